"""What in a record does not look like a motion of the model: other units, another start.

Told before a search begins, which would take long and end nowhere.  A record may be right all the same, so
that these are warnings.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionlab.analysis.fitting.data import TimeRecord, of_kind
from frictionlab.analysis.motion_scales import shortest_period
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.models.model import ModelOrAutomaton
from frictionlab.presentation import unit_of_state

Array = NDArray[np.float64]
MAX_SIZE_RATIO = 100.0  # of a state's range in the record and in the run: a larger one is rather one of units
PROBED_TIMES = 10  # times of a record over which its spacing is compared with the motion
MOST_PERIODS = 10.0  # of the motion between two times: with more, no search by single times can find its way
MILLISECOND = 1e-3  # s
MAX_LEAD = 10.0  # times the samples' distance: a record that begins later leaves out the motion's start


def doubts_about(data: Sequence[Any], run: Trajectory, model: ModelOrAutomaton) -> Iterator[str]:
    """What is odd about time records, each in a sentence; `run` is the model's where the search begins."""
    for record in of_kind(data, TimeRecord):
        yield from _doubts_about_times(record.t, shortest_period(run, record.values))
        for name, column in record.values.items():
            yield from _doubts_about_size(name, column, run, unit_of_state(model, name))


def check_times(data: Sequence[Any], run_for: Callable[[float], Trajectory]) -> None:
    """Raise ValueError where what a record measures goes up and down many times between two of its times.

    Only where times in ms would follow the motion: other records may be of single times on purpose.
    `run_for` gives the model's run of a length, s.  A few times of a record are enough, so that this takes
    less than one run over all of it.
    """
    for record in of_kind(data, TimeRecord):
        interval = float(np.median(np.diff(record.t))) if len(record.t) > 1 else 0.0
        if len(record.t) > PROBED_TIMES:
            run = run_for(PROBED_TIMES * interval)
            shortest = shortest_period(run, record.values)
            if run.status.ok and MILLISECOND * interval < shortest < interval / MOST_PERIODS:
                raise ValueError(
                    f"the times of a record must follow the motion, got times {interval:g} s apart where the "
                    f"model moves up and down within {shortest:.3g} s: give t in s (is it in ms?), or fit a "
                    "SpectrumRecord"
                )


def _doubts_about_times(t: Array, shortest: float) -> Iterator[str]:
    interval = float(np.median(np.diff(t))) if len(t) > 1 else np.inf
    if shortest < interval < np.inf:
        yield (
            f"the times of a record are {interval:g} s apart, and the model moves up and down within "
            f"{shortest:.3g} s: t must be in s, is it in ms?"
        )
    if t[0] > max(MAX_LEAD * interval, shortest):
        yield (
            f"a record begins at {t[0]:g} s, and the motion at 0 s, with x0: subtract {t[0]:g} from t if x0 "
            "is the state at the first measurement"
        )


def _doubts_about_size(name: str, column: Array, run: Trajectory, unit: str) -> Iterator[str]:
    measured, own = (float(np.ptp(values)) for values in (column, run.states[:, run.names.index(name)]))
    if min(measured, own) > 0.0 and not 1.0 / MAX_SIZE_RATIO < measured / own < MAX_SIZE_RATIO:
        yield (
            f"{name} ranges over {measured:.3g} in a record and over {f'{own:.3g} {unit}'.rstrip()} in the "
            f"model's run: values must be in {unit or 'its units'}"
        )
