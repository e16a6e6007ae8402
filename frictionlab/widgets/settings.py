"""The settings of an explorer: as data, as Python that recreates them, as JSON."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from typing import Any

import frictionlab
from frictionlab.analysis.motion_scales import rounded_period
from frictionlab.components.component import Component
from frictionlab.hybrid.methods.base import Method
from frictionlab.hybrid.methods.taylor import Taylor

SIMULATED_PERIODS, SHOWN_PERIODS = (
    200,
    10,
)  # of the model: simulated, and shown; 20 s and 1 s of the slider on a belt

# Under Eq. (13) flights of the slider that are shorter than a third of the distance between two samples are
# replaced by their limit: displacements are right to some 1e-5 of the motion, rates, which zigzag in flight,
# to less than a pixel, and it is ten times as fast.  The tolerance makes less than 1e-5 of the motion over
# 20 s, far less than a pixel; shorter series spare some 25 % where events leave them little time.
QUICK_METHOD = Taylor(tol=1e-7, chatter=4e-4)
PERIODICITY_TOLERANCE = 1e-10  # tolerance where it is told whether a motion repeats

WHAT_MOVES = "moving"  # shown: the last periods, or of a motion that has come to rest the whole of it

MAX_STEPS = 300_000  # 100 s of the paper's system with all its chatter have 200 000


@dataclass(frozen=True)
class Settings:
    """A model, how it is run, and what is shown of it.

    Parameters
    ----------
    model : Model
    t_end : float
        Seconds that are simulated.
    x0 : str or tuple of float
        As :func:`frictionlab.simulate` takes it.
    method : Method
    window : float, "moving" or None
        Seconds at the end that are shown; None shows the whole run, "moving" the last ten periods, or, where
        nothing moves in them, the run from its start until a bit after it came to rest.
    coordinate : str
        The coordinate of phase plane and spectrum.
    """

    model: Any
    t_end: float
    x0: str | tuple[float, ...]
    method: Method
    window: float | str | None
    coordinate: str


def default_settings(model: Any, method: Method = QUICK_METHOD) -> Settings:
    """The initial settings of an explorer; the length of a run follows from the model's own time scale."""
    period = rounded_period(model)
    return Settings(model, SIMULATED_PERIODS * period, "rest", method, WHAT_MOVES, model.coordinates[0])


def limit_steps(method: Method) -> Method:
    """The method with a cap on its steps, as a motion that grows without bounds takes ever shorter ones."""
    return replace(method, max_steps=MAX_STEPS) if isinstance(method, Taylor) else method


def tighten_tolerance(method: Method) -> Method:
    """The method with a tolerance small enough to recognise that a motion repeats."""
    return (
        replace(method, tol=min(method.tol, PERIODICITY_TOLERANCE)) if isinstance(method, Taylor) else method
    )


def python_snippet(settings: Settings) -> str:
    """Python code that recreates the model and the run."""
    start = settings.x0 if isinstance(settings.x0, str) else list(settings.x0)
    described = _with_package_prefix(f"{type(settings.model).__name__}, {settings.model!r}").partition(", ")[
        2
    ]
    arguments = f"model, {settings.t_end!r}, x0={start!r}{_method_argument(settings.method)}"
    run = f"run = fl.simulate({arguments})"
    return "\n".join(
        ["import frictionlab as fl", *_import_lines(settings.model), f"model = {described}", run]
    )


def to_json(settings: Settings) -> str:
    """Everything as JSON; ``fl.Model.from_dict(data["model"])`` gives the model again."""
    start = settings.x0 if isinstance(settings.x0, str) else list(settings.x0)
    data = {
        "model": settings.model.to_dict(),
        "t_end": settings.t_end,
        "x0": start,
        "method": settings.method.describe(),
        "window": settings.window,
        "coordinate": settings.coordinate,
    }
    return json.dumps(data, indent=1)


def _method_argument(method: Method) -> str:
    """The method as an argument, with what differs from its defaults."""
    usual = type(method)()
    differs = [f.name for f in fields(method) if getattr(method, f.name) != getattr(usual, f.name)]
    values = ", ".join(f"{name}={getattr(method, name)!r}" for name in differs)
    return "" if method == Taylor() else f", method=fl.{type(method).__name__}({values})"


def _with_package_prefix(text: str) -> str:
    """The text with fl. before every class of the package's own that is called in it."""
    return re.sub(r"\b([A-Z]\w*)\(", lambda m: f"fl.{m[0]}" if m[1] in frictionlab.__all__ else m[0], text)


def _import_lines(model: Any) -> Iterator[str]:
    """Import lines for laws that are not the package's own."""
    for cls in dict.fromkeys(_component_classes(model)):
        if cls.__name__ in frictionlab.__all__ and cls.__module__.startswith("frictionlab."):
            continue
        if cls.__module__ == "__main__":
            yield f"# run the cell that defines {cls.__name__} first"
        elif f"{cls.__name__}(" in repr(model):
            yield f"from {cls.__module__} import {cls.__name__}"


def _component_classes(component: Component) -> Iterator[type]:
    yield type(component)
    for value in getattr(component, "components", {}).values():
        yield from _component_classes(value)
