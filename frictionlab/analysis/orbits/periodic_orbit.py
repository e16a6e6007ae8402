"""`fl.periodic_orbit`: a periodic orbit, stable or not, and its Floquet multipliers, by single shooting:
Newton's method on a Poincare section normal to the flow, from a state, a run or a steady state.

The result is checked independently of how it was found: an orbit moves, returns in the mode in which it
begins, keeps the conditions of its modes, and its monodromy matrix maps the flow's direction onto itself.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import eig, null_space
from scipy.optimize import minimize_scalar

from frictionlab.analysis.initial_states import carried_state_of, initial_state_of
from frictionlab.analysis.motion_scales import (
    AT_REST_RTOL,
    Array,
    motion_size,
    state_groups,
    state_ranges,
    state_scales,
)
from frictionlab.analysis.orbits.closing import Closing, closing_of
from frictionlab.analysis.run_conditions import moved_by_rounding
from frictionlab.analysis.steady_state.classification import MotionKind
from frictionlab.analysis.steady_state.drift import drifting_states, shifts_without_effect
from frictionlab.analysis.steady_state.steady_state import SteadyState
from frictionlab.automaton import HybridAutomaton
from frictionlab.hybrid.solve import end_of, problem_of, solve, solve_from_end
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.hybrid.variational.tangent_flow import carry_frame
from frictionlab.hybrid.variational.tangent_jets import SaltationError, linearise_mode
from frictionlab.models.model import ModelOrAutomaton, automaton_of
from frictionlab.presentation import Drawable, shorten
from frictionlab.stability.equilibrium_points.frozen_time import refuse_time
from frictionlab.validation import abbreviate, check_number, is_sequence

MOST_PERIODS = 64  # of an orbit in a guess
SAME_STATE_RTOL = 1e-6  # share of the motion's size within which two states are one
RETURN_RTOL = 0.1  # a state has returned within this share of the largest distance so far
# of its range: a state whose end differs by more from its start is no part of the periodic motion
DECAYING_SHARE = 1e-3
RETURN_XTOL = 1e-5  # share of a step to which the time of a return is located
SHORTEST_STAY = 1e-6  # share of a run that a stay has to last for an orbit to begin in it
MAX_ITERATIONS = 40
MAX_HALVINGS = 8
CONSTRAINT_STEPS = 3  # of Newton's method onto the constraints of a mode; one where they are linear
RESIDUAL_ROUNDING = 1e-14  # residual at the level of rounding, which cannot become smaller
# relative singular values below this belong to a family of orbits: no step is taken in their directions
FAMILY_RCOND = 1e-11
# times the error estimated: that of a nearly double multiplier is more than first order tells
ERROR_FACTOR = 10.0
CIRCLE_SAMPLES = 64  # points of the unit circle
MAX_PERIOD_FACTOR = 2.0  # factor by which the period may change in one iteration
MIN_ORBIT_SIZE = 1e-3  # an orbit smaller than this share of the guess is in fact an equilibrium
MAX_VIOLATION = 1e-6  # largest violation of a condition of a mode, as a share of the condition's terms
FLOW_DIRECTION_RTOL = 1e-6  # share by which the monodromy matrix may miss the direction of the flow


@dataclass(frozen=True, eq=False)
class PeriodicOrbit(Drawable):
    """A periodic orbit.

    Parameters
    ----------
    model : Model or HybridAutomaton
    period : float
        The shortest, in s.
    state : array (n,)
        Where `trajectory` starts: in the middle of the longest stay in a mode without constraints, or with
        the fewest where all modes have some.
    monodromy : array (n, n)
        Derivative of the state after one period by `state`.
    multipliers : array (n,), complex
        Floquet multipliers, its eigenvalues, the largest first.  One is 1, along the orbit; with onsets of
        stick or plastic impacts one at least is 0.  So is that of cyclic coordinates that turn together, and
        so are two for each rigid contact that stays closed.
    modes : tuple of (str, float)
        The modes, in order from the first event of `trajectory` on, and the seconds spent in each.
    residual : float
        How far the orbit is from closing, as a share of the size of the motion in each state.
    trajectory : Trajectory
        One period.
    """

    drawn_by = "plot_orbit"

    model: ModelOrAutomaton
    period: float
    state: Array
    monodromy: Array
    multipliers: Array
    modes: tuple[tuple[str, float], ...]
    residual: float
    trajectory: Trajectory

    @property
    def stable(self) -> bool:
        """Whether all multipliers but that along the orbit are inside the unit circle beyond errors."""
        return self.stability == "stable"

    @property
    def stability(self) -> str:
        """Whether it is "stable" or "unstable".

        "neutral" where the error of the multipliers leaves open on which side of the unit circle one is, as
        without damping: the linear theory does not tell.  The error is estimated from the residual, the
        tolerance of the run, and how far the monodromy matrix misses what is known of it: the flow's
        direction, and the multiplier 1.  It grows with the condition of the multipliers, which is large where
        two nearly coincide, as in a family of orbits.
        """
        return stability_within_errors(self)

    def __repr__(self) -> str:
        kind = self.stability
        modes = shorten((mode for mode, _ in self.modes), separator=" > ")
        return f"PeriodicOrbit({kind}, period {self.period:.6g} s, {modes})"


def periodic_orbit(
    model: ModelOrAutomaton,
    guess: Any,
    *,
    period: float | None = None,
    t_max: float = 100.0,
    tolerance: float = 1e-9,
) -> PeriodicOrbit:
    """The periodic orbit near a guess, stable or unstable, by Newton's method on the return map.

    The monodromy matrix is that of :func:`frictionlab.tangent_flow`, so that events are accounted for.
    The result has been checked: it closes, up to turns of cyclic coordinates; it keeps to the conditions of
    its modes; and its monodromy matrix maps the flow's direction onto itself.

    Parameters
    ----------
    model : Model or HybridAutomaton
    guess : SteadyState, Trajectory, array_like (n,), mapping, "rest" or "near"
        A periodic steady state; a run whose end is near the orbit; or a state near the orbit, see `simulate`.
        It may be of other parameter values.
    period : float or None
        Approximate period in s; None takes the time after which the motion first returns to the guess.
    t_max : float
        Longest time (s) in which the motion from a state has to return.
    tolerance : float
        Largest residual, as a share of the motion's size.

    Returns
    -------
    PeriodicOrbit

    Raises
    ------
    ValueError
        For bad arguments; for a guess to which the motion does not return; where Newton's method does not get
        below the tolerance; where the motion has no derivative, see `tangent_flow`.
    KeyboardInterrupt
        After ctrl-C; there is no partial result.

    Examples
    --------
    >>> import frictionlab as fl
    >>> model = fl.SliderOnBelt(mu_k=1.4).without("geometry")
    >>> run = fl.simulate(model, 30.0)
    >>> fl.periodic_orbit(model, run)
    PeriodicOrbit(stable, period 0.0905161 s, slip+ > stick > slip+ > separation)
    """
    automaton = automaton_of(model)
    _check(model, guess, period, t_max, tolerance)
    refuse_time(model, "a periodic orbit")
    given = guess if isinstance(guess, (SteadyState, Trajectory)) else initial_state_of(model, guess)
    run = guess.trajectory if isinstance(guess, SteadyState) else guess
    mode = end_of(run)[1] if isinstance(run, Trajectory) else None
    state, about = state_and_period(automaton, given, period, t_max)
    start = _start_in_freest_mode(automaton, carried_state_of(model, state), about, mode)
    shot = shoot(automaton, start, tolerance)
    check_motion(shot, start)
    shot = _shortest_period(automaton, start, shot, tolerance)
    check_orbit(shot, start)
    return orbit_of_run(model, shot.run, shot.matrix, shot.residual)


def orbit_of_run(
    model: ModelOrAutomaton, run: Trajectory, monodromy: Array, residual: float
) -> PeriodicOrbit:
    """The periodic orbit whose one period is a run."""
    return PeriodicOrbit(
        model=model,
        period=run.raw.t,
        state=run.raw.step_states[0].copy(),
        monodromy=monodromy,
        multipliers=floquet_multipliers(monodromy),
        modes=mode_sequence(run),
        residual=residual,
        trajectory=run if isinstance(model, HybridAutomaton) else run.from_source(model),
    )


def _check(model: ModelOrAutomaton, guess: Any, period: float | None, t_max: float, tolerance: float) -> None:
    check_number("t_max", t_max, above=0.0, cure="give the seconds to look for a return")
    check_number("tolerance", tolerance, above=0.0, cure="1e-9 suits the exact solver")
    if period is not None:
        check_number("period", period, above=0.0, cure="give about the period in seconds")
    run = guess.trajectory if isinstance(guess, SteadyState) else guess
    names = automaton_of(model).state_names
    if isinstance(run, Trajectory):
        if run.names != names:
            raise ValueError(f"guess must have the model's states {names}, got {run.names}: run this model")
        return
    if not isinstance(guess, (str, Mapping)) and not is_sequence(guess):
        raise ValueError(
            f"guess must be a SteadyState, a Trajectory, or a finite number for each of {', '.join(names)}, "
            f"got {abbreviate(guess)}: run the model until it has settled"
        )
    try:
        initial_state_of(model, guess)
    except ValueError as error:
        raise ValueError(
            f"guess must be a SteadyState, a Trajectory, or a finite number for each of {', '.join(names)}, "
            f"got {abbreviate(guess)}: {error}"
        ) from error


def _start_in_freest_mode(
    automaton: HybridAutomaton, state: Array, period: float, mode: str | None
) -> OrbitGuess:
    """The guess, moved along its motion into the mode with the fewest constraints, far from the events."""
    run = solve_from_end(automaton, period, state, mode, progress=False)
    _check_end(run)
    ends = np.array([0.0, *run.events.t, run.raw.t])
    i = freest_stay(automaton, [run.mode[0], *run.events.target], np.diff(ends))
    # Without events it is not moved: an unstable motion leads away from the orbit.
    middle = 0.5 * (ends[i] + ends[i + 1]) if len(run.events) else 0.0
    return OrbitGuess(run(middle), period, scales_of_orbit(run), mode_to_state(run, middle))


def scales_of_orbit(run: Trajectory, missed: Array | None = None) -> Array:
    """The unit (n,) of differences between states.

    A state that only rounding moves is measured by the motion of others.  So is a state that decays, and is
    no part of the periodic motion: its end differs from its start by much of its range.  `missed` (n,) has
    these differences.
    """
    states = run.states
    if missed is not None:
        ranges = state_ranges(states)
        decays = np.abs(missed) > DECAYING_SHARE * ranges
        decays &= ranges > AT_REST_RTOL * np.abs(states).max(axis=0)
        states = np.where(decays, 0.0, states)
    scales = state_scales(states, run.automaton.coordinates)
    return np.where(moved_by_rounding(run), motion_size(run), scales)


def _check_end(run: Trajectory) -> None:
    """Raise ValueError where the motion of a guess did not reach its end."""
    if not run.status.ok:
        raise ValueError(f"guess must be near a periodic orbit; its motion ends early: {run.status}")


def mode_to_state(run: Trajectory, t: float) -> str | None:
    """The mode of a run at a time, where its state does not tell it: where the mode has constraints, or,
    with hysteresis, another one is chosen there."""
    automaton, mode = run.automaton, str(run.modes_at(t))
    if automaton.mode(mode).constraints:
        return mode
    if automaton.on_demand or len(automaton.names) < 2:
        return None
    again = solve(automaton, SHORTEST_STAY * run.raw.t, x0=run(t), progress=False)
    return mode if again.modes_at(0.0) != mode else None


def freest_stay(automaton: HybridAutomaton, names: Sequence[str], lengths: Array) -> int:
    """Of stays in modes of these names the number of the longest in a mode with the fewest constraints."""
    counts = {name: len(automaton.mode(name).constraints) for name in {*names} if name}
    # A state that rounding has moved off a closed contact makes a flight before the first event.
    shortest = SHORTEST_STAY * lengths.sum()
    lasting = [n for n, length in zip(names, lengths, strict=True) if length > shortest and n in counts]
    fewest = min(counts[name] for name in lasting)
    freest = [name in counts and counts[name] == fewest for name in names]
    return int(np.argmax(np.where(freest, lengths, 0.0)))


def _shortest_period(
    automaton: HybridAutomaton, guess: OrbitGuess, shot: ShootingResult, tolerance: float
) -> ShootingResult:
    """The orbit with its shortest period, where the guess was several periods long."""
    start, times = shot.run.raw.step_states[0], shot.run.raw.t / np.arange(MOST_PERIODS, 1, -1)
    away = np.abs(shot.closing.difference(shot.run(times), start) / guess.size).max(axis=1)
    returns = (away < SAME_STATE_RTOL) & (shot.run.modes_at(times) == shot.run.modes_at(0.0))
    for period in times[returns][:1]:
        return shoot(automaton, guess._replace(state=start, period=float(period)), tolerance)
    return shot


def mode_sequence(run: Trajectory) -> tuple[tuple[str, float], ...]:
    """Modes and dwell times; the run's first and last stay are parts of one."""
    t, period = run.events.t, run.raw.t
    if not len(t):
        return ((str(run.mode[0]), period),)
    lengths = np.diff(np.append(t, t[0] + period))
    return tuple((str(name), float(length)) for name, length in zip(run.events.target, lengths, strict=True))


