"""What stability and exact derivatives cost: many eigenvalue problems at once against a loop; processor time
of `fl.sensitivity`, by all parameters, against that of the quantity alone; Floquet multipliers by the tangent
tape against finite differences.

`python docs/performance/stability_costs.py` prints the table of docs/how-to/sensitivity.md.  Quantities of
orbits start from a known orbit; the search for it, which both sides would share, is not timed.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from statistics import median
from typing import Any

import numpy as np

from frictionlab.analysis.orbits.periodic_orbit import PeriodicOrbit, periodic_orbit
from frictionlab.analysis.quantities.critical_quantities import CriticalFrequency, CriticalValue
from frictionlab.analysis.quantities.folds import FoldValue
from frictionlab.analysis.quantities.orbit_quantities import OrbitAmplitude, OrbitIntensity, OrbitPeriod
from frictionlab.analysis.quantities.quantities import (
    EquilibriumCoordinate,
    GrowthRate,
    ModeFrequency,
    Quantity,
    sensitivity,
)
from frictionlab.analysis.simulate import simulate
from frictionlab.components import PlasticImpact
from frictionlab.hybrid.methods.taylor import Taylor
from frictionlab.hybrid.variational.tangent_flow import tangent_flow
from frictionlab.models import (
    ImpactOscillator,
    MassOnBelt,
    ModeCoupling,
    Model,
    SliderOnBelt,
    SliderOnRigidBelt,
)
from frictionlab.models.model import require_model
from frictionlab.stability import eigenvalues, root_locus, stability_changes
from reference_scenes import FULL_GAP_RATE_SLIDER
from tables import markdown_table
from timing import least_times, warm_up

LOOP_STRIDE = 20  # the loop solves one problem in so many and is scaled up
EIGENPROBLEM_MODEL = SliderOnBelt()
DIFFERENCE_STEPS = (1e-4, 1e-6, 1e-8)
LEAST_TIME = 0.02  # s: what takes less is repeated within a measurement
RANGE = (0.0, 4.0)  # of mu_k, in which stability is lost
FOLDED = SliderOnBelt(mu_k=1.5, F=3000.0, k4=2e4, k5=2e3, k6=2e3, l1=0.05, l2=0.05)
CYCLES = (
    (SliderOnBelt(mu_k=1.4, impact=PlasticImpact("full")), "x1"),
    (SliderOnBelt(mu_k=1.4).without("geometry"), "x1"),
    (MassOnBelt(c=0.05), "x"),
    (ImpactOscillator(Omega=2.8, e=0.6, d=0.05, c=0.02), "x"),
)


@dataclass(frozen=True)
class EigenproblemRow:
    """A row of the table: task, processor time (s), largest difference of an eigenvalue from those of the
    loop (1/s)."""

    name: str
    seconds: float
    difference: float


def eigenproblem_times(count: int = 10_000, repeats: int = 3) -> list[EigenproblemRow]:
    """Equilibrium and eigenvalues for `count` values of mu_k: all at once, with modes tracked; in a loop."""
    values = np.linspace(0.0, 3.0, count)
    some = values[::LOOP_STRIDE]
    at_once, loop, changes = least_times(
        [
            lambda: root_locus(EIGENPROBLEM_MODEL, "mu_k", values),
            lambda: _eigenvalues_in_loop(some),
            _find_changes,
        ],
        repeats,
    )
    scale = count / len(some)
    return [
        EigenproblemRow(f"{count} values, modes tracked (root_locus)", at_once, _largest_difference(some)),
        EigenproblemRow(f"{count} values, one after another (eigenvalues)", loop * scale, 0.0),
        EigenproblemRow("every stability change from mu_k 0 to 3 (stability_changes)", changes, 0.0),
    ]


def _eigenvalues_in_loop(values: Any) -> list[Any]:
    return [eigenvalues(EIGENPROBLEM_MODEL.replace(mu_k=float(value))).values for value in values]


def _find_changes() -> Any:
    return stability_changes(EIGENPROBLEM_MODEL, "mu_k", (0.0, 3.0))


def _largest_difference(values: Any) -> float:
    tracked = np.sort_complex(root_locus(EIGENPROBLEM_MODEL, "mu_k", values).values)
    upper = np.array([np.sort_complex(one[one.imag > 0]) for one in _eigenvalues_in_loop(values)])
    return float(np.abs(tracked - upper).max())


def eigenproblem_table(rows: list[EigenproblemRow]) -> str:
    """The rows as Markdown; times also as multiples of the first."""
    lines = (
        f"{r.name} | {r.seconds:.3g} s | {r.seconds / rows[0].seconds:.2g} | {r.difference:.0e}" for r in rows
    )
    return markdown_table("eigenvalue problems | time | x | difference, 1/s", lines)


@dataclass(frozen=True)
class SensitivityCost:
    """Processor times (s) of a quantity of a model: the number alone, and with all derivatives."""

    model: str
    quantity: str
    parameters: int
    alone: float
    with_derivatives: float

    @property
    def extra(self) -> float:
        """Cost of the derivatives, in evaluations of the number alone."""
        return self.with_derivatives / self.alone - 1.0


def sensitivity_costs(repeats: int = 9) -> list[SensitivityCost]:
    """Costs of quantities of stability, equilibria, a fold and orbits; medians of interleaved turns."""
    return [_cost_of(model, quantity, repeats) for model, quantity in _cases()]


def _cases() -> Iterator[tuple[Any, Quantity]]:
    for model in (SliderOnBelt(mu_k=1.4), ModeCoupling(c=0.1), SliderOnRigidBelt()):
        yield model, CriticalValue("mu_k", RANGE)
        yield model, CriticalFrequency("mu_k", RANGE)
        yield model, GrowthRate()
        yield model, ModeFrequency(1)
        yield model, EquilibriumCoordinate(model.coordinates[0])
    yield FOLDED, FoldValue("F", (100.0, 6000.0))
    for model, name in CYCLES:
        orbit = _orbit_of(model)
        yield model, OrbitPeriod(near=orbit)
        yield model, OrbitAmplitude(name, near=orbit)
        if not isinstance(model, ImpactOscillator):  # which has no equilibrium, from which L_s is measured
            yield model, OrbitIntensity(near=orbit)


def _orbit_of(model: Model) -> PeriodicOrbit:
    return periodic_orbit(model, simulate(model, 200.0, progress=False))


def _cost_of(model: Model, quantity: Quantity, repeats: int) -> SensitivityCost:
    def alone() -> Any:
        return quantity(model)

    def derivatives() -> Any:
        return sensitivity(model, quantity)

    alone()
    count = len(derivatives().parameters)  # this call derives the equations, once for a structure
    times = max(1, int(LEAST_TIME / max(_processor_time(alone, 1), 1e-6)))
    turns = [[_processor_time(way, times) for way in (alone, derivatives)] for _ in range(repeats)]
    first, second = (median(column) for column in zip(*turns, strict=True))
    return SensitivityCost(type(model).__name__, quantity.label, count, first, second)


def _processor_time(way: Callable[[], Any], times: int) -> float:
    begin = time.process_time()
    for _ in range(times):
        way()
    return (time.process_time() - begin) / times


def sensitivity_table(rows: Sequence[SensitivityCost]) -> str:
    """The rows as Markdown."""
    lines = (
        f"{r.model} | {r.quantity} | {r.parameters} | {1e3 * r.alone:.3g} ms "
        f"| {1e3 * r.with_derivatives:.3g} ms | {max(r.extra, 0.0):.1f}"
        for r in rows
    )
    head = "model | quantity | parameters | the number | with all derivatives | extra evaluations"
    return markdown_table(head, lines)


@dataclass(frozen=True)
class MultiplierRow:
    """A row of the table: method, processor time (s), runs over a period; error of the known multipliers,
    1 and 0, and of the largest other."""

    scene: str
    name: str
    seconds: float
    runs: int
    known: float
    other: float


def multiplier_times(repeats: int = 5) -> list[MultiplierRow]:
    """Scenes A and B at mu_k = 1.4: a cycle of slip, stick, slip and flight."""
    return [row for name in ("A", "B") for row in _scene_rows(name, repeats)]


def _scene_rows(name: str, repeats: int) -> list[MultiplierRow]:
    model = FULL_GAP_RATE_SLIDER.without("geometry") if name == "A" else FULL_GAP_RATE_SLIDER
    warm_up(model.automaton(), Taylor())
    orbit = periodic_orbit(model, simulate(model, 60.0, progress=False))
    count = len(orbit.state)
    ways: dict[str, tuple[Callable[[], np.ndarray], int]] = {
        "tangent tape": (partial(monodromy_by_tape, orbit), 1)
    }
    for step in DIFFERENCE_STEPS:
        ways[f"central differences, step {step:.0e}"] = (
            partial(monodromy_by_differences, orbit, step),
            2 * count,
        )
    seconds = least_times([way for way, _ in ways.values()], repeats)
    reference = _largest_other(monodromy_extrapolated(orbit))
    return [
        _multiplier_row(name, text, spent, runs, way(), reference)
        for (text, (way, runs)), spent in zip(ways.items(), seconds, strict=True)
    ]


def monodromy_by_tape(orbit: PeriodicOrbit) -> np.ndarray:
    """Monodromy matrix by the tangent flow of one run."""
    return tangent_flow(_run_period(orbit, orbit.state), progress=False).matrix


def monodromy_by_differences(orbit: PeriodicOrbit, step: float) -> np.ndarray:
    """Monodromy matrix by central differences, from two runs for each state."""
    size = np.ptp(orbit.trajectory.states, axis=0)
    ends = [
        (_state_after_period(orbit, off), _state_after_period(orbit, -off)) for off in step * np.diag(size)
    ]
    columns = [(plus - minus) / (2.0 * step) for plus, minus in ends]
    return np.column_stack(columns) / size


def monodromy_extrapolated(orbit: PeriodicOrbit) -> np.ndarray:
    """Monodromy matrix extrapolated from differences with two steps: the reference for errors."""
    return (4.0 * monodromy_by_differences(orbit, 1e-5) - monodromy_by_differences(orbit, 2e-5)) / 3.0


def _run_period(orbit: PeriodicOrbit, state: Any) -> Any:
    return simulate(require_model(orbit.model), orbit.period, x0=state, progress=False)


def _state_after_period(orbit: PeriodicOrbit, off: np.ndarray) -> np.ndarray:
    return _run_period(orbit, orbit.state + off).final_state


def _largest_other(matrix: np.ndarray) -> float:
    """Size of the largest multiplier apart from that along the orbit."""
    values = np.linalg.eigvals(matrix)
    return float(np.abs(np.delete(values, np.argmin(np.abs(values - 1.0)))).max())


def _multiplier_row(
    scene: str, name: str, seconds: float, runs: int, matrix: np.ndarray, reference: float
) -> MultiplierRow:
    values = np.linalg.eigvals(matrix)
    known = max(np.abs(values - 1.0).min(), np.abs(values).min())
    return MultiplierRow(scene, name, seconds, runs, float(known), abs(_largest_other(matrix) - reference))


def multiplier_table(rows: Sequence[MultiplierRow]) -> str:
    """The rows as Markdown; times also as multiples of the scene's first."""
    first = {row.scene: row.seconds for row in reversed(rows)}
    lines = (
        f"{r.scene} | {r.name} | {r.runs} | {1e3 * r.seconds:.3g} ms | {r.seconds / first[r.scene]:.2f} "
        f"| {r.known:.1e} | {r.other:.1e}"
        for r in rows
    )
    return markdown_table("scene | way | runs | time | x | error of 1 and 0 | of the largest other", lines)


if __name__ == "__main__":
    print(sensitivity_table(sensitivity_costs()))
