"""The arrays that the kernels run on: an automaton's structure as integers, its coefficients as floats.

Arrays of `Code` have one row for each operation, function, guard or mode; each field has a note of its shape.
A `Program` consists of these arrays and the formulas that give its `Numbers`; those at the last values of the
parameters are remembered (`numbers_at`).  A program is kept for later processes (`kept_program`) as data that
JSON can hold.  Its tapes then have the operations, from which native code is written, without the expressions
of their numbers.
"""

from __future__ import annotations

from array import array
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionlab.compilation.decorators import prepare_arrays
from frictionlab.tape.formulas import Formulas, formulas_from_data
from frictionlab.tape.tape import Tape

NO_RESET = -1  # "no reset" in the arrays
NOT_POLYNOMIAL = 1000  # stands for the degree of what is no polynomial of the states: above all orders


class Demand(NamedTuple):
    """Modes that are combinations of regimes, one for each part, of which only some are derived.

    The code's last mode then stands for all others: it holds no events and cannot be entered; its
    constraints are the conditions of all regimes.  Where a mode is entered, none of those of its regimes may
    be negative.
    """

    regimes: np.ndarray  # (parts + 1,) range of each part's regimes, numbered through all parts
    conditions: np.ndarray  # (regimes + 1,) range of each regime's conditions among these constraints
    combinations: np.ndarray  # (known, parts) the regime of each part, from 0
    modes: np.ndarray  # (known,) the mode of each, or minus how many first regimes exclude each other
    listed: np.ndarray  # (guards + 1,) range of the targets of each event
    targets: np.ndarray  # (targets, parts) their combinations


class Code(NamedTuple):
    """The structure of an automaton as integers; the parameter values are in :class:`Numbers`.

    Functions are numbered through all modes: first the event functions (guards), then the constraints.
    """

    inputs: int  # number of states
    ops: np.ndarray  # (operations, 3): kind, a, b
    shared: int  # number of the first term of products of matrices, which are in panels
    term_slots: np.ndarray  # (terms before `shared` and columns of panels,)
    mode_ops: np.ndarray  # (modes + 1,) range of each mode's operations
    flow: np.ndarray  # (modes, states) slot that holds a state's derivative
    mode_guards: np.ndarray  # (modes + 1,)
    mode_constraints: np.ndarray  # (modes + 1,) numbered after all guards
    function_slots: np.ndarray  # (guards + constraints,)
    targets: np.ndarray  # (guards, modes without limit modes) in the order of trial; none on demand
    limits: np.ndarray  # (limit modes,) tried first where an accumulation is closed
    resets: np.ndarray  # (guards, 2) number of the reset, and of the one that closes an accumulation
    function_classes: (
        np.ndarray
    )  # (functions,) one class for functions equal up to the sign; 0: never zero by construction
    zeros: (
        np.ndarray
    )  # (2 guards + 1,) ranges of what is zero by construction after each of a guard's two resets, in turn
    zero_classes: np.ndarray  # in these ranges: classes of functions that are zero, and
    zero_counts: np.ndarray  # how many of their leading coefficients
    reset_ops: np.ndarray  # (resets + 1,)
    reset_out: np.ndarray  # (resets, states) slot that holds a state's new value
    sections: np.ndarray  # (modes, sections) slots
    directions: np.ndarray  # (sections,) +1 rising, -1 falling, 0 both
    native: np.ndarray  # (modes,) addresses of native code, 0 where there is none
    lanes: np.ndarray  # (modes,) the same for the code of a step of several runs side by side
    built: np.ndarray  # (modes,) whether the mode is derived; if not, its constraints are those of `Demand`
    powers: np.ndarray  # (modes,) whether there are powers, whose base may be zero
    quotients: np.ndarray  # (modes,) whether there are quotients, whose divisor may be zero
    degrees: (
        np.ndarray
    )  # (modes,) highest degree of a mode's polynomials, NOT_POLYNOMIAL where there are other functions
    ranges: np.ndarray  # (operations,) how the range of its result on a disc is found, a :class:`tape.Range`
    state_ranges: np.ndarray  # (modes, states) the same of the states
    polynomial: np.ndarray  # (operations,) whether it is a polynomial of the states
    polynomial_degrees: np.ndarray  # (modes,) highest degree of those slots that are polynomials
    guard_degrees: np.ndarray  # (guards,) degrees of the event functions
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
    magnitudes = Numbers(np.abs(numbers.constants), np.abs(numbers.terms))
    return prepare_arrays(System(code, numbers, magnitudes))


class Section(NamedTuple):
    """A zero crossing that is recorded but changes no mode; `direction` +1 rising, -1 falling, 0 both."""

    function: Any  # expression, or the name of an output
    direction: int = 0


