"""Scales of a motion: the range of each state, the period of an oscillation, and its amplitude spectrum.

Differences between states are measured by the range of each state.  States form three groups, coordinates,
velocities and others, as each group has a unit of its own.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import floor, log10
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionlab.hybrid.trajectory import Trajectory, check_run
from frictionlab.presentation import Drawable, count, unit_of_state
from frictionlab.validation import check_choice, check_number

Array = NDArray[np.float64]

# Least scale of a state, as a share of the largest range in its group.
MIN_RANGE_RTOL = 1e-6
AT_REST_RTOL = 1e-9  # a coordinate whose range is a smaller share of its values counts as at rest

SEEN = 1e-3  # share of the size of a motion: what varies less is not seen in a picture
AFTER_REST = 1.15  # time shown of a motion that comes to rest, relative to the time until rest
SAMPLES_AT_REST = 65

LEAST_MOTION_RTOL = 1e-6  # least size of the motion of a group of states, as a share of its largest value

DEFAULT_PERIOD = 0.1  # s, about that of the slider on a belt
DEAD_BAND = 1e-3  # share of a state's range by which it has to pass the middle to have passed it
LEAST_TURNS = 3
ROUND_NUMBER_RTOL = 1e-9  # share by which rounding errors may put a number below the round one it stands for
HARMONICS_SHOWN = 6.0  # a spectrum shows frequencies up to this multiple of the model's own
# most periods transformed: they resolve a thousandth of the frequency, more than a figure shows
MAX_PERIODS = 1000.0
# samples per period of f_max, so that the high harmonics of kinks are not aliased into view
OVERSAMPLING = 16
MIN_LINES = 5
MAX_SAMPLES = 1e7  # of a spectrum: a minute of computation


def state_ranges(states: Any) -> Array:
    """Range of each state over a motion; zeros for a motion without samples."""
    states = np.asarray(states, dtype=float)
    return states.max(axis=0) - states.min(axis=0) if len(states) else np.zeros(states.shape[1])


def state_groups(coordinates: int) -> tuple[slice, slice, slice]:
    """Coordinates, velocities, other states: each has a unit of its own."""
    return slice(coordinates), slice(coordinates, 2 * coordinates), slice(2 * coordinates, None)


def state_scales(states: Array, coordinates: int) -> Array:
    """The range of each state, by which differences are measured.

    It is at least a share of the largest range in its group, so that a state that only decays is not compared
    by its own small range.  A state or group that does not move beyond rounding is measured by its values.
    """
    ranges, values = state_ranges(states), np.abs(states).max(axis=0)
    still = ranges <= AT_REST_RTOL * values
    for group in state_groups(coordinates):
        largest = ranges[group].max(initial=0.0) or values[group].max(initial=0.0) or 1.0
        ranges[group] = np.maximum(ranges[group], MIN_RANGE_RTOL * largest)
        values[group] = np.maximum(values[group], MIN_RANGE_RTOL * values[group].max(initial=0.0))
    return np.where(still, np.maximum(ranges, values), ranges)


def motion_size(run: Trajectory, samples: int | None = None) -> Array:
    """Size of a motion, or of its first `samples`, in each state: the largest range in its group.

    Groups are coordinates, velocities, others.
    """
    # sampled within steps too: at the events of dry friction all velocities may be zero
    states = run.states[:samples]
    ranges, values = state_ranges(states), np.abs(states).max(axis=0)
    for group in state_groups(run.automaton.coordinates):
        largest = max(ranges[group].max(initial=0.0), LEAST_MOTION_RTOL * values[group].max(initial=0.0))
        ranges[group] = largest or 1.0
    return ranges


def is_at_rest(run: Trajectory, span: tuple[float, float]) -> bool:
    """Whether no coordinate changes in a part of a run, relative to its size or distance from the start."""
    count = run.automaton.coordinates or len(run.names)
    began, states = np.split(run(np.append(0.0, np.linspace(*span, SAMPLES_AT_REST)))[:, :count], [1])
    size = max(float(np.abs(states - began).max()), float(np.abs(states).max()))
    return bool(np.ptp(states, axis=0).max() <= AT_REST_RTOL * size)


def time_of_rest(run: Trajectory) -> float:
    """When a run came to rest (s): from then on no coordinate visibly differs from its last value."""
    q = run.states[:, : run.automaton.coordinates or len(run.names)]
    away = np.abs(q - q[-1]).max(axis=1)
    displaced = np.flatnonzero(away > SEEN * away.max())
    after = min(int(displaced[-1]) + 1, len(q) - 1) if len(displaced) else len(q) - 1
    # The last event may come long after the last visible change, as the impacts of a ball do.
    events = run.events.t
    return max(float(run.t[after]), float(events[-1]) if len(events) else 0.0)


def moving_span(run: Trajectory, seconds: float) -> tuple[float, float]:
    """Start and end of the last seconds of a run or, if nothing moves in them, of what moved before."""
    end = float(run.raw.t)
    span = max(0.0, end - seconds), end
    if span[0] == 0.0 or not is_at_rest(run, span):
        return span
    return 0.0, min(end, AFTER_REST * time_of_rest(run))


def mean_period(times: Array, values: Array) -> float:
    """Twice the mean time (s) between passes of the middle of the range; inf where there are few."""
    middle, size = 0.5 * (values.max() + values.min()), np.ptp(values)
    away = np.abs(values - middle) > DEAD_BAND * size
    sides = np.sign(values[away] - middle)
    passes = times[away][1:][sides[1:] != sides[:-1]]
    return float(2 * (passes[-1] - passes[0]) / (len(passes) - 1)) if len(passes) >= LEAST_TURNS else np.inf


def shortest_period(run: Trajectory, of: Iterable[str] | None = None) -> float:
    """Mean time in which the fastest of the states, all or some by name, goes up and down, s.

    It is inf where none does twice.
    """
    names = run.names if of is None else of
    return min((mean_period(run.t, run.states[:, run.names.index(name)]) for name in names), default=np.inf)


def period_of_run(run: Trajectory) -> float:
    """Approximate period of oscillation (s): as stated; of an automaton without one, as it moved."""
    stated = getattr(run.automaton if run.source is None else run.source, "period", None)
    return stated or min(shortest_period(run), float(run.raw.t)) or DEFAULT_PERIOD


def round_down_1_2_5(x: float) -> float:
    """A number rounded down to 1, 2 or 5 times a power of ten.

    >>> round_down_1_2_5(37.0), round_down_1_2_5(0.05)
    (20.0, 0.05)
    """
    limit = x * (1 + ROUND_NUMBER_RTOL)
    power = 10.0 ** floor(log10(limit))
    return float(f"{max(d for d in (1, 2, 5) if d * power <= limit) * power:.3g}")


class Spectrum(NamedTuple):
    """Amplitude spectrum of the state `name` from `start` to `stop` (s), lines `resolution` (Hz) apart.

    Amplitudes are in `unit`, "" where it is not known.
    """

    frequencies: Array
    amplitudes: Array
    resolution: float
    start: float
    stop: float
    name: str = ""
    unit: str = ""

    drawn_by = "plot_amplitudes"
    several_axes = False
    plot = Drawable.plot

    def __repr__(self) -> str:
        lines = f"{count(len(self.frequencies), 'line')} {self.resolution:.2g} Hz apart"
        return f"Spectrum({self.name}, {lines}, strongest {self.strongest:.4g} Hz)"

    @property
    def strongest(self) -> float:
        """Frequency (Hz) of the largest amplitude."""
        return float(self.frequencies[np.argmax(self.amplitudes)])

    def peaks(self, share: float = 0.05) -> tuple[Array, Array]:
        """Frequencies (Hz) and amplitudes of the local maxima above a share of the largest, strongest first.

        A peak between two lines is interpolated by the ratio of the two highest, which the Hann window
        determines: frequencies are right to some hundredths of the resolution, and amplitudes to some
        thousandths, where other peaks are several lines away.
        """
        check_number("share", share, least=0.0, below=1.0, cure="0.05 is usual")
        a = self.amplitudes
        i = 1 + np.flatnonzero((a[1:-1] > a[:-2]) & (a[1:-1] >= a[2:]) & (a[1:-1] > share * a.max()))
        ratio = np.maximum(a[i - 1], a[i + 1]) / a[i]
        aside = np.clip((2 * ratio - 1) / (1 + ratio), 0.0, 0.5)
        heights = a[i] * (1 - aside**2) / np.sinc(aside)
        order = np.argsort(-heights)
        lines = self.frequencies[i] + np.where(a[i + 1] > a[i - 1], aside, -aside) * self.resolution
        return lines[order], heights[order]


def heard_state(run: Trajectory) -> str:
    """The state whose spectrum is shown: the first coordinate, or its rate if it may turn for ever."""
    first = run.automaton.shown_state
    return run.automaton.rates[first] if first in run.automaton.cyclic else first


def amplitude_spectrum(
    run: Trajectory, name: str | None = None, *, f_max: float | None = None, start: float | None = None
) -> Spectrum | None:
    """Amplitude spectrum of a state, with a Hann window and without the mean.

    A sine of amplitude a has a line of height a, where a whole number of its periods is transformed.

    Parameters
    ----------
    run : Trajectory
    name : str or None
        The state, e.g. "x1" or "x1'"; None takes the first coordinate, or its rate if it may turn for ever.
    f_max : float or None
        Highest frequency kept, Hz; None takes about six times the model's own, 60 Hz for the slider.
    start : float or None
        Start (s) of the part that is transformed, which lasts to the end of the run; None takes the second
        half, but no more than about a thousand periods.

    Returns
    -------
    Spectrum or None
        None where the part is too short to resolve five lines up to `f_max`.
    """
    check_run(run)
    state = heard_state(run) if name is None else name
    check_choice("name", state, run.names)
    stop = float(run.raw.t)
    if f_max is None:
        f_max = highest_frequency(period_of_run(run))
    else:
        f_max = float(
            check_number("f_max", f_max, above=0.0, cure="leave it out for six times the model's own")
        )
    if start is None:
        length = min(stop / 2, MAX_PERIODS * period_of_run(run))
    else:
        cure = "give a time of the run, in seconds"
        length = stop - check_number("start", start, least=0.0, most=stop, cure=cure)
    if length * f_max < MIN_LINES:
        return None
    samples = length * f_max * OVERSAMPLING
    check_number(
        "the number of samples", samples, most=MAX_SAMPLES, cure="lower f_max, or give a later start"
    )
    count = int(np.ceil(samples))
    t = np.clip(stop - length + np.arange(count) * (length / count), 0.0, stop)
    x = run(t)[:, run.names.index(state)]
    window = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(count) / count)
    # Subtract the mean weighted by the window, so that nothing of it is left in the first lines.
    amplitudes = np.abs(np.fft.rfft((x - np.average(x, weights=window)) * window)) * (2 / window.sum())
    frequencies = np.arange(len(amplitudes)) / length
    in_range = frequencies <= f_max
    unit = unit_of_state(run.source, state)
    return Spectrum(frequencies[in_range], amplitudes[in_range], 1 / length, stop - length, stop, state, unit)


def highest_frequency(period: float) -> float:
    """The highest frequency (Hz) that a spectrum of a motion of this period (s) shows."""
    return HARMONICS_SHOWN / round_down_1_2_5(period)
