"""The kind of motion in a run: equilibrium, periodic, non-periodic, or not settled yet.

Recurrence is checked first: the shortest period after which the whole state at a section repeats.  A motion
that does not repeat is checked for trends: crossings that drift one way, an amplitude that doubles or halves,
and slow decay.  Slow decay is found from the linear map from sample to sample (dynamic mode decomposition).
Near an equilibrium, or a periodic motion, what is left of the transient follows such a map.  Its part along
each eigenvector shrinks in every step, even while the coordinates beat.  Source: P. J. Schmid, "Dynamic mode
decomposition of numerical and experimental data", J. Fluid Mechanics 656 (2010) 5-28.

A motion that turns for ever, or whose place grows, settles to none of these.  It is judged again modulo the
shift on which nothing depends, see `drift`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionlab.analysis.motion_scales import AT_REST_RTOL, Array, state_ranges
from frictionlab.analysis.run_conditions import moved_by_rounding
from frictionlab.analysis.steady_state.drift import TREND_PARTS, Drift, drift_of
from frictionlab.analysis.steady_state.poincare_sections import (
    STICK,
    Section,
    contacts_that_stick,
    covers_period,
    only_phase_resets,
    phase_on_circle,
    phase_returns,
    returns_without_coordinates,
    section_crossings,
    stick_onsets,
    turning_section,
)
from frictionlab.hybrid.run_events import SectionPoints
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.presentation import Kind

MIN_PERIODS_SEEN = 3  # periods that the window has to contain at least
AT_ONCE_SHARE = 1e-3  # of the longest time between crossings: one that follows sooner is no other crossing
MAX_LAG = 500  # largest number of crossings in a period
SHORTER_PERIOD = 0.75  # share of a period: periods of one motion are multiples of the shortest
NEAR_RECURRENCE_RTOL = 1e-3
# factor from each third of the window to the next by which the deviation shrinks where the motion still
# settles
MIN_SETTLING_FACTOR = 1.5
# with fewer crossings a motion that does not repeat may still turn out to do so, or to drift
MIN_CROSSINGS = TREND_PARTS * MIN_PERIODS_SEEN

# share of the largest singular value below which a direction in the samples is due to rounding
SAMPLE_RANK_RTOL = 1e-10
# Rows of a block, small enough for numpy to compute in one thread.  For the whole matrix it starts threads of
# its own, which compete with a sweep's: two values side by side took longer than one after the other.
ROWS = 64
MIN_LOSS_SHARE = 1e-9  # share of the motion's square that a decaying part has to lose
# least rate of decay, as a share of the largest, where events between samples disturb the linear map
MIN_RATE_RATIO = 0.5
# the same for single parts that all decay to zero; towards a cycle, decay becomes ever slower
SINGLE_RATE_RATIO = 0.99
SIGNIFICANT_SHARE = 1e-6  # share of the motion's square above which a part of it has to decay as well
REST_AMPLITUDE_RTOL = 1e-3  # a decaying motion smaller than this share of the coordinates counts as at rest
ABOUT_ZERO = 0.25  # share of its range up to which the mean of a motion about zero may differ from that
MIN_DECAY_FACTOR = 1.4  # by which factor it has to shrink from the first quarter of the window to the last
EVEN_SAMPLES = 8001


class Recurrence(NamedTuple):
    """How nearly a motion returns to where it was `lag` crossings of a section before.

    Parameters
    ----------
    lag : int
        Crossings in a period; 0 where there are too few to tell.
    period : float
        Mean time of `lag` crossings in s, over the second half of all crossings; NaN where `lag` is 0.
    deviation : float
        The larger of two deviations over the second half of the crossings.  One is the largest difference
        between the state and that one period before, as a share of the motion's size.  The other compares the
        times between such states: their largest difference from the last one, as a share of the longest.
    shrinking : float
        Least factor by which the deviation shrinks from each third of the crossings to the next: large where
        the motion still settles.
    """

    lag: int
    period: float
    deviation: float
    shrinking: float


NO_RECURRENCE = Recurrence(0, np.nan, np.inf, 1.0)


def find_recurrence(t: Array, states: Array, size: Array, tolerance: float) -> Recurrence:
    """The recurrence at the shortest lag at which the motion repeats; else at the lag of least deviation.

    To repeat it has to return within the tolerance, or nearly so and ever more closely.

    Parameters
    ----------
    t, states : array (K,), (K, m)
        Crossings of a section.
    size : array (m,)
        Size of the motion in each state; differences are measured by it.
    tolerance : float
    """
    shares = states / np.where(size > 0, size, 1.0)
    lags = range(1, min(len(t) // MIN_PERIODS_SEEN, MAX_LAG) + 1)
    recurrences: list[Recurrence] = []
    for lag in lags:
        recurrences.append(_recurrence_at_lag(t, shares, lag))
        if is_periodic(recurrences[-1], tolerance):
            # A motion that spirals inwards first repeats within the tolerance at a long lag, but its
            # deviation at a shorter one decays too.
            return next((r for r in recurrences if r.shrinking > MIN_SETTLING_FACTOR), recurrences[-1])
    return min(recurrences, key=lambda r: r.deviation, default=NO_RECURRENCE)


def is_periodic(recurrence: Recurrence, tolerance: float) -> bool:
    """Whether a motion is periodic, or close to a periodic one and approaching it."""
    return recurrence.deviation < tolerance or (
        recurrence.deviation < NEAR_RECURRENCE_RTOL and recurrence.shrinking > MIN_SETTLING_FACTOR
    )


def is_near(recurrence: Recurrence) -> bool:
    """Whether a motion that is not periodic may be on its way to a periodic one."""
    return recurrence.deviation < NEAR_RECURRENCE_RTOL or recurrence.shrinking > MIN_SETTLING_FACTOR


def _recurrence_at_lag(t: Array, states: Array, lag: int) -> Recurrence:
    differences = np.maximum(
        np.abs(states[lag:] - states[:-lag]).max(axis=1), _time_deviations(t[lag:] - t[:-lag])
    )
    half = min(len(differences) // 2, len(differences) - 2)  # two at least, as the last is the reference
    count = (len(t) - 1 - half) // lag
    period = float(t[-1] - t[-1 - count * lag]) / count
    return Recurrence(lag, period, float(differences[half:].max()), _settling_factor(differences))


def _time_deviations(times: Array) -> Array:
    """Differences of the times between returns from the last of them, as shares of the longest.

    Where a section is only touched, some returns are missed or counted twice: the state is the same at each
    crossing, but the times between differ.
    """
    longest = times.max()
    return np.abs(times - times[-1]) / longest if longest > 0.0 else np.ones(len(times))


def _settling_factor(differences: Array) -> float:
    first, second, third = (part.max(initial=0.0) for part in np.array_split(differences, 3))
    if second == 0.0 or third == 0.0:
        return np.inf
    return float(min(first / second, second / third))


def crossings_drift(states: Array, size: Array) -> bool:
    """Whether a motion that does not repeat still drifts.

    It does if the mean of its crossings of a section, or their scatter, changes in one direction throughout.

    Parameters
    ----------
    states : array (K, m)
        Crossings of a section.
    size : array (m,)
        Size of the motion in each state.
    """
    if len(states) < MIN_CROSSINGS:
        return False
    parts = np.array_split(states / np.where(size > 0, size, 1.0), TREND_PARTS)
    course = [[*part.mean(axis=0), part.std(axis=0).sum()] for part in parts]
    steps: Array = np.asarray(np.diff(np.array(course, dtype=float), axis=0), dtype=float)
    return bool(((steps > 0).all(axis=0) | (steps < 0).all(axis=0)).any())


def amplitude_changes(states: Array) -> bool:
    """Whether a motion's size in most states doubles, or halves, between its first and its last quarter."""
    parts = np.array_split(states, 4)
    if not len(parts[-1]):
        return False
    first, last = state_ranges(parts[0]), state_ranges(parts[-1])
    moving = np.minimum(first, last) > 0
    return bool(moving.any() and abs(np.log2(np.median(last[moving] / first[moving]))) > 1)


