"""Work against precision: scenes x methods, timed in turns, errors against references.

Whatever is compiled is compiled before anything is timed: kernels, and native code of all modes, as a
long run has it. Times are medians of runs that are interleaved, so that a slow moment affects all.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from importlib.util import find_spec
from statistics import median
from typing import Any

import numpy as np

from frictionlab.automaton import HybridAutomaton
from frictionlab.bench.peers.external import ExternalMethod
from frictionlab.bench.peers.methods import METHODS, BenchMethod
from frictionlab.hybrid.codegen.native_cache import native_code
from frictionlab.hybrid.compilation import HAS_MACHINE_CODE
from frictionlab.hybrid.methods.base import Method
from frictionlab.hybrid.methods.taylor import Taylor
from frictionlab.hybrid.problem import Status
from frictionlab.hybrid.solve import solve
from frictionlab.hybrid.tape.packing import program_of
from frictionlab.presentation import markdown_table

from .peers import methods
from .scenes import BenchScene

BASE_METHOD = "frictionlab, tol 1e-15"
SINGLE_RUN_ABOVE = 3.0  # s: a run longer than this is timed once
WARM_RUN_BELOW = (
    0.1  # s: a shorter one would be slowed down by what ran before it, which leaves the caches cold
)


def warm_up(automaton: HybridAutomaton, method: Method) -> None:
    """Compile what is missing, so that no mode is native code in one run and interpreted in the next."""
    solve(automaton, 1e-9, x0=np.zeros(len(automaton.states)), method=method, progress=False)
    if not isinstance(method, Taylor):
        return
    jets = native_code(program_of(automaton)[0])
    for mode in np.flatnonzero(jets.code.native == 0) if HAS_MACHINE_CODE else ():
        jets.compile(int(mode))


def warm_up_lanes(automaton: HybridAutomaton, method: Taylor) -> None:
    """The same for the steps of several runs side by side."""
    native = native_code(program_of(automaton)[0])
    for mode in np.flatnonzero(native.code.lanes == 0) if HAS_MACHINE_CODE else ():
        native.compile_step(int(mode))


def interleaved_medians(runs: Sequence[Callable[[], Any]], repeats: int) -> list[float]:
    """Median wall time of each, after one run to warm up; in turns, so that a slow moment affects all."""
    for run in runs:
        run()
    spent = [[_time_call(run) for run in runs] for _ in range(repeats)]
    return [median(column) for column in zip(*spent, strict=True)]


def _time_call(run: Callable[[], Any]) -> float:
    begin = time.perf_counter()
    run()
    return time.perf_counter() - begin


@dataclass(frozen=True)
class WorkPrecisionRow:
    """A method on a scene: its time, error, steps and missed events; `note` says why a number is missing."""

    scene: str
    family: str
    method: str
    seconds: float | None
    error: float | None
    events: int | None
    missed: int | None
    steps: int | None
    note: str = ""


def measure(
    scene: BenchScene, ways: Sequence[BenchMethod] = METHODS, repeats: int = 3
) -> list[WorkPrecisionRow]:
    """A row for every method; where its package is not installed the row says so."""
    there = [way for way in ways if not way.package or find_spec(way.package)]
    methods = {way.name: way.create(scene.automaton) for way in there}
    for method in methods.values():
        if isinstance(method, ExternalMethod):
            method.prepare(scene.x0)
        else:
            warm_up(scene.automaton, method)
    runs = {name: _time_run(scene, method) for name, method in methods.items()}
    spent = {name: [seconds] if seconds > SINGLE_RUN_ABOVE else [] for name, (_, seconds) in runs.items()}
    for _ in range(repeats):
        for name in [name for name in methods if runs[name][1] <= SINGLE_RUN_ABOVE]:
            if runs[name][1] < WARM_RUN_BELOW:
                _time_run(scene, methods[name])
            spent[name].append(_time_run(scene, methods[name])[1])
    rows = [
        _measured_row(scene, way, methods[way.name], runs[way.name][0], spent[way.name])
        if way in there
        else _row_without_package(scene, way)
        for way in ways
    ]
    return rows if scene.model is None else [*rows, _regularised_row(scene)]


def _regularised_row(scene: BenchScene) -> WorkPrecisionRow:
    """The row of the regularised model, whose error is that of the smoothing."""
    state, seconds, steps = methods.run(scene.model, scene.t_end)
    name = "model made smooth, LSODA"
    return WorkPrecisionRow(scene.name, "regularised", name, seconds, scene.error(state), 0, None, steps)


def _row_without_package(scene: BenchScene, way: BenchMethod) -> WorkPrecisionRow:
    return WorkPrecisionRow(
        scene.name, way.family, way.name, *[None] * 5, note=f"{way.package} is not installed"
    )


def _time_run(scene: BenchScene, method: Method) -> tuple[Any, float]:
    begin = time.perf_counter()
    run = solve(scene.automaton, scene.t_end, x0=scene.x0, method=method, progress=False)
    return run, time.perf_counter() - begin


def _measured_row(
    scene: BenchScene, way: BenchMethod, method: Method, run: Any, spent: list[float]
) -> WorkPrecisionRow:
    note = "" if run.status is Status.FINISHED else run.status.name.lower().replace("_", " ")
    error = scene.error(run.final_state) if not note else None
    found, steps = len(run.events), method.steps if isinstance(method, ExternalMethod) else run.stats["steps"]
    missed = scene.missed(found)
    return WorkPrecisionRow(
        scene.name, way.family, way.name, median(spent), error, found, missed, steps, note
    )


def as_json(rows: Sequence[WorkPrecisionRow]) -> list[dict[str, Any]]:
    """The rows as JSON has them."""
    return [asdict(row) for row in rows]


def work_precision_table(rows: Sequence[WorkPrecisionRow]) -> str:
    """One scene's rows as Markdown; times also as multiples of ours, events where the scene has any."""
    base = next(row.seconds for row in rows if row.method == BASE_METHOD)
    heads = ["method", "wall time", "x", "error", "steps", "per step"]
    heads += ["events", "missed"] if any(row.events for row in rows) else []
    return markdown_table(" | ".join(heads), (" | ".join(_cells(row, base)[: len(heads)]) for row in rows))


def _cells(row: WorkPrecisionRow, base: float | None) -> list[str]:
    if row.seconds is None or base is None:
        return [row.method, row.note, *[""] * 6]
    error = row.note if row.error is None else f"{row.error:.1e}"
    missed = "-" if row.missed is None else str(row.missed)
    times = [f"{1e3 * row.seconds:.3g} ms", f"{row.seconds / base:.3g}"]
    each = f"{1e6 * row.seconds / row.steps:.2f} us" if row.steps else "-"
    return [row.method, *times, error, str(row.steps), each, str(row.events), missed]
