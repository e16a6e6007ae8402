"""`fl.tangent_flow`: how a motion depends on its initial state."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from frictionlab.hybrid.events import Events
from frictionlab.hybrid.saltation import (
    Crossing,
    SaltationError,
    constraint_gradients,
    in_mode,
    saltation,
)
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.hybrid.variational import carry_steps


@dataclass(frozen=True, eq=False)
class TangentFlow:
    """Derivative of a run's final state by its initial state.

    Parameters
    ----------
    matrix : array (n, n)
        The fundamental matrix: entry (i, j) is the derivative of final state i by initial state j.  Over one
        period of a periodic motion it is the monodromy matrix.
    events : Events
        The run's events.
    saltations : array (E, n, n)
        The saltation matrix of each.
    """

    matrix: np.ndarray
    events: Events
    saltations: np.ndarray


def tangent_flow(run: Trajectory) -> TangentFlow:
    """Fundamental matrix of a run: its variational equation, with a saltation matrix at every event.

    The series are those of the run's tape, differentiated operation by operation, so that the matrix is as
    exact as the run.  Where stick begins the matrix loses a rank: neighbours stick as well.  In a run that
    starts in a mode with constraints (stick) only perturbations that keep them have a derivative; others are
    projected upon these first.  Where a run starts on the boundary of its mode (at rest on the belt) the
    derivative is that for neighbours inside.

    Parameters
    ----------
    run : Trajectory
        Made by method "taylor".

    Returns
    -------
    TangentFlow

    Raises
    ------
    ValueError
        Where the derivative does not exist or is not known: at an accumulation of impacts or chatter that was
        closed, a grazing event, two events at one instant, an end without admissible mode, or a run of
        another method.  The message says when and why.

    Examples
    --------
    >>> import frictionlab as fl
    >>> model = fl.SliderOnBelt(mu_k=1.4).without("geometry")
    >>> run = fl.simulate(model, 0.05, x0="near")
    >>> fl.tangent_flow(run).matrix.shape
    (8, 8)
    """
    frame, matrices = carry_frame(run, initial_frame(run))
    return TangentFlow(frame, run.events, np.array(matrices).reshape(-1, *frame.shape))


def initial_frame(run: Trajectory) -> np.ndarray:
    """The perturbations (n, n) that a run's first mode admits: the unit matrix, constraints projected out."""
    program, numbers, raw = run._problem.program, run._problem.numbers, run.raw
    frame = np.eye(raw.state.size)
    if not len(raw.step_modes):
        return frame
    mode, z = int(raw.step_modes[0]), raw.step_states[0]
    fixed = constraint_gradients(program, mode, in_mode(program, numbers, mode, z))
    return frame - np.linalg.pinv(fixed) @ fixed if len(fixed) else frame


def carry_frame(run: Trajectory, frame: np.ndarray) -> tuple[np.ndarray, list[np.ndarray]]:
    """Columns (n, m), tangent vectors at the start of a run, carried to its end; and the saltation matrices."""
    check_exact(run)
    starts, done, matrices = run.raw.step_times[:, 0], 0, []
    rows = np.ascontiguousarray(frame.T)
    for i, t in enumerate(run.raw.event_times):
        reached = int(np.searchsorted(starts, t))
        _carry(run, done, reached, rows)
        done = reached
        matrices.append(_saltation(run, i))
        rows = np.ascontiguousarray(rows @ matrices[-1].T)
    _carry(run, done, len(starts), rows)
    return rows.T.copy(), matrices


def check_exact(run: Trajectory) -> None:
    """Raise for a run of a method whose events are not exact."""
    method = run.description.get("method", {}).get("name")
    if method != "taylor":
        raise ValueError(f"the tangent flow needs a run of method 'taylor', got {method!r}: run it again so")


def _carry(run: Trajectory, first: int, last: int, rows: np.ndarray) -> None:
    """Carry the rows over the steps [first, last)."""
    problem, raw, order = run._problem, run.raw, run.samples.order
    part = slice(first, last)
    J = np.zeros((problem.program.slots, order + 1))
    T = np.zeros((len(rows), *J.shape))
    steps = raw.step_times[part], raw.step_modes[part], raw.step_states[part]
    settings = problem.program.code, problem.numbers, order, run.description["method"]["tol"]
    with np.errstate(all="ignore"):
        failed = carry_steps(*settings, *steps, raw.state.copy(), rows, J, T)
    if failed >= 0 or not np.isfinite(rows).all():
        t = raw.step_times[first + max(failed, 0), 0]
        raise SaltationError(f"the tangent flow overflows after t = {t:g} s: end the run earlier")


def _saltation(run: Trajectory, i: int) -> np.ndarray:
    raw, problem = run.raw, run._problem
    t, (guard, target, closed) = raw.event_times[i], raw.event_codes[i]
    where = f"at t = {t:g} s ({run.events.source[i]} to {run.events.target[i] or 'no mode'})"
    if closed:
        raise SaltationError(
            f"an accumulation of events was closed {where}; its derivative is not known: end the run before"
        )
    if target < 0:
        raise SaltationError(f"no mode was admissible {where}: end the run before")
    dwell = float(t - (raw.event_times[i - 1] if i else 0.0))
    event = Crossing(int(guard), int(target), *raw.event_states[i], dwell)
    try:
        return saltation(problem.program, problem.numbers, event)
    except SaltationError as error:
        raise SaltationError(f"no tangent flow {where}: {error}; change the initial state") from None
