"""What is kept of a packed program: its numbers at the last values of the parameters; and itself as data that
JSON can hold, its arrays, and its numbers as a straight line.

Of the tapes there are the operations, which native code is written from, without the expressions of their
numbers.
"""

from __future__ import annotations

from array import array
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from frictionlab.automaton.straight_line import Data, StraightLine, side_by_side, straight_line_data
from frictionlab.hybrid.elementary.parameter_functions import OF_PARAMETERS
from frictionlab.hybrid.tape.lowering import FunctionsApart
from frictionlab.hybrid.tape.program import Code, Demand, Numbers, Program
from frictionlab.hybrid.tape.tape import Tape


def numbers_at(program: Program, values: Iterable[Any]) -> Numbers:
    """The program's numbers at values of the parameters, into which nothing writes."""
    return _numbers_at(program, array("d", values).tobytes())


@lru_cache(maxsize=64)
def _numbers_at(program: Program, values: bytes) -> Numbers:  # bits tell 0 from -0
    return program.numbers(array("d", values).tolist())


def program_to_data(program: Program, fill: Callable[..., Any]) -> dict[str, Any] | None:
    """The program, with the function that gives its numbers; None where that is no straight line."""
    numbers = _numbers_to_data(fill)
    if numbers is None:
        return None
    demand = program.demand
    return {
        "code": {name: _array_to_data(value) for name, value in program.code._asdict().items()},
        "tapes": [_tape_to_data(tape) for tape in program.tapes],
        "resets": [_tape_to_data(tape) for tape in program.resets],
        "slots": program.slots,
        "modes": program.modes,
        "guards": program.guards,
        "guard_modes": _array_to_data(program.guard_modes),
        "initial": _array_to_data(program.initial),
        "numbers": numbers,
        "demand": demand and [_array_to_data(value) for value in demand],
    }


def _numbers_to_data(fill: Callable[..., Any]) -> Data | None:
    if not isinstance(fill, FunctionsApart):
        return straight_line_data(fill, OF_PARAMETERS)
    lines = [straight_line_data(function, OF_PARAMETERS) for function in fill.functions]
    known = [line for line in lines if line is not None]
    return side_by_side(known, fill.where.tolist()) if len(known) == len(lines) else None


def program_from_data(data: Mapping[str, Any], undefined: Callable[[Sequence[float]], str]) -> Program:
    """The program that :func:`program_to_data` described; `undefined` says which number has no value."""
    return Program(
        Code(**{name: _array_from_data(value) for name, value in data["code"].items()}),
        tuple(map(_tape_from_data, data["tapes"])),
        tuple(map(_tape_from_data, data["resets"])),
        data["slots"],
        tuple(data["modes"]),
        tuple(data["guards"]),
        _array_from_data(data["guard_modes"]),
        _array_from_data(data["initial"]),
        StraightLine(data["numbers"], OF_PARAMETERS),
        undefined,
        data["demand"] and Demand(*map(_array_from_data, data["demand"])),
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
