"""A slider on a rigid belt with any contact law: mode coupling caused by the preload, and separation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import pi
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Unpack

from frictionlab.components.component import parameter
from frictionlab.components.contact import ContactLaw, CubicContact
from frictionlab.components.friction import Coulomb, FrictionLaw
from frictionlab.models.mechanical.mechanical_model import PlanarSlider, inclined_spring_energy
from frictionlab.models.mechanism import Mechanism, body_on_belt, inclined_end
from frictionlab.models.model import with_signature

from .parameters import (
    angle_parameter,
    damper_parameter,
    mass_parameter,
    natural_period,
    speed_parameter,
    stiffness_parameter,
)

if TYPE_CHECKING:
    from .parameters import SliderOnRigidBeltKeywords


SOFT_TO_STIFF = (1e3, 1e5)


@with_signature
@dataclass(frozen=True, init=False, repr=False)
class SliderOnRigidBelt(PlanarSlider):
    """A mass in the plane, pressed by F on a rigid belt through a nonlinear contact that may be lost.

    A spring k1 along the belt and a spring k3 at the angle a hold it.  With y into the belt, F_N = F_N(y):

        m x'' + c x' + k11 x + k12 y = F_T,           k11 = k1 + k3 cos^2 a,   k12 = k3 sin a cos a,
        m y'' + c y' + k12 x + k22 y + F_N(y) = F,    k22 = k3 sin^2 a

    Sliding, F_T = mu F_N.  About its equilibrium the contact has the stiffness k_c = dF_N/dy, which grows
    with the preload where the contact hardens, and without dampers flutter sets in and ends where

        k_c^2 - 2 (k11 - k22 + 2 mu k12) k_c + (k11 - k22)^2 + 4 k12^2 = 0:

    a stable slider gets unstable as it is pressed harder, and then stable again.  What grows leaves the belt
    (y < 0) and comes back to it.

    The kind of model is that of Li, Ouyang and Guan; the layout of the springs and the numbers are this
    package's.

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
    Stable when pressed softly, unstable at the preload by default, stable when pressed hard:

    >>> import frictionlab as fl
    >>> [fl.eigenvalues(fl.SliderOnRigidBelt(F=F)).stable for F in (20.0, 100.0, 300.0)]
    [True, False, True]
    """

    m: float = mass_parameter()
    c: float = damper_parameter(2.0, range=(0.0, 20.0))
    k1: float = stiffness_parameter(1e4, "k_1", "stiffness of the spring along the belt", range=SOFT_TO_STIFF)
    k3: float = stiffness_parameter(6e3, "k_3", "stiffness of the inclined spring", range=SOFT_TO_STIFF)
    a: float = angle_parameter(pi / 4, r"\alpha", "angle of the inclined spring")
    F: float = parameter(100.0, unit="N", symbol="F", meaning="preload", minimum=0.0, range=(0.0, 500.0))
    v: float = speed_parameter(1.0)
    contact: ContactLaw = CubicContact(k2=5e3, k_nl=2.5e7)
    friction: FrictionLaw = Coulomb(mu_k=0.5, mu_s=0.7)

    roles: ClassVar[Mapping[str, type]] = MappingProxyType({"contact": ContactLaw, "friction": FrictionLaw})
    reference: ClassVar[str] = "Z. Li, H. Ouyang, Z. Guan, J. Vibration and Acoustics 138 (2016) 041006"

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
