"""Den Hartog's oscillator: dry friction and a harmonic force."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import pi
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Unpack

from frictionlab.components import functions
from frictionlab.components.friction import Coulomb, FrictionLaw
from frictionlab.models.mechanical.mechanical_model import SingleMass
from frictionlab.models.mechanical.mechanics import Friction, Mechanics
from frictionlab.models.mechanism import Mechanism, Wall, held_block
from frictionlab.models.model import with_signature

from .parameters import (
    damper_parameter,
    frequency_parameter,
    load_parameter,
    mass_parameter,
    normal_force_parameter,
    stiffness_parameter,
)

if TYPE_CHECKING:
    from .parameters import DenHartogKeywords


@with_signature
@dataclass(frozen=True, init=False, repr=False)
class DenHartog(SingleMass):
    """A mass on a spring that rubs on the ground, driven: m x'' + c x' + k x = F cos(Omega t) + F_T.

    F_T = -mu N sgn(x').  Its state has the phase Omega t (rad) beside x and x'; the phase goes from 0 to
    2 pi and begins anew.  Without a damper the motion with two turns a period has, for r = Omega sqrt(m/k)
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

    m: float = mass_parameter()
    c: float = damper_parameter()
    k: float = stiffness_parameter()
    N: float = normal_force_parameter(0.3)
    F: float = load_parameter()
    Omega: float = frequency_parameter(0.8)
    friction: FrictionLaw = Coulomb(mu_k=1.0, mu_s=1.0)

    roles: ClassVar[Mapping[str, type]] = MappingProxyType({"friction": FrictionLaw})
    reference: ClassVar[str] = "J. P. Den Hartog, Philosophical Magazine 9 (1930) 801-817"

    if TYPE_CHECKING:

        def __init__(self, **given: Unpack[DenHartogKeywords]) -> None: ...

    @property
    def period(self) -> float:
        """That of the force, s."""
        return 2 * pi / self.Omega

    @property
    def mechanism(self) -> Mechanism:
        """A block on the ground, on a spring."""
        return Mechanism(Wall((-1.2, 0.0), (1.2, 0.0)), *held_block("x"))

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
