"""The base of every component: a frozen dataclass whose parameters are checked when it is made.

A parameter is a field that holds a physical number, with unit, symbol, meaning and range.
"""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, fields
from enum import Enum
from functools import cache, cached_property, partial
from inspect import Parameter as Argument
from inspect import signature
from math import isfinite
from numbers import Real
from types import MappingProxyType
from typing import Any, NamedTuple, Self, TypedDict, Unpack

from frictionlab.components.surroundings import surroundings_of
from frictionlab.letters import symbol_of
from frictionlab.validation import (
    abbreviate,
    check_flag,
    check_keywords,
    check_limits,
    check_number,
    check_text,
    plain_number,
    unknown_parameter,
)

if sys.version_info >= (3, 14):  # where an annotation may name what is defined later
    from annotationlib import Format
    from annotationlib import get_annotations as annotations_in

    get_annotations = partial(annotations_in, format=Format.FORWARDREF)
else:
    from inspect import get_annotations

METADATA_KEY = "frictionlab parameter"


@dataclass(frozen=True)
class Parameter:
    """What is known about a parameter besides its value.

    Parameters
    ----------
    symbol : str
        LaTeX, without dollars.
    unit : str
        SI; empty for a pure number.
    meaning : str
        One phrase.
    default : float or None
        None where the field has none.
    minimum, exclusive_minimum, maximum : float or None
        Bounds of the admissible values.
    range : (float, float) or None
        Where a slider for it starts and ends.
    log : bool
        Whether that slider is logarithmic.
    """

    symbol: str = ""
    unit: str = ""
    meaning: str = ""
    default: float | None = None
    minimum: float | None = None
    exclusive_minimum: float | None = None
    maximum: float | None = None
    range: tuple[float, float] | None = None
    log: bool = False


class ParameterKeywords(TypedDict, total=False):
    """The keywords of :func:`parameter`, for editors and type checkers: the fields of :class:`Parameter`."""

    unit: str
    symbol: str
    meaning: str
    minimum: float | None
    exclusive_minimum: float | None
    maximum: float | None
    range: tuple[float, float] | None
    log: bool


def parameter(default: float, **about: Unpack[ParameterKeywords]) -> Any:
    """A dataclass field that is a parameter of its component.

    The keywords are those of :class:`Parameter`.  In a law of your own::

        @dataclass(frozen=True)
        class Hertz(ContactLaw):
            k_h: float = parameter(1e6, unit="N/m^1.5", symbol="k_H", meaning="Hertz stiffness", minimum=0.0)

            def force(self, penetration):
                return self.k_h * penetration**1.5

    Raises
    ------
    TypeError
        If the default is no number, or for an unknown keyword.
    ValueError
        If the range is not two numbers in ascending order, above 0 for a logarithmic slider.
    """
    _check_default(default)
    check_keywords("parameter", about, ParameterKeywords.__annotations__)
    record = Parameter(default=default, **about)
    _check_metadata(record)
    return dataclasses.field(default=default, metadata={METADATA_KEY: record})


def _check_default(default: Any) -> None:
    if isinstance(default, bool) or not isinstance(default, Real):
        raise TypeError(
            f"the default of a parameter must be a number, "
            f"got {abbreviate(default)}: give a float, or make the field "
            "one without parameter(...)"
        )


def _check_metadata(about: Parameter) -> None:
    for name in ("unit", "symbol", "meaning"):
        check_text(name, getattr(about, name), "leave it out for none")
    for name in ("minimum", "exclusive_minimum", "maximum"):
        if (bound := getattr(about, name)) is not None:
            check_number(name, bound, cure="leave it out for no bound")
    check_flag("log", about.log)
    if about.range is not None:
        check_limits(
            "range",
            about.range,
            "give (low, high), the ends of a slider",
            positive="where log=True" if about.log else "",
        )


@cache
def parameters_of(component: type) -> Mapping[str, Parameter]:
    """The parameters of a component class by name, in the order of its fields.

    A plain ``float`` field counts as a parameter without unit; every other field is *structure*.
    """
    _refuse_undecorated(component)
    metadata = {f.name: parameter_of_field(f) for f in dataclasses.fields(component)}
    return MappingProxyType({name: about for name, about in metadata.items() if about is not None})


@cache
def structure_of(component: type) -> tuple[str, ...]:
    """Names of the fields that are not parameters: they change the equations, not the numbers in them."""
    names = (f.name for f in dataclasses.fields(component))
    return tuple(name for name in names if name not in parameters_of(component))


def parameter_of_field(field: dataclasses.Field[Any]) -> Parameter | None:
    """What is known of a field that is a parameter; None for any other."""
    about = field.metadata.get(METADATA_KEY)
    if about is not None:
        return about if about.symbol else dataclasses.replace(about, symbol=symbol_of(field.name))
    if field.type not in (float, "float"):
        return None
    return Parameter(
        symbol_of(field.name), default=None if field.default is dataclasses.MISSING else field.default
    )


