"""Two blocks on one belt: two contacts that stick and slip by turns."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Unpack

from frictionlab.components.friction import Coulomb, FrictionLaw
from frictionlab.models.mechanical.mechanical_model import MechanicalModel
from frictionlab.models.mechanical.mechanics import Friction, Mechanics
from frictionlab.models.mechanism import Belt, Mechanism, Place, Spring, held_block
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
    from .parameters import TwoBlocksKeywords


@with_signature
@dataclass(frozen=True, init=False, repr=False)
class TwoBlocks(MechanicalModel):
    """Two blocks on a belt, each on a spring of its own and a spring between them.

        m1 x1'' + c x1' + k1 x1 + k12 (x1 - x2) = F_T1
        m2 x2'' + c x2' + k2 x2 + k12 (x2 - x1) = F_T2

    Each sticks or slips by the same law under a normal force of its own.  A mode names what both do, as in
    "stick | slip+"; there are nine, each derived when a run first tries to enter it.  Blocks that are alike
    and start alike move as one: as :class:`MassOnBelt`, with the period 8.902605407815 s by default.  Sliding
    they have the frequencies sqrt(k/m) and sqrt((k + 2 k12)/m).

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

    m1: float = mass_parameter(1.0, "m_1", "mass of the first block")
    m2: float = mass_parameter(1.0, "m_2", "mass of the second block")
    c: float = damper_parameter(0.0, "c", "damping of each block")
    k1: float = stiffness_parameter(1.0, "k_1", "stiffness of the first block's spring")
    k2: float = stiffness_parameter(1.0, "k_2", "stiffness of the second block's spring")
    k12: float = stiffness_parameter(1.2, "k_{12}", "stiffness between the blocks")
    N1: float = normal_force_parameter(1.0, "N_1", "normal force on the first block")
    N2: float = normal_force_parameter(1.0, "N_2", "normal force on the second block")
    v: float = speed_parameter(0.2)
    friction: FrictionLaw = Coulomb(mu_k=0.5, mu_s=1.0)

    roles: ClassVar[Mapping[str, type]] = MappingProxyType({"friction": FrictionLaw})
    reference: ClassVar[str] = "U. Galvanetto, S. R. Bishop, Int. J. Mechanical Sciences 36 (1994)"

    if TYPE_CHECKING:

        def __init__(self, **given: Unpack[TwoBlocksKeywords]) -> None: ...

    @property
    def coordinates(self) -> tuple[str, ...]:
        """The displacements x1 and x2, from where the springs are slack."""
        return ("x1", "x2")

    @property
    def period(self) -> float:
        """That of the first block on its own spring, s."""
        return natural_period(self.k1, self.m1)

    @property
    def mechanism(self) -> Mechanism:
        """Two blocks on one belt, each held by a spring, and a spring between them."""
        one = held_block("x1", wall=-2.4, place=-0.9, number="_1")
        two = held_block("x2", wall=2.4, place=0.9, number="_2")
        between = Spring(Place(-0.6, 0.2, right="x1"), Place(0.6, 0.2, right="x2"))
        return Mechanism(Belt("v", start=-2.0, end=2.0), *one, *two, between)

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
