"""Masses on springs with dry friction: on the ground, free and driven; on a belt, one and two coupled."""

from __future__ import annotations

from collections.abc import Mapping
from math import pi
from typing import TYPE_CHECKING, Any, Unpack

from frictionlab.components import functions
from frictionlab.components.friction import Coulomb, FrictionLaw
from frictionlab.models.library.parameters import (
    frequency_parameter,
    natural_period,
    not_negative,
    of_either_sign,
    positive,
    stiffness_parameter,
)
from frictionlab.models.mechanical.mechanical_model import MechanicalModel
from frictionlab.models.mechanical.mechanics import Friction, Mechanics
from frictionlab.models.mechanism import Belt, Mechanism, Point, Spring, Wall, held_block, level_belt
from frictionlab.models.model import model

if TYPE_CHECKING:
    from frictionlab.models.library.parameters import (
        DenHartogKeywords,
        FreeCoulombKeywords,
        MassOnBeltKeywords,
        TwoBlocksKeywords,
    )


class SingleMass(MechanicalModel):
    """Base of the models of one mass m on a spring k."""

    m: Any
    k: Any
    coordinates = ("x",)

    @property
    def period(self) -> float:
        """That of the mass on its spring, s."""
        return natural_period(self.k, self.m)

    @property
    def mechanism(self) -> Mechanism:
        """A block on the ground, on a spring."""
        return Mechanism(Wall((-1.2, 0.0), (1.2, 0.0)), *held_block("x"))


@model
class FreeCoulomb(SingleMass):
    """A mass on a spring that rubs on the ground and stops for ever: m x'' + k x = F_T, F_T = -mu N sgn(x').

    Released at x_0 it turns after every half period pi sqrt(m/k), each time 2 mu_k N/k nearer to where the
    spring is slack, and stays at the first turning point with k |x| <= mu_s N.  From 10.3 with all else 1 it
    turns at -8.3, 6.3, -4.3, 2.3 and rests at -0.3 after 5 pi.

    Parameters
    ----------
    m : float
        Mass, kg, above 0.
    k : float
        Spring, N/m.
    N : float
        Normal force, N.
    x_0 : float
        Where it is released from rest, m.
    friction : FrictionLaw

    References
    ----------
    J. P. Den Hartog, Mechanical Vibrations, 4th ed., McGraw-Hill 1956.

    Examples
    --------
    >>> import frictionlab as fl
    >>> fl.simulate(fl.FreeCoulomb(), 20.0).events.state[:, 0].round(9).tolist()
    [-8.3, 6.3, -4.3, 2.3, -0.3]
    """

    m: float = positive(1.0, "kg", "m", "mass")
    k: float = stiffness_parameter()
    N: float = not_negative(1.0, 10.0, "N", "N", "normal force")
    x_0: float = of_either_sign(10.3, 20.0, "m", "x_0", "where it is released")
    friction: FrictionLaw = Coulomb(mu_k=1.0, mu_s=1.0)

    reference = "J. P. Den Hartog, Mechanical Vibrations, 4th ed., McGraw-Hill 1956"

    if TYPE_CHECKING:

        def __init__(self, **given: Unpack[FreeCoulombKeywords]) -> None: ...

    def release(self) -> Mapping[str, float]:
        """At x_0."""
        return {"x": self.x_0}

    def mechanics(self, q: Any, v: Any) -> Mechanics:
        """One mass, one contact with the ground."""
        return Mechanics(
            kinetic=self.m * v.x**2 / 2,
            potential=self.k * q.x**2 / 2,
            contacts=(Friction(-v.x, self.N, self.friction),),
        )


