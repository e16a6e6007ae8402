"""A model as data that JSON can hold, and back.

Reading creates only components: a class is looked up among the loaded subclasses of the base that its
role asks for, so that a file can neither import a module nor call anything else.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import fields
from enum import Enum
from typing import Any

import frictionlab
from frictionlab.components.component import Component


def is_public(cls: type) -> bool:
    """Whether the class is a name of frictionlab's namespace."""
    return cls.__module__.startswith("frictionlab.") and cls.__qualname__ in frictionlab.__all__


def class_path(cls: type) -> str:
    """The class as "module:qualified name"; of the library's, that of its public name.

    So a file is read after the library's classes have moved among its modules.
    """
    return f"{'frictionlab' if is_public(cls) else cls.__module__}:{cls.__qualname__}"


def component_to_dict(component: Component) -> dict[str, Any]:
    """Class and fields of a component; components among them in the same way, tuples as lists.

    Raises
    ------
    TypeError
        For a field that is no number, text, truth value, None, enum, component, nor a tuple of such.
    """
    values = {f.name: getattr(component, f.name) for f in fields(component)}
    owner = type(component).__name__
    return {
        "class": class_path(type(component)),
        "fields": {name: value_to_data(value, f"{owner}.{name}") for name, value in values.items()},
    }


def value_to_data(value: Any, owner: str) -> Any:
    """The value of a field as data; `owner` names the field in errors."""
    if isinstance(value, Component):
        return component_to_dict(value)
    if isinstance(value, Enum) and value.name in type(value).__members__:
        return {"enum": class_path(type(value)), "name": value.name}
    if isinstance(value, tuple):
        return [value_to_data(each, owner) for each in value]
    if getattr(value, "shape", None) == ():  # a number of numpy, which is not loaded for this
        number: Any = value
        value = number.item()
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    raise TypeError(
        f"{owner} holds {value!r}, which no file can hold: make it a number, a text, True or False, None, an "
        "enum, a component, or a tuple of these"
    )


def component_from_dict(data: Mapping[str, Any], base: type) -> Any:
    """A component of the kind `base` from what :func:`component_to_dict` gave.

    Raises
    ------
    ValueError
        If the data is malformed, or its class is not loaded or no subclass of `base`.
    """
    if not isinstance(data, Mapping) or not isinstance(data.get("fields"), Mapping):
        raise ValueError(f"a {base.__name__} must be a mapping with 'class' and 'fields', got {data!r}")
    cls = loaded_class(data.get("class"), base)
    roles: Mapping[str, type] = getattr(cls, "roles", {})
    values = {
        name: component_from_dict(value, roles[name]) if name in roles else value_from_data(value)
        for name, value in data["fields"].items()
    }
    try:
        return cls(**values)
    except (TypeError, AttributeError) as error:
        raise ValueError(f"{cls.__name__} cannot be made from {dict(data['fields'])!r}: {error}") from error


def value_from_data(data: Any) -> Any:
    """The value that :func:`value_to_data` described."""
    if isinstance(data, (list, tuple)):
        return tuple(value_from_data(each) for each in data)
    if not isinstance(data, Mapping):
        return data
    if "class" in data:
        return component_from_dict(data, Component)
    members = getattr(loaded_class(data.get("enum"), Enum), "__members__", {})
    if data.get("name") not in members:
        raise ValueError(f"{data.get('enum')} must have {data.get('name')!r}, it has {', '.join(members)}")
    return members[data["name"]]


def loaded_class(name: object, base: type) -> type:
    """The subclass of `base` of that path; ValueError where none is loaded."""
    # The last one wins: a notebook cell that ran twice has defined its class twice.
    found = [cls for cls in _subclasses(base) if class_path(cls) == name]
    if found:
        return found[-1]
    module = str(name).partition(":")[0]
    raise ValueError(
        f"no {base.__name__} {name!r} is loaded: import {module}, or run the cell that defines it, first"
    )


def _subclasses(base: type) -> Iterator[type]:
    yield base
    for cls in base.__subclasses__():
        yield from _subclasses(cls)
