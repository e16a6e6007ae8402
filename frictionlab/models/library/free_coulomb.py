"""A free oscillator with dry friction."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Unpack

from frictionlab.components.component import parameter
from frictionlab.components.friction import Coulomb, FrictionLaw
from frictionlab.models.mechanical.mechanical_model import SingleMass
from frictionlab.models.mechanical.mechanics import Friction, Mechanics
from frictionlab.models.mechanism import Mechanism, Wall, held_block
from frictionlab.models.model import with_signature

from .parameters import mass_parameter, natural_period, normal_force_parameter, stiffness_parameter

if TYPE_CHECKING:
    from .parameters import FreeCoulombKeywords


@with_signature
@dataclass(frozen=True, init=False, repr=False)
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

    m: float = mass_parameter()
    k: float = stiffness_parameter()
    N: float = normal_force_parameter()
    x_0: float = parameter(10.3, unit="m", symbol="x_0", meaning="where it is released", range=(-20.0, 20.0))
    friction: FrictionLaw = Coulomb(mu_k=1.0, mu_s=1.0)

    roles: ClassVar[Mapping[str, type]] = MappingProxyType({"friction": FrictionLaw})
    reference: ClassVar[str] = "J. P. Den Hartog, Mechanical Vibrations, 4th ed., McGraw-Hill 1956"

    if TYPE_CHECKING:

        def __init__(self, **given: Unpack[FreeCoulombKeywords]) -> None: ...

    @property
    def period(self) -> float:
        """That of the mass on its spring, s."""
        return natural_period(self.k, self.m)

    def release(self) -> Mapping[str, float]:
        """At x_0."""
        return {"x": self.x_0}

    @property
    def mechanism(self) -> Mechanism:
        """A block on the ground, on a spring."""
        return Mechanism(Wall((-1.2, 0.0), (1.2, 0.0)), *held_block("x"))

    def mechanics(self, q: Any, v: Any) -> Mechanics:
        """One mass, one contact with the ground."""
        return Mechanics(
            kinetic=self.m * v.x**2 / 2,
            potential=self.k * q.x**2 / 2,
            contacts=(Friction(-v.x, self.N, self.friction),),
        )
