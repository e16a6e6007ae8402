"""The base of every component: a frozen dataclass whose parameters are checked when it is made."""

from __future__ import annotations

from dataclasses import dataclass, fields

from .parameter import check_value, parameters_of


@dataclass(frozen=True, repr=False)
class Component:
    """A law as data: its fields are the parameters, its methods the formulas.

    The methods use nothing but arithmetic, so that they take floats, arrays and sympy symbols alike.
    Two components are equal when they have the same class and the same values.
    """

    def __post_init__(self) -> None:
        for name, about in parameters_of(type(self)).items():
            object.__setattr__(self, name, check_value(name, getattr(self, name), about))
        self.check()

    def check(self) -> None:
        """Raise ValueError where values contradict each other; a subclass may say how."""

    def reduced(self) -> Component:
        """A simpler law that this one equals at its values (a restitution of 0 is a plastic impact); else the
        component itself."""
        return self

    def __repr__(self) -> str:
        values = (f"{f.name}={getattr(self, f.name)!r}" for f in fields(self))
        return f"{type(self).__name__}({', '.join(values)})"
