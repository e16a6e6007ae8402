"""Structures in their modes: a bowed string, a beam that a mass runs over, a disc between pads."""

from __future__ import annotations

from collections.abc import Mapping
from math import pi
from typing import Any

from frictionlab.components.friction import FrictionLaw, HyperbolicDecay
from frictionlab.components.functions import cos, sin, tan
from frictionlab.components.impact import ImpactLaw, RestitutionImpact
from frictionlab.models.library.parameters import not_negative, of_either_sign, positive
from frictionlab.models.mechanical.mechanical_model import numbered
from frictionlab.models.mechanical.mechanics import Friction, Mechanics, Stop
from frictionlab.models.mechanism import Belt, Block, Mechanism, Point, Spring, Wall
from frictionlab.models.model import model
from frictionlab.models.zoo.zoo_model import LINEAR, UNBOUNDED, ZooModel, of_what_ends


@model
class BowedString(ZooModel):
    """A string of the length 1 and the wave speed 1 in its first modes, bowed at the place beta.

    The deflection is the sum of q_i sin(i pi x), and with the mass m of the string

        m/2 (q_i'' + d i^2 q_i' + (i pi)^2 q_i) = F_T sin(i pi beta),   v_r = v - sum of q_i' sin(i pi beta).

    In Helmholtz's motion, of the period 2 of the free string, the bow carries the string along for the share
    1 - beta of a period, and the string flies back for the share beta.  The motion of few damped modes has
    one flight in a period too, which is longer, and so is the period: the note is flat.  The numbers are
    this package's.

    Parameters
    ----------
    m : float
        Mass of the string, kg, above 0.
    d : float
        Damping of the first mode, 1/s.
    beta : float
        Place of the bow, a share of the length.
    N : float
        Normal force of the bow, N.
    v : float
        Speed of the bow, m/s.
    modes : int
    friction : FrictionLaw

    References
    ----------
    M. E. McIntyre, R. T. Schumacher, J. Woodhouse, Journal of the Acoustical Society of America 74 (1983)
    1325-1345.

    Examples
    --------
    >>> import frictionlab as fl
    >>> model = fl.BowedString()
    >>> orbit = fl.periodic_orbit(model, fl.simulate(model, 200.0))
    >>> round(orbit.period, 3), [name for name, _ in orbit.modes]
    (2.05, ['stick', 'slip+'])
    """

    m: float = positive(1.0, "kg", "m", "mass of the string")
    d: float = not_negative(0.1, 1.0, "1/s", "d", "damping of the first mode")
    beta: float = positive(0.2, "", r"\beta", "place of the bow")
    N: float = not_negative(2.0, 5.0, "N", "N", "normal force of the bow")
    v: float = of_either_sign(0.2, 1.0, "m/s", "v", "speed of the bow")
    friction: FrictionLaw = HyperbolicDecay(mu_k=0.3, mu_s=0.8, v_s=0.1)
    modes: int = 6
    coordinates = numbered("q", count="modes")
    period = 2.0

    about = "a string in modes under a bow: stick for most of a period, a short flight back"
    reference = "M. E. McIntyre, R. T. Schumacher, J. Woodhouse, J. Acoust. Soc. America 74 (1983) 1325-1345"
    not_applicable = UNBOUNDED

    def release(self) -> Mapping[str, float]:
        """In Helmholtz's motion, half-way through stick."""
        first = 2 * self.v / (pi * self.beta)
        return {f"{name}'": first * (-1) ** i / (i + 1) for i, name in enumerate(self.coordinates)}

    @property
    def mechanism(self) -> Mechanism:
        """The string as a thread to a bead that moves with the first mode, and the bow."""
        bead = Point(-0.6, 0.2, right="q1")
        threads = Spring(Point(-1.6, 0.2), bead), Spring(bead, Point(1.6, 0.2))
        ends = Wall((-1.6, 0.0), (-1.6, 0.4)), Wall((1.6, 0.0), (1.6, 0.4))
        return Mechanism(Belt("v"), *ends, *threads, Block(bead, 0.2, 0.4))

    def mechanics(self, q: Any, v: Any) -> Mechanics:
        """The modes, one contact."""
        bowed = sum(u * sin(i * pi * self.beta) for i, u in enumerate(v, 1))
        kinetic = self.m * sum(u**2 for u in v) / 4
        tension = self.m * sum((i * pi * x) ** 2 for i, x in enumerate(q, 1)) / 4
        rubbing = Friction(self.v - bowed, self.N, self.friction)
        dampers = self.d * self.m * sum((i * u) ** 2 for i, u in enumerate(v, 1)) / 4
        return Mechanics(kinetic, tension, dampers, (rubbing,))


