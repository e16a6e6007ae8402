"""What the exact derivatives of a quantity cost: processor time of `fl.sensitivity`, by all parameters,
beside that of the quantity alone.

`python -m frictionlab.bench.sensitivity_costs` prints the table of docs/how-to/sensitivity.md.  Quantities of
orbits are those near an orbit that is known, without the search for it, which both would share.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from statistics import median
from typing import Any

from frictionlab.analysis.orbits.periodic_orbit import PeriodicOrbit, periodic_orbit
from frictionlab.analysis.quantities.critical_quantities import CriticalFrequency, CriticalValue, FoldValue
from frictionlab.analysis.quantities.equilibrium_quantities import (
    EquilibriumCoordinate,
    GrowthRate,
    ModeFrequency,
)
from frictionlab.analysis.quantities.orbit_quantities import OrbitAmplitude, OrbitIntensity, OrbitPeriod
from frictionlab.analysis.quantities.sensitivity import Quantity, sensitivity
from frictionlab.analysis.simulate import simulate
from frictionlab.components import PlasticImpact
from frictionlab.models import ImpactOscillator, MassOnBelt, ModeCoupling, SliderOnBelt, SliderOnRigidBelt
from frictionlab.presentation import markdown_table

LEAST_TIME = 0.02  # s: what takes less is done several times
RANGE = (0.0, 4.0)  # of mu_k, in which stability is lost
FOLDED = SliderOnBelt(mu_k=1.5, F=3000.0, k4=2e4, k5=2e3, k6=2e3, l1=0.05, l2=0.05)
CYCLES = (
    (SliderOnBelt(mu_k=1.4, impact=PlasticImpact("full")), "x1"),
    (SliderOnBelt(mu_k=1.4).without("geometry"), "x1"),
    (MassOnBelt(c=0.05), "x"),
    (ImpactOscillator(Omega=2.8, e=0.6, d=0.05, c=0.02), "x"),
)


@dataclass(frozen=True)
class SensitivityCost:
    """A quantity of a model: processor times (s) of the number alone, and with all derivatives."""

    model: str
    quantity: str
    parameters: int
    alone: float
    with_derivatives: float

    @property
    def extra(self) -> float:
        """By how many evaluations of the number the derivatives lengthen it."""
        return self.with_derivatives / self.alone - 1.0


def sensitivity_costs(repeats: int = 9) -> list[SensitivityCost]:
    """Every quantity of three models or more; medians of interleaved turns."""
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
        if not isinstance(model, ImpactOscillator):  # it has no equilibrium to measure L_s from
            yield model, OrbitIntensity(near=orbit)


def _orbit_of(model: Any) -> PeriodicOrbit:
    return periodic_orbit(model, simulate(model, 200.0, progress=False))


def _cost_of(model: Any, quantity: Quantity, repeats: int) -> SensitivityCost:
    def alone() -> Any:
        return quantity(model)

    def derivatives() -> Any:
        return sensitivity(model, quantity)

    alone()
    count = len(derivatives().parameters)  # equations are derived here, once for a structure
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


if __name__ == "__main__":
    print(sensitivity_table(sensitivity_costs()))
