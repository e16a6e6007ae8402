"""Named quantities of a trajectory: formulas of each mode as functions of arrays of states.

Powers in them are those of the tape: a base that is below zero by rounding counts as zero.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any

import numpy as np
import sympy as sp
from sympy.printing.numpy import NumPyPrinter

from frictionlab.automaton import HybridAutomaton, Mode

# What sympy takes for "numpy" is all of it: test tools and f2py too, a tenth of a second of every start.
_NUMPY = {name: value for name, value in vars(np).items() if not name.startswith("_")}
_SETTINGS = {"fully_qualified_modules": False, "inline": True, "allow_unknown_functions": True}


def numpy_function(arguments: Sequence[Any], expressions: Any) -> Callable[..., Any]:
    """Function of numbers or arrays, in the order of the `arguments`: the values of the expressions."""
    return sp.lambdify(arguments, expressions, modules=[_NUMPY], printer=NumPyPrinter(_SETTINGS), cse=True)


def nonnegative_power(base: Any, exponent: Any) -> Any:
    """A power whose base counts as zero where it is negative, as penetration^1.5 at a penetration of -1e-18 m
    by rounding."""
    with np.errstate(divide="ignore"):
        return np.maximum(base, 0.0) ** exponent


def array_function(arguments: Sequence[Any], expressions: Any) -> Callable[..., Any]:
    """Function of arrays, in the order of the `arguments`, that gives the values of the expressions."""
    names = _NUMPY | {"power": nonnegative_power}
    return sp.lambdify(arguments, expressions, modules=[names], printer=_Printer(_SETTINGS), cse=True)


class _Printer(NumPyPrinter):
    def _print_Pow(self, expr: Any, rational: bool = False) -> str:
        if expr.exp.is_integer:
            return super()._print_Pow(expr, rational=rational)
        return f"power({self._print(expr.base)}, {self._print(expr.exp)})"


@lru_cache(maxsize=1024)
def _output_function(mode: Mode, name: str, states: tuple, parameters: tuple) -> Callable[..., np.ndarray]:
    return array_function([*states, *parameters], mode.outputs[name])


def evaluate_output(
    automaton: HybridAutomaton, name: str, states: np.ndarray, modes: np.ndarray, mode_names: Sequence[str]
) -> np.ndarray:
    """Values (N,) of output `name` at `states` (N, n), each by the formula of its mode.

    The modes are numbers in `mode_names`.
    """
    values = np.empty(len(states))
    parameters = tuple(automaton.parameters)
    for i in np.unique(modes):
        chosen = modes == i
        mode = automaton.mode(mode_names[int(i)])
        function = _output_function(mode, name, automaton.states, parameters)
        values[chosen] = function(*states[chosen].T, *automaton.parameters.values())
    return values
