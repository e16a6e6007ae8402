"""`frictionlab reproduce`: every claim and every figure of the paper, as a page."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from .figure import add_sweep_options, check_workers
from .parser import OneLineParser

EARLY = 1
FOLDER = "docs"

DESCRIPTION = """\
Check every claim of the paper (Liu & Ouyang 2020) by the exact solver, with both
impact laws, and by the paper's algorithm; draw every figure; write
reproduction.md with the pictures beside it."""

EPILOG = """\
examples:
  frictionlab reproduce                          (docs/reproduction.md)
  frictionlab reproduce --quick -o check         (a few minutes, coarser grids)
  frictionlab reproduce --resume sweeps          (goes on after ctrl-C)

exit status: 0 the page was written; 1 it could not be; 2 bad arguments;
130 stopped by ctrl-C (with --resume, what was computed is kept)."""


def add_reproduce(commands: Any) -> OneLineParser:
    """Add the command `reproduce`; returns its parser."""
    parser = commands.add_parser(
        "reproduce",
        help="check every claim of the paper and draw every figure",
        description=DESCRIPTION,
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.add_argument(
        "-o", "--output", default=FOLDER, metavar="FOLDER", help=f"takes the page (default: {FOLDER})"
    )
    parser.add_argument("--quick", action="store_true", help="coarser grids: a quarter of the time")
    parser.add_argument("-q", "--quiet", action="store_true", help="no progress bar")
    add_sweep_options(parser)
    return parser


def reproduce_command(chosen: argparse.Namespace, parser: OneLineParser) -> int:
    """Check, compute and write; returns the exit status."""
    from frictionlab.paper.reproduction import reproduce
    from frictionlab.paper.setting import Setting

    try:
        check_workers(chosen.workers)
        for option, path in (("-o", chosen.output), ("--resume", chosen.resume)):
            _check_folder(option, path)
    except ValueError as error:
        parser.error(str(error))
    resume = None if chosen.resume is None else Path(chosen.resume)
    options = {"quick": chosen.quick, "workers": chosen.workers, "progress": not chosen.quiet}
    try:
        page = reproduce(chosen.output, Setting(**options, resume=resume))
    except OSError as error:
        sys.stderr.write(f"{parser.prog}: error: {error}\n")
        return EARLY
    print(f"Page in {page}")
    return 0


def _check_folder(option: str, path: str | None) -> None:
    if path is not None and Path(path).exists() and not Path(path).is_dir():
        raise ValueError(f"{option} must be a folder, {path!r} is a file: give another")
