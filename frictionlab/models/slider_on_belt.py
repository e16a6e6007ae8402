"""The paper's model: a slider on an elastically held belt, with friction, impacts and a moving load."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Self

from frictionlab.components.contact import ContactLaw, CubicContact
from frictionlab.components.friction import Coulomb, FrictionLaw
from frictionlab.components.geometry import Geometry, MovingLoad
from frictionlab.components.impact import ImpactLaw, PlasticImpact
from frictionlab.components.interface import Interface, StickSlipSeparation
from frictionlab.components.parameter import parameter

from .model import Model, with_signature
from .toggles import replacements

if TYPE_CHECKING:
    from frictionlab.automaton import HybridAutomaton

    from .equations import Equations


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
class SliderOnBelt(Model):
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
        PlasticImpact(gap_rate), RestitutionImpact(e), FrictionalImpact(e, mu_i) or your own.

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

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the coordinates: x1, y1 of the slider, x2, y2 and the angle phi of the belt."""
        return self.geometry.coordinates

    def derive(self) -> HybridAutomaton:
        """The modes of the interface, and the limit of impacts that throw off."""
        from .assembly import slider_automaton

        return slider_automaton(self)

    def equations(self, mode: str) -> Equations:
        """The equations of a mode (or of the "impact") as the paper writes them; LaTeX in a notebook.

        Raises
        ------
        ValueError
            If the model has no such mode.
        """
        from .equations import equations

        return equations(self, mode)

    def without(self, *names: str) -> Self:
        """The model without nonlinearities of the paper.

        Parameters
        ----------
        *names : {"cubic", "nonsmooth", "geometry"}
            LinearContact with the same k2, SlidingOnly, FixedLoad take the components' places.

        Raises
        ------
        ValueError
            For another name.
        """
        return self.replace(**replacements(self, names))