@model
class DenHartog(SingleMass):
    """A mass on a spring that rubs on the ground, driven: m x'' + c x' + k x = F cos(Omega t) + F_T.

    F_T = -mu N sgn(x').  Its state has the phase Omega t (rad) beside x and x'; the phase goes from 0 to
    2 pi and begins anew.  Without a damper the motion that turns twice a period has, for r = Omega sqrt(m/k)
    and f = mu_k N/F, the amplitude

        (F/k) sqrt( (1/(1 - r^2))^2 - (f sin(pi/r)/(r (1 + cos(pi/r))))^2 )

    as long as it does not stick in between.

    Parameters
    ----------
    m : float
        Mass, kg, above 0.
    c, k : float
        Damper, N s/m, and spring, N/m.
    N : float
        Normal force, N.
    F, Omega : float
        Amplitude (N) and angular frequency (rad/s) of the force.
    friction : FrictionLaw

    References
    ----------
    J. P. Den Hartog, "Forced vibrations with combined viscous and Coulomb damping", Philosophical Magazine 9
    (1930) 801-817.

    Examples
    --------
    >>> import frictionlab as fl
    >>> model = fl.DenHartog(Omega=0.8, N=0.3)
    >>> orbit = fl.periodic_orbit(model, fl.simulate(model, 100.0))
    >>> float(round(orbit.trajectory.events.state[:, 0].max(), 12))
    2.626104875723
    """

    m: float = positive(1.0, "kg", "m", "mass")
    c: float = not_negative(0.0, 2.0, "N s/m", "c", "damping")
    k: float = stiffness_parameter()
    N: float = not_negative(0.3, 10.0, "N", "N", "normal force")
    F: float = not_negative(1.0, 10.0, "N", "F", "amplitude of the force")
    Omega: float = frequency_parameter(0.8)
    friction: FrictionLaw = Coulomb(mu_k=1.0, mu_s=1.0)

    reference = "J. P. Den Hartog, Philosophical Magazine 9 (1930) 801-817"

    if TYPE_CHECKING:

        def __init__(self, **given: Unpack[DenHartogKeywords]) -> None: ...

    @property
    def period(self) -> float:
        """That of the force, s."""
        return 2 * pi / self.Omega

    def mechanics(self, q: Any, v: Any) -> Mechanics:
        """One mass, one contact with the ground, one force."""
        return Mechanics(
            kinetic=self.m * v.x**2 / 2,
            potential=self.k * q.x**2 / 2,
            dissipation=self.c * v.x**2 / 2,
            contacts=(Friction(-v.x, self.N, self.friction),),
            loads={"x": self.F * functions.cos(q.phase)},
            frequency=self.Omega,
        )


@model
class MassOnBelt(SingleMass):
    """A mass on a spring and a damper, rubbed by a belt that runs: m x'' + c x' + k x = F_T.

    It slides with v_r = v - x' and F_T = sgn(v_r) mu(|v_r|) N, and sticks while |F_T| = |k x + c v| is at
    most mu_s N.

    * **Coulomb's law, no damper**: with a = (mu_s - mu_k) N/k and w = sqrt(k/m) the mass sticks for
      2 a/v and slips for (2 pi - 2 atan(a w/v))/w.  By default that is a period of 8.902605407815 s.
      Inside that cycle lie the oscillations without stick, all of the period 2 pi/w.
    * **Friction that depends on speed**: the slope of its curve acts as a damper.  Steady sliding loses its
      stability where c + N mu'(v) = 0, at the angular frequency w.  This Hopf point is subcritical where
      -N mu'''(v), the third derivative of F_T by x', is positive.  A decaying exponential makes it so at
      every speed, and stick-slip exists beside stable sliding.
    * **Weakening and strengthening**, mu = mu_k + (mu_s - mu_k) exp(-|v_r|/v_s) + mu_v |v_r|/v_s: the Hopf
      point is at v = v_s log((mu_s - mu_k)/(mu_v + c v_s/N)).

    Parameters
    ----------
    m : float
        Mass, kg, above 0.
    c, k : float
        Damper, N s/m, and spring, N/m.
    N : float
        Normal force, N.
    v : float
        Speed of the belt, m/s.
    friction : FrictionLaw
        Coulomb(mu_k, mu_s), Stribeck(...), WeakeningStrengthening(...) or your own.

    References
    ----------
    A. Papangelo, M. Ciavarella, N. Hoffmann, Nonlinear Dynamics 90 (2017) 2037-2046, for weakening and
    strengthening; K. Popp, P. Stelter, Phil. Trans. R. Soc. A 332 (1990) 89-105.

    Examples
    --------
    >>> import frictionlab as fl
    >>> run = fl.simulate(fl.MassOnBelt(), 30.0)
    >>> onsets = run.events.t[run.events.target == "stick"]
    >>> float(round(onsets[2] - onsets[1], 12))
    8.902605407815
    """

    m: float = positive(1.0, "kg", "m", "mass")
    c: float = not_negative(0.0, 2.0, "N s/m", "c", "damping")
    k: float = stiffness_parameter()
    N: float = not_negative(1.0, 10.0, "N", "N", "normal force")
    v: float = of_either_sign(0.2, 3.0, "m/s", "v", "speed of the belt")
    friction: FrictionLaw = Coulomb(mu_k=0.5, mu_s=1.0)

    reference = "K. Popp, P. Stelter, Phil. Trans. R. Soc. A 332 (1990) 89-105"

    if TYPE_CHECKING:

        def __init__(self, **given: Unpack[MassOnBeltKeywords]) -> None: ...

    @property
    def mechanism(self) -> Mechanism:
        """A block on a belt, on a spring."""
        return Mechanism(Belt("v"), *held_block("x"))

    def mechanics(self, q: Any, v: Any) -> Mechanics:
        """One mass, one contact."""
        return Mechanics(
            kinetic=self.m * v.x**2 / 2,
            potential=self.k * q.x**2 / 2,
            dissipation=self.c * v.x**2 / 2,
            contacts=(Friction(self.v - v.x, self.N, self.friction),),
        )


