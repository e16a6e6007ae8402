"""The nonlinearities of a model by name, each with the components that replace it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

from frictionlab.components.contact import ContactLaw, Interface, LinearContact, SlidingOnly
from frictionlab.components.geometry import FixedLoad, Geometry
from frictionlab.validation import did_you_mean


@dataclass(frozen=True)
class Nonlinearity:
    """A nonlinearity that can be switched off.

    Parameters
    ----------
    about : str
        Label in an explorer.
    without : callable
        Function of the model that returns the parameters and components, by name, that take its place.
    """

    about: str
    without: Callable[[Any], Mapping[str, Any]]

    def missing(self, model: Any) -> bool:
        """Whether the model is without it already."""
        try:
            return all(getattr(model, name) == value for name, value in self.without(model).items())
        except ValueError:  # a law that cannot do without its nonlinearity has it
            return False


def nonlinearities_of(model: Any) -> dict[str, Nonlinearity]:
    """The nonlinearities that follow from the classes of a model's components, in the order of its roles."""
    found = {}
    for name, (base, about, instead) in OF_COMPONENTS.items():
        for role in (role for role, kind in model.roles.items() if kind is base):
            found[name] = Nonlinearity(about, partial(_replaced, role, instead))
    return found


def _replaced(role: str, instead: Callable[[Any], Any], model: Any) -> dict[str, Any]:
    return {role: instead(getattr(model, role))}


def without(model: Any, names: tuple[str, ...]) -> dict[str, Any]:
    """The parameters and components to replace, by name, where the model is to be without some.

    Raises
    ------
    ValueError
        For a name that is none of the model's nonlinearities.
    """
    known = model.nonlinearities
    if names and not known:
        raise ValueError(
            f"{type(model).__name__} has no nonlinearity to leave out by name, got {names!r}: "
            "give it another law with replace(...)"
        )
    for name in names:
        if not isinstance(name, str) or name not in known:
            listed = ", ".join(map(repr, known))
            hint = did_you_mean(name, known) if isinstance(name, str) else f": write without({listed})"
            raise ValueError(f"a model can be without {listed}, got {name!r}{hint}")
    return {key: value for name in names for key, value in known[name].without(model).items()}


def _linear(contact: Any) -> LinearContact:
    stiffness = getattr(contact, "k2", None)
    if stiffness is None:
        raise ValueError(
            f"{contact!r} has no k2 to keep without 'cubic': replace(contact=LinearContact(k2=...))"
        )
    return LinearContact(k2=stiffness)


# Name -> class of component that has it, label, and what takes the component's place.
OF_COMPONENTS: Mapping[str, tuple[type, str, Callable[[Any], Any]]] = {
    "cubic": (ContactLaw, "cubic contact", _linear),
    "nonsmooth": (Interface, "stick, slip, separation", lambda _: SlidingOnly()),
    "geometry": (Geometry, "moving load, tilting belt", lambda _: FixedLoad()),
}
