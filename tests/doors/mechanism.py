"""A mechanism as text: energies, loads and contacts; the package and the reference make a system of it.

Expressions are Python in the coordinates q1, q2 ..., the velocities v1, v2 ..., the phase p of a force that
depends on time, and functions of one argument (sin, cos, exp, tanh).  Further states s1, s2 ... have rates of
their own; loads and given normal forces may depend on them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import frictionlab as fl
from frictionlab import functions
from frictionlab.models import Friction, Mechanics
from frictionlab.models.mechanical.mechanics import Stop
from tests.differential.laws import OWN

FUNCTIONS = ("sin", "cos", "exp", "tanh")
LAWS = {"Coulomb": fl.Coulomb, "ExponentialDecay": fl.ExponentialDecay, "Stribeck": fl.Stribeck, **OWN}
NOTHING = "0"


@dataclass(frozen=True)
class Law:
    """A friction law by name, with its numbers."""

    name: str
    numbers: tuple[tuple[str, float], ...]


@dataclass(frozen=True)
class Rub:
    """A contact with friction whose normal force is given; it is never lost."""

    speed: str
    normal: str
    law: Law


@dataclass(frozen=True)
class Touch:
    """A contact that may be lost, on a spring of the force k d + k3 d^3 at the penetration d."""

    speed: str
    penetration: str
    k: float
    k3: float
    law: Law


@dataclass(frozen=True)
class Wall:
    """A rigid stop; `wave` is the length of corrugations along the first coordinate, 0 for none."""

    distance: str
    e: float
    wave: float = 0.0


@dataclass(frozen=True)
class Further:
    """A state with a rate of its own.

    Parameters
    ----------
    rate : str
    start, size : float
        Where it starts, and how large it is about.
    steep : str
        What the rate, or a force, changes fast with: at `layer`, centre and width.
    """

    rate: str
    start: float
    size: float
    steep: str = "0"
    layer: tuple[float, float] | None = None


@dataclass(frozen=True)
class Mechanism:
    """Energies, dissipation, loads and contacts of n coordinates."""

    n: int
    kinetic: str
    potential: str
    dissipation: str
    loads: tuple[str, ...]
    frequency: float
    contacts: tuple[Any, ...]
    x0: tuple[float, ...]
    period: float  # s: a time in which the motion changes
    phase: float = 0.0  # where the phase starts
    further: tuple[Further, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the further states."""
        return tuple(f"s{i + 1}" for i in range(len(self.further)))

    @property
    def starts(self) -> tuple[float, ...]:
        """Where coordinates, velocities and further states start."""
        return (*self.x0, *(state.start for state in self.further))

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the coordinates."""
        return tuple(f"q{i + 1}" for i in range(self.n))


def evaluated(text: str, names: dict[str, Any]) -> Any:
    """The value of an expression."""
    return eval(text, {"__builtins__": {}}, names)


def model_of(mechanism: Mechanism) -> fl.MechanicalModel:
    """The package's model."""
    one = mechanism

    @fl.model
    class Made(fl.MechanicalModel):
        """A random mechanism."""

        coordinates = one.coordinates
        states = one.names
        period = one.period

        def mechanics(self, q: Any, v: Any, s: Any = None) -> Mechanics:
            names = {name: getattr(functions, name) for name in FUNCTIONS}
            names |= {f"q{i + 1}": getattr(q, name) for i, name in enumerate(one.coordinates)}
            names |= {f"v{i + 1}": getattr(v, name) for i, name in enumerate(one.coordinates)}
            names |= {"p": q.phase, **{name: getattr(s, name) for name in one.names}}
            loads = {
                name: evaluated(text, names)
                for name, text in zip(one.coordinates, one.loads, strict=True)
                if text != NOTHING
            }
            return Mechanics(
                kinetic=evaluated(one.kinetic, names),
                potential=evaluated(one.potential, names),
                dissipation=evaluated(one.dissipation, names),
                loads=loads,
                frequency=one.frequency or None,
                contacts=tuple(_contact(each, names) for each in one.contacts),
                rates={name: evaluated(state.rate, names) for name, state in zip(one.names, one.further)},
            )

    return Made()


def law_of(law: Law) -> Any:
    """The package's law."""
    return LAWS[law.name](**dict(law.numbers))


def _contact(contact: Any, names: dict[str, Any]) -> Any:
    if isinstance(contact, Wall):
        return Stop(evaluated(contact.distance, names), fl.RestitutionImpact(e=contact.e))
    speed = evaluated(contact.speed, names)
    if isinstance(contact, Rub):
        return Friction(speed, evaluated(contact.normal, names), law_of(contact.law))

    def spring(d: Any) -> Any:
        return contact.k * d + contact.k3 * d**3

    return Friction(speed, spring, law_of(contact.law), penetration=evaluated(contact.penetration, names))
