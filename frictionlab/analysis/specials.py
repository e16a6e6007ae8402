"""Special points of a branch of closed orbits, between two neighbours on it: tests that change their sign."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq

from frictionlab.automaton import HybridAutomaton

from .arclength import Point, stepped
from .recurrence import Array

EXACT = 1e-12  # of the step, to which a special point is found
ON_CIRCLE = 1e-3  # how far from the unit circle the pair of a Neimark-Sacker point may be, with rounding


def multipliers(monodromy: Array) -> Array:
    """Eigenvalues, the largest first."""
    values = np.linalg.eigvals(monodromy).astype(complex)
    return values[np.argsort(-np.abs(values), kind="stable")]


def others(point: Point) -> Array:
    """The multipliers but for that along the orbit."""
    values = multipliers(point.monodromy)
    return np.delete(values, np.argmin(np.abs(values - 1.0)))


def fold(point: Point) -> float:
    """How fast the parameter grows along the branch."""
    return float(point.tangent[-1])


def period_doubling(point: Point) -> float:
    """Zero where a multiplier is -1."""
    return float(np.prod(1.0 + others(point)).real)


def neimark_sacker(point: Point) -> float:
    """Zero where the product of two multipliers is 1."""
    values = others(point)
    products = np.outer(values, values)[np.triu_indices(len(values), 1)]
    return float(np.prod(1.0 - products).real)


TESTS: dict[str, Callable[[Point], float]] = {
    "fold": fold,
    "period doubling": period_doubling,
    "Neimark-Sacker": neimark_sacker,
}


class Found(NamedTuple):
    """A special point, its kind, and the parameter there."""

    kind: str
    point: Point
    value: float


def between(automaton: HybridAutomaton, point: Point, after: Point, step: float) -> list[Found]:
    """The special points between a point and the one a step after it, in their order.

    Where one cannot be located, as no orbit is found within the step, it is put at the latter point.
    """
    found = []
    for kind, test in TESTS.items():
        if test(point) * test(after) < 0.0:
            try:
                at, share = located(automaton, point, step, test)
            except ValueError:
                at, share = after, step
            found += [(share, Found(kind, at, at.value))] if _is(kind, at) else []
    return [special for _, special in sorted(found, key=lambda pair: pair[0])]


def located(
    automaton: HybridAutomaton, point: Point, step: float, test: Callable[[Point], float]
) -> tuple[Point, float]:
    """Where a test changes its sign within a step, and how far into it that is."""

    def value(share: float) -> float:
        return test(stepped(automaton, point, share)) if share else test(point)

    share: Any = brentq(value, 0.0, step, xtol=EXACT * step)
    return stepped(automaton, point, share), share


def _is(kind: str, point: Point) -> bool:
    """Real multipliers whose product is 1 are no Neimark-Sacker point."""
    values = others(point)
    pairs = values[np.abs(values.imag) > 0.0]
    return kind != "Neimark-Sacker" or bool((np.abs(np.abs(pairs) - 1.0) < ON_CIRCLE).any())
