"""Whether a run keeps the conditions of its modes, judged by their values alone, without another run.

Nothing of the search for events is used: guards are bounded all over the run, and constraints computed, so
that an event that all methods step over alike is seen.  At an event that begins stick, the reset may remove
rounding errors only.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionlab.analysis.motion_scales import motion_size, state_groups, state_ranges
from frictionlab.hybrid.accuracy import RESIDUAL_ROUNDING, largest_sound_defect
from frictionlab.hybrid.codegen.native_cache import native_code
from frictionlab.hybrid.guard_bounds import (
    Array,
    Negative,
    Pieces,
    Tape,
    largest_defect,
    negative_points,
    pieces_of,
)
from frictionlab.hybrid.kernels.run_state import StepData, jet_columns
from frictionlab.hybrid.kernels.taylor_steps import sample_states
from frictionlab.hybrid.methods.taylor import Taylor
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.hybrid.variational.tangent_flow import step_to_stop
from frictionlab.presentation import count

MOST_STEPS, PIECES_AT_ONCE = 20_000, 1000
HALVINGS = 30  # by which the time of a violation is found
SAMPLES_OF_SIZES, SAMPLES_OF_ROUNDING = 2000, 500
VIOLATION_WITHOUT_TOLERANCE = 1e-6  # share of a condition's size, for methods whose tolerance is not known
ROUNDING_MARGIN = 10.0  # times the rounding errors of a state: what moves less is at rest
SMALL_BESIDE_OTHERS = 1e-9  # share of the largest range in a group of states
STICK_GUARD = "v_r"  # begins the names of the guards whose event makes a relative velocity zero


def broken_condition(run: Trajectory) -> str:
    """Which condition a run breaks, and where; an empty text where it keeps them all."""
    limit = largest_violation(run)
    return _broken_guard(run, limit) or _broken_reset(run, limit) or _broken_flow(run, limit)


def unjudged_steps(run: Trajectory) -> str:
    """How many steps conditions were looked at in, where these are not all; an empty text else."""
    begins, lengths = run.raw.step_times.T
    judged, every = len(_chosen_steps(run)), int((begins + lengths > begins).sum())
    text = f"Event functions were bounded in {judged} of {every} steps." if judged < every else ""
    stops = len(steps_to_stops(run)) if is_of_series(run) else 0
    left_out = f"Rates were not compared in {count(stops, 'step')} to stops in the plane." if stops else ""
    return " ".join(filter(None, [text, left_out]))


def is_of_series(run: Trajectory) -> bool:
    """Whether a run's dense output is a series, so that it reaches across each step."""
    return run.description["method"]["name"] == Taylor.name


def largest_violation(run: Trajectory) -> float:
    """The share of a condition's size by which a sound run may break it."""
    if not is_of_series(run):
        return VIOLATION_WITHOUT_TOLERANCE
    return largest_sound_defect(run.description["method"]["tol"])


def judged_size(run: Trajectory) -> Array:
    """Size of a motion in each state, by which conditions are judged.

    Bodies at rest on several contacts have velocities of 1e-16 m/s, which are no motion.
    """
    return np.maximum(motion_size(run), _sizes_of_rounding(run))


def _sizes_of_rounding(run: Trajectory) -> Array:
    """Sizes of the states that move by no more than rounding errors of the rates, summed over the run.

    Of such a size these errors are the share by which a condition may be broken.  Those of other states are
    zero, as a motion is judged by its own size.
    """
    rounding = _rounding_of_rates(run)
    only_rounding = state_ranges(run.states) <= ROUNDING_MARGIN * rounding
    return np.where(only_rounding, rounding / largest_violation(run), 0.0)


