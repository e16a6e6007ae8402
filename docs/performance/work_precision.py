"""Work against precision: scenes x methods, timed in turns, errors against reference states.

Everything is compiled before anything is timed: kernels, and native code of all modes, which a long run
would have.  Times are processor times, medians of interleaved runs.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from importlib.util import find_spec
from statistics import median
from typing import Any

from compared_methods import METHODS, ComparedMethod, run_regularised
from external import ExternalMethod
from frictionlab.hybrid.methods.base import Method
from frictionlab.hybrid.problem import Status
from frictionlab.hybrid.solve import solve
from frictionlab.models import SliderOnBelt
from reference_scenes import ReferenceScene
from tables import markdown_table, three_digits
from timing import warm_up

BASE_METHOD = "frictionlab, tol 1e-15"
SINGLE_RUN_ABOVE = 3.0  # s: a run longer than this is timed once
# s: shorter runs are repeated for so long at each turn, as the first ones find cold caches
TURN_SECONDS = 0.1
SHORT_TURNS = 3  # times as many turns for these, as other work on the machine slows down a turn or two
PEERS = (
    "heyoka",
    "heyoka, fast_math",
    "diffrax Dopri8",
    "CVODE Adams",
    "scipy DOP853",
    "scipy LSODA",
    "PathSim RKDP87",
    "RK4",
)
OURS = "frictionlab"


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
    scene: ReferenceScene, ways: Sequence[ComparedMethod] = METHODS, repeats: int = 3
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
    for turn in range(SHORT_TURNS * repeats):
        longest = SINGLE_RUN_ABOVE if turn < repeats else TURN_SECONDS
        for name in [name for name in methods if runs[name][1] <= longest]:
            spent[name].append(_time_of_turn(scene, methods[name]))
    rows = [
        _measured_row(scene, way, methods[way.name], runs[way.name][0], spent[way.name])
        if way in there
        else _row_without_package(scene, way)
        for way in ways
    ]
    return rows if scene.model is None else [*rows, _regularised_row(scene, scene.model)]


def _regularised_row(scene: ReferenceScene, model: SliderOnBelt) -> WorkPrecisionRow:
    """The row of the regularised model, whose error is that of the smoothing."""
    state, seconds, steps = run_regularised(model, scene.t_end)
    family = "model made smooth"
    name = f"{family}, LSODA"
    return WorkPrecisionRow(scene.name, family, name, seconds, scene.error(state), 0, None, steps)


def _row_without_package(scene: ReferenceScene, way: ComparedMethod) -> WorkPrecisionRow:
    return WorkPrecisionRow(
        scene.name, way.family, way.name, *[None] * 5, note=f"{way.package} is not installed"
    )


def _time_run(scene: ReferenceScene, method: Method) -> tuple[Any, float]:
    begin = time.process_time()  # in which other work on the machine counts little
    run = solve(scene.automaton, scene.t_end, x0=scene.x0, method=method, progress=False)
    return run, time.process_time() - begin


def _time_of_turn(scene: ReferenceScene, method: Method) -> float:
    """Median time of the runs that fit into a turn, which is equally long for every method."""
    spent: list[float] = []
    while not spent or sum(spent) < TURN_SECONDS:
        spent.append(_time_run(scene, method)[1])
    return median(spent)


def _measured_row(
    scene: ReferenceScene, way: ComparedMethod, method: Method, run: Any, spent: list[float]
) -> WorkPrecisionRow:
    note = "" if run.status is Status.FINISHED else run.status.name.lower().replace("_", " ")
    error = scene.error(run.final_state) if not note else None
    events, steps = (
        len(run.events),
        method.steps if isinstance(method, ExternalMethod) else run.stats["steps"],
    )
    missed = scene.missed(events)
    return WorkPrecisionRow(
        scene.name, way.family, way.name, median(spent), error, events, missed, steps, note
    )


def as_json(rows: Sequence[WorkPrecisionRow]) -> list[dict[str, Any]]:
    """The rows as dictionaries, for JSON."""
    return [asdict(row) for row in rows]


def work_precision_table(rows: Sequence[WorkPrecisionRow]) -> str:
    """One scene's rows as Markdown; times also as multiples of ours, events where the scene has any."""
    base = next(row.seconds for row in rows if row.method == BASE_METHOD)
    heads = ["method", "time", "x", "error", "steps", "per step"]
    heads += ["events", "missed"] if any(row.events for row in rows) else []
    return markdown_table(" | ".join(heads), (" | ".join(_cells(row, base)[: len(heads)]) for row in rows))


def ratio_table(rows: Sequence[WorkPrecisionRow]) -> str:
    """A row for each tool, a column for each scene: its times divided by ours at no larger error."""
    names = list(dict.fromkeys(row.scene for row in rows))
    lines = (" | ".join([family, *(_ratio_cell(rows, name, family) for name in names)]) for family in PEERS)
    return markdown_table(" | ".join(["tool", *names]), lines)


def own_table(rows: Sequence[WorkPrecisionRow]) -> str:
    """Our own times in ms, a row for each tolerance and a column for each scene."""
    names = list(dict.fromkeys(row.scene for row in rows))
    ours = [row for row in rows if row.family == OURS]
    lines = []
    for method in dict.fromkeys(row.method for row in ours):
        times = {row.scene: 1e3 * (row.seconds or 0.0) for row in ours if row.method == method}
        tolerance = method.rpartition(" ")[2]
        lines.append(" | ".join([tolerance, *(three_digits(times[name]) for name in names)]))
    return markdown_table(" | ".join(["tolerance", *names]), lines)


def _ratio_cell(rows: Sequence[WorkPrecisionRow], scene: str, family: str) -> str:
    here = [row for row in rows if row.scene == scene and row.family == family and row.error is not None]
    ours = [row for row in rows if row.scene == scene and row.family == OURS]
    return ", ".join(_ratio_text(row, ours) for row in sorted(here, key=lambda row: row.error or 0.0))


def _ratio_text(row: WorkPrecisionRow, ours: Sequence[WorkPrecisionRow]) -> str:
    error = row.error or 0.0
    exact = [own.seconds for own in ours if own.seconds and (own.error or 0.0) <= error]
    best = min(ours, key=lambda own: own.error or 0.0).seconds
    text = three_digits((row.seconds or 0.0) / (min(exact) if exact else best or 1.0))
    return text if exact else f"({text})"


def _cells(row: WorkPrecisionRow, base: float | None) -> list[str]:
    if row.seconds is None or base is None:
        return [row.method, row.note, *[""] * 6]
    error = row.note if row.error is None else f"{row.error:.1e}"
    missed = "-" if row.missed is None else str(row.missed)
    times = [f"{three_digits(1e3 * row.seconds)} ms", three_digits(row.seconds / base)]
    each = f"{1e6 * row.seconds / row.steps:.2f} us" if row.steps else "-"
    return [row.method, *times, error, str(row.steps), each, str(row.events), missed]
