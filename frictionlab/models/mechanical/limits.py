"""What energies and contacts say of parameters without bounds: masses are above 0, dampers and given normal
forces at least 0.

Masses and contacts are checked with numbers by `masses.py` and `contact_numbers.py`, dampers here.  A page,
which has no Python, checks the same by the formulas of :func:`limits_of`.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple

from frictionlab.components.component import StructureKey
from frictionlab.models.kept_structures import derivations_of
from frictionlab.models.symbols import parameter_symbols, structure_values, symbol
from frictionlab.tape.formulas import Formulas, formulas_of, kept_formulas

from .contact_numbers import NORMAL_FORCE, given_normal_forces
from .masses import KINETIC, known_signs

if TYPE_CHECKING:
    from frictionlab.models.mechanical.mechanical_model import MechanicalModel

DISSIPATION = (
    "dissipation of {of} must not be negative for any motion, and the damper of {name!r} is {value}: write a "
    "force that drives as a load; fl.parameter(..., minimum=0.0) refuses it at once"
)


class Limit(NamedTuple):
    """A formula of parameters that must be above 0, or at least 0.

    Parameters
    ----------
    value : Expr
    above : bool
        Whether 0 itself is refused.
    words : str
        The message, with "{value}" where the value stands, and with the names of parameters in braces.
    """

    value: Any
    above: bool
    words: str


def check_dampers(model: MechanicalModel) -> None:
    """Raise ValueError where a damper is negative, at the values of the model's parameters."""
    names, formulas = _dampers(model.structure_key)
    if not names:
        return
    for name, value in zip(names, formulas.numbers(*structure_values(model)).tolist(), strict=True):
        if value < 0:
            raise ValueError(DISSIPATION.format(of=type(model).__name__, name=name, value=f"{value:g}"))


@cache
def _dampers(key: StructureKey) -> tuple[list[str], Formulas]:
    """The coordinates whose dampers may be negative, and the dampers as formulas of the parameters."""
    derivations = derivations_of(key)
    names = derivations.value("dampers", lambda: list(_uncertain_dampers(key)))

    def derive() -> Formulas:
        return formulas_of(parameter_symbols(key), list(_uncertain_dampers(key).values()))

    return names, kept_formulas(derivations, "dampers", derive)


def _uncertain_dampers(key: StructureKey) -> dict[str, Any]:
    from .equations_of_motion import system_of

    system = system_of(key)
    dissipation = system.mechanics.dissipation
    signs, parameters = known_signs(key), set(parameter_symbols(key))
    if not dissipation or parameters.isdisjoint(dissipation.free_symbols):
        return {}
    dampers = {q.name: dissipation.diff(v, 2) for q, v in zip(system.q, system.v, strict=True)}
    return {
        name: damper
        for name, damper in dampers.items()
        if damper.free_symbols <= parameters and not damper.xreplace(signs).is_nonnegative
    }


def limits_of(model: MechanicalModel) -> Iterator[Limit]:
    """What masses, dampers and given normal forces ask of parameters whose bounds do not ensure it."""
    from .equations_of_motion import system_of

    key, of = model.structure_key, type(model).__name__
    system, signs, parameters = system_of(key), known_signs(key), parameter_symbols(key)
    within = set(parameters)
    for i, q in enumerate(system.q):
        mass = system.mass[i, i]
        if mass.free_symbols <= within and not mass.xreplace(signs).is_positive:
            values = ", ".join(
                f"{name} = {{{name}}}" for name in key.parameters if symbol(name) in mass.free_symbols
            )
            got = f"the mass of {q.name!r} is {{value}}"
            yield Limit(mass, True, KINETIC.format(of=of, got=got, at=f" at {values}"))
    for name, damper in _uncertain_dampers(key).items():
        yield Limit(damper, False, DISSIPATION.format(of=of, name=name, value="{value}"))
    for number, press in given_normal_forces(key):
        if not press.xreplace(signs).is_nonnegative:
            yield Limit(press, False, NORMAL_FORCE.format(number=number, of=of, value="{value}"))
