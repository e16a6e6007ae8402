"""`frictionlab run`: check, simulate, summarise, draw, save."""

from __future__ import annotations

import argparse
import sys
from typing import Any

from . import choices, summary
from .parser import OneLineParser

EARLY, INTERRUPTED = 1, 130


def run_command(chosen: argparse.Namespace, parser: OneLineParser) -> int:
    """Do what the options say; returns the exit status."""
    try:
        model, options = _checked(chosen)
    except (ValueError, TypeError) as error:
        parser.error(str(error))
    print(summary.before(model, options["method"], chosen), flush=True)
    run = _simulated(model, chosen, options, parser)
    print(summary.after(run), flush=True)
    written = _written(run, chosen, parser)
    return _code(run) or written


def _checked(chosen: argparse.Namespace) -> tuple[Any, dict[str, Any]]:
    from frictionlab.hybrid.validation import check_number

    check_number("--t-end", chosen.t_end, above=0.0, cure="give the length of the run in seconds")
    choices.check_files(chosen)
    model = choices.model_of(chosen)
    return model, {"method": choices.method_of(chosen), "x0": choices.start_of(chosen, model)}


def _simulated(model: Any, chosen: argparse.Namespace, options: dict[str, Any], parser: OneLineParser) -> Any:
    from frictionlab.analysis.simulate import simulate

    try:
        return simulate(model, chosen.t_end, progress=not chosen.quiet, **options)
    except ValueError as error:
        parser.error(str(error))


def _written(run: Any, chosen: argparse.Namespace, parser: OneLineParser) -> int:
    try:
        if chosen.save is not None:
            print(f"Saved as {run.save(chosen.save)}")
        if chosen.output is not None:
            from frictionlab.plotting import plot_run

            plot_run(run).savefig(chosen.output)
            print(f"Picture in {chosen.output}")
    except OSError as error:  # a full disk, or a folder that has gone since the check
        sys.stderr.write(f"{parser.prog}: error: {error}\n")
        return EARLY
    return 0


def _code(run: Any) -> int:
    if run.status.ok:
        return 0
    return INTERRUPTED if run.status.name == "INTERRUPTED" else EARLY
