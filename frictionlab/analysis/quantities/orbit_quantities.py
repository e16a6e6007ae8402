"""Quantities of a periodic orbit, its period, the amplitude of a coordinate, its intensity L_s, and their
derivatives by all parameters.

The orbit closes, z(T; z0, p) = z0.  To first order, with the monodromy matrix M, the flow f at the end and
the derivative B of the end by the parameters,

    [ M - 1   f ] [ dz0/dp ]     [ -B ]
    [  f^T    0 ] [ dT/dp  ]  =  [  0 ],

a bordered system: the start moves on a Poincare section normal to the flow.  It is regular where the
multiplier 1 is simple, of an unstable orbit too.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
import sympy

from frictionlab.analysis.motion_scales import state_scales
from frictionlab.analysis.options import SteadyStateOptions
from frictionlab.analysis.orbits.periodic_orbit import PeriodicOrbit, periodic_orbit
from frictionlab.analysis.parameter_flow import parameter_flow, varied_names
from frictionlab.analysis.quantities.equilibrium_quantities import derivatives_at
from frictionlab.analysis.quantities.sensitivity import Array, Gradient, Quantity
from frictionlab.analysis.steady_state.classification import MotionKind
from frictionlab.analysis.steady_state.steady_state import steady_state
from frictionlab.hybrid.solve import solve
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.hybrid.variational.tangent_flow import end_rates
from frictionlab.hybrid.variational.tangent_jets import linearise_mode
from frictionlab.models.coercion import automaton_of
from frictionlab.presentation import state_unit
from frictionlab.stability.equilibrium_points.equilibria import equilibrium_problem
from frictionlab.validation import check_choice

REGULAR_RTOL = 1e-9  # least singular value of the bordered matrix: below it orbits come in families


class OrbitDerivatives(NamedTuple):
    """How an orbit moves with P parameters.

    Parameters
    ----------
    orbit : PeriodicOrbit
    names : tuple of str
    start : array (n, P)
        Of `orbit.state`, on a section normal to the flow.
    period : array (P,)
    """

    orbit: PeriodicOrbit
    names: tuple[str, ...]
    start: Array
    period: Array


class Extreme(NamedTuple):
    """The largest or least value of a state along an orbit, and its derivatives (P,)."""

    value: float
    slopes: Array


def orbit_derivatives(orbit: PeriodicOrbit) -> OrbitDerivatives:
    """Derivatives of start and period by all parameters.

    Raises
    ------
    ValueError
        Where the orbit is one of a family, or a motion along it has no derivative.
    """
    run = orbit.trajectory
    names = varied_names(run.automaton)
    flow = parameter_flow(run, names, free=True)
    size = state_scales(run.states, run.automaton.coordinates)
    rate = end_rates(run)[1] / size
    n = len(size)
    bordered = np.zeros((n + 1, n + 1))
    bordered[:n, :n] = flow.state * size / size[:, None] - np.eye(n)
    bordered[:n, n] = rate * orbit.period
    bordered[n, :n] = rate / np.linalg.norm(rate)
    least = np.linalg.svd(bordered, compute_uv=False)
    if least[-1] < REGULAR_RTOL * least[0]:
        raise ValueError(
            "the orbit must be alone near by to have derivatives, got one of a family: add damping, or take "
            "another orbit"
        )
    right = np.zeros((n + 1, len(names)))
    right[:n] = -flow.parameters / size[:, None]
    found = np.linalg.solve(bordered, right)
    return OrbitDerivatives(orbit, names, found[:n] * size[:, None], found[n] * orbit.period)


def extreme(at: OrbitDerivatives, name: str, sign: int) -> Extreme:
    """The largest (`sign` 1) or least (-1) value of a coordinate along an orbit.

    Where the coordinate turns smoothly its rate is zero, and the value moves as the state does; where it
    turns at an event, as at a stop, the time of the event moves too.
    """
    run = at.orbit.trajectory
    place = run.names.index(name)
    velocity = run.automaton.states[run.automaton.coordinates + place]
    again = solve(
        run.automaton, at.orbit.period, x0=at.orbit.state, sections={"turn": velocity}, progress=False
    )
    turns, jumps = again.sections["turn"], again.raw.event_states[:, 0, place]
    # A velocity that jumps through zero is recorded as a turn too.
    smooth = np.where(np.isin(turns.t, again.raw.event_times), -np.inf, sign * turns.state[:, place])
    if len(jumps) and (sign * jumps).max() > smooth.max(initial=-np.inf):
        i = int(np.argmax(sign * jumps))
        return Extreme(float(jumps[i]), _at_event(at, again, i)[place])
    i = int(np.argmax(smooth))
    until = solve(run.automaton, float(turns.t[i]), x0=at.orbit.state, progress=False)
    flow = parameter_flow(until, at.names, free=True)
    return Extreme(float(sign * smooth[i]), (flow.state @ at.start + flow.parameters)[place])


def _at_event(at: OrbitDerivatives, run: Trajectory, i: int) -> Array:
    """Derivatives (n, P) of the state at an event, just before it; its time moves as well."""
    raw, program = run.raw, run.problem.program
    guard, before = int(raw.event_codes[i, 0]), raw.event_states[i, 0]
    mode = int(program.guard_modes[guard])
    kept = raw.step_times[:, 0] < raw.event_times[i]
    cut = raw._replace(
        step_times=raw.step_times[kept],
        step_modes=raw.step_modes[kept],
        step_states=raw.step_states[kept],
        event_times=raw.event_times[:i],
        event_codes=raw.event_codes[:i],
        event_states=raw.event_states[:i],
        t=float(raw.event_times[i]),
        state=before,
        mode=mode,
    )
    until = Trajectory(run.automaton, run.problem, cut, run.samples, description=run.description)
    flow = parameter_flow(until, at.names, free=True)
    moved = flow.state @ at.start + flow.parameters
    jets = linearise_mode(program, run.problem.numbers, mode, before)
    slot = program.code.function_slots[guard]
    rates = jets.jets[program.code.flow[mode], 0]
    by_parameters = _guard_slopes(run, mode, guard, before, at.names)
    later = -(jets.gradients[slot] @ moved + by_parameters) / jets.jets[slot, 1]
    return moved + np.outer(rates, later)


def _guard_slopes(run: Trajectory, mode: int, guard: int, z: Array, names: tuple[str, ...]) -> Array:
    """Derivatives (P,) of an event function by the parameters."""
    automaton, code = run.automaton, run.problem.program.code
    function = automaton.mode(run.mode_names[mode]).events[guard - int(code.mode_guards[mode])].function
    values = {**dict(zip(automaton.states, z)), **automaton.parameters}
    symbols = {symbol.name: symbol for symbol in automaton.parameters}
    slopes = (sympy.diff(function, symbols[name]) for name in names)
    return np.array([float(slope.subs(values)) for slope in slopes])


def mean_square(at: OrbitDerivatives, point: Any, point_slopes: Any) -> Extreme:
    """L_s, Eq. (20), and its derivatives; `point` (c,) is the equilibrium, (c, P) its derivatives."""
    run, period = at.orbit.trajectory, at.orbit.period
    chosen = run.automaton.states[: len(point)]
    rest = [sympy.Symbol(f"{x.name} at rest") for x in chosen]
    apart = [x - e for x, e in zip(chosen, rest)]
    square = sum((d**2 for d in apart), sympy.S.Zero)
    named = {e: float(value) for e, value in zip(rest, point)}
    automaton = type(run.automaton)(
        run.automaton.states, run.automaton.modes, {**run.automaton.parameters, **named}, len(chosen)
    )
    asked = {"square": square} | {f"apart {i}": d for i, d in enumerate(apart)}
    again = solve(automaton, period, x0=at.orbit.state, quadratures=asked, progress=False)
    flow = parameter_flow(again, at.names, (square,), free=True)
    value = again.quadratures["square"] / period
    end = float(((again.final_state[: len(point)] - point) ** 2).sum())
    total = flow.integrals_by_state[0] @ at.start + flow.integrals_by_parameters[0] + end * at.period
    means = np.array([again.quadratures[f"apart {i}"] for i in range(len(point))]) / period
    slopes = (total - value * at.period) / period - 2.0 * means @ np.asarray(point_slopes)
    return Extreme(float(value), slopes)


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