class OrbitGuess(NamedTuple):
    """A motion near an orbit.

    Parameters
    ----------
    state : array (n,)
    period : float
        Approximately, s.
    size : array (n,)
        The motion's size in each state.
    mode : str or None
        The mode of the state, where that does not tell it.
    parameters : int
        How many of the last states are parameters, which no constraint moves.
    """

    state: Array
    period: float
    size: Array
    mode: str | None = None
    parameters: int = 0


def state_and_period(
    automaton: HybridAutomaton, guess: Any, period: float | None, t_max: float
) -> tuple[Array, float]:
    """State (n,) and period of the guess that :func:`frictionlab.periodic_orbit` was given.

    Raises
    ------
    ValueError
        Where the motion does not return to the state.
    """
    if isinstance(guess, SteadyState):
        further = automaton.state_names[2 * automaton.coordinates :]
        if alone := [name for name in guess.drift if name in further]:
            raise ValueError(
                f"the state of an orbit must return, and {alone[0]} of guess drifts for ever: let an event "
                "set it back once a period, as Reset({p: p - 2*pi}) does with a phase p"
            )
        if guess.kind != MotionKind.PERIODIC:
            raise ValueError(
                f"guess must be periodic, the steady state is {guess.kind!r}: give another state"
            )
        return guess.trajectory.final_state, period or guess.period
    if isinstance(guess, Trajectory):
        return guess.final_state, period or first_return(guess, guess.raw.t, -1)
    state = np.asarray(guess, dtype=float)
    return state, period or first_return(solve(automaton, t_max, x0=state), 0.0, 1)


