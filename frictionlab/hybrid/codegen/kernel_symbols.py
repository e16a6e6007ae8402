"""Kernels that native code calls by a name, so that what they compute is stated once.

A name is made known to LLVM when code that holds it is loaded.  The kernels of functions and of powers are
called so, as what they do takes longer than a call.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

from frictionlab.hybrid.compilation import c_address
from frictionlab.hybrid.elementary.logarithms import power
from frictionlab.hybrid.tape.functions import function_range, function_value

VALUE_SYMBOL, RANGE_SYMBOL = "frictionlab_function_value", "frictionlab_function_range"
POWER_SYMBOL = "frictionlab_power"


class KernelSymbol(NamedTuple):
    """A call of a kernel, and its types."""

    function: Callable[..., float]
    signature: str


def _value(kind, x):
    return function_value(kind, x)


def _range(kind, a, y, slope, d):
    return function_range(kind, a, y, slope, d)


def _power(x, y):
    return power(x, y)


KERNELS = {
    VALUE_SYMBOL: KernelSymbol(_value, "float64(int64, float64)"),
    RANGE_SYMBOL: KernelSymbol(_range, "float64(int64, float64, float64, float64, float64)"),
    POWER_SYMBOL: KernelSymbol(_power, "float64(float64, float64)"),
}


def register_used(code: bytes) -> None:
    """Make known to LLVM the kernels whose names stand in machine code."""
    for name in KERNELS:
        if name.encode() in code:
            _registered(name)


@cache  # once a process
def _registered(name: str) -> None:
    import llvmlite.binding as llvm

    llvm.add_symbol(name, c_address(name, *KERNELS[name]))
