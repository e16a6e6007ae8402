"""Work against precision: scenes x methods, in turns, errors against references."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from importlib.util import find_spec
from statistics import median
from typing import Any

from frictionlab.analysis.markdown import markdown
from frictionlab.hybrid.methods import Method
from frictionlab.hybrid.solve import solve
from frictionlab.hybrid.status import Status

from . import regularised
from .external import External
from .ready import make_ready
from .scenes import BenchScene
from .ways import WAYS, Way

OURS = "frictionlab, tol 1e-15"
SLOW = 3.0  # s: a run longer than this is timed once
BRIEF = 0.1  # s: a shorter one would be slowed down by what ran before it, which leaves the caches cold


@dataclass(frozen=True)
class Row:
    """A method on a scene: what it took, found and missed; `note` says why a number is not there."""

    scene: str
    family: str
    method: str
    seconds: float | None
    error: float | None
    events: int | None
    missed: int | None
    steps: int | None
    note: str = ""


def measure(scene: BenchScene, ways: Sequence[Way] = WAYS, repeats: int = 3) -> list[Row]:
    """A row for every way; those whose package is absent say so."""
    there = [way for way in ways if not way.needs or find_spec(way.needs)]
    methods = {way.name: way.make(scene.automaton) for way in there}
    for method in methods.values():
        if isinstance(method, External):
            method.prepare(scene.x0)
        else:
            make_ready(scene.automaton, method)
    runs = {name: _timed(scene, method) for name, method in methods.items()}
    spent = {name: [seconds] if seconds > SLOW else [] for name, (_, seconds) in runs.items()}
    for _ in range(repeats):
        for name in [name for name in methods if runs[name][1] <= SLOW]:
            if runs[name][1] < BRIEF:
                _timed(scene, methods[name])
            spent[name].append(_timed(scene, methods[name])[1])
    rows = [
        _row(scene, way, methods[way.name], runs[way.name][0], spent[way.name])
        if way in there
        else _absent(scene, way)
        for way in ways
    ]
    return rows if scene.model is None else [*rows, _smoothed(scene)]


def _smoothed(scene: BenchScene) -> Row:
    """Another model, not another method: its error is what smoothing does."""
    state, seconds, steps = regularised.run(scene.model, scene.t_end)
    name = "model made smooth, LSODA"
    return Row(scene.name, "regularised", name, seconds, scene.error(state), 0, None, steps)


def _absent(scene: BenchScene, way: Way) -> Row:
    return Row(scene.name, way.family, way.name, *[None] * 5, note=f"{way.needs} is not installed")


def _timed(scene: BenchScene, method: Method) -> tuple[Any, float]:
    begin = time.perf_counter()
    run = solve(scene.automaton, scene.t_end, x0=scene.x0, method=method, progress=False)
    return run, time.perf_counter() - begin


def _row(scene: BenchScene, way: Way, method: Method, run: Any, spent: list[float]) -> Row:
    note = "" if run.status is Status.FINISHED else run.status.name.lower().replace("_", " ")
    error = scene.error(run.final_state) if not note else None
    found, steps = len(run.events), method.steps if isinstance(method, External) else run.stats["steps"]
    missed = scene.missed(found)
    return Row(scene.name, way.family, way.name, median(spent), error, found, missed, steps, note)


def as_json(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """The rows as JSON has them."""
    return [asdict(row) for row in rows]


def table(rows: Sequence[Row]) -> str:
    """One scene's rows as Markdown; times also as multiples of ours, events where the scene has any."""
    base = next(row.seconds for row in rows if row.method == OURS)
    heads = ["method", "wall time", "x", "error", "steps", "per step"]
    heads += ["events", "missed"] if any(row.events for row in rows) else []
    return markdown(" | ".join(heads), (" | ".join(_cells(row, base)[: len(heads)]) for row in rows))


def _cells(row: Row, base: float | None) -> list[str]:
    if row.seconds is None or base is None:
        return [row.method, row.note, *[""] * 6]
    error = row.note if row.error is None else f"{row.error:.1e}"
    missed = "-" if row.missed is None else str(row.missed)
    times = [f"{1e3 * row.seconds:.3g} ms", f"{row.seconds / base:.3g}"]
    each = f"{1e6 * row.seconds / row.steps:.2f} us" if row.steps else "-"
    return [row.method, *times, error, str(row.steps), each, str(row.events), missed]