class EigenvectorSquares(NamedTuple):
    """Mean squares (TREND_PARTS, k) of the motion along k eigenvectors, and which of them the map shrinks."""

    squares: Array
    inside: NDArray[np.bool_]

    @property
    def whole(self) -> float:
        """The largest sum of squares over all eigenvectors."""
        return float(self.squares.sum(axis=1).max())


def part_decays(samples: Array, size: Array, *, evenly: bool = False) -> bool:
    """Whether the shrinking part of a motion decays throughout, or its growing part grows throughout.

    Parameters
    ----------
    samples : array (N, m)
        States at even times, or at the crossings of a section.
    size : array (m,)
        Size of the motion in each state.
    evenly : bool
        Whether the rate has to be about constant: beats of a motion with events may look like decay for a
        while.
    """
    parts = _eigenvector_squares(samples, size)
    if parts is None:
        return False
    least, share = MIN_LOSS_SHARE * parts.whole, MIN_RATE_RATIO * evenly
    shrinking, growing = (parts.squares[:, some].sum(axis=1) for some in (parts.inside, ~parts.inside))
    return _decreases(shrinking, least, share) or _decreases(growing[::-1], least, share)


def all_parts_decay(samples: Array, size: Array) -> bool:
    """Whether all parts of a motion decay, each at a constant rate of its own."""
    parts = _eigenvector_squares(samples, size)
    if parts is None:
        return False
    notable = parts.squares.T[parts.squares.max(axis=0) > SIGNIFICANT_SHARE * parts.whole]
    return all(_decreases(course, MIN_LOSS_SHARE * parts.whole, SINGLE_RATE_RATIO) for course in notable)