def first_return(run: Trajectory, start: float, direction: int) -> float:
    """Time from `start`, an end of the run, until the state is again close to that at `start`.

    Close means within a small share of the largest distance reached in between.
    """
    if run.raw.mode < 0:  # no mode could be entered
        _check_end(run)
    t = run.t[::direction]
    away = _distances(run, t, start)
    largest = np.maximum.accumulate(away, axis=0)
    parts = state_groups(run.automaton.coordinates)
    still = AT_REST_RTOL * np.array([np.abs(run.states[:, part]).max(initial=0.0) or 1.0 for part in parts])
    share = np.where(largest > still, away / np.where(largest > still, largest, 1.0), 0.0).max(axis=1)
    for i in 1 + np.flatnonzero((share[1:-1] <= share[:-2]) & (share[1:-1] < share[2:])):
        low, high = sorted((t[i - 1], t[i + 1]))
        scales = np.maximum(largest[i], still)
        minimum: Any = minimize_scalar(
            lambda at, scales=scales: float((_distances(run, [at], start) / scales).max()),
            bounds=(low, high),
            method="bounded",
            options={"xatol": RETURN_XTOL * (high - low)},
        )
        after = float(abs(minimum.x - start))
        if minimum.fun < RETURN_RTOL and _in_mode_near(run, minimum.x, RETURN_RTOL * after, start):
            return after
    growing = [run.names[i] for i in _shifted_coordinates(run)]
    cyclic = f", or list {' and '.join(growing)} in cyclic, as what grows for ever" if growing else ""
    raise ValueError(
        f"guess must come back within {RETURN_RTOL:.0%} of the size of its motion, it does not in "
        f"{run.raw.t:g} s: give a state nearer to the orbit, a larger t_max=, or about its period as "
        f"period={cyclic}"
    )


