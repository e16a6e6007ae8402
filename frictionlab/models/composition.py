"""The composition of a model: one namespace for its own parameters and those of its components.

Also the table of all parameters, as text and in a notebook, and the nonlinearities that can be switched off,
by name, each with the components that take its place.
"""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache, partial
from html import escape
from numbers import Real
from typing import TYPE_CHECKING, Any

from frictionlab.components.component import (
    Component,
    Parameter,
    get_annotations,
    parameters_of,
    structure_of,
    subclasses_of,
    value_repr,
)
from frictionlab.components.contact import (
    ContactLaw,
    FixedLoad,
    Geometry,
    Interface,
    LinearContact,
    SlidingOnly,
)
from frictionlab.models.serialisation import is_public
from frictionlab.presentation import html_rows, rotational_unit
from frictionlab.validation import abbreviate, did_you_mean, unknown_parameter, with_article

if TYPE_CHECKING:
    from frictionlab.models.model import Model, ModelOrAutomaton


def roles_of(cls: type, names: Mapping[str, Any]) -> dict[str, type]:
    """The fields that hold laws, each with the kind of law that its annotation names.

    Parameters
    ----------
    cls : type
        A dataclass; those of its fields that are roles of its base class are left out.
    names : mapping
        What is known where the class is defined, for annotations that are texts.

    Raises
    ------
    TypeError
        Where a field that is annotated as a law has none as its default, or a law an annotation that is not
        known there.
    """
    fields = {field.name: field for field in dataclasses.fields(cls)}
    own, known = get_annotations(cls), getattr(super(cls, cls), "roles", {})
    roles = {}
    for name in [name for name in own if name in fields] + [
        name for name in fields if name not in own and name not in known
    ]:
        kind, default = _annotated_kind(fields[name].type, names), fields[name].default
        if kind is None and isinstance(default, Component):
            raise TypeError(
                f"the annotation of {name} in {cls.__name__} must name a kind of law, "
                f"got {abbreviate(fields[name].type)}, which is not known there: import it"
            )
        if isinstance(kind, type) and issubclass(kind, Component):
            given = None if default is dataclasses.MISSING else default
            check_component(f"the default of {name} in {cls.__name__}", kind, given)
            roles[name] = kind
    return roles


def _annotated_kind(annotation: Any, names: Mapping[str, Any]) -> Any:
    """What an annotation stands for; None for a text whose names are not known.

    The text is the user's own code, which Python would have evaluated without `from __future__ import
    annotations`.
    """
    text = getattr(
        annotation, "__forward_arg__", annotation
    )  # Python 3.14 gives names that it does not know so
    if not isinstance(text, str):
        return annotation
    try:
        return eval(text, dict(names))
    except (NameError, AttributeError, SyntaxError, TypeError):
        return None


@cache
def structural_fields(cls: type) -> tuple[str, ...]:
    """Names of a model's structural fields, which are neither parameters nor components with a role.

    Such are a number of masses, or the name of a variant.
    """
    roles = getattr(cls, "roles", {})
    return tuple(name for name in structure_of(cls) if name not in roles)


def structural_defaults(cls: type) -> dict[str, Any]:
    """Defaults of the structural fields that have one."""
    defaults = {}
    for field in (f for f in dataclasses.fields(cls) if f.name in structural_fields(cls)):
        if field.default is not dataclasses.MISSING:
            defaults[field.name] = field.default
        elif field.default_factory is not dataclasses.MISSING:
            defaults[field.name] = field.default_factory()
    return defaults


def structural_values(cls: type, given: dict[str, Any]) -> dict[str, Any]:
    """Values of the structural fields; takes them out of `given`, the keywords of a constructor.

    Raises
    ------
    TypeError
        If one without a default is missing.
    """
    names, usual = structural_fields(cls), structural_defaults(cls) if structural_fields(cls) else {}
    values = {**usual, **{name: given.pop(name) for name in names if name in given}}
    for name in names:
        if name not in values:
            raise TypeError(
                f"{cls.__name__} needs {name}, which has no default: write {cls.__name__}({name}=...)"
            )
    return values


def parameter_owners(cls: type, components: Mapping[str, Component]) -> dict[str, str]:
    """The owner of each parameter: a component's role, or "" for the model.

    Raises
    ------
    ValueError
        If a parameter of a component has a name that is already taken, or that of an attribute of the class.
    """
    owners = dict.fromkeys(parameters_of(cls), "")
    taken = {*owners, *components, *structural_fields(cls)}
    for role, component in components.items():
        for name in parameters_of(type(component)):
            if name in taken:
                law = type(component).__name__
                raise ValueError(
                    f"parameter {name!r} of {law} must differ from the model's {name!r}: rename it, or write "
                    f"{role}: object, which makes the law part of the structure"
                )
            if hasattr(cls, name):
                law = type(component).__name__
                cure = f"write {role} = {law}({name}=...), or rename it"
                raise ValueError(
                    f"{name!r} of {cls.__name__} must not hide the parameter of {law}: "
                    + (cure if is_number_of_class(cls, name) else f"rename that of {law}")
                )
            taken.add(name)
            owners[name] = role
    return owners