@model
class TwoBlocks(MechanicalModel):
    """Two blocks on a belt, each on a spring of its own and a spring between them.

        m1 x1'' + c x1' + k1 x1 + k12 (x1 - x2) = F_T1
        m2 x2'' + c x2' + k2 x2 + k12 (x2 - x1) = F_T2

    Each sticks or slips by the same law under a normal force of its own.  A mode names what both do, as in
    "stick | slip+"; there are nine.  Equal blocks that start alike move as one: as :class:`MassOnBelt`, with
    the period 8.902605407815 s by default.  While they slide, equal blocks have the angular frequencies
    sqrt(k/m) and sqrt((k + 2 k12)/m).

    Galvanetto and Bishop use a friction law that falls hyperbolically; any law can take its place.

    Parameters
    ----------
    m1, m2 : float
        Masses, kg, above 0.
    k1, k2, k12 : float
        Springs to the ground and between the blocks, N/m.
    c : float
        Damper of each block, N s/m.
    N1, N2 : float
        Normal forces, N.
    v : float
        Speed of the belt, m/s.
    friction : FrictionLaw

    References
    ----------
    U. Galvanetto, S. R. Bishop, International Journal of Mechanical Sciences 36 (1994).

    Examples
    --------
    >>> import frictionlab as fl
    >>> run = fl.simulate(fl.TwoBlocks(), 30.0, x0=[0.1, 0.0, 0.0, 0.0])
    >>> run.events.target[:2].tolist()
    ['slip+ | stick', 'stick | stick']
    """

    m1: float = positive(1.0, "kg", "m_1", "mass of the first block")
    m2: float = positive(1.0, "kg", "m_2", "mass of the second block")
    c: float = not_negative(0.0, 2.0, "N s/m", "c", "damping of each block")
    k1: float = stiffness_parameter(1.0, "k_1", "stiffness of the first block's spring")
    k2: float = stiffness_parameter(1.0, "k_2", "stiffness of the second block's spring")
    k12: float = stiffness_parameter(1.2, "k_{12}", "stiffness between the blocks")
    N1: float = not_negative(1.0, 10.0, "N", "N_1", "normal force on the first block")
    N2: float = not_negative(1.0, 10.0, "N", "N_2", "normal force on the second block")
    v: float = of_either_sign(0.2, 3.0, "m/s", "v", "speed of the belt")
    friction: FrictionLaw = Coulomb(mu_k=0.5, mu_s=1.0)
    coordinates = ("x1", "x2")

    reference = "U. Galvanetto, S. R. Bishop, Int. J. Mechanical Sciences 36 (1994)"

    if TYPE_CHECKING:

        def __init__(self, **given: Unpack[TwoBlocksKeywords]) -> None: ...

    @property
    def period(self) -> float:
        """That of the first block on its own spring, s."""
        return natural_period(self.k1, self.m1)

    @property
    def mechanism(self) -> Mechanism:
        """Two blocks on one belt, each held by a spring, and a spring between them."""
        one = held_block("x1", wall=-2.4, place=-0.9, number="_1")
        two = held_block("x2", wall=2.4, place=0.9, number="_2")
        between = Spring(Point(-0.6, 0.2, right="x1"), Point(0.6, 0.2, right="x2"))
        return Mechanism(level_belt("v", -2.0, 2.0), *one, *two, between)

    def mechanics(self, q: Any, v: Any) -> Mechanics:
        """Two masses, two contacts."""
        springs = self.k1 * q.x1**2 + self.k2 * q.x2**2 + self.k12 * (q.x1 - q.x2) ** 2
        return Mechanics(
            kinetic=(self.m1 * v.x1**2 + self.m2 * v.x2**2) / 2,
            potential=springs / 2,
            dissipation=self.c * (v.x1**2 + v.x2**2) / 2,
            contacts=(
                Friction(self.v - v.x1, self.N1, self.friction),
                Friction(self.v - v.x2, self.N2, self.friction),
            ),
        )