def _shifted_coordinates(run: Trajectory) -> list[int]:
    """The coordinates that drift and are not cyclic, though a shift of them changes nothing."""
    places = [i for i in drifting_states(run) if i < run.automaton.coordinates]
    drift = shifts_without_effect(run, places) if places else None
    return [i for i in drift.shifted if run.names[i] not in run.automaton.cyclic] if drift else []


def _in_mode_near(run: Trajectory, t: float, about: float, start: float) -> bool:
    """Whether a run is in its mode at `start` also near another time, within `about`."""
    times = np.clip([t - about, t, t + about], 0.0, run.raw.t)
    return bool((run.modes_at(times) == run.modes_at(start)).any())


def _distances(run: Trajectory, t: Any, start: float) -> Array:
    """Distances (N, 3) from the state at `start`: in the coordinates, in the velocities, in the rest."""
    differences = np.abs(closing_of(run).difference(run(np.asarray(t)), run(start)))
    parts = state_groups(run.automaton.coordinates)
    return np.column_stack([differences[:, part].max(axis=1, initial=0.0) for part in parts])


class ShootingResult(NamedTuple):
    """A trial over one period: the run, its monodromy matrix, its residual over the motion's size, and what
    of the state has to return."""

    run: Trajectory
    matrix: Array
    residual: float
    closing: Closing

    @property
    def missed(self) -> Array:
        """How far the end is from the start (n,), but for turns."""
        return self.closing.difference(self.run.final_state, self.run.raw.step_states[0])

    @property
    def end_rates(self) -> tuple[Array, Array]:
        """Rates (n,) of the state at the start and at the end."""
        return self.closing.end_rates(self.run)