def is_number_of_class(cls: type, name: str) -> bool:
    """Whether what a class and its bases have under a name are numbers and fields, if it is anything."""
    return all(isinstance(vars(kind).get(name, 0), Real | dataclasses.Field) for kind in cls.__mro__)


def parameter_unit(model: ModelOrAutomaton, name: str) -> str:
    """Unit of a parameter of a model; "" for a parameter of an automaton, which has no metadata."""
    if getattr(model, "components", None) is None:
        return ""
    about = parameters_of_model(model).get(name)
    return about.unit if about else ""


def refuse_positional(values: tuple[Any, ...], cls: type) -> None:
    """Raise TypeError if a constructor was given positional arguments."""
    if values:
        name, of = cls.__name__, next(iter(inspect.signature(cls).parameters), "name")
        raise TypeError(
            f"{name} takes its parameters by name, got {abbreviate(values[0])}: write {name}({of}=...)"
        )


def refuse_unknown(
    given: Iterable[str], cls: Any, parameters: Iterable[str], components: Mapping[str, Component]
) -> None:
    """Raise TypeError for the first name that is no parameter, component or structural field."""
    names = [*parameters, *components, *structural_fields(cls)]
    for name in given:
        if name not in names:
            raise unknown_parameter(cls.__name__, name, names, owner_hint(name, cls, components))


def check_component(role: str, base: type, component: object) -> Component:
    """The component, if it may take that role.

    Raises
    ------
    TypeError
        If it is of another kind, or a class instead of an object.
    """
    if isinstance(component, base) and isinstance(component, Component):
        return component
    if isinstance(component, type):
        name = component.__name__
        raise TypeError(f"{role} must be {with_article(base)}, got the class {name}: write {name}()")
    names = [kind.__name__ for kind in _laws_of_library(base)]
    if isinstance(component, str) and component in names:
        raise TypeError(
            f"{role} must be {with_article(base)}, got the text {component!r}: write {component}()"
        )
    kinds = ", ".join(f"{name}()" for name in names)
    raise TypeError(
        f"{role} must be {with_article(base)}, got {abbreviate(component)}: take {kinds}, or a class of "
        f"your own that derives from {base.__name__}"
    )


def with_values(component: Component, values: Mapping[str, float]) -> Component:
    """The component with these values of parameters."""
    return dataclasses.replace(component, **values) if values else component


def model_signature(cls: type, components: Mapping[str, Component]) -> inspect.Signature:
    """All keywords of a model with their defaults, for tab completion and help."""
    values: dict[str, Any] = {name: about.default for name, about in parameters_of(cls).items()}
    for component in components.values():
        values |= {name: getattr(component, name) for name in parameters_of(type(component))}
    keyword = inspect.Parameter.KEYWORD_ONLY
    values |= dict.fromkeys(structural_fields(cls), inspect.Parameter.empty) | structural_defaults(cls)
    return inspect.Signature(
        [inspect.Parameter(k, keyword, default=v) for k, v in (values | dict(components)).items()]
    )


def parameter_metadata(cls: type, components: Mapping[str, Component]) -> dict[str, Parameter]:
    """Symbol, unit, meaning and bounds of each parameter of the namespace, by name."""
    metadata = dict(parameters_of(cls))
    for component in components.values():
        metadata |= parameters_of(type(component))
    return metadata


def parameters_of_model(model: Any, moving_as: Any = None) -> dict[str, Parameter]:
    """The same of a model; the laws of contacts whose bodies turn have units of angles and moments.

    Where one law serves contacts of both kinds, the parameters whose units differ have no unit.  Bodies move
    alike in models that differ in their laws alone: then one model, `moving_as`, stands for all.  Which
    contacts turn follows from the mechanics, which are derived only where a law has such a parameter.
    """
    about = parameter_metadata(type(model), model.components)
    of_laws = {role: parameters_of(type(law)) for role, law in model.components.items()}
    turned = {
        role: {name: unit for name, each in some.items() if (unit := rotational_unit(each.unit)) != each.unit}
        for role, some in of_laws.items()
    }
    for role, alone in (moving_as or model).turning_roles.items() if any(turned.values()) else ():
        for name, unit in turned[role].items():
            about[name] = dataclasses.replace(about[name], unit=unit if alone else "")
    return about


def _laws_of_library(base: type) -> list[type]:
    """The library's laws of a kind; those of a session are no help to one who has mistyped a name."""
    return [kind for kind in subclasses_of(base) if kind is not base and is_public(kind)]


