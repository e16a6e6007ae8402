"""Measurements to which a model can be fitted: time records, event times, eigenfrequencies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionlab.validation import check_mapping, check_number, float_array

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class TimeRecord:
    """States of a motion at some times.

    Parameters
    ----------
    t : array_like (N,)
        Ascending times, s, from the start of the motion at 0.
    values : mapping of str to array_like (N,)
        Measured values by the state's name, as "x1" or "x1'".
    error : float or mapping of str to float
        Standard deviation of the measurement, in the unit of the state.

    Examples
    --------
    >>> import frictionlab as fl
    >>> fl.TimeRecord([0.0, 0.1], {"x": [1.0, 0.9]}, error=0.01).count
    2
    """

    t: Any
    values: Mapping[str, Any]
    error: Any = 1.0

    def __post_init__(self) -> None:
        t = _ascending(self.t)
        check_mapping("values", self.values, 'give arrays by state, such as {"x1": measured}')
        kept = {
            name: float_array(f"values[{name!r}]", column, "give numbers")
            for name, column in self.values.items()
        }
        for name, column in kept.items():
            if column.shape != t.shape or not np.isfinite(column).all():
                raise ValueError(
                    f"values[{name!r}] must hold a finite number for each of the {len(t)} times, got shape "
                    f"{column.shape}: leave out times without one"
                )
        errors: Any = self.error if isinstance(self.error, Mapping) else dict.fromkeys(kept, self.error)
        for name in kept:
            check_number(
                f"the error of {name}", errors.get(name), above=0.0, cure="give the standard deviation"
            )
        object.__setattr__(self, "t", t)
        object.__setattr__(self, "values", kept)
        object.__setattr__(self, "error", {name: float(errors[name]) for name in kept})

    @property
    def count(self) -> int:
        """Number of measured numbers."""
        return len(self.t) * len(self.values)


@dataclass(frozen=True, eq=False)
class EventTimes:
    """Times of events, each known by the mode that it enters.

    Parameters
    ----------
    t : array_like (N,)
        Ascending times, s, of the first N such events from the start of the motion at 0.
    target : str
        The mode entered, as "stick".
    error : float
        Standard deviation, s.
    """

    t: Any
    target: str
    error: float = 1.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "t", _ascending(self.t))
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
        Hz, by the mode's number, counted from 0 by ascending frequency.
    error : float
        Standard deviation, Hz.
    """

    values: Mapping[int, float]
    error: float = 1.0

    def __post_init__(self) -> None:
        check_mapping("values", self.values, "give frequencies by mode, such as {0: 13.5}")
        check_number("error", self.error, above=0.0, cure="give the standard deviation in Hz")

    @property
    def count(self) -> int:
        """Number of measured numbers."""
        return len(self.values)


KINDS = (TimeRecord, EventTimes, Frequencies)


def as_data(data: Any) -> tuple[Any, ...]:
    """One or several measurements as a tuple.

    Raises
    ------
    TypeError
        For what is none.
    """
    found = tuple(data) if isinstance(data, Sequence) else (data,)
    for one in found or (data,):
        if not isinstance(one, KINDS):
            raise TypeError(
                f"data must be TimeRecord, EventTimes, Frequencies or several of them, got {one!r}: write "
                'fl.TimeRecord(t, {"x1": measured}, error=1e-4)'
            )
    return found


def _ascending(t: Any) -> Array:
    times = float_array("t", t, "give ascending times in s")
    if times.ndim != 1 or not len(times) or times[0] < 0.0 or not (np.diff(times) > 0.0).all():
        raise ValueError(f"t must be ascending times from 0 on, one at least, got {t!r}: sort them")
    return times
