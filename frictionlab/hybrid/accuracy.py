"""How exact a run is: the defect of its steps.

Between two stored states a run is a polynomial in time, its dense output.  Put into the equations, it leaves
a residual x' - f(x).  If a method other than the series computed the next state, there is also a jump from
the end of the polynomial to that state.  A step adds to the error the residual times its length, or the jump
if that is larger.  As a share of the motion's size this is its defect, which compares with the tolerance.

Every run by series is checked when it is over.  The defects of a few of its steps are measured; those that
the tolerance does not allow give a warning.  So do flights that were replaced by the limit of chatter and are
not short.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from frictionlab.compilation.decorators import inlined, kernel
from frictionlab.hybrid.codegen.native_cache import native_code
from frictionlab.hybrid.kernels.jets import (
    MACHINE_EPSILON,
    majorant,
    mode_jets,
    polynomial_slope,
    states_at,
)
from frictionlab.hybrid.kernels.run_state import jet_columns
from frictionlab.hybrid.kernels.taylor_steps import step_series
from frictionlab.hybrid.problem import Problem, RunData
from frictionlab.presentation import FrozenMapping
from frictionlab.tape.elementary.trigonometry import cos

CHECK_POINTS = 8  # points in a step, zeros of a Chebyshev polynomial: dense towards its ends
# Errors up to this share of a sum's absolute terms may be rounding, and do not count as a defect.
RESIDUAL_ROUNDING = 8 * MACHINE_EPSILON
UNKNOWN_END = np.nan  # end of a step without advance of time: its event cannot be told from an earlier one
SUSPECT_TOLERANCES = 1e4  # times the tolerance: the defects of sound steps are hundreds of times smaller
HARMLESS_DEFECT = 1e-9  # share of the motion's size: smaller than any analysis here resolves
SAMPLED_SHARE = 0.01  # share of a mode's steps whose defect is measured in every run, within the next two
LEAST_SAMPLE, LARGEST_SAMPLE = 8, 64
SHORT_SHARE = 1 / 32  # of the longest stay; what replaced flights leave out goes with the square of theirs
ALL_STEPS = slice(None)


class StoredSteps(NamedTuple):
    """Steps of a run, and the sizes to which their errors are relative."""

    times: np.ndarray  # (steps, 2) start and length
    modes: np.ndarray  # (steps,)
    states: np.ndarray  # (steps, states) at the start
    ends: np.ndarray  # (steps, states) at the end, before an event
    sizes: np.ndarray  # (steps, states) least sizes; larger states in the step take their place


class DefectScratch(NamedTuple):
    """Scratch arrays."""

    jets: np.ndarray  # series
    values: np.ndarray
    bounds: np.ndarray  # majorants of values
    z: np.ndarray  # a state
    sums: np.ndarray  # of its absolute terms
    errors: np.ndarray  # the largest error of each state in the step
    sizes: np.ndarray  # the largest value of each state in the step


def defects(problem: Problem, raw: RunData, order: int) -> Mapping[str, float]:
    """The largest defect of a run's steps, by the name of the mode."""
    return FrozenMapping(_largest_defects(problem, stored_steps(raw), order))


def _largest_defects(
    problem: Problem, steps: StoredSteps, order: int, above: float = -1.0
) -> dict[str, float]:
    """The largest defect of steps, by the name of the mode, of modes in which it is above a value."""
    program = problem.program
    worst = np.full(len(program.modes), above)
    system = native_code(program).system(problem.numbers)
    scratch = new_defect_scratch(program.slots, steps.states.shape[1], order)
    with np.errstate(all="ignore"):
        measure_defects(system, order, steps, worst, scratch)
    by_mode = zip(program.modes, worst.tolist())
    return {name: defect for name, defect in by_mode if not defect <= above}


def defect_warning(
    problem: Problem, raw: RunData, order: int, tol: float, steps: np.ndarray | slice = ALL_STEPS
) -> str | None:
    """A warning if the defect of one of the `steps` is too large for the tolerance `tol`, else None.

    Here a defect is a share of the motion's size in the whole run.  That is first taken for the size in these
    steps alone, which is at most as large: nearly always it shows that all is well.
    """
    times, modes, states = raw.step_times[steps], raw.step_modes[steps], raw.step_states[steps]
    if not len(modes):
        return None
    ends = np.full_like(states, UNKNOWN_END)  # that of a series is the next state
    bad: dict[str, float] = {}
    for motion in (states, raw.step_states):
        sizes = np.tile(np.abs(motion).max(axis=0), (len(states), 1))
        stored = StoredSteps(times, modes, states, ends, sizes)
        bad = _largest_defects(problem, stored, order, largest_sound_defect(tol))
        if not bad:
            return None
    worst = max(bad, key=bad.__getitem__)
    return (
        f"steps in mode {worst!r} are wrong by up to {bad[worst]:.1g} of the motion's size, "
        f"{bad[worst] / tol:.0e} times the tolerance: a law may be too sharp there for its series"
    )