def owner_hint(name: Any, cls: Any, components: Mapping[str, Component]) -> str:
    """The end of a message: the class has a constant of the name, or a law of the library the parameter."""
    if not isinstance(name, str):
        return ""
    constant = getattr(cls, name, None)
    if isinstance(constant, Real) and not isinstance(constant, bool):
        return f", but a constant: write {name}: float = {constant!r} in the class"
    for role, base in cls.roles.items():
        for kind in _laws_of_library(base):
            if name in parameters_of(kind):
                return f": it belongs to {kind.__name__}, and {role} is {components[role]!r}"
    return ""


@dataclass(frozen=True)
class ParameterRow:
    """One parameter."""

    name: str
    symbol: str
    value: float
    unit: str
    meaning: str
    owner: str


@dataclass(frozen=True, repr=False)
class ParameterTable:
    """Rows of name, symbol (LaTeX), value, unit, meaning and owner; prints as a table."""

    title: str
    rows: tuple[ParameterRow, ...]

    def __iter__(self) -> Iterator[ParameterRow]:
        return iter(self.rows)

    def __len__(self) -> int:
        return len(self.rows)

    def __repr__(self) -> str:
        lines = [(r.name, f"{r.value:g}", r.unit, r.meaning, r.owner) for r in self.rows]
        table = [("name", "value", "unit", "meaning", "of"), *lines]
        widths = [max(map(len, column)) for column in zip(*table, strict=True)]
        rows = (
            "  ".join(cell.ljust(w) for cell, w in zip(line, widths, strict=True)).rstrip() for line in table
        )
        return "\n".join([self.title, *rows])

    def _repr_html_(self) -> str:
        rows = ((f"${r.symbol}$", r.name, f"{r.value:g}", r.unit, r.meaning, r.owner) for r in self.rows)
        table = html_rows(("symbol", "name", "value", "unit", "meaning", "of"), rows)
        return f"<p>{escape(self.title)}</p>{table}"


def parameter_table(model: Model) -> ParameterTable:
    """The table of a model's parameters."""
    components = model.components
    about, owner = parameters_of_model(model), parameter_owners(type(model), components)
    names = {"": "structure"} | {role: type(component).__name__ for role, component in components.items()}
    rows = (
        ParameterRow(
            name, about[name].symbol, value, about[name].unit, about[name].meaning, names[owner[name]]
        )
        for name, value in model.parameters.items()
    )
    laws = [f"{role} {type(component).__name__}" for role, component in components.items()]
    other = [f"{name} {value_repr(getattr(model, name))}" for name in structural_fields(type(model))]
    return ParameterTable(f"{type(model).__name__}: {', '.join([*laws, *other])}", tuple(rows))


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

    def missing(self, model: Model) -> bool:
        """Whether the model is without it already."""
        try:
            return all(getattr(model, name) == value for name, value in self.without(model).items())
        except ValueError:  # nothing can take the place of this law, so the model has its nonlinearity
            return False


def nonlinearities_of(model: Model) -> dict[str, Nonlinearity]:
    """The nonlinearities that follow from a model's roles, in the order of `OF_COMPONENTS`."""
    nonlinearities = {}
    for name, (base, about, instead) in OF_COMPONENTS.items():
        for role in (role for role, kind in model.roles.items() if kind is base):
            nonlinearities[name] = Nonlinearity(about, partial(_replaced, role, instead))
    return nonlinearities


def _replaced(role: str, instead: Callable[[Any], Any], model: Model) -> dict[str, Any]:
    return {role: instead(getattr(model, role))}


def without(model: Model, names: tuple[str, ...]) -> dict[str, Any]:
    """The parameters and components, by name, that take the place of these nonlinearities.

    Raises
    ------
    ValueError
        For a name that is none of the model's nonlinearities, or where nothing can take a law's place.
    """
    known = model.nonlinearities
    if names and not known:
        raise ValueError(
            f"{type(model).__name__} has no nonlinearity to leave out by name, got {abbreviate(names)}: "
            "give it another law with replace(...)"
        )
    for name in names:
        if not isinstance(name, str) or name not in known:
            listed = ", ".join(map(repr, known))
            hint = did_you_mean(name, known) if isinstance(name, str) else f": write without({listed})"
            raise ValueError(f"a model can be without {listed}, got {abbreviate(name)}{hint}")
    return {key: value for name in names for key, value in known[name].without(model).items()}


def _linear(contact: Any) -> LinearContact:
    stiffness = getattr(contact, "k2", None)
    if stiffness is None:
        raise ValueError(
            f"{contact!r} has no k2 to keep without 'cubic': replace(contact=LinearContact(k2=...))"
        )
    return LinearContact(k2=stiffness)


# Name of a nonlinearity -> class of component that has it, label, and what takes the component's place.
OF_COMPONENTS: Mapping[str, tuple[type, str, Callable[[Any], Any]]] = {
    "cubic": (ContactLaw, "cubic contact", _linear),
    "nonsmooth": (Interface, "stick, slip, separation", lambda _: SlidingOnly()),
    "geometry": (Geometry, "moving load, tilting belt", lambda _: FixedLoad()),
}