def is_decorated(component: type) -> bool:
    """Whether a class that adds fields is a dataclass: else these would silently not be parameters."""
    adds = get_annotations(component) or "__init__" in component.__dict__
    return not adds or "__dataclass_fields__" in component.__dict__


def _refuse_undecorated(component: type) -> None:
    if not is_decorated(component):
        raise TypeError(
            f"{component.__name__} has fields but is no dataclass: write each as mu: float = 0.5, without an "
            "__init__, and @dataclass(frozen=True) above the class"
        )


def check_value(name: str, value: Any, about: Parameter) -> float:
    """The value as a float, if it is a finite real number within its bounds.

    Raises
    ------
    TypeError
        If it is no real number: text, a truth value, a complex number, an array.
    ValueError
        If it is not finite or out of bounds.
    """
    quick = type(value) is float and isfinite(value)
    number = value if quick else _finite_number(name, plain_number(value), about)
    if about.exclusive_minimum is not None and not number > about.exclusive_minimum:
        raise ValueError(
            _value_message(name, f"greater than {about.exclusive_minimum:g}", number, f"raise {name}", about)
        )
    if about.minimum is not None and not number >= about.minimum:
        raise ValueError(_value_message(name, f"at least {about.minimum:g}", number, f"raise {name}", about))
    if about.maximum is not None and not number <= about.maximum:
        raise ValueError(_value_message(name, f"at most {about.maximum:g}", number, f"lower {name}", about))
    return number


def _finite_number(name: str, value: Any, about: Parameter) -> float:
    if isinstance(value, bool) or not isinstance(value, Real):
        what = f"{abbreviate(value)} ({type(value).__name__})"
        raise TypeError(_value_message(name, "one real number", what, "give a float", about))
    try:
        number = float(value)
    except OverflowError:
        number = float("inf")
    if not isfinite(number):
        raise ValueError(_value_message(name, "a finite number", number, "give a float", about))
    return number


def _value_message(name: str, rule: str, value: Any, cure: str, about: Parameter) -> str:
    default = (
        ""
        if about.default is None
        else f" (its default is {about.default:g}{' ' * bool(about.unit)}{about.unit})"
    )
    return f"{name} must be {rule}, got {value}: {cure}{default}"


class StructureKey(NamedTuple):
    """The structure of a component: all but its parameter values; the key of the caches of derivations.

    `values` are those of the fields that are no parameters; a component with a role is replaced by its key.
    `surroundings` tell what a class of one's own depends on besides (`surroundings_of`).
    """

    component: type
    values: tuple[Any, ...]
    surroundings: str = ""

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of its parameters and of its components' parameters."""
        return _parameters_of_structure(self)


@cache
def _parameters_of_structure(key: StructureKey) -> tuple[str, ...]:
    parts = (each for each in key.values if isinstance(each, StructureKey))
    return (*parameters_of(key.component), *(name for part in parts for name in part.parameters))


@dataclass(frozen=True, repr=False)
class Component:
    """A law as data: its fields are the parameters, its methods the formulas.

    The methods use nothing but arithmetic, so that they take floats, arrays and sympy symbols alike.
    Two components are equal when they have the same class and the same values.

    A subclass may set the default of an inherited field anew, as ``mu_k = 0.1`` or ``mu_k: float = 0.1``.
    A parameter keeps its unit, symbol, meaning, bounds and range.  Of several bases the first that sets it
    counts, as for any attribute.
    """

    def __init_subclass__(cls, **given: Any) -> None:
        super().__init_subclass__(**given)
        _keep_metadata(cls)

    def __new__(cls, *values: Any, **named: Any) -> Self:
        """Refuse an unknown argument and suggest the name that was meant; Python's own error does not."""
        names = _names_of_arguments(cls)
        for name in named:
            if names and name not in names:
                raise unknown_parameter(cls.__name__, name, names)
        return super().__new__(cls)

    def __post_init__(self) -> None:
        laws = _LAWS_OF_EXPRESSIONS.get()
        expressions = {} if laws is None or hasattr(self, "roles") else expressions_of(self)
        for name, about in parameters_of(type(self)).items():
            if name not in expressions:
                object.__setattr__(self, name, check_value(name, getattr(self, name), about))
        for name in structure_of(type(self)):
            _check_structure(type(self).__name__, name, getattr(self, name))
        if laws is not None and expressions:
            laws.append(self)
        else:
            self.check()

    def check(self) -> None:
        """Raise ValueError where values contradict each other; subclasses may override it."""

    @property
    def structure_key(self) -> StructureKey:
        """Its structure as it is now."""
        kind = type(self)
        roles = getattr(kind, "roles", {})
        values = {name: getattr(self, name) for name in structure_of(kind)}
        return StructureKey(
            kind,
            tuple(value.structure_key if name in roles else value for name, value in values.items()),
            surroundings_of(kind),
        )

    def __repr__(self) -> str:
        values = (f"{f.name}={value_repr(getattr(self, f.name))}" for f in fields(self))
        return f"{type(self).__name__}({', '.join(values)})"


