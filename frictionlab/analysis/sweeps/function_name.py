"""What files of sweeps know of a function: its name, and a digest of its code and of what it holds."""

from __future__ import annotations

import dis
from collections.abc import Callable, Iterable, Mapping, Sequence, Set
from dataclasses import fields, is_dataclass
from hashlib import sha256
from types import CellType, CodeType, FunctionType, MethodType, ModuleType
from typing import Any

PLAIN = bool, int, float, complex, str, bytes, type(None)
DIGITS = 12


def function_name(function: Callable[..., Any]) -> str:
    """The name of a function with digits, by which files tell functions apart.

    The digits follow from its code, and from the content of its closure, its defaults, its partial arguments
    and the object whose method it is: numbers, texts, arrays, models, functions, and what holds such.  They
    do not follow from docstrings.  What it takes from its module is not seen, so that functions which it
    calls may change, nor are methods of classes.  Of what cannot be copied, such as an open file or a lock,
    the type alone is seen.  A function that changes what it holds, such as a list of its calls, is another
    one afterwards.
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
        if is_dataclass(value):
            return [(each.name, getattr(value, each.name, None)) for each in fields(value)]
        if isinstance(value, Mapping):
            return value.items()
        if isinstance(value, Set):
            return sorted(map(self.digest, value))  # its order is another one in each process
        return value if type(value) in (tuple, list) else _parts_of_copy(value)


def _parts_of_code(code: CodeType) -> Sequence[Any]:
    """The instructions with the constants and names that they load, which leaves the docstring out."""
    instructions = [(each.opname, each.argval) for each in dis.get_instructions(code)]
    arguments = code.co_argcount, code.co_posonlyargcount, code.co_kwonlyargcount, code.co_varnames
    return instructions, arguments, code.co_exceptiontable


def _parts_of_copy(value: Any) -> Sequence[Any]:
    """What a copy of an object would be made from; nothing of one that cannot be copied."""
    try:
        made = value.__reduce_ex__(2)
    except Exception:  # an object may raise what it likes
        return ()
    if isinstance(made, str):  # it is found by its name
        return made, getattr(value, "__wrapped__", None)
    return [*made[1:3], *map(list, filter(None, made[3:5]))]
