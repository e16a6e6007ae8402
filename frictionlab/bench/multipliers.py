"""Floquet multipliers by the tangent tape against finite differences of runs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from frictionlab.analysis.markdown import markdown
from frictionlab.analysis.periodic_orbit import PeriodicOrbit, periodic_orbit
from frictionlab.analysis.simulate import simulate
from frictionlab.hybrid.tangent_flow import tangent_flow
from frictionlab.hybrid.taylor import Taylor

from .ready import make_ready
from .switches import SCENE, interleaved

STEPS = (1e-4, 1e-6, 1e-8)  # of finite differences, as a share of the motion's range in each state


@dataclass(frozen=True)
class Row:
    """How, wall time in s, runs of a period, errors of the multipliers 1 and 0, and of the largest other."""

    scene: str
    name: str
    seconds: float
    runs: int
    known: float
    other: float


def multipliers(repeats: int = 5) -> list[Row]:
    """Scenes A and B at mu_k = 1.4: a cycle of slip, stick, slip and flight."""
    return [row for name in ("A", "B") for row in _rows(name, repeats)]


def _rows(name: str, repeats: int) -> list[Row]:
    model = SCENE.without("geometry") if name == "A" else SCENE
    make_ready(model.automaton(), Taylor())
    orbit = periodic_orbit(model, simulate(model, 60.0, progress=False))
    count = len(orbit.state)
    ways: dict[str, tuple[Callable[[], np.ndarray], int]] = {"tangent tape": (partial(by_tape, orbit), 1)}
    for step in STEPS:
        ways[f"central differences, step {step:.0e}"] = partial(by_differences, orbit, step), 2 * count
    seconds = interleaved([way for way, _ in ways.values()], repeats)
    reference = _largest_other(extrapolated(orbit))
    return [
        _row(name, text, spent, runs, way(), reference)
        for (text, (way, runs)), spent in zip(ways.items(), seconds, strict=True)
    ]


def by_tape(orbit: PeriodicOrbit) -> np.ndarray:
    """Monodromy matrix of one run and its tangent flow."""
    return tangent_flow(_run(orbit, orbit.state), progress=False).matrix


def by_differences(orbit: PeriodicOrbit, step: float) -> np.ndarray:
    """Monodromy matrix of two runs for each state."""
    size = np.ptp(orbit.trajectory.states, axis=0)
    ends = [(_end(orbit, off), _end(orbit, -off)) for off in step * np.diag(size)]
    columns = [(plus - minus) / (2.0 * step) for plus, minus in ends]
    return np.column_stack(columns) / size


def extrapolated(orbit: PeriodicOrbit) -> np.ndarray:
    """Differences of two steps, extrapolated: what errors are measured by."""
    return (4.0 * by_differences(orbit, 1e-5) - by_differences(orbit, 2e-5)) / 3.0


def _run(orbit: PeriodicOrbit, state: Any) -> Any:
    return simulate(orbit.model, orbit.period, x0=state, progress=False)


def _end(orbit: PeriodicOrbit, off: np.ndarray) -> np.ndarray:
    return _run(orbit, orbit.state + off).final_state


def _largest_other(matrix: np.ndarray) -> float:
    """Size of the largest multiplier but that along the orbit."""
    values = np.linalg.eigvals(matrix)
    return float(np.abs(np.delete(values, np.argmin(np.abs(values - 1.0)))).max())


def _row(scene: str, name: str, seconds: float, runs: int, matrix: np.ndarray, reference: float) -> Row:
    values = np.linalg.eigvals(matrix)
    known = max(np.abs(values - 1.0).min(), np.abs(values).min())
    return Row(scene, name, seconds, runs, float(known), abs(_largest_other(matrix) - reference))


def table(rows: Sequence[Row]) -> str:
    """The rows as Markdown; times also as multiples of the scene's first."""
    first = {row.scene: row.seconds for row in reversed(rows)}
    lines = (
        f"{r.scene} | {r.name} | {r.runs} | {1e3 * r.seconds:.3g} ms | {r.seconds / first[r.scene]:.2f} "
        f"| {r.known:.1e} | {r.other:.1e}"
        for r in rows
    )
    return markdown("scene | way | runs | wall time | x | error of 1 and 0 | of the largest other", lines)
