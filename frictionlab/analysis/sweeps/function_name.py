"""What files of sweeps know of a function: its name, and a digest of its code and of what it holds."""

from __future__ import annotations

import dis
from collections.abc import Callable, Iterable, Sequence
from dataclasses import fields, is_dataclass
from decimal import Decimal
from enum import Enum
from fractions import Fraction
from functools import partial
from hashlib import sha256
from operator import attrgetter, itemgetter, methodcaller
from pathlib import PurePath
from types import CellType, CodeType, FunctionType, MappingProxyType, MethodType, ModuleType
from typing import Any

import numpy as np

from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.presentation import FrozenMapping

PLAIN = int, float, complex, Fraction, Decimal, np.generic, str, bytes, range, PurePath, type(None)
DIGITS = 12


def function_name(function: Callable[..., Any]) -> str:
    """The name of a function with digits, by which files tell functions apart.

    The digits follow from its code, and from the content of its closure, its defaults, its partial arguments
    and the object whose method it is: numbers, texts, tuples, arrays, models, laws, functions, and frozen
    things, such as frozen dataclasses.  A run counts without the time that it took.  Of what may change while
    the function runs the type alone is seen: of lists, dictionaries, sets, caches, generators, and objects of
    ordinary classes.  So a number in a list is not seen, nor are docstrings, nor methods of classes, nor what
    the function takes from its module: functions which it calls may change.
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
        if isinstance(value, PLAIN) and not isinstance(value, Enum):
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
            keywords = tuple((value.__kwdefaults__ or {}).items())
            return value.__code__, value.__defaults__, keywords, value.__closure__
        if isinstance(value, MethodType):
            return value.__func__, value.__self__
        if isinstance(value, CellType):
            try:
                return (value.cell_contents,)
            except ValueError:  # of a name that has no value yet
                return ()
        if isinstance(value, partial):
            return value.func, value.args, tuple(value.keywords.items())
        if isinstance(value, (tuple, attrgetter, itemgetter, methodcaller)):
            return value if isinstance(value, tuple) else value.__reduce__()
        if isinstance(value, frozenset):
            return sorted(map(self.digest, value))  # its order is another one in each process
        return _parts_of_data(value)


def _parts_of_data(value: Any) -> Iterable[Any]:
    """The content of arrays, expressions and frozen things; of other objects a name, if they have one."""
    if isinstance(value, np.ndarray):
        items = tuple(value.flat) if value.dtype.hasobject else value.tobytes()
        return str(value.dtype), value.shape, items
    if hasattr(type(value), "tocoo"):  # a sparse array
        sparse = value.tocoo()
        return sparse.shape, sparse.row, sparse.col, sparse.data
    if hasattr(type(value), "free_symbols"):  # an expression of sympy
        from sympy import srepr

        return value.args or (srepr(value),)
    if isinstance(value, Trajectory):
        return value.raw, value.samples, value.quadratures, value.source, value.automaton.parameters
    if isinstance(value, (FrozenMapping, MappingProxyType)):
        return value.items()
    if isinstance(value, Enum):
        return (value.name,)
    if isinstance(value, slice):
        return value.start, value.stop, value.step
    if is_dataclass(value) and type(value).__dataclass_params__.frozen:  # pyright: ignore
        return [(each.name, getattr(value, each.name, None)) for each in fields(value)]
    return _parts_of_callable(value) if callable(value) else ()


def _parts_of_callable(value: Any) -> Sequence[Any]:
    """What a compiled or cached function is called, and the function that it wraps; nothing of others."""
    names = getattr(value, "__module__", None), getattr(value, "__name__", None)
    return *names, getattr(value, "__dict__", {}).get("__wrapped__")


def _parts_of_code(code: CodeType) -> Sequence[Any]:
    """The instructions with the constants and names that they load, which leaves the docstring out."""
    instructions = tuple((each.opname, each.argval) for each in dis.get_instructions(code))
    arguments = code.co_argcount, code.co_posonlyargcount, code.co_kwonlyargcount, code.co_varnames
    return instructions, arguments, code.co_exceptiontable
