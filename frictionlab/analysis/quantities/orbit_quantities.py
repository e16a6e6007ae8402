"""Quantities of a periodic orbit (period, amplitude of a coordinate, intensity L_s), with derivatives.

The orbit closes, z(T; z0, p) = z0.  To first order, with the monodromy matrix M, the flow f at the end and
the derivative B of the end by the parameters,

    [ M - 1   f ] [ dz0/dp ]     [ -B ]
    [  f^T    0 ] [ dT/dp  ]  =  [  0 ],

a bordered system: the start moves on a Poincare section normal to the flow.  It is regular where the
multiplier 1 is simple, also for an unstable orbit.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from frictionlab.analysis.initial_states import named_state
from frictionlab.analysis.motion_scales import state_scales
from frictionlab.analysis.options import SteadyStateOptions
from frictionlab.analysis.orbits.periodic_orbit import PeriodicOrbit, periodic_orbit
from frictionlab.analysis.parameter_flow import parameter_flow, varied_names
from frictionlab.analysis.quantities.quantities import (
    Array,
    Gradient,
    Quantity,
    derivatives_at,
    equilibrium_at,
)
from frictionlab.analysis.steady_state.classification import MotionKind
from frictionlab.analysis.steady_state.steady_state import (
    SQUARED_DISTANCE,
    displacements,
    settled_motion,
    squared_distance,
    with_equilibrium_parameters,
)
from frictionlab.hybrid.solve import solve_from_end
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.hybrid.variational.tangent_flow import end_rates
from frictionlab.models.model import automaton_of
from frictionlab.presentation import state_unit
from frictionlab.stability.equilibrium_points.equilibria import equilibrium_problem
from frictionlab.validation import abbreviate, check_choice, check_text

if TYPE_CHECKING:
    from frictionlab.automaton import HybridAutomaton
    from frictionlab.models.model import ModelOrAutomaton

SAME_TIME_SHARE = 1e-12  # share of the period: a turning point this near to an event is at the event
REGULAR_RTOL = 1e-9  # least over largest singular value of the bordered matrix: smaller in a family of orbits


class _OrbitDerivatives(NamedTuple):
    """Derivatives of an orbit's start (n, P), on a section normal to the flow, and of its period (P,)."""

    start: Array
    period: Array


def _orbit_derivatives(orbit: PeriodicOrbit, of_end: Array) -> _OrbitDerivatives:
    """Derivatives of start and period, from those of the end (n, n + P) by the start and by parameters.

    Raises
    ------
    ValueError
        Where the orbit is one of a family.
    """
    run, n = orbit.trajectory, len(of_end)
    by_state, by_parameters = of_end[:, :n], of_end[:, n:]
    size = state_scales(run.states, run.automaton.coordinates)
    rate = end_rates(run)[1] / size
    bordered = np.zeros((n + 1, n + 1))
    bordered[:n, :n] = by_state * size / size[:, None] - np.eye(n)
    bordered[:n, n] = rate * orbit.period
    bordered[n, :n] = rate / np.linalg.norm(rate)
    least = np.linalg.svd(bordered, compute_uv=False)
    if least[-1] < REGULAR_RTOL * least[0]:
        raise ValueError(
            "the orbit must be alone near by to have derivatives, got one of a family: add damping, or take "
            "another orbit"
        )
    right = np.zeros((n + 1, by_parameters.shape[1]))
    right[:n] = -by_parameters / size[:, None]
    solution = np.linalg.solve(bordered, right)
    return _OrbitDerivatives(solution[:n] * size[:, None], solution[n] * orbit.period)


class _Extreme(NamedTuple):
    """The largest or least value of a coordinate along an orbit, its time, and its event if it is at one."""

    value: float
    t: float
    event: int | None


def _once_more(orbit: PeriodicOrbit, automaton: HybridAutomaton, **records: Any) -> Trajectory:
    """One period of an orbit with records."""
    mode = str(orbit.trajectory.modes_at(0.0))
    return solve_from_end(automaton, orbit.period, orbit.state, mode, progress=False, **records)