def floquet_multipliers(monodromy: Array) -> Array:
    """Eigenvalues of a monodromy matrix, the largest first."""
    values = np.linalg.eigvals(monodromy).astype(complex)
    return values[np.argsort(-np.abs(values), kind="stable")]


def transverse_multipliers(multipliers: Array) -> Array:
    """Floquet multipliers without that along the orbit, the one next to 1."""
    return np.delete(multipliers, np.argmin(np.abs(multipliers - 1.0)))


def stability_within_errors(orbit: PeriodicOrbit) -> str:
    """Whether an orbit is "stable" or "unstable", "neutral" where the errors of its multipliers hide that.

    Let dM be the error of the monodromy matrix M in units of the motion's size.  To first order it moves a
    simple multiplier, with left and right vectors l, r of length 1, by at most |dM|/|l r|.  So one may be
    outside the unit circle for sure.  No multiplier crosses the circle, whether simple or not, as long as the
    least singular value of B - z is larger than the error of B for all |z| = 1.  B is M without the
    multiplier along the orbit, on the plane normal to its l, so that its error is at most |dM|/|l r| of that.
    """
    run = orbit.trajectory
    size = scales_of_orbit(run)
    matrix = orbit.monodromy * size / size[:, None]
    decomposition: Any = eig(matrix, left=True)
    values, left, right = decomposition
    along = int(np.argmin(np.abs(values - 1.0)))
    with np.errstate(divide="ignore"):
        conditions = 1.0 / np.abs((left.conj() * right).sum(axis=0))
    error = ERROR_FACTOR * max(
        _monodromy_error(orbit, matrix, size), abs(values[along] - 1.0) / conditions[along]
    )
    outside = np.abs(values) - conditions * error > 1.0
    others = np.delete(values, along)
    plane = null_space(left[:, along].conj()[None])
    if np.delete(outside, along).any():
        return "unstable"
    if _distance_from_circle(plane.conj().T @ matrix @ plane, others) <= conditions[along] * error:
        return "neutral"
    return "unstable" if (np.abs(others) > 1.0).any() else "stable"


