"""The bouncing ball: infinitely many impacts in a finite time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Unpack

from frictionlab.components.component import parameter
from frictionlab.components.impact import ImpactLaw, RestitutionImpact
from frictionlab.models.mechanical.mechanical_model import MechanicalModel
from frictionlab.models.mechanical.mechanics import Mechanics, Stop
from frictionlab.models.mechanism import Block, Mechanism, Place, Wall
from frictionlab.models.model import with_signature

from .parameters import mass_parameter

if TYPE_CHECKING:
    from .parameters import BouncingBallKeywords


@with_signature
@dataclass(frozen=True, init=False, repr=False)
class BouncingBall(MechanicalModel):
    """A ball that is dropped on the ground: y'' = -g, and y' becomes -e y' where y = 0.

    Dropped from h it first lands after sqrt(2 h/g).  Each flight is e times as long as the one before, so
    that all of them are over at

        sqrt(2 h/g) (1 + e)/(1 - e),

    when it comes to rest: with e = 0.5 and h = 1 m three times the first fall, 1.354570922957 s.

    Parameters
    ----------
    m : float
        Mass, kg, above 0; the motion does not depend on it.
    g : float
        Gravity, m/s^2, above 0.
    h : float
        Height from which the ball is dropped, m.
    impact : ImpactLaw
        RestitutionImpact(e).

    References
    ----------
    B. Brogliato, Nonsmooth Mechanics: Models, Dynamics and Control, 3rd ed., Springer 2016.

    Examples
    --------
    >>> import frictionlab as fl
    >>> run = fl.simulate(fl.BouncingBall(), 2.0)
    >>> float(round(run.events.t[-1], 10)), str(run.mode[-1])
    (1.354570923, 'contact')
    """

    m: float = mass_parameter()
    g: float = parameter(
        9.81, unit="m/s^2", symbol="g", meaning="gravity", exclusive_minimum=0.0, range=(1.0, 30.0)
    )
    h: float = parameter(
        1.0, unit="m", symbol="h", meaning="height from which it is dropped", minimum=0.0, range=(0.0, 10.0)
    )
    impact: ImpactLaw = RestitutionImpact(e=0.5)

    roles: ClassVar[Mapping[str, type]] = MappingProxyType({"impact": ImpactLaw})
    reference: ClassVar[str] = "B. Brogliato, Nonsmooth Mechanics, 3rd ed., Springer 2016"

    if TYPE_CHECKING:

        def __init__(self, **given: Unpack[BouncingBallKeywords]) -> None: ...

    @property
    def coordinates(self) -> tuple[str, ...]:
        """The height y above the ground."""
        return ("y",)

    @property
    def period(self) -> float:
        """Up and down once more from h, s."""
        return 2 * (2 * (self.h or 1.0) / self.g) ** 0.5

    def release(self) -> Mapping[str, float]:
        """At the height h."""
        return {"y": self.h}

    @property
    def mechanism(self) -> Mechanism:
        """A ball above the ground."""
        ball = Block(Place(0.0, 0.2, up="y"), width=0.4, height=0.4, disc=True)
        return Mechanism(Wall((-1.0, 0.0), (1.0, 0.0)), ball)

    def mechanics(self, q: Any, v: Any) -> Mechanics:
        """One mass, one stop."""
        return Mechanics(
            kinetic=self.m * v.y**2 / 2,
            potential=self.m * self.g * q.y,
            contacts=(Stop(q.y, self.impact),),
        )
