"""The numbers in tapes, constants and coefficients, as functions of the parameters."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from frictionlab.automaton.combinations import combinations_of
from frictionlab.automaton.undefined_numbers import undefined_part
from frictionlab.hybrid.elementary.parameter_functions import function_of_parameters
from frictionlab.hybrid.tape.lowered_mode import LoweredTape, int_array

# Numbers from which on to write each as Python code takes seconds; they are then sums of a few expressions.
MANY_NUMBERS = 1000


def undefined_number(
    parameters: tuple[Any, ...], every: Sequence[LoweredTape], values: Sequence[float]
) -> str:
    """The first number without a value, in words; empty where none is found."""
    at = dict(zip(parameters, values, strict=True))
    exprs = _numbers_of(every)
    return next(filter(None, (undefined_part(expr, at) for expr in exprs)), "")


def _numbers_of(every: Sequence[LoweredTape]) -> list[Any]:
    """All constants, then the coefficients of all terms."""
    return [c for one in every for c in one.tape.constants] + [c for one in every for _, c in one.tape.terms]


def fill_function(
    parameters: tuple[Any, ...], every: Sequence[LoweredTape], apart: bool
) -> Callable[..., Any]:
    """Function of the parameters that gives all constants, then the coefficients of all terms."""
    if not apart:
        exprs = _numbers_of(every)
        if len(exprs) >= MANY_NUMBERS:
            sums = combinations_of(exprs, ())
            function = function_of_parameters(parameters, list(sums.expressions))
            return lambda *values: sums.values(np.array(function(*values), dtype=float))
        return function_of_parameters(parameters, exprs)
    numbers = _number_list(parameters)
    constants, terms = zip(*(numbers.places(one) for one in every))
    used, where = np.unique(np.concatenate([*constants, *terms]), return_inverse=True)
    functions = [numbers.functions[i] for i in used]
    return lambda *values: np.array([function(*values) for function in functions], dtype=float)[where]


class _NumberList:
    """Functions of the parameters for the numbers in tapes.

    Each has the same bits whatever the others are: they share no subexpressions.
    """

    def __init__(self, parameters: tuple[Any, ...]) -> None:
        self._parameters = parameters
        self._numbers: dict[Any, int] = {}
        self._places: WeakKeyDictionary[LoweredTape, tuple[np.ndarray, np.ndarray]] = WeakKeyDictionary()
        self.functions: list[Callable[..., float]] = []

    def places(self, lowered: LoweredTape) -> tuple[np.ndarray, np.ndarray]:
        """Numbers of the functions of a tape's constants and coefficients."""
        if lowered not in self._places:
            tape = lowered.tape
            exprs = tape.constants, [coefficient for _, coefficient in tape.terms]
            constants, terms = (int_array([self._number(expr) for expr in some]) for some in exprs)
            self._places[lowered] = constants, terms
        return self._places[lowered]

    def _number(self, expr: Any) -> int:
        if expr not in self._numbers:
            self._numbers[expr] = len(self.functions)
            self.functions.append(function_of_parameters(self._parameters, expr))
        return self._numbers[expr]


@lru_cache(maxsize=64)
def _number_list(parameters: tuple[Any, ...]) -> _NumberList:
    return _NumberList(parameters)