def _monodromy_error(orbit: PeriodicOrbit, matrix: Array, size: Array) -> float:
    """An estimate of |dM|, in units of `size`: by what the run leaves open, and by M f = f for the flow f."""
    first, last = (rate / size for rate in closing_of(orbit.trajectory).end_rates(orbit.trajectory))
    tolerance = orbit.trajectory.description["method"]["tol"]
    share = max(tolerance, len(size) * np.finfo(float).eps, orbit.residual)
    missed = np.linalg.norm(matrix @ first - last) / np.linalg.norm(first)
    return float(max(share * np.linalg.norm(matrix, 2), missed))


def _distance_from_circle(block: Any, values: Any) -> float:
    """The least singular value of B - z on the unit circle: at the angles of B's eigenvalues, and between."""
    angles = np.append(np.linspace(0.0, 2.0 * np.pi, CIRCLE_SAMPLES, endpoint=False), np.angle(values))
    shifted = block - np.exp(1j * angles)[:, None, None] * np.eye(len(block))
    return float(np.linalg.svd(shifted, compute_uv=False).min(initial=np.inf))


def shoot(automaton: HybridAutomaton, guess: OrbitGuess, tolerance: float) -> ShootingResult:
    """The periodic orbit near a guess: the state z and the period T, such that the flow after T is z again.

    Raises
    ------
    ValueError
        Where Newton's method does not get below the tolerance.
    """
    shot = run_one_period(automaton, guess)
    for _ in range(MAX_ITERATIONS):
        if shot.residual <= RESIDUAL_ROUNDING:
            break
        better = _damped_step(automaton, guess, shot)
        if better is None:
            break
        guess, shot = better
    if not shot.residual <= tolerance:
        raise ValueError(
            "no periodic orbit found near the guess: Newton's method reached a residual of "
            f"{shot.residual:.2g} of the motion's size at period {guess.period:.6g} s, asked for is "
            f"{tolerance:g}: give a guess nearer to an orbit"
        )
    return shot


def run_one_period(automaton: HybridAutomaton, guess: OrbitGuess) -> ShootingResult:
    """The motion from a state over a period, and how far it ends from there, in units of its size.

    Raises
    ------
    SaltationError
        If the motion ends early.
    """
    z, frame = _on_constraints(automaton, guess)
    run = solve(automaton, guess.period, x0=z, mode=guess.mode, progress=False)
    if not run.status.ok:
        raise SaltationError(f"a motion near the orbit ends after {run.raw.t:g} s: {run.status}")
    closing = closing_of(run)
    missed = float(np.abs(closing.difference(run.final_state, z) / guess.size).max())
    matrix = closing.matrix(carry_frame(run, frame, False)[0])
    return ShootingResult(run, matrix, missed, closing)


def _on_constraints(automaton: HybridAutomaton, guess: OrbitGuess) -> tuple[Array, Array]:
    """The state (n,) moved onto the constraints of its mode, and the perturbations (n, n) that keep them.

    Each unit perturbation is moved along the constraints' gradients; parameters are not moved.
    """
    z, frame = guess.state, np.eye(len(guess.state))
    if guess.mode is None or not automaton.mode(guess.mode).constraints:
        return z, frame
    problem = problem_of(automaton, z, guess.period, guess.mode)
    program, mode = problem.program, problem.program.modes.index(guess.mode)
    slots = program.code.function_slots[slice(*program.code.mode_constraints[mode : mode + 2])]
    free = len(z) - guess.parameters
    for _ in range(CONSTRAINT_STEPS):
        at = linearise_mode(program, problem.numbers, mode, z)
        gradients = at.gradients[slots]
        back = np.vstack([np.linalg.pinv(gradients[:, :free]), np.zeros((guess.parameters, len(slots)))])
        z, frame = z - back @ at.jets[slots, 0], np.eye(len(z)) - back @ gradients
    return z, frame


