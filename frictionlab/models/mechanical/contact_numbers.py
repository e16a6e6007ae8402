"""What the contacts of a model must be like at the values of its parameters.

A normal force that is given by parameters alone must not pull; and what is to slide in one direction only
needs a belt that moves, by which friction has its direction.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from functools import cache
from itertools import islice
from typing import TYPE_CHECKING, Any, NamedTuple

from frictionlab.components.component import StructureKey, parameters_of
from frictionlab.lazy_names import sympy
from frictionlab.models.kept_structures import derivations_of

from .mechanics import Friction, Stop

if TYPE_CHECKING:
    from frictionlab.models.mechanical.mechanical_model import MechanicalModel
    from frictionlab.tape.formulas import Formulas

NORMAL_FORCE = (
    "the normal force of contact {number} of {of} must be at least 0, got {value}: a contact does not pull; "
    "fl.parameter(..., minimum=0.0) refuses it at once"
)


class ContactNumbers(NamedTuple):
    """A contact with friction at some values of the parameters.

    Parameters
    ----------
    speed : float
        Speed of the belt (m/s), at the origin and where the phase is zero; 0 in the plane.
    press : float or None
        F_N (N) where it depends on parameters only.
    """

    speed: float
    press: float | None = None


def numbers_of_contacts(model: MechanicalModel) -> list[ContactNumbers | None]:
    """These numbers of each contact of a model; None for a stop."""
    key = model.structure_key
    counts, formulas = _formulas(key)
    values = model.parameters
    numbers = iter(formulas.numbers(*(values[name] for name in key.parameters)).tolist())
    return [None if count == 0 else ContactNumbers(*islice(numbers, count)) for count in counts]


@cache
def _formulas(key: StructureKey) -> tuple[list[int], Formulas]:
    """How many numbers each contact has, none where it is a stop, and all of them as formulas."""
    # The command's help loads models, and no numpy.
    from frictionlab.models.symbols import parameter_symbols
    from frictionlab.tape.formulas import formulas_of, kept_formulas

    derivations = derivations_of(key)

    def derive() -> Formulas:
        return formulas_of(parameter_symbols(key), [one for some in _expressions(key) for one in some])

    counts = derivations.value("contacts", lambda: [len(some) for some in _expressions(key)])
    return counts, kept_formulas(derivations, "contacts", derive)


def _expressions(key: StructureKey) -> list[list[Any]]:
    from .equations_of_motion import system_of

    system, given = system_of(key), dict(given_normal_forces(key))
    speeds = [
        [sympy.S.Zero if contact.in_plane else system.speed_at_origin(contact)]
        if isinstance(contact, Friction)
        else []
        for contact in system.mechanics.contacts
    ]
    return [[*speed, given[i]] if i in given else speed for i, speed in enumerate(speeds, 1)]


def given_normal_forces(key: StructureKey) -> Iterator[tuple[int, Any]]:
    """The numbers of contacts, from 1, whose F_N depends on parameters only, and their F_N."""
    from .equations_of_motion import system_of

    system = system_of(key)
    for i, contact in enumerate(system.mechanics.contacts, 1):
        if isinstance(contact, Friction) and contact.penetration is None:  # else F_N is a law's
            press = sympy.sympify(contact.pressing, strict=True)
            if not system.varies(press):
                yield i, press


@cache
def _only_slide(key: StructureKey) -> tuple[bool, ...]:
    """Whether each contact slides in the direction that its belt gives, and in no other."""

    def only_slide() -> list[bool]:
        from .equations_of_motion import system_of

        contacts = system_of(key).mechanics.contacts
        return [isinstance(one, Friction) and "slip" in one.modes and not one.in_plane for one in contacts]

    return tuple(derivations_of(key).value("contacts that only slide", only_slide))


@cache
def turning_roles(key: StructureKey, rotational_outputs: tuple[str, ...]) -> dict[str, bool]:
    """Roles of the laws of contacts whose bodies turn, and whether they serve no others.

    A law serves the contacts in whose friction or normal force its parameters are.
    """

    def derive() -> dict[str, bool]:
        from frictionlab.models.symbolic_laws import symbolic_copy

        turns: dict[str, list[bool]] = {}
        for output, symbols in _laws_of_contacts(key):
            for role, law in symbolic_copy(key).components.items():
                if symbols & {*parameters_of(type(law))}:
                    turns.setdefault(role, []).append(output in rotational_outputs)
        return {role: all(found) for role, found in turns.items() if any(found)}

    return derivations_of(key).value("roles that turn", derive)


def _laws_of_contacts(key: StructureKey) -> Iterator[tuple[str, set[str]]]:
    """An output that moves as a contact's force does, and the parameters of the law of that force."""
    from .equations_of_motion import system_of

    contacts = system_of(key).mechanics.contacts
    for i, contact in enumerate(contacts, 1):
        number = f"_{i}" if len(contacts) > 1 else ""
        law = contact.friction if isinstance(contact, Stop) else getattr(contact, "law", None)
        if law is not None:
            yield f"friction_force{number}", _names(getattr(law, name) for name in parameters_of(type(law)))
        if not isinstance(contact, Stop):
            yield f"normal_force{number}", _names((contact.pressing, contact.damping))


def _names(expressions: Iterable[Any]) -> set[str]:
    return {one.name for each in expressions for one in sympy.sympify(each, strict=True).free_symbols}


def check_contacts(model: MechanicalModel) -> None:
    """Raise ValueError where a given normal force pulls, and where what only slides rubs a belt at rest."""
    key = model.structure_key
    counts, _ = _formulas(key)
    if any(_only_slide(key)):
        check_sliding(model, _only_slide(key))
    if max(counts, default=0) <= 1:  # no normal force is given
        return
    for i, one in enumerate(numbers_of_contacts(model), 1):
        if one is not None and one.press is not None and one.press < 0:
            words = NORMAL_FORCE.format(number=i, of=type(model).__name__, value=f"{one.press:g}")
            raise ValueError(words)


def check_sliding(model: MechanicalModel, which: Sequence[bool] | None = None) -> None:
    """Raise ValueError where a contact, or one of some, would have no direction if it could only slide."""
    contacts = numbers_of_contacts(model)
    for i, (one, slides) in enumerate(zip(contacts, which or [True] * len(contacts), strict=True), 1):
        if slides and one is not None and one.speed == 0:
            raise ValueError(
                f"contact {i} of {type(model).__name__} must rub a belt that moves where it only slides, got "
                "one at rest, or friction in the plane, which has no fixed direction: give the belt a speed, "
                "or keep stick, as with interface=StickSlipSeparation()"
            )
