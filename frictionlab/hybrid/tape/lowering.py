"""The tapes of modes and resets, the numbers in them, and the functions that are zero after a reset.

A mode or a reset is lowered to its tape, with the slots of its functions as arrays.  The numbers in tapes,
constants and coefficients, are functions of the parameters.  Some functions are zero after a reset whatever
the numbers, so that their zeros there are no events.

A program of modes on demand has a separate function for each number.  It is kept for later processes with all
its modes: the data of any program, and what kernels need to choose among modes (`Demand`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from frictionlab.automaton import Event, Mode, Reset
from frictionlab.automaton.expressions import combinations_of, multiply_out, undefined_part, within_floats
from frictionlab.automaton.mode import Expr
from frictionlab.automaton.straight_line import side_by_side, straight_line_data
from frictionlab.hybrid.elementary.parameter_functions import OF_PARAMETERS
from frictionlab.hybrid.tape.functions import AFFINE
from frictionlab.hybrid.tape.program import (
    NOT_POLYNOMIAL,
    Demand,
    Program,
    Section,
    program_from_data,
    program_to_data,
)
from frictionlab.hybrid.tape.tape import AffineTerms, ResetBuilder, Tape, TapeBuilder
from frictionlab.lazy_names import sympy as sp

# With so many numbers, printing each as Python code takes seconds; they are then sums of a few expressions.
MANY_NUMBERS = 1000
ON_DEMAND = "program on demand"  # the name under which such a program is kept
_KEPT: WeakKeyDictionary[Any, Program] = WeakKeyDictionary()  # programs by the `kept` of their structure


@dataclass(frozen=True, eq=False)
class LoweredTape:
    """A tape as arrays."""

    tape: Tape

    @cached_property
    def ops(self) -> np.ndarray:
        """(operations, 3): kind, a, b."""
        return slot_array(self.tape.ops, columns=3)

    @cached_property
    def affine(self) -> np.ndarray:
        """(operations,) whether a and b are a range of terms."""
        return self.ops[:, 0] == AFFINE

    @cached_property
    def term_slots(self) -> np.ndarray:
        """(terms,)"""
        return slot_array([slot for slot, _ in self.tape.terms])


@dataclass(frozen=True, eq=False)
class LoweredMode(LoweredTape):
    """A mode's tape, and the slots of its flow, guards, constraints and sections."""

    flow: list[int]
    guards: list[int]
    constraints: list[int]
    sections: list[int]

    @cached_property
    def degrees(self) -> list[float]:
        """Degree of each slot as a polynomial of the states; infinite where it is none."""
        return self.tape.degrees()

    @cached_property
    def ranges(self) -> np.ndarray:
        """(slots,) how the range of each on a disc is found, a :class:`tape.Range`."""
        return int_array(self.tape.ranges((*self.flow, *self.guards, *self.sections)))

    @cached_property
    def degree(self) -> int:
        """The highest degree, NOT_POLYNOMIAL where there are other functions."""
        return _finite(max(self.degrees))

    @cached_property
    def polynomial(self) -> np.ndarray:
        """(slots,) whether each is a polynomial of the states."""
        return int_array([degree < math.inf for degree in self.degrees])

    @cached_property
    def polynomial_degree(self) -> int:
        """The highest degree of the slots that are polynomials."""
        return _finite(max(degree for degree in self.degrees if degree < math.inf))

    @cached_property
    def guard_degrees(self) -> np.ndarray:
        """Degrees of the event functions."""
        return int_array([_finite(self.degrees[slot]) for slot in self.guards])

    def has(self, kind: int) -> bool:
        """Whether there are operations of a kind."""
        return any(op[0] == kind for op in self.tape.ops)

    @cached_property
    def flow_slots(self) -> np.ndarray:
        """(states,)"""
        return slot_array(self.flow)

    @cached_property
    def guard_slots(self) -> np.ndarray:
        """(guards,)"""
        return slot_array(self.guards)

    @cached_property
    def constraint_slots(self) -> np.ndarray:
        """(constraints,)"""
        return slot_array(self.constraints)


@dataclass(frozen=True, eq=False)
class LoweredReset(LoweredTape):
    """A reset's tape, and the slot of each state's new value."""

    out: list[int]

    @cached_property
    def out_slots(self) -> np.ndarray:
        """(states,)"""
        return slot_array(self.out)


