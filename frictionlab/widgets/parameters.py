"""Sliders for all parameters of a model: the most used ones in sight, the others in an accordion."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import ipywidgets

from frictionlab.models.namespace import about_all, owners

from .sliders import slider, unrounded

OPERATION = "F", "v"  # of the model's own parameters those that one changes on a running system
FEW = 12  # parameters of a model all of which are in sight
FOLDED = "structure"


class ParameterControls:
    """One slider for each parameter; those of a component that is not there are hidden, and keep their value.

    Attributes
    ----------
    sliders : dict of str to FloatSlider or FloatLogSlider
        By the parameter's name.
    """

    def __init__(self, model: Any, changed: Callable[[Any], None]) -> None:
        self._changed = changed
        self.sliders: dict[str, Any] = {}
        self._start: dict[str, float] = {}
        self._shown: tuple[str, ...] = ()
        layout = ipywidgets.Layout(flex_flow="row wrap")
        self._used, self._rest = ipywidgets.Box(layout=layout), ipywidgets.Box(layout=layout)
        self._more = ipywidgets.Accordion([self._rest], titles=(FOLDED,))
        self._more.add_class("fl-structure")
        self.widget = ipywidgets.VBox([self._used, self._more])
        self.show(model)

    def show(self, model: Any) -> None:
        """Have sliders for the parameters of this model in sight; does nothing where they are."""
        names = tuple(model.parameters)
        if names == self._shown:
            return
        about = about_all(type(model), model.components)
        for name in names:
            if name not in self.sliders:
                self._start[name] = model.parameters[name]
                self.sliders[name] = slider(name, about[name], model.parameters[name])
                self.sliders[name].observe(self._changed, names="value")
        used = most_used(model)
        self._used.children = [self.sliders[name] for name in used]
        self._rest.children = [self.sliders[name] for name in names if name not in used]
        self._more.layout.display = "" if self._rest.children else "none"
        self._shown = names

    def values(self, model: Any) -> dict[str, float]:
        """What the sliders say about the parameters of this model."""
        self.show(model)
        return {name: unrounded(self.sliders[name].value, self._start[name]) for name in model.parameters}

    def reset(self) -> None:
        """Back to the values of the start; sliders that came later to their law's."""
        for name, control in self.sliders.items():
            control.value = self._start[name]

    def close(self) -> None:
        """Forget the sliders."""
        for control in self.sliders.values():
            control.close()


def most_used(model: Any) -> list[str]:
    """Parameters of the friction law, of operation, then of the other components; all where they are few."""
    owner = owners(type(model), model.components)
    if len(owner) <= FEW:
        return list(owner)
    friction = [name for name, role in owner.items() if role == "friction"]
    laws = [name for name, role in owner.items() if role and role != "friction"]
    return [*friction, *(name for name in OPERATION if name in owner), *laws]