def moved_by_rounding(run: Trajectory) -> NDArray[np.bool_]:
    """The states (n,) that but rounding moves, beside others of their group or together with all of it, as
    the height of a body that slides on two feet: coordinates together with their velocities."""
    n = run.automaton.coordinates
    # errors of other methods are not rounding
    if not is_of_series(run) or not n:
        return np.zeros(len(run.names), dtype=bool)
    # within steps too: at the events of dry friction all velocities may be zero
    t = np.linspace(0.0, run.raw.t, SAMPLES_OF_ROUNDING)
    ranges = state_ranges(np.vstack([run(t), run.raw.step_states[:, : len(run.names)]]))
    small, rounding = np.zeros(len(run.names), dtype=bool), _rounding_of_rates(run)
    for group in state_groups(n):  # contacts that hold a body still leave rounding errors of all forces on it
        largest = ranges[group].max(initial=0.0)
        rounding[group] = rounding[group].max(initial=0.0)
        moves = largest > 0.0  # what stays as it is was moved by nothing, and has its own size
        small[group] = moves & (
            (ranges[group] <= SMALL_BESIDE_OTHERS * largest) | (largest <= rounding[group])
        )
    still = small & (ranges <= rounding)
    still[:n] = still[n : 2 * n] = still[:n] & still[n : 2 * n]
    return still


def _rounding_of_rates(run: Trajectory) -> Array:
    """What rounding errors of the rates, summed over the run, change in each state (n,).

    In steps to stops in the plane rates grow for an instant: these are left out.
    """
    n = run.automaton.coordinates
    t = np.linspace(0.0, run.raw.t, SAMPLES_OF_ROUNDING)
    steps = np.searchsorted(run.raw.step_times[:, 0], t, side="right") - 1
    states, modes = run.states_and_modes(t[~np.isin(steps, steps_to_stops(run))])
    rates = np.zeros_like(states)
    for mode in np.unique(modes):
        tape, here = Tape(run.problem.program.code, run.problem.numbers, int(mode)), modes == mode
        with np.errstate(all="ignore"):
            rates[here] = tape.magnitudes(states[here], tape.flow)
    finite = np.isfinite(rates)
    mean = np.where(finite, rates, 0.0).sum(axis=0) / np.maximum(finite.sum(axis=0), 1)
    rounding = RESIDUAL_ROUNDING * run.raw.t * mean
    rounding[:n] = rounding[n : 2 * n] * run.raw.t
    return rounding


def steps_to_stops(run: Trajectory) -> Array:
    """The steps that end by a stop of friction in the plane, over which accelerations count as constant."""
    program = run.problem.program
    # a norm has a root
    may_be = program.code.powers[program.guard_modes[run.raw.event_codes[:, 0]]]
    last = (step_to_stop(run, int(i)) for i in np.flatnonzero(may_be))
    return np.array([step for step in last if step is not None], dtype=int)


def evenly_spread(count: int, most: int) -> Array:
    """Indices below `count`, evenly spread, at most so many."""
    return np.unique(np.linspace(0, count - 1, most).astype(int))


def _broken_guard(run: Trajectory, limit: float) -> str:
    first, words, worst = np.inf, "", 0.0
    least = _sizes_of_rounding(run)
    anywhere = _states_of_steps(run, np.arange(len(run.raw.step_modes)))
    for mode, steps in _steps_by_mode(run):
        tape = Tape(run.problem.program.code, run.problem.numbers, mode)
        if not tape.functions:
            continue
        sizes = tape.sizes(np.vstack([anywhere, _states_of_steps(run, steps)]), least=least)
        bounds = np.where(sizes > 0.0, -limit * sizes, -np.inf)
        for some in _at_once(steps):
            bad = negative_points(tape, _pieces(run, some), bounds)
            if not len(bad.times):
                continue
            worst = max(worst, float((np.abs(bad.values) / sizes[bad.functions]).max()))
            k = int(bad.times.argmin())
            if bad.times[k] < first:
                first = _beginning(run, tape, bounds, bad, k)
                words = _name_of_function(run, mode, int(bad.functions[k]))
    if not words:
        return ""
    return (
        f"{words}: at t = {first:.6g} s its function is beyond zero, "
        f"in the worst case by {worst:.1g} of its size"
    )


def _beginning(run: Trajectory, tape: Tape, bounds: Array, bad: Negative, k: int) -> float:
    """The time at which a function that is broken at a point of a piece begins to be."""
    sound, broken, function = float(bad.starts[k]), float(bad.times[k]), bad.functions[k]
    for _ in range(HALVINGS):
        middle = 0.5 * (sound + broken)
        value = tape.values(run(middle)[None])[0, function]
        amount = value if function < len(tape.guards) else -abs(value)
        sound, broken = (middle, broken) if amount >= bounds[function] else (sound, middle)
    return broken


