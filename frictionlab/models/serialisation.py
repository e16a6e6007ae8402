"""A model as data that JSON can hold, and back.

Reading creates only components: a class is looked up among the loaded subclasses of the base that its
role asks for, so that a file can neither import a module nor call anything else.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import fields
from typing import Any

from frictionlab.components.component import Component


def class_path(cls: type) -> str:
    """The class as "module:qualified name"."""
    return f"{cls.__module__}:{cls.__qualname__}"


def component_to_dict(component: Component) -> dict[str, Any]:
    """Class and fields of a component, those that are components in the same way."""
    values = {f.name: getattr(component, f.name) for f in fields(component)}
    return {
        "class": class_path(type(component)),
        "fields": {k: component_to_dict(v) if isinstance(v, Component) else v for k, v in values.items()},
    }


def component_from_dict(data: Mapping[str, Any], base: type) -> Any:
    """A component of the kind `base` from what :func:`component_to_dict` gave.

    Raises
    ------
    ValueError
        If the data is malformed, or its class is not loaded or no subclass of `base`.
    """
    if not isinstance(data, Mapping) or not isinstance(data.get("fields"), Mapping):
        raise ValueError(f"a {base.__name__} must be a mapping with 'class' and 'fields', got {data!r}")
    cls = _loaded_class(data.get("class"), base)
    roles: Mapping[str, type] = getattr(cls, "roles", {})
    values = {k: component_from_dict(v, roles[k]) if k in roles else v for k, v in data["fields"].items()}
    try:
        return cls(**values)
    except TypeError as error:
        raise ValueError(f"{cls.__name__} cannot be made from {dict(data['fields'])!r}: {error}") from error


def _loaded_class(name: object, base: type) -> type:
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
