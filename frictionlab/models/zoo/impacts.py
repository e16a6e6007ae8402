"""Impacts: a ball on a table that vibrates, a block that rocks, a gear that rattles, a row of balls."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import pairwise
from math import pi
from types import MappingProxyType
from typing import Any, ClassVar

from frictionlab.components.functions import cos, sin
from frictionlab.components.impact import ImpactLaw, RestitutionImpact
from frictionlab.models.mechanical.mechanics import Mechanics, Stop
from frictionlab.models.mechanism import Block, Mechanism, Point, Wall
from frictionlab.models.model import model
from frictionlab.models.zoo.zoo_model import NO_EQUILIBRIUM, ZooModel, not_negative, positive

SLENDERNESS = 0.2  # rad, of a block five times as high as wide


@model
class BallOnTable(ZooModel):
    """A ball that bounces on a table that vibrates: y'' = -g, and Newton's impact where y = A sin(Omega t).

    Bounces of the table's period strike it at the phase p, with

        cos p = pi g (1 - e)/((1 + e) A Omega^2),

    and are stable where A Omega^2/g is above pi (1 - e)/(1 + e), where they are born, and below

        sqrt((pi (1 - e)/(1 + e))^2 + (2 (1 + e^2)/(1 + e)^2)^2),

    where their period doubles.  Chaos follows.

    Parameters
    ----------
    m : float
        Mass, kg, above 0; the motion does not depend on it.
    g : float
        Gravity, m/s^2, above 0.
    A, Omega : float
        Amplitude (m) and angular frequency (rad/s) of the table.
    h : float
        Height from which the ball is dropped, m.
    impact : ImpactLaw
        RestitutionImpact(e).

    References
    ----------
    P. J. Holmes, Journal of Sound and Vibration 84 (1982) 173-189, where heights are large against A.

    Examples
    --------
    >>> import frictionlab as fl
    >>> model = fl.BallOnTable()
    >>> orbit = fl.periodic_orbit(model, fl.simulate(model, 200.0))
    >>> strikes = orbit.trajectory.events
    >>> bool(abs(strikes.state[strikes.guard == "impact", 2] - model.impact_phase) < 1e-9)
    True
    """

    m: float = positive(1.0, "kg", "m", "mass")
    g: float = positive(1.0, "m/s^2", "g", "gravity")
    A: float = positive(1.2, "m", "A", "amplitude of the table")
    Omega: float = positive(1.0, "rad/s", r"\Omega", "angular frequency of the table")
    h: float = not_negative(12.0, 20.0, "m", "h", "height from which it is dropped")
    impact: ImpactLaw = RestitutionImpact(e=0.6)
    coordinates = ("y",)

    about = "a ball on a table that vibrates: bounces of one period, period doublings, chaos"
    reference = "P. J. Holmes, J. Sound and Vibration 84 (1982) 173-189"
    not_applicable: ClassVar[Mapping[str, str]] = MappingProxyType({"eigenvalues": NO_EQUILIBRIUM})

    @property
    def period(self) -> float:
        """That of the table, s."""
        return 2 * pi / self.Omega

    @property
    def impact_phase(self) -> float:
        """Phase (rad) at which stable bounces of one period strike the table."""
        return math.acos(pi * self.g * (1 - self.e) / ((1 + self.e) * self.A * self.Omega**2))

    def release(self) -> Mapping[str, float]:
        """At the height h."""
        return {"y": self.h}

    @property
    def mechanism(self) -> Mechanism:
        """A ball above the table's mean place."""
        ball = Block(Point(0.0, 0.2, up="y"), width=0.4, height=0.4, disc=True)
        return Mechanism(Wall((-1.0, 0.0), (1.0, 0.0)), ball)

    def mechanics(self, q: Any, v: Any) -> Mechanics:
        """One mass, one stop that moves."""
        table = Stop(q.y - self.A * sin(q.phase), self.impact)
        weight = self.m * self.g * q.y
        return Mechanics(self.m * v.y**2 / 2, weight, contacts=(table,), frequency=self.Omega)


