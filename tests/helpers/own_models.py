"""A law and a model of users, with fields of every kind that is no physical number."""

from dataclasses import dataclass
from enum import Enum
from itertools import pairwise

import frictionlab as fl
from frictionlab.components import Coulomb, FrictionLaw
from frictionlab.models import MechanicalModel, Mechanics
from frictionlab.models.mechanical.mechanics import Friction


class Wear(Enum):
    """How a surface is worn."""

    NEW, OLD = "new", "old"


@dataclass(frozen=True, repr=False)
class Fitted(FrictionLaw):
    """Friction that falls with speed by a series whose shares and exponents are data."""

    mu_w: float = fl.parameter(
        0.5, symbol=r"\mu_w", meaning="friction at rest", range=(0.0, 2.0), minimum=0.0
    )
    shares: tuple[float, ...] = (0.3, 0.1)
    pairs: tuple[tuple[str, int], ...] = (("slow", 1), ("fast", 2))
    wear: Wear = Wear.NEW
    note: str = 'with "quotes", {braces} and \N{GREEK SMALL LETTER MU}'
    lubricated: bool = False
    source: str | None = None
    base: FrictionLaw = Coulomb(mu_k=0.25, mu_s=0.5)

    def kinetic(self, normal_force, speed):
        """The base's, and a part that falls."""
        falling = sum(s / (1 + speed) ** n for s, (_, n) in zip(self.shares, self.pairs, strict=True))
        worn = 0.5 if self.wear is Wear.OLD else 1.0
        return self.base.kinetic(normal_force, speed) + worn * self.mu_w * normal_force * falling

    def static_limit(self, normal_force):
        """At rest."""
        return (self.mu_w + 1.0) * normal_force


@fl.model
class Chain(MechanicalModel):
    """Masses in a row on springs, the first of which rubs on a belt."""

    m: float = fl.parameter(
        1.0, unit="kg", symbol="m", meaning="mass", range=(0.1, 10.0), exclusive_minimum=0.0
    )
    k: float = fl.parameter(2.0, unit="N/m", symbol="k", meaning="stiffness", range=(0.1, 10.0))
    v: float = fl.parameter(0.5, unit="m/s", symbol="v", meaning="speed of the belt", range=(-3.0, 3.0))
    masses: int = 2
    ends: str = "fixed"
    wear: Wear = Wear.NEW
    weights: tuple[float, ...] = (1.0, 0.5, 0.25)
    spare: object = Fitted(shares=(0.2,), pairs=(("slow", 1),))
    friction: FrictionLaw = Coulomb(mu_k=0.3, mu_s=0.5)

    coordinates = fl.numbered("x", count="masses")
    period = 4.0

    def mechanics(self, q, v):
        """Springs between neighbours, and from both ends to the walls, or from the first end only."""
        stretched = [q[0], *(b - a for a, b in pairwise(q))] + ([q[-1]] if self.ends == "fixed" else [])
        kinetic = sum(w * self.m * rate**2 / 2 for w, rate in zip(self.weights, v))
        load = self.spare.kinetic(1.0, 0.0) + (1.0 if self.wear is Wear.OLD else 0.0)
        return Mechanics(
            kinetic=kinetic,
            potential=sum(self.k * each**2 / 2 for each in stretched),
            contacts=(Friction(self.v - v[0], 1.0 + load, self.friction),),
        )


@fl.model
class NeedsNumber(fl.Model):
    """A structural field that has no default."""

    degree: int
    coordinates = ("x",)

    def derive(self):
        """x' = -x^degree."""
        from frictionlab.models.symbols import symbol

        x, rate = symbol("x"), symbol("x'")
        return fl.HybridAutomaton((x, rate), (fl.Mode("only", (rate, -(x**self.degree))),), {}, 1)
