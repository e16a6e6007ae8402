"""The paper's model: a slider on an elastically held belt, with friction, impacts and a moving load."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType, SimpleNamespace
from typing import TYPE_CHECKING, Any, ClassVar, Unpack

from frictionlab.components.component import parameter
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
from frictionlab.models.mechanical.mechanical_model import MechanicalModel
from frictionlab.models.mechanical.mechanics import Friction, Mechanics, SlidingStatics
from frictionlab.models.mechanism import TiltingBelt
from frictionlab.models.model import with_signature

if TYPE_CHECKING:
    from .parameters import SliderOnBeltKeywords


def _mass(
    default: float, symbol: str, meaning: str, unit: str = "kg", slider: tuple[float, float] = (0.1, 10.0)
) -> Any:
    return parameter(
        default, unit=unit, symbol=symbol, meaning=meaning, exclusive_minimum=0.0, range=slider, log=True
    )


def _spring(default: float, number: int, meaning: str) -> Any:
    return parameter(
        default,
        unit="N/m",
        symbol=f"k_{number}",
        meaning=f"stiffness of {meaning}",
        minimum=0.0,
        range=(1e3, 1e6),
        log=True,
    )


def _damper(number: int, meaning: str) -> Any:
    return parameter(
        0.1,
        unit="N s/m",
        symbol=f"c_{number}",
        meaning=f"damping of {meaning}",
        minimum=0.0,
        range=(0.0, 50.0),
    )


def _length(number: int, wheel: str) -> Any:
    return parameter(
        0.2,
        unit="m",
        symbol=f"l_{number}",
        meaning=f"distance of the {wheel} wheel from the belt's mass centre",
        minimum=0.0,
        range=(0.0, 0.5),
    )


@with_signature
@dataclass(frozen=True, init=False, repr=False)
class SliderOnBelt(MechanicalModel):
    """The 5-degree-of-freedom slider-on-belt system of Liu & Ouyang (2020), Eqs. (1) to (17).

    Every parameter is a keyword, those of the components too; defaults are Table 1 with mu_k = 0.3,
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
        Speed of the belt, m/s; negative runs the other way.
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

    M: float = _mass(1.0, "M", "mass of the slider")
    m: float = _mass(1.0, "m", "mass of the belt")
    J: float = _mass(0.1, "J", "rotational inertia of the belt", "kg m^2", (0.01, 1.0))
    c1: float = _damper(1, "the slider, horizontal")
    c2: float = _damper(2, "the slider, vertical")
    c4: float = _damper(4, "the belt, horizontal")
    c5: float = _damper(5, "the first wheel, vertical")
    c6: float = _damper(6, "the second wheel, vertical")
    k1: float = _spring(1e4, 1, "the slider, horizontal")
    k3: float = _spring(6e3, 3, "the slider, at 45 degrees")
    k4: float = _spring(1e4, 4, "the belt, horizontal")
    k5: float = _spring(1e4, 5, "the first wheel, vertical")
    k6: float = _spring(1e4, 6, "the second wheel, vertical")
    l1: float = _length(1, "first")
    l2: float = _length(2, "second")
    v: float = parameter(1.0, unit="m/s", symbol="v", meaning="speed of the belt", range=(-3.0, 3.0))
    F: float = parameter(200.0, unit="N", symbol="F", meaning="preload on the slider", range=(0.0, 1000.0))
    contact: ContactLaw = CubicContact()
    friction: FrictionLaw = Coulomb()
    interface: Interface = StickSlipSeparation()
    geometry: Geometry = MovingLoad()
    impact: ImpactLaw = PlasticImpact()

    reference: ClassVar[str] = "N. Liu, H. Ouyang, Nonlinear Dynamics (2020)"
    roles: ClassVar[Mapping[str, type]] = MappingProxyType(
        {
            "contact": ContactLaw,
            "friction": FrictionLaw,
            "interface": Interface,
            "geometry": Geometry,
            "impact": ImpactLaw,
        }
    )

    statics: ClassVar[SlidingStatics] = SlidingStatics(height="y1")

    if TYPE_CHECKING:

        def __init__(self, **given: Unpack[SliderOnBeltKeywords]) -> None: ...

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the coordinates: x1, y1 of the slider, x2, y2 and the angle phi of the belt."""
        return self.geometry.coordinates

    @property
    def mechanism(self) -> TiltingBelt:
        """Fig. 1 of the paper."""
        return TiltingBelt()

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
        at, rates = ([getattr(x, name) for name in self.coordinates] for x in (q, v))
        tangent = self.geometry.tangent(*at)
        return Friction(
            relative_velocity=self.v - sum(w * rate for w, rate in zip(tangent, rates, strict=True)),
            normal_force=self.contact.force,
            law=self.friction,
            penetration=self.geometry.penetration(*at),
            normal=self.geometry.normal(*at),
            impact=self.impact,
        )


def _all(at: Any) -> SimpleNamespace:
    """All coordinates, or their rates; those that the geometry leaves out are zero."""
    return SimpleNamespace(**{name: getattr(at, name, 0) for name in MovingLoad.coordinates})