@model
class RockingBlock(ZooModel):
    """A slender block that rocks from one of its lower corners to the other: theta'' = p^2 (theta - alpha).

    Here theta is the size of its rotation, p^2 = 3 g/(4 R), and at theta = 0 it goes on about the other
    corner, with the share e of its angular velocity: so theta comes to a stop and back.  Released at theta_0
    it comes down after arcosh(1/(1 - theta_0/alpha))/p, a quarter of its first period, and turns after the
    n-th impact at

        theta_n = alpha (1 - sqrt(1 - e^(2 n) (1 - (1 - theta_0/alpha)^2))).

    Without a loss of angular momentum about the new corner e = 1 - 3/2 sin^2 alpha.

    Parameters
    ----------
    R : float
        Half the diagonal, m, above 0.
    alpha : float
        Angle of the diagonal with the vertical, rad: where it stands on a corner.
    g : float
        Gravity, m/s^2, above 0.
    theta_0 : float
        Angle at which it is released, rad.
    impact : ImpactLaw
        RestitutionImpact(e).

    References
    ----------
    G. W. Housner, Bulletin of the Seismological Society of America 53 (1963) 403-417.

    Examples
    --------
    >>> import frictionlab as fl
    >>> model = fl.RockingBlock()
    >>> abs(float(fl.simulate(model, 1.0).events.t[0]) - model.period / 4) < 1e-12
    True
    """

    R: float = positive(1.0, "m", "R", "half the diagonal")
    alpha: float = positive(SLENDERNESS, "rad", r"\alpha", "angle of the diagonal")
    g: float = positive(9.81, "m/s^2", "g", "gravity")
    theta_0: float = not_negative(0.1, 0.2, "rad", r"\theta_0", "angle at which it is released")
    impact: ImpactLaw = RestitutionImpact(e=1 - 1.5 * math.sin(SLENDERNESS) ** 2)
    coordinates = ("theta",)

    about = "a block that rocks from corner to corner, faster and faster, until it stands"
    reference = "G. W. Housner, Bull. Seismological Society of America 53 (1963) 403-417"
    not_applicable: ClassVar[Mapping[str, str]] = MappingProxyType(
        dict.fromkeys(
            ("periodic_orbit", "continue_orbit"), "Every rocking comes to rest, so that none is periodic."
        )
    )

    @property
    def period(self) -> float:
        """That of the first rocking, s; as of half the angle alpha where it is released beyond."""
        share = self.theta_0 / self.alpha if 0 < self.theta_0 < self.alpha else 0.5
        return 4 * math.acosh(1 / (1 - share)) / (0.75 * self.g / self.R) ** 0.5

    def release(self) -> Mapping[str, float]:
        """At theta_0."""
        return {"theta": self.theta_0}

    @property
    def mechanism(self) -> Mechanism:
        """The block; a height stands for its angle."""
        return Mechanism(Wall((-1.0, 0.0), (1.0, 0.0)), Block(Point(0.0, 0.6, up="theta"), 0.3, 1.2))

    def mechanics(self, q: Any, v: Any) -> Mechanics:
        """One inertia, one stop; energies for a mass of 1 kg."""
        kinetic = 4 / 3 * self.R**2 * v.theta**2 / 2
        weight = -self.g * self.R * (self.alpha - q.theta) ** 2 / 2
        return Mechanics(kinetic, weight, contacts=(Stop(q.theta, self.impact),))


@model
class RattlingGear(ZooModel):
    """A loose gear that rattles in its backlash b: m x'' + c x' = 0 between flanks that move.

    The flanks are at A cos(Omega t) and b above that, x is along them.  Without a damper the gear flies at a
    constant speed u.  A motion of the drive's period that strikes each flank once, half a period apart, has
    the phase p at the lower flank, with

        b - 2 A cos p = pi u/Omega,      A Omega sin p = -u (1 - e)/(1 + e).

    It is the impact pair of which Karagiannis and Pfeiffer make gearboxes; the numbers are this package's.

    Parameters
    ----------
    m : float
        Mass, kg, above 0.
    c : float
        Damper, as of oil, N s/m.
    A, Omega : float
        Amplitude (m) and angular frequency (rad/s) of the flanks.
    b : float
        Backlash, m, above 0.
    impact : ImpactLaw
        RestitutionImpact(e).

    References
    ----------
    K. Karagiannis, F. Pfeiffer, Nonlinear Dynamics 2 (1991) 367-387.

    Examples
    --------
    >>> import frictionlab as fl
    >>> settled = fl.steady_state(fl.RattlingGear(), transient=1000.0, progress=False)
    >>> str(settled.kind), bool(abs(settled.period - fl.RattlingGear().period) < 1e-6)
    ('periodic', True)
    """

    m: float = positive(1.0, "kg", "m", "mass")
    c: float = not_negative(0.0, 1.0, "N s/m", "c", "damping of the oil")
    A: float = positive(1.0, "m", "A", "amplitude of the flanks")
    Omega: float = positive(1.0, "rad/s", r"\Omega", "angular frequency of the flanks")
    b: float = positive(3.0, "m", "b", "backlash")
    impact: ImpactLaw = RestitutionImpact(e=0.6)
    coordinates = ("x",)

    about = "a gear in its backlash, that strikes one flank and then the other"
    reference = "K. Karagiannis, F. Pfeiffer, Nonlinear Dynamics 2 (1991) 367-387"
    not_applicable: ClassVar[Mapping[str, str]] = MappingProxyType({"eigenvalues": NO_EQUILIBRIUM})

    @property
    def period(self) -> float:
        """That of the flanks, s."""
        return 2 * pi / self.Omega

    def release(self) -> Mapping[str, float]:
        """In the middle between the flanks."""
        return {"x": self.A + self.b / 2}

    @property
    def mechanism(self) -> Mechanism:
        """The gear as a block between two walls, which are the flanks in their mean places."""
        gear, upper = Block(Point(0.4, 0.3, right="x"), 0.4, 0.4), Point(0.8, 0.0, right="b")
        return Mechanism(Wall((0.0, 0.0), (0.0, 0.6)), Wall(upper, upper.beside(0.0, 0.6)), gear)

    def mechanics(self, q: Any, v: Any) -> Mechanics:
        """One mass, two stops that move."""
        above = q.x - self.A * cos(q.phase)
        flanks = Stop(above, self.impact), Stop(self.b - above, self.impact)
        kinetic, dampers = self.m * v.x**2 / 2, self.c * v.x**2 / 2
        return Mechanics(kinetic, dissipation=dampers, contacts=flanks, frequency=self.Omega)


