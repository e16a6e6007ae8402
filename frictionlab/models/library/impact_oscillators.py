"""Masses that strike a stop: a bouncing ball, which does so infinitely often in a finite time, and a driven
oscillator.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import pi
from typing import TYPE_CHECKING, Any, Unpack

from frictionlab.components import functions
from frictionlab.components.component import parameter
from frictionlab.components.impact import ImpactLaw, RestitutionImpact
from frictionlab.models.library.parameters import (
    frequency_parameter,
    not_negative,
    of_either_sign,
    positive,
    stiffness_parameter,
)
from frictionlab.models.mechanical.mechanical_model import MechanicalModel
from frictionlab.models.mechanical.mechanics import Mechanics, Stop
from frictionlab.models.mechanism import Block, Mechanism, Point, Spring, Wall
from frictionlab.models.model import model

if TYPE_CHECKING:
    from frictionlab.models.library.parameters import BouncingBallKeywords, ImpactOscillatorKeywords


@model
class BouncingBall(MechanicalModel):
    """A ball that is dropped on the ground: y'' = -g, and y' becomes -e y' where y = 0.

    Dropped from h it first lands after sqrt(2 h/g).  Each flight is e times as long as the one before, so
    that the ball comes to rest after

        sqrt(2 h/g) (1 + e)/(1 - e).

    With e = 0.5 and h = 1 m that is three times the first fall, 1.354570922957 s.

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

    m: float = positive(1.0, "kg", "m", "mass")
    g: float = parameter(
        9.81, unit="m/s^2", symbol="g", meaning="gravity", exclusive_minimum=0.0, range=(1.0, 30.0)
    )
    h: float = not_negative(1.0, 10.0, "m", "h", "height from which it is dropped")
    impact: ImpactLaw = RestitutionImpact(e=0.5)
    coordinates = ("y",)

    reference = "B. Brogliato, Nonsmooth Mechanics, 3rd ed., Springer 2016"

    if TYPE_CHECKING:

        def __init__(self, **given: Unpack[BouncingBallKeywords]) -> None: ...

    @property
    def period(self) -> float:
        """Time of a fall from h and a rise back to it, s."""
        return 2 * (2 * (self.h or 1.0) / self.g) ** 0.5

    def release(self) -> Mapping[str, float]:
        """At the height h."""
        return {"y": self.h}

    @property
    def mechanism(self) -> Mechanism:
        """A ball above the ground."""
        ball = Block(Point(0.0, 0.2, up="y"), width=0.4, height=0.4, disc=True)
        return Mechanism(Wall((-1.0, 0.0), (1.0, 0.0)), ball)

    def mechanics(self, q: Any, v: Any) -> Mechanics:
        """One mass, one stop."""
        return Mechanics(
            kinetic=self.m * v.y**2 / 2,
            potential=self.m * self.g * q.y,
            contacts=(Stop(q.y, self.impact),),
        )


@model
class ImpactOscillator(MechanicalModel):
    """A driven mass beside a stop: m x'' + c x' + k x = F cos(Omega t) while x < d; x' becomes -e x' at d.

    Its state has the phase Omega t (rad) beside x and x'; the phase goes from 0 to 2 pi and begins anew.
    Without a damper, with w = sqrt(k/m) and A = F/(k - m Omega^2), a motion with one impact in n periods of
    the force, T = 2 pi n/Omega, leaves the stop at the speed V and a phase p for which

        A cos p = d + V (1 + e) cot(w T/2)/(2 e w),      A Omega sin p = -V (1 - e)/(2 e).

    Parameters
    ----------
    m : float
        Mass, kg, above 0.
    c, k : float
        Damper, N s/m, and spring, N/m.
    d : float
        Where the stop is, m.
    F, Omega : float
        Amplitude (N) and angular frequency (rad/s) of the force.
    impact : ImpactLaw
        RestitutionImpact(e).

    References
    ----------
    S. W. Shaw, P. J. Holmes, Journal of Sound and Vibration 90 (1983) 129-155.

    Examples
    --------
    >>> import frictionlab as fl
    >>> fl.steady_state(fl.ImpactOscillator(), transient=300, window=100).kind
    'periodic'
    """

    m: float = positive(1.0, "kg", "m", "mass")
    c: float = not_negative(0.0, 2.0, "N s/m", "c", "damping")
    k: float = stiffness_parameter()
    d: float = of_either_sign(0.0, 2.0, "m", "d", "where the stop is")
    F: float = not_negative(1.0, 10.0, "N", "F", "amplitude of the force")
    Omega: float = frequency_parameter(2.5)
    impact: ImpactLaw = RestitutionImpact(e=0.8)
    coordinates = ("x",)

    reference = "S. W. Shaw, P. J. Holmes, J. Sound and Vibration 90 (1983) 129-155"

    if TYPE_CHECKING:

        def __init__(self, **given: Unpack[ImpactOscillatorKeywords]) -> None: ...

    @property
    def period(self) -> float:
        """That of the force, s."""
        return 2 * pi / self.Omega

    def release(self) -> Mapping[str, float]:
        """Where the spring is slack, or at the stop where d < 0."""
        return {"x": min(0.0, self.d)}

    @property
    def mechanism(self) -> Mechanism:
        """A block on a spring, and the stop, which it touches at d."""
        block, edge = Point(0.0, 0.2, right="x"), Point(0.3, 0.2, right="d")
        stop = Wall(edge.beside(0.0, -0.4), edge.beside(0.0, 0.4))
        held = Spring(Point(-1.6, 0.2), block.beside(-0.3))
        return Mechanism(Wall((-1.6, -0.2), (-1.6, 0.6)), held, stop, Block(block))

    def mechanics(self, q: Any, v: Any) -> Mechanics:
        """One mass, one stop, one force."""
        return Mechanics(
            kinetic=self.m * v.x**2 / 2,
            potential=self.k * q.x**2 / 2,
            dissipation=self.c * v.x**2 / 2,
            contacts=(Stop(self.d - q.x, self.impact),),
            loads={"x": self.F * functions.cos(q.phase)},
            frequency=self.Omega,
        )
