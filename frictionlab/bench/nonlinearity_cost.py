"""The cost of each nonlinearity, and the costs that arise once.

The eight scenes with and without nonlinearities: size of the tape and wall time; their first call in a
fresh process; native code for each mode, compiled and loaded.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from itertools import compress, product
from statistics import median
from typing import Any

from frictionlab.analysis.simulate import simulate
from frictionlab.hybrid import compilation
from frictionlab.hybrid.codegen.native_cache import NativeCode
from frictionlab.hybrid.methods.taylor import Taylor
from frictionlab.hybrid.tape.packing import program_of
from frictionlab.hybrid.tape.program import Program
from frictionlab.presentation import markdown_table

from .harness import interleaved_medians, warm_up
from .scenes import FULL_GAP_RATE_SLIDER

NONLINEARITIES = ("cubic", "nonsmooth", "geometry")
COMBINATIONS = tuple(tuple(compress(NONLINEARITIES, choice)) for choice in product((0, 1), repeat=3))

FRESH_PROCESS = """\
import time
begin = time.perf_counter()
import frictionlab as fl
imported = time.perf_counter()
model = fl.SliderOnBelt(mu_k=1.4, impact=fl.PlasticImpact("full")).without(*{without})
fl.simulate(model, 1.0, progress=False)
print(imported - begin, time.perf_counter() - imported)
"""


@dataclass(frozen=True)
class NonlinearityCost:
    """One of the eight scenes: the nonlinearities left out, and its costs; operations summed over modes."""

    without: tuple[str, ...]
    states: int
    modes: int
    guards: int
    products: int
    operations: int
    nanoseconds: float  # wall time per simulated second


def nonlinearity_costs(t_end: float = 20.0, repeats: int = 5) -> list[NonlinearityCost]:
    """The eight scenes with nonlinearities left out: size of the tape, and wall time."""
    models = [FULL_GAP_RATE_SLIDER.without(*names) for names in COMBINATIONS]
    for model in models:
        warm_up(model.automaton(), Taylor())
    runs = [partial(simulate, model, t_end, progress=False) for model in models]
    seconds = interleaved_medians(runs, repeats)
    return [_cost_of(n, m, s / t_end) for n, m, s in zip(COMBINATIONS, models, seconds, strict=True)]


def _cost_of(left_out: tuple[str, ...], model: Any, seconds: float) -> NonlinearityCost:
    cost = program_of(model.automaton())[0].cost()
    products = sum(mode["product"] + mode["square"] + mode["quotient"] for mode in cost.values())
    operations = products + sum(mode["affine"] for mode in cost.values())
    guards, states = sum(mode["guards"] for mode in cost.values()), next(iter(cost.values()))["states"]
    return NonlinearityCost(left_out, states, len(cost), guards, products, operations, 1e9 * seconds)


def nonlinearity_table(rows: Sequence[NonlinearityCost], first: Sequence[float], imported: float) -> str:
    """The eight scenes as Markdown, with the time of their first call and of the import, in s."""
    head = "without | states | modes | guards | products | operations | ns per simulated second | first call"
    lines = [
        f"{', '.join(row.without) or '-'} | {row.states} | {row.modes} | {row.guards} | {row.products} "
        f"| {row.operations} | {float(f'{row.nanoseconds:.3g}'):,.0f} | {seconds:.2f} s"
        for row, seconds in zip(rows, first, strict=True)
    ]
    return markdown_table(head, [*lines, f"`import frictionlab` | | | | | | | {imported:.3f} s"])


@dataclass(frozen=True)
class StartTimes:
    """Fresh processes, warm caches: `import frictionlab`, then each scene's first simulated second, in s."""

    imported: float
    first: tuple[float, ...]


@dataclass(frozen=True)
class NativeCodeTime:
    """A mode's machine code: compiling it, and loading it from the cache in a later process, in s."""

    mode: str
    operations: int
    compiled: float
    loaded: float


def starts(repeats: int = 3) -> StartTimes:
    """The eight scenes of the switches, each in processes of its own; medians."""
    for without in COMBINATIONS:
        _time_fresh_process(without)  # warms the caches
    spent = [[_time_fresh_process(without) for without in COMBINATIONS] for _ in range(repeats)]
    imported = median(seconds for turn in spent for seconds, _ in turn)
    return StartTimes(
        imported, tuple(median(first for _, first in scene) for scene in zip(*spent, strict=True))
    )


def _time_fresh_process(without: tuple[str, ...]) -> tuple[float, float]:
    command = [sys.executable, "-c", FRESH_PROCESS.format(without=without)]
    printed = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    imported, first = map(float, printed.split())
    return imported, first


def native_code_times(repeats: int = 3) -> list[NativeCodeTime]:
    """Every mode of scene B, compiled into an empty cache and loaded from it; none without numba."""
    if not compilation.HAS_MACHINE_CODE:
        return []
    program = program_of(FULL_GAP_RATE_SLIDER.automaton())[0]
    _time_native_code(program, 0)  # LLVM itself is loaded here
    modes = range(len(program.modes))
    spent = [[_time_native_code(program, mode) for mode in modes] for _ in range(repeats)]
    columns = (zip(*column, strict=True) for column in zip(*spent, strict=True))
    rows = zip(program.modes, program.tapes, columns, strict=True)
    return [NativeCodeTime(name, len(tape.ops), *map(median, times)) for name, tape, times in rows]


def _time_native_code(program: Program, mode: int) -> tuple[float, float]:
    with _empty_cache():
        jets = NativeCode(program)
        begin = time.perf_counter()
        jets.compile(mode)
        done = time.perf_counter()
        NativeCode(program)  # finds the mode that is there
        return done - begin, time.perf_counter() - done


@contextmanager
def _empty_cache() -> Iterator[None]:
    before = compilation.CACHE_FOLDER
    with tempfile.TemporaryDirectory() as folder:
        compilation.CACHE_FOLDER = folder
        try:
            yield
        finally:
            compilation.CACHE_FOLDER = before


def native_table(rows: Sequence[NativeCodeTime]) -> str:
    """The modes as Markdown."""
    lines = (f"{r.mode} | {r.operations} | {1e3 * r.compiled:.0f} ms | {1e3 * r.loaded:.1f} ms" for r in rows)
    return markdown_table("mode of scene B | operations | compiled | from the cache", lines)
