"""What the equations of a class of one's own depend on beside its fields: methods, and numbers around them.

A notebook has ``g = 9.81`` in one cell and a model that uses it in another.  The first cell may be run again
with another number, and a method of the class may be replaced.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from dis import get_instructions
from enum import Enum
from functools import cache, cached_property, partial
from hashlib import sha256
from numbers import Number
from types import CodeType, FunctionType, MemberDescriptorType, SimpleNamespace
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

    Empty for classes of the library.  Functions of the same module, those that a decorator wraps, and what
    methods name of objects of one's own classes are followed, other modules are not.
    """
    notes: dict[str, Any] = {}
    seen: set[Any] = set()
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


def _note(
    name: str, value: Any, notes: dict[str, Any], seen: set[Any], attributes: tuple[str, ...] = ()
) -> None:
    """Note a value, a function and what it uses, or the `attributes` of an object."""
    for each in HOLDERS.get(type(value), ()):
        _note(f"{name}.{each}", getattr(value, each), notes, seen)
    if isinstance(value, FunctionType):
        if value not in seen:
            seen.add(value)
            notes[name] = _instructions(value.__code__)
            for each, inner in _used(value):
                _note(f"{name}.{each}", inner, notes, seen, _attributes(value.__code__))
    elif (plain := _plain(value)) is not None:
        notes[name] = plain
    elif attributes and _is_own(value if isinstance(value, type) else type(value)):
        names = _with_those_of_methods(value, attributes)
        if (id(value), names) not in seen:
            seen.add((id(value), names))
            for each in names:
                if (held := _held(value, each)) is not None:
                    _note(f"{name}.{each}", held, notes, seen, names)


@cache
def _is_own(kind: type) -> bool:
    """Whether a class is somebody's own, of no package that is installed; or a namespace."""
    file = getattr(sys.modules.get(kind.__module__), "__file__", None) or ""
    package = kind.__module__.partition(".")[0]
    known = package == "frictionlab" or package in sys.stdlib_module_names or "-packages" in file
    return kind is SimpleNamespace or package == "__main__" or not known


def _held(value: Any, name: str) -> Any:
    """An attribute of an object, the property itself of one that is computed; None where it has none.

    As `inspect.getattr_static`, which looks at each base several times: half the time of a digest.
    """
    kind: Any = type(value)
    classes = value.__mro__ if isinstance(value, type) else ()
    bases = (each.__dict__ for each in (*classes, *kind.__mro__))
    held = next((base[name] for base in bases if name in base), None)
    if isinstance(held, MemberDescriptorType):
        return getattr(value, name, None)
    if not classes and not hasattr(type(held), "__set__"):
        try:
            return object.__getattribute__(value, "__dict__").get(name, held)
        except AttributeError:  # it has slots alone
            return held
    return held


def _with_those_of_methods(value: Any, attributes: tuple[str, ...]) -> tuple[str, ...]:
    """Names of attributes, and of those that methods among them name."""
    names = [*attributes]
    for name in names:
        method = _held(value, name)
        code = getattr(getattr(method, "fget", method), "__code__", None)
        names += () if code is None else [each for each in _attributes(code) if each not in names]
    return tuple(names)


@cache
def _attributes(code: CodeType) -> tuple[str, ...]:
    """Names of attributes, and others, that a function mentions."""
    inner = (name for each in code.co_consts if isinstance(each, CodeType) for name in _attributes(each))
    return tuple(dict.fromkeys((*code.co_names, *inner)))


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
        if not isinstance(value, FunctionType) or value.__globals__ is function.__globals__:
            yield name, value


@cache
def _names(code: CodeType) -> tuple[str, ...]:
    """Names that a function looks up in its module, without those of attributes."""
    own = (one.argval for one in get_instructions(code) if one.opname == "LOAD_GLOBAL")
    inner = (name for each in code.co_consts if isinstance(each, CodeType) for name in _names(each))
    return tuple(dict.fromkeys((*own, *inner)))


def _plain(value: Any) -> Any:
    """A number, text, enum, array, table, law, or a collection of such as something to print; else None."""
    if isinstance(value, (Number, str, bytes, Enum)):
        return type(value), value
    if isinstance(value, (tuple, list)):
        return type(value), tuple(map(_plain, value))
    if isinstance(value, (set, frozenset)):
        return type(value), sorted(map(repr, map(_plain, value)))
    if isinstance(value, dict):
        return dict, tuple((name, _plain(each)) for name, each in value.items())
    if type(value).__module__ == "numpy" and hasattr(value, "tobytes"):
        if value.dtype.hasobject:
            return _plain(value.tolist())
        return value.dtype.str, value.shape, sha256(value.tobytes()).hexdigest()
    if isinstance(value, type):
        return None
    if hasattr(type(value), "to_numpy"):
        return [_plain(one.to_numpy()) for one in getattr(value, "axes", ())], _plain(value.to_numpy())
    if is_dataclass(value) and type(value).__module__.partition(".")[0] == "frictionlab":
        return type(value).__qualname__, tuple(_plain(getattr(value, each.name)) for each in fields(value))
    return None
