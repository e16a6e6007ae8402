"""What turns: a disc that wobbles between its pads, a drill string, a pendulum on a shaft."""

from __future__ import annotations

from collections.abc import Mapping
from math import pi
from types import MappingProxyType
from typing import Any

from frictionlab.components.friction import Coulomb, ExponentialDecay, FrictionLaw, Stribeck
from frictionlab.components.functions import cos, sin
from frictionlab.models.library.parameters import natural_period, not_negative, of_either_sign, positive
from frictionlab.models.mechanical.mechanics import Friction, Mechanics
from frictionlab.models.mechanism import (
    Block,
    Forces,
    Mechanism,
    Point,
    Spring,
    Turn,
    Wall,
    disc_with_mark,
)
from frictionlab.models.model import model
from frictionlab.models.zoo.zoo_model import LINEAR, ZooModel


@model
class WobblingDisc(ZooModel):
    """A rigid disc on an elastic hub that turns between two pads, for small tilts q1 and q2.

        J q1'' + d q1' + 2 J Omega q2' + (k_t + 2 k r^2) q1 = 0
        J q2'' + d q2' - 2 J Omega q1' + k_t q2 - mu k h r q1 = 0

    The pads are springs k on both sides at the radius r.  Where the disc tilts towards one of them, that pad
    presses more and the other less, and their friction forces are a couple with the lever h, the thickness.
    Gyroscopic forces and this circulating one make steady rotation unstable for every mu where there is no
    damper, although friction does not fall with speed.

    The system is of the kind of von Wagner, Hochlenert and Hagedorn, without what the preload adds; the
    numbers are this package's.

    Parameters
    ----------
    J : float
        Inertia about a diameter, kg m^2, above 0.
    d, k_t : float
        Rotational damper (N m s) and spring (N m) of the hub.
    k : float
        Spring of a pad, N/m.
    r, h : float
        Radius of the pads and thickness of the disc, m.
    Omega : float
        Angular velocity, rad/s.
    mu : float
        Coefficient of friction.

    References
    ----------
    U. von Wagner, D. Hochlenert, P. Hagedorn, Journal of Sound and Vibration 302 (2007) 527-539.

    Examples
    --------
    >>> import frictionlab as fl
    >>> [fl.eigenvalues(fl.WobblingDisc(d=d)).stable for d in (0.0, 0.5)]
    [False, True]
    """

    J: float = positive(0.16, "kg m^2", "J", "inertia about a diameter")
    d: float = not_negative(0.1, 2.0, "N m s", "d", "damping of the hub")
    k_t: float = positive(1.88e4, "N m", r"k_{\mathrm{t}}", "stiffness of the hub")
    k: float = positive(6e5, "N/m", "k", "stiffness of a pad")
    r: float = positive(0.13, "m", "r", "radius of the pads")
    h: float = positive(0.02, "m", "h", "thickness of the disc")
    Omega: float = of_either_sign(10.0, 100.0, "rad/s", r"\Omega", "angular velocity")
    mu: float = not_negative(0.6, 2.0, "", r"\mu", "coefficient of friction")
    coordinates = ("q1", "q2")

    about = "a disc that turns between pads: gyroscopic and circulating forces make it wobble"
    reference = "U. von Wagner, D. Hochlenert, P. Hagedorn, J. Sound and Vibration 302 (2007) 527-539"
    not_applicable = LINEAR

    @property
    def period(self) -> float:
        """That of a tilt on the hub alone, s."""
        return natural_period(self.k_t, self.J)

    def release(self) -> Mapping[str, float]:
        """With a small tilt."""
        return {"q1": 1e-3}

    @property
    def mechanism(self) -> Mechanism:
        """The rim between both pads; a height stands for a tilt."""
        rim = Point(0.0, 0.0, up="q1")
        upper, lower = (Spring(Point(0.0, y), rim.beside(0.0, 0.1 * y)) for y in (1.0, -1.0))
        walls = Wall((-0.5, 1.0), (0.5, 1.0)), Wall((-0.5, -1.0), (0.5, -1.0))
        return Mechanism(*walls, upper, lower, Block(rim, 1.6, 0.2))

    def mechanics(self, q: Any, v: Any) -> Mechanics:
        """Two tilts; the moments of gyroscopic forces and of friction are loads."""
        kinetic, dampers = self.J * (v.q1**2 + v.q2**2) / 2, self.d * (v.q1**2 + v.q2**2) / 2
        springs = self.k_t * (q.q1**2 + q.q2**2) / 2 + self.k * (self.r * q.q1) ** 2
        spin, couple = 2 * self.J * self.Omega, self.mu * self.k * self.h * self.r
        return Mechanics(
            kinetic, springs, dampers, loads={"q1": -spin * v.q2, "q2": spin * v.q1 + couple * q.q1}
        )


