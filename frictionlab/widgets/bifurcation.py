"""`fl.explore_bifurcation`: a diagram to zoom into, and the motion at a value of it."""

from __future__ import annotations

from typing import Any

from .explorer import Explorer, start_of
from .panels.diagram import Diagram
from .panels.phase import phase
from .panels.response import response
from .settings import settings_of
from .sliders import known


def explore_bifurcation(model: Any = None, parameter: str = "mu_k") -> Explorer:
    """Zoom into a bifurcation diagram, and see the motion at any value of the parameter.

    The range slider says what is looked at; values in between are computed when it gets narrower.  The
    parameter's own slider selects the value whose response is shown, and so does a click into the diagram.

    Parameters
    ----------
    model : Model or None
        None takes the paper's.
    parameter : str

    Returns
    -------
    Explorer

    Raises
    ------
    TypeError
        If it is no model.
    ValueError
        For an unknown parameter.

    Examples
    --------
    >>> import frictionlab as fl
    >>> explorer = fl.explore_bifurcation(fl.SliderOnBelt().without("geometry"))
    >>> explorer.controls["range"].value = (1.2, 1.5)
    >>> [round(float(x), 3) for x in explorer.picture.tiles["bifurcation"].ax.get_xlim()]
    [1.2, 1.5]
    """
    model = start_of(model)
    known(model, parameter)
    panels = {"bifurcation": Diagram(model, parameter), "response": response, "phase": phase}
    explorer = Explorer(settings_of(model), panels)
    for name, slider in explorer.parameters.sliders.items():
        # Another parameter means another diagram: it is computed when the slider is let go.
        slider.continuous_update = name == parameter
    return explorer