def _newton_step(shot: ShootingResult, period: float, size: Array) -> Array:
    """Newton's step for (z / size, T / period): the shortest one that closes the orbit.

    At a periodic orbit it is normal to the flow, so that z moves on a Poincare section.
    """
    last = shot.end_rates[1] / size
    missed: Any = shot.missed / size
    matrix = shot.matrix * size / size[:, None] - np.eye(len(size))
    return np.linalg.lstsq(np.column_stack([matrix, last * period]), -missed, rcond=FAMILY_RCOND)[0]


def _damped_step(
    automaton: HybridAutomaton, guess: OrbitGuess, shot: ShootingResult
) -> tuple[OrbitGuess, ShootingResult] | None:
    """After Newton's step, or the largest of its half, quarter, ... that reduces the residual; None where
    none does."""
    if not (np.isfinite(shot.matrix).all() and np.isfinite(shot.missed).all()):  # beyond all floats
        return None
    step, period = _newton_step(shot, guess.period, guess.size), guess.period
    if not np.isfinite(step).all():
        return None
    for share in 0.5 ** np.arange(MAX_HALVINGS):
        state, longer = guess.state + share * step[:-1] * guess.size, period * (1.0 + share * step[-1])
        if not period / MAX_PERIOD_FACTOR < longer < period * MAX_PERIOD_FACTOR:
            continue
        other = guess._replace(state=state, period=longer)
        try:
            after = run_one_period(automaton, other)
        except ValueError:  # it ends early, or leaves the states of its mode
            continue
        if after.residual < shot.residual:
            return other, after
    return None


def check_motion(shot: ShootingResult, guess: OrbitGuess) -> None:
    """Raise where the motion closes only because it is an equilibrium, or a steady rotation."""
    start = shot.run.raw.step_states[0]
    if (state_ranges(shot.closing.difference(shot.run.states, start)) / guess.size).max() < MIN_ORBIT_SIZE:
        where = shorten(f"{name} {value:.4g}" for name, value in zip(shot.run.names, start, strict=True))
        raise ValueError(
            "no periodic orbit found near the guess: Newton's method reached an equilibrium, "
            f"{where}: give a guess nearer to an orbit"
        )


def check_orbit(shot: ShootingResult, guess: OrbitGuess) -> None:
    """Raise for an orbit that ends in another mode than it begins in, that breaks a condition of its modes,
    or whose monodromy matrix is too inexact.
    """
    # At zero relative velocity, with the force between kinetic and static friction, both slip and stick may
    # begin: a motion that slips away from such a state and returns to stick there does not repeat.
    names = shot.run.mode_names
    begins, ends = names[int(shot.run.raw.step_modes[0])], names[shot.run.raw.mode]
    if begins != ends:
        raise ValueError(
            f"no periodic orbit found near the guess: what Newton's method reached begins in mode {begins!r} "
            f"and comes back to the same state in mode {ends!r}: give a guess nearer to an orbit"
        )
    if (amount := shot.run.violation) > MAX_VIOLATION:
        raise ValueError(
            f"the orbit found violates a condition of its modes by {amount:.2g}: give another guess"
        )
    first, last = (rate / guess.size for rate in shot.end_rates)
    matrix = shot.matrix * guess.size / guess.size[:, None]
    missed = np.abs(matrix @ first - last).max() / (np.abs(matrix) @ np.abs(first)).max()
    if not missed < FLOW_DIRECTION_RTOL:
        growth = np.abs(matrix).max()
        why = "the orbit is too unstable for single shooting; take other parameters"
        if growth * FLOW_DIRECTION_RTOL < 1.0:
            why = (
                f"no deviation grows by more than {growth:.2g} in a period, so a law may lack a finite slope "
                "at a state of the orbit, as sqrt(v_r) does at v_r = 0: write one that has it"
            )
        raise ValueError(f"the monodromy matrix misses the flow's direction by {missed:.2g}: {why}")