def _name_of_function(run: Trajectory, number: int, function: int) -> str:
    mode = run.automaton.mode(run.mode_names[number])
    missed = [f"event {event.name!r} of mode {mode.name!r} is missed" for event in mode.events]
    return [*missed, *(f"a constraint of mode {mode.name!r} is broken" for _ in mode.constraints)][function]


def _chosen_steps(run: Trajectory) -> Array:
    """All steps that advance; of too many the longest, in which most can be missed, and others all over."""
    begins, lengths = run.raw.step_times.T
    steps = np.flatnonzero(begins + lengths > begins)
    if len(steps) <= MOST_STEPS:
        return steps
    longest = steps[np.argsort(-lengths[steps], kind="stable")[: MOST_STEPS // 2]]
    return np.union1d(longest, steps[evenly_spread(len(steps), MOST_STEPS // 2)])


def _steps_by_mode(run: Trajectory) -> Iterator[tuple[int, Array]]:
    """The modes in which steps are looked at, and the steps in each."""
    steps, modes = _chosen_steps(run), run.raw.step_modes
    for mode in np.unique(modes[steps]):
        yield int(mode), steps[modes[steps] == mode]


def _at_once(steps: Array) -> list[Array]:
    """Steps in parts that are looked at together."""
    return np.array_split(steps, -(-len(steps) // PIECES_AT_ONCE))


def _states_of_steps(run: Trajectory, steps: Array) -> Array:
    """States at the start and in the middle of some of the steps, evenly spread.

    The starts alone would not tell sizes: a gap may be zero at each of them, as that of a ball whose flights
    are one step each.
    """
    some = steps[evenly_spread(len(steps), SAMPLES_OF_SIZES)]
    begins, lengths = run.raw.step_times[some].T
    return np.vstack([run.raw.step_states[some], run(begins + 0.5 * lengths)])


def _pieces(run: Trajectory, steps: Array) -> Pieces:
    """The steps as pieces; of other methods than series their starts, as their dense output need not reach
    across a step."""
    raw, program, order = run.raw, run.problem.program, run.samples.order
    begins, lengths = raw.step_times[steps].T
    if not is_of_series(run):
        return Pieces(begins, 0.0 * lengths, raw.step_states[steps][:, None])
    # By times from the starts of the steps: the rounding of the clock would spoil slopes.
    local = np.column_stack([0.0 * lengths, lengths])
    stored = StepData(local, raw.step_modes[steps], raw.step_states[steps])
    code, jets = native_code(program).code, np.zeros((program.slots, jet_columns(order)))

    def states(times: Array) -> Array:
        which, out = np.repeat(np.arange(len(steps)), order + 1), np.empty((len(times), raw.state.size))
        sample_states(code, run.problem.numbers, order, stored, which, times, out, jets)
        return out

    return pieces_of(0.0 * begins, lengths, order, states)._replace(starts=begins)


def _broken_reset(run: Trajectory, limit: float) -> str:
    events, n = run.events, run.automaton.coordinates
    begins_stick = np.array([name.startswith(STICK_GUARD) for name in events.guard], dtype=bool)
    jumps: Any = np.abs(events.state - events.before)[:, n : 2 * n] / judged_size(run)[n : 2 * n]
    broken = np.flatnonzero(begins_stick & ~(jumps.max(axis=1, initial=0.0) <= limit))
    if not len(broken):
        return ""
    first = broken[0]
    return (
        f"at t = {events.t[first]:.6g} s the reset of event {str(events.guard[first])!r} takes away "
        f"{jumps[first].max():.1g} of the velocities, more than rounding"
    )


def _broken_flow(run: Trajectory, limit: float) -> str:
    """Where a run is no motion of its modes' equations; only of series, whose dense output is one."""
    if not is_of_series(run):
        return ""
    sizes = judged_size(run)
    for mode, steps in _steps_by_mode(run):
        tape = Tape(run.problem.program.code, run.problem.numbers, mode)
        for some in _at_once(np.setdiff1d(steps, steps_to_stops(run))):
            defect = largest_defect(tape, _pieces(run, some), sizes)
            if defect.share > limit:
                return (
                    f"at t = {defect.time:.6g} s a step in mode {run.mode_names[mode]!r} does not keep the "
                    f"rate of {run.names[defect.state]!r}, by {defect.share:.1g} of the motion's size: a law "
                    "may be too sharp there for its series"
                )
    return ""
