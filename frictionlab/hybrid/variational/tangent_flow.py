"""`fl.tangent_flow`: how a motion depends on its initial state, and how fast perturbations grow.

For growth rates the tangent vectors are orthonormalised after every step (Gram-Schmidt).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from frictionlab.compilation.decorators import kernel
from frictionlab.hybrid.codegen.native_cache import interpreted_code
from frictionlab.hybrid.kernels.jets import copy_vector
from frictionlab.hybrid.kernels.run_state import StepData, Truncation
from frictionlab.hybrid.kernels.step_length import SHARE_OF_STOP
from frictionlab.hybrid.methods.base import RECORD_CAPACITY
from frictionlab.hybrid.methods.runge_kutta import STOP_ORDER, guard_at_stop
from frictionlab.hybrid.run_events import Events
from frictionlab.hybrid.trajectory import Trajectory, check_run
from frictionlab.hybrid.variational.tangent_jets import (
    MIN_TANGENT_STEP_SHARE,
    EventCrossing,
    Saltation,
    SaltationError,
    TangentScratch,
    admissible_tangents,
    carry_step,
    carry_steps,
    changes_nothing,
    constraint_gradients,
    linearise_mode,
    saltation,
)
from frictionlab.interruption import progress_bar
from frictionlab.presentation import Drawable, count
from frictionlab.tape.elementary.exponentials import log
from frictionlab.validation import abbreviate, check_flag

# share of a vector's length that remains by rounding alone where an event removes the vector
LOST_SHARE = 1e-12
# s, when the first mode of a run that goes on from another was entered, at the latest: neighbours on both
# sides come from there, and an event at t = 0 has a derivative
BEFORE_START = -float(np.finfo(float).tiny)


@dataclass(frozen=True, eq=False)
class TangentFlow(Drawable):
    """Derivative of a run's final state by its initial state.

    Parameters
    ----------
    matrix : array (n, n)
        The fundamental matrix: entry (i, j) is the derivative of final state i by initial state j.  Over one
        period of a periodic motion it is the monodromy matrix.
    events : Events
        The run's events.
    saltations : array (E, n, n)
        The saltation matrix of each event.
    names : tuple of str
        Names of the states.
    """

    drawn_by = "plot_tangent_flow"

    matrix: np.ndarray
    events: Events
    saltations: np.ndarray
    names: tuple[str, ...]

    def __repr__(self) -> str:
        size, events = count(len(self.matrix), "state"), count(len(self.events), "event")
        return f"TangentFlow({size}, {events}, largest derivative {np.abs(self.matrix).max():.4g})"


def tangent_flow(run: Trajectory, *, progress: bool = True) -> TangentFlow:
    """Fundamental matrix of a run: its variational equation, with a saltation matrix at every event.

    The series are those of the run's tape, differentiated operation by operation, so that the matrix is as
    exact as the run.  Where stick begins the matrix loses a rank: neighbouring motions stick as well.
    In a run that starts in a mode with constraints (stick) only perturbations that keep them have a
    derivative; others are projected onto these first.  Where a run starts on the boundary of its mode (at
    rest on the belt) the derivative is that for neighbouring states inside.

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
        Where the derivative does not exist or is not known: at a grazing event, two events at one instant
        that neighbours meet one after the other, an accumulation of chatter or of impacts with friction that
        was closed, an end without admissible mode, or a run of another method.  The message says when and
        why.

    Examples
    --------
    >>> import frictionlab as fl
    >>> model = fl.SliderOnBelt(mu_k=1.4).without("geometry")
    >>> run = fl.simulate(model, 0.05, x0="near")
    >>> fl.tangent_flow(run).matrix.shape
    (8, 8)
    """
    check_taylor_run(run)
    check_flag("progress", progress)
    frame, matrices = carry_frame(run, initial_frame(run), progress)
    return TangentFlow(frame, run.events, np.array(matrices).reshape(-1, *frame.shape), run.names)


def initial_frame(run: Trajectory) -> np.ndarray:
    """The perturbations (n, n) that a run's first mode admits."""
    return admissible_frame(run, 0) if len(run.raw.step_modes) else np.eye(run.raw.state.size)


def admissible_frame(run: Trajectory, step: int) -> np.ndarray:
    """The perturbations (n, n) that are admitted where a step begins: the unit matrix projected onto the
    constraints of its mode."""
    program, numbers, raw = run.problem.program, run.problem.numbers, run.raw
    mode, z = int(raw.step_modes[step]), raw.step_states[step]
    return admissible_tangents(constraint_gradients(program, mode, linearise_mode(program, numbers, mode, z)))


