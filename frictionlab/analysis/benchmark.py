"""`frictionlab bench`: run time and error of the methods in one run, as ratios.

The scene is mu_k = 1.4 from rest with the moving load and the full gap rate in the impact law: stick,
slip, separation and 886 events in 20 s.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import compress, product
from statistics import median
from typing import Any

import numpy as np

from frictionlab.analysis.simulate import simulate
from frictionlab.components import PlasticImpact
from frictionlab.hybrid.methods import Method
from frictionlab.hybrid.program import program_of
from frictionlab.hybrid.rk4 import RK4
from frictionlab.hybrid.scipy_methods import Scipy
from frictionlab.hybrid.taylor import Taylor
from frictionlab.models import SliderOnBelt

SCENE = SliderOnBelt(mu_k=1.4, impact=PlasticImpact(gap_rate="full"))
# The state of SCENE at 20 s from rest, by tests/reference/slider_mpmath.py with 40 digits.
REFERENCE = (
    -0.01563171764918776,
    -0.024517895028636476,
    0.012009167802481643,
    -0.008104117695891856,
    -0.010657612762793766,
    0.01877919440799427,
    -2.599060934608227,
    -0.8632722791610545,
    0.43483137365689173,
    -0.011811320566702371,
)
METHODS: tuple[tuple[str, Method], ...] = (
    ("Taylor, tol 1e-15", Taylor(tol=1e-15)),
    ("Taylor, tol 1e-8", Taylor(tol=1e-8)),
    ("RK4, step 1e-4 s", RK4(step=1e-4)),
    ("RK4, step 2e-4 s", RK4(step=2e-4)),
    ("DOP853, rtol 1e-10", Scipy("DOP853")),
)
SWITCHES = ("cubic", "nonsmooth", "geometry")


@dataclass(frozen=True)
class Row:
    """A method: wall time of a run in s, largest error of a state at 20 s, events and steps in 20 s."""

    name: str
    seconds: float
    error: float
    events: int
    steps: int


@dataclass(frozen=True)
class Switches:
    """A scene of the eight: what is left out, and what the rest costs; operations summed over modes."""

    without: tuple[str, ...]
    states: int
    modes: int
    guards: int
    products: int
    operations: int
    microseconds: float  # wall time per simulated second


def methods(
    t_end: float = 200.0, repeats: int = 3, among: Sequence[tuple[str, Method]] = METHODS
) -> list[Row]:
    """Time and error of each method on SCENE; the runs are interleaved, the median is taken.

    scipy's methods are timed over a twentieth of `t_end` and scaled up.
    """
    shares = [20.0 if isinstance(method, Scipy) else 1.0 for _, method in among]
    timed = [(method, t_end / share) for (_, method), share in zip(among, shares, strict=True)]
    seconds = interleaved([partial(_run, *arguments) for arguments in timed], repeats)
    return [
        _row(name, method, spent * share)
        for (name, method), spent, share in zip(among, seconds, shares, strict=True)
    ]


def switches(t_end: float = 20.0, repeats: int = 5) -> list[Switches]:
    """The eight scenes with nonlinearities left out: size of the tape, and wall time."""
    left_out = [tuple(compress(SWITCHES, choice)) for choice in product((0, 1), repeat=3)]
    models = [SCENE.without(*names) for names in left_out]
    runs = [partial(simulate, model, t_end, progress=False) for model in models]
    seconds = interleaved(runs, repeats)
    return [_size(n, m, s / t_end) for n, m, s in zip(left_out, models, seconds, strict=True)]


def interleaved(runs: Sequence[Callable[[], Any]], repeats: int) -> list[float]:
    """Median wall time of each, after one run to warm up; in turns, so that a slow moment hits all."""
    for run in runs:
        run()
    spent = [[_timed(run) for run in runs] for _ in range(repeats)]
    return [median(column) for column in zip(*spent, strict=True)]


def _timed(run: Callable[[], Any]) -> float:
    begin = time.perf_counter()
    run()
    return time.perf_counter() - begin


def _run(method: Method, t_end: float) -> Any:
    return simulate(SCENE, t_end, method=method, progress=False)


def _row(name: str, method: Method, seconds: float) -> Row:
    run = _run(method, 20.0)
    error = float(np.abs(run.final_state - np.array(REFERENCE)).max())
    return Row(name, seconds, error, len(run.events), len(run.raw.step_modes))


def _size(left_out: tuple[str, ...], model: Any, seconds: float) -> Switches:
    cost = program_of(model.automaton())[0].cost()
    products = sum(mode["product"] + mode["square"] + mode["quotient"] for mode in cost.values())
    operations = products + sum(mode["affine"] for mode in cost.values())
    guards, states = sum(mode["guards"] for mode in cost.values()), next(iter(cost.values()))["states"]
    return Switches(left_out, states, len(cost), guards, products, operations, 1e6 * seconds)


def table(rows: Sequence[Row], against: str = METHODS[0][0]) -> str:
    """The methods as Markdown; times and errors also as multiples of `against`."""
    base = next(row for row in rows if row.name == against)
    head = "method | wall time | x | error at 20 s | x | events | steps in 20 s"
    lines = (
        f"{row.name} | {row.seconds:.3g} s | {row.seconds / base.seconds:.1f} | {row.error:.1e} "
        f"| {row.error / base.error:.1e} | {row.events} | {row.steps}"
        for row in rows
    )
    return markdown(head, lines)


def switch_table(rows: Sequence[Switches]) -> str:
    """The eight scenes as Markdown."""
    head = "without | states | modes | guards | products | operations | per simulated second"
    lines = (
        f"{', '.join(row.without) or '-'} | {row.states} | {row.modes} | {row.guards} | {row.products} "
        f"| {row.operations} | {row.microseconds:.0f} us"
        for row in rows
    )
    return markdown(head, lines)


def markdown(head: str, lines: Iterable[str]) -> str:
    """A table."""
    rule = "|".join("---" for _ in head.split("|"))
    return "\n".join([f"| {head} |", f"|{rule}|", *(f"| {line} |" for line in lines)])
