"""Contact laws that are powers of the gap: Hertz's, and polynomials."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from .contact import ContactLaw
from .parameter import parameter


@dataclass(frozen=True, repr=False)
class HertzContact(ContactLaw):
    """Two elastic bodies that touch in a point: F_N = k_h gap^(3/2).

    The bodies must be able to separate, as the law has no value for a negative gap.

    Parameters
    ----------
    k_h : float
        Stiffness, N/m^1.5, at least 0; for two spheres 4/3 sqrt(R) E*, with the effective radius and modulus.

    References
    ----------
    K. L. Johnson, Contact Mechanics, Cambridge University Press 1985, chapter 4.
    """

    k_h: float = parameter(
        2.5e4,
        unit="N/m^1.5",
        symbol=r"k_{\mathrm{H}}",
        meaning="Hertz contact stiffness",
        minimum=0.0,
        range=(1e3, 1e7),
        log=True,
    )

    def force(self, gap: Any) -> Any:
        """Normal force (N)."""
        return self.k_h * gap**1.5


def _coefficient(n: int, default: float = 0.0) -> Any:
    return parameter(
        default,
        unit="N/m" if n == 1 else f"N/m^{n}",
        symbol=f"a_{n}",
        meaning=f"contact stiffness of order {n}",
        range=(0.0, 10.0 ** (n + 3)),
    )


@dataclass(frozen=True, repr=False)
class PolynomialContact(ContactLaw):
    """Spring with a polynomial of degree five: F_N = a1 gap + a2 gap^2 + ... + a5 gap^5.

    Parameters
    ----------
    a1, a2, a3, a4, a5 : float
        Coefficients, N/m^n.
    """

    a1: float = _coefficient(1, 5e3)
    a2: float = _coefficient(2)
    a3: float = _coefficient(3)
    a4: float = _coefficient(4)
    a5: float = _coefficient(5)

    def force(self, gap: Any) -> Any:
        """Normal force (N), by Horner's rule."""
        total = 0
        for a in (self.a5, self.a4, self.a3, self.a2, self.a1):
            total = (total + a) * gap
        return total
