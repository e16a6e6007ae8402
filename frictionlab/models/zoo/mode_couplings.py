"""Mode coupling by friction that does not fall with speed: a mass between two contacts, pads."""

from __future__ import annotations

from typing import Any

from frictionlab.components.contact import ContactLaw, CubicContact
from frictionlab.components.friction import Coulomb, FrictionLaw
from frictionlab.components.functions import cos, sin
from frictionlab.models.library.parameters import natural_period, not_negative, of_either_sign, positive
from frictionlab.models.mechanical.mechanics import Friction, Mechanics
from frictionlab.models.mechanism import (
    Belt,
    Block,
    Forces,
    Mechanism,
    Point,
    Spring,
    Wall,
    inclined_end,
    level_belt,
)
from frictionlab.models.model import model
from frictionlab.models.zoo.zoo_model import ZooModel


@model
class HultenOscillator(ZooModel):
    """A mass that two springs with cubic parts press on two belts, and which slides on both for good.

    Each contact's normal force is that of its spring, f_i(x) = k_i x + g_i x^3, and its friction acts along
    the other's:

        m x'' + c1 x' + f_1(x) - mu f_2(y) = 0
        m y'' + c2 y' + f_2(y) + mu f_1(x) = 0

    Without dampers both modes coalesce at

        mu_c = |k1 - k2|/(2 sqrt(k1 k2)),      omega_c^2 = (k1 + k2)/(2 m).

    With dampers flutter sets in at a mu that depends on their ratio: the damper of one mode may lower it.

    Parameters
    ----------
    m : float
        Mass, kg, above 0.
    c1, c2 : float
        Dampers, N s/m.
    k1, k2 : float
        Springs, N/m.
    g1, g2 : float
        Cubic parts of the springs, N/m^3.
    mu : float
        Coefficient of friction.

    References
    ----------
    J. Hulten, SAE Technical Paper 932965 (1993), for the linear system; with cubic parts J.-J. Sinou,
    L. Jezequel, European Journal of Mechanics A/Solids 26 (2007) 106-122.

    Examples
    --------
    >>> import frictionlab as fl
    >>> model = fl.HultenOscillator(c1=0.0, c2=0.0)
    >>> abs(fl.critical_value(model, "mu", bounds=(0, 1)) - model.critical_friction) < 1e-9
    True
    """

    m: float = positive(1.0, "kg", "m", "mass")
    c1: float = not_negative(0.02, 1.0, "N s/m", "c_1", "damping along x")
    c2: float = not_negative(0.02, 1.0, "N s/m", "c_2", "damping along y")
    k1: float = positive(1.5, "N/m", "k_1", "stiffness along x")
    k2: float = positive(1.0, "N/m", "k_2", "stiffness along y")
    g1: float = not_negative(1.0, 10.0, "N/m^3", "g_1", "cubic stiffness along x")
    g2: float = not_negative(0.0, 10.0, "N/m^3", "g_2", "cubic stiffness along y")
    mu: float = not_negative(0.25, 1.0, "", r"\mu", "coefficient of friction")
    coordinates = ("x", "y")

    about = "two modes that friction couples, with a limit cycle by cubic springs alone"
    reference = "J.-J. Sinou, L. Jezequel, European J. Mechanics A/Solids 26 (2007) 106-122"

    @property
    def period(self) -> float:
        """That of the mass on the first spring, s."""
        return natural_period(self.k1, self.m)

    @property
    def critical_friction(self) -> float:
        """mu_c, at which undamped modes coalesce."""
        return abs(self.k1 - self.k2) / (2 * (self.k1 * self.k2) ** 0.5)

    def release(self) -> dict[str, float]:
        """Beside the equilibrium, which is at rest."""
        return {"x": 0.1}

    @property
    def mechanism(self) -> Mechanism:
        """A mass on a belt below it and one beside it, drawn as two springs."""
        body = Point(0.0, 0.8, right="x", up="y")
        below = Spring(Point(0.0, 0.0), body.beside(0.0, -0.2))
        beside = Spring(Point(-1.2, 0.8), body.beside(-0.3))
        return Mechanism(level_belt("", -0.9, 1.1), below, beside, Block(body))

    def mechanics(self, q: Any, v: Any) -> Mechanics:
        """One mass; friction as loads, as it never reverses."""
        first, second = self.k1 * q.x + self.g1 * q.x**3, self.k2 * q.y + self.g2 * q.y**3
        linear, cubic = (self.k1 * q.x**2 + self.k2 * q.y**2) / 2, (self.g1 * q.x**4 + self.g2 * q.y**4) / 4
        dampers = (self.c1 * v.x**2 + self.c2 * v.y**2) / 2
        rubbing = {"x": self.mu * second, "y": -self.mu * first}
        return Mechanics(self.m * (v.x**2 + v.y**2) / 2, linear + cubic, dampers, loads=rubbing)


