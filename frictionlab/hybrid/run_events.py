"""The events of a run and the crossings of its sections, as tables."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from frictionlab.presentation import MAX_ROWS, count, dataframe, shorten, span
from frictionlab.validation import abbreviate, did_you_mean, is_sequence

MAX_KINDS = 6  # kinds of events that a summary counts


class RunEvent(NamedTuple):
    """One event of a run: a row of `Events`."""

    t: float
    source: str
    target: str
    guard: str
    state: np.ndarray
    before: np.ndarray
    closed: bool


class EventOutputs(NamedTuple):
    """What a model tells of events besides their states, such as impulses: columns (E,), and their units."""

    values: Mapping[str, np.ndarray] = MappingProxyType({})
    units: Mapping[str, str] = MappingProxyType({})


@dataclass(frozen=True)
class Events:
    """Every event of a run, one row each; ``print(run.events)`` shows the first as a table.

    ``run.events[0]`` is an event, ``run.events[run.events.target == "stick"]`` are some of them.

    States and outputs of events have names, as those of a run have: ``run.events["x1"]`` after the events.
    The outputs of a :class:`MechanicalModel` or a :class:`Structure` are the impulses of its impacts, N s,
    M (v+ - v-) = sum of W p:
    "impulse" of the normal force and, of impact laws with friction, "friction_impulse"; numbered as outputs
    of runs are, "impulse_1", where there are several contacts.  They are 0 at an event at which the contact
    has no impact.  Impacts at one instant have an event each, or one together.

    Attributes
    ----------
    t : (E,) times, in seconds
    source, target : (E,) names of the modes left and entered ("" where none could be entered)
    guard : (E,) names of the event functions that reached zero
    state, before : (E, states) state after and before the reset
    closed : (E,) whether the event closed a Zeno accumulation
    names : names of the states
    units : their units, "" where nothing tells them
    outputs : function that gives the other columns, as they are computed when they are asked for

    Examples
    --------
    >>> import frictionlab as fl
    >>> ball = fl.BouncingBall()  # m = 1 kg falls from 1 m
    >>> first = fl.simulate(ball, 1.0).events["impulse"][0]
    >>> bool(abs(first - (1 + ball.e) * (2 * ball.g * ball.h) ** 0.5) < 1e-12)
    True
    """

    t: np.ndarray
    source: np.ndarray
    target: np.ndarray
    guard: np.ndarray
    state: np.ndarray
    before: np.ndarray
    closed: np.ndarray
    names: tuple[str, ...] = ()
    units: tuple[str, ...] = ()
    outputs: Callable[[], EventOutputs] = EventOutputs

    def __len__(self) -> int:
        return len(self.t)

    def __getstate__(self) -> dict[str, Any]:
        """With the outputs in place of the run, whose model may be of a class that pickle does not find."""
        values, units = self.outputs()
        return vars(self) | {"outputs": partial(EventOutputs, {**values}, {**units})}

    def __getitem__(self, index: Any) -> Any:
        """One event for an integer; `Events` for a slice, or for an array of integers or truth values; a
        state after the events or an output of them, (E,), for its name."""
        if isinstance(index, str):
            return self._column(index)
        if isinstance(index, (int, np.integer)) and not isinstance(index, bool):
            if not -len(self) <= index < len(self):
                raise IndexError(
                    f"there are {len(self)} events, got the index {abbreviate(index)}: count from 0"
                )
            t, source, target, guard, state, before, closed = (column[index] for column in self._columns())
            return RunEvent(float(t), str(source), str(target), str(guard), state, before, bool(closed))
        places = np.arange(len(self))
        try:
            chosen: Any = index
            if not isinstance(index, slice) and not is_sequence(index):
                raise TypeError
            places = places[chosen if isinstance(index, slice) or len(chosen) else []]
        except (IndexError, TypeError, ValueError):
            raise IndexError(
                f"the {len(self)} events are chosen by integers, a slice or truth values, "
                f"got {abbreviate(index)}: write events[events.target == 'stick']"
            ) from None
        columns = dict(zip(RunEvent._fields, (column[places] for column in self._columns()), strict=True))
        return replace(self, **columns, outputs=partial(_some_outputs, self.outputs, places))

    def _column(self, name: str) -> np.ndarray:
        if name in self.names:
            return self.state[:, self.names.index(name)]
        outputs = self.outputs().values
        if name not in outputs:
            known = [*self.names, *outputs]
            none = "" if outputs else "; they have impulses where a contact of a model has an impact law"
            raise KeyError(
                f"the events have no {abbreviate(name)}{did_you_mean(name, known)}; they have "
                f"{', '.join(known)}{none}"
            )
        return outputs[name]

    def __iter__(self) -> Iterator[RunEvent]:
        return (self[i] for i in range(len(self)))

    def _columns(self) -> list[np.ndarray]:
        return [getattr(self, name) for name in RunEvent._fields]

    def counts(self) -> dict[str, int]:
        """Number of events by kind, e.g. ``{"slip+ -> stick": 10}``, the most frequent first."""
        kinds = Counter(f"{a} -> {b}" for a, b in zip(self.source, self.target, strict=True))
        return dict(kinds.most_common())

    def to_dataframe(self) -> Any:
        """One row for each event, as a pandas DataFrame indexed by time (needs the extra ``data``).

        Columns: modes left and entered, event function, whether an accumulation was closed; then the states
        after the event, those before it, as "x1 before", and impulses.
        """
        outputs = self.outputs()
        about = {name: getattr(self, name) for name in ("source", "target", "guard", "closed")}
        after = dict(zip(self.names, self.state.T, strict=True))
        before = {f"{name} before": column for name, column in zip(self.names, self.before.T, strict=True)}
        units = dict(zip((*after, *before), (*self.units, *self.units)))
        units |= {"t": "s", **outputs.units}
        return dataframe(about | after | before | {**outputs.values}, {"t": self.t}, units)

    def __repr__(self) -> str:
        kinds = shorten((f"{kind}: {n}" for kind, n in self.counts().items()), MAX_KINDS)
        return f"Events({len(self)}: {kinds})" if kinds else "Events(0)"

    def __str__(self) -> str:
        rows = [("t (s)", "from", "to", "event function")]
        rows += [(f"{e.t:.6g}", e.source, e.target or "no mode", e.guard) for e in self[:MAX_ROWS]]
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        lines = ["  ".join(f"{text:{width}}" for text, width in zip(row, widths)).rstrip() for row in rows]
        lines += [f"... and {len(self) - MAX_ROWS} more"] if len(self) > MAX_ROWS else []
        return "\n".join([repr(self), *(lines if len(self) else [])])


def _some_outputs(outputs: Callable[[], EventOutputs], places: np.ndarray) -> EventOutputs:
    """The outputs of some of the events."""
    values, units = outputs()
    return EventOutputs({name: column[places] for name, column in values.items()}, units)


class SectionPoints(NamedTuple):
    """Crossings of a section: times (P,) and states (P, states)."""

    t: np.ndarray
    state: np.ndarray

    def __repr__(self) -> str:
        when = f", {span(self.t)} s" if len(self.t) else ""
        return f"SectionPoints({count(len(self.t), 'crossing')}{when})"
