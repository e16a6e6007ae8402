"""`fl.tangent_flow`: how a motion depends on its initial state."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from frictionlab.hybrid.events import Events
from frictionlab.hybrid.methods import CHUNK
from frictionlab.hybrid.progress import DELAY
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


def tangent_flow(run: Trajectory, *, progress: bool = True) -> TangentFlow:
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
    progress : bool
        Show a progress bar where it takes more than a second.

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
    check_exact(run)
    frame, matrices = carry_frame(run, initial_frame(run), progress)
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


def carry_frame(run: Trajectory, frame: np.ndarray, progress: bool) -> tuple[np.ndarray, list[np.ndarray]]:
    """Columns (n, m), tangent vectors at a run's start, carried to its end; and the saltation matrices."""
    from tqdm.auto import tqdm

    rows, matrices = np.ascontiguousarray(frame.T), []
    shown = tqdm(list(pieces(run)), desc="tangent flow", leave=False, delay=DELAY, disable=not progress)
    for part, event in shown:
        carry_rows(carry_steps, run, part, rows)
        if event is not None:
            matrices.append(saltation_at(run, event))
            rows = np.ascontiguousarray(rows @ matrices[-1].T)
    return rows.T.copy(), matrices


def pieces(run: Trajectory) -> Iterator[tuple[slice, int | None]]:
    """A run as slices of its steps, none too long to be interrupted, each with the event at its end."""
    starts = run.raw.step_times[:, 0]
    ends = [*np.searchsorted(starts, run.raw.event_times).tolist(), len(starts)]
    for i, (first, last) in enumerate(pairwise([0, *ends])):
        while last - first > CHUNK:
            yield slice(first, first + CHUNK), None
            first += CHUNK
        yield slice(first, last), i if i < len(ends) - 1 else None


def end_rates(run: Trajectory) -> tuple[np.ndarray, np.ndarray]:
    """Time derivative (n,) of the state at the start and at the end of a run that takes at least one step."""
    problem, raw = run._problem, run.raw
    ends = (int(raw.step_modes[0]), raw.step_states[0]), (raw.mode, raw.state)
    flow = problem.program.code.flow
    first, last = (in_mode(problem.program, problem.numbers, *end).jets[flow[end[0]], 0] for end in ends)
    return first, last


def check_exact(run: Trajectory) -> None:
    """Raise for what is no run, or one of a method whose events are not exact."""
    if not isinstance(run, Trajectory):
        raise TypeError(
            f"run must be a Trajectory, got {run!r}: give what frictionlab.simulate or solve returns"
        )
    method = run.description.get("method", {}).get("name")
    if method != "taylor":
        raise ValueError(f"the tangent flow needs a run of method 'taylor', got {method!r}: run it again so")


def carry_rows(steps: Any, run: Trajectory, part: slice, rows: np.ndarray, *more: np.ndarray) -> None:
    """Carry the rows, tangent vectors, over a smooth piece of a run, by the kernel `steps`."""
    problem, raw, order = run._problem, run.raw, run.samples.order
    J = np.zeros((problem.program.slots, order + 1))
    T = np.zeros((*J.shape, len(rows)))
    stored = raw.step_times[part], raw.step_modes[part], raw.step_states[part]
    settings = problem.program.code, problem.numbers, order, run.description["method"]["tol"]
    with np.errstate(all="ignore"):
        failed = steps(*settings, *stored, raw.state.copy(), rows, J, T, *more)
    if failed >= 0 or not np.isfinite(rows).all():
        t = raw.step_times[part.start + max(failed, 0), 0]
        raise SaltationError(f"the tangent flow overflows after t = {t:g} s: end the run earlier")


def saltation_at(run: Trajectory, i: int) -> np.ndarray:
    """Saltation matrix (n, n) of an event of a run, by its number."""
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
    before, after = raw.event_states[i]
    event = Crossing(int(guard), int(target), before, after, dwell)
    try:
        return saltation(problem.program, problem.numbers, event)
    except SaltationError as error:
        raise SaltationError(f"no tangent flow {where}: {error}; change the initial state") from None
