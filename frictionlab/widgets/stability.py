"""`fl.explore_stability`: eigenvalues, and how far the model is from the loss of stability."""

from __future__ import annotations

from typing import Any

from .explorer import Explorer, start_of
from .panels.critical import Critical
from .panels.eigenvalues import eigenvalues
from .settings import settings_of
from .sliders import known


def explore_stability(model: Any = None, parameter: str = "mu_k", over: str = "F") -> Explorer:
    """Move a model through a plane of two parameters and watch its eigenvalues.

    Sliders move it, or a click into the plane.

    Parameters
    ----------
    model : Model or None
        Where to start; None takes the paper's.
    parameter, over : str
        The parameter whose critical value is drawn, against the other one.

    Returns
    -------
    Explorer

    Raises
    ------
    TypeError
        If it is no model.
    ValueError
        For an unknown parameter, or twice the same.

    Examples
    --------
    >>> import frictionlab as fl
    >>> explorer = fl.explore_stability()
    >>> explorer.controls["mu_k"].value = 1.6
    >>> explorer.result.eigenvalues.stable
    False
    """
    model = start_of(model)
    for name in (parameter, over):
        known(model, name)
    if parameter == over:
        raise ValueError(f"over must be another parameter than {parameter!r}: take for example 'F'")
    panels = {"eigenvalues": eigenvalues, "critical": Critical(model, parameter, over)}
    return Explorer(settings_of(model), panels)
