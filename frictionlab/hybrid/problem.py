"""The problem that a method integrates, and what it returns: arrays, events, named outputs.

A `Problem` is a program with its numbers, an initial state and an end time.  Kernels fill records of fixed
capacity.  `RecordList` joins these into `RunData`, the arrays that a
:class:`~frictionlab.hybrid.trajectory.Trajectory` wraps, and checks that they do not fill the memory
(`free_memory`).  `Status` says in a sentence how the run ended.
`Events` and `SectionPoints` list what happened, and when.  Each mode has a formula for every output, which is
evaluated at arrays of states.  Powers in these formulas follow the rule of the tape: a base that rounding has
made negative counts as zero.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from frictionlab.automaton import HybridAutomaton, Mode
from frictionlab.hybrid.free_memory import free_memory
from frictionlab.hybrid.kernels.run_state import Record, new_record
from frictionlab.presentation import MAX_ROWS, count, dataframe, shorten, span
from frictionlab.tape.formulas import Formulas, formulas_of, kept_formulas
from frictionlab.tape.program import Code, Numbers, Program
from frictionlab.validation import abbreviate, is_sequence


@dataclass(frozen=True)
class Problem:
    """A program with its numbers, an initial state, an end time, and a mode to start in (None: choose one).

    Two flights in a row shorter than `chatter` (s) are replaced by the limit mode, if there is one.

    Where modes are derived on demand, `derive` takes combinations of regimes and returns the program and its
    numbers with their modes added.  The modes already in the program keep their indices.
    """

    program: Program
    numbers: Numbers
    x0: np.ndarray
    t_end: float
    mode: int | None = None
    derive: Callable[[Sequence[tuple[int, ...]]], tuple[Program, Numbers]] | None = None
    chatter: float = 0.0

    def with_mode(self, combination: np.ndarray) -> Problem:
        """The problem with the mode of one more combination."""
        assert self.derive is not None
        program, numbers = self.derive([tuple(combination.tolist())])
        return replace(self, program=program, numbers=numbers)

    def with_derived_modes(self) -> Problem:
        """The problem with all modes that runs have had derived meanwhile."""
        if self.derive is None:
            return self
        program, numbers = self.derive([])
        return replace(self, program=program, numbers=numbers)


class Sampling(NamedTuple):
    """How a run is sampled: the order of its dense output, and at what times.

    Samples cut each step into `parts`, or are at the times `t_eval`.  `sections` names the recorded ones.
    """

    order: int
    parts: int
    t_eval: np.ndarray | None = None
    sections: tuple[str, ...] = ()


class RunData(NamedTuple):
    """What a method computed, as arrays; :class:`~frictionlab.hybrid.trajectory.Trajectory` wraps it.

    A step has its start time, its length, its mode and the state at its start.  An event has its time, the
    guard, the mode entered (-1: none), whether it closed an accumulation, and the states before and after.
    """

    step_times: np.ndarray  # (steps, 2)
    step_modes: np.ndarray  # (steps,)
    step_states: np.ndarray  # (steps, states)
    event_times: np.ndarray  # (events,)
    event_codes: np.ndarray  # (events, 3)
    event_states: np.ndarray  # (events, 2, states)
    point_times: np.ndarray  # (points,) section points
    point_sections: np.ndarray
    point_states: np.ndarray
    t: float
    state: np.ndarray
    mode: int
    status: Status

    def cut(self, states: int) -> RunData:
        """The data without the integrals, which follow the first `states` states."""
        if self.state.size == states:
            return self
        names = ("step_states", "event_states", "point_states", "state")
        return self._replace(**{name: getattr(self, name)[..., :states].copy() for name in names})


class Status(Enum):
    """How a run ended; the value is a sentence that says what happened and what can be done."""

    FINISHED = "finished: the end time was reached"
    NO_ADMISSIBLE_MODE = (
        "no admissible mode: after the last event no mode of the automaton could be entered; "
        "check the model's laws there, or the initial state; a force that jumps where a velocity changes its "
        "sign, and drives it back from either side, is dry friction, which needs a Friction contact"
    )
    STALLED = (
        "stalled: time no longer advances; the step or the dwell times fell below the resolution of time"
    )
    ACCUMULATED = "accumulation: events piled up in finite time; use accumulation='close' to pass such points"
    NOT_FINITE = (
        "not finite: a state overflowed or its rate is no number; end the run earlier where the motion is "
        "unbounded, or see where a law is not defined"
    )
    STEP_CAP = "step cap: max_steps was reached before the end time; raise it to go on"
    EVENT_CAP = "event cap: max_events was reached before the end time; raise it to go on"
    MEMORY_CAP = (
        "memory cap: what is kept of the run would soon fill the memory that is free; end the run earlier, "
        "go on from its final state, or use fl.ensemble, which keeps no steps"
    )
    INTERRUPTED = "interrupted: stopped by ctrl-C; the run is kept up to there"
    RUNNING = "running"

    def __str__(self) -> str:
        return self.value

    @property
    def ok(self) -> bool:
        """Whether the end time was reached."""
        return self is Status.FINISHED


BYTES_BETWEEN_LOOKS = 2**26  # largest growth of a run between two checks of the free memory
BYTES_AT_FIRST_LOOK = 2**20  # below them a run is too small to fill a memory


class RecordList:
    """Records in the order in which they were filled."""

    def __init__(self) -> None:
        self._parts: list[list[np.ndarray]] = []
        self.steps, self.events = 0, 0
        self._bytes, self._next_look = 0, min(BYTES_AT_FIRST_LOOK, BYTES_BETWEEN_LOOKS)

    def add(self, record: Record, steps: int, events: int, points: int) -> bool:
        """Keep a copy of the filled part of a record; without memory for one (False) the part itself."""
        lengths = (steps, steps, steps, events, events, events, points, points, points)
        try:
            parts = [array[:n].copy() if n else array[:0] for array, n in zip(record, lengths)]
            copied = True
        except MemoryError:
            parts, copied = [array[:n] for array, n in zip(record, lengths)], False
        self._parts.append(parts)
        self._bytes += sum([part.nbytes for part in parts])
        self.steps += steps
        self.events += events
        return copied

    def fills_memory(self) -> bool:
        """Whether memory would soon run out.  To work with the run takes as much memory again as it holds."""
        if self._bytes < self._next_look:
            return False
        growth = min(self._bytes, BYTES_BETWEEN_LOOKS)
        self._next_look = self._bytes + growth
        return free_memory() < self._bytes + 2 * growth

    def raw(self, code: Code, t: float, state: np.ndarray, mode: int, status: Status) -> RunData:
        """All records joined, with the end of the run.  The records are given up, which saves memory."""
        parts, self._parts = self._parts, []
        if len(parts) > 1:
            arrays = [_joined(parts, i) for i in range(len(Record._fields))]
        else:
            arrays = parts[0] if parts else new_record(code, 0, 0, 0)
        return RunData(*arrays, t=t, state=state, mode=mode, status=status)


def _joined(parts: list[list[Any]], i: int) -> np.ndarray:
    """The arrays number `i` of the parts as one; the parts give them up."""
    joined = np.concatenate([part[i] for part in parts])
    for part in parts:
        part[i] = None
    return joined


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


@dataclass(frozen=True)
class Events:
    """Every event of a run, one row each; ``print(run.events)`` shows the first as a table.

    ``run.events[0]`` is an event, ``run.events[run.events.target == "stick"]`` are some of them.

    Attributes
    ----------
    t : (E,) times, in seconds
    source, target : (E,) names of the modes left and entered ("" where none could be entered)
    guard : (E,) names of the event functions that reached zero
    state, before : (E, states) state after and before the reset
    closed : (E,) whether the event closed a Zeno accumulation
    names, units : names of the states, and their units, "" where they are not known
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

    def __len__(self) -> int:
        return len(self.t)

    def __getitem__(self, index: Any) -> Any:
        """One event for an integer; `Events` for a slice, or for an array of integers or truth values."""
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
        return replace(self, **columns)

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
        after the event, and those before it, as "x1 before".
        """
        about = {name: getattr(self, name) for name in ("source", "target", "guard", "closed")}
        after = dict(zip(self.names, self.state.T, strict=True))
        before = {f"{name} before": column for name, column in zip(self.names, self.before.T, strict=True)}
        units = dict(zip((*after, *before), (*self.units, *self.units)))
        return dataframe(about | after | before, {"t": self.t}, {"t": "s"} | units)

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


class SectionPoints(NamedTuple):
    """Crossings of a section: times (P,) and states (P, states)."""

    t: np.ndarray
    state: np.ndarray

    def __repr__(self) -> str:
        when = f", {span(self.t)} s" if len(self.t) else ""
        return f"SectionPoints({count(len(self.t), 'crossing')}{when})"


def evaluate_output(
    automaton: HybridAutomaton, name: str, states: np.ndarray, modes: np.ndarray, mode_names: Sequence[str]
) -> np.ndarray:
    """Values (N,) of output `name` at `states` (N, n), each by the formula of its mode.

    `modes` (N,) holds indices into `mode_names`.
    """
    values, numbers = np.empty(len(states)), automaton.values.values()
    for i in np.unique(modes):
        chosen = modes == i
        formulas = output_formulas(automaton, mode_names[int(i)], name)
        values[chosen] = formulas.along_run(*states[chosen].T, *numbers)[0]
    return values


def output_formulas(automaton: HybridAutomaton, mode: str, name: str) -> Formulas:
    """An output in a mode as a formula of the states, then the parameters."""

    def derive() -> Formulas:
        return _derived_output(automaton.mode(mode), name, automaton.states, tuple(automaton.parameters))

    return kept_formulas(automaton.derivations, f"{name} in {mode}", derive)


@lru_cache(maxsize=1024)
def _derived_output(mode: Mode, name: str, states: tuple, parameters: tuple) -> Formulas:
    return formulas_of([*states, *parameters], [mode.outputs[name]])
