"""Parameters: dataclass fields that hold a physical number, with its unit, symbol, meaning and range."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from inspect import get_annotations
from numbers import Real
from types import MappingProxyType
from typing import Any

KEY = "frictionlab parameter"


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

    symbol: str
    unit: str = ""
    meaning: str = ""
    default: float | None = None
    minimum: float | None = None
    exclusive_minimum: float | None = None
    maximum: float | None = None
    range: tuple[float, float] | None = None
    log: bool = False


def parameter(
    default: float,
    *,
    unit: str = "",
    symbol: str = "",
    meaning: str = "",
    minimum: float | None = None,
    exclusive_minimum: float | None = None,
    maximum: float | None = None,
    range: tuple[float, float] | None = None,
    log: bool = False,
) -> Any:
    """A dataclass field that is a parameter of its component.

    The keywords are those of :class:`Parameter`.  In a law of your own::

        @dataclass(frozen=True)
        class Hertz(ContactLaw):
            k_h: float = parameter(1e6, unit="N/m^1.5", symbol="k_H", meaning="Hertz stiffness", minimum=0.0)

            def force(self, gap):
                return self.k_h * gap**1.5

    Raises
    ------
    TypeError
        If the default is no number.
    ValueError
        If the range is not two numbers in ascending order, above 0 for a logarithmic slider.
    """
    _check_default(default)
    _check_range(range, log)
    about = Parameter(symbol, unit, meaning, default, minimum, exclusive_minimum, maximum, range, log)
    return dataclasses.field(default=default, metadata={KEY: about})


def _check_default(default: Any) -> None:
    if isinstance(default, bool) or not isinstance(default, Real):
        raise TypeError(
            f"the default of a parameter must be a number, got {default!r}: give a float, or make the field "
            "one without parameter(...)"
        )


def _check_range(range: Any, log: bool) -> None:
    if range is None:
        return
    try:
        low, high = range
        fits = low < high and (low > 0 or not log)
    except (TypeError, ValueError):
        fits = False
    if not fits:
        rule = "two numbers in ascending order" + ", above 0 where log=True" * log
        raise ValueError(f"range must be {rule}, got {range!r}: give (low, high), the ends of a slider")


@cache
def parameters_of(component: type) -> Mapping[str, Parameter]:
    """The parameters of a component class by name, in the order of its fields.

    A plain ``float`` field counts as a parameter without unit; every other field is *structure*.
    """
    _refuse_undecorated(component)
    found = {f.name: _about(f) for f in dataclasses.fields(component)}
    return MappingProxyType({name: about for name, about in found.items() if about is not None})


@cache
def structure_of(component: type) -> tuple[str, ...]:
    """Names of the fields that are not parameters: they change the equations, not the numbers in them."""
    names = (f.name for f in dataclasses.fields(component))
    return tuple(name for name in names if name not in parameters_of(component))


def _about(field: dataclasses.Field[Any]) -> Parameter | None:
    about = field.metadata.get(KEY)
    if about is not None:
        return about if about.symbol else dataclasses.replace(about, symbol=field.name)
    if field.type not in (float, "float"):
        return None
    return Parameter(field.name, default=None if field.default is dataclasses.MISSING else field.default)


def is_dataclass_of_its_own(component: type) -> bool:
    """Whether a class that adds fields is decorated; without it they would silently not be parameters."""
    return not get_annotations(component) or "__dataclass_fields__" in component.__dict__


def _refuse_undecorated(component: type) -> None:
    if not is_dataclass_of_its_own(component):
        raise TypeError(
            f"{component.__name__} has fields but is no dataclass: write @dataclass(frozen=True) above it"
        )
