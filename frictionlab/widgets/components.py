"""Controls that exchange components: a switch for each nonlinearity, and the impact law."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import ipywidgets

from frictionlab.components.component import Component
from frictionlab.components.impact import PlasticImpact, RestitutionImpact
from frictionlab.models.nonlinearities import without

from .sliders import dressed

IMPACTS: Mapping[str, Component] = MappingProxyType(
    {
        "plastic, Eq. (13)": PlasticImpact("material"),
        "plastic, full gap rate": PlasticImpact("full"),
        "restitution": RestitutionImpact(),
    }
)


class ComponentControls:
    """Checkboxes and a choice; what is not chosen here comes from the model.

    Attributes
    ----------
    switches : dict of str to Checkbox
        One for each of the model's `nonlinearities`.
    impact : Dropdown or None
    """

    def __init__(self, model: Any) -> None:
        self._model = model
        self._full = _with_all(model)
        found = model.nonlinearities
        self.switches = {
            name: _switch(name, one.about, not one.missing(model)) for name, one in found.items()
        }
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
        chosen: dict[str, Any] = {}
        if self.impact:
            chosen["impact"] = self.impact.value
        off = [name for name, switch in self.switches.items() if not switch.value]
        found = self._model.nonlinearities
        for name in found:
            if name not in off:
                chosen |= self._full.get(name, {})
        # What the model lacks from the start it lacks by its own component.
        lacking = {name for name in off if found[name].missing(self._model)}
        chosen |= without(self._model, tuple(name for name in off if name not in lacking))
        return self._model.replace(**chosen)


def _with_all(model: Any) -> dict[str, dict[str, Any]]:
    """What gives a model each of the nonlinearities that it lacks: what models of its class have."""
    usual = type(model)()
    lacking = {name: one for name, one in model.nonlinearities.items() if one.missing(model)}
    return {name: {key: getattr(usual, key) for key in one.without(model)} for name, one in lacking.items()}


def _switch(name: str, text: str, on: bool) -> Any:
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
