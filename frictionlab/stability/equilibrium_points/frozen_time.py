"""The automaton of a model that depends on time, with time frozen: a parameter in place of the state t.

A belt that brakes, or a preload that grows, has no equilibrium.  Where it changes slowly beside the
vibrations, equilibria and eigenvalues at each instant tell when these begin to grow.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import Any

from frictionlab.automaton import HybridAutomaton, Mode
from frictionlab.automaton.hybrid_automaton import WholeAutomaton
from frictionlab.automaton.modes_on_demand import ModesOnDemand
from frictionlab.models.model import Model, ModelOrAutomaton, automaton_of
from frictionlab.presentation import TIME


class FrozenAutomaton(WholeAutomaton):
    """An automaton in which time is a parameter."""


def depends_on_time(model: ModelOrAutomaton) -> bool:
    """Whether a model has the time as a state, `q.t`."""
    if not isinstance(model, Model):
        return False
    automaton = automaton_of(model)
    clock = TIME in automaton.state_names[2 * automaton.coordinates :]
    return clock and TIME not in getattr(model, "states", ())


def automaton_at_rest(model: ModelOrAutomaton) -> HybridAutomaton:
    """The automaton whose equilibria are those of a model: on all sides of borders at once."""
    return automaton_of(model).whole


def refuse_time(model: ModelOrAutomaton, what: str) -> None:
    """Raise ValueError where a model depends on time, for `what` of it."""
    if depends_on_time(model):
        raise ValueError(
            f"{type(model).__name__} must not depend on the time q.t to have {what}: simulate its motion, "
            'ask root_locus(model, "t", times) for eigenvalues with time frozen at each of these times, or '
            "write what is periodic with q.phase"
        )


def is_sliding(model: ModelOrAutomaton) -> bool:
    """Whether equilibria are searched for in modes without constraints only, as those of models are."""
    return isinstance(model, (Model, FrozenAutomaton))


def frozen_in_time(model: Model) -> FrozenAutomaton:
    """The automaton of a model that depends on time, with time frozen at 0 s."""
    whole = automaton_of(model).whole
    place = whole.state_names.index(TIME)
    states = tuple(one for i, one in enumerate(whole.states) if i != place)
    modes = whole.modes if isinstance(whole.modes, ModesOnDemand) else tuple(whole.modes)
    parameters = {**whole.parameters, whole.states[place]: 0.0}
    return FrozenAutomaton(states, _frozen_modes(modes, place), parameters, whole.coordinates, whole.cyclic)


@lru_cache(maxsize=64)
def _frozen_modes(modes: Any, place: int) -> Any:
    if not isinstance(modes, ModesOnDemand):
        return tuple(_without_rate(mode, place) for mode in modes)

    def derive(combination: tuple[int, ...]) -> Mode:
        mode = modes.mode(combination)
        assert mode is not None  # it is allowed
        return _without_rate(mode, place)

    return ModesOnDemand(modes.parts, derive, modes.names)


def _without_rate(mode: Mode, place: int) -> Mode:
    return replace(mode, flow=(*mode.flow[:place], *mode.flow[place + 1 :]))
