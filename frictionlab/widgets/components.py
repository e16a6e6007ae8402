"""Controls that exchange components: a switch for each nonlinearity, and the impact law."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import ipywidgets

from frictionlab.components.component import Component
from frictionlab.components.contact import LinearContact
from frictionlab.components.geometry import FixedLoad
from frictionlab.components.impact import PlasticImpact, RestitutionImpact
from frictionlab.components.interface import SlidingOnly
from frictionlab.models.toggles import replacements

from .sliders import dressed

# Name of the nonlinearity -> role of the component that has it, and what the switch is called.
SWITCHES: Mapping[str, tuple[str, str]] = MappingProxyType(
    {
        "cubic": ("contact", "cubic contact"),
        "nonsmooth": ("interface", "stick, slip, separation"),
        "geometry": ("geometry", "moving load, tilting belt"),
    }
)
IMPACTS: Mapping[str, Component] = MappingProxyType(
    {
        "plastic, Eq. (13)": PlasticImpact("material"),
        "plastic, full gap rate": PlasticImpact("full"),
        "restitution": RestitutionImpact(),
    }
)
LEFT_OUT = LinearContact, SlidingOnly, FixedLoad


class ComponentControls:
    """Checkboxes and a choice; what is not chosen here comes from the model.

    Attributes
    ----------
    switches : dict of str to Checkbox
        "cubic", "nonsmooth", "geometry", those that the model has.
    impact : Dropdown or None
    """

    def __init__(self, model: Any) -> None:
        self._model = model
        self._full = {role: _full(model, role) for role in model.roles}
        has = {name: role for name, (role, _) in SWITCHES.items() if role in model.roles}
        self.switches = {name: _switch(name, not _left_out(model, role)) for name, role in has.items()}
        self.impact = _impact(model.impact) if "impact" in model.roles else None

    @property
    def controls(self) -> dict[str, Any]:
        """All of them by name."""
        switches = {f"switch-{name}": switch for name, switch in self.switches.items()}
        return switches | ({"impact": self.impact} if self.impact else {})

    def model(self) -> Any:
        """The model with the components chosen, and their own parameters.

        Raises
        ------
        ValueError
            If a law cannot do without its nonlinearity.
        """
        chosen = dict(self._full)
        if self.impact:
            chosen["impact"] = self.impact.value
        off = [name for name, switch in self.switches.items() if not switch.value]
        # What the model lacks from the start it lacks by its own component.
        lacking = [name for name in off if _left_out(self._model, SWITCHES[name][0])]
        chosen |= {SWITCHES[name][0]: getattr(self._model, SWITCHES[name][0]) for name in lacking}
        chosen |= replacements(self._model, tuple(name for name in off if name not in lacking))
        return self._model.replace(**chosen)


def _left_out(model: Any, role: str) -> bool:
    return isinstance(getattr(model, role), LEFT_OUT)


def _full(model: Any, role: str) -> Component:
    """The model's component; where that lacks the nonlinearity, the one that models of its class have."""
    return getattr(type(model), role) if _left_out(model, role) else getattr(model, role)


def _switch(name: str, on: bool) -> Any:
    text = SWITCHES[name][1]
    switch = ipywidgets.Checkbox(on, indent=False)
    switch = dressed(switch, f"switch-{name}", text, f"switches a nonlinearity on and off: {text}")
    switch.layout.width = "auto"
    return switch


def _impact(own: Component) -> Any:
    options = dict(IMPACTS)
    known = {type(law): text for text, law in IMPACTS.items() if type(law) is not PlasticImpact}
    text = known.get(type(own), next((t for t, law in IMPACTS.items() if law == own), type(own).__name__))
    options[text] = own
    return dressed(
        ipywidgets.Dropdown(options=list(options.items()), value=own),
        "impact",
        "impact law",
        "what the slider's velocity is after it lands on the belt again",
    )
