"""Whether what a model states of the phase has the period 2 pi, at the values of the model's parameters.

The phase starts again at 0 after each period: there cos(phase/2) would jump, or a second load at a frequency
that is no whole multiple of the first, and the motion would be another than is meant.
"""

from __future__ import annotations

from collections.abc import Iterator
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
JUMP_RTOL = 1e-9  # share of the terms: a ratio of frequencies that is a whole number has rounding errors


def check_period(model: MechanicalModel) -> None:
    """Raise ValueError where sines and cosines of the phase do not return after a period."""
    texts, formulas, states = _oscillations(model.structure_key)
    if formulas is None:
        return
    with np.errstate(all="ignore"):
        numbers = formulas.arrays(*structure_values(model), *_places(states))
        *rows, _ = np.broadcast_arrays(*numbers, np.zeros(PLACES))
    for text, jump, size in zip(texts, rows[::2], rows[1::2], strict=True):
        if (np.abs(jump) > JUMP_RTOL * size).any():
            raise ValueError(_words(model, text))


def period_limits(model: MechanicalModel) -> Iterator[tuple[Any, str]]:
    """Formulas of parameters that :func:`check_period` asks to be at least 0, each with its message."""
    key = model.structure_key
    uneven = _uneven(key)
    states = _states(key, uneven)
    for terms in uneven:
        jump, size = _jump_and_size(terms)
        for place in _places(len(states)).T if states else [()]:
            margin = (JUMP_RTOL * size - abs(jump)).xreplace(dict(zip(states, map(sympy.Float, place))))
            if margin.free_symbols:
                yield margin, _words(model, str(sympy.Add(*terms)))


def _places(states: int) -> Any:
    """Values of the states (states, PLACES) at which what is stated is compared after a period."""
    return np.random.default_rng(SEED).normal(size=(states, PLACES))


def _words(model: MechanicalModel, text: str) -> str:
    return (
        f"what {type(model).__name__} states of q.phase must have its period, 2 pi, got "
        f"{abbreviate(text)}, but the phase starts again at 0 after each: give Mechanics the "
        "frequency of which all others are whole multiples, or write q.t, which goes on, for q.phase"
    )


@cache
def _oscillations(key: StructureKey) -> tuple[list[str], Formulas | None, int]:
    """Texts of what may not return; formulas of its jump and size by parameters and states, how many."""
    derivations = derivations_of(key)
    about = derivations.value("oscillations", lambda: _about(key))
    if not about["texts"]:
        return [], None, 0
    formulas = kept_formulas(derivations, "oscillations", lambda: _formulas(key, _uneven(key)))
    return about["texts"], formulas, about["states"]


def _about(key: StructureKey) -> dict[str, Any]:
    uneven = _uneven(key)
    return {"texts": [str(sympy.Add(*terms)) for terms in uneven], "states": len(_states(key, uneven))}


def _formulas(key: StructureKey, uneven: list[list[Any]]) -> Formulas:
    sides = [side for terms in uneven for side in _jump_and_size(terms)]
    return formulas_of([*parameter_symbols(key), *_states(key, uneven)], sides)


def _jump_and_size(terms: list[Any]) -> tuple[Any, Any]:
    """What the sum of these terms changes by after a period, and the sum of their sizes before and after."""
    phase = symbol(PHASE)
    start, end = ([one.xreplace({phase: at}) for one in terms] for at in (BEGIN, BEGIN + 2 * sympy.pi))
    sizes = (sympy.Abs(one, evaluate=False) for one in start + end)
    return sympy.Add(*end) - sympy.Add(*start), sympy.Add(*sizes)


def _states(key: StructureKey, uneven: list[list[Any]]) -> list[Any]:
    """What these expressions depend on beside parameters and the phase."""
    there = {each for terms in uneven for one in terms for each in one.free_symbols}
    return sorted(there - {*parameter_symbols(key), symbol(PHASE)}, key=str)


def _uneven(key: StructureKey) -> list[list[Any]]:
    """The terms of each expression that are sines of the phase, where one may be no whole multiple of it.

    What has the phase outside of sines too is meant to start anew with it, as a sawtooth or a short pulse.
    """
    from .equations_of_motion import system_of

    phase, uneven = symbol(PHASE), []
    system = system_of(key)
    for stated in system.mechanics.expressions if system.phase else ():
        terms = [one for one in sympy.Add.make_args(stated) if _is_of_waves(one)]
        multiples = [wave.args[0].diff(phase) for one in terms for wave in _waves(one)]
        if not all(one.is_integer or one.has(phase) for one in multiples):
            uneven.append(terms)
    return uneven


def _waves(term: Any) -> list[Any]:
    phase = symbol(PHASE)
    return [one for one in term.atoms(sympy.sin, sympy.cos, sympy.tan) if one.has(phase)]


def _is_of_waves(term: Any) -> bool:
    """Whether a term has the phase, and only in sines."""
    names = {wave: sympy.Dummy() for wave in _waves(term)}
    return bool(names) and not term.xreplace(names).has(symbol(PHASE))
