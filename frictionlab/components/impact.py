"""Impact laws: the impulse between slider and belt when they meet again.

An impulse p along W_N changes the velocities by M dv = W_N p, Eqs. (10) to (12).  So it changes the
gap rate by -compliance * p, where compliance = W_N^T M^-1 W_N = 1/M + 1/m + (x1 - x2)^2/J.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from .component import Component
from .names import did_you_mean
from .parameter import parameter

GAP_RATES = ("material", "full")


@dataclass(frozen=True, repr=False)
class ImpactLaw(Component):
    """Base of the impact laws: a subclass gives :meth:`impulse`."""

    def impulse(self, material_rate: Any, gap_rate: Any, compliance: Any) -> Any:
        """Impulse (N s) of the re-contact.

        Parameters
        ----------
        material_rate : float
            Velocity (m/s) at which the slider approaches the belt's material point, -W_N^T v.
        gap_rate : float
            Time derivative of the gap (m/s); it has the slider's travel along the tilted belt as well.
        compliance : float
            W_N^T M^-1 W_N, 1/kg.
        """
        raise NotImplementedError(f"{type(self).__name__} must define impulse(...)")

    def friction(self, impulse: Any, stopping: Any) -> Any:
        """Tangential impulse (N s) along the relative velocity; none in the paper.

        Parameters
        ----------
        impulse : float
            Normal impulse of the re-contact, N s.
        stopping : float
            Tangential impulse that would bring the relative velocity to zero, N s; it has that one's sign.
        """
        return 0


@dataclass(frozen=True, repr=False)
class PlasticImpact(ImpactLaw):
    """Perfectly plastic impact, Eqs. (13) and (14).

    Parameters
    ----------
    gap_rate : {"material", "full"}
        What the impact brings to zero: the velocity relative to the belt's material point, as the
        paper's Eq. (13) has it, or the full rate of the gap.
    """

    gap_rate: str = "material"

    def check(self) -> None:
        """The gap rate is one of two."""
        if self.gap_rate not in GAP_RATES:
            hint = did_you_mean(self.gap_rate, GAP_RATES)
            raise ValueError(f"gap_rate must be 'material' or 'full', got {self.gap_rate!r}: {hint}")

    def impulse(self, material_rate: Any, gap_rate: Any, compliance: Any) -> Any:
        """Impulse (N s), Eq. (14), with the chosen rate in its numerator."""
        rates = {"material": material_rate, "full": gap_rate}
        return rates[self.gap_rate] / compliance


@dataclass(frozen=True, repr=False)
class RestitutionImpact(ImpactLaw):
    """Newton's impact law on the full gap rate: after = -e * before.

    Parameters
    ----------
    e : float
        Coefficient of restitution, 0 (plastic) to 1 (elastic).
    """

    e: float = parameter(
        0.5, symbol="e", meaning="coefficient of restitution", minimum=0.0, maximum=1.0, range=(0.0, 1.0)
    )

    def reduced(self) -> ImpactLaw:
        """At e = 0 the gap rate after the impact is zero by construction, not by rounding."""
        return PlasticImpact("full") if self.e == 0 else self

    def impulse(self, material_rate: Any, gap_rate: Any, compliance: Any) -> Any:
        """Impulse (N s): (1 + e) gap_rate / compliance."""
        return (1 + self.e) * gap_rate / compliance
