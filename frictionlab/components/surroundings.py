"""What the equations of a class of one's own depend on beside its fields: methods, and numbers around them.

A notebook has ``g = 9.81`` in one cell and a model that uses it in another.  The first cell may be run again
with another number, and a method of the class may be replaced.
"""

from __future__ import annotations

from collections.abc import Iterator
from dis import get_instructions
from enum import Enum
from functools import cache, cached_property, partial
from hashlib import sha256
from numbers import Number
from types import CodeType, FunctionType
from typing import Any

PYTHONS = "abc", "builtins", "dataclasses", "enum", "typing"
# What holds functions and values, and where.
HOLDERS = {
    property: ("fget",),
    cached_property: ("func",),
    classmethod: ("__func__",),
    staticmethod: ("__func__",),
    partial: ("func", "args", "keywords"),
}


def surroundings_of(kind: type) -> str:
    """Digest of the methods of a class and its bases, and of the numbers, texts and arrays that they use.

    Empty for classes of the library.  Functions of the same module and those that a decorator wraps are
    followed, other modules are not.
    """
    notes: dict[str, Any] = {}
    seen: set[FunctionType] = set()
    for cls in _own_classes(kind):
        for name, value in vars(cls).items():
            if not name.startswith("__"):
                _note(f"{cls.__qualname__}.{name}", value, notes, seen)
    return sha256(repr(notes).encode()).hexdigest() if notes else ""


@cache
def _own_classes(kind: type) -> tuple[type, ...]:
    return tuple(
        cls for cls in kind.__mro__ if cls.__module__.partition(".")[0] not in ("frictionlab", *PYTHONS)
    )


def _note(name: str, value: Any, notes: dict[str, Any], seen: set[FunctionType]) -> None:
    """Note a value, or a function and what it uses."""
    for each in HOLDERS.get(type(value), ()):
        _note(f"{name}.{each}", getattr(value, each), notes, seen)
    if isinstance(value, FunctionType):
        if value not in seen:
            seen.add(value)
            notes[name] = _instructions(value.__code__)
            for each, inner in _used(value):
                _note(f"{name}.{each}", inner, notes, seen)
    elif (plain := _plain(value)) is not None:
        notes[name] = plain


@cache
def _instructions(code: CodeType) -> tuple[Any, ...]:
    """What a function does, without the lines of its text."""
    constants = (_instructions(one) if isinstance(one, CodeType) else _plain(one) for one in code.co_consts)
    return code.co_code, code.co_names, code.co_varnames, tuple(constants)


def _used(function: FunctionType) -> Iterator[tuple[str, Any]]:
    """What a function finds by name: defaults, variables of functions around it, and of its module."""
    yield "defaults", function.__defaults__
    for name, cell in zip(function.__code__.co_freevars, function.__closure__ or (), strict=True):
        try:
            yield name, cell.cell_contents
        except ValueError:  # it has no value yet
            continue
    for name in _names(function.__code__):
        value = function.__globals__.get(name)
        if getattr(value, "__globals__", function.__globals__) is function.__globals__:
            yield name, value


@cache
def _names(code: CodeType) -> tuple[str, ...]:
    """Names that a function looks up in its module, without those of attributes."""
    own = (one.argval for one in get_instructions(code) if one.opname == "LOAD_GLOBAL")
    inner = (name for each in code.co_consts if isinstance(each, CodeType) for name in _names(each))
    return tuple(dict.fromkeys((*own, *inner)))


def _plain(value: Any) -> Any:
    """A number, text, enum, array, or a collection of such as something to print; None for all else."""
    if isinstance(value, (Number, str, bytes, Enum)):
        return type(value), value
    if isinstance(value, (tuple, list)):
        return type(value), tuple(map(_plain, value))
    if isinstance(value, (set, frozenset)):
        return type(value), sorted(map(repr, map(_plain, value)))
    if isinstance(value, dict):
        return dict, tuple((name, _plain(each)) for name, each in value.items())
    if type(value).__module__ == "numpy" and hasattr(value, "tobytes") and not value.dtype.hasobject:
        return value.dtype.str, value.shape, sha256(value.tobytes()).hexdigest()
    return None
