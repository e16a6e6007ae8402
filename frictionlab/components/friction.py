"""Friction laws: the friction force while sliding, and its limit while sticking.

They are Coulomb's law, and laws that depend on speed or pressure.  Laws with states of their own, such as
LuGre's, are in `dynamic_friction`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, ClassVar

from frictionlab.validation import abbreviate, check_sequence

from .component import Component, parameter
from .functions import exp, interpolate

# Outputs and states of models, whose names a law's states cannot have.
NAMES_OF_RUNS = {
    "penetration",
    "gap",
    "normal_force",
    "friction_force",
    "relative_velocity",
    "distance",
    "reaction",
    "phase",
    "t",
}


@dataclass(frozen=True, repr=False)
class FrictionLaw(Component):
    """Base of the friction laws: a subclass gives :meth:`kinetic` and :meth:`static_limit`.

    A *dynamic* law has states of its own, such as the deflection of bristles.  It names them in `states`, and
    gives :meth:`force` and :meth:`rates` instead, which take the states by their names.  Its contact does not
    stick: where v_r changes its sign, force and rates are continuous.  Of an elastic-plastic law, which has a
    :meth:`state_limit`, "stick" is the elastic regime; several states have each its own.
    """

    states: ClassVar[tuple[str, ...]] = ()

    def __post_init__(self) -> None:
        super().__post_init__()
        self._check_states()

    def _check_states(self) -> None:
        """Raise ValueError unless `states` are names that nothing else of a run has."""
        what, cure = f"states of {type(self).__name__}", 'write states = ("z",) in the class'
        names = check_sequence(what, self.states, cure)
        for name in names:
            if not isinstance(name, str) or not name.isidentifier() or names.count(name) > 1:
                raise ValueError(
                    f"{what} must be different names of letters, digits and _, got {abbreviate(name)}: {cure}"
                )
            if name in NAMES_OF_RUNS:
                raise ValueError(
                    f"{what} must not have the name {name!r}, which models give to something else: {cure}"
                )

    def kinetic(self, normal_force: Any, speed: Any) -> Any:
        """Friction force (N) along the relative velocity, whose magnitude is `speed` (m/s)."""
        raise NotImplementedError(f"{type(self).__name__} must define kinetic(normal_force, speed)")

    def static_limit(self, normal_force: Any) -> Any:
        """Largest friction force (N) in stick."""
        raise NotImplementedError(f"{type(self).__name__} must define static_limit(normal_force)")

    # A law with the state z has force(normal_force, relative_velocity, z) and rates of the same arguments;
    # its stored_energy has normal_force and z, its rates_in_separation z alone.  Type checkers let it narrow
    # down what takes any arguments.

    def force(self, *arguments: Any, **named: Any) -> Any:
        """Friction force (N) of a dynamic law, positive along v_r (m/s), which has either sign."""
        raise NotImplementedError(f"{type(self).__name__} must define {self._signature('force')}")

    def rates(self, *arguments: Any, **named: Any) -> Mapping[str, Any]:
        """The rates of a dynamic law's states, by their names."""
        raise NotImplementedError(f"{type(self).__name__} must define {self._signature('rates')}")

    def rates_in_separation(self, *arguments: Any, **named: Any) -> Mapping[str, Any] | None:
        """The rates of the states while the bodies are apart, by their names.

        None, as by default, where all states return to zero at once when the contact is lost, as
        bristles without mass do.
        """
        return None

    def stored_energy(self, *arguments: Any) -> Any:
        """Energy (J) that a dynamic law stores in its states, as bristles do, at a normal force (N).

        None, as by default, where it stores none: then all work of friction is dissipated.
        """
        return None

    def state_limit(self, normal_force: Any) -> Any:
        """Largest magnitude of the state of an elastic-plastic law, at which it slips; else None.

        Of several states a mapping of their names to the limits.
        """
        return None

    def _signature(self, method: str) -> str:
        return f"{method}(normal_force, relative_velocity, {', '.join(self.states) or '<states>'})"


def check_coefficients(mu_k: float, mu_s: float) -> None:
    """Refuse static friction below kinetic friction."""
    if mu_s < mu_k:
        raise ValueError(f"mu_s must be at least mu_k ({mu_k}), got {mu_s}: raise mu_s or lower mu_k")


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
        """Refuse static friction below kinetic friction."""
        check_coefficients(self.mu_k, self.mu_s)

    def kinetic(self, normal_force: Any, speed: Any) -> Any:
        """mu_k F_N (N), whatever the speed (m/s): the magnitude in Eq. (3)."""
        return self.mu_k * normal_force

    def static_limit(self, normal_force: Any) -> Any:
        """mu_s F_N (N): the right-hand side of Eq. (8)."""
        return self.mu_s * normal_force


