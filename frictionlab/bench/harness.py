"""Work against precision: scenes x methods, in turns, errors against references."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from importlib.util import find_spec
from statistics import median
from typing import Any

from frictionlab.automaton import HybridAutomaton
from frictionlab.hybrid.methods import Method
from frictionlab.hybrid.rk4 import RK4
from frictionlab.hybrid.solve import solve
from frictionlab.hybrid.status import Status
from frictionlab.hybrid.taylor import Taylor

from . import regularised
from .scenes import BenchScene
from .with_cvode import Cvode
from .with_heyoka import Heyoka
from .with_scipy import SolveIvp

OURS = "frictionlab, tol 1e-15"
SLOW = 3.0  # s: a run longer than this is timed once
NEVER = (None, 0.0)


@dataclass(frozen=True)
class Way:
    """A method by name, made for an automaton, and the package it needs."""

    family: str
    name: str
    make: Callable[[HybridAutomaton], Method]
    needs: str = ""


@dataclass(frozen=True)
class Row:
    """A method on a scene; `note` says why the numbers are missing."""

    scene: str
    family: str
    method: str
    seconds: float | None
    error: float | None
    events: int | None
    note: str = ""


def _taylor(tol: float) -> Way:
    return Way("frictionlab", f"frictionlab, tol {tol:.0e}", lambda a: Taylor(tol=tol))


def _rk4(step: float) -> Way:
    return Way("RK4", f"RK4, step {step:g} s", lambda a: RK4(step=step))


def _ivp(integrator: str, rtol: float) -> Way:
    def make(automaton: HybridAutomaton) -> Method:
        return SolveIvp(automaton, integrator, rtol, rtol * 1e-3)

    return Way(f"scipy {integrator}", f"scipy {integrator}, rtol {rtol:.0e}", make)


def _heyoka(tol: float) -> Way:
    return Way("heyoka", f"heyoka, tol {tol:.0e}", lambda a: Heyoka(a, tol), "heyoka")


def _cvode(formula: str, rtol: float) -> Way:
    def make(automaton: HybridAutomaton) -> Method:
        return Cvode(automaton, formula, rtol, rtol * 1e-3)

    return Way(f"CVODE {formula}", f"CVODE {formula}, rtol {rtol:.0e}", make, "sksundae")


WAYS = (
    *map(_taylor, (1e-15, 1e-10, 1e-6)),
    *map(_rk4, (1e-3, 1e-4, 2e-5)),
    *(_ivp(name, rtol) for name in ("DOP853", "RK45", "LSODA") for rtol in (1e-7, 1e-10)),
    *map(_heyoka, (1e-15, 1e-9)),
    *(_cvode(formula, rtol) for formula in ("Adams", "BDF") for rtol in (1e-8, 1e-11)),
)


def measure(scene: BenchScene, ways: Sequence[Way] = WAYS, repeats: int = 3) -> list[Row]:
    """A row for every way; those whose package is absent say so."""
    there = [way for way in ways if not way.needs or find_spec(way.needs)]
    methods = {way.name: way.make(scene.automaton) for way in there}
    runs = {name: _timed(scene, method) for name, method in methods.items()}  # compiles too
    spent = {name: [seconds] if seconds > SLOW else [] for name, (_, seconds) in runs.items()}
    for _ in range(repeats):
        for name in [name for name in methods if runs[name][1] <= SLOW]:
            spent[name].append(_timed(scene, methods[name])[1])
    rows = [_row(scene, way, runs.get(way.name, NEVER)[0], spent.get(way.name)) for way in ways]
    return rows if scene.model is None else [*rows, _smoothed(scene)]


def _smoothed(scene: BenchScene) -> Row:
    """Another model, not another method: its error is what smoothing does."""
    state, seconds = regularised.run(scene.model, scene.t_end)
    return Row(scene.name, "regularised", "model made smooth, LSODA", seconds, scene.error(state), 0)


def _timed(scene: BenchScene, method: Method) -> tuple[Any, float]:
    begin = time.perf_counter()
    run = solve(scene.automaton, scene.t_end, x0=scene.x0, method=method, progress=False)
    return run, time.perf_counter() - begin


def _row(scene: BenchScene, way: Way, run: Any, spent: list[float] | None) -> Row:
    if run is None or spent is None:
        return Row(scene.name, way.family, way.name, None, None, None, f"{way.needs} is not installed")
    note = "" if run.status is Status.FINISHED else run.status.name.lower().replace("_", " ")
    error = scene.error(run.final_state) if not note else None
    return Row(scene.name, way.family, way.name, median(spent), error, len(run.events), note)


def as_json(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """The rows as JSON has them."""
    return [asdict(row) for row in rows]


def table(rows: Sequence[Row]) -> str:
    """One scene's rows as Markdown; times also as multiples of ours."""
    base = next(row.seconds for row in rows if row.method == OURS)
    lines = ["| method | wall time | x | error | events |", "|---|---|---|---|---|"]
    return "\n".join([*lines, *(_line(row, base) for row in rows)])


def _line(row: Row, base: float | None) -> str:
    if row.seconds is None or base is None:
        return f"| {row.method} | {row.note} | | | |"
    error = row.note if row.error is None else f"{row.error:.1e}"
    ratio = row.seconds / base
    return f"| {row.method} | {1e3 * row.seconds:.3g} ms | {ratio:.3g} | {error} | {row.events} |"
