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


class Demand(NamedTuple):
    """Modes that are combinations of regimes, one for each part, of which only some are derived.

    The code's last mode then stands for all others: it holds no events and cannot be entered; its
    constraints are the conditions of all regimes, none of which may be negative where a mode with it is
    entered.
    """

    regimes: np.ndarray  # (parts + 1,) range of each part's regimes, numbered through all parts
    conditions: np.ndarray  # (regimes + 1,) range of each regime's conditions among these constraints
    combinations: np.ndarray  # (known, parts) the regime of each part, from 0
    modes: np.ndarray  # (known,) the mode of each of these combinations, -1 where it is none
    listed: np.ndarray  # (guards + 1,) range of the targets of each event
    targets: np.ndarray  # (targets, parts) their combinations


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
    targets: np.ndarray  # (guards, modes but for limits) in the order in which they are tried; none on demand
    limits: np.ndarray  # (limit modes,) which closing an accumulation tries before
    resets: np.ndarray  # (guards, 2) number of the reset, and of the one that closes an accumulation
    function_classes: (
        np.ndarray
    )  # (functions,) functions that are equal up to the sign; 0: never zero by construction
    zeros: (
        np.ndarray
    )  # (2 guards + 1,) ranges of what is zero by construction after those two resets, in turn
    zero_classes: np.ndarray  # classes that are zero, and
    zero_counts: np.ndarray  # how many of their leading coefficients
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
    demand: Demand | None = None  # what is known of all modes where only some are derived
    grown_from: Any = None  # a weak reference to the program whose modes are the first of these, if any

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