@model
class StrutPad(ZooModel):
    """A pad on a belt, on a strut at the angle theta, that a second mass presses on it through a spring.

    It sticks, slips and leaves the belt, and how long it does each tells creaks from squeals.  In steady
    sliding the strut presses too, by Spurr's formula

        F_N = F/(1 - mu_k tan theta),

    so that there is none where mu_k tan theta is 1: the strut jams (sprag-slip).  With theta below zero the
    strut pulls away, and modes couple.  The system is of the kind of Elmaian and others, of three freedoms;
    its equations and numbers are this package's.

    Parameters
    ----------
    m, m_b : float
        Masses of the pad and behind it, kg, above 0.
    c : float
        Damping of each coordinate, N s/m.
    k, k_b, k_n : float
        Stiffness of the strut, of the spring behind the pad and of the contact, N/m.
    theta : float
        Angle of the strut with the belt, rad.
    F : float
        Force on the second mass, N.
    v : float
        Speed of the belt, m/s.
    friction : FrictionLaw

    References
    ----------
    A. Elmaian, F. Gautier, C. Pezerat, J. M. Duffal, Applied Acoustics 76 (2014) 391-401.
    R. T. Spurr, Proceedings of the Institution of Mechanical Engineers: Automobile Division 15 (1961) 33-52.

    Examples
    --------
    >>> import frictionlab as fl
    >>> model = fl.StrutPad()
    >>> abs(fl.equilibrium(model).normal_force - model.sliding_force) < 1e-12
    True
    """

    m: float = positive(1.0, "kg", "m", "mass of the pad")
    m_b: float = positive(1.0, "kg", r"m_{\mathrm{b}}", "mass behind the pad")
    c: float = not_negative(0.05, 1.0, "N s/m", "c", "damping of each coordinate")
    k: float = positive(2.0, "N/m", "k", "stiffness of the strut")
    k_b: float = positive(1.0, "N/m", r"k_{\mathrm{b}}", "stiffness of the spring behind the pad")
    k_n: float = positive(2.0, "N/m", r"k_{\mathrm{n}}", "contact stiffness")
    theta: float = of_either_sign(0.3, 1.2, "rad", r"\theta", "angle of the strut")
    F: float = positive(1.0, "N", "F", "force on the second mass")
    v: float = of_either_sign(0.1, 2.0, "m/s", "v", "speed of the belt")
    friction: FrictionLaw = Coulomb(mu_k=0.6, mu_s=0.75)
    coordinates = ("x", "y", "z")

    about = "a pad on a strut: stick, slip and separation; it jams where mu tan(theta) is 1"
    reference = "A. Elmaian, F. Gautier, C. Pezerat, J. M. Duffal, Applied Acoustics 76 (2014) 391-401"

    @property
    def period(self) -> float:
        """That of the pad on its strut, s."""
        return natural_period(self.k, self.m)

    @property
    def sliding_force(self) -> float:
        """F_N of steady sliding with Coulomb's friction, N: Spurr's formula."""
        return self.F / (1 - self.parameters["mu_k"] * float(sin(self.theta) / cos(self.theta)))

    @property
    def mechanism(self) -> Mechanism:
        """The pad on its contact spring, the strut to the left, the second mass above."""
        pad, back = Point(0.0, 0.8, right="x", up="-y"), Point(0.0, 1.8, up="-z")
        contact = Spring(Point(0.0, 0.0, right="x"), pad.beside(0.0, -0.2), loose="separation")
        x, y = inclined_end(self.theta)
        strut = Spring(Point(x, 0.8 + y), pad), Wall((x - 0.15, 0.8 + y), (x + 0.15, 0.8 + y))
        return Mechanism(Belt("v"), contact, *strut, Spring(pad, back), Block(pad), Block(back), Forces(pad))

    def mechanics(self, q: Any, v: Any) -> Mechanics:
        """Two masses, one contact."""
        strut = self.k * (cos(self.theta) * q.x - sin(self.theta) * q.y) ** 2 / 2
        springs = strut + self.k_b * (q.z - q.y) ** 2 / 2
        pad, back = v.x**2 + v.y**2, v.z**2
        rubbing = Friction(self.v - v.x, lambda d: self.k_n * d, self.friction, penetration=q.y)
        kinetic = (self.m * pad + self.m_b * back) / 2
        return Mechanics(kinetic, springs - self.F * q.z, self.c * (pad + back) / 2, (rubbing,))


