"""Whether what a model states of the phase has the period 2 pi, at the values of the model's parameters.

The phase starts again at 0 after each period: there cos(phase/2) would jump, or a second load at a frequency
that is no whole multiple of the first, and the motion would be another than is meant.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from frictionlab.components.component import StructureKey
from frictionlab.lazy_names import sympy
from frictionlab.models.kept_structures import derivations_of
from frictionlab.models.symbols import parameter_symbols, structure_values, symbol
from frictionlab.presentation import PHASE
from frictionlab.tape.formulas import Formulas, formulas_of, kept_formulas
from frictionlab.validation import abbreviate

from .masses import SEED

if TYPE_CHECKING:
    from frictionlab.models.mechanical.mechanical_model import MechanicalModel

PLACES = 8  # at which what is stated is compared after a period
BEGIN = 1  # of that period, rad: no zero of sines
JUMP_RTOL = 1e-9  # share of the value: a ratio of frequencies that is a whole number has rounding errors


def check_period(model: MechanicalModel) -> None:
    """Raise ValueError where sines and cosines of the phase do not return after a period."""
    texts, formulas, states = _oscillations(model.structure_key)
    if formulas is None:
        return
    place = np.random.default_rng(SEED).normal(size=(states, PLACES))
    with np.errstate(all="ignore"):
        *rows, _ = np.broadcast_arrays(*formulas.arrays(*structure_values(model), *place), np.zeros(PLACES))
    for text, start, end in zip(texts, rows[::2], rows[1::2], strict=True):
        if (np.abs(end - start) > JUMP_RTOL * np.fmax(np.abs(start), np.abs(end))).any():
            raise ValueError(
                f"what {type(model).__name__} states of q.phase must have its period, 2 pi, got "
                f"{abbreviate(text)}, which jumps where the phase starts again at 0: give Mechanics the "
                "frequency of which all others are whole multiples, or write q.t, which goes on, for q.phase"
            )


@cache
def _oscillations(key: StructureKey) -> tuple[list[str], Formulas | None, int]:
    """Texts of what may not return; formulas of the parameters and of states, how many, a period apart."""
    derivations = derivations_of(key)
    about = derivations.value("oscillations", lambda: _about(key))
    if not about["texts"]:
        return [], None, 0
    formulas = kept_formulas(derivations, "oscillations", lambda: _formulas(key))
    return about["texts"], formulas, about["states"]


def _about(key: StructureKey) -> dict[str, Any]:
    uneven = _uneven(key)
    return {"texts": [str(one) for one, _ in uneven], "states": len(_states(key))}


def _formulas(key: StructureKey) -> Formulas:
    phase, sides = symbol(PHASE), []
    for given, waves in _uneven(key):
        for place in (BEGIN, BEGIN + 2 * sympy.pi):
            at = {wave: wave.xreplace({phase: place}) for wave in waves}
            sides.append(given.xreplace(at).xreplace({phase: sympy.S.Zero}))
    return formulas_of([*parameter_symbols(key), *_states(key)], sides)


def _states(key: StructureKey) -> list[Any]:
    """What these expressions depend on beside parameters and the phase."""
    there = {each for one, _ in _uneven(key) for each in one.free_symbols}
    return sorted(there - {*parameter_symbols(key), symbol(PHASE)}, key=str)


def _uneven(key: StructureKey) -> list[tuple[Any, list[Any]]]:
    """Expressions with sines of what may be no whole multiple of the phase, and all their sines of it.

    A sawtooth that is written as the phase itself jumps as is meant.
    """
    from .equations_of_motion import system_of

    phase, found = symbol(PHASE), []
    for given in system_of(key).mechanics.expressions:
        waves = [one for one in given.atoms(sympy.sin, sympy.cos, sympy.tan) if one.has(phase)]
        multiples = [one.args[0].diff(phase) for one in waves]
        if not all(one.is_integer or one.has(phase) for one in multiples):
            found.append((given, waves))
    return found
