"""Quantities of a periodic orbit: its period, the amplitude of a coordinate, its intensity L_s."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from frictionlab.analysis.options import SteadyStateOptions
from frictionlab.analysis.orbits.orbit_derivatives import (
    OrbitDerivatives,
    extreme,
    mean_square,
    orbit_derivatives,
)
from frictionlab.analysis.orbits.periodic_orbit import PeriodicOrbit, periodic_orbit
from frictionlab.analysis.steady_state.classification import MotionKind
from frictionlab.analysis.steady_state.steady_state import steady_state
from frictionlab.models.coercion import automaton_of
from frictionlab.presentation import state_unit
from frictionlab.stability.equilibrium_points.equilibria import equilibrium_problem
from frictionlab.validation import check_choice

from .equilibrium_quantities import derivatives_at
from .quantity import Array, Gradient, Quantity


@dataclass(frozen=True)
class _OfOrbit(Quantity):
    """A number of the periodic orbit near a given one, or of that to which the motion from rest settles."""

    near: PeriodicOrbit | None = field(default=None, kw_only=True)
    x0: Any = field(default="rest", kw_only=True)
    options: SteadyStateOptions = field(default=SteadyStateOptions(), kw_only=True)

    def _orbit(self, model: Any) -> PeriodicOrbit:
        """The orbit of a model.

        Raises
        ------
        ValueError
            Where the motion settles to none.
        """
        if self.near is not None:
            return periodic_orbit(model, self.near.state, period=self.near.period)
        found = steady_state(model, self.x0, options=self.options, progress=False)
        if found.kind != MotionKind.PERIODIC:
            raise ValueError(
                f"the motion must settle to a periodic orbit, got {found.kind!r}: give another x0=, a longer "
                "transient in options=, or an orbit as near="
            )
        return periodic_orbit(model, found)

    def values(self, model: Any, changes: Mapping[str, Array]) -> Array:
        count = max((len(column) for column in changes.values()), default=1)
        found = np.full(count, np.nan)
        for i in range(count):
            other = model.replace(**{name: float(column[i]) for name, column in changes.items()})
            try:
                found[i] = self._value(self._orbit(other))
            except ValueError:
                continue
        return found

    def _value(self, orbit: PeriodicOrbit) -> float:
        return self._slopes(orbit_derivatives(orbit))[0]

    def gradient(self, model: Any) -> Gradient:
        at = orbit_derivatives(self._orbit(model))
        value, slopes = self._slopes(at)
        return Gradient(value, dict(zip(at.names, map(float, slopes), strict=True)))

    def _slopes(self, at: OrbitDerivatives) -> tuple[float, Array]:
        """The number and its derivatives (P,)."""
        raise NotImplementedError


@dataclass(frozen=True)
class OrbitPeriod(_OfOrbit):
    """The period of a periodic orbit, s.

    Parameters
    ----------
    near : PeriodicOrbit, optional
        An orbit near that which is meant, of this model or of others near by; stable or not.  By default the
        one to which the motion from `x0` settles.
    x0 : "rest", "near", mapping or array_like
    options : SteadyStateOptions

    Examples
    --------
    >>> import frictionlab as fl
    >>> round(fl.OrbitPeriod()(fl.MassOnBelt()), 9)
    8.902605408
    """

    @property
    def label(self) -> str:
        return "period (s)"

    def _value(self, orbit: PeriodicOrbit) -> float:
        return orbit.period

    def _slopes(self, at: OrbitDerivatives) -> tuple[float, Array]:
        return at.orbit.period, at.period


@dataclass(frozen=True)
class OrbitAmplitude(_OfOrbit):
    """Half the range of a coordinate along a periodic orbit, m or rad.

    Parameters
    ----------
    name : str
        As "x1".
    near, x0, options
        As of :class:`OrbitPeriod`.

    Examples
    --------
    >>> import frictionlab as fl
    >>> model = fl.MassOnBelt()  # sqrt(a^2 + (v/w)^2) with a = (mu_s - mu_k) N/k
    >>> round(fl.OrbitAmplitude("x")(model), 9)
    0.538516481
    """

    name: str

    @property
    def label(self) -> str:
        return f"amplitude of {self.name} ({state_unit(self.name)})"

    def _orbit(self, model: Any) -> PeriodicOrbit:
        automaton = automaton_of(model)
        names = tuple(str(state) for state in automaton.states[: automaton.coordinates])
        check_choice("name", self.name, names, "name one of the coordinates")
        return super()._orbit(model)

    def _slopes(self, at: OrbitDerivatives) -> tuple[float, Array]:
        top, bottom = (extreme(at, self.name, sign) for sign in (1, -1))
        return 0.5 * (top.value - bottom.value), 0.5 * (top.slopes - bottom.slopes)


@dataclass(frozen=True)
class OrbitIntensity(_OfOrbit):
    """The intensity L_s of a periodic orbit, Eq. (20): mean squared distance from the equilibrium, m^2.

    Parameters
    ----------
    near, x0, options
        As of :class:`OrbitPeriod`.

    Examples
    --------
    >>> import frictionlab as fl
    >>> fl.OrbitIntensity()(fl.MassOnBelt()) > 0
    True
    """

    @property
    def label(self) -> str:
        return "L_s (m²)"

    def _slopes(self, at: OrbitDerivatives) -> tuple[float, Array]:
        problem = equilibrium_problem(at.orbit.model)
        found = derivatives_at(problem)
        places = [symbol.name for symbol in problem.flow.parameters]
        count = at.orbit.trajectory.automaton.coordinates
        moves = found.state()[:count]
        slopes = np.array([moves[:, places.index(p)] if p in places else np.zeros(count) for p in at.names])
        return mean_square(at, found.x[:count], slopes.T)