def _decay_speed() -> Any:
    return parameter(
        0.5,
        unit="m/s",
        symbol=r"v_{\mathrm{s}}",
        meaning="speed over which friction decays",
        exclusive_minimum=0.0,
        range=(0.01, 10.0),
        log=True,
    )


@dataclass(frozen=True, repr=False)
class ExponentialDecay(Coulomb):
    """Friction that decays with speed: mu = mu_k + (mu_s - mu_k) exp(-|v_r|/v_s).

    Parameters
    ----------
    mu_k, mu_s : float
        Coefficients of friction at high speed and at rest, 0 <= mu_k <= mu_s.
    v_s : float
        Decay speed, m/s, above 0.
    """

    v_s: float = _decay_speed()

    def kinetic(self, normal_force: Any, speed: Any) -> Any:
        """Friction force (N) at a sliding speed (m/s)."""
        return (self.mu_k + (self.mu_s - self.mu_k) * exp(-speed / self.v_s)) * normal_force


@dataclass(frozen=True, repr=False)
class HyperbolicDecay(Coulomb):
    """Friction that falls with speed as a hyperbola: mu = mu_k + (mu_s - mu_k)/(1 + |v_r|/v_s).

    Parameters
    ----------
    mu_k, mu_s : float
        Coefficients of friction at high speed and at rest, 0 <= mu_k <= mu_s.
    v_s : float
        Speed at which half of the fall is over, m/s, above 0.
    """

    v_s: float = _decay_speed()

    def kinetic(self, normal_force: Any, speed: Any) -> Any:
        """Friction force (N) at a sliding speed (m/s)."""
        return (self.mu_k + (self.mu_s - self.mu_k) / (1 + speed / self.v_s)) * normal_force


@dataclass(frozen=True, repr=False)
class Stribeck(Coulomb):
    """Stribeck's curve with viscous friction: mu = mu_k + (mu_s - mu_k) exp(-(v_r/v_s)^2) + mu_v |v_r|.

    Parameters
    ----------
    mu_k, mu_s : float
        Coefficients of kinetic and static friction, 0 <= mu_k <= mu_s.
    v_s : float
        Stribeck speed, m/s, above 0.
    mu_v : float
        Viscous coefficient, s/m, at least 0.

    References
    ----------
    B. Armstrong-Helouvry, P. Dupont, C. Canudas de Wit, Automatica 30 (1994) 1083-1138.
    """

    v_s: float = _decay_speed()
    mu_v: float = parameter(
        0.0,
        unit="s/m",
        symbol=r"\mu_{\mathrm{v}}",
        meaning="viscous coefficient of friction",
        minimum=0.0,
        range=(0.0, 1.0),
    )

    def kinetic(self, normal_force: Any, speed: Any) -> Any:
        """Friction force (N) at a sliding speed (m/s)."""
        decay = (self.mu_s - self.mu_k) * exp(-((speed / self.v_s) ** 2))
        return (self.mu_k + decay + self.mu_v * speed) * normal_force


@dataclass(frozen=True, repr=False)
class WeakeningStrengthening(Coulomb):
    """Friction that weakens and then grows: mu = mu_k + (mu_s - mu_k) exp(-|v_r|/v_s) + mu_v |v_r|/v_s.

    Parameters
    ----------
    mu_k, mu_s : float
        Dynamic and static coefficients, 0 <= mu_k <= mu_s.
    v_s : float
        Reference speed, m/s, above 0.
    mu_v : float
        Strengthening per reference speed, at least 0; friction is least at v_s log((mu_s - mu_k)/mu_v).

    References
    ----------
    A. Papangelo, M. Ciavarella, N. Hoffmann, Nonlinear Dynamics 90 (2017) 2037-2046.
    """

    v_s: float = _decay_speed()
    mu_v: float = parameter(
        0.1,
        symbol=r"\mu_{\mathrm{v}}",
        meaning="strengthening of friction",
        minimum=0.0,
        range=(0.0, 1.0),
    )

    def kinetic(self, normal_force: Any, speed: Any) -> Any:
        """Friction force (N) at a sliding speed (m/s)."""
        ratio = speed / self.v_s
        return (self.mu_k + (self.mu_s - self.mu_k) * exp(-ratio) + self.mu_v * ratio) * normal_force


