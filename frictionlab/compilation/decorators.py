"""The decorators of every kernel: compiled ahead of time, else by numba, else plain Python.

The functions of an object take the place of the kernels that Python calls.  Which code there is on this
machine is known in :mod:`frictionlab.compilation.machine_code`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from frictionlab.compilation import machine_code
from frictionlab.compilation.loaded_kernels import with_table
from frictionlab.compilation.machine_code import LOADED, NUMBA
from frictionlab.compilation.numba_internals import c_function, compiled_kernel, has_kernel

T = TypeVar("T", bound=tuple)
_FOUND: set[Any] = set()  # kernels found in the cache folder, so that it is read once for each


def needs_compilation(function: Any) -> bool:
    """Whether the next call of a kernel compiles it: neither loaded nor in the cache folder."""
    if NUMBA is None or function.overloads or function in _FOUND:
        return False
    if machine_code.CACHE_FOLDER and has_kernel(machine_code.CACHE_FOLDER, function.__name__):
        _FOUND.add(function)
    return function not in _FOUND


def kernel(function: Callable) -> Callable:
    """The function as compiled ahead of time; else numba compiles it on its first call, once per machine;
    without numba the function itself."""
    return _compile(function, {"forceinline": False})  # else it inherits this from its callers


def inlined(function: Callable) -> Callable:
    """A kernel that is inlined into its callers: a call would pass some hundred numbers for its arrays."""
    return _compile(function, {"forceinline": True})


def c_address(name: str, function: Callable, signature: str) -> int:
    """Address at which C code calls a function; ahead of time it was compiled under this `name`."""
    if LOADED is not None:
        return LOADED.address(name)
    return c_function(NUMBA, function, signature, machine_code.CACHE_FOLDER).address


def prepare_arrays(arrays: T) -> T:
    """The named tuple of arrays, prepared for kernels that take it at every run."""
    return arrays if LOADED is None else with_table(arrays)


def _compile(function: Callable, further: dict[str, bool]) -> Callable:
    if LOADED is not None:
        return LOADED.function(function)
    if NUMBA is None:
        return function
    return compiled_kernel(NUMBA, function, machine_code.CACHE_FOLDER, further)
