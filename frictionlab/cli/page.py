"""`frictionlab page`: a model as one HTML file, to be tried in any browser."""

from __future__ import annotations

import argparse
from dataclasses import asdict
from typing import Any

from .parsing import (
    EXIT_FAILED,
    OneLineParser,
    add_command,
    add_json,
    add_model_options,
    complain,
    model_data,
    model_from_options,
    print_json,
)

OF_ONE_MODEL = {
    "output": "-o",
    "model": "--model",
    "values": "--set",
    "without": "--without",
    "slider": "--slider",
    "t_end": "--t-end",
}

PAGE_DESCRIPTION = """\
Write a model as one HTML file with sliders, switches and the exact solver in
it. The file needs neither a server nor a network. With --all, a folder of
such files, one for each model of the library, and an index of them; what is
there already is kept, so that an export that was stopped goes on."""

PAGE_EPILOG = """\
examples:
  frictionlab page -o slider.html
  frictionlab page --model DenHartog -o den-hartog.html --slider F Omega N
  frictionlab page --all pages

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
    parser.add_argument("-o", "--output", metavar="FILE", help="default: slider.html")
    parser.add_argument("--all", metavar="FOLDER", help="pages of all models, and an index of them")
    add_model_options(parser)
    parser.add_argument("--slider", nargs="+", metavar="NAME", help="sliders shown at first")
    parser.add_argument(
        "--t-end", type=float, metavar="S", help="end time (default: 200 periods, fewer for a stiff model)"
    )
    add_json(parser)
    return parser


def page_command(args: argparse.Namespace, parser: OneLineParser) -> int:
    """Write the page; returns the exit status."""
    import frictionlab as fl
    from frictionlab.pages.export import SolverNotBuiltError

    try:
        if args.all is not None:
            return _all_pages(args, parser)
        model, output = model_from_options(args), args.output or "slider.html"
        path = fl.export_page(model, output, sliders=args.slider, t_end=args.t_end)
    except SolverNotBuiltError as error:
        complain(parser.prog, f"error: {error}")
        return EXIT_FAILED
    except (ValueError, TypeError) as error:
        parser.error(str(error))
    print_json({**model_data(model), "file": path}) if args.json else print(f"wrote {path}")
    return 0


def _all_pages(args: argparse.Namespace, parser: OneLineParser) -> int:
    from frictionlab.pages.gallery import export_gallery

    for name, option in OF_ONE_MODEL.items():
        if getattr(args, name) != parser.get_default(name):
            raise ValueError(f"--all must have no {option}, got both: leave out one of them")
    gallery = export_gallery(args.all)
    if args.json:
        print_json(asdict(gallery))
        return 0
    there = f", {len(gallery.present)} were there" if gallery.present else ""
    print(f"wrote {len(gallery.written)} pages{there}: open {gallery.index}")
    for name, reason in gallery.refused.items():
        print(f"no page of {name}: {reason}")
    return 0
