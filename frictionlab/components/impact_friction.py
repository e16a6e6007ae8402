"""Impact laws with friction in the impact itself."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from .impact import ImpactLaw, PlasticImpact, RestitutionImpact
from .parameter import parameter


def _friction() -> Any:
    return parameter(
        0.3,
        symbol=r"\mu_{\mathrm{i}}",
        meaning="coefficient of friction of impacts",
        minimum=0.0,
        range=(0.0, 1.0),
    )


def within_cone(stopping: Any, limit: Any) -> Any:
    """The stopping impulse, or what of it does not exceed the limit."""
    return (abs(stopping + limit) - abs(stopping - limit)) / 2


@dataclass(frozen=True, repr=False)
class FrictionalImpact(RestitutionImpact):
    """Newton's impact law with Coulomb's friction between the impulses: |p_T| <= mu_i p_N.

    The tangential impulse stops the sliding where the cone allows it, and opposes it otherwise.  The normal
    impulse is that for the velocities after the tangential one; the cone is that of the impulse without
    it, which is the same but for a share of the belt's angle, by which the two are coupled.

    Parameters
    ----------
    e : float
        Coefficient of restitution, 0 (plastic) to 1 (elastic).
    mu_i : float
        Coefficient of friction of the impulses, at least 0.

    References
    ----------
    C. Glocker, Set-Valued Force Laws: Dynamics of Non-Smooth Systems, Springer 2001.
    """

    mu_i: float = _friction()

    def reduced(self) -> ImpactLaw:
        """Without friction the law without; at e = 0 the gap rate afterwards is zero by construction."""
        if self.mu_i == 0:
            return super().reduced()
        return _PlasticFriction(mu_i=self.mu_i) if self.e == 0 else self

    def friction(self, impulse: Any, stopping: Any) -> Any:
        """Tangential impulse (N s): the stopping one, of mu_i times the normal impulse at most."""
        return within_cone(stopping, self.mu_i * impulse)


@dataclass(frozen=True, repr=False)
class _PlasticFriction(PlasticImpact):
    gap_rate: str = "full"
    mu_i: float = _friction()

    def friction(self, impulse: Any, stopping: Any) -> Any:
        return within_cone(stopping, self.mu_i * impulse)
