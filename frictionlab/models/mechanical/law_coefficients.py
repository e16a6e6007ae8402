"""Whether laws that `mechanics` makes of expressions keep their rules at the values of a model's parameters.

Coefficients that depend on parameters are checked before a run, those that depend on the phase at 64 phases
of a period.  Those that depend on place, speed, time or further states may be admissible in some places
only, so they are checked where a run begins.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from frictionlab.components.component import Component, StructureKey, expressions_of
from frictionlab.lazy_names import sympy
from frictionlab.models.kept_structures import derivations_of
from frictionlab.models.symbols import expand_products
from frictionlab.presentation import PHASE
from frictionlab.tape.formulas import Formulas, formulas_of

if TYPE_CHECKING:
    from frictionlab.models.mechanical.mechanical_model import MechanicalModel

    from .equations_of_motion import LagrangeSystem

PHASES = np.linspace(0.0, 2 * np.pi, 64, endpoint=False)
DIGITS = 12  # of values that are compared; the last ones of a float are rounding


class LawOfExpressions(NamedTuple):
    """A law, and its coefficients as formulas of parameters and states.

    Parameters
    ----------
    law : Component
    inputs : tuple of str
        Names of the parameters and the states.
    coefficients : Formulas
        Their values, then the sums of the sizes of their terms.
    """

    law: Component
    inputs: tuple[str, ...]
    coefficients: Formulas


def check_law_coefficients(model: MechanicalModel, start: Any = None) -> None:
    """Raise ValueError where a law that `mechanics` makes has coefficients that break one of its rules.

    Without `start`, a state, laws are checked that depend on parameters and phase only; with it the others.
    """
    laws, states = _laws(model.structure_key)
    for one in laws:
        there = {*one.inputs}.intersection(states)
        if (start is None) != (there <= {PHASE}):
            continue
        state = {PHASE: PHASES if there else 0.0} if start is None else dict(zip(states, start, strict=True))
        _check(model, one, {**state, **model.parameters})


def _check(model: MechanicalModel, one: LawOfExpressions, values: Mapping[str, Any]) -> None:
    expressions = expressions_of(one.law)
    inputs = [values[name] for name in one.inputs]
    with np.errstate(all="ignore"):
        rows = np.broadcast_arrays(*one.coefficients.arrays(*inputs), *inputs, np.zeros(1))
    n = len(expressions)
    for row in zip(*(each.tolist() for each in rows), strict=True):
        numbers = [_rounded(*each) for each in zip(row[:n], row[n : 2 * n], strict=True)]
        try:
            replace(one.law, **dict(zip(expressions, numbers, strict=True)))
        except ValueError as error:
            law, of = type(one.law).__name__, type(model).__name__
            given = ", ".join(f"{name} = {each}" for name, each in expressions.items())
            at = zip(one.inputs, row[2 * n :])
            where = ", ".join(f"{name} = {each:g}" for name, each in at)
            raise ValueError(
                f"{error}; the {law} in mechanics of {of} has {given}, here at {where}: change these, or "
                "refuse such values of parameters by fl.parameter(..., minimum=...)"
            ) from None


def _rounded(value: float, size: float) -> float:
    """A value without its last digits; 0 where terms of this size cancel but for rounding."""
    return 0.0 if abs(value) < 10.0**-DIGITS * size else float(f"{value:.{DIGITS}g}")


def _size(given: Any) -> Any:
    """The sum of the sizes of an expression's terms."""
    return sympy.Add(*map(sympy.Abs, sympy.Add.make_args(expand_products(given))))


@cache
def _laws(key: StructureKey) -> tuple[list[LawOfExpressions], list[str]]:
    """The laws that `mechanics` makes of expressions, and the names of the states."""

    def derived() -> LagrangeSystem:
        from .equations_of_motion import system_of  # which loads sympy

        return system_of(key)

    if not derivations_of(key).value("laws of expressions", lambda: bool(derived().laws_of_expressions)):
        return [], []
    system, laws = derived(), []
    for law in system.laws_of_expressions:
        given = [*expressions_of(law).values()]
        inputs = sorted({each for one in given for each in one.free_symbols}, key=str)
        formulas = formulas_of(inputs, [*given, *map(_size, given)])
        laws.append(LawOfExpressions(law, tuple(map(str, inputs)), formulas))
    return laws, [str(one) for one in system.states]
