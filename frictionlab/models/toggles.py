"""The three nonlinearities of the paper, each with the component that a model has without it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

from frictionlab.components.component import Component
from frictionlab.components.contact import LinearContact
from frictionlab.components.geometry import FixedLoad
from frictionlab.components.interface import SlidingOnly
from frictionlab.components.names import did_you_mean


def replacements(model: Any, names: tuple[str, ...]) -> dict[str, Component]:
    """The components to replace, by role.

    Raises
    ------
    ValueError
        If a name is none of "cubic", "nonsmooth", "geometry".
    """
    for name in names:
        if not isinstance(name, str) or name not in TOGGLES:
            known = ", ".join(map(repr, TOGGLES))
            hint = did_you_mean(name, TOGGLES) if isinstance(name, str) else f"write without({known})"
            raise ValueError(f"a model can be without {known}, got {name!r}: {hint}")
    return dict(TOGGLES[name](model) for name in names)


def _linear(model: Any) -> tuple[str, Component]:
    stiffness = getattr(model.contact, "k2", None)
    if stiffness is None:
        raise ValueError(
            f"{model.contact!r} has no k2 to keep without 'cubic': replace(contact=LinearContact(k2=...))"
        )
    return "contact", LinearContact(k2=stiffness)


def _smooth(model: Any) -> tuple[str, Component]:
    return "interface", SlidingOnly()


def _fixed(model: Any) -> tuple[str, Component]:
    return "geometry", FixedLoad()


TOGGLES: Mapping[str, Callable[[Any], tuple[str, Component]]] = MappingProxyType(
    {"cubic": _linear, "nonsmooth": _smooth, "geometry": _fixed}
)