@model
class DrillString(ZooModel):
    """A drill string of two inertias: a table with a motor, a shaft, and a bit that rubs on the rock.

        J phi1'' + d (phi1' - phi2') + k (phi1 - phi2) = c_m (Omega - phi1')
        J_b phi2'' + d (phi2' - phi1') + k (phi2 - phi1) = -mu(phi2') T

    The bit's torque falls with its speed.  Steady rotation, an equilibrium of what turns for ever, is stable
    above a speed, and below it the bit stops and is torn loose again and again.  The numbers are this
    package's.

    Parameters
    ----------
    J, J_b : float
        Inertias of table and bit, kg m^2, above 0.
    k, d : float
        Spring (N m) and damper (N m s) of the shaft.
    c_m : float
        Slope of the motor's torque, N m s.
    Omega : float
        Speed of the motor without a load, rad/s.
    T : float
        Torque of the bit at mu = 1, N m.
    friction : FrictionLaw

    References
    ----------
    J. D. Jansen, L. van den Steen, Journal of Sound and Vibration 179 (1995) 647-668.

    Examples
    --------
    >>> import frictionlab as fl
    >>> [fl.eigenvalues(fl.DrillString(Omega=speed)).stable for speed in (6.0, 25.0)]
    [False, True]
    """

    J: float = positive(2000.0, "kg m^2", "J", "inertia of the table")
    J_b: float = positive(400.0, "kg m^2", r"J_{\mathrm{b}}", "inertia of the bit")
    k: float = positive(500.0, "N m", "k", "stiffness of the shaft")
    d: float = not_negative(50.0, 500.0, "N m s", "d", "damping of the shaft")
    c_m: float = positive(400.0, "N m s", r"c_{\mathrm{m}}", "slope of the motor's torque")
    Omega: float = of_either_sign(6.0, 30.0, "rad/s", r"\Omega", "speed of the motor without a load")
    T: float = not_negative(2000.0, 10000.0, "N m", "T", "torque of the bit")
    friction: FrictionLaw = ExponentialDecay(mu_k=0.5, mu_s=1.0, v_s=3.0)
    coordinates = ("phi1", "phi2")
    cyclic = ("phi1", "phi2")

    about = "a drill string that turns steadily, or whose bit stops and goes"
    reference = "J. D. Jansen, L. van den Steen, J. Sound and Vibration 179 (1995) 647-668"

    @property
    def period(self) -> float:
        """That of the bit on the shaft, s."""
        return natural_period(self.k, self.J_b)

    @property
    def mechanism(self) -> Mechanism:
        """Table and bit, seen from above."""
        return Mechanism(*disc_with_mark("phi1", 1.0), *disc_with_mark("phi2", 0.5))

    def mechanics(self, q: Any, v: Any) -> Mechanics:
        """Two inertias, one contact."""
        kinetic = (self.J * v.phi1**2 + self.J_b * v.phi2**2) / 2
        motor, shaft = self.c_m * (v.phi1 - self.Omega) ** 2 / 2, self.d * (v.phi1 - v.phi2) ** 2 / 2
        rubbing = Friction(-v.phi2, self.T, self.friction)
        return Mechanics(kinetic, self.k * (q.phi1 - q.phi2) ** 2 / 2, motor + shaft, contacts=(rubbing,))


@model
class FroudePendulum(ZooModel):
    """A pendulum on a shaft that turns and takes it along: m l^2 theta'' + m g l sin theta = r F_T.

    F_T = mu(v_r) N with v_r = r (Omega - theta').  It hangs aside at sin theta = r mu(r Omega) N/(m g l), and
    swings where friction falls with speed.

    Parameters
    ----------
    m, l : float
        Mass (kg) and length (m) of the pendulum, above 0.
    g : float
        Gravity, m/s^2.
    r : float
        Radius of the shaft, m.
    N : float
        Normal force of the sleeve, N.
    Omega : float
        Speed of the shaft, rad/s.
    friction : FrictionLaw

    References
    ----------
    A. A. Andronov, A. A. Vitt, S. E. Khaikin, Theory of Oscillators, Pergamon 1966.

    Examples
    --------
    >>> import math
    >>> import frictionlab as fl
    >>> model = fl.FroudePendulum(friction=fl.Coulomb(mu_k=0.5, mu_s=0.8))
    >>> torque = 0.5 * model.N * model.r
    >>> aside = math.asin(torque / (model.m * model.g * model.l))
    >>> bool(abs(fl.equilibrium(model).q[0] - aside) < 1e-12)
    True
    """

    m: float = positive(1.0, "kg", "m", "mass of the pendulum")
    l: float = positive(0.3, "m", "l", "length of the pendulum")  # as in every textbook
    g: float = positive(9.81, "m/s^2", "g", "gravity")
    r: float = positive(0.02, "m", "r", "radius of the shaft")
    N: float = not_negative(40.0, 200.0, "N", "N", "normal force of the sleeve")
    Omega: float = of_either_sign(5.0, 20.0, "rad/s", r"\Omega", "speed of the shaft")
    friction: FrictionLaw = Stribeck(mu_k=0.5, mu_s=0.8, v_s=0.1)
    coordinates = ("theta",)

    about = "a pendulum that a turning shaft takes along"
    reference = "A. A. Andronov, A. A. Vitt, S. E. Khaikin, Theory of Oscillators, Pergamon 1966"

    @property
    def period(self) -> float:
        """That of small swings, s."""
        return 2 * pi * (self.l / self.g) ** 0.5

    @property
    def mechanism(self) -> Mechanism:
        """The bob on its rod, which hangs from the shaft."""
        pivot, bob = Point(0.0, 0.0), Point(0.0, 0.0, turn=Turn("theta", 1.0, 1.0, -pi / 2))
        return Mechanism(Wall(pivot, bob), Block(pivot, 0.3, 0.3, disc=True), Block(bob, 0.4, 0.4, disc=True))

    def mechanics(self, q: Any, v: Any) -> Mechanics:
        """One pendulum, one contact."""
        kinetic, weight = self.m * (self.l * v.theta) ** 2 / 2, self.m * self.g * self.l * (1 - cos(q.theta))
        rubbing = Friction(self.r * (self.Omega - v.theta), self.N, self.friction)
        return Mechanics(kinetic, weight, contacts=(rubbing,))


