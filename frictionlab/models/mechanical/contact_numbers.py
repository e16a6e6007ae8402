"""What the contacts of a model must be like at the values of its parameters.

A normal force that is given by parameters alone must not pull; and what is to slide in one direction only
needs a belt that moves, by which friction has its direction.
"""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

from frictionlab.automaton.straight_line import MATH, StraightLine, straight_line_data
from frictionlab.lazy_names import sympy
from frictionlab.models.serialisation import Structure, derivations_of, structure_of_component

from .mechanics import Friction


class ContactNumbers(NamedTuple):
    """A contact with friction at some values of the parameters.

    Parameters
    ----------
    speed : float
        Speed of the belt (m/s), at the origin and where the phase is zero.
    press : float or None
        F_N (N) where it depends on parameters only.
    """

    speed: float
    press: float | None = None


def numbers_of_contacts(model: Any) -> list[ContactNumbers | None]:
    """These numbers of each contact of a model; None for a stop."""
    key = structure_of_component(model)
    values = [model.parameters[name] for name in key.parameters]
    return [None if function is None else ContactNumbers(*function(*values)) for function in _formulas(key)]


@cache
def _formulas(key: Structure) -> list[Any]:
    kept = derivations_of(key, key.parameters)
    known = kept.get("contacts")
    if known is None:
        known = _derived_formulas(key)
        if not any(map(callable, known)):
            kept.keep("contacts", known)
    return [StraightLine(one, MATH) if isinstance(one, dict) else one for one in known]


def _derived_formulas(key: Structure) -> list[Any]:
    from frictionlab.models.symbols import parameter_symbols

    from .equations_of_motion import system_of

    found, rows = system_of(key), []
    for contact in found.mechanics.contacts:
        if not isinstance(contact, Friction):
            rows.append(None)
            continue
        formulas = [found.speed_at_origin(contact)]
        if contact.penetration is None:  # else F_N is a law's, which is not asked here
            press = sympy.sympify(contact.pressing, strict=True)
            formulas += [] if found.varies(press) else [press]
        function = sympy.lambdify(parameter_symbols(key), formulas, "math")
        rows.append(straight_line_data(function, MATH) or function)
    return rows


def check_contacts(model: Any) -> None:
    """Raise ValueError where a given normal force pulls."""
    for i, one in enumerate(numbers_of_contacts(model), 1):
        if one is not None and one.press is not None and one.press < 0:
            raise ValueError(
                f"the normal force of contact {i} of {type(model).__name__} must be at least 0, got "
                f"{one.press:g}: a contact does not pull; fl.parameter(..., minimum=0.0) refuses it at once"
            )


def check_sliding(model: Any) -> None:
    """Raise ValueError where a contact would have no direction if it could only slide."""
    for i, one in enumerate(numbers_of_contacts(model), 1):
        if one is not None and one.speed == 0:
            raise ValueError(
                f"contact {i} of {type(model).__name__} must rub a belt that moves where it only slides, got "
                "one at rest, which gives friction no direction: give the belt a speed, or keep stick, as "
                "with interface=StickSlip()"
            )