def _decreases(course: Array, least: float, share: float) -> bool:
    if not (np.diff(course) < 0.0).all() or course[0] - course[-1] <= least:
        return False
    rates = -np.diff(np.log(course))
    return bool(rates.min() > share * rates.max())


def _eigenvector_squares(samples: Array, size: Array) -> EigenvectorSquares | None:
    """The motion's squares along the eigenvectors of its linear map; None where samples are too few."""
    steps = np.diff(samples / np.where(size > 0, size, 1.0), axis=0)
    if len(steps) < TREND_PARTS:
        return None
    _, spread, directions = np.linalg.svd(_triangle(_triangle(steps)), full_matrices=False)
    significant = spread > SAMPLE_RANK_RTOL * spread[0]
    spread, directions = spread[significant], directions[significant]
    if not len(spread) or len(steps) <= 2 * len(spread):
        return None
    shares = _product(steps, directions.T / spread)
    first, later = _in_blocks(shares[:-1]), _in_blocks(shares[1:])
    squares, products = ((first.transpose(0, 2, 1) @ other).sum(axis=0) for other in (first, later))
    factors, modes = np.linalg.eig(np.linalg.solve(squares, products))  # the columns are nearly orthonormal
    lengths = (np.abs(np.linalg.pinv(modes) * spread) ** 2).sum(axis=1)
    parts = np.array_split(np.abs(_product(shares, modes)) ** 2 * lengths, TREND_PARTS)
    return EigenvectorSquares(np.array([part.mean(axis=0) for part in parts]), np.abs(factors) < 1.0)


