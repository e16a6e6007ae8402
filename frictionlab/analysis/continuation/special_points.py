"""Special points of a branch of periodic orbits: folds, period doublings, Neimark-Sacker points, by their
test functions.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq

from frictionlab.analysis.motion_scales import Array
from frictionlab.analysis.orbits.shooting import floquet_multipliers
from frictionlab.automaton import HybridAutomaton

from .pseudo_arclength import BranchPoint, continuation_step

LOCATION_XTOL = 1e-12  # share of the step to which a special point is located
UNIT_CIRCLE_ATOL = (
    1e-3  # how far from the unit circle the pair of a Neimark-Sacker point may be, with rounding
)


def transverse_multipliers(point: BranchPoint) -> Array:
    """The multipliers but for that along the orbit."""
    values = floquet_multipliers(point.monodromy)
    return np.delete(values, np.argmin(np.abs(values - 1.0)))


def fold_test(point: BranchPoint) -> float:
    """How fast the parameter grows along the branch."""
    return float(point.tangent[-1])


def period_doubling_test(point: BranchPoint) -> float:
    """Zero where a multiplier is -1."""
    return float(np.prod(1.0 + transverse_multipliers(point)).real)


def neimark_sacker_test(point: BranchPoint) -> float:
    """Zero where the product of two multipliers is 1."""
    values = transverse_multipliers(point)
    products = np.outer(values, values)[np.triu_indices(len(values), 1)]
    return float(np.prod(1.0 - products).real)


TEST_FUNCTIONS: dict[str, Callable[[BranchPoint], float]] = {
    "fold": fold_test,
    "period doubling": period_doubling_test,
    "Neimark-Sacker": neimark_sacker_test,
}


class SpecialPoint(NamedTuple):
    """A special point, its kind, and the parameter there."""

    kind: str
    point: BranchPoint
    value: float


def special_points_between(
    automaton: HybridAutomaton, point: BranchPoint, after: BranchPoint, step: float
) -> list[SpecialPoint]:
    """The special points between a point and the one a step after it, in their order.

    Where one cannot be located, as no orbit is found within the step, it is put at the latter point.
    """
    found = []
    for kind, test in TEST_FUNCTIONS.items():
        if test(point) * test(after) < 0.0:
            try:
                at, share = locate_zero(automaton, point, step, test)
            except ValueError:
                at, share = after, step
            found += [(share, SpecialPoint(kind, at, at.value))] if _is_special(kind, at) else []
    return [special for _, special in sorted(found, key=lambda pair: pair[0])]


def locate_zero(
    automaton: HybridAutomaton, point: BranchPoint, step: float, test: Callable[[BranchPoint], float]
) -> tuple[BranchPoint, float]:
    """The point at which a test function changes its sign within a step, and how far into the step it is."""

    def value(share: float) -> float:
        return test(continuation_step(automaton, point, share)) if share else test(point)

    share: Any = brentq(value, 0.0, step, xtol=LOCATION_XTOL * step)
    return continuation_step(automaton, point, share), share


def _is_special(kind: str, point: BranchPoint) -> bool:
    """Whether a zero is a special point: two real multipliers whose product is 1 are no Neimark-Sacker
    point."""
    values = transverse_multipliers(point)
    pairs = values[np.abs(values.imag) > 0.0]
    return kind != "Neimark-Sacker" or bool((np.abs(np.abs(pairs) - 1.0) < UNIT_CIRCLE_ATOL).any())