def carry_frame(run: Trajectory, frame: np.ndarray, progress: bool) -> tuple[np.ndarray, list[np.ndarray]]:
    """Columns (n, m), tangent vectors at a run's start, propagated to its end; and the saltation matrices."""
    rows, matrices = np.ascontiguousarray(frame.T), []
    for part, event in progress_bar(list(smooth_segments(run)), desc="tangent flow", shown=progress):
        carry_rows(carry_steps, run, part, rows)
        if event is not None:
            saltation = event_saltation(run, event)
            matrices.append(saltation.matrix)
            rows = np.ascontiguousarray(saltation.carried(rows))
    return rows.T.copy(), matrices


def smooth_segments(run: Trajectory) -> Iterator[tuple[slice, int | None]]:
    """The steps of a run in slices short enough for ctrl-C, each with the event at its end."""
    starts = run.raw.step_times[:, 0]
    ends = [*np.searchsorted(starts, run.raw.event_times).tolist(), len(starts)]
    for i, (first, last) in enumerate(pairwise([0, *ends])):
        while last - first > RECORD_CAPACITY:
            yield slice(first, first + RECORD_CAPACITY), None
            first += RECORD_CAPACITY
        event = i if i < len(ends) - 1 else None
        yield slice(first, last if event is None or step_to_stop(run, event) is None else last - 1), event


def end_rates(run: Trajectory) -> tuple[np.ndarray, np.ndarray]:
    """Time derivative (n,) of the state at the start and at the end of a run that takes at least one step."""
    problem, raw = run.problem, run.raw
    ends = (int(raw.step_modes[0]), raw.step_states[0]), (raw.mode, raw.state)
    flow = problem.program.code.flow
    first, last = (
        linearise_mode(problem.program, problem.numbers, *end).jets[flow[end[0]], 0] for end in ends
    )
    return first, last


def check_taylor_run(run: Trajectory) -> None:
    """Raise for what is not a run, or is a run of a method whose events are not exact."""
    check_run(run)
    method = run.description.get("method", {}).get("name")
    if method != "taylor":
        raise ValueError(
            f"the tangent flow needs a run of method 'taylor', got {abbreviate(method)}: run it again so"
        )


def carry_rows(steps: Any, run: Trajectory, part: slice, rows: np.ndarray, *more: Growth) -> None:
    """Propagate the rows, tangent vectors, along a smooth segment of a run, by the kernel `steps`."""
    problem, raw, order = run.problem, run.raw, run.samples.order
    J = np.zeros((problem.program.slots, order + 1))
    scratch = TangentScratch(J, np.zeros((*J.shape, len(rows))))
    stored = StepData(raw.step_times[part], raw.step_modes[part], raw.step_states[part])
    truncation = Truncation(order, run.description["method"]["tol"])
    code = interpreted_code(problem.program)
    arguments = code, problem.numbers, truncation, stored, raw.state.copy(), rows, scratch
    with np.errstate(all="ignore"):
        failed = steps(*arguments, *more)
    if failed >= 0 or not np.isfinite(rows).all():
        t = raw.step_times[part.start + max(failed, 0), 0]
        raise SaltationError(f"the tangent flow overflows after t = {t:g} s: end the run earlier")


def entry_time(run: Trajectory, i: int, first: float) -> float:
    """When the mode that an event ends was entered; the run's own at the `first` time.

    That a phase began anew since then does not count.
    """
    raw, problem = run.raw, run.problem
    for k in range(i - 1, -1, -1):
        guard, target = (int(one) for one in raw.event_codes[k, :2])
        stays = target == problem.program.guard_modes[guard]
        if not stays or not changes_nothing(problem.program, problem.numbers, guard, raw.event_states[k, 0]):
            return float(raw.event_times[k])
    return first


def step_to_stop(run: Trajectory, i: int) -> int | None:
    """The step that ends by an event at which a norm comes to zero, and has no gradient; None for others.

    So short a step changes no tangent vector that the stop leaves.  Both are left out: the saltation is that
    at its start.
    """
    raw, program = run.raw, run.problem.program
    guard = int(raw.event_codes[i, 0])
    step = int(np.searchsorted(raw.step_times[:, 0], raw.event_times[i])) - 1
    if step < 0 or (i > 0 and not raw.event_times[i - 1] < raw.event_times[i]):
        return None
    about = interpreted_code(program), run.problem.numbers, int(program.guard_modes[guard])
    longest, J = raw.step_times[step, 1] / SHARE_OF_STOP, np.zeros((program.slots, STOP_ORDER + 1))
    stop = guard_at_stop(*about, longest, raw.step_states[step].copy(), J).guard
    return step if stop == guard else None


