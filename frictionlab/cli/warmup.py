"""`frictionlab warmup`: what a machine has to compile once, before the lesson."""

from __future__ import annotations

import argparse
import time
from typing import Any

from .parsing import EXIT_FAILED, OneLineParser, add_command, add_json, print_json

WARMUP_DESCRIPTION = """\
Compile what has to be compiled once on a machine, and run a second of the
slider, so that the first run of a lesson starts at once."""


def add_warmup(commands: Any) -> OneLineParser:
    """Add the command `warmup`; returns its parser."""
    epilog = "exit status: 0 ready; 1 the run ended early; 2 bad arguments."
    parser = add_command(
        commands, "warmup", "compile the solver before the lesson", WARMUP_DESCRIPTION, epilog
    )
    add_json(parser)
    return parser


def warmup_command(args: argparse.Namespace, parser: OneLineParser) -> int:
    """Compile, and simulate one second of the slider twice; returns the exit status."""
    import frictionlab as fl
    from frictionlab.compilation import machine_code

    with fl.progress(not args.json):
        seconds = []
        for _ in range(2):
            begin = time.perf_counter()
            run = fl.simulate(fl.SliderOnBelt(mu_k=1.4), 1.0)
            seconds.append(time.perf_counter() - begin)
    if machine_code.LOADED is not None:
        kind = "compiled ahead of time"
    else:
        kind = "compiled by numba" if machine_code.NUMBA is not None else "plain Python"
    if args.json:
        print_json({"solver": kind, "first_run": seconds[0], "second_run": seconds[1]})
    else:
        first, second = seconds
        print(f"Ready. The solver is {kind}; the first run took {first:.3g} s, the next {second:.3g} s.")
    return 0 if run.status.ok else EXIT_FAILED