def _extremes(orbit: PeriodicOrbit, name: str) -> tuple[_Extreme, _Extreme]:
    """The largest and the least value of a coordinate along an orbit."""
    run = orbit.trajectory
    place = run.names.index(name)
    velocity = run.automaton.states[run.automaton.coordinates + place]
    again = _once_more(orbit, run.automaton, sections={"turn": velocity})
    turns = again.sections["turn"]
    times, jumps = run.raw.event_times, run.raw.event_states[:, 0, place]
    # A velocity that jumps through zero is recorded as a turn too.
    separate = np.abs(turns.t[:, None] - times).min(axis=1, initial=np.inf) > SAME_TIME_SHARE * orbit.period

    def of_side(sign: int) -> _Extreme:
        smooth = np.where(separate, sign * turns.state[:, place], -np.inf)
        if len(jumps) and (sign * jumps).max() > smooth.max(initial=-np.inf):
            i = int(np.argmax(sign * jumps))
            return _Extreme(float(jumps[i]), float(times[i]), i)
        i = int(np.argmax(smooth))
        return _Extreme(float(sign * smooth[i]), float(turns.t[i]), None)

    return of_side(1), of_side(-1)


def amplitude_along(orbit: PeriodicOrbit, name: str) -> float:
    """Half the range of a coordinate along an orbit."""
    names = orbit.trajectory.names[: orbit.trajectory.automaton.coordinates]
    check_choice("name", name, names, "name one of the coordinates")
    top, bottom = _extremes(orbit, name)
    return 0.5 * (top.value - bottom.value)


def _rest_point(model: ModelOrAutomaton, names: tuple[str, ...], count: int) -> tuple[Array, Array]:
    """The coordinates (c,) of the equilibrium, and their derivatives (c, P)."""
    problem = equilibrium_problem(model)
    derivatives = derivatives_at(problem)
    places, moves = problem.parameter_names, derivatives.state()[:count]
    slopes = [moves[:, places.index(p)] if p in places else np.zeros(count) for p in names]
    return derivatives.x[:count], np.array(slopes).T


class _SquaredDistance(NamedTuple):
    """A run over one period of an orbit that integrates the squared distance from a point.

    `integrand` is that squared distance, `mean` its mean over the period, and `displacements` (c,) the mean
    of each coordinate's difference from the point.
    """

    run: Trajectory
    integrand: Any
    mean: float
    displacements: Array


def _squared_distance(orbit: PeriodicOrbit, point: Array) -> _SquaredDistance:
    automaton = with_equilibrium_parameters(orbit.trajectory.automaton, point)
    integrand, names = squared_distance(automaton), [f"displacement {i}" for i in range(len(point))]
    integrals = {SQUARED_DISTANCE: integrand, **dict(zip(names, displacements(automaton), strict=True))}
    run = _once_more(orbit, automaton, quadratures=integrals)
    means = np.array([run.quadratures[name] for name in names]) / orbit.period
    mean = float(run.quadratures[SQUARED_DISTANCE] / orbit.period)
    return _SquaredDistance(run, integrand, mean, means)


@dataclass(frozen=True)
class _OfOrbit(Quantity):
    """A number of the periodic orbit near a given one, or of that to which the motion from `x0` settles."""

    near: PeriodicOrbit | None = field(default=None, kw_only=True)
    x0: Any = field(default="rest", kw_only=True)
    options: SteadyStateOptions = field(default=SteadyStateOptions(), kw_only=True)

    def __post_init__(self) -> None:
        if self.near is not None and not isinstance(self.near, PeriodicOrbit):
            raise TypeError(
                f"near must be a PeriodicOrbit, got {abbreviate(self.near)}: find one with fl.periodic_orbit"
            )
        if isinstance(self.x0, str):
            check_choice("x0", self.x0, ("rest", "near"), "or give numbers, one for each state")
        named_state(self.x0)  # raises for what is no state of any model
        if not isinstance(self.options, SteadyStateOptions):
            raise TypeError(
                f"options must be SteadyStateOptions, got {abbreviate(self.options)}: "
                "write fl.SteadyStateOptions(...)"
            )

    def _orbit(self, model: ModelOrAutomaton) -> PeriodicOrbit:
        """The orbit of a model.

        Raises
        ------
        ValueError
            Where the motion does not settle to a periodic orbit.
        """
        if self.near is not None:
            return periodic_orbit(model, self.near.state, period=self.near.period)
        steady = settled_motion(model, self.x0, self.options, progress=False)
        if steady.kind != MotionKind.PERIODIC:
            raise ValueError(
                f"the motion must settle to a periodic orbit, "
                f"got {abbreviate(steady.kind)}: give another x0=, a longer "
                "transient in options=, or an orbit as near="
            )
        return periodic_orbit(model, steady)

    def values(self, model: ModelOrAutomaton, changes: Mapping[str, Array]) -> Array:
        count = max((len(column) for column in changes.values()), default=1)
        numbers = np.full(count, np.nan)
        for i in range(count):
            other = model.replace(**{name: float(column[i]) for name, column in changes.items()})
            try:
                numbers[i] = self._value(self._orbit(other))
            except ValueError:
                continue
        return numbers

    def _value(self, orbit: PeriodicOrbit) -> float:
        raise NotImplementedError

    def gradient(self, model: ModelOrAutomaton) -> Gradient:
        orbit = self._orbit(model)
        names = varied_names(orbit.trajectory.automaton)
        value, slopes = self._with_slopes(orbit, names)
        return Gradient(value, dict(zip(names, map(float, slopes), strict=True)))

    def _with_slopes(self, orbit: PeriodicOrbit, names: tuple[str, ...]) -> tuple[float, Array]:
        """The number and its derivatives (P,)."""
        raise NotImplementedError


