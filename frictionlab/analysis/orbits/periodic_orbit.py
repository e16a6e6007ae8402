"""`fl.periodic_orbit`: a periodic orbit, stable or not, and its Floquet multipliers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from frictionlab.analysis.motion_scales import Array, state_scales
from frictionlab.analysis.orbits.shooting import OrbitGuess, state_and_period
from frictionlab.analysis.simulate import model_initial_state
from frictionlab.analysis.steady_state.steady_state import SteadyState
from frictionlab.automaton import HybridAutomaton
from frictionlab.hybrid.solve import solve
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.models.model import automaton_of
from frictionlab.presentation import Drawable, shorten
from frictionlab.validation import check_number

from .shooting import ShootingResult, check_motion, check_orbit, floquet_multipliers, shoot

PERIOD_DIVISORS = (2, 3, 5, 7)
SAME_STATE_RTOL = 1e-6  # share of the motion's size within which two states are one
MULTIPLIER_RTOL = (
    1e-6  # in a family of orbits the multiplier 1 is double, and so known only to the square root of rounding
)


@dataclass(frozen=True, eq=False)
class PeriodicOrbit(Drawable):
    """A periodic orbit.

    Parameters
    ----------
    model : Model or HybridAutomaton
    period : float
        The shortest, in s.
    state : array (n,)
        Where `trajectory` starts: in the middle of the longest stay in a mode without constraints.
    monodromy : array (n, n)
        Derivative of the state after one period by `state`.
    multipliers : array (n,), complex
        Floquet multipliers, its eigenvalues, the largest first.  One is 1, along the orbit; with onsets of
        stick or plastic impacts one at least is 0.
    modes : tuple of (str, float)
        The modes and the seconds spent in each, in their order, from the first event of `trajectory` on.
    residual : float
        How far the orbit is from closing, as a share of the size of the motion in each state.
    trajectory : Trajectory
        One period.
    """

    drawn_by = "plot_orbit"

    model: Any
    period: float
    state: Array
    monodromy: Array
    multipliers: Array
    modes: tuple[tuple[str, float], ...]
    residual: float
    trajectory: Trajectory

    @property
    def stable(self) -> bool:
        """Whether all multipliers but that along the orbit are inside the unit circle, beyond rounding."""
        others = np.delete(self.multipliers, np.argmin(np.abs(self.multipliers - 1.0)))
        return bool((np.abs(others) < 1.0 - MULTIPLIER_RTOL).all())

    def __repr__(self) -> str:
        kind = "stable" if self.stable else "unstable"
        modes = shorten((mode for mode, _ in self.modes), separator=" > ")
        return f"PeriodicOrbit({kind}, period {self.period:.6g} s, {modes})"


def periodic_orbit(
    model: Any,
    guess: Any,
    *,
    period: float | None = None,
    t_max: float = 100.0,
    tolerance: float = 1e-9,
) -> PeriodicOrbit:
    """The periodic orbit near a guess, stable or unstable, by Newton's method on the return map.

    The monodromy matrix is that of :func:`frictionlab.tangent_flow`, so that events are accounted for.
    The result has been checked: it closes, keeps to the conditions of its modes, and its monodromy matrix
    maps the flow's direction upon itself.

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
        below the tolerance, with what it reached; where the motion has no derivative, see `tangent_flow`.
    KeyboardInterrupt
        After ctrl-C; there is no result yet.

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
    start = _start_in_free_mode(
        automaton, *state_and_period(automaton, _guess_state(model, guess), period, t_max)
    )
    shot = shoot(automaton, start, tolerance)
    check_motion(shot, start)
    shot = _shortest_period(automaton, start, shot, tolerance)
    check_orbit(shot, start)
    run = shot.run
    return PeriodicOrbit(
        model=model,
        period=run.raw.t,
        state=run.raw.step_states[0].copy(),
        monodromy=shot.matrix,
        multipliers=floquet_multipliers(shot.matrix),
        modes=mode_sequence(run),
        residual=shot.residual,
        trajectory=run,
    )


def _check(model: Any, guess: Any, period: float | None, t_max: float, tolerance: float) -> None:
    check_number("t_max", t_max, above=0.0, cure="give the seconds to look for a return")
    check_number("tolerance", tolerance, above=0.0, cure="1e-9 suits the exact solver")
    if period is not None:
        check_number("period", period, above=0.0, cure="give about the period in seconds")
    run = guess.trajectory if isinstance(guess, SteadyState) else guess
    names = tuple(map(str, automaton_of(model).states))
    if isinstance(run, Trajectory):
        if run.names != names:
            raise ValueError(f"guess must have the model's states {names}, got {run.names}: run this model")
        return
    state = np.asarray(model_initial_state(model, guess), dtype=float)
    if state.shape != (len(names),) or not np.isfinite(state).all():
        raise ValueError(
            f"guess must be a SteadyState, a Trajectory, or a finite number for each of {', '.join(names)}, "
            f"got {guess!r}"
        )


def _guess_state(model: Any, guess: Any) -> Any:
    return guess if isinstance(guess, (SteadyState, Trajectory)) else model_initial_state(model, guess)


def _start_in_free_mode(automaton: HybridAutomaton, state: Array, period: float) -> OrbitGuess:
    """The guess, moved along its motion into a mode without constraints, far from the events."""
    run = solve(automaton, period, x0=state, progress=False)
    if not run.status.ok:
        raise ValueError(f"guess must be near a periodic orbit; its motion ends early: {run.status}")
    ends = np.array([0.0, *run.events.t, run.raw.t])
    names = [run.mode[0], *run.events.target]
    free = [name for name in {*names} if name and not automaton.mode(name).constraints]
    stays = np.where(np.isin(names, free), np.diff(ends), 0.0)
    if not stays.max() > 0.0:
        raise ValueError("guess must pass a mode without constraints, it only sticks: give another state")
    i = np.argmax(stays)
    # Without events it is not moved: an unstable motion leads away from the orbit.
    middle = 0.5 * (ends[i] + ends[i + 1]) if len(run.events) else 0.0
    return OrbitGuess(run(middle), period, state_scales(run.states, automaton.coordinates))


def _shortest_period(
    automaton: HybridAutomaton, guess: OrbitGuess, shot: ShootingResult, tolerance: float
) -> ShootingResult:
    """The orbit with its shortest period, where the guess was several of them."""
    for fold in PERIOD_DIVISORS:
        period = shot.run.raw.t / fold
        while np.abs((shot.run(period) - shot.run.raw.step_states[0]) / guess.size).max() < SAME_STATE_RTOL:
            once = OrbitGuess(shot.run.raw.step_states[0], period, guess.size)
            shot = shoot(automaton, once, tolerance)
            period = shot.run.raw.t / fold
    return shot


def mode_sequence(run: Trajectory) -> tuple[tuple[str, float], ...]:
    """Modes and dwell times; the first and the last stay are one."""
    t, period = run.events.t, run.raw.t
    if not len(t):
        return ((str(run.mode[0]), period),)
    lengths = np.diff(np.append(t, t[0] + period))
    return tuple((str(name), float(length)) for name, length in zip(run.events.target, lengths, strict=True))
