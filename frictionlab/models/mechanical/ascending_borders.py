"""Whether the borders of laws in pieces ascend at the values of a model's parameters."""

from __future__ import annotations

from functools import cache
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from frictionlab.automaton.hybrid_automaton import module_of_pieces
from frictionlab.components.component import StructureKey
from frictionlab.models.kept_structures import derivations_of

if TYPE_CHECKING:
    from frictionlab.models.mechanical.mechanical_model import MechanicalModel
    from frictionlab.tape.formulas import Formulas


def check_borders(model: MechanicalModel) -> None:
    """Raise ValueError where the borders of a law in pieces do not ascend."""
    pairs, formulas = ((), None) if module_of_pieces() is None else _neighbours(model.structure_key)
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

    if not derivations_of(key, key.parameters).value("borders of laws", derive) or not (found or derive()):
        return [], None
    from frictionlab.models.symbols import parameter_symbols
    from frictionlab.tape.formulas import formulas_of

    sides = [side for _, low, high in found for side in (low, high)]
    return [tuple(map(str, one)) for one in found], formulas_of(parameter_symbols(key), sides)
