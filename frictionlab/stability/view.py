"""The one way in: a model or an automaton becomes its steady motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionlab.components.names import did_you_mean
from frictionlab.components.validation import checked
from frictionlab.models import Model
from frictionlab.models.namespace import about_all

from .automata import steady_state_of
from .equilibria import Equilibrium, equilibria
from .sliding import steady_sliding
from .statics import by_gap
from .steady import Steady

SAME = 1e-12  # share of a coordinate: an equilibrium computed again is the same but for rounding


def steady(model: Any, equilibrium: Equilibrium | None = None) -> Steady:
    """The steady motion of a model, or of an automaton: the usual one, or that of one of its equilibria.

    Raises
    ------
    TypeError
        If it is neither.
    ValueError
        If the equilibrium is none of the model.
    """
    near = None if equilibrium is None else _checked(model, equilibrium)
    if by_gap(model):
        return steady_sliding(model, near)
    return steady_state_of(model, near)


def _checked(model: Any, equilibrium: Any) -> NDArray[np.float64]:
    """The coordinates of one of the model's equilibria, pressed if it is a contact's."""
    known = equilibria(model)
    if not isinstance(equilibrium, Equilibrium) or not any(_same(e, equilibrium) for e in known):
        raise ValueError(
            f"equilibrium must be one of the {len(known)} of the model, got {equilibrium!r}: "
            "take one from equilibria(model)"
        )
    if by_gap(model) and not equilibrium.normal_force > 0:
        raise ValueError(
            f"equilibrium must have F_N > 0, got {equilibrium.normal_force:.4g} N: there is no contact"
        )
    return equilibrium.q


def _same(one: Equilibrium, other: Equilibrium) -> bool:
    return one.q.shape == other.q.shape and np.allclose(one.q, other.q, rtol=SAME, atol=0.0)


def check_parameter(model: Any, known: Mapping[str, float], name: Any, values: Sequence[float]) -> None:
    """Refuse an unknown parameter, and values that break its own rule.

    Rules between parameters (mu_s is at least mu_k) do not matter here: no steady motion depends on both.
    """
    if name not in known:
        raise ValueError(f"no parameter is called {name!r}: {did_you_mean(name, known)}")
    if isinstance(model, Model):
        about = about_all(type(model), model.components)[name]
        for value in values:
            checked(name, value, about)


def path_of(view: Steady, name: Any, values: Any) -> NDArray[np.float64]:
    """Values (N,) of a parameter that keep to its rule, one at least."""
    try:
        at = np.atleast_1d(np.asarray(values, dtype=float)).ravel()
    except (TypeError, ValueError):
        at = np.empty(0)
    if not len(at):
        raise ValueError(f"values must be one number or more, got {values!r}: give those of {name}")
    check_parameter(view.model, view.parameters, name, at.tolist())
    return at


def check_bounds(model: Any, known: Mapping[str, float], name: Any, bounds: Any) -> tuple[float, float]:
    """Two values of a parameter, in ascending order."""
    try:
        low, high = (float("nan") if isinstance(b, str) else float(b) for b in bounds)
    except (TypeError, ValueError):
        low = high = float("nan")
    if not low < high:
        raise ValueError(f"bounds must be two numbers in ascending order, got {bounds!r}: give (low, high)")
    check_parameter(model, known, name, (low, high))
    return low, high
