"""The mass on a belt: stick-slip in its simplest form, with any friction law."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Unpack

from frictionlab.components.friction import Coulomb, FrictionLaw
from frictionlab.models.mechanical.mechanical_model import SingleMass
from frictionlab.models.mechanical.mechanics import Friction, Mechanics
from frictionlab.models.mechanism import Belt, Mechanism, held_block
from frictionlab.models.model import with_signature

from .parameters import (
    damper_parameter,
    mass_parameter,
    natural_period,
    normal_force_parameter,
    speed_parameter,
    stiffness_parameter,
)

if TYPE_CHECKING:
    from .parameters import MassOnBeltKeywords


@with_signature
@dataclass(frozen=True, init=False, repr=False)
class MassOnBelt(SingleMass):
    """A mass on a spring and a damper, rubbed by a belt that runs: m x'' + c x' + k x = F_T.

    It slides with v_r = v - x' and F_T = sgn(v_r) mu(|v_r|) N, and sticks while |F_T| = |k x + c v| is at
    most mu_s N.

    * **Coulomb's law, no damper**: with a = (mu_s - mu_k) N/k and w = sqrt(k/m) the mass sticks for
      2 a/v and slips for (2 pi - 2 atan(a w/v))/w.  By default that is a period of 8.902605407815 s.
      Inside that cycle lie the oscillations without stick, all of the period 2 pi/w.
    * **Friction that depends on speed**: the slope of its curve acts as a damper.  Steady sliding loses its
      stability where c + N mu'(v) = 0, at the frequency w.  With m x'' + ... = G(x') near it, the Hopf point
      is subcritical where -N mu'''(v) > 0: an exponential that decays is so at every speed, and stick-slip
      exists beside stable sliding.
    * **Weakening and strengthening**, mu = mu_k + (mu_s - mu_k) exp(-|v_r|/v_s) + mu_v |v_r|/v_s: the point
      is at v = v_s log((mu_s - mu_k)/(mu_v + c v_s/N)).

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

    m: float = mass_parameter()
    c: float = damper_parameter()
    k: float = stiffness_parameter()
    N: float = normal_force_parameter()
    v: float = speed_parameter(0.2)
    friction: FrictionLaw = Coulomb(mu_k=0.5, mu_s=1.0)

    roles: ClassVar[Mapping[str, type]] = MappingProxyType({"friction": FrictionLaw})
    reference: ClassVar[str] = "K. Popp, P. Stelter, Phil. Trans. R. Soc. A 332 (1990) 89-105"

    if TYPE_CHECKING:

        def __init__(self, **given: Unpack[MassOnBeltKeywords]) -> None: ...

    @property
    def period(self) -> float:
        """That of the mass on its spring, s."""
        return natural_period(self.k, self.m)

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
