"""Commands that compute the paper's results: `frictionlab figure` and `frictionlab reproduce`."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from frictionlab.cli import parsing
from frictionlab.cli.parsing import (
    EXIT_FAILED,
    OneLineParser,
    add_command,
    add_json,
    add_sweep_options,
    check_workers,
    complain,
    print_json,
)

FIGURE_DESCRIPTION = """\
Compute a figure of the paper (Liu & Ouyang 2020), print its numbers and draw
it."""

FIGURE_EPILOG = """\
examples:
  frictionlab figure 2                 (writes fig2.png)
  frictionlab figure 6 -o pairs.pdf
  frictionlab figure 9 --algorithm paper -o fig9.png
  frictionlab figure 12 --impact full --quick

exit status: 0 the picture was written; 1 it could not be; 2 bad arguments;
130 stopped by ctrl-C."""

DEFAULT_FOLDER = "docs"

REPRODUCE_DESCRIPTION = """\
Check every claim of the paper (Liu & Ouyang 2020) by the exact solver, with both
impact laws, and by the paper's algorithm; draw every figure; write
reproduction.md with the pictures beside it."""

REPRODUCE_EPILOG = """\
examples:
  frictionlab reproduce                          (docs/reproduction.md)
  frictionlab reproduce --quick -o check         (a few minutes, coarser grids)
  frictionlab reproduce --resume sweeps          (goes on after ctrl-C)

exit status: 0 the page was written; 1 it could not be; 2 bad arguments;
130 stopped by ctrl-C (with --resume, what was computed is kept)."""


def add_figure(commands: Any) -> OneLineParser:
    """Add the command `figure`; returns its parser."""
    parser = add_command(
        commands, "figure", "compute and draw a figure of the paper", FIGURE_DESCRIPTION, FIGURE_EPILOG
    )
    parser.add_argument("number", type=int, metavar="N", help="the paper's number: 2 to 18")
    parser.add_argument(
        "-o", "--output", metavar="FILE", help="picture, e.g. fig2.png or .pdf (default: figN.png)"
    )
    _add_figure_options(
        parser.add_argument_group("figures 7 to 18, which are of steady states and take minutes")
    )
    add_json(parser)
    parser.set_defaults(save=None)
    return parser


def _add_figure_options(group: Any) -> None:
    group.add_argument(
        "--algorithm",
        default="exact",
        metavar="NAME",
        help="exact, or paper: fixed steps of 0.0002 s (default: exact)",
    )
    group.add_argument(
        "--impact",
        default="paper",
        metavar="LAW",
        help="paper: Eq. 13 as printed; full: the gap's full rate; not for 13 and 14 (default: paper)",
    )
    group.add_argument("--quick", action="store_true", help="a coarser grid")
    add_sweep_options(group)


def figure_command(args: argparse.Namespace, parser: OneLineParser) -> int:
    """Check, compute, print and draw; returns the exit status."""
    from frictionlab.paper import figure
    from frictionlab.paper.results import check_figure

    args.output = f"fig{args.number}.png" if args.output is None else args.output
    try:
        options = _figure_options(args)
        check_figure(args.number, options["algorithm"], options["impact"])
        check_workers(args.workers)
        parsing.check_files(args)
    except ValueError as error:
        parser.error(str(error))
    try:
        result = figure(args.number, **options)
    except ValueError as error:  # a file in --resume that is damaged, or of another sweep
        complain(parser.prog, f"error: {error}")
        return EXIT_FAILED
    if not args.json:
        print(result, flush=True)
    return _write_picture(result, args)


def _figure_options(args: argparse.Namespace) -> dict[str, Any]:
    impact = {"full": "full gap rate"}.get(args.impact, args.impact)
    names = "algorithm", "quick", "workers", "resume"
    return {name: getattr(args, name) for name in names} | {"impact": impact}


def _write_picture(result: Any, args: argparse.Namespace) -> int:
    path = args.output
    result.plot().savefig(path)
    if args.json:
        about = {name: getattr(result, name) for name in ("number", "how", "caption", "summary")}
        print_json({**about, "file": path})
    else:
        print(f"Picture in {path}")
    return 0


def add_reproduce(commands: Any) -> OneLineParser:
    """Add the command `reproduce`; returns its parser."""
    parser = add_command(
        commands,
        "reproduce",
        "check every claim of the paper and draw every figure",
        REPRODUCE_DESCRIPTION,
        REPRODUCE_EPILOG,
    )
    parser.add_argument(
        "-o",
        "--output",
        default=DEFAULT_FOLDER,
        metavar="FOLDER",
        help=f"takes the page (default: {DEFAULT_FOLDER})",
    )
    parser.add_argument("--quick", action="store_true", help="coarser grids: a quarter of the time")
    parser.add_argument("-q", "--quiet", action="store_true", help="no progress bar")
    add_json(parser)
    add_sweep_options(parser)
    return parser


def reproduce_command(args: argparse.Namespace, parser: OneLineParser) -> int:
    """Check, compute and write; returns the exit status."""
    from frictionlab.paper.report import reproduce
    from frictionlab.paper.scenes import Setting

    try:
        check_workers(args.workers)
        for option, path in (("-o", args.output), ("--resume", args.resume)):
            _check_folder(option, path)
    except ValueError as error:
        parser.error(str(error))
    resume = None if args.resume is None else Path(args.resume)
    options = {"quick": args.quick, "workers": args.workers, "progress": not args.quiet}
    try:
        page = reproduce(args.output, Setting(**options, resume=resume))
    except ValueError as error:  # a file in --resume that is damaged
        complain(parser.prog, f"error: {error}")
        return EXIT_FAILED
    print_json({"page": page}) if args.json else print(f"Page in {page}")
    return 0


def _check_folder(option: str, path: str | None) -> None:
    if path is not None and Path(path).exists() and not Path(path).is_dir():
        raise ValueError(f"{option} must be a folder, {path!r} is a file: give another")