@lru_cache(maxsize=4096)  # modes that are derived one by one are packed again and again
def lower_mode(
    mode: Mode, states: tuple[Any, ...], sections: tuple[Section, ...], integrands: tuple[Any, ...]
) -> LoweredMode:
    """Lower a mode with its sections; the integrands of quadratures follow the flow."""
    builder = TapeBuilder(states, _linear_terms(states))

    def slots(expressions: Iterable[Any]) -> list[int]:
        return [builder.slot(within_floats(expr)) for expr in expressions]

    return LoweredMode(
        flow=slots((*mode.flow, *(_section_expression(e, mode) for e in integrands))),
        guards=slots(event.function for event in mode.events),
        constraints=slots(mode.constraints),
        sections=slots(_section_expression(section.function, mode) for section in sections),
        tape=builder.tape,
    )


@lru_cache(maxsize=64)
def _linear_terms(states: tuple[Any, ...]) -> dict[Any, AffineTerms]:
    """Terms of expressions that are affine in the states, shared by all tapes, on which they are the same."""
    return {}


@lru_cache(maxsize=4096)
def lower_reset(reset: Reset, states: tuple[Any, ...]) -> LoweredReset:
    """Lower a reset."""
    builder = ResetBuilder(states, _linear_terms(states))
    return LoweredReset(
        out=[builder.slot(within_floats(reset.jump.get(state, state))) for state in states],
        tape=builder.tape,
    )


def _section_expression(function: Any | str, mode: Mode) -> Any:
    return mode.outputs[function] if isinstance(function, str) else function


def _finite(degree: float) -> int:
    return int(min(degree, NOT_POLYNOMIAL))


def int_array(rows: Any, columns: int | None = None, kind: type = np.int64) -> np.ndarray:
    """An array of integers; with `columns` given it has two axes, even where `rows` is empty."""
    array = np.array(rows, dtype=kind)
    return array if columns is None else array.reshape(len(rows), columns)


def slot_array(rows: Sequence[Any], columns: int | None = None) -> np.ndarray:
    """An array of unsigned integers, which spare the kernels the check for negative indices."""
    return int_array(rows, columns, np.uint32)


def undefined_number(
    parameters: tuple[Any, ...], every: Sequence[LoweredTape], values: Sequence[float]
) -> str:
    """A text that says which number is the first without a value; empty where none is found."""
    at = dict(zip(parameters, values, strict=True))
    exprs = _numbers_of(every)
    return next(filter(None, (undefined_part(expr, at) for expr in exprs)), "")


def _numbers_of(every: Sequence[LoweredTape]) -> list[Any]:
    """All constants, then the coefficients of all terms."""
    return [c for one in every for c in one.tape.constants] + [c for one in every for _, c in one.tape.terms]


def fill_function(
    parameters: tuple[Any, ...], every: Sequence[LoweredTape], apart: bool
) -> Callable[..., Any]:
    """Function of the parameters that gives all constants, then the coefficients of all terms.

    With `apart` each number has a function of its own.
    """
    from frictionlab.hybrid.expression_functions import function_of_parameters  # which loads sympy

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
    return FunctionsApart(tuple(numbers.functions[i] for i in used), where)


class FunctionsApart(NamedTuple):
    """Functions that give one number each, and for each of many numbers the function that gives it."""

    functions: tuple[Callable[..., float], ...]
    where: np.ndarray

    def __call__(self, *values: float) -> np.ndarray:
        """All numbers."""
        return np.array([function(*values) for function in self.functions], dtype=float)[self.where]


class _NumberList:
    """Functions of the parameters for the numbers in tapes.

    The bits of a number do not depend on the others: the functions share no subexpressions.
    """

    def __init__(self, parameters: tuple[Any, ...]) -> None:
        self._parameters = parameters
        self._numbers: dict[Any, int] = {}
        self._places: WeakKeyDictionary[LoweredTape, tuple[np.ndarray, np.ndarray]] = WeakKeyDictionary()
        self.functions: list[Callable[..., float]] = []

    def places(self, lowered: LoweredTape) -> tuple[np.ndarray, np.ndarray]:
        """Indices of the functions that give a tape's constants, and its coefficients."""
        if lowered not in self._places:
            tape = lowered.tape
            exprs = tape.constants, [coefficient for _, coefficient in tape.terms]
            constants, terms = (int_array([self._number(expr) for expr in some]) for some in exprs)
            self._places[lowered] = constants, terms
        return self._places[lowered]

    def _number(self, expr: Any) -> int:
        from frictionlab.hybrid.expression_functions import function_of_parameters

        if expr not in self._numbers:
            self._numbers[expr] = len(self.functions)
            self.functions.append(function_of_parameters(self._parameters, expr))
        return self._numbers[expr]