@model
class MassOnBeam(ZooModel):
    """A mass that runs over a beam at a constant speed, in the beam's modes; it may leave the beam.

    The beam of the length 1 is simply supported: its deflection is the sum of q_i sin(i pi x), with y, the
    height of the mass, upwards, and

        m_b/2 (q_i'' + d q_i' + (i pi)^4 w^2/pi^4 q_i) = -F_N sin(i pi v t),    m y'' = F_N - m g.

    In contact y is the deflection at x = v t.  The numbers are this package's.

    Parameters
    ----------
    m, m_b : float
        Masses of the body and of the beam, kg, above 0.
    w : float
        First angular frequency of the beam, rad/s.
    d : float
        Damping of each mode, 1/s.
    v : float
        Speed, lengths of the beam a second.
    g : float
        Gravity, m/s^2.
    modes : int
    impact : ImpactLaw
        RestitutionImpact(e).

    References
    ----------
    D. Stancioiu, H. Ouyang, J. E. Mottershead, Journal of Sound and Vibration 310 (2008) 1128-1147.

    Examples
    --------
    >>> import frictionlab as fl
    >>> run = fl.simulate(fl.MassOnBeam(), 1.0)
    >>> bool(run["y"].min() < 0), run.status.ok
    (True, True)
    """

    m: float = positive(0.5, "kg", "m", "mass of the body")
    m_b: float = positive(1.0, "kg", r"m_{\mathrm{b}}", "mass of the beam")
    w: float = positive(5.0, "rad/s", "w", "first angular frequency of the beam")
    d: float = not_negative(0.0, 2.0, "1/s", "d", "damping of each mode")
    v: float = positive(1.0, "1/s", "v", "speed, in lengths of the beam")
    g: float = positive(9.81, "m/s^2", "g", "gravity")
    impact: ImpactLaw = RestitutionImpact(e=0.0)
    modes: int = 3
    period = 1.0

    about = "a mass that runs over a beam, leaves it and comes back"
    reference = "D. Stancioiu, H. Ouyang, J. E. Mottershead, J. Sound and Vibration 310 (2008) 1128-1147"
    not_applicable = of_what_ends("The mass runs over the beam once, so that no motion comes back.")

    def check(self) -> None:
        """`modes` is from 1 to 100."""
        self.check_count("modes", least=1)
        super().check()

    @property
    def coordinates(self) -> tuple[str, ...]:
        """y of the mass, and q1, q2, ... of the beam."""
        return ("y", *(f"q{i + 1}" for i in range(self.modes)))

    @property
    def mechanism(self) -> Mechanism:
        """The mass above the middle of the beam, which moves with the first mode."""
        middle = Point(0.0, 0.0, up="q1")
        beam = Wall(Point(-1.6, 0.0), middle), Wall(middle, Point(1.6, 0.0))
        return Mechanism(*beam, Block(Point(0.0, 0.2, up="y"), 0.4, 0.4, disc=True))

    def mechanics(self, q: Any, v: Any) -> Mechanics:
        """The mass, the modes, one stop that travels."""
        deflection = sum(x * sin(i * pi * self.v * q.t) for i, x in enumerate(q[1:], 1))
        beam = self.m_b * sum(u**2 for u in v[1:]) / 4
        bending = self.m_b * self.w**2 * sum(i**4 * x**2 for i, x in enumerate(q[1:], 1)) / 4
        stop = Stop(q.y - deflection, self.impact)
        kinetic, weight = self.m * v.y**2 / 2 + beam, self.m * self.g * q.y
        return Mechanics(kinetic, bending + weight, self.d * beam, (stop,))


