"""Impacts: a ball on a table that vibrates, a block that rocks, a gear, a row of balls, a woodpecker."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise
from math import pi
from types import MappingProxyType
from typing import Any

from frictionlab.components.friction import Coulomb, FrictionLaw
from frictionlab.components.functions import cos, sin
from frictionlab.components.impact import FrictionalImpact, ImpactLaw, RestitutionImpact
from frictionlab.models.library.impact_oscillators import BouncingBall
from frictionlab.models.library.parameters import not_negative, positive
from frictionlab.models.mechanical.mechanical_model import numbered
from frictionlab.models.mechanical.mechanics import Mechanics, Stop
from frictionlab.models.mechanism import Block, Mechanism, Point, Spring, Wall
from frictionlab.models.model import model
from frictionlab.models.zoo.zoo_model import NO_EQUILIBRIUM, ZooModel

# Lengths of the woodpecker, m: to the spring, from it to the bird, half of the sleeve, its radius, the beak.
ARM, BIRD, HALF_SLEEVE, RADIUS, BEAK, REACH = 0.01, 0.015, 0.0058, 0.0031, 0.02, 0.0051
CLEARANCE = 0.0006  # m, of the sleeve's edges at the pole
SLENDERNESS = 0.2  # rad, of a block five times as high as wide


@model
class BallOnTable(ZooModel, BouncingBall):
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

    g: float = positive(1.0, "m/s^2", "g", "gravity")
    A: float = positive(1.2, "m", "A", "amplitude of the table")
    Omega: float = positive(1.0, "rad/s", r"\Omega", "angular frequency of the table")
    h: float = not_negative(12.0, 20.0, "m", "h", "height from which it is dropped")
    impact = RestitutionImpact(e=0.6)

    about = "a ball on a table that vibrates: bounces of one period, period doublings, chaos"
    reference = "P. J. Holmes, J. Sound and Vibration 84 (1982) 173-189"
    not_applicable = NO_EQUILIBRIUM

    @property
    def period(self) -> float:
        """That of the table, s."""
        return 2 * pi / self.Omega

    @property
    def impact_phase(self) -> float:
        """Phase (rad) at which stable bounces of one period strike the table."""
        return math.acos(pi * self.g * (1 - self.e) / ((1 + self.e) * self.A * self.Omega**2))

    def mechanics(self, q: Any, v: Any) -> Mechanics:
        """The ground moves."""
        table = Stop(q.y - self.A * sin(q.phase), self.impact)
        return replace(super().mechanics(q, v), contacts=(table,), frequency=self.Omega)


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
    not_applicable = MappingProxyType(
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
    not_applicable = NO_EQUILIBRIUM

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
        return Mechanics(self.m * v.x**2 / 2, 0, self.c * v.x**2 / 2, flanks, frequency=self.Omega)


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
    coordinates = numbered("x", count="balls", least=2)

    about = "one ball falls, one flies: impacts at one instant, in a sequence"
    reference = "F. Herrmann, M. Seitz, American J. Physics 50 (1982) 977-981"
    not_applicable = MappingProxyType(
        {
            "eigenvalues": "At rest the balls touch, at the border of all modes.",
            "periodic_orbit": "In the end all balls swing as one: gaps and impacts have shrunk to nothing.",
            "continue_orbit": "In the end all balls swing as one, with any amplitude: there is no branch.",
        }
    )

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
        stops = tuple(Stop(b - a, self.impact) for a, b in pairwise(q))
        weight = self.m * self.g / self.l * sum(x**2 for x in q) / 2
        return Mechanics(self.m * sum(u**2 for u in v) / 2, weight, contacts=stops)


@model
class Woodpecker(ZooModel):
    """A woodpecker on a spring, on a sleeve that falls, jams and slips free on a pole.

    The sleeve has a clearance: its edges touch the pole where it has turned by 0.103 rad either way, and
    stick or slip there by friction.  The beak strikes the pole at an angle of 0.12 rad.  In a period the
    lower edge strikes and jams, the bird swings down and back, the sleeve slips free, falls and turns over,
    the beak strikes, and the sleeve turns back.  It could hang still where the friction coefficient is 0.285
    or more.  Leine, Glocker and van Campen print this sequence, a period of 0.1452 s (here 0.1460 s) and a
    lowest angle of the bird of -0.53 rad.

    Parameters
    ----------
    m_M, J_M : float
        Mass (kg) and inertia (kg m^2) of the sleeve.
    m_S, J_S : float
        Mass and inertia of the bird.
    k_t : float
        Stiffness of the spring between them, N m/rad.
    g : float
        Gravity, m/s^2.
    friction : FrictionLaw
        Of all contacts.
    impact, jamming : ImpactLaw
        Of the beak, and of the sleeve, whose restitution is 0.

    References
    ----------
    C. Glocker, F. Pfeiffer, Nonlinear Dynamics 7 (1995) 471-497; R. I. Leine, C. Glocker, D. H. van Campen,
    Proc. ASME DETC 2001, VIB-21608.

    Examples
    --------
    >>> import frictionlab as fl
    >>> run = fl.simulate(fl.Woodpecker(), 0.2, progress=False)
    >>> bool(run["y"][-1] < -0.005), "impact_1" in run.events.guard  # it is lower, and has pecked
    (True, True)
    """

    m_M: float = positive(0.0003, "kg", r"m_{\mathrm{M}}", "mass of the sleeve")
    J_M: float = positive(5e-9, "kg m^2", r"J_{\mathrm{M}}", "inertia of the sleeve")
    m_S: float = positive(0.0045, "kg", r"m_{\mathrm{S}}", "mass of the bird")
    J_S: float = positive(7e-7, "kg m^2", r"J_{\mathrm{S}}", "inertia of the bird")
    k_t: float = positive(0.0056, "N m/rad", r"k_{\mathrm{t}}", "stiffness of the spring between them")
    g: float = positive(9.81, "m/s^2", "g", "gravity")
    friction: FrictionLaw = Coulomb(mu_k=0.3, mu_s=0.3)
    impact: ImpactLaw = FrictionalImpact(e=0.5, mu_i=0.3)
    jamming: Any = FrictionalImpact(e=0.0, mu_i=0.3)
    coordinates = ("y", "phi_M", "phi_S")
    cyclic = ("y",)

    about = "a toy that pecks its way down a pole: impacts, jamming and slip in one period"
    reference = "C. Glocker, F. Pfeiffer, Nonlinear Dynamics 7 (1995) 471-497"
    not_applicable = MappingProxyType(
        {"eigenvalues": "It has no equilibrium in slip or flight: the toy falls, or hangs in stick."}
    )

    @property
    def period(self) -> float:
        """That of the bird on a sleeve that is jammed, s."""
        return 2 * pi * ((self.J_S + self.m_S * BIRD**2) / self.k_t) ** 0.5

    def release(self) -> Mapping[str, float]:
        """As the sleeve jams."""
        return {"phi_M": -CLEARANCE / HALF_SLEEVE, "phi_S": -0.2788, "y'": -0.3411, "phi_S'": -7.4583}

    @property
    def mechanism(self) -> Mechanism:
        """The pole, the sleeve on it and the bird beside it; heights stand for angles."""
        sleeve, bird = Point(0.0, 0.6, up="y"), Point(0.9, 0.6, up="phi_S")
        pole = Wall((0.0, -0.6), (0.0, 1.8))
        return Mechanism(
            pole, Spring(sleeve, bird), Block(sleeve, 0.3, 0.5), Block(bird, 0.5, 0.4, disc=True)
        )

    def mechanics(self, q: Any, v: Any) -> Mechanics:
        """Sleeve and bird; the beak and both edges of the sleeve are rigid contacts with friction."""
        bird, height = (at.y + ARM * at.phi_M + BIRD * at.phi_S for at in (v, q))
        beak = v.y + ARM * v.phi_M - REACH * v.phi_S
        law = self.friction
        stops = [Stop(0.0024 - BEAK * q.phi_S, self.impact, friction=law, relative_velocity=-beak)]
        for side in (1, -1):
            edge, rate = CLEARANCE + side * HALF_SLEEVE * q.phi_M, v.y + RADIUS * v.phi_M
            stops.append(Stop(edge, self.jamming, friction=law, relative_velocity=-rate))
        turning = (self.m_M * v.y**2 + self.m_S * bird**2 + self.J_M * v.phi_M**2 + self.J_S * v.phi_S**2) / 2
        weight = self.g * (self.m_M * q.y + self.m_S * height)
        return Mechanics(turning, self.k_t * (q.phi_M - q.phi_S) ** 2 / 2 + weight, contacts=tuple(stops))
