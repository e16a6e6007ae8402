"""The states of dynamic friction laws where a run begins.

They are zero where the contact is lost and the law returns them to zero; that of an elastic-plastic law is
within its limit.  An end state of a run with other parameters may be beyond: as the limit falls the contact
yields, so it begins at the limit.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionlab.components.component import StructureKey
from frictionlab.lazy_names import sympy
from frictionlab.models.kept_structures import derivations_of
from frictionlab.tape.formulas import Formulas, formulas_of, kept_formulas

from .mechanics import Friction

if TYPE_CHECKING:
    from frictionlab.models.mechanical.equations_of_motion import LagrangeSystem
    from frictionlab.models.mechanical.mechanical_model import MechanicalModel
    from frictionlab.models.model import MovingSystem

    LawsInMotion = MechanicalModel | MovingSystem

Array = NDArray[np.float64]
LIMIT_RTOL = 1e-6  # share of its limit by which a state that follows it may differ from it by rounding


class StatesOfLaws(NamedTuple):
    """What is known of each contact with a dynamic law where a run begins.

    Formulas of states and parameters give for each contact a number that is negative where it is lost, and
    the limits of its states if they have any.
    """

    known: Sequence[dict[str, Any]] = ()
    formulas: Formulas | Any = None
    parameters: tuple[str, ...] = ()


def with_law_states(
    model: LawsInMotion, start: Array, limited: Callable[[LawsInMotion, str, float, float], float]
) -> Array:
    """An initial state with zeros for the states of contacts that are lost, where these return to zero.

    The state of an elastic-plastic law is `limited`: `within_limit` refuses one beyond the limit,
    `carried_to_limit` takes the limit.
    """
    known, formulas, names = model.states_of_laws()
    if not any(start[place] for about in known for place in about["places"]):
        return start
    values = model.parameters
    numbers = formulas.numbers(*map(float, start), *(values[name] for name in names)).tolist()
    start = start.copy()
    for about in known:
        touching, *limits = (numbers.pop(0) for _ in range(1 + about["limits"]))
        if about["lost"] and touching < 0:
            start[about["places"]] = 0.0
            continue
        for place, name, limit in zip(about["places"], about["names"], limits):
            start[place] = limited(model, name, float(start[place]), limit)
    return start


def carried_to_limit(model: LawsInMotion, name: str, value: float, limit: float) -> float:
    """The state in which a run with other values of parameters has ended, yielded to the limit."""
    return min(max(value, -limit), limit)


def within_limit(model: LawsInMotion, name: str, value: float, limit: float) -> float:
    """The state itself; raises ValueError where it is beyond the limit."""
    if abs(value) > (1 + LIMIT_RTOL) * max(limit, 0.0):
        raise ValueError(
            f"x0 of {type(model).__name__} must have {name} within the limit of its friction law, {limit:g} "
            f"here, got {value:g}: the contact slips at the limit; give a smaller {name}"
        )
    return value


@cache
def states_of_laws(key: StructureKey) -> StatesOfLaws:
    """What a run of a model of this structure begins with."""
    derivations = derivations_of(key)

    def of_contacts() -> list[tuple[dict[str, Any], tuple[Any, ...]]]:
        from .equations_of_motion import system_of

        return contacts_with_states(system_of(key))

    def derive() -> Formulas:
        from frictionlab.models.symbols import parameter_symbols

        from .equations_of_motion import system_of

        inputs = [*system_of(key).states, *parameter_symbols(key)]
        return formulas_of(inputs, [one for _, some in of_contacts() for one in some])

    known = derivations.value("states of laws", lambda: [about for about, _ in of_contacts()])
    return StatesOfLaws(known, kept_formulas(derivations, "states of laws", derive), key.parameters)


def contacts_with_states(system: LagrangeSystem) -> list[tuple[dict[str, Any], tuple[Any, ...]]]:
    """What is known of each contact with a dynamic law, and expressions of the numbers that are asked for."""
    from .dynamic_laws import limits_of_states, returns_to_zero

    contacts = []
    order = [str(one) for one in system.states]
    for contact in system.mechanics.contacts:
        states = system.law_states(contact)
        if not isinstance(contact, Friction) or not states:
            continue
        limits, names = limits_of_states(contact), [str(one) for one in states]
        about = {
            "names": names,
            "places": [order.index(name) for name in names],
            "lost": "separation" in contact.modes and returns_to_zero(contact, states),
            "limits": len(limits),
        }
        touching = contact.penetration
        if touching is None:
            touching = contact.pressing
        elif "relaxation" in contact.modes:
            touching = sympy.Min(touching, contact.pressing)
        contacts.append((about, (touching, *limits)))
    return contacts