@lru_cache(maxsize=64)
def _number_list(parameters: tuple[Any, ...]) -> _NumberList:
    return _NumberList(parameters)


def kept_program_on_demand(kept: Any, packed: Callable[[], Program]) -> Program:
    """The program in the files of a structure, `kept`; if there is none yet, `packed` makes it."""
    if kept not in _KEPT:
        data = kept.get(ON_DEMAND)
        if data is not None:
            _KEPT[kept] = _from_data(data, lambda values: packed()._undefined(values))
        else:
            program = _KEPT[kept] = packed()
            if (data := _to_data(program)) is not None:
                kept.keep(ON_DEMAND, data)
    return _KEPT[kept]


def _to_data(program: Program) -> dict[str, Any] | None:
    """The program as data that JSON can hold; None where a function is no straight line."""
    fill: Any = program._fill
    assert isinstance(fill, FunctionsApart)
    assert program.demand is not None
    lines = [straight_line_data(function, OF_PARAMETERS) for function in fill.functions]
    known = [line for line in lines if line is not None]
    data = program_to_data(program, _no_numbers)
    if data is None or len(known) < len(lines):
        return None
    demand = [[array.shape, array.ravel().tolist()] for array in program.demand]
    return data | {"numbers": side_by_side(known, fill.where.tolist()), "demand": demand}


def _no_numbers() -> list[float]:
    return []


def _from_data(data: dict[str, Any], undefined: Callable[..., str]) -> Program:
    arrays = (np.array(elements, dtype=np.int64).reshape(shape) for shape, elements in data["demand"])
    return replace(program_from_data(data, undefined), demand=Demand(*arrays))


@lru_cache(maxsize=4096)
def structural_zeros(mode: Mode, event: Event, reset: Reset) -> Mapping[Any, int]:
    """How many leading Taylor coefficients are zero after the event's reset, by function up to its sign.

    The reset declares such functions.  Besides, the function that triggered the event and the constraints of
    the mode that ends were zero before the reset; they stay zero unless it changes them where the event is.
    """
    zero: dict[Any, int] = {}
    for function, count in reset.vanishing.items():
        zero[sign_normal_form(function)] = max(count, zero.get(sign_normal_form(function), 0))
    for function in (event.function, *mode.constraints):
        if sign_normal_form(function) not in zero and _survives(function, reset, event.function):
            zero[sign_normal_form(function)] = 1
    return zero


def _survives(function: Expr, reset: Reset, guard: Expr) -> bool:
    """Whether a function that was zero before the reset is zero after it, where the guard is zero."""
    if function.free_symbols.isdisjoint(reset.jump):
        return True
    after: Any = sp.sympify(function.xreplace(dict(reset.jump)), strict=True)  # a jump may be a plain number
    if _is_zero(after):
        return True
    surface = _solved(guard, function.free_symbols & guard.free_symbols)
    return surface is not None and _is_zero((after - function).xreplace(surface))


def _solved(guard: Expr, symbols: set[Any]) -> dict[Any, Expr] | None:
    """The value of one of the symbols at which the guard is zero; None where it is linear in none of them."""
    for one in sorted(symbols, key=str):
        slope = sp.diff(guard, one)
        if slope != 0 and one not in slope.free_symbols:
            return {one: -guard.xreplace({one: sp.S.Zero}) / slope}
    return None


def _is_zero(expression: Any) -> bool:
    somewhere = expression.xreplace(_integers(expression.free_symbols))
    if somewhere.is_Rational and somewhere != 0:  # exact, and quicker than multiplying out
        return False
    return multiply_out(expression) in (0, 0.0)  # to sympy these are two numbers


def _integers(symbols: set[Any]) -> dict[Any, Any]:
    """A different integer for each symbol."""
    return {name: sp.Integer(i) for i, name in enumerate(sorted(symbols, key=str), start=3)}


@lru_cache(maxsize=4096)
def sign_normal_form(function: Expr) -> Expr:
    """One form for f and -f, however they are written, as both are zero together."""
    expanded = multiply_out(function)
    return -expanded if expanded.could_extract_minus_sign() else expanded