@model
class PadOnDisc(ZooModel):
    """A pad and a disc, each of two freedoms, with a cubic contact between them that rubs.

    With a contact that hardens the Hopf point is subcritical: below the critical friction steady sliding is
    stable, and beside it there is a vibration with slip and separation, of which eigenvalues say nothing.
    The system is of the kind of Zhang, Oberst and Lai's of four freedoms; its equations and numbers are this
    package's.

    Parameters
    ----------
    m1, m2 : float
        Masses of the pad and the disc, kg, above 0.
    c : float
        Damping of each coordinate, N s/m.
    k_x, k_y, k_c : float
        Springs of the pad along the disc, across it, and at 45 degrees, N/m.
    k_d : float
        Springs of the disc along both directions, N/m.
    F : float
        Force on the pad, N.
    v : float
        Speed of the disc's surface, m/s.
    contact : ContactLaw
    friction : FrictionLaw

    References
    ----------
    Z. Zhang, S. Oberst, J. C. S. Lai, Journal of Sound and Vibration 443 (2019) 328-340.

    Examples
    --------
    >>> import frictionlab as fl
    >>> fl.hopf(fl.PadOnDisc(), "mu_k", bounds=(0.5, 1.5)).criticality
    'subcritical'
    """

    m1: float = positive(1.0, "kg", "m_1", "mass of the pad")
    m2: float = positive(2.0, "kg", "m_2", "mass of the disc")
    c: float = not_negative(0.05, 1.0, "N s/m", "c", "damping of each coordinate")
    k_x: float = positive(2.0, "N/m", r"k_{\mathrm{x}}", "stiffness of the pad along the disc")
    k_y: float = positive(1.0, "N/m", r"k_{\mathrm{y}}", "stiffness of the pad across the disc")
    k_c: float = positive(0.5, "N/m", r"k_{\mathrm{c}}", "stiffness at 45 degrees")
    k_d: float = positive(2.0, "N/m", r"k_{\mathrm{d}}", "stiffness of the disc")
    F: float = positive(1.0, "N", "F", "force on the pad")
    v: float = of_either_sign(1.0, 5.0, "m/s", "v", "speed of the disc's surface")
    contact: ContactLaw = CubicContact(k2=1.0, k_nl=5.0)
    friction: FrictionLaw = Coulomb(mu_k=0.92, mu_s=0.92)
    coordinates = ("x1", "y1", "x2", "y2")

    about = "a pad and a disc of four freedoms: a subcritical Hopf point, which eigenvalues do not tell"
    reference = "Z. Zhang, S. Oberst, J. C. S. Lai, J. Sound and Vibration 443 (2019) 328-340"

    @property
    def period(self) -> float:
        """That of the pad across the disc, s."""
        return natural_period(self.k_y, self.m1)

    def release(self) -> dict[str, float]:
        """Far from steady sliding, which is stable."""
        return {"y1": 2.0}

    @property
    def mechanism(self) -> Mechanism:
        """The pad above the disc, each on its springs."""
        pad, disc = Point(0.0, 1.1, right="x1", up="-y1"), Point(0.0, 0.2, right="x2", up="-y2")
        contact = Spring(disc.beside(0.0, 0.2), pad.beside(0.0, -0.2), loose="separation")
        held = Spring(Point(-1.6, 1.1), pad.beside(-0.3)), Spring(Point(-1.6, 0.2), disc.beside(-0.6))
        inclined = Spring(Point(-1.0, 2.1), pad.beside(-0.3, 0.2))
        walls = Wall((-1.6, 0.0), (-1.6, 1.4)), Wall((-1.2, 2.1), (-0.8, 2.1))
        return Mechanism(*walls, *held, inclined, contact, Block(disc, 1.2), Block(pad), Forces(pad))

    def mechanics(self, q: Any, v: Any) -> Mechanics:
        """Two masses, one contact."""
        held = self.k_x * q.x1**2 + self.k_y * q.y1**2 + self.k_c * (q.x1 + q.y1) ** 2
        springs = (held + self.k_d * (q.x2**2 + q.y2**2)) / 2
        pad, disc = v.x1**2 + v.y1**2, v.x2**2 + v.y2**2
        v_r, depth = self.v + v.x2 - v.x1, q.y1 - q.y2
        rubbing = Friction(v_r, self.contact.force, self.friction, penetration=depth)
        kinetic = (self.m1 * pad + self.m2 * disc) / 2
        return Mechanics(kinetic, springs - self.F * q.y1, self.c * (pad + disc) / 2, (rubbing,))
