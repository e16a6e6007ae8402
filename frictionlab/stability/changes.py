"""`fl.stability_changes` and `fl.critical_value`: every loss and regain of stability in a range."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize.elementwise import find_root

from .scan import NEUTRAL, Brackets, Evaluate, brackets, growth
from .steady import Steady
from .view import check_bounds, check_parameter, steady

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
JUMP = 1e-6  # share of the largest eigenvalue: a larger growth rate at a root means that there is none


@dataclass(frozen=True)
class StabilityChange:
    """A value of a parameter at which one mode becomes unstable, or stable again.

    Parameters
    ----------
    value : float
        The parameter's.
    frequency : float
        Of the mode, Hz; zero for divergence.
    kind : "flutter", "divergence" or "fold"
        Flutter: a complex pair crosses the imaginary axis, as where modes couple.  Divergence: a real
        eigenvalue passes zero.  Fold: the equilibrium ends and another takes over.
    direction : "loss" or "regain"
    unstable : (int, int)
        Number of growing modes below and above the value.
    """

    value: float
    frequency: float
    kind: str
    direction: str
    unstable: tuple[int, int]


def stability_changes(model: Any, parameter: str, bounds: Any) -> tuple[StabilityChange, ...]:
    """Every change of stability of the sliding equilibrium as a parameter grows.

    The range is scanned, more finely where growth rates come near zero or two eigenvalues near each other,
    down to some 1e-9 of it; each change is then solved for to rounding.

    Parameters
    ----------
    model : SliderOnBelt or HybridAutomaton
    parameter : str
    bounds : (float, float)

    Returns
    -------
    tuple of StabilityChange
        By ascending value.

    Raises
    ------
    ValueError
        For an unknown parameter, or bounds that are none or break its rule.

    Examples
    --------
    >>> import frictionlab as fl
    >>> [f"{c.kind} at {c.value:.5f}" for c in fl.stability_changes(fl.SliderOnBelt(), "mu_k", (0, 3))]
    ['flutter at 1.51378']
    """
    view = steady(model)
    low, high = check_bounds(view, parameter, bounds)
    return on_lines(view, parameter, (low, high), {})[0]


def critical_value(model: Any, parameter: str, bounds: Any) -> float | None:
    """The first value at which the sliding equilibrium loses stability as a parameter grows.

    None where that does not happen in the range: the equilibrium is stable throughout, or unstable from
    the start; :func:`stability_changes` and :func:`eigenvalues` tell which.

    Parameters
    ----------
    model : SliderOnBelt or HybridAutomaton
    parameter : str
    bounds : (float, float)

    Raises
    ------
    ValueError
        As :func:`stability_changes`.

    Examples
    --------
    >>> import frictionlab as fl
    >>> round(fl.critical_value(fl.SliderOnBelt(), "mu_k", bounds=(0, 4)), 8)
    1.51378354
    """
    return first_loss(stability_changes(model, parameter, bounds))


@dataclass(frozen=True, eq=False)
class CriticalCurve:
    """Critical values of one parameter against another.

    Parameters
    ----------
    model : Model or HybridAutomaton
    parameter, over : str
        The critical parameter, and the other one.
    at : array (N,)
        Values of `over`.
    values : array (N,)
        Critical values of `parameter`; NaN where there is none in the range.
    """

    model: Any
    parameter: str
    over: str
    at: Array
    values: Array


def critical_curve(model: Any, parameter: str, bounds: Any, *, over: tuple[str, Any]) -> CriticalCurve:
    """:func:`critical_value` for each value of another parameter, all at once.

    Parameters
    ----------
    model : SliderOnBelt or HybridAutomaton
    parameter : str
    bounds : (float, float)
    over : (str, array_like (N,))
        The other parameter and its values.

    Raises
    ------
    ValueError
        As :func:`stability_changes`, for both parameters.
    """
    view = steady(model)
    low, high = check_bounds(view, parameter, bounds)
    name, at = over[0], np.asarray(over[1], dtype=float).ravel()
    check_parameter(view, name, at.tolist())
    losses = map(first_loss, on_lines(view, parameter, (low, high), {name: at}))
    return CriticalCurve(
        model, parameter, name, at, np.array([np.nan if x is None else x for x in losses], dtype=float)
    )


def first_loss(changes: tuple[StabilityChange, ...]) -> float | None:
    """The value at which no growing mode becomes one."""
    return next((c.value for c in changes if c.unstable[0] == 0 and c.direction == "loss"), None)


def on_lines(
    view: Steady, parameter: str, bounds: tuple[float, float], fixed: Mapping[str, Array]
) -> list[tuple[StabilityChange, ...]]:
    """The changes on each of L lines, along which `parameter` varies and `fixed` (L,) do not."""
    count = max((len(column) for column in fixed.values()), default=1)

    def evaluate(line: Indices, at: Array) -> Any:
        return view.spectra({**{name: column[line] for name, column in fixed.items()}, parameter: at})

    low, high = (np.full(count, bound) for bound in bounds)
    found = brackets(evaluate, low, high)
    changes = _described(evaluate, found, _roots(evaluate, found))
    return [tuple(c for c, line in zip(changes, found.line, strict=True) if line == i) for i in range(count)]


def _roots(evaluate: Evaluate, found: Brackets) -> Array:
    if not found.line.size:
        return np.zeros(0)
    shift = np.maximum(_neutral(evaluate, found, found.low), _neutral(evaluate, found, found.high))

    def rate(at: Array, line: Any, level: Any, shift: Any) -> Array:
        return level_of(evaluate(line.astype(int), at), level.astype(int)).real - shift

    solved = find_root(rate, (found.low, found.high), args=(found.line, found.level, shift))
    return np.asarray(solved.x, dtype=float)


def _neutral(evaluate: Evaluate, found: Brackets, at: Array) -> Array:
    """A rate that tells growth from none where nothing is damped, since zero does not; else zero."""
    spectra = evaluate(found.line, at)
    bound = NEUTRAL * np.abs(spectra).max(axis=1)
    return np.where(np.abs(level_of(spectra, found.level).real) < bound, bound, 0.0)


def level_of(spectra: Any, level: Indices) -> Any:
    """The eigenvalue with the `level`-th largest growth rate of each row."""
    return np.take_along_axis(spectra, level[:, None], axis=1)[:, 0]


def _described(evaluate: Evaluate, found: Brackets, roots: Array) -> list[StabilityChange]:
    if not found.line.size:
        return []
    before, at, after = (evaluate(found.line, p) for p in (found.low, roots, found.high))
    undamped = _neutral(evaluate, found, found.low) + _neutral(evaluate, found, found.high) > 0
    growing = np.where((before.real.max(axis=1) > after.real.max(axis=1))[:, None], before, after)
    # Without damping all growth rates are zero at the root: the growing side tells which mode it is.
    critical = level_of(np.where(undamped[:, None], growing, at), found.level)
    jumps = ~undamped & (np.abs(critical.real) > JUMP * np.abs(at).max(axis=1))
    return [
        StabilityChange(
            float(root),
            float(abs(value.imag) / (2 * np.pi)),
            "fold" if jump else ("flutter" if value.imag else "divergence"),
            "loss" if a < b else "regain",
            (a, b),
        )
        for root, value, jump, a, b in zip(roots, critical, jumps, _growing(before), _growing(after))
    ]


def _growing(spectra: Any) -> list[int]:
    return ((growth(spectra) > 0) & (spectra.imag >= 0)).sum(axis=1).tolist()