_LAWS_OF_EXPRESSIONS: ContextVar[list[Component] | None] = ContextVar("laws of expressions", default=None)


@contextmanager
def laws_of_expressions(laws: list[Component]) -> Iterator[None]:
    """A place where laws may be made of expressions: `mechanics`, and methods of laws that are given symbols.

    The laws that are made so are added to `laws`.  Rules for the values of those of `mechanics` are checked
    where the values are known.
    """
    token = _LAWS_OF_EXPRESSIONS.set(laws)
    try:
        yield
    finally:
        _LAWS_OF_EXPRESSIONS.reset(token)


def expressions_of(component: Component) -> dict[str, Any]:
    """Parameters of a law that are expressions, by name."""
    values = {name: getattr(component, name) for name in parameters_of(type(component))}
    return {name: value for name, value in values.items() if getattr(value, "free_symbols", None)}


def subclasses_of(base: type) -> Iterator[type]:
    """The class and all that derive from it, as they were defined."""
    yield base
    for cls in base.__subclasses__():
        yield from subclasses_of(cls)


def _keep_metadata(cls: type) -> None:
    """Make what a class sets anew of inherited fields their defaults, and those of parameters parameters.

    Raises
    ------
    TypeError, ValueError
        If the default of a parameter is no number, or out of its bounds; if a property takes a field's place.
    """
    if "__dataclass_fields__" in vars(cls):  # dataclass(slots=True) makes the class a second time
        return
    own, roles = get_annotations(cls), getattr(cls, "roles", {})
    for name, inherited in inherited_fields(cls).items():
        value, about = _nearest_value(cls, inherited), parameter_of_field(inherited)
        if name not in own and value is inherited:
            continue
        if isinstance(value, property | cached_property):
            raise TypeError(
                f"{name} of {cls.__name__} must be a value, as it is a field of its base, got a property: "
                f"write {name} = ..., or give the property another name"
            )
        if name not in own:
            cls.__annotations__ = own = own | {name: float if about else roles.get(name, Any)}
        if about and not isinstance(vars(cls).get(name), dataclasses.Field):
            _set_default(cls, name, value, about)


def _set_default(cls: type, name: str, value: Any, about: Parameter) -> None:
    """Set a default, or that of a field, of a parameter anew, as a field that keeps what is known of it."""
    if isinstance(value, dataclasses.Field):
        value, about = value.default, value.metadata.get(METADATA_KEY, about)
    if value is not dataclasses.MISSING:
        about = dataclasses.replace(about, default=check_value(name, value, about))
        setattr(cls, name, dataclasses.field(default=about.default, metadata={METADATA_KEY: about}))


def _nearest_value(cls: type, inherited: dataclasses.Field[Any]) -> Any:
    """What the nearest class that sets a field gives it: a value, or for a dataclass the field itself."""
    for kind in cls.__mro__:
        if "__dataclass_fields__" in vars(kind):
            if inherited.name in get_annotations(kind):
                return vars(kind)["__dataclass_fields__"][inherited.name]
        elif inherited.name in vars(kind):
            return vars(kind)[inherited.name]
    return inherited


def inherited_fields(cls: type) -> dict[str, dataclasses.Field[Any]]:
    """The fields of all bases of a class by name, in the order of the nearest."""
    bases = (base for base in cls.__mro__[1:] if "__dataclass_fields__" in vars(base))
    fields: dict[str, dataclasses.Field[Any]] = {}
    for each in (each for base in bases for each in dataclasses.fields(base)):
        fields.setdefault(each.name, each)
    return fields


@cache
def _names_of_arguments(component: type) -> tuple[str, ...]:
    """Names of the constructor's arguments; none where it takes any keyword and checks it, as for models."""
    arguments = signature(component.__init__).parameters.values()
    if any(one.kind is Argument.VAR_KEYWORD for one in arguments):
        return ()
    return tuple(one.name for one in arguments)[1:]


def _check_structure(owner: str, name: str, value: Any) -> None:
    """Raise TypeError for a list, a mapping or an array: equations are derived once for each value."""
    try:
        hash(value)
    except TypeError:
        raise TypeError(
            f"{name} of {owner} must not change later, as its equations depend on it, "
            f"got {abbreviate(value)}: "
            "write a tuple or a number"
        ) from None


def value_repr(value: Any) -> str:
    """The value of a field as a Python expression; an enum member as Kind.NAME, a number as Python's."""
    if isinstance(value, tuple):
        return f"({', '.join(map(value_repr, value))}{',' * (len(value) == 1)})"
    return f"{type(value).__name__}.{value.name}" if isinstance(value, Enum) else repr(plain_number(value))