@dataclass(frozen=True, repr=False)
class PressureDependent(Coulomb):
    """Coefficients that fall with speed, and with pressure: F_T = mu(|v_r|) F_N (F_N/F_ref)^(-n).

    Here mu = mu_k + (mu_s - mu_k) exp(-|v_r|/v_s).  With n = 1/3 friction follows the area of a Hertz
    contact, which grows like F_N^(2/3).

    Parameters
    ----------
    mu_k, mu_s : float
        Coefficients at F_N = F_ref, at high speed and at rest, 0 <= mu_k <= mu_s.
    v_s : float
        Decay speed, m/s, above 0.
    n : float
        Exponent of the pressure, 0 to below 1; 0 is the law without pressure.
    F_ref : float
        Normal force (N) at which the coefficients hold, above 0.

    References
    ----------
    K. L. Johnson, Contact Mechanics, Cambridge University Press 1985, chapter 4, for the area.
    """

    v_s: float = _decay_speed()
    n: float = parameter(
        1 / 3, symbol="n", meaning="exponent of the pressure", minimum=0.0, maximum=0.9, range=(0.0, 0.9)
    )
    F_ref: float = parameter(
        200.0,
        unit="N",
        symbol=r"F_{\mathrm{ref}}",
        meaning="normal force of the coefficients",
        exclusive_minimum=0.0,
        range=(10.0, 1000.0),
        log=True,
    )

    def kinetic(self, normal_force: Any, speed: Any) -> Any:
        """Friction force (N) at a sliding speed (m/s)."""
        return (self.mu_k + (self.mu_s - self.mu_k) * exp(-speed / self.v_s)) * self._effective_normal_force(
            normal_force
        )

    def static_limit(self, normal_force: Any) -> Any:
        """Largest friction force (N) in stick."""
        return self.mu_s * self._effective_normal_force(normal_force)

    def _effective_normal_force(self, normal_force: Any) -> Any:
        return self.F_ref**self.n * normal_force ** (1 - self.n)


def _coefficient_at(number: int, mu: float) -> Any:
    where = f"point {number}" if number else "rest"
    meaning = f"coefficient of friction at {where}"
    return parameter(mu, symbol=rf"\mu_{{{number}}}", meaning=meaning, minimum=0.0, range=(0.0, 1.5))


def _speed_of(number: int, v: float) -> Any:
    return parameter(
        v,
        unit="m/s",
        symbol=f"v_{{{number}}}",
        meaning=f"speed of point {number}",
        exclusive_minimum=0.0,
        range=(0.01, 3.0),
    )


@dataclass(frozen=True, repr=False)
class FrictionCurve(FrictionLaw):
    """A friction curve through five points: monotone cubics between them, constant beyond the last.

    The curve is that of :func:`frictionlab.functions.interpolate`.  The first point, at rest, is the static
    coefficient too.  In an explorer or an exported page the points are dragged; all are parameters, so that
    nothing is derived anew.

    Parameters
    ----------
    mu_0, mu_1, mu_2, mu_3, mu_4 : float
        Coefficients of friction at rest and at the speeds v_1 to v_4, at least 0.
    v_1, v_2, v_3, v_4 : float
        Ascending speeds, m/s, above 0.

    References
    ----------
    F. N. Fritsch, J. Butland, SIAM Journal on Scientific and Statistical Computing 5 (1984) 300-304.
    """

    mu_0: float = _coefficient_at(0, 0.6)
    mu_1: float = _coefficient_at(1, 0.45)
    mu_2: float = _coefficient_at(2, 0.36)
    mu_3: float = _coefficient_at(3, 0.32)
    mu_4: float = _coefficient_at(4, 0.4)
    v_1: float = _speed_of(1, 0.1)
    v_2: float = _speed_of(2, 0.3)
    v_3: float = _speed_of(3, 0.8)
    v_4: float = _speed_of(4, 2.0)

    def check(self) -> None:
        """Refuse speeds that do not ascend."""
        speeds = self.v_1, self.v_2, self.v_3, self.v_4
        for i, (one, following) in enumerate(pairwise(speeds)):
            if not one < following:
                raise ValueError(
                    f"v_{i + 2} must be above v_{i + 1} ({one}), got {following}: raise v_{i + 2} or lower "
                    f"v_{i + 1}"
                )

    def kinetic(self, normal_force: Any, speed: Any) -> Any:
        """Friction force (N) at a sliding speed (m/s)."""
        speeds = 0, self.v_1, self.v_2, self.v_3, self.v_4
        coefficients = self.mu_0, self.mu_1, self.mu_2, self.mu_3, self.mu_4
        return interpolate(speed, speeds, coefficients) * normal_force

    def static_limit(self, normal_force: Any) -> Any:
        """Largest friction force (N) in stick."""
        return self.mu_0 * normal_force
