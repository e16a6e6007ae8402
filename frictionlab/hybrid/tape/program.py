"""The arrays that the kernels run on: an automaton's structure as integers, its coefficients as floats.

Arrays of `Code` have one row for each operation, function, guard or mode; shapes stand at each field.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from frictionlab.hybrid.tape.tape import Tape

NO_RESET = -1  # "no reset" in the arrays
NOT_POLYNOMIAL = 1000  # stands for the degree of what is no polynomial of the states: above all orders


class Code(NamedTuple):
    """The structure of an automaton as integers; the parameter values are in :class:`Numbers`.

    Functions are numbered through all modes: first the event functions (guards), then the constraints.
    """

    inputs: int  # number of states
    ops: np.ndarray  # (operations, 3): kind, a, b
    term_slots: np.ndarray  # (terms,)
    mode_ops: np.ndarray  # (modes + 1,) range of each mode's operations
    flow: np.ndarray  # (modes, states) slot that holds a state's derivative
    mode_guards: np.ndarray  # (modes + 1,)
    mode_constraints: np.ndarray  # (modes + 1,) numbered after all guards
    function_slots: np.ndarray  # (guards + constraints,)
    targets: np.ndarray  # (guards, modes but for limits) in the order in which they are tried
    limits: np.ndarray  # (limit modes,) which closing an accumulation tries before
    resets: np.ndarray  # (guards, 2) number of the reset, and of the one that closes an accumulation
    declared: np.ndarray  # (guards, 2, functions) leading coefficients that vanish after those two
    reset_ops: np.ndarray  # (resets + 1,)
    reset_out: np.ndarray  # (resets, states) slot that holds a state's new value
    sections: np.ndarray  # (modes, sections) slots
    directions: np.ndarray  # (sections,) +1 rising, -1 falling, 0 both
    native: np.ndarray  # (modes,) addresses of native code, 0 where there is none
    lanes: np.ndarray  # (modes,) the same of a step of several runs side by side
    built: np.ndarray  # (modes,) whether it is derived; if not, its constraints must not be negative
    powers: np.ndarray  # (modes,) whether there are powers, whose base may be zero
    degrees: (
        np.ndarray
    )  # (modes,) of the polynomials in a mode, NOT_POLYNOMIAL where there are other functions
    ranges: np.ndarray  # (operations,) how its range on a disc is found, a :class:`tape.Range`
    state_ranges: np.ndarray  # (modes, states) the same of the states
    polynomial: np.ndarray  # (operations,) whether it is a polynomial of the states
    polynomial_degrees: np.ndarray  # (modes,) the highest of those that are
    guard_degrees: np.ndarray  # (guards,) the same of the event functions
    groups: np.ndarray  # (4,) bounds of the coordinates, the velocities, the other states; integrals follow


class Numbers(NamedTuple):
    """The coefficients of the affine operations for one set of parameter values."""

    constants: np.ndarray  # (operations,)
    terms: np.ndarray  # (terms,)


class System(NamedTuple):
    """An automaton with values: its structure, its numbers, and their absolute values for majorants."""

    code: Code
    numbers: Numbers
    magnitudes: Numbers


def system_of(code: Code, numbers: Numbers) -> System:
    """A structure with numbers."""
    return System(code, numbers, Numbers(np.abs(numbers.constants), np.abs(numbers.terms)))


class Section(NamedTuple):
    """A zero crossing that is recorded but changes no mode; `direction` +1 rising, -1 falling, 0 both."""

    function: Any  # expression, or the name of an output
    direction: int = 0


@dataclass(frozen=True, eq=False)
class Program:
    """What :func:`frictionlab.hybrid.tape.packing.pack_program` makes of an automaton's structure."""

    code: Code
    tapes: tuple[Tape, ...]
    resets: tuple[Tape, ...]
    slots: int
    modes: tuple[str, ...]
    guards: tuple[str, ...]
    guard_modes: np.ndarray
    initial: np.ndarray  # modes in the order in which they are tried at the start
    _fill: Callable[..., Sequence[float]]
    _undefined: Callable[[Sequence[float]], str]  # which number has no value at those of the parameters

    def numbers(self, values: Sequence[float]) -> Numbers:
        """Coefficients for parameter values in the order of the automaton's parameters.

        Raises
        ------
        ValueError
            Where one has no real value there, such as the root of a negative number.
        """
        try:
            filled = np.array(self._fill(*values), dtype=float)
        except (ArithmeticError, ValueError, TypeError) as error:  # TypeError: a complex number
            raise ValueError(
                f"the equations have {self._undefined(values) or f'an undefined number ({error})'}: give the "
                "parameters other values, or mend the formula"
            ) from error
        split = len(self.code.ops)
        return Numbers(filled[:split].copy(), filled[split:].copy())

    def cost(self) -> dict[str, dict[str, int]]:
        """What each mode costs: operations by kind, guards, states."""
        first = self.code.mode_guards
        return {
            name: self.tapes[i].counts()
            | {"guards": int(first[i + 1] - first[i]), "states": self.code.inputs}
            for i, name in enumerate(self.modes)
        }
