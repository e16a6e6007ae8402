"""`frictionlab figure`: a figure of the paper, computed, described and drawn."""

from __future__ import annotations

import argparse
import sys
from typing import Any

from . import choices
from .parser import OneLineParser

EARLY = 1

DESCRIPTION = """\
Compute a figure of the paper (Liu & Ouyang 2020), print its numbers and draw it."""

EPILOG = """\
examples:
  frictionlab figure 2                 (writes fig2.png)
  frictionlab figure 6 -o pairs.pdf

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
    parser.add_argument("number", type=int, metavar="N", help="the paper's number: 2 to 6")
    parser.add_argument(
        "-o", "--output", metavar="FILE", help="picture, e.g. fig2.png or .pdf (default: figN.png)"
    )
    parser.set_defaults(save=None)
    return parser


def figure_command(chosen: argparse.Namespace, parser: OneLineParser) -> int:
    """Check, compute, print and draw; returns the exit status."""
    from frictionlab.paper import figure
    from frictionlab.paper.registry import check_number

    chosen.output = f"fig{chosen.number}.png" if chosen.output is None else chosen.output
    try:
        check_number(chosen.number)
        choices.check_files(chosen)
    except ValueError as error:
        parser.error(str(error))
    result = figure(chosen.number)
    print(result, flush=True)
    return _written(result, chosen.output, parser)


def _written(result: Any, path: str, parser: OneLineParser) -> int:
    try:
        result.plot().savefig(path)
    except OSError as error:  # a full disk, or a folder that has gone since the check
        sys.stderr.write(f"{parser.prog}: error: {error}\n")
        return EARLY
    print(f"Picture in {path}")
    return 0
