"""What each nonlinearity costs: the eight scenes with and without, size of the tape and wall time."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import compress, product
from statistics import median
from typing import Any

from frictionlab.analysis.markdown import markdown
from frictionlab.analysis.simulate import simulate
from frictionlab.components import PlasticImpact
from frictionlab.hybrid.program import program_of
from frictionlab.hybrid.taylor import Taylor
from frictionlab.models import SliderOnBelt

from .ready import make_ready

SCENE = SliderOnBelt(mu_k=1.4, impact=PlasticImpact(gap_rate="full"))
SWITCHES = ("cubic", "nonsmooth", "geometry")
LEFT_OUT = tuple(tuple(compress(SWITCHES, choice)) for choice in product((0, 1), repeat=3))


@dataclass(frozen=True)
class Switches:
    """A scene of the eight: what is left out, and what the rest costs; operations summed over modes."""

    without: tuple[str, ...]
    states: int
    modes: int
    guards: int
    products: int
    operations: int
    nanoseconds: float  # wall time per simulated second


def switches(t_end: float = 20.0, repeats: int = 5) -> list[Switches]:
    """The eight scenes with nonlinearities left out: size of the tape, and wall time."""
    models = [SCENE.without(*names) for names in LEFT_OUT]
    for model in models:
        make_ready(model.automaton(), Taylor())
    runs = [partial(simulate, model, t_end, progress=False) for model in models]
    seconds = interleaved(runs, repeats)
    return [_size(n, m, s / t_end) for n, m, s in zip(LEFT_OUT, models, seconds, strict=True)]


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


def _size(left_out: tuple[str, ...], model: Any, seconds: float) -> Switches:
    cost = program_of(model.automaton())[0].cost()
    products = sum(mode["product"] + mode["square"] + mode["quotient"] for mode in cost.values())
    operations = products + sum(mode["affine"] for mode in cost.values())
    guards, states = sum(mode["guards"] for mode in cost.values()), next(iter(cost.values()))["states"]
    return Switches(left_out, states, len(cost), guards, products, operations, 1e9 * seconds)


def switch_table(rows: Sequence[Switches], first: Sequence[float], imported: float) -> str:
    """The eight scenes as Markdown, with the time of their first call and of the import, in s."""
    head = "without | states | modes | guards | products | operations | ns per simulated second | first call"
    lines = [
        f"{', '.join(row.without) or '-'} | {row.states} | {row.modes} | {row.guards} | {row.products} "
        f"| {row.operations} | {float(f'{row.nanoseconds:.3g}'):,.0f} | {seconds:.2f} s"
        for row, seconds in zip(rows, first, strict=True)
    ]
    return markdown(head, [*lines, f"`import frictionlab` | | | | | | | {imported:.3f} s"])
