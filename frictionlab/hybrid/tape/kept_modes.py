"""A program of modes on demand that is kept for later processes, and has all of them.

Beside what is kept of any program there is what kernels need to choose among modes, and each number is a
function of its own.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from frictionlab.automaton.straight_line import side_by_side, straight_line_data
from frictionlab.hybrid.elementary.parameter_functions import OF_PARAMETERS
from frictionlab.hybrid.tape.lowering import FunctionsApart
from frictionlab.hybrid.tape.program import Demand, Program, program_from_data, program_to_data

NAME = "program on demand"
_KEPT: WeakKeyDictionary[Any, Program] = WeakKeyDictionary()  # by what files hold of a structure


def kept_program_on_demand(kept: Any, packed: Callable[[], Program]) -> Program:
    """The program that files hold of a structure, `kept`; if they do not yet, what `packed` gives."""
    if kept not in _KEPT:
        data = kept.get(NAME)
        if data is not None:
            _KEPT[kept] = _from_data(data, lambda values: packed()._undefined(values))
        else:
            program = _KEPT[kept] = packed()
            if (data := _to_data(program)) is not None:
                kept.keep(NAME, data)
    return _KEPT[kept]


def _to_data(program: Program) -> dict[str, Any] | None:
    """The program as data that JSON can hold; None where a number is no straight line."""
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
