"""`frictionlab bench`: the tables of docs/performance.md, measured now."""

from __future__ import annotations

import argparse
from typing import Any

from .parser import OneLineParser

DESCRIPTION = """\
Measure run time and error of the methods on one scene (mu_k = 1.4 from rest, moving load, full gap rate
in the impact law; 886 events in 20 s), and what each nonlinearity costs. Times are medians of interleaved
runs on this machine, errors are against a reference of 40 digits. Prints Markdown."""


def add_bench(commands: Any) -> OneLineParser:
    """Add the command `bench`; returns its parser."""
    parser = commands.add_parser(
        "bench", help="measure run time and error of the methods", description=DESCRIPTION
    )
    parser.add_argument("--quick", action="store_true", help="a tenth of the time: 20 s runs, one repetition")
    return parser


def bench_command(chosen: argparse.Namespace, parser: OneLineParser) -> int:
    """Measure and print; returns the exit status."""
    from frictionlab.analysis import benchmark, benchmark_stability

    t_end, repeats = (20.0, 1) if chosen.quick else (200.0, 3)
    print(f"Methods, wall time of {t_end:g} s of motion\n")
    print(benchmark.table(benchmark.methods(t_end, repeats)), flush=True)
    print("\nScenes, wall time per simulated second\n")
    print(benchmark.switch_table(benchmark.switches(repeats=repeats)))
    print("\nLinear stability\n")
    print(benchmark_stability.table(benchmark_stability.eigenproblems(10_000, repeats)))
    return 0