@dataclass(frozen=True, eq=False)
class Program:
    """What :func:`frictionlab.tape.packing.pack_program` makes of an automaton's structure."""

    code: Code
    tapes: tuple[Tape, ...]
    resets: tuple[Tape, ...]
    slots: int
    modes: tuple[str, ...]
    guards: tuple[str, ...]
    guard_modes: np.ndarray
    initial: np.ndarray  # modes in the order in which they are tried at the start
    distinct: Formulas  # of the parameters: the numbers, each once
    number_places: NDArray[np.int64]  # among these: all constants, then the coefficients of all terms
    _undefined: Callable[[Sequence[float]], str]  # says which number has no value at given parameters
    demand: Demand | None = None  # what is known of all modes where only some are derived
    shared_terms: NDArray[np.float64] = field(
        default_factory=lambda: np.zeros(0)
    )  # coefficients of products, after those of all terms
    grown_from: Any = None  # a weak reference to the program whose modes are the first of these, if any

    @property
    def formulas(self) -> Formulas:
        """All constants, then the coefficients of all terms, as formulas of the parameters."""
        outputs = self.distinct.outputs
        return Formulas(self.distinct.tape, tuple(outputs[place] for place in self.number_places.tolist()))

    @cached_property
    def has_powers(self) -> bool:
        """Whether a mode has powers, whose base may be zero."""
        return bool(self.code.powers.any())

    @cached_property
    def highest_degree(self) -> int:
        """Highest degree of the polynomials of any mode, or NOT_POLYNOMIAL."""
        return int(self.code.degrees.max())

    @cached_property
    def steps_follow_states(self) -> bool:
        """Whether steps follow from the states alone.

        There are no events, also in modes to come, sections or integrals.
        """
        code, eventless = self.code, self.demand is None and not self.guards
        return eventless and code.sections.size == 0 and bool(code.inputs == code.groups[3])

    def numbers(self, values: Sequence[float]) -> Numbers:
        """Coefficients for parameter values in the order of the automaton's parameters.

        Raises
        ------
        ValueError
            Where a coefficient has no real value there, such as the root of a negative number.
        """
        filled = self.distinct.numbers(*values)[self.number_places]
        if not np.isfinite(filled).all():
            raise ValueError(
                f"the equations have {self._undefined(values) or 'a number that is not finite'}: give the "
                "parameters other values, or mend the formula"
            )
        split = len(self.code.ops)
        terms = np.concatenate([filled[split:], self.shared_terms])
        return prepare_arrays(Numbers(filled[:split].copy(), terms))

    def cost(self) -> dict[str, dict[str, int]]:
        """What each mode costs: operations by kind, guards, states."""
        first = self.code.mode_guards
        return {
            name: self.tapes[i].counts()
            | {"guards": int(first[i + 1] - first[i]), "states": self.code.inputs}
            for i, name in enumerate(self.modes)
        }


@lru_cache(maxsize=64)
def numbers_at(program: Program, values: bytes) -> Numbers:
    """The program's numbers at values of the parameters, whose bits tell 0 from -0; nothing may write into
    their arrays."""
    return program.numbers(array("d", values).tolist())


def kept_program(derivations: Any, name: str, packed: Callable[[], Program]) -> Program:
    """The program among the derivations of a structure; if there is none yet, the one that `packed` makes."""
    program = derivations.objects.get("the program")
    if program is None:
        data = derivations.get(name)
        if data is not None:
            program = program_from_data(data, lambda values: packed()._undefined(values))
        else:
            program = packed()
            derivations.keep(name, program_to_data(program))
        derivations.objects["the program"] = program
    return program


def program_to_data(program: Program) -> dict[str, Any]:
    """The program as data that JSON can hold."""
    demand = None if program.demand is None else map(_array_to_data, program.demand)
    return {
        "code": {name: _array_to_data(value) for name, value in program.code._asdict().items()},
        "tapes": [_tape_to_data(tape) for tape in program.tapes],
        "resets": [_tape_to_data(tape) for tape in program.resets],
        "slots": program.slots,
        "modes": program.modes,
        "guards": program.guards,
        "guard_modes": _array_to_data(program.guard_modes),
        "initial": _array_to_data(program.initial),
        "numbers": program.formulas.to_data(),
        "demand": demand if demand is None else list(demand),
    }


def program_from_data(data: Mapping[str, Any], undefined: Callable[[Sequence[float]], str]) -> Program:
    """The program from what :func:`program_to_data` gave; `undefined` says which number has no value."""
    numbers = formulas_from_data(data["numbers"])
    return Program(
        Code(**{name: _array_from_data(value) for name, value in data["code"].items()}),
        tuple(map(_tape_from_data, data["tapes"])),
        tuple(map(_tape_from_data, data["resets"])),
        data["slots"],
        tuple(data["modes"]),
        tuple(data["guards"]),
        _array_from_data(data["guard_modes"]),
        _array_from_data(data["initial"]),
        numbers,
        np.arange(len(numbers.outputs)),
        undefined,
        None if data["demand"] is None else Demand(*map(_array_from_data, data["demand"])),
    )


def _array_to_data(value: Any) -> Any:
    if not isinstance(value, np.ndarray):
        return value
    return [value.dtype.str, value.shape, value.ravel().tolist()]


def _array_from_data(data: Any) -> Any:
    if not isinstance(data, list):
        return data
    kind, shape, elements = data
    return np.array(elements, dtype=kind).reshape(shape)


def _tape_to_data(tape: Tape) -> list[Any]:
    return [tape.inputs, tape.ops, [slot for slot, _ in tape.terms]]


def _tape_from_data(data: Sequence[Any]) -> Tape:
    inputs, ops, slots = data
    return Tape(inputs, [(kind, a, b) for kind, a, b in ops], terms=[(slot, None) for slot in slots])
