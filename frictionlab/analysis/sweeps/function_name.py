"""What files of sweeps know of a function: its name, and a digest of its code and of what it holds."""

from __future__ import annotations

import copyreg
import dis
import random
from collections.abc import Callable, ItemsView, Iterable, KeysView, Sequence, ValuesView
from enum import Enum
from functools import cached_property
from hashlib import sha256
from types import CellType, CodeType, FunctionType, MappingProxyType, MethodType, ModuleType
from typing import Any

import numpy as np

from frictionlab.hybrid.trajectory import Trajectory

PLAIN = bool, int, float, complex, str, bytes, type(None)
VIEWS = KeysView, ValuesView, ItemsView
RANDOM = np.random.Generator, np.random.BitGenerator, np.random.RandomState, random.Random
DIGITS = 12


def function_name(function: Callable[..., Any]) -> str:
    """The name of a function with digits, by which files tell functions apart.

    The digits follow from its code, and from the content of its closure, its defaults, its partial arguments
    and the object whose method it is: numbers, texts, lists, dictionaries, sets, arrays, models, laws,
    functions, and the attributes of other objects.  A run counts without the time that it took, and an object
    without its cached properties.  Of generators of random numbers, locks, files, and what else cannot be
    taken apart, the type and the name alone are seen.  Docstrings, methods of classes, and what the function
    takes from its module are not seen: functions which it calls may change.

    A function that changes what it holds while it runs, such as a list or a cache, is another one afterwards.
    """
    name = getattr(function, "__name__", type(function).__name__)
    return f"{getattr(function, '__qualname__', name)} {_Content().digest(function)[:DIGITS]}"


def own_name(function: Callable[..., Any]) -> str:
    """The name of a function; "result" of one that has none."""
    name = getattr(function, "__name__", "<lambda>")
    return "result" if name == "<lambda>" else name


class _Content:
    """Digests of objects by content; an object that holds itself has one too."""

    def __init__(self) -> None:
        self._digests: dict[int, tuple[Any, str]] = {}  # by id, with the object, which keeps its id its own

    def digest(self, value: Any) -> str:
        """The digest of an object; of numbers and texts what Python writes."""
        if type(value) in PLAIN:
            return f"{type(value).__name__} {value!r}"
        if id(value) not in self._digests:
            self._digests[id(value)] = value, f"object {len(self._digests)}"
            content = type(value).__qualname__, *map(self.digest, self._parts(value))
            self._digests[id(value)] = value, sha256(repr(content).encode()).hexdigest()
        return self._digests[id(value)][1]

    def _parts(self, value: Any) -> Iterable[Any]:
        if isinstance(value, (type, ModuleType)):
            return value.__module__ if isinstance(value, type) else "", value.__name__
        if isinstance(value, CodeType):
            return _parts_of_code(value)
        if isinstance(value, FunctionType):
            return value.__code__, value.__defaults__, value.__kwdefaults__, value.__closure__
        if isinstance(value, MethodType):
            return value.__func__, value.__self__
        if isinstance(value, CellType):
            try:
                return (value.cell_contents,)
            except ValueError:  # of a name that has no value yet
                return ()
        if isinstance(value, (set, frozenset)):
            items = sorted(map(self.digest, value))  # its order is another one in each process
            return items, getattr(value, "__dict__", None)
        return _parts_of_data(value)


def _parts_of_data(value: Any) -> Iterable[Any]:
    """The content of containers, arrays, expressions and runs; of other objects that of a copy."""
    if type(value) is tuple or isinstance(value, VIEWS):
        return value
    if type(value) is dict or isinstance(value, MappingProxyType):
        return value.items()
    if type(value) is np.ndarray:
        items = tuple(value.flat) if value.dtype.hasobject else value.tobytes()
        return str(value.dtype), value.shape, items
    if hasattr(type(value), "tocoo"):  # a sparse array
        sparse = value.tocoo()
        return sparse.shape, sparse.row, sparse.col, sparse.data
    if hasattr(type(value), "free_symbols"):  # an expression of sympy
        from sympy import srepr

        return getattr(value, "args", ()) or (srepr(value),)
    if isinstance(value, Trajectory):
        return value.raw, value.samples, value.quadratures, value.source, value.automaton.parameters
    if isinstance(value, Enum):
        return (value.name,)
    return () if isinstance(value, RANDOM) else _parts_of_copy(value)


def _parts_of_copy(value: Any) -> Sequence[Any]:
    """What a copy of an object would be made from; name and attributes of one that cannot be copied."""
    kind = type(value)
    if kind.__module__.startswith("numba.") and hasattr(
        value, "__wrapped__"
    ):  # a copy has a number of its own
        return _names(value)
    try:
        made = copyreg.dispatch_table.get(kind, lambda value: value.__reduce_ex__(2))(value)
    except Exception:  # an object may raise what it likes
        return *_names(value), _without_caches(getattr(value, "__dict__", None), kind)
    if isinstance(made, str):  # it is found by its name
        return made, *_names(value)
    arguments, state, *items = *made[1:5], *[None] * (5 - len(made))
    if isinstance(state, tuple):  # of attributes and slots
        state = tuple(_without_caches(each, kind) for each in state)
    return arguments, _without_caches(state, kind), *(tuple(each or ()) for each in items)


def _without_caches(state: Any, kind: type) -> Any:
    """The attributes of an object without the values of cached properties."""
    if not isinstance(state, dict):
        return state
    members = {name: each for base in reversed(kind.__mro__) for name, each in vars(base).items()}
    return {name: it for name, it in state.items() if not isinstance(members.get(name), cached_property)}


def _names(value: Any) -> Sequence[Any]:
    """Module and name of a compiled or cached function, and the function that it wraps."""
    names = getattr(value, "__module__", None), getattr(value, "__name__", None)
    return *names, getattr(value, "__dict__", {}).get("__wrapped__")


def _parts_of_code(code: CodeType) -> Sequence[Any]:
    """The instructions with the constants and names that they load, which leaves the docstring out."""
    instructions = tuple((each.opname, each.argval) for each in dis.get_instructions(code))
    arguments = code.co_argcount, code.co_posonlyargcount, code.co_kwonlyargcount, code.co_varnames
    return instructions, arguments, code.co_exceptiontable
