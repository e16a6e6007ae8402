"""`frictionlab figure`: a figure of the paper, computed, described and drawn."""

from __future__ import annotations

import argparse
import sys
from typing import Any

from . import choices
from .parser import OneLineParser

EARLY = 1

DESCRIPTION = """\
Compute a figure of the paper (Liu & Ouyang 2020), print its numbers and draw
it."""

EPILOG = """\
examples:
  frictionlab figure 2                 (writes fig2.png)
  frictionlab figure 6 -o pairs.pdf
  frictionlab figure 9 --algorithm paper -o fig9.png
  frictionlab figure 12 --impact full --quick

exit status: 0 the picture was written; 1 it could not be; 2 bad arguments;
130 stopped by ctrl-C."""


def add_figure(commands: Any) -> OneLineParser:
    """Add the command `figure`; returns its parser."""
    parser = commands.add_parser(
        "figure",
        help="compute and draw a figure of the paper",
        description=DESCRIPTION,
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.add_argument("number", type=int, metavar="N", help="the paper's number: 2 to 18")
    parser.add_argument(
        "-o", "--output", metavar="FILE", help="picture, e.g. fig2.png or .pdf (default: figN.png)"
    )
    _add_choices(parser.add_argument_group("figures 7 to 18, which are of steady states and take minutes"))
    parser.set_defaults(save=None)
    return parser


def _add_choices(group: Any) -> None:
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


def add_sweep_options(group: Any) -> None:
    """Workers and resuming, of commands that run sweeps."""
    group.add_argument("--workers", type=int, metavar="N", help="threads (default: one for each processor)")
    group.add_argument(
        "--resume", metavar="FOLDER", help="keep sweeps there as they come, and go on with those found there"
    )


def check_workers(workers: int | None) -> None:
    """Raise for less than one."""
    from frictionlab.hybrid.validation import check_number

    if workers is not None:
        check_number("--workers", workers, integer=True, least=1, cure="leave it out for one each processor")


def figure_command(chosen: argparse.Namespace, parser: OneLineParser) -> int:
    """Check, compute, print and draw; returns the exit status."""
    from frictionlab.paper import figure
    from frictionlab.paper.registry import check_figure

    chosen.output = f"fig{chosen.number}.png" if chosen.output is None else chosen.output
    try:
        options = _options(chosen)
        check_figure(chosen.number, options["algorithm"], options["impact"])
        check_workers(chosen.workers)
        choices.check_files(chosen)
    except ValueError as error:
        parser.error(str(error))
    result = figure(chosen.number, **options)
    print(result, flush=True)
    return _written(result, chosen.output, parser)


def _options(chosen: argparse.Namespace) -> dict[str, Any]:
    impact = {"full": "full gap rate"}.get(chosen.impact, chosen.impact)
    names = "algorithm", "quick", "workers", "resume"
    return {name: getattr(chosen, name) for name in names} | {"impact": impact}


def _written(result: Any, path: str, parser: OneLineParser) -> int:
    try:
        result.plot().savefig(path)
    except OSError as error:  # a full disk, or a folder that has gone since the check
        sys.stderr.write(f"{parser.prog}: error: {error}\n")
        return EARLY
    print(f"Picture in {path}")
    return 0
