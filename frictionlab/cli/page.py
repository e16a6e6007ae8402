"""`frictionlab page`: a model as one HTML file, to be tried in any browser."""

from __future__ import annotations

import argparse
from typing import Any

from .parsing import (
    OneLineParser,
    add_command,
    add_json,
    add_model_options,
    complain,
    model_data,
    model_from_options,
    print_json,
)

EXIT_FAILED = 1

PAGE_DESCRIPTION = """\
Write a model as one HTML file with sliders, switches and the exact solver in
it. The file needs neither a server nor a network."""

PAGE_EPILOG = """\
examples:
  frictionlab page -o slider.html
  frictionlab page --model DenHartog -o den-hartog.html --slider F Omega N

exit status: 0 written; 1 it could not be written; 2 bad arguments."""


def add_page(commands: Any) -> OneLineParser:
    """Add the command `page`; returns its parser."""
    parser = add_command(
        commands,
        "page",
        "write a model as one HTML file with the exact solver in it",
        PAGE_DESCRIPTION,
        PAGE_EPILOG,
    )
    parser.add_argument("-o", "--output", metavar="FILE", default="slider.html", help="default: slider.html")
    add_model_options(parser)
    parser.add_argument("--slider", nargs="+", metavar="NAME", help="sliders shown at first")
    parser.add_argument("--t-end", type=float, metavar="S", help="end time (default: some 300 periods)")
    add_json(parser)
    return parser


def page_command(chosen: argparse.Namespace, parser: OneLineParser) -> int:
    """Write the page; returns the exit status."""
    import frictionlab as fl
    from frictionlab.pages.export import SolverNotBuiltError

    try:
        model = model_from_options(chosen)
        path = fl.export_page(model, chosen.output, sliders=chosen.slider, t_end=chosen.t_end)
    except SolverNotBuiltError as error:
        complain(parser.prog, f"error: {error}")
        return EXIT_FAILED
    except (ValueError, TypeError) as error:
        parser.error(str(error))
    print_json({**model_data(model), "file": path}) if chosen.json else print(f"wrote {path}")
    return 0