@model
class MotorAndCart(ZooModel):
    """A motor whose pin drives a cart to and fro in a slot, as in a Scotch yoke; the cart rubs on its rails.

        (J + m r^2 s^2) alpha'' + m r^2 s c alpha'^2 + b alpha' = K i + r s F_T
        L i' + R i + K alpha' = U

    with s = sin alpha and c = cos alpha.  The cart is at r c.  Its inertia and its friction make the motor
    turn unevenly, and a weak motor stops.  The system is of the kind of Lima and Sampaio; the numbers are
    this package's.

    Parameters
    ----------
    J, m : float
        Inertia of the motor (kg m^2) and mass of the cart (kg), above 0.
    r : float
        Radius of the pin, m.
    b : float
        Damping of the motor, N m s.
    K, L, R : float
        Constant of the motor (N m/A), inductance (H) and resistance (ohm).
    U : float
        Voltage, V.
    N : float
        Normal force of the cart, N.
    friction : FrictionLaw

    References
    ----------
    R. Lima, R. Sampaio, Nonlinear Dynamics 100 (2020) 2215-2224.

    Examples
    --------
    >>> import frictionlab as fl
    >>> fl.simulate(fl.MotorAndCart(), 20.0).status.ok
    True
    """

    J: float = positive(0.5, "kg m^2", "J", "inertia of the motor")
    m: float = positive(1.0, "kg", "m", "mass of the cart")
    r: float = positive(0.2, "m", "r", "radius of the pin")
    b: float = not_negative(0.05, 1.0, "N m s", "b", "damping of the motor")
    K: float = positive(0.3, "N m/A", "K", "constant of the motor")
    L: float = positive(0.1, "H", "L", "inductance")
    R: float = positive(1.0, "ohm", "R", "resistance")
    U: float = of_either_sign(2.0, 10.0, "V", "U", "voltage")
    N: float = not_negative(1.0, 10.0, "N", "N", "normal force of the cart")
    friction: FrictionLaw = Coulomb(mu_k=0.4, mu_s=0.6)
    coordinates = ("alpha",)
    states = ("i",)
    cyclic = ("alpha",)
    period = 4.0

    about = "a motor that drives a cart with dry friction: it turns unevenly, or stops"
    reference = "R. Lima, R. Sampaio, Nonlinear Dynamics 100 (2020) 2215-2224"
    not_applicable = MappingProxyType(
        {"eigenvalues": "The inertia changes with the angle, so that no steady rotation is an equilibrium."}
    )

    @property
    def mechanism(self) -> Mechanism:
        """The motor's pin in the slot of the cart."""
        cart = Point(0.0, 0.2, turn=Turn("alpha", 0.5, 0.0))
        slot = Wall(cart.beside(0.0, 0.2), cart.beside(0.0, 1.7))
        motor = disc_with_mark("alpha", 0.5, y=1.2)
        return Mechanism(Wall((-1.2, 0.0), (1.2, 0.0)), slot, Block(cart), *motor, Forces(cart))

    def mechanics(self, q: Any, v: Any, s: Any) -> Mechanics:
        """One turning inertia, one contact, one current."""
        speed = -self.r * sin(q.alpha) * v.alpha
        kinetic, dampers = (self.J * v.alpha**2 + self.m * speed**2) / 2, self.b * v.alpha**2 / 2
        current = (self.U - self.R * s.i - self.K * v.alpha) / self.L
        rubbing = Friction(-speed, self.N, self.friction)
        return Mechanics(kinetic, 0, dampers, (rubbing,), {"alpha": self.K * s.i}, rates={"i": current})