def event_saltation(run: Trajectory, i: int, first: float = 0.0) -> Saltation:
    """Saltation of an event of a run, by its number; the run's first mode was entered at the `first` time."""
    raw, problem = run.raw, run.problem
    t, (guard, target, closed) = raw.event_times[i], raw.event_codes[i]
    where = f"at t = {t:g} s ({run.events.source[i]} to {run.events.target[i] or 'no mode'})"
    if target < 0:
        raise SaltationError(f"no mode was admissible {where}: end the run before")
    before, after = raw.event_states[i]
    if (last := step_to_stop(run, i)) is not None:
        before = raw.step_states[last]
    dwell = float(t - entry_time(run, i, first))
    event = EventCrossing(int(guard), int(target), before, after, dwell)
    try:
        return saltation(problem.program, problem.numbers, event, bool(closed))
    except SaltationError as error:
        raise SaltationError(
            f"no tangent flow {where}: {error}; change the initial state, or end the run before"
        ) from None


class Growth(NamedTuple):
    """How tangent vectors grow."""

    size: np.ndarray  # (states,) the unit in which each component is measured
    sums: np.ndarray  # (directions,) sums of the logarithms of the growth factors


@kernel
def scaled_inner_product(a, b, size):
    """Inner product of two vectors, each component measured by its `size`."""
    total = 0.0
    for i in range(a.shape[0]):
        total += (a[i] / size[i]) * (b[i] / size[i])
    return total


@kernel
def orthonormalise(frame, growth):
    """Gram-Schmidt on the rows of `frame`; adds the logarithms of their lengths to ``growth.sums``."""
    size = growth.size
    for d in range(frame.shape[0]):
        for e in range(d):
            share = scaled_inner_product(frame[d], frame[e], size)
            for i in range(frame.shape[1]):
                frame[d, i] -= share * frame[e, i]
        length = math.sqrt(scaled_inner_product(frame[d], frame[d], size))
        growth.sums[d] += log(length)
        for i in range(frame.shape[1]):
            frame[d, i] /= length


@kernel
def carry_orthonormal_steps(code, numbers, truncation, steps, z, frame, scratch, growth):
    """Propagate the frame along the steps of a run; returns the index of the step that failed, or -1."""
    for i in range(steps.modes.shape[0]):
        copy_vector(steps.states[i], z)
        left = steps.times[i, 1]
        while left > 0.0:
            step = carry_step(code, numbers, truncation, steps.modes[i], left, z, frame, scratch)
            if not (step == left or step > MIN_TANGENT_STEP_SHARE * steps.times[i, 1]):
                return i
            orthonormalise(frame, growth)
            left -= step
    return -1


def tangent_growth(run: Trajectory, rows: np.ndarray, size: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The rows (m, n) propagated to the end of a run, orthonormal in units of `size` (n,), and their growth.

    The run goes on from another one.
    The growth (m,) is the logarithm of a factor: -inf where an event or a mode's constraints remove a
    direction.
    """
    growth, rows = np.zeros(len(rows)), rows.copy()
    for part, event in smooth_segments(run):
        constrained = _is_constrained(run, part)
        for some in [slice(i, i + 1) for i in range(part.start, part.stop)] if constrained else [part]:
            if constrained:  # each step: what leaves constraints by rounding would outgrow vectors that decay
                rows = _orthonormalise_anew(rows @ admissible_frame(run, some.start).T, size, growth)
            carry_rows(carry_orthonormal_steps, run, some, rows, Growth(size, growth))
        if event is not None:
            rows = _orthonormalise_anew(event_saltation(run, event, BEFORE_START).carried(rows), size, growth)
    return rows, growth


def _is_constrained(run: Trajectory, part: slice) -> bool:
    """Whether the mode of a segment has constraints."""
    modes = run.raw.step_modes[part]
    return len(modes) > 0 and bool(np.diff(run.problem.program.code.mode_constraints)[modes[0]])


def _orthonormalise_anew(rows: np.ndarray, size: np.ndarray, growth: np.ndarray) -> np.ndarray:
    """Orthonormalise rows some of which an event or constraints may have removed.

    Before that they were orthonormal, so their lengths are growth.  A vector that is removed has a growth of
    -inf, and an arbitrary one takes its place.
    """
    columns = (rows / size).T
    frame, upper = np.linalg.qr(columns)
    left, lengths = np.abs(np.diag(upper)), np.linalg.norm(columns, axis=0)
    with np.errstate(divide="ignore"):
        growth += np.log(np.where(left > LOST_SHARE * np.maximum(lengths, 1.0), left, 0.0))
    return np.ascontiguousarray(frame.T * size)
