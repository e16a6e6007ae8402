"""Impact laws, which give the impulse of a re-contact: plastic, with restitution, and with friction."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from frictionlab.validation import check_choice

from .component import Component, StructureKey, parameter, parameters_of

PENETRATION_RATES = ("material", "full")


@dataclass(frozen=True, repr=False)
class ImpactLaw(Component):
    """Base of the impact laws: a subclass gives :meth:`impulse`."""

    def impulse(self, material_rate: Any, penetration_rate: Any, compliance: Any) -> Any:
        """Impulse (N s) of the re-contact.

        Parameters
        ----------
        material_rate : float
            Velocity (m/s) at which the slider approaches the belt's material point, -W_N^T v.
        penetration_rate : float
            Time derivative of the penetration (m/s), which is minus the gap rate; it includes the slider's
            travel along the tilted belt.
        compliance : float
            How much 1 N s changes the rate that the law uses, 1/kg: W_N^T M^-1 W_N of the material one,
            g^T M^-1 W_N of the penetration's, if it is used; g is the gradient of the gap.
        """
        raise NotImplementedError(f"{type(self).__name__} must define impulse(...)")

    def reduced(self) -> ImpactLaw:
        """A simpler law that this one equals at its values (a restitution of 0 is a plastic impact); else the
        law itself.  Its parameters are some of this law's, with the same values."""
        return self

    @property
    def structure_key(self) -> StructureKey:
        """Its structure as it is now, or that of the simpler law that it equals."""
        reduced = self.reduced()
        if reduced is self:
            return super().structure_key
        for name in parameters_of(type(reduced)):
            if name not in parameters_of(type(self)) or getattr(reduced, name) != getattr(self, name):
                raise ValueError(
                    f"reduced() of {type(self).__name__} must return a law with its own parameters and "
                    f"values, got {reduced!r} with another {name}: give both the same"
                )
        return reduced.structure_key

    @property
    def friction_coefficient(self) -> Any:
        """Coefficient of Coulomb's friction of the impulses; 0 where they have none, or another."""
        return 0

    @property
    def has_own_friction(self) -> bool:
        """Whether a subclass has another :meth:`friction` than Coulomb's, or none."""
        return type(self).friction not in (ImpactLaw.friction, FrictionalImpact.friction)

    def friction(self, impulse: Any, stopping_impulse: Any) -> Any:
        """Tangential impulse (N s) along the relative velocity; none in the paper.

        Parameters
        ----------
        impulse : float
            Normal impulse of the re-contact without friction, N s.
        stopping_impulse : float
            Tangential impulse that would bring the relative velocity to zero after it, N s; it has the sign
            of that velocity.
        """
        return 0


@dataclass(frozen=True, repr=False)
class PlasticImpact(ImpactLaw):
    """Perfectly plastic impact, Eqs. (13) and (14).

    Parameters
    ----------
    penetration_rate : {"material", "full"}
        What the impact brings to zero: the velocity relative to the belt's material point, as the
        paper's Eq. (13) has it, or the full gap rate.
    """

    penetration_rate: str = "material"

    def check(self) -> None:
        """Refuse any other `penetration_rate`."""
        check_choice(
            "penetration_rate", self.penetration_rate, PENETRATION_RATES, "'material' is that of Eq. (13)"
        )

    def impulse(self, material_rate: Any, penetration_rate: Any, compliance: Any) -> Any:
        """Impulse (N s), Eq. (14), with the chosen rate in its numerator."""
        rates = {"material": material_rate, "full": penetration_rate}
        return rates[self.penetration_rate] / compliance


@dataclass(frozen=True, repr=False)
class RestitutionImpact(ImpactLaw):
    """Newton's impact law: the full gap rate after an impact is -e times that before.

    Parameters
    ----------
    e : float
        Coefficient of restitution, 0 (plastic) to 1 (elastic).
    """

    e: float = parameter(
        0.5, symbol="e", meaning="coefficient of restitution", minimum=0.0, maximum=1.0, range=(0.0, 1.0)
    )

    def reduced(self) -> ImpactLaw:
        """A plastic impact at e = 0: the gap rate after it is zero by construction, not to rounding.

        A subclass with an impulse or friction of its own is no simpler law.
        """
        return PlasticImpact("full") if self.e == 0 and _has_formulas_of(self, RestitutionImpact) else self

    def impulse(self, material_rate: Any, penetration_rate: Any, compliance: Any) -> Any:
        """Impulse (N s): (1 + e) penetration_rate / compliance."""
        return (1 + self.e) * penetration_rate / compliance


def _has_formulas_of(law: ImpactLaw, base: type) -> bool:
    """Whether the class of a law has no impulse or friction of its own beside those of a base."""
    methods = "impulse", "friction", "friction_coefficient"
    return all(getattr(type(law), name) is getattr(base, name) for name in methods)


def has_friction(law: ImpactLaw) -> bool:
    """Whether an impact has a tangential impulse, Coulomb's or the law's own."""
    return law.has_own_friction or law.friction_coefficient != 0


def _impact_friction_coefficient() -> Any:
    return parameter(
        0.3,
        symbol=r"\mu_{\mathrm{i}}",
        meaning="coefficient of friction of impacts",
        minimum=0.0,
        range=(0.0, 1.0),
    )


def clip(impulse: Any, least: Any, most: Any, size: Callable[[Any], Any] = abs) -> Any:
    """An impulse, or the nearest of its limits where it is beyond them; `size` is the absolute value."""
    return (size(impulse - least) - size(impulse - most) + least + most) / 2


@dataclass(frozen=True, repr=False)
class FrictionalImpact(RestitutionImpact):
    """Newton's impact law with Coulomb's friction between the impulses: |p_T| <= mu_i p_N.

    Both impulses follow together, at every contact along a line.  The gap opens at e times the rate at which
    it closed, so that p_N = p - b p_T, where p is the impulse without friction, and b is not zero where
    masses or directions couple both.  The tangential impulse stops the sliding where the friction cone allows
    it, and opposes it otherwise; it never feeds energy in.  A law with a :meth:`friction` of its own is given
    p, and answers for both itself.

    Parameters
    ----------
    e : float
        Coefficient of restitution, 0 (plastic) to 1 (elastic).
    mu_i : float
        Coefficient of friction of the impulses, at least 0.

    References
    ----------
    J. J. Moreau, Unilateral contact and dry friction in finite freedom dynamics, Springer 1988.

    C. Glocker, Set-Valued Force Laws: Dynamics of Non-Smooth Systems, Springer 2001.
    """

    mu_i: float = _impact_friction_coefficient()

    def reduced(self) -> ImpactLaw:
        """RestitutionImpact without friction; at e = 0 the gap rate afterwards is zero by construction."""
        if not _has_formulas_of(self, FrictionalImpact):
            return self
        if self.mu_i == 0:
            return RestitutionImpact(self.e).reduced()
        return _PlasticFrictionalImpact(mu_i=self.mu_i) if self.e == 0 else self

    @property
    def friction_coefficient(self) -> Any:
        """mu_i."""
        return self.mu_i

    def friction(self, impulse: Any, stopping_impulse: Any) -> Any:
        """Tangential impulse (N s): the stopping one, but at most mu_i times the normal impulse."""
        return clip(stopping_impulse, -self.mu_i * impulse, self.mu_i * impulse)


@dataclass(frozen=True, repr=False)
class _PlasticFrictionalImpact(PlasticImpact):
    penetration_rate: str = "full"
    mu_i: float = _impact_friction_coefficient()
    friction_coefficient = FrictionalImpact.friction_coefficient
    friction = FrictionalImpact.friction