@model
class DiscAndPads(ZooModel):
    """A disc in two modes of n nodal diameters, cos n phi and sin n phi, between pads at -theta and theta.

    A pad is a spring k on the disc.  Where the disc moves towards it, its friction on the face, at half the
    thickness, bends the disc along the circumference: a force mu k (h/(2 r)) dw/dphi.  With modal masses of
    1 kg, flutter sets in without a damper at

        mu_c = 2 r/(n h) |cot(2 n theta)|,

    whatever k: two modes that the pads separate by 2 k cos(2 n theta) are coupled by friction.  The disc is
    of the kind of Kang, Krousgrill and Sadeghi's; this minimum of it and its numbers are this package's.

    Parameters
    ----------
    w : float
        Angular frequency of the free disc, rad/s.
    c : float
        Damping of each mode, N s/m.
    k : float
        Spring of a pad, N/m.
    r, h : float
        Radius of the pads and thickness of the disc, m.
    theta : float
        Angle of a pad, rad.
    mu : float
        Coefficient of friction.
    diameters : int
        n.

    References
    ----------
    J. Kang, C. M. Krousgrill, F. Sadeghi, Journal of Sound and Vibration 316 (2008) 164-179.

    Examples
    --------
    >>> import frictionlab as fl
    >>> model = fl.DiscAndPads(c=0.0)
    >>> abs(fl.critical_value(model, "mu", bounds=(0.0, 1.0)) - model.critical_friction) < 1e-9
    True
    """

    w: float = positive(10.0, "rad/s", "w", "angular frequency of the free disc")
    c: float = not_negative(0.05, 1.0, "N s/m", "c", "damping of each mode")
    k: float = positive(20.0, "N/m", "k", "stiffness of a pad")
    r: float = positive(0.13, "m", "r", "radius of the pads")
    h: float = positive(0.02, "m", "h", "thickness of the disc")
    theta: float = of_either_sign(0.25, 1.0, "rad", r"\theta", "angle of a pad")
    mu: float = not_negative(0.4, 2.0, "", r"\mu", "coefficient of friction")
    diameters: int = 3
    coordinates = ("a", "b")

    about = "two modes of a disc that pads separate and friction couples"
    reference = "J. Kang, C. M. Krousgrill, F. Sadeghi, J. Sound and Vibration 316 (2008) 164-179"
    not_applicable = LINEAR

    def check(self) -> None:
        """`diameters` is from 1 to 100."""
        self.check_count("diameters", least=1)
        super().check()

    @property
    def period(self) -> float:
        """That of the free disc, s."""
        return 2 * pi / self.w

    @property
    def critical_friction(self) -> float:
        """mu_c, at which undamped modes coalesce."""
        return 2 * self.r / (self.diameters * self.h) / abs(float(tan(2 * self.diameters * self.theta)))

    def release(self) -> Mapping[str, float]:
        """With a small deflection."""
        return {"a": 0.01}

    @property
    def mechanism(self) -> Mechanism:
        """Two places of the rim, one for each mode, on the springs of the pads."""
        one, two = Point(-0.7, 0.6, up="a"), Point(0.7, 0.6, up="b")
        springs = Spring(Point(-0.7, 0.0), one), Spring(Point(0.7, 0.0), two)
        return Mechanism(Wall((-1.4, 0.0), (1.4, 0.0)), *springs, Block(one, 1.0, 0.2), Block(two, 1.0, 0.2))

    def mechanics(self, q: Any, v: Any) -> Mechanics:
        """Two modes; friction of the pads as loads."""
        c, s = cos(self.diameters * self.theta), sin(self.diameters * self.theta)
        springs = self.w**2 * (q.a**2 + q.b**2) / 2 + self.k * ((c * q.a) ** 2 + (s * q.b) ** 2)
        couple = self.mu * self.k * self.diameters * self.h / self.r
        rubbing = {"a": couple * s**2 * q.b, "b": -couple * c**2 * q.a}
        squares = v.a**2 + v.b**2
        return Mechanics(squares / 2, springs, self.c * squares / 2, loads=rubbing)