@model
class NewtonsCradle(ZooModel):
    """Equal balls in a row, each on a string, that touch: the first one falls, and the last one flies.

        m x_i'' + m g/l x_i = 0,     x_i <= x_(i+1)

    The impacts at one instant are a sequence.  Each passes on the share (1 + e)/2 of the speed, so that the
    last of n balls leaves with ((1 + e)/2)^(n - 1) of the speed of the first.  Elastic balls swing for ever,
    with the period 2 pi sqrt(l/g).

    Parameters
    ----------
    m : float
        Masses, kg, above 0.
    l : float
        Length of the strings, m, above 0.
    g : float
        Gravity, m/s^2, above 0.
    a : float
        How far the first ball is drawn aside, m.
    balls : int
        n.
    impact : ImpactLaw
        RestitutionImpact(e).

    References
    ----------
    F. Herrmann, M. Seitz, American Journal of Physics 50 (1982) 977-981; as a sequence of impacts
    B. Brogliato, Nonsmooth Mechanics, 3rd ed., Springer 2016.

    Examples
    --------
    >>> import frictionlab as fl
    >>> run = fl.simulate(fl.NewtonsCradle(e=1.0), 2.5)
    >>> (run.v[-1] / run.v[-1, 2]).round(9).tolist()
    [0.0, 0.0, 1.0]
    """

    m: float = positive(1.0, "kg", "m", "mass")
    l: float = positive(1.0, "m", "l", "length of the strings")  # as in every textbook
    g: float = positive(1.0, "m/s^2", "g", "gravity")
    a: float = not_negative(0.2, 1.0, "m", "a", "how far the first ball is drawn aside")
    impact: ImpactLaw = RestitutionImpact(e=0.95)
    balls: int = 3

    about = "one ball falls, one flies: impacts at one instant, in a sequence"
    reference = "F. Herrmann, M. Seitz, American J. Physics 50 (1982) 977-981"
    not_applicable: ClassVar[Mapping[str, str]] = MappingProxyType(
        {
            "eigenvalues": "At rest the balls touch, at the border of all modes.",
            "continue_orbit": "In the end all balls swing as one, with any amplitude: there is no branch.",
        }
    )

    def check(self) -> None:
        """`balls` is from 2 to 100."""
        self.check_count("balls", least=2)
        super().check()

    @property
    def coordinates(self) -> tuple[str, ...]:
        """x1, x2, ..."""
        return tuple(f"x{i + 1}" for i in range(self.balls))

    @property
    def period(self) -> float:
        """That of a ball on its string, s."""
        return 2 * pi * (self.l / self.g) ** 0.5

    def release(self) -> Mapping[str, float]:
        """The first ball drawn aside."""
        return {"x1": -self.a}

    @property
    def mechanism(self) -> Mechanism:
        """Balls in a row on strings."""
        places = [Point(0.4 * i, 0.0, right=name) for i, name in enumerate(self.coordinates)]
        strings = [Wall(Point(at.x, 1.4), at) for at in places]
        beam = Wall((-0.4, 1.4), (0.4 * self.balls, 1.4))
        return Mechanism(beam, *strings, *(Block(at, 0.4, 0.4, disc=True) for at in places))

    def mechanics(self, q: Any, v: Any) -> Mechanics:
        """n masses, a stop between each and the next."""
        x, rates = ([getattr(at, name) for name in self.coordinates] for at in (q, v))
        stops = tuple(Stop(b - a, self.impact) for a, b in pairwise(x))
        kinetic = self.m * sum(rate**2 for rate in rates) / 2
        return Mechanics(kinetic, self.m * self.g / self.l * sum(a**2 for a in x) / 2, contacts=stops)
