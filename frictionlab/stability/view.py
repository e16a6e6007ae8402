"""The one way in: a model or an automaton becomes its steady motion."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionlab.components.names import did_you_mean
from frictionlab.components.validation import checked
from frictionlab.models import Model, SliderOnBelt
from frictionlab.models.namespace import about_all

from .automata import steady_state_of
from .sliding import steady_sliding
from .steady import Steady


def steady(model: Any) -> Steady:
    """The steady motion of a model, or of an automaton.

    Raises
    ------
    TypeError
        If it is neither.
    """
    if isinstance(model, SliderOnBelt):
        return steady_sliding(model)
    return steady_state_of(model)


def check_parameter(view: Steady, name: Any, values: Sequence[float]) -> None:
    """Refuse an unknown parameter, and values that break its own rule.

    Rules between parameters (mu_s is at least mu_k) do not matter here: no steady motion depends on both.
    """
    if name not in view.parameters:
        raise ValueError(f"no parameter is called {name!r}: {did_you_mean(name, view.parameters)}")
    if isinstance(view.model, Model):
        about = about_all(type(view.model), view.model.components)[name]
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
    check_parameter(view, name, at.tolist())
    return at


def check_bounds(view: Steady, name: Any, bounds: Any) -> tuple[float, float]:
    """Two values of a parameter, in ascending order."""
    try:
        low, high = (float("nan") if isinstance(b, str) else float(b) for b in bounds)
    except (TypeError, ValueError):
        low = high = float("nan")
    if not low < high:
        raise ValueError(f"bounds must be two numbers in ascending order, got {bounds!r}: give (low, high)")
    check_parameter(view, name, (low, high))
    return low, high