def _in_blocks(rows: Array) -> Array:
    """A matrix (N, m) as K blocks (K, ROWS, m), filled up with zeros."""
    blocks = np.zeros((-(-len(rows) // ROWS), ROWS, rows.shape[1]))
    blocks.reshape(-1, rows.shape[1])[: len(rows)] = rows
    return blocks


def _triangle(rows: Array) -> Array:
    """A matrix of fewer rows with the same singular values and right singular vectors."""
    triangles: Any = np.linalg.qr(_in_blocks(rows), mode="r")
    return triangles.reshape(-1, rows.shape[1])


def _product(rows: Array, factor: Any) -> Any:
    return (_in_blocks(rows) @ factor).reshape(-1, factor.shape[1])[: len(rows)]


class MotionKind(Kind):
    """Kind of a steady state; each member equals its text, as ``MotionKind.PERIODIC == "periodic"``."""

    EQUILIBRIUM = "equilibrium"
    PERIODIC = "periodic"
    NON_PERIODIC = "non-periodic"
    NOT_SETTLED = "not settled yet"  # the transient was too short to tell
    ENDED_EARLY = "ended early"  # the run did not reach its end


class Comparison(NamedTuple):
    """What is compared of a run's states: all, with phases on circles, or what a drift leaves.

    Parameters
    ----------
    run : Trajectory
    drift : Drift or None
    reach : callable
        Gives the largest coordinate before the run, which may come to rest at zero.
    still : array (n,) of bool
        States that count as zero, as but rounding moves them; by default none.
    """

    run: Trajectory
    drift: Drift | None = None
    reach: Callable[[], float] = float
    still: Any = np.zeros(1, dtype=bool)

    def columns(self, states: Array) -> Array:
        """What is compared of states (N, m)."""
        states = np.where(self.still, 0.0, states)
        if self.drift is None:
            return phase_on_circle(self.run, states)
        return self.drift.leave_out(states)

    def sizes(self) -> Array:
        """Size of the motion in each of the columns: its range, or its value where but rounding moves it; 0
        where a drift leaves but rounding of it."""
        states = self.columns(self.run.raw.step_states)
        size, values = state_ranges(states), np.abs(states).max(axis=0, initial=0.0)
        size = np.where(size < AT_REST_RTOL * values, values, size)
        if self.drift is not None:
            across = size[: self.drift.across.shape[1]]
            across[across <= self.drift.rounding] = 0.0
        return size

    def resting_parts(self, states: Array) -> list[tuple[Array, float]]:
        """What is constant in states (N, m) where the motion has come to rest, in parts of one unit each, and
        the least size of each."""
        if self.drift is None:
            return [(np.where(self.still, 0.0, states)[:, : self.run.automaton.coordinates or None], 0.0)]
        places, rates = self.drift.places_and_rates(states)
        return [(places, self.drift.travelled), (rates, 0.0)]

    def turning_points(self) -> SectionPoints:
        """Crossings of the section that a motion has by default."""
        if self.drift is not None:
            return section_crossings(self.run, self.drift.section)
        if self.run.automaton.coordinates:
            return section_crossings(self.run, turning_section(self.run.automaton))
        return returns_without_coordinates(self.run, MIN_PERIODS_SEEN)


def kind_of_motion(of: Comparison, crossings: Array, returns: Recurrence, tolerance: float) -> MotionKind:
    """The kind of motion in a run, from its crossings (K, m) of a section and their recurrence.

    Crossings are states as they are compared.
    """
    run, resting = of.run, _at_rest(of)
    if resting is not None:
        return MotionKind.EQUILIBRIUM if resting else MotionKind.NOT_SETTLED
    if is_periodic(returns, tolerance):
        return MotionKind.PERIODIC
    if of.drift is None and is_small_and_decays(run, largest_coordinate(run)):
        return MotionKind.EQUILIBRIUM
    return (
        MotionKind.NOT_SETTLED
        if len(crossings) < MIN_CROSSINGS or is_near(returns) or _has_trend(of, crossings)
        else MotionKind.NON_PERIODIC
    )


def _at_rest(of: Comparison) -> bool | None:
    """Whether a motion has come to rest; None where it has events of its own or does not decay.

    With a drift: to a steady motion, in which all that the drift leaves rests.
    """
    run = of.run
    if np.all(of.still[: run.automaton.coordinates or None]):  # which foot holds a body may yet change
        return covers_period(run)
    if not only_phase_resets(run):
        return None
    verdicts = [_part_at_rest(run, x, least) for x, least in of.resting_parts(_even_samples(run))]
    if of.drift is None and _decays_to_zero(run, of.reach):
        return True
    return None if None in verdicts else all(verdicts)


def _decays_to_zero(run: Trajectory, reach: Callable[[], float]) -> bool:
    """Whether a motion about zero decays, and is small beside what `reach` gives, as of :class:`Comparison`.

    Where the equilibrium is at zero, as that of a structure without loads, coordinates are no measure.
    """
    if len(run.events):
        return False
    x = _even_samples(run)
    places = x[:, : run.automaton.coordinates or None]
    if not np.abs(places.mean(axis=0)).max() < ABOUT_ZERO * state_ranges(places).max():
        return False
    return all_parts_decay(x, state_ranges(x)) and _last_range(places) < REST_AMPLITUDE_RTOL * reach()


def _part_at_rest(run: Trajectory, x: Array, least: float) -> bool | None:
    """As `_at_rest` for some states (N, k), whose size is at least `least`."""
    first, *_, last = (float(state_ranges(part).max(initial=0.0)) for part in np.array_split(x, 4))
    size = max(float(np.abs(x).max(initial=0.0)), least)
    if state_ranges(x).max(initial=0.0) <= AT_REST_RTOL * size:
        return covers_period(run)  # a periodic force may yet move what now rests
    if len(run.events):
        return None
    if last <= AT_REST_RTOL * size:
        return True
    return last < REST_AMPLITUDE_RTOL * size if last < first / MIN_DECAY_FACTOR else None


def is_small_and_decays(run: Trajectory, size: float, share: float = REST_AMPLITUDE_RTOL) -> bool:
    """Whether a motion without events decays evenly, and in the end moves no coordinate by more than a share
    of `size`."""
    if len(run.events):
        return False
    x = _even_samples(run)
    small = _last_range(x[:, : run.automaton.coordinates or None]) < share * size
    return small and all_parts_decay(x, state_ranges(x))


def _last_range(places: Array) -> float:
    """The largest range of coordinates (N, n) in the last quarter of a window."""
    return float(state_ranges(np.array_split(places, 4)[-1]).max())


def largest_coordinate(run: Trajectory) -> float:
    """The largest coordinate in a run; the largest state, where there are no coordinates."""
    return float(np.abs(run.raw.step_states[:, : run.automaton.coordinates or None]).max(initial=0.0))


def _has_trend(of: Comparison, crossings: Array) -> bool:
    """Whether a motion that does not repeat drifts, grows or decays throughout the window."""
    run, size = of.run, of.sizes()
    whole = run.raw.step_states if of.drift is None else of.columns(run.raw.step_states)
    if crossings_drift(crossings, size) or amplitude_changes(whole) or part_decays(crossings, size):
        return True
    x = of.columns(_even_samples(run))
    return part_decays(x, state_ranges(x), evenly=not only_phase_resets(run))


def _even_samples(run: Trajectory) -> Array:
    """States (N, m) at even times."""
    return run(np.linspace(0.0, run.raw.t, EVEN_SAMPLES))


def onsets_per_period(run: Trajectory, period: float) -> int:
    """Transitions from slip to stick in a period, of all contacts: their mean over all whole periods of the
    run."""
    times = np.repeat(run.events.t, contacts_that_stick(run))
    if not len(times):
        return 0
    count = max(1, int((times[-1] - times[0]) / period + 0.5))
    # Shifted by half a thousandth of a period, so that rounding does not count both ends.
    return round(int((times > times[-1] - (count - 5e-4) * period).sum()) / count)


class MotionClass(NamedTuple):
    """A run's crossings of a section, their recurrence, and the kind and the period (s) of its motion.

    `drift` is what was left out to compare its states, if anything.
    """

    section: SectionPoints
    returns: Recurrence
    kind: MotionKind
    period: float
    drift: Drift | None = None


def classify_run(
    run: Trajectory, section: Section | None, tolerance: float, reach: Callable[[], float] = float
) -> MotionClass:
    """The kind of motion in a run and its period; `reach` as of :class:`Comparison`, the rest as of
    `steady_state`."""
    if not run.status.ok:
        # A motion that grows without bounds does not repeat, and may have a million crossings.
        end = SectionPoints(np.array([run.raw.t]), run.final_state[None])
        return MotionClass(end, Recurrence(0, np.nan, np.nan, np.nan), MotionKind.ENDED_EARLY, np.nan)
    classified = _classify(Comparison(run, reach=reach), section, tolerance)
    if classified.kind == MotionKind.EQUILIBRIUM:
        return classified
    still = moved_by_rounding(run)
    moves = not still.any() or not still[: run.automaton.coordinates].all()
    if classified.kind != MotionKind.NOT_SETTLED and moves:
        return classified
    drift = drift_of(run)
    if drift is None and not still.any():
        return classified
    return _classify(Comparison(run, drift, reach if drift is None else float, still), section, tolerance)


def _classify(of: Comparison, section: Section | None, tolerance: float) -> MotionClass:
    run = of.run
    if section is None and stick_onsets(run).sum() >= MIN_PERIODS_SEEN:
        section = STICK
    crossings = of.turning_points() if section is None else section_crossings(run, section)
    states, returns = _section_recurrence(of, crossings, tolerance)
    # A force returns to its phase once a period, however many crossings there are in it.
    forced = _section_recurrence(of, phase_returns(run), tolerance)[1]
    if is_periodic(forced, tolerance) or (is_near(forced) and not is_periodic(returns, tolerance)):
        returns = forced
    elif section == STICK and not (returns.lag == 1 and is_periodic(returns, tolerance)):
        # Where the slider only just reaches the belt's speed, rounding decides whether stick begins, in each
        # period anew: by chance the onsets seem to repeat after several.
        turns, other = _section_recurrence(of, of.turning_points(), tolerance)
        if not is_periodic(returns, tolerance):
            shorter = is_periodic(other, tolerance) or len(states) < MIN_CROSSINGS
        else:
            shorter = is_periodic(other, tolerance) and other.period < SHORTER_PERIOD * returns.period
        if shorter:
            states, returns = turns, other
    kind = kind_of_motion(of, states, returns, tolerance)
    period = returns.period if kind == MotionKind.PERIODIC else np.nan
    return MotionClass(crossings, returns, kind, period, of.drift)


def _section_recurrence(
    of: Comparison, crossings: SectionPoints, tolerance: float
) -> tuple[Array, Recurrence]:
    """The states at crossings of a section, as they are compared, and their recurrence."""
    crossings = _separate_crossings(crossings)
    states, size = of.columns(crossings.state), of.sizes()
    return states, find_recurrence(crossings.t, states, size, tolerance)


def _separate_crossings(crossings: SectionPoints) -> SectionPoints:
    """The crossings without those at once after another, of which rounding decides how many there are.

    So it is where infinitely many impacts come to an end, and where a section is only touched.
    """
    after = np.diff(crossings.t)
    separate = np.append(True, after > AT_ONCE_SHARE * after.max(initial=0.0))[: len(crossings.t)]
    return SectionPoints(crossings.t[separate], crossings.state[separate])
