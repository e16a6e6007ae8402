"""Models and their components as JSON data, in files of runs, sweeps and scenes.

Reading creates only components: a class is looked up among the loaded subclasses of the base that its role
asks for, so that a file can neither import a module nor call anything else.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from enum import Enum
from typing import Any

import frictionlab
from frictionlab.components.component import Component, StructureKey, structure_of, subclasses_of
from frictionlab.validation import MAX_CHARACTERS, abbreviate, with_article


def is_public(cls: type) -> bool:
    """Whether the class is one of frictionlab's public names."""
    return cls.__module__.startswith("frictionlab.") and cls.__qualname__ in frictionlab.__all__


def class_path(cls: type) -> str:
    """The class as "module:qualified name"; the module of the library's public classes is "frictionlab".

    So files can still be read after such a class has moved to another module of the library.
    """
    return f"{'frictionlab' if is_public(cls) else cls.__module__}:{cls.__qualname__}"


def component_to_dict(component: Component) -> dict[str, Any]:
    """Class and fields of a component; components in fields in the same way, tuples as lists.

    Raises
    ------
    TypeError
        If a field is not a number, text, truth value, None, enum, component, or a tuple of these.
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
    if getattr(value, "shape", None) == ():  # a numpy number, recognised without loading numpy
        number: Any = value
        value = number.item()
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    raise TypeError(
        f"{owner} holds {value!r}, which no file can hold: make it a number, a text, True or False, None, an "
        "enum, a component, or a tuple of these"
    )


class NotLoadedError(ValueError):
    """A class of which there is data is not defined in this session."""


def component_from_dict(data: Mapping[str, Any], base: type) -> Any:
    """A component of the kind `base` from what :func:`component_to_dict` gave.

    Raises
    ------
    ValueError
        If the data is malformed, or its class is not loaded or not a subclass of `base`.
    """
    if not isinstance(data, Mapping) or not isinstance(data.get("fields"), Mapping):
        raise ValueError(
            f"{with_article(base)} must be a mapping with 'class' and 'fields', got {abbreviate(data)}"
        )
    cls = loaded_class(data.get("class"), base)
    roles: Mapping[str, type] = getattr(cls, "roles", {})
    values = {
        name: component_from_dict(value, roles[name]) if name in roles else value_from_data(value)
        for name, value in data["fields"].items()
    }
    try:
        return cls(**values)
    except (TypeError, AttributeError) as error:
        given = abbreviate(dict(data["fields"]))
        raise ValueError(f"{cls.__name__} cannot be made from {given}: {error}") from error


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
        asked = abbreviate(data.get("name"))
        raise ValueError(f"{abbreviate(data.get('enum'))} must have {asked}, it has {', '.join(members)}")
    return members[data["name"]]


def loaded_class(name: object, base: type) -> type:
    """The subclass of `base` whose :func:`class_path` is `name`; ValueError where none is loaded."""
    home, _, public = str(name).partition(":")
    if home == "frictionlab" and public in frictionlab.__all__:
        getattr(frictionlab, public)  # names of the library are loaded when they are first used
    # The last one wins: a notebook cell that ran twice has defined its class twice.
    matching = [cls for cls in subclasses_of(base) if class_path(cls) == name]
    if matching:
        return matching[-1]
    module = str(name).partition(":")[0][:MAX_CHARACTERS]
    raise NotLoadedError(
        f"no {base.__name__} {abbreviate(name)} is loaded: import {module}, or run the cell that defines it, "
        "first"
    )


def structure_to_data(key: StructureKey) -> dict[str, Any]:
    """A structure as data: classes of a model and its components, and their fields that are no parameters.

    Raises
    ------
    TypeError
        For a field that no file can hold.
    """
    names, owner = structure_of(key.component), key.component.__name__
    values = {
        name: structure_to_data(value)
        if isinstance(value, StructureKey)
        else value_to_data(value, f"{owner}.{name}")
        for name, value in zip(names, key.values, strict=True)
    }
    return {"class": class_path(key.component), "structure": values}
