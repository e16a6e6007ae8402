"""Friction laws: the friction force while sliding, and its limit while sticking."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from .component import Component
from .parameter import parameter


@dataclass(frozen=True, repr=False)
class FrictionLaw(Component):
    """Base of the friction laws: a subclass gives :meth:`kinetic` and :meth:`static_limit`."""

    def kinetic(self, normal_force: Any, speed: Any) -> Any:
        """Friction force (N) along the relative velocity, whose magnitude is `speed` (m/s)."""
        raise NotImplementedError(f"{type(self).__name__} must define kinetic(normal_force, speed)")

    def static_limit(self, normal_force: Any) -> Any:
        """Largest friction force (N) that sticking can bear."""
        raise NotImplementedError(f"{type(self).__name__} must define static_limit(normal_force)")


@dataclass(frozen=True, repr=False)
class Coulomb(FrictionLaw):
    """Coulomb's law, Eqs. (3) and (8): |F_T| = mu_k F_N sliding, |F_T| <= mu_s F_N sticking.

    Parameters
    ----------
    mu_k : float
        Coefficient of kinetic friction, at least 0.
    mu_s : float
        Coefficient of static friction, at least `mu_k`.
    """

    mu_k: float = parameter(
        0.3,
        symbol=r"\mu_{\mathrm{k}}",
        meaning="coefficient of kinetic friction",
        minimum=0.0,
        range=(0.0, 3.0),
    )
    mu_s: float = parameter(
        3.0,
        symbol=r"\mu_{\mathrm{s}}",
        meaning="coefficient of static friction",
        minimum=0.0,
        range=(0.0, 4.0),
    )

    def check(self) -> None:
        """Static friction is never below kinetic friction."""
        if self.mu_s < self.mu_k:
            raise ValueError(
                f"mu_s must be at least mu_k ({self.mu_k}), got {self.mu_s}: raise mu_s or lower mu_k"
            )

    def kinetic(self, normal_force: Any, speed: Any) -> Any:
        """mu_k F_N (N), whatever the speed (m/s): the magnitude in Eq. (3)."""
        return self.mu_k * normal_force

    def static_limit(self, normal_force: Any) -> Any:
        """mu_s F_N (N): the right-hand side of Eq. (8)."""
        return self.mu_s * normal_force
