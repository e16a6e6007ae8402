"""The tapes of modes and resets, and the numbers in them.

A mode or a reset is lowered to its tape, with the slots of its functions as arrays.  The numbers in tapes,
constants and coefficients, are functions of the parameters.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from frictionlab.automaton import Mode, Reset
from frictionlab.automaton.expressions import within_floats
from frictionlab.tape.formulas import FormulaBuilder, Formulas
from frictionlab.tape.functions import AFFINE, CONSTANT_TERM
from frictionlab.tape.program import NOT_POLYNOMIAL, Section
from frictionlab.tape.tape import AffineTerms, ResetBuilder, Tape, TapeBuilder
from frictionlab.tape.undefined_parts import undefined_part


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
        return int_array(self.tape.ranges((*self.flow, *self.guards, *self.sections), self.degrees))

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
        return kind in self._kinds

    @cached_property
    def _kinds(self) -> frozenset[int]:
        return frozenset(op[0] for op in self.tape.ops)


@dataclass(frozen=True, eq=False)
class LoweredReset(LoweredTape):
    """A reset's tape, and the slot of each state's new value."""

    out: list[int]


@lru_cache(maxsize=4096)  # modes that are derived one by one are packed again and again
def lower_mode(
    mode: Mode,
    states: tuple[Any, ...],
    sections: tuple[Section, ...],
    integrands: tuple[Any, ...],
    products: tuple[Any, ...] = (),
) -> LoweredMode:
    """Lower a mode with its sections; the integrands of quadratures follow the flow.

    Products of matrices that many modes have in common are lowered once for all.
    """
    builder = _builder(states, products).with_products(())

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
def _builder(states: tuple[Any, ...], products: tuple[Any, ...]) -> TapeBuilder:
    """A builder with these products."""
    return TapeBuilder(states, _linear_terms(states)).with_products(products)


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


def undefined_number(parameters: tuple[Any, ...], every: Sequence[Tape], values: Sequence[float]) -> str:
    """A text that says which number is the first without a value; empty where none is found."""
    at = dict(zip(parameters, values, strict=True))
    exprs = _numbers_of(every)
    return next(filter(None, (undefined_part(expr, at) for expr in exprs)), "")


def _numbers_of(every: Sequence[Tape]) -> list[Any]:
    """All constants, then the coefficients of all terms."""
    return [c for one in every for c in one.constants] + [c for one in every for _, c in one.terms]


class NumberSlots:
    """The numbers in tapes as slots on one tape of formulas, which programs of the same parameters share."""

    def __init__(self, parameters: tuple[Any, ...]) -> None:
        self._builder = FormulaBuilder(parameters)
        self.tape = self._builder.tape
        self._of_expressions: dict[Any, int] = {}

    def of(self, number: Any) -> int:
        """The slot of a number."""
        if type(number) is float:  # of a matrix, of which there are many
            return self._builder.materialised({CONSTANT_TERM: number})
        if number not in self._of_expressions:
            self._of_expressions[number] = self._builder.slot(number)
        return self._of_expressions[number]


number_slots = lru_cache(maxsize=64)(NumberSlots)


class NumberPlaces:
    """The numbers in the tapes of a program as places among formulas of the parameters, each there once."""

    def __init__(self, parameters: tuple[Any, ...]) -> None:
        self._slots, self._places = number_slots(parameters), dict[int, int]()
        self._formulas = Formulas(self._slots.tape, ())

    def of(self, lowered: LoweredTape) -> tuple[np.ndarray, np.ndarray]:
        """Places of the constants, and of the coefficients of the terms."""
        tape, place, slot = lowered.tape, self._place, self._slots.of
        return int_array([place(slot(c)) for c in tape.constants]), int_array(
            [place(slot(c)) for _, c in tape.terms]
        )

    def _place(self, slot: int) -> int:
        return self._places.setdefault(slot, len(self._places))

    def formulas(self) -> Formulas:
        """The formulas so far."""
        if len(self._formulas.outputs) < len(self._places):
            self._formulas = Formulas(self._slots.tape, tuple(self._places))
        return self._formulas