@dataclass(frozen=True)
class OrbitPeriod(_OfOrbit):
    """The period of a periodic orbit, s.

    Parameters
    ----------
    near : PeriodicOrbit, optional
        An orbit near the one in question, stable or not, of this model or of one with similar parameters.  By
        default the orbit is the one to which the motion from `x0` settles.
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

    def _with_slopes(self, orbit: PeriodicOrbit, names: tuple[str, ...]) -> tuple[float, Array]:
        end = parameter_flow(orbit.trajectory, names, free=True).end
        return orbit.period, _orbit_derivatives(orbit, end).period


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

    def __post_init__(self) -> None:
        super().__post_init__()
        check_text("name", self.name, "name a coordinate")

    @property
    def label(self) -> str:
        return f"amplitude of {self.name} ({state_unit(self.name)})"

    def _orbit(self, model: ModelOrAutomaton) -> PeriodicOrbit:
        automaton = automaton_of(model)
        names = automaton.state_names[: automaton.coordinates]
        check_choice("name", self.name, names, "name one of the coordinates")
        return super()._orbit(model)

    def _value(self, orbit: PeriodicOrbit) -> float:
        return amplitude_along(orbit, self.name)

    def _with_slopes(self, orbit: PeriodicOrbit, names: tuple[str, ...]) -> tuple[float, Array]:
        # Where the coordinate turns smoothly its rate is zero, and the value moves as the state does; where
        # it turns at an event, as at a stop, the time of the event moves too.
        top, bottom = ends = _extremes(orbit, self.name)
        run = orbit.trajectory
        order = sorted(range(2), key=lambda k: ends[k].t)
        flow = parameter_flow(run, names, [ends[k].t for k in order], free=True)
        at = _orbit_derivatives(orbit, flow.end)
        moves = np.vstack([at.start, np.eye(len(names))])
        place = run.names.index(self.name)
        slopes = np.zeros((2, len(names)))
        for i, k in enumerate(order):
            slopes[k] = flow.slopes[i, place] @ moves
            if (event := ends[k].event) is not None:
                rate = run.raw.event_states[event, 0, run.automaton.coordinates + place]
                slopes[k] += rate * (flow.event_slopes[event] @ moves)
        return 0.5 * (top.value - bottom.value), 0.5 * (slopes[0] - slopes[1])


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

    def _value(self, orbit: PeriodicOrbit) -> float:
        x, _ = equilibrium_at(equilibrium_problem(orbit.model))
        point = x[: orbit.trajectory.automaton.coordinates]
        return _squared_distance(orbit, point).mean

    def _with_slopes(self, orbit: PeriodicOrbit, names: tuple[str, ...]) -> tuple[float, Array]:
        point, moves = _rest_point(orbit.model, names, orbit.trajectory.automaton.coordinates)
        distance = _squared_distance(orbit, point)
        slopes = parameter_flow(distance.run, names, integrands=(distance.integrand,), free=True).end
        at, n = _orbit_derivatives(orbit, slopes[:-1]), len(orbit.state)
        end = float(((distance.run.final_state[: len(point)] - point) ** 2).sum())
        total = slopes[-1, :n] @ at.start + slopes[-1, n:] + end * at.period
        return distance.mean, (
            total - distance.mean * at.period
        ) / orbit.period - 2.0 * distance.displacements @ moves
