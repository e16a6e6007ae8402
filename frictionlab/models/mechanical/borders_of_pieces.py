"""Whether laws in pieces are laws at the values of a model's parameters: their borders ascend, and energies
do not jump there.

The force of an energy that jumps would be an impulse at the border, which no flow has.  Both sides are
evaluated at places on the border, to which Newton's method leads from scattered ones.
"""

from __future__ import annotations

from functools import cache
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from frictionlab.automaton.hybrid_automaton import module_of_pieces
from frictionlab.components.component import StructureKey
from frictionlab.models.kept_structures import derivations_of
from frictionlab.models.symbols import gradient, parameter_symbols

from .masses import SEED

if TYPE_CHECKING:
    from frictionlab.models.mechanical.mechanical_model import MechanicalModel
    from frictionlab.tape.formulas import Formulas

SIZES = np.geomspace(1e-3, 1.0, 8)  # of the places from which the search for borders starts
STEPS_TO_BORDER = 20  # of Newton's method
ON_BORDER_RTOL = 1e-12  # share of the states within which a place is on a border
JUMP_RTOL = 1e-12  # share of the energy at the places: less is rounding


def check_borders(model: MechanicalModel) -> None:
    """Raise ValueError where the borders of a law in pieces do not ascend, or an energy jumps at one."""
    if module_of_pieces() is None:
        return
    _check_ascending(model)
    for border in _borders_of_energies(model.structure_key):
        _check_continuous(model, border)


def _check_ascending(model: MechanicalModel) -> None:
    pairs, formulas = _neighbours(model.structure_key)
    if formulas is None:
        return
    values = model.parameters
    numbers = formulas.numbers(*(values[name] for name in model.structure_key.parameters)).tolist()
    for (x, low, high), below, above in zip(pairs, numbers[::2], numbers[1::2], strict=True):
        if not below <= above:
            raise ValueError(
                f"borders of a law in pieces of {type(model).__name__} must ascend, got {x} = {low}, which "
                f"is {below:g}, before {high}, which is {above:g}: change the parameters in them, or refuse "
                "such values by fl.parameter(..., minimum=0.0)"
            )


@cache
def _neighbours(key: StructureKey) -> tuple[list[Any], Formulas | None]:
    """Neighbouring borders that depend on parameters: x and both as texts, and their values as formulas."""
    found: list[tuple[Any, Any, Any]] = []

    def derive() -> bool:
        from .equations_of_motion import system_of
        from .modes import expressions_of

        system, pieces = system_of(key), module_of_pieces()
        for division in pieces.divisions_of(system.states, expressions_of(system)):
            for low, high in pairwise(division.borders):
                there = low.free_symbols | high.free_symbols
                if there and there.isdisjoint(system.states):
                    found.append((division.x, low, high))
        return bool(found)

    if not derivations_of(key).value("borders of laws", derive) or not (found or derive()):
        return [], None
    from frictionlab.tape.formulas import formulas_of

    sides = [side for _, low, high in found for side in (low, high)]
    return [tuple(map(str, one)) for one in found], formulas_of(parameter_symbols(key), sides)


class EnergyBorder(NamedTuple):
    """A border of an energy: their names, and formulas of the states and the parameters: what is zero on the
    border, the energy above and below it, then the slopes by the coordinates of what is zero."""

    energy: str
    border: str
    states: int
    formulas: Formulas


@cache
def _borders_of_energies(key: StructureKey) -> list[EnergyBorder]:
    """The borders between places at which the energies of a structure have functions in pieces."""
    known: list[EnergyBorder] = []

    def derive() -> bool:
        from frictionlab.tape.formulas import formulas_of

        from .equations_of_motion import system_of

        system, pieces = system_of(key), module_of_pieces()
        inputs = [*system.states, *parameter_symbols(key)]
        for name, energy in (("potential", system.mechanics.stored), ("kinetic", system.mechanics.kinetic)):
            for x, border in pieces.borders_in(energy):
                slopes = gradient(x - border, system.q)
                above, below = (pieces.beside_border(energy, x, border, side) for side in (1, 0))
                if any(slopes) and above != below:
                    formulas = formulas_of(inputs, [x - border, above, below, *slopes])
                    known.append(EnergyBorder(name, f"{x} = {border}", len(system.states), formulas))
        return bool(known)

    if derivations_of(key).value("borders of energies", derive) and not known:
        derive()
    return known


def _check_continuous(model: MechanicalModel, border: EnergyBorder) -> None:
    n, values = len(model.coordinates), [model.parameters[name] for name in model.structure_key.parameters]
    place = np.random.default_rng(SEED).normal(size=(border.states, len(SIZES))) * SIZES
    size = 0.0
    on = np.zeros(place.shape[1], dtype=bool)
    below = above = on.astype(float)
    with np.errstate(all="ignore"):
        for _ in range(STEPS_TO_BORDER):
            rows = np.broadcast_arrays(*border.formulas.arrays(*place, *values), place[0])[:-1]
            missed, above, below, slopes = *rows[:3], np.array(rows[3:])
            size = max(size, np.nanmax(np.abs([below, above]), initial=0.0))
            step = slopes * missed / (slopes**2).sum(axis=0)
            place[:n] -= step
            on = np.abs(step).max(axis=0) <= ON_BORDER_RTOL * np.abs(place[:n]).max(axis=0)
            if on.all():
                break
        jumps = np.flatnonzero(on & (np.abs(above - below) > JUMP_RTOL * size))
    if len(jumps):
        i = jumps[-1]
        raise ValueError(
            f"the {border.energy} energy of {type(model).__name__} must be continuous, got {below[i]:.6g} J "
            f"below and {above[i]:.6g} J above the border {border.border}: an impulse would act there, which "
            "no run has; add a constant to one side so that both agree, or write a force that jumps as a load"
        )
