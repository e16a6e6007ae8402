"""Sliders on a moving belt: the paper's, with impacts and a moving load, on a belt that is held by springs;
and one mass in the plane on a linear or a nonlinear contact spring, which it may leave.
"""

from __future__ import annotations

from math import pi
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, Unpack

from frictionlab.components import functions
from frictionlab.components.component import parameter, parameters_of
from frictionlab.components.contact import (
    ContactLaw,
    CubicContact,
    Geometry,
    Interface,
    MovingLoad,
    StickSlipSeparation,
)
from frictionlab.components.friction import Coulomb, FrictionLaw
from frictionlab.components.impact import ImpactLaw, PlasticImpact
from frictionlab.models.library.parameters import (
    natural_period,
    not_negative,
    of_either_sign,
    positive,
    stiffness_parameter,
)
from frictionlab.models.mechanical.mechanical_model import (
    MechanicalModel,
    PlanarSlider,
    inclined_spring_energy,
)
from frictionlab.models.mechanical.mechanics import Friction, Mechanics, SlidingStatics
from frictionlab.models.mechanism import (
    Belt,
    Block,
    Forces,
    Load,
    Mechanism,
    Point,
    Spring,
    Turn,
    Wall,
    body_on_belt,
    inclined_end,
)
from frictionlab.models.model import model

if TYPE_CHECKING:
    from .parameters import ModeCouplingKeywords, SliderOnBeltKeywords, SliderOnRigidBeltKeywords

BELT_RANGE, RIGID_BELT_RANGE = (1e3, 1e6), (1e3, 1e5)  # N/m, of springs of SliderOnBelt, SliderOnRigidBelt
WHEEL = 0.2  # radius of the belt's wheels in the picture of SliderOnBelt; the farther wheel is at 1
NEAREST_WHEEL = 0.25  # a wheel in that picture, even where its distance is zero
LEAST_DISTANCE = 1e-9  # m: both wheels are drawn near where both distances are zero


