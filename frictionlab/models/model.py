"""What every model has: one namespace of parameters, copies with changes, a description, an automaton."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Self, TypeVar

from frictionlab.components.component import Component
from frictionlab.components.parameter import parameters_of

from .description import Description, describe
from .namespace import changed, chosen, owners, refuse_unknown, signature
from .serialise import component_from_dict, component_to_dict

if TYPE_CHECKING:
    from frictionlab.automaton import HybridAutomaton

    from .equations import Equations

M = TypeVar("M", bound="Model")


@dataclass(frozen=True, init=False, repr=False)
class Model(Component):
    """Base of the models: a frozen composition of parameters and components.

    A subclass names in `roles` which component fields it has, and of which kind.  Keywords of the
    constructor are those fields and every parameter, whether the model's own or a component's.
    """

    roles: ClassVar[Mapping[str, type]] = MappingProxyType({})
    __signature__: ClassVar[inspect.Signature]

    def __init__(self, **given: Any) -> None:
        cls = type(self)
        components = {
            role: chosen(role, base, given.pop(role, getattr(cls, role))) for role, base in self.roles.items()
        }
        refuse_unknown(given, cls, self.roles, components)
        for name, about in parameters_of(cls).items():
            object.__setattr__(self, name, given.get(name, about.default))
        owner = owners(cls, components)
        for role, component in components.items():
            values = {name: value for name, value in given.items() if owner[name] == role}
            object.__setattr__(self, role, changed(component, values))
        self.__post_init__()

    @property
    def components(self) -> Mapping[str, Component]:
        """Role -> component."""
        return MappingProxyType({role: getattr(self, role) for role in self.roles})

    @property
    def parameters(self) -> Mapping[str, float]:
        """Name -> value of every parameter (SI units), read-only; change them with :meth:`replace`."""
        values = {name: getattr(self, name) for name in parameters_of(type(self))}
        for role in self.roles:
            component = getattr(self, role)
            for name in parameters_of(type(component)):
                values[name] = getattr(component, name)
        return MappingProxyType(values)

    def replace(self, **changes: Any) -> Self:
        """A new model with other parameters or components.

        A new component comes with its own parameters; parameters named as well overwrite them.

        Raises
        ------
        TypeError
            For an unknown name.
        ValueError
            For a value that breaks a rule.
        """
        own = {name: getattr(self, name) for name in parameters_of(type(self))}
        return type(self)(**{**own, **self.components, **changes})

    def describe(self) -> Description:
        """Table of the parameters: symbol, value, unit, meaning."""
        return describe(self)

    def automaton(self) -> HybridAutomaton:
        """The hybrid automaton; models that differ in numbers only share its `modes` object."""
        from .assembly import automaton

        return automaton(self)

    def equations(self, mode: str) -> Equations:
        """The equations of a mode (or of the "impact") as sympy equations; LaTeX in a notebook."""
        from .equations import equations

        return equations(self, mode)

    def to_dict(self) -> dict[str, Any]:
        """The model as data that JSON can hold."""
        return component_to_dict(self)

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Self:
        """The model that :meth:`to_dict` described.

        Raises
        ------
        ValueError
            If the data is malformed, or a law of your own is not defined in this session.
        """
        return component_from_dict(data, cls)

    def __getattr__(self, name: str) -> Any:
        # Reached only for what is no field: a component's parameter, model.mu_k.
        if not name.startswith("_"):
            for role in type(self).roles:
                component = self.__dict__.get(role)
                if component is not None and name in parameters_of(type(component)):
                    return getattr(component, name)
        raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self.parameters]

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(_differences(self))})"


def with_signature(cls: type[M]) -> type[M]:
    """Give a model class the signature that help and tab completion show."""
    cls.__signature__ = signature(cls, {role: getattr(cls, role) for role in cls.roles})
    return cls


def _differences(model: Model) -> list[str]:
    """What differs from the defaults, as keywords that make the model again."""
    usual = type(model)()
    same = {
        role for role, component in model.components.items() if type(component) is type(getattr(usual, role))
    }
    names = owners(type(model), model.components)
    values = [
        n for n, role in names.items() if not role or (role in same and not _restructured(model, usual, role))
    ]
    texts = [f"{n}={model.parameters[n]!r}" for n in values if model.parameters[n] != usual.parameters[n]]
    whole = [role for role in model.roles if role not in same or _restructured(model, usual, role)]
    return texts + [f"{role}={getattr(model, role)!r}" for role in whole]


def _restructured(model: Model, usual: Model, role: str) -> bool:
    """Whether a component of the default's class differs in more than parameters."""
    mine, its = getattr(model, role), getattr(usual, role)
    return changed(its, {n: getattr(mine, n) for n in parameters_of(type(its))}) != mine