def chatter_warning(raw: RunData, limit: float) -> str | None:
    """A warning where flights below the `limit` of chatter (s) were replaced though no stay is much longer,
    as in a model whose unit of time is a week; else None."""
    longest = np.diff(raw.event_times, prepend=0.0, append=raw.t).max()
    if limit <= SHORT_SHARE * longest:
        return None
    return (
        f"flights below {limit:.3g} s were replaced by the limit of chatter, which is not short beside the "
        f"longest stay in a mode, {longest:.3g} s: give the method a limit that is, such as "
        f"chatter={SHORT_SHARE * SHORT_SHARE * longest:.1g}"
    )


def sampled_steps(raw: RunData, modes: np.ndarray) -> np.ndarray:
    """The numbers of some steps of each of some modes, a bounded number."""
    return np.concatenate([_sample_of_steps(raw, np.flatnonzero(raw.step_modes == mode)) for mode in modes])


def _sample_of_steps(raw: RunData, steps: np.ndarray) -> np.ndarray:
    """Some of the `steps` of one mode: the longest, the last before events, and others all over the run."""
    if len(steps) <= LEAST_SAMPLE:
        return steps
    size = min(max(LEAST_SAMPLE, int(SAMPLED_SHARE * len(steps))), LARGEST_SAMPLE)
    lengths = raw.step_times[steps, 1]
    longest = steps[np.argpartition(-lengths, size // 4)[: size // 4]]
    last = steps[np.append(np.diff(steps) > 1, True)]
    others = np.linspace(0, len(steps) - 1, size - size // 4 - size // 4).astype(int)
    return np.unique(np.concatenate([longest, _spread(last, size // 4), steps[others]]))


def _spread(steps: np.ndarray, count: int) -> np.ndarray:
    """So many of the steps, evenly spread."""
    return steps[np.unique(np.linspace(0, len(steps) - 1, count).astype(int))]


def largest_sound_defect(tol: float) -> float:
    """The defect above which steps of a run with the tolerance `tol` are suspect."""
    return max(SUSPECT_TOLERANCES * tol, HARMLESS_DEFECT)


def stored_steps(raw: RunData) -> StoredSteps:
    """The steps with the states at their ends: the next stored state, or the state before the event there."""
    times = np.append(raw.step_times[1:, 0], raw.t)[: len(raw.step_times)]
    ends = np.concatenate([raw.step_states[1:], raw.state[None]])[: len(times)]
    first = np.searchsorted(raw.event_times, times)
    at_event = np.append(raw.event_times, np.inf)[first] == times
    ends[at_event] = raw.event_states[first[at_event], 0]
    ends[at_event & (raw.step_times[:, 0] == times)] = UNKNOWN_END
    return StoredSteps(raw.step_times, raw.step_modes, raw.step_states, ends, np.zeros_like(ends))


def new_defect_scratch(slots: int, states: int, order: int) -> DefectScratch:
    """Empty scratch arrays for :func:`measure_defects`."""
    series, values, bounds = (np.zeros((slots, jet_columns(k))) for k in (order, 0, 0))
    return DefectScratch(series, values, bounds, *np.zeros((4, states)))


@kernel
def measure_defects(system, order, steps, worst, scratch):
    """Write the largest defect of each mode's steps into `worst`.

    A step to a stop is left out.  In it the direction of the friction force is not defined, and the velocity
    that is left is set to zero at its end.
    """
    for step in range(steps.modes.shape[0]):
        mode, now, h = steps.modes[step], steps.times[step, 0], steps.times[step, 1]
        if h > 0.0 and begin_step(
            system, order, mode, now, h, steps.states[step], steps.sizes[step], scratch
        ):
            for point in range(CHECK_POINTS):
                s = 0.5 * h * (1.0 - cos(math.pi * (point + 0.5) / CHECK_POINTS))
                record_residuals(system, order, mode, s, worst[mode] / h, scratch)
            for i in range(scratch.errors.shape[0]):
                scratch.errors[i] *= h
            record_jump(system, order, mode, h, steps.ends[step], scratch)
            worst[mode] = max(worst[mode], relative_defect(system.code, scratch))


@kernel
def begin_step(system, order, mode, now, h, state, sizes, scratch):
    """Compute the series of a step, and set its errors to zero; returns whether it does not lead to a stop.

    The sizes are set to those at its start, or to the given ones where these are larger.
    """
    stops = step_series(system.code, system.numbers, mode, order, now, h, state, scratch.jets)
    for i in range(state.shape[0]):
        scratch.errors[i], scratch.sizes[i] = 0.0, max(sizes[i], abs(state[i]))
    return not stops


@inlined
def polynomial_magnitude(c, n, s):
    """Sum of the absolute terms of a polynomial at s > 0."""
    total = abs(c[n])
    for k in range(n - 1, -1, -1):
        total = total * s + abs(c[k])
    return total


@inlined
def slope_magnitude(c, n, s):
    """Sum of the absolute terms of a polynomial's derivative at s > 0."""
    total = n * abs(c[n])
    for k in range(n - 1, 0, -1):
        total = total * s + k * abs(c[k])
    return total


@inlined
def larger_or_infinite(error, worst):
    """The larger of the two; infinite where the error is NaN."""
    if error <= worst:
        return worst
    return error if error == error else math.inf


@kernel
def compute_states(order, s, scratch):
    """Compute the states at time `s` of a step; update the sizes."""
    states_at(scratch.jets, order, s, scratch.z)
    for i in range(scratch.z.shape[0]):
        scratch.sizes[i] = max(scratch.sizes[i], abs(scratch.z[i]))


@kernel
def compute_sums(order, s, scratch):
    """Compute the sums of the absolute terms of the states at time `s` of a step."""
    for i in range(scratch.z.shape[0]):
        scratch.sums[i] = polynomial_magnitude(scratch.jets[i], order, s)


@kernel
def has_residual_above(code, order, mode, s, share, scratch):
    """Whether |x' - f(x)| is above a share of the largest state of its group."""
    for group in range(3):
        size = 0.0
        for i in range(code.groups[group], code.groups[group + 1]):
            size = max(size, scratch.sizes[i])
        for i in range(code.groups[group], code.groups[group + 1]):
            slope = polynomial_slope(scratch.jets[i], order, s)
            residual = abs(slope - scratch.values[code.flow[mode, i], 0])
            if not (residual < math.inf and residual <= share * size):
                return True
    return False


@kernel
def record_residuals(system, order, mode, s, share, scratch):
    """Record |x' - f(x)| at time `s` of a step, less what rounding explains, if any is above a share.

    The rounding errors take as long as all the rest.  They do not matter if no residual is above the share of
    the largest state of its group by which the worst one was until now.
    """
    code = system.code
    compute_states(order, s, scratch)
    mode_jets(code, system.numbers, mode, 0, scratch.z, scratch.values)
    if not has_residual_above(code, order, mode, s, share, scratch):
        return
    compute_sums(order, s, scratch)
    majorant(code, system.magnitudes, mode, 0, scratch.sums, scratch.values, scratch.bounds)
    for i in range(scratch.z.shape[0]):
        slot, c = code.flow[mode, i], scratch.jets[i]
        residual = abs(polynomial_slope(c, order, s) - scratch.values[slot, 0])
        rounding = RESIDUAL_ROUNDING * (scratch.bounds[slot, 0] + slope_magnitude(c, order, s))
        scratch.errors[i] = larger_or_infinite(residual - rounding, scratch.errors[i])


@inlined
def is_unknown(end):
    """Whether a state is that of an end which is not known."""
    known = 0
    for i in range(end.shape[0]):
        if end[i] == end[i]:
            known += 1
    return known == 0


@kernel
def record_jump(system, order, mode, h, end, scratch):
    """Record the jump from the end of the polynomial to the next state, less what rounding explains.

    The end is all NaN if it is not known.
    """
    code = system.code
    compute_states(order, h, scratch)
    if is_unknown(end):
        return
    compute_sums(order, h, scratch)
    mode_jets(code, system.numbers, mode, 0, scratch.z, scratch.values)
    majorant(code, system.magnitudes, mode, 0, scratch.sums, scratch.values, scratch.bounds)
    for i in range(scratch.z.shape[0]):
        rounding = RESIDUAL_ROUNDING * (scratch.sums[i] + h * scratch.bounds[code.flow[mode, i], 0])
        scratch.errors[i] = larger_or_infinite(abs(end[i] - scratch.z[i]) - rounding, scratch.errors[i])


@kernel
def relative_defect(code, scratch):
    """The largest error as a share of the largest state of its group: coordinates, velocities, others."""
    worst = 0.0
    for group in range(3):
        error = size = 0.0
        for i in range(code.groups[group], code.groups[group + 1]):
            error, size = max(error, scratch.errors[i]), max(size, scratch.sizes[i])
        if error > 0.0:
            worst = larger_or_infinite(error / size, worst)
    return worst