@model
class SliderOnBelt(MechanicalModel):
    """The 5-degree-of-freedom slider-on-belt system of Liu & Ouyang (2020), Eqs. (1) to (17).

    Every parameter is a keyword, those of the components too; defaults are those of Table 1, with mu_k = 0.3,
    mu_s = 3, k_nl = 1e4 N/m^3 and F = 200 N.  Models are frozen and compare by value.

    Parameters
    ----------
    M, m : float
        Masses of slider and belt, kg, above 0.
    J : float
        Rotational inertia of the belt, kg m^2, above 0.
    c1, c2, c4, c5, c6 : float
        Dampers of the slider (horizontal, vertical) and the belt (horizontal, two wheels), N s/m.
    k1, k3, k4, k5, k6 : float
        Springs of the slider (horizontal, at 45 degrees) and the belt (horizontal, two wheels), N/m.
    l1, l2 : float
        Distances of the wheels from the belt's mass centre, m.
    v : float
        Speed of the belt, m/s; where it is negative, the belt runs the other way.
    F : float
        Preload on the slider, N.
    contact : ContactLaw
        CubicContact(k2, k_nl), LinearContact(k2), HertzContact(k_h), PolynomialContact(a1, ...) or your own.
    friction : FrictionLaw
        Coulomb(mu_k, mu_s), ExponentialDecay, Stribeck, WeakeningStrengthening, PressureDependent or one
        of your own.
    interface : Interface
        StickSlipSeparation(), StickSlip(), SlidingSeparation() or SlidingOnly().
    geometry : Geometry
        MovingLoad(direction) or FixedLoad().
    impact : ImpactLaw
        PlasticImpact(penetration_rate), RestitutionImpact(e), FrictionalImpact(e, mu_i) or your own.

    Raises
    ------
    TypeError
        For an unknown name, or a value that is no number.
    ValueError
        For a value that breaks a rule.

    Examples
    --------
    >>> from frictionlab import SliderOnBelt
    >>> SliderOnBelt(mu_k=1.4).without("geometry")
    SliderOnBelt(mu_k=1.4, geometry=FixedLoad())
    """

    M: float = positive(1.0, "kg", "M", "mass of the slider")
    m: float = positive(1.0, "kg", "m", "mass of the belt")
    J: float = positive(0.1, "kg m^2", "J", "rotational inertia of the belt")
    c1: float = not_negative(0.1, 50.0, "N s/m", "c_1", "damping of the slider, horizontal")
    c2: float = not_negative(0.1, 50.0, "N s/m", "c_2", "damping of the slider, vertical")
    c4: float = not_negative(0.1, 50.0, "N s/m", "c_4", "damping of the belt, horizontal")
    c5: float = not_negative(0.1, 50.0, "N s/m", "c_5", "damping of the first wheel, vertical")
    c6: float = not_negative(0.1, 50.0, "N s/m", "c_6", "damping of the second wheel, vertical")
    k1: float = stiffness_parameter(1e4, "k_1", "stiffness of the slider, horizontal", BELT_RANGE)
    k3: float = stiffness_parameter(6e3, "k_3", "stiffness of the slider, at 45 degrees", BELT_RANGE)
    k4: float = stiffness_parameter(1e4, "k_4", "stiffness of the belt, horizontal", BELT_RANGE)
    k5: float = stiffness_parameter(1e4, "k_5", "stiffness of the first wheel, vertical", BELT_RANGE)
    k6: float = stiffness_parameter(1e4, "k_6", "stiffness of the second wheel, vertical", BELT_RANGE)
    l1: float = not_negative(0.2, 0.5, "m", "l_1", "distance of the first wheel from the belt's mass centre")
    l2: float = not_negative(0.2, 0.5, "m", "l_2", "distance of the second wheel from the belt's mass centre")
    v: float = of_either_sign(1.0, 3.0, "m/s", "v", "speed of the belt")
    F: float = parameter(200.0, unit="N", symbol="F", meaning="preload on the slider", range=(0.0, 1000.0))
    contact: ContactLaw = CubicContact()
    friction: FrictionLaw = Coulomb()
    interface: Interface = StickSlipSeparation()
    geometry: Geometry = MovingLoad()
    impact: ImpactLaw = PlasticImpact()

    reference = "N. Liu, H. Ouyang, Nonlinear Dynamics (2020)"
    statics = SlidingStatics(height="y1")
    period = 0.1  # s, of its fast modes

    if TYPE_CHECKING:

        def __init__(self, **given: Unpack[SliderOnBeltKeywords]) -> None: ...

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the coordinates: x1, y1 of the slider, x2, y2 and the angle phi of the belt."""
        return self.geometry.coordinates

    @property
    def mechanism(self) -> Mechanism:
        """Fig. 1 of the paper: the slider on its contact spring, on the belt that tilts about two wheels.

        Springs along x or y stay so, as Eq. (1) has it: their ends on walls move with the bodies.
        """
        slider, corner = Point(0.0, 0.95, right="x1", up="y1"), (-1.1, 2.0)
        far = functions.maximum(functions.maximum(self.l1, self.l2), LEAST_DISTANCE)
        x1, x2 = (
            -functions.maximum(self.l1 / far, NEAREST_WHEEL),
            functions.maximum(self.l2 / far, NEAREST_WHEEL),
        )
        left, right = self._wheel(x1), self._wheel(x2)
        belt = Belt("v", left, right, WHEEL)
        law = ", ".join(f"${about.symbol}$" for about in parameters_of(type(self.contact)).values())
        foot = Point(0.0, 0.0, right="x1", on=belt)
        springs = (
            Spring(slider.level_at(-1.6), slider.beside(-0.2), label="$k_1$"),
            Spring(Point(*corner), slider.beside(-0.2, 0.15), label="$k_3$"),
            Spring(right, right.level_at(2.1), label="$k_4$"),
            Spring(left.upright_at(-1.3), left, label="$k_5$"),
            Spring(right, right.upright_at(-1.3), label="$k_6$"),
            Spring(foot, slider.beside(0.0, -0.15), loose="separation", label=law),
        )
        walls = (
            Wall((-1.6, 0.4), (-1.6, 1.5)),
            Wall((2.1, -0.75), (2.1, 0.35)),
            Wall((-1.5, -1.3), (1.5, -1.3)),
            Wall((corner[0] - 0.12, corner[1] - 0.12), (corner[0] + 0.12, corner[1] + 0.12)),
        )
        load = Load(slider.beside(0.14, 0.15), "F")
        return Mechanism(*walls, belt, *springs, Block(slider, 0.4, 0.3), Forces(slider), load)

    def _wheel(self, x: Any) -> Point:
        """The centre of a wheel, which the tilt of the belt takes along."""
        if "phi" not in self.coordinates:
            return Point(x, -WHEEL, right="x2", up="y2")
        away, start = functions.sqrt(x**2 + WHEEL**2), functions.arctan(x / WHEEL) - pi / 2
        tilt = Turn("-phi", away, away, start, linear=True)
        return Point(0.0, 0.0, right="x2", up="y2", turn=tilt)

    def mechanics(self, q: Any, v: Any) -> Mechanics:
        """Two bodies; k3 lies at 45 degrees, k5 and k6 hold the belt at its two wheels."""
        contact = self._contact(q, v)
        q, v = _all(q), _all(v)
        slider = self.k1 * q.x1**2 + self.k3 * (q.x1 - q.y1) ** 2 / 2
        belt = self.k5 * (q.y2 + self.l1 * q.phi) ** 2 + self.k6 * (q.y2 - self.l2 * q.phi) ** 2
        dampers = self.c5 * (v.y2 + self.l1 * v.phi) ** 2 + self.c6 * (v.y2 - self.l2 * v.phi) ** 2
        moving = self.M * (v.x1**2 + v.y1**2) + self.m * (v.x2**2 + v.y2**2) + self.J * v.phi**2
        return Mechanics(
            kinetic=moving / 2,
            potential={"springs": (slider + self.k4 * q.x2**2 + belt) / 2, "preload": self.F * q.y1},
            dissipation=(self.c1 * v.x1**2 + self.c2 * v.y1**2 + self.c4 * v.x2**2 + dampers) / 2,
            contacts=(contact,),
        )

    def _contact(self, q: Any, v: Any) -> Friction:
        tangent = self.geometry.tangent(*q)
        return Friction(
            relative_velocity=self.v - sum(w * rate for w, rate in zip(tangent, v, strict=True)),
            normal_force=self.contact.force,
            law=self.friction,
            penetration=self.geometry.penetration(*q),
            normal=self.geometry.normal(*q),
            impact=self.impact,
        )


def _all(at: Any) -> SimpleNamespace:
    """All coordinates, or their rates; those that the geometry leaves out are zero."""
    return SimpleNamespace(**{name: getattr(at, name, 0) for name in MovingLoad.coordinates})


@model
class ModeCoupling(PlanarSlider):
    """A mass in the plane, held by two inclined springs, pressed on a belt by F through a contact spring k3.

    With y into the belt, F_N = k3 y and F_T along the belt,

        m x'' + c x' + k11 x + k12 y = F_T
        m y'' + c y' + k12 x + k22 y = F

    where k11 = k1 cos^2 a1 + k2 cos^2 a2, k12 = k1 sin a1 cos a1 + k2 sin a2 cos a2 and k22 = k1 sin^2 a1 +
    k2 sin^2 a2 + k3 contains the contact spring.  In slip, F_T = mu k3 y makes the stiffness matrix
    unsymmetric: without a damper the two modes coalesce, and flutter sets in, at

        mu_c = (k12^2 + ((k11 - k22)/2)^2)/(k12 k3),      omega_c^2 = (k11 + k22)/(2 m),

    although the coefficient of friction does not fall with speed.  The mass sticks while |F_T| <= mu_s F_N,
    and leaves the belt where y < 0.

    Parameters
    ----------
    m : float
        Mass, kg, above 0.
    c : float
        Damper along x and along y, N s/m.
    k1, k2, k3 : float
        Inclined springs, contact spring, N/m.
    a1, a2 : float
        Angles of the inclined springs with the belt, rad.
    F : float
        Preload, N.
    v : float
        Speed of the belt, m/s.
    friction : FrictionLaw

    References
    ----------
    N. Hoffmann, M. Fischer, R. Allgaier, L. Gaul, Mechanics Research Communications 29 (2002) 197-205.

    Examples
    --------
    >>> import frictionlab as fl
    >>> model = fl.ModeCoupling(c=0.0)
    >>> critical = fl.critical_value(model, "mu_k", bounds=(0, 2))
    >>> abs(critical - model.critical_friction) < 1e-9
    True
    """

    m: float = positive(1.0, "kg", "m", "mass")
    c: float = not_negative(0.1, 2.0, "N s/m", "c", "damping")
    k1: float = stiffness_parameter(1.0, "k_1", "stiffness of the first inclined spring")
    k2: float = stiffness_parameter(0.5, "k_2", "stiffness of the second inclined spring")
    k3: float = stiffness_parameter(4 / 3, "k_3", "stiffness of the contact spring")
    a1: float = of_either_sign(pi / 6, pi, "rad", r"\alpha_1", "angle of the first spring")
    a2: float = of_either_sign(5 * pi / 6, pi, "rad", r"\alpha_2", "angle of the second spring")
    F: float = not_negative(1.0, 10.0, "N", "F", "preload")
    v: float = of_either_sign(1.0, 3.0, "m/s", "v", "speed of the belt")
    friction: FrictionLaw = Coulomb(mu_k=0.5, mu_s=1.0)

    reference = "N. Hoffmann et al., Mechanics Research Communications 29 (2002) 197-205"

    if TYPE_CHECKING:

        def __init__(self, **given: Unpack[ModeCouplingKeywords]) -> None: ...

    @property
    def period(self) -> float:
        """That of the mass on its contact spring, s."""
        return natural_period(self.k3, self.m)

    @property
    def stiffnesses(self) -> tuple[float, float, float]:
        """k11, k12 and k22, N/m."""
        (c1, s1), (c2, s2) = ((functions.cos(a), functions.sin(a)) for a in (self.a1, self.a2))
        along = self.k1 * c1**2 + self.k2 * c2**2
        across = self.k1 * s1**2 + self.k2 * s2**2
        return float(along), float(self.k1 * s1 * c1 + self.k2 * s2 * c2), float(across + self.k3)

    @property
    def critical_friction(self) -> float:
        """mu_c, at which undamped modes coalesce."""
        k11, k12, k22 = self.stiffnesses
        return (k12**2 + ((k11 - k22) / 2) ** 2) / (k12 * self.k3)

    @property
    def critical_frequency(self) -> float:
        """omega_c at mu_c, rad/s."""
        k11, _, k22 = self.stiffnesses
        return ((k11 + k22) / (2 * self.m)) ** 0.5

    @property
    def mechanism(self) -> Mechanism:
        """A body on its contact spring on a belt, and both inclined springs."""
        return body_on_belt(*(inclined_end(a) for a in (self.a1, self.a2)))

    def springs(self, q: Any) -> Any:
        """Energy of both inclined springs, J."""
        return inclined_spring_energy(self.k1, self.a1, q) + inclined_spring_energy(self.k2, self.a2, q)

    def normal_force(self, penetration: Any) -> Any:
        """F_N of the contact spring, N."""
        return self.k3 * penetration


@model
class SliderOnRigidBelt(PlanarSlider):
    """A mass in the plane, pressed by F on a rigid belt through a nonlinear contact that may be lost.

    A spring k1 along the belt and a spring k3 at the angle a hold it.  With y into the belt, F_N = F_N(y):

        m x'' + c x' + k11 x + k12 y = F_T,           k11 = k1 + k3 cos^2 a,   k12 = k3 sin a cos a,
        m y'' + c y' + k12 x + k22 y + F_N(y) = F,    k22 = k3 sin^2 a

    In slip, F_T = mu F_N.  About its equilibrium the contact has the stiffness k_c = dF_N/dy, which grows
    with the preload where the contact hardens.  Without dampers flutter sets in and ends where

        k_c^2 - 2 (k11 - k22 + 2 mu k12) k_c + (k11 - k22)^2 + 4 k12^2 = 0:

    a stable slider becomes unstable as it is pressed harder, and then stable again.  As the vibration grows,
    the slider leaves the belt (y < 0) and comes back to it.

    The model is of the kind studied by Li, Ouyang and Guan; the layout of the springs and the numbers are
    this package's.

    Parameters
    ----------
    m : float
        Mass, kg, above 0.
    c : float
        Damper along x and along y, N s/m.
    k1, k3 : float
        Spring along the belt and inclined spring, N/m.
    a : float
        Angle of the inclined spring with the belt, rad.
    F : float
        Preload, N.
    v : float
        Speed of the belt, m/s.
    contact : ContactLaw
    friction : FrictionLaw

    References
    ----------
    Z. Li, H. Ouyang, Z. Guan, Journal of Vibration and Acoustics 138 (2016) 041006.

    Examples
    --------
    Stable when pressed softly, unstable at the default preload, stable when pressed hard:

    >>> import frictionlab as fl
    >>> [fl.eigenvalues(fl.SliderOnRigidBelt(F=F)).stable for F in (20.0, 100.0, 300.0)]
    [True, False, True]
    """

    m: float = positive(1.0, "kg", "m", "mass")
    c: float = not_negative(2.0, 20.0, "N s/m", "c", "damping")
    k1: float = stiffness_parameter(1e4, "k_1", "stiffness of the spring along the belt", RIGID_BELT_RANGE)
    k3: float = stiffness_parameter(6e3, "k_3", "stiffness of the inclined spring", RIGID_BELT_RANGE)
    a: float = of_either_sign(pi / 4, pi, "rad", r"\alpha", "angle of the inclined spring")
    F: float = not_negative(100.0, 500.0, "N", "F", "preload")
    v: float = of_either_sign(1.0, 3.0, "m/s", "v", "speed of the belt")
    contact: ContactLaw = CubicContact(k2=5e3, k_nl=2.5e7)
    friction: FrictionLaw = Coulomb(mu_k=0.5, mu_s=0.7)

    reference = "Z. Li, H. Ouyang, Z. Guan, J. Vibration and Acoustics 138 (2016) 041006"

    if TYPE_CHECKING:

        def __init__(self, **given: Unpack[SliderOnRigidBeltKeywords]) -> None: ...

    @property
    def period(self) -> float:
        """That of the mass on its spring along the belt, s."""
        return natural_period(self.k1, self.m)

    @property
    def mechanism(self) -> Mechanism:
        """A body on its contact spring on a belt, and two springs."""
        return body_on_belt(inclined_end(0.0), inclined_end(self.a))

    def springs(self, q: Any) -> Any:
        """Energy of both springs, J."""
        return self.k1 * q.x**2 / 2 + inclined_spring_energy(self.k3, self.a, q)

    def normal_force(self, penetration: Any) -> Any:
        """F_N of the contact law, N."""
        return self.contact.force(penetration)
