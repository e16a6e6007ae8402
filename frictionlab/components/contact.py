"""Contact laws: the normal force of the contact spring from its compression, the gap."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from .component import Component
from .parameter import parameter


def _stiffness() -> Any:
    return parameter(
        5e3,
        unit="N/m",
        symbol="k_2",
        meaning="linear contact stiffness",
        minimum=0.0,
        range=(1e3, 1e5),
        log=True,
    )


@dataclass(frozen=True, repr=False)
class ContactLaw(Component):
    """Base of the contact laws: a subclass gives :meth:`force`."""

    def force(self, gap: Any) -> Any:
        """Normal force (N) at a compression `gap` (m), positive where the bodies press on each other."""
        raise NotImplementedError(f"{type(self).__name__} must define force(gap)")


@dataclass(frozen=True, repr=False)
class CubicContact(ContactLaw):
    """Linear and cubic spring, Eq. (2): F_N = k2 gap + k_nl gap^3.

    Parameters
    ----------
    k2 : float
        Linear stiffness, N/m, at least 0.
    k_nl : float
        Cubic stiffness, N/m^3, at least 0.
    """

    k2: float = _stiffness()
    k_nl: float = parameter(
        1e4,
        unit="N/m^3",
        symbol=r"k_{\mathrm{nl}}",
        meaning="cubic contact stiffness",
        minimum=0.0,
        range=(1e2, 1e8),
        log=True,
    )

    def force(self, gap: Any) -> Any:
        """Normal force (N), Eq. (2)."""
        return self.k2 * gap + self.k_nl * gap**3


@dataclass(frozen=True, repr=False)
class LinearContact(ContactLaw):
    """Linear spring, Eq. (2) without its cubic term: F_N = k2 gap.

    Parameters
    ----------
    k2 : float
        Linear stiffness, N/m, at least 0.
    """

    k2: float = _stiffness()

    def force(self, gap: Any) -> Any:
        """Normal force (N)."""
        return self.k2 * gap
