"""Measurements to which a model can be fitted: time records, spectra, event times, eigenfrequencies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from frictionlab.automaton import HybridAutomaton
from frictionlab.automaton.modes_on_demand import check_mode_name
from frictionlab.validation import (
    abbreviate,
    check_choice,
    check_mapping,
    check_number,
    check_text,
    float_array,
)

Array = NDArray[np.float64]
WINDOWS = ("rectangular", "hann")
TIMES_CURE = "give ascending times in s, time differences or time stamps"
FREQUENCIES_CURE = "give frequencies by mode, such as {0: 13.5}"


@dataclass(frozen=True, eq=False)
class TimeRecord:
    """States of a motion at some times.

    Parameters
    ----------
    t : array_like (N,)
        Ascending times, s, from the start of the motion at 0.  Time differences (timedelta64, timedelta) are
        such times as well.  Of time stamps (datetime64, datetime, a pandas index) the first is the start.
    values : mapping of str to array_like (N,), or a table
        Measured values by the state's name, as "x1" or "x1'", in SI units; or those of a table of pandas or
        polars, or of a structured array of numpy.
    error : float or mapping of str to float
        Standard deviation of the measurement, in the unit of the state.

    Attributes
    ----------
    start : datetime64 or datetime or None
        The first time stamp; None where the times are seconds.

    Examples
    --------
    >>> import frictionlab as fl
    >>> fl.TimeRecord([0.0, 0.1], {"x": [1.0, 0.9]}, error=0.01).count
    2
    """

    t: Any
    values: Mapping[str, Any]
    error: Any = 1.0
    start: Any = field(default=None, init=False, repr=False)

    def __post_init__(self) -> None:
        t, start = _ascending(self.t, stamps=True)
        object.__setattr__(self, "start", start)
        given = _by_state(self.values)
        columns, errors = _columns(given, self.error, len(t), "times")
        _check_order(self.t, given)
        object.__setattr__(self, "t", t)
        object.__setattr__(self, "values", columns)
        object.__setattr__(self, "error", errors)

    @property
    def count(self) -> int:
        """Number of measured numbers."""
        return len(self.t) * len(self.values)


@dataclass(frozen=True, eq=False)
class SpectrumRecord:
    """Amplitudes of states at some frequencies, from samples of a part of the motion.

    For samples x_j at the times t_j, with the weights w_j of a window, they are

        a(f) = | 2 / sum w_j  sum w_j (x_j - m) exp(-2 pi i f t_j) |,    m = sum w_j x_j / sum w_j.

    A model's prediction is the same sum, so that leakage between lines is the same on both sides.  Phases are
    not used.

    Parameters
    ----------
    t : array_like (N,)
        Ascending times of the samples, as those of a :class:`TimeRecord`.
    frequencies : array_like (F,)
        Ascending, above 0, Hz.
    values : mapping of str to array_like (F,)
        Measured amplitudes by the state's name, as "x1" or "x1'".
    error : float or mapping of str to float
        Standard deviation of an amplitude.  Errors are nearly normal only where the amplitude is a few times
        as large: leave out lines that are all noise.
    window : "rectangular" or "hann"
        The window of the measurement.  With "hann", neighbouring lines share their noise, and confidence
        intervals come out too narrow unless only every third line is taken.

    Examples
    --------
    >>> import frictionlab as fl, numpy as np
    >>> t = np.arange(100) / 10.0
    >>> record = fl.TimeRecord(t, {"x": 2.0 * np.sin(2 * np.pi * 0.5 * t)}, error=0.1)
    >>> lines = fl.SpectrumRecord.from_record(record, [0.5, 1.0])
    >>> [round(float(a), 9) for a in lines.values["x"]], round(lines.error["x"], 4)
    ([2.0, 0.0], 0.0141)
    """

    t: Any
    frequencies: Any
    values: Mapping[str, Any]
    error: Any = 1.0
    window: str = "rectangular"
    start: Any = field(default=None, init=False, repr=False)

    def __post_init__(self) -> None:
        t, start = _ascending(self.t, stamps=True)
        object.__setattr__(self, "t", t)
        object.__setattr__(self, "start", start)
        lines = float_array("frequencies", self.frequencies, "give those of the lines in Hz")
        if lines.ndim != 1 or not len(lines) or not lines[0] > 0.0 or not (np.diff(lines) > 0.0).all():
            raise ValueError(
                f"frequencies must ascend and be above 0, one at least, "
                f"got {abbreviate(self.frequencies)}: sort them"
            )
        object.__setattr__(self, "frequencies", lines)
        check_choice("window", self.window, WINDOWS, "say that of the measurement")
        columns, errors = _columns(self.values, self.error, len(lines), "frequencies")
        object.__setattr__(self, "values", columns)
        object.__setattr__(self, "error", errors)

    @classmethod
    def from_record(cls, record: TimeRecord, frequencies: Any, window: str = "rectangular") -> SpectrumRecord:
        """The lines of a time record, with the errors that follow from those of the record."""
        if not isinstance(record, TimeRecord):
            raise TypeError(
                f"record must be a TimeRecord, got {abbreviate(record)}: write fl.TimeRecord(t, ...)"
            )
        lines = np.atleast_1d(float_array("frequencies", frequencies, "give those of the lines in Hz"))
        check_choice("window", window, WINDOWS, "take one of them")
        weights, w = line_weights(record.t, lines, window), _window(len(record.t), window)
        share = float(np.sqrt(2.0 * (w**2).sum()) / w.sum())
        values = {name: np.abs(weights @ column) for name, column in record.values.items()}
        spectrum = cls(record.t, lines, values, {n: share * e for n, e in record.error.items()}, window)
        object.__setattr__(spectrum, "start", record.start)
        return spectrum

    @property
    def count(self) -> int:
        """Number of measured numbers."""
        return len(self.frequencies) * len(self.values)


def line_weights(t: Array, frequencies: Array, window: str) -> NDArray[np.complex128]:
    """Factors (F, N) of the samples in the sums whose absolute values are the amplitudes."""
    share = _window(len(t), window)
    share = share / share.sum()
    turns = np.exp(-2j * np.pi * np.outer(frequencies, t))
    return 2.0 * share * (turns - (turns @ share)[:, None])


def _window(count: int, window: str) -> Array:
    hann = window == "hann"
    return 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(count) / count) if hann else np.ones(count)


@dataclass(frozen=True, eq=False)
class EventTimes:
    """Times of events that enter one mode.

    Parameters
    ----------
    t : array_like (N,)
        Ascending times, s, or time differences, of the first N such events from the start of the motion
        at 0.
    target : str
        The mode entered, as "stick".
    error : float
        Standard deviation, s.
    """

    t: Any
    target: str
    error: float = 1.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "t", _ascending(self.t, stamps=False)[0])
        check_text("target", self.target, "name the mode that is entered")
        check_number("error", self.error, above=0.0, cure="give the standard deviation in s")

    @property
    def count(self) -> int:
        """Number of measured numbers."""
        return len(self.t)


@dataclass(frozen=True, eq=False)
class Frequencies:
    """Frequencies of modes at the equilibrium.

    Parameters
    ----------
    values : mapping of int to float
        Hz, by the mode's number, counted from 0 by ascending frequency, those of 0 Hz too: overdamped modes,
        further states, a rotation.
    error : float
        Standard deviation, Hz.
    """

    values: Mapping[int, float]
    error: float = 1.0

    def __post_init__(self) -> None:
        check_mapping("values", self.values, FREQUENCIES_CURE, keys=object)
        for mode, value in self.values.items():
            check_number("a mode's number in values", mode, integer=True, least=0, cure=FREQUENCIES_CURE)
            check_number(f"values[{mode}]", value, above=0.0, cure="give the frequency in Hz")
        check_number("error", self.error, above=0.0, cure="give the standard deviation in Hz")

    @property
    def count(self) -> int:
        """Number of measured numbers."""
        return len(self.values)


KINDS = (TimeRecord, SpectrumRecord, EventTimes, Frequencies)
Measurement = TypeVar("Measurement")


def of_kind(data: Sequence[Any], kind: type[Measurement]) -> list[Measurement]:
    """The measurements of one kind."""
    return [one for one in data if isinstance(one, kind)]


def as_data(data: Any) -> tuple[Any, ...]:
    """One or several measurements as a tuple.

    Raises
    ------
    TypeError
        Where one is no measurement.
    """
    records = tuple(data) if isinstance(data, Sequence) else (data,)
    for one in records or (data,):
        if not isinstance(one, KINDS):
            raise TypeError(
                "data must be TimeRecord, SpectrumRecord, EventTimes, Frequencies or several of them, got "
                f'{abbreviate(one)}: write fl.TimeRecord(t, {{"x1": measured}}, error=1e-4)'
            )
    return records


def check_data(data: Sequence[Any], automaton: HybridAutomaton) -> None:
    """Raise ValueError unless the automaton has the states and modes that were measured.

    Also where records have different time stamps of their starts, as a motion has one.
    """
    starts = [one.start for one in data if getattr(one, "start", None) is not None]
    if any(start != starts[0] for start in starts):
        raise ValueError(
            f"records must begin at the same time stamp, got {' and '.join(map(str, starts))}: give times in "
            "s, or as differences from the start of the motion"
        )
    for one in data:
        if isinstance(one, (TimeRecord, SpectrumRecord)):
            for name in one.values:
                check_choice("state", name, automaton.state_names, "name one of them")
        elif isinstance(one, EventTimes):
            check_mode_name(one.target, automaton.names)


def _by_state(values: Any) -> Any:
    """The columns of a table or of a structured array by their names; all else as it is given."""
    names = getattr(values, "columns", getattr(getattr(values, "dtype", None), "names", None))
    if isinstance(values, Mapping) or names is None:
        return values
    return {name: values[name] for name in names}


def _columns(values: Any, error: Any, count: int, of: str) -> tuple[dict[str, Array], dict[str, float]]:
    """Measured values by state, `count` of each, and their errors.

    Raises
    ------
    ValueError
        For no values, values that are not finite, or not `count` of them; for an error that is not above 0.
    """
    check_mapping("values", values, 'give arrays by state, such as {"x1": measured}')
    if not values:
        raise ValueError('values must hold one state at least, got none: write {"x1": measured}')
    columns = {n: _measured(f"values[{abbreviate(n)}]", column) for n, column in values.items()}
    for name, column in columns.items():
        rule = f"values[{abbreviate(name)}] must hold a finite number for each of the {count} {of}"
        if column.shape != (count,):
            raise ValueError(f"{rule}, got shape {column.shape}: leave out {of} without one")
        if not np.isfinite(column).all():
            first = int(np.argmin(np.isfinite(column)))
            raise ValueError(f"{rule}, got {column[first]} at index {first}: leave out {of} without one")
    errors: Any = error if isinstance(error, Mapping) else dict.fromkeys(columns, error)
    for name in columns:
        check_number(f"the error of {name}", errors.get(name), above=0.0, cure="give the standard deviation")
    return columns, {name: float(errors[name]) for name in columns}


def _check_order(t: Any, values: Mapping[str, Any]) -> None:
    """Raise ValueError where a pandas Series has the labels of the times, or the times, in another order."""
    labels = np.asarray(_labels(t, t))
    for name, column in values.items():
        own = np.asarray(_labels(column, labels))
        if own.shape == labels.shape and (own != labels).any() and set(own.tolist()) == set(labels.tolist()):
            raise ValueError(
                f"values[{abbreviate(name)}] must be in the order of t, got its index in another: give the "
                "values in the order of t, as by .loc[t.index]"
            )


def _labels(column: Any, otherwise: Any) -> Any:
    """The index of a pandas Series; a list has a method of this name."""
    index = getattr(column, "index", otherwise)
    return otherwise if callable(index) else index


def _measured(name: str, column: Any) -> Array:
    """Measured values as floats, with NaN for those that are masked."""
    if np.ma.isMaskedArray(column):
        return float_array(name, np.ma.filled(column.astype(float), np.nan), "give numbers")
    if getattr(getattr(column, "dtype", None), "kind", "") in ("m", "M"):
        raise ValueError(f"{name} must hold numbers, got values of the type {column.dtype}: give SI units")
    return float_array(name, column, "give numbers")


def _ascending(t: Any, *, stamps: bool) -> tuple[Array, Any]:
    """Times in s, and the time stamp of the first if they are stamps; raises unless they ascend from 0 on."""
    seconds, start = _seconds(t)
    if start is not None and not stamps:
        raise ValueError(
            f"t must be times from the start of the motion, got time stamps, the first {start}: subtract "
            "that of the start"
        )
    times = _measured("t", seconds) if np.ma.isMaskedArray(seconds) else float_array("t", seconds, TIMES_CURE)
    if not np.isfinite(times).all():
        first = int(np.argmin(np.isfinite(times)))
        raise ValueError(f"t must be finite times, got a missing one at index {first}: leave it out")
    if times.ndim != 1 or not len(times) or times[0] < 0.0 or not (np.diff(times) > 0.0).all():
        raise ValueError(
            f"t must be ascending times from 0 on, one at least, got {abbreviate(t)}: sort them, each once"
        )
    return times, start


def _seconds(t: Any) -> tuple[Any, Any]:
    """Time differences and time stamps as s, and the first stamp; other values as they are.

    Stamps are of numpy, pandas or Python, with or without a time zone.
    """
    try:
        times = t if isinstance(t, np.ndarray) else np.asarray(t)
    except ValueError:  # rows of different lengths
        return t, None
    if times.dtype.kind == "M" and times.size:
        return _seconds(times - times.flat[0])[0], times.flat[0]
    if times.dtype.kind == "m":
        times = times.filled(np.timedelta64("NaT")) if np.ma.isMaskedArray(times) else times
        return np.where(np.isnat(times), np.nan, times / np.timedelta64(1, "s")), None
    if times.dtype == object and times.size and all(isinstance(one, timedelta) for one in times.flat):
        return [one.total_seconds() for one in times.flat], None
    if times.dtype == object and times.size and all(isinstance(one, datetime) for one in times.flat):
        # Python subtracts the clocks of two stamps of one zone, though one may be of summer time.
        aware = [one.astimezone(UTC) if one.tzinfo else one for one in times.flat]
        return [(one - aware[0]).total_seconds() for one in aware], aware[0]
    return t, None
