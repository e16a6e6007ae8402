"""A mode and a reset lowered to their tapes, with what is asked of them as arrays."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from frictionlab.automaton import Mode, Reset
from frictionlab.hybrid.tape.operations import AFFINE, POWER
from frictionlab.hybrid.tape.program import NOT_POLYNOMIAL, Section
from frictionlab.hybrid.tape.tape import AffineTerms, ResetBuilder, Tape, TapeBuilder


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
    """A mode's tape, and the slots of what is asked of it."""

    flow: list[int]
    guards: list[int]
    constraints: list[int]
    sections: list[int]

    @cached_property
    def degrees(self) -> list[float]:
        """Of each slot, as a polynomial of the states."""
        return self.tape.degrees(self.guards)

    @cached_property
    def ranges(self) -> np.ndarray:
        """(slots,) how the range of each is found."""
        return int_array(self.tape.ranges((*self.flow, *self.guards, *self.sections), self.guards))

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
        """The highest degree of those that are."""
        return _finite(max(degree for degree in self.degrees if degree < math.inf))

    @cached_property
    def guard_degrees(self) -> np.ndarray:
        """Degrees of the event functions."""
        return int_array([_finite(self.degrees[slot]) for slot in self.guards])

    @cached_property
    def has_powers(self) -> bool:
        """Whether there are powers, whose base may be zero."""
        return any(op[0] == POWER for op in self.tape.ops)

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
    """Lower a mode with its sections; the integrands follow the flow."""
    builder = TapeBuilder(states, _linear_terms(states))
    return LoweredMode(
        flow=[
            builder.slot(expr) for expr in (*mode.flow, *(_section_expression(e, mode) for e in integrands))
        ],
        guards=[builder.slot(event.function) for event in mode.events],
        constraints=[builder.slot(expr) for expr in mode.constraints],
        sections=[builder.slot(_section_expression(section.function, mode)) for section in sections],
        tape=builder.tape,
    )


@lru_cache(maxsize=64)
def _linear_terms(states: tuple[Any, ...]) -> dict[Any, AffineTerms]:
    """Terms of expressions that are affine in the states: they are the same on every tape."""
    return {}


@lru_cache(maxsize=4096)
def lower_reset(reset: Reset, states: tuple[Any, ...]) -> LoweredReset:
    """Lower a reset."""
    builder = ResetBuilder(states, _linear_terms(states))
    return LoweredReset(
        out=[builder.slot(reset.jump.get(state, state)) for state in states], tape=builder.tape
    )


def _section_expression(function: Any | str, mode: Mode) -> Any:
    return mode.outputs[function] if isinstance(function, str) else function


def _finite(degree: float) -> int:
    return int(min(degree, NOT_POLYNOMIAL))


def int_array(rows: Any, columns: int | None = None, kind: type = np.int64) -> np.ndarray:
    """An array of integers; of so many columns where `rows` may be empty."""
    array = np.array(rows, dtype=kind)
    return array if columns is None else array.reshape(len(rows), columns)


def slot_array(rows: Sequence[Any], columns: int | None = None) -> np.ndarray:
    """The same, unsigned, which spares the kernels the check for negative indices."""
    return int_array(rows, columns, np.uint32)
