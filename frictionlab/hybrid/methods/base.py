"""What the methods share: the caps of a run, the choice of its first mode, and the loop that feeds records
to `advance`.

A method is one frozen dataclass; to add one, give it ``name``, ``entry``, ``degree`` and
:meth:`Method.advance`.
The mode at t = 0 is chosen by the rule that follows every event.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, ClassVar, NamedTuple

import numpy as np

from frictionlab.automaton import HybridAutomaton
from frictionlab.compilation.decorators import prepare_arrays
from frictionlab.hybrid.chatter_limit import chatter_limit
from frictionlab.hybrid.codegen.native_cache import NativeCode, native_code
from frictionlab.hybrid.free_memory import free_memory
from frictionlab.hybrid.kernels import run_state
from frictionlab.hybrid.kernels.event_handling import handle_event, handle_event_on_demand
from frictionlab.hybrid.kernels.event_location import COEFFICIENT_ROUNDING, GuardZero
from frictionlab.hybrid.kernels.impacts import note_resolution
from frictionlab.hybrid.kernels.jets import MACHINE_EPSILON
from frictionlab.hybrid.kernels.mode_selection import (
    NO_MODE,
    Rounding,
    Selection,
    select_combination,
    select_mode,
)
from frictionlab.hybrid.kernels.run_state import (
    CombinationQueue,
    new_queue,
    new_record,
    new_run_state,
    new_scratch,
)
from frictionlab.hybrid.problem import Problem, RunData, Status
from frictionlab.interruption import Progress
from frictionlab.tape.program import Program, System
from frictionlab.validation import check_field

# Steps between two updates of the progress bar, which check for ctrl-C; 20 s of the slider take one record.
RECORD_CAPACITY = 3072

STATUS_OF_CODE = {
    run_state.RUNNING: Status.RUNNING,
    run_state.FINISHED: Status.FINISHED,
    run_state.NO_ADMISSIBLE_MODE: Status.NO_ADMISSIBLE_MODE,
    run_state.STALLED: Status.STALLED,
    run_state.ZENO: Status.ACCUMULATED,
    run_state.NOT_FINITE: Status.NOT_FINITE,
}
BYTES_BETWEEN_LOOKS = 2**26  # largest growth of a run between two checks of the free memory
BYTES_AT_FIRST_LOOK = 2**20  # below them a run is too small to fill a memory
MOST_SPARES = 8  # programs, or sizes, for which arrays are kept
# Shares of a condition's terms below which it counts as zero where a run starts.
ROUNDINGS_AT_START = COEFFICIENT_ROUNDING, 4096 * MACHINE_EPSILON, 1e-9


class SpareArrays:
    """Arrays of runs that are over, for the next run that needs the same.

    That run need not allocate them.  The words by which kernels take them are known already.
    """

    def __init__(self) -> None:
        self._kept: dict[Any, list[Any]] = {}

    def take(self, key: Any, make: Callable[[], Any]) -> Any:
        """Arrays of a run that is over, or new ones; no two active runs share them."""
        try:
            return self._kept[key].pop()
        except (KeyError, IndexError):
            return make()

    def give(self, key: Any, arrays: Any) -> None:
        """Keep arrays that nothing refers to any more."""
        if key not in self._kept and len(self._kept) == MOST_SPARES:
            self._kept.clear()
        self._kept.setdefault(key, []).append(arrays)


_COUNTED = slice(run_state.STEPS, run_state.POINTS + 1)  # steps, events, points


class ActiveRun(NamedTuple):
    """A run in progress: its arrays, as the kernels take them.

    `queue` is None if all modes are derived.  `event` is one at which a mode has to be derived first.  It is
    handled when the run goes on.
    """

    problem: Problem
    native: NativeCode
    system: System  # with the addresses of native code
    order: int  # of the series
    cursor: run_state.RunState
    scratch: run_state.Scratch
    record: run_state.Record  # to be filled again and again
    nothing: run_state.Record  # without steps, events and points, for all results that lack some of these
    queue: CombinationQueue | None
    event: GuardZero | None = None

    def without_native_code(self) -> ActiveRun:
        """The same run with all modes interpreted."""
        return self._replace(system=self.system._replace(code=self.native.interpreted))

    def for_problem(self, problem: Problem, ends_at_accumulation: bool) -> ActiveRun:
        """A run of another problem of this program from time 0, with the arrays of this one, which is over.

        Jets, bounds and roots need not be cleared: they are written before they are read.
        """
        scratch, cursor = self.scratch, self.cursor
        cursor.state[:] = problem.x0
        np.abs(problem.x0, out=cursor.sizes)
        cursor.times[:] = 0.0, problem.t_end, 0.0, problem.chatter, 0.0, 0.0
        cursor.counts.fill(0)
        cursor.signs.fill(0)
        cursor.counts[run_state.JETS_READY], cursor.counts[run_state.STOPS_AT_ZENO] = 1, ends_at_accumulation
        scratch.structural_zeros.fill(0)
        scratch.leading_zeros.fill(0)
        scratch.ended[0], scratch.ended[1] = NO_MODE, 0
        numbers, queue = problem.numbers, self.queue and new_queue(problem.program.demand)
        system = self.system if self.system.numbers is numbers else self.native.system(numbers)
        arrays = cursor, scratch, self.record, self.nothing
        return ActiveRun(problem, self.native, system, self.order, *arrays, queue)

    def handle_event(
        self, truncation: run_state.Truncation, event: GuardZero, record: run_state.Record
    ) -> int:
        """Record an event and choose the next mode by series up to an order; returns the run's status."""
        arrays = self.cursor, record, self.scratch
        if self.queue is None:
            return handle_event(self.system, truncation, event, *arrays)
        return handle_event_on_demand(self.system, self.queue, truncation, event, *arrays)

    def event_left(self) -> GuardZero:
        """The event that a kernel left to be handled."""
        counts = self.cursor.counts
        guard, multiplicity = counts[run_state.EVENT_GUARD], counts[run_state.EVENT_MULTIPLICITY]
        return GuardZero(0.0, int(guard), int(multiplicity))


def new_run(problem: Problem, order: int, before: ActiveRun | None = None) -> ActiveRun:
    """A run with empty arrays; those of the run `before` it had more modes, as far as they still fit.

    New records would fragment the memory in a run that stops for every new mode.
    """
    program = problem.program
    code, sections = program.code, program.code.sections.shape[1]
    scratch = prepare_arrays(new_scratch(program.slots, code, order))
    # Impacts that act together are recorded at once.
    events = RECORD_CAPACITY + len(scratch.impacts.guards) - 1
    if before is not None and len(before.record.event_times) == events:
        cursor, record = before.cursor, before.record
    else:
        points = (order + 2) * sections + RECORD_CAPACITY if sections else 0
        record = prepare_arrays(new_record(code, RECORD_CAPACITY, events, points))
        cursor = prepare_arrays(new_run_state(code.inputs, sections)) if before is None else before.cursor
    native = native_code(program)
    system, queue = native.system(problem.numbers), new_queue(program.demand)
    nothing = new_record(code, 0, 0, 0)
    return ActiveRun(problem, native, system, order, cursor, scratch, record, nothing, queue)


SPARE_RUNS = SpareArrays()  # runs that are over, by program and order of the series


def initial_mode(run: ActiveRun) -> Selection:
    """First admissible mode at the initial state; leaves the jets that it used in the scratch arrays.

    Raises
    ------
    ValueError
        Where the mode that was asked for cannot be entered there.
    """
    problem, system, scratch, order = run.problem, run.system, run.scratch, run.order
    program = problem.program
    if run.queue is None and not program.code.function_slots.size:  # no mode has a condition
        run.cursor.counts[run_state.JETS_READY] = 0
        return Selection(int(program.initial[0]) if problem.mode is None else problem.mode, NO_MODE)
    candidates = program.initial if problem.mode is None else np.array([problem.mode], dtype=np.int64)
    for rounding in _roundings_at_start(problem):
        if problem.mode is None and run.queue is not None:
            selection = select_combination(
                system, run.queue, NO_MODE, *(problem.x0, rounding, order, scratch)
            )
        else:
            selection = select_mode(system, candidates, problem.x0, rounding, order, scratch)
        if selection.mode >= 0 or selection.missing != NO_MODE:
            return selection
    if problem.mode is not None:
        raise ValueError(
            f"the run cannot start in mode {program.modes[problem.mode]!r}: at x0 one of its conditions "
            "does not hold or fails at once; leave mode=None to have the mode chosen"
        )
    return selection


def _roundings_at_start(problem: Problem) -> Iterator[Rounding]:
    """What counts as zero where a run starts, to be tried in turn until a mode is admissible.

    The sums in the last step of another run, at whose event this one starts, had larger terms than the state
    has; along a closed contact rounding adds up, so that its state may be off by more.  A body that slides on
    two feet is 1e-16 m above them, of which no share is zero: beside the largest state of the group it is.
    """
    for share in ROUNDINGS_AT_START:
        yield Rounding(problem.x0, share)
    sizes, groups = problem.x0.copy(), problem.program.code.groups
    for first, last in pairwise(groups[:3]):
        sizes[first:last] = np.abs(sizes[first:last]).max(initial=0.0)
    yield Rounding(sizes, ROUNDINGS_AT_START[-1])


class RecordList:
    """Records in the order in which they were filled."""

    def __init__(self, nothing: run_state.Record) -> None:
        self._parts: list[list[np.ndarray]] = []
        self._nothing = nothing
        self.steps, self.events = 0, 0
        self._bytes, self._next_look = 0, min(BYTES_AT_FIRST_LOOK, BYTES_BETWEEN_LOOKS)

    def add(self, record: run_state.Record, steps: int, events: int, points: int) -> bool:
        """Keep a copy of the filled part of a record; without memory for one (False) the part itself."""
        lengths = (steps, steps, steps, events, events, events, points, points, points)
        try:
            arrays = [a[:n].copy() if n else none for a, none, n in zip(record, self._nothing, lengths)]
            copied = True
        except MemoryError:
            arrays, copied = [array[:n] for array, n in zip(record, lengths)], False
        self._parts.append(arrays)
        self.steps += steps
        self.events += events
        return copied

    def fills_memory(self) -> bool:
        """Whether memory would soon run out after the record added last.

        To work with the run takes as much memory again as it holds.
        """
        self._bytes += sum(array.nbytes for array in self._parts[-1])
        if self._bytes < self._next_look:
            return False
        growth = min(self._bytes, BYTES_BETWEEN_LOOKS)
        self._next_look = self._bytes + growth
        return free_memory() < self._bytes + 2 * growth

    def raw(self, t: float, state: np.ndarray, mode: int, status: Status) -> RunData:
        """All records joined, with the end of the run.  The records are given up, which saves memory."""
        parts, self._parts = self._parts, []
        if len(parts) > 1:
            arrays = [_joined(parts, i) for i in range(len(run_state.Record._fields))]
        else:
            arrays = parts[0] if parts else [*self._nothing]
        return RunData(*arrays, t=t, state=state, mode=mode, status=status)


def _joined(parts: list[list[Any]], i: int) -> np.ndarray:
    """The arrays number `i` of the parts as one; the parts give them up."""
    joined = np.concatenate([part[i] for part in parts])
    for part in parts:
        part[i] = None
    return joined


@dataclass(frozen=True)
class Method(ABC):
    """Base of all methods; runs the loop and keeps the records."""

    name: ClassVar[str]
    records_sections: ClassVar[bool] = False  # whether the method records sections and integrates quadratures
    entry: ClassVar[Any]  # the kernel that takes longest to compile
    parts: ClassVar[int] = 1  # samples a step is cut into where no t_eval is given
    event_tol = 0.0  # share of the states by which the end of a step may miss its event
    chatter_share: ClassVar[float] = 0.0  # of the time in which the motion changes, where `chatter` is None
    # Settings of some methods.  With an annotation they would come before the other fields of these.
    chatter = 0.0  # s
    accumulation = "close"

    max_steps: int = field(default=3_000_000, kw_only=True)
    max_events: int = field(default=1_000_000, kw_only=True)

    def chatter_limit(self, automaton: HybridAutomaton) -> float:
        """Time (s) below which two flights in a row are replaced by the limit mode of chatter, if any."""
        return chatter_limit(automaton, self.chatter_share) if self.chatter is None else self.chatter

    @property
    @abstractmethod
    def degree(self) -> int:
        """Order of the Taylor series that choose modes and give the dense output."""

    def order_of(self, program: Program) -> int:
        """The degree for runs of a program."""
        return self.degree

    @abstractmethod
    def advance(self, run: ActiveRun, record: run_state.Record) -> int:
        """Fill `record` until it is full (RUNNING), or return why the run ends; see `run_state`."""

    def describe(self) -> dict[str, Any]:
        """Name and settings, for the record."""
        return {"name": self.name, **vars(self)}

    def check_caps(self) -> None:
        """Raise ValueError unless the caps are positive integers."""
        for name in ("max_steps", "max_events"):
            check_field(self, name, integer=True, least=1, cure="leave it out for the default")

    def handle_event(self, run: ActiveRun, event: GuardZero, record: run_state.Record) -> int:
        """Record an event and choose the next mode; returns the run's status, as :meth:`advance`."""
        run, truncation = run.without_native_code(), run_state.Truncation(self.degree, self.event_tol)
        note_resolution(run.system, event.guard, run.cursor, run.scratch)
        return run.handle_event(truncation, event, record)

    @np.errstate(all="ignore")
    def integrate(self, problem: Problem, order: int, progress: Progress) -> RunData:
        """Run the problem to its end, or as far as it goes, with series of an order."""
        run = self._begin(problem, order)
        pieces = RecordList(run.nothing)
        counts, times = run.cursor.counts, run.cursor.times
        status = Status.RUNNING if counts[run_state.MODE] >= 0 else Status.NO_ADMISSIBLE_MODE
        while status is Status.RUNNING:
            counts[_COUNTED] = 0
            record = self._record(run, pieces)
            end = self._advance_or_enter(run, record)
            run = run if run.event is None else run._replace(event=None)
            counted = counts[_COUNTED].tolist()
            if 0 in run.native.code.native.tolist():  # a mode has no machine code yet
                run.native.used(record.step_modes[: counted[0]])
            status = STATUS_OF_CODE.get(end, Status.RUNNING)
            if not pieces.add(record, *counted):
                status = Status.MEMORY_CAP if status is Status.RUNNING else status
                break
            if status is not Status.RUNNING:
                continue
            status = self._status(pieces)
            if status is Status.RUNNING and progress.update(times[run_state.NOW]):
                status = Status.INTERRUPTED
            elif end == run_state.MODE_NOT_DERIVED:
                run = self._with_missing_mode(run, run.event_left())
        else:
            SPARE_RUNS.give((run.problem.program, run.order), run)
        state, mode = run.cursor.state.copy(), int(counts[run_state.MODE])
        return pieces.raw(float(times[run_state.NOW]), state, mode, status)

    def _advance_or_enter(self, run: ActiveRun, record: run_state.Record) -> int:
        """Go on, or first enter a mode that was derived meanwhile; handle the events that kernels leave."""
        end = self.advance(run, record) if run.event is None else self.handle_event(run, run.event, record)
        while end == run_state.EVENT_PENDING:
            end = self.handle_event(run, run.event_left(), record)
            if end == run_state.RUNNING:
                end = self.advance(run, record)
        return end

    def _begin(self, problem: Problem, order: int) -> ActiveRun:
        spare = SPARE_RUNS.take((problem.program, order), lambda: new_run(problem, order))
        run = spare.for_problem(problem, self.accumulation == "raise")
        mode, missing = initial_mode(run)
        while missing != NO_MODE:
            run = self._with_missing_mode(run)
            mode, missing = initial_mode(run)
        run.cursor.counts[run_state.MODE] = mode
        return run

    def _with_missing_mode(self, run: ActiveRun, event: GuardZero | None = None) -> ActiveRun:
        """The run with the mode that was to be tried next; goes on with the event at which it was missing."""
        assert run.queue is not None
        zeros = run.scratch.structural_zeros.copy()
        after = new_run(run.problem.with_mode(run.queue.missing), run.order, run)
        after.scratch.structural_zeros[: len(zeros)] = zeros
        return after._replace(event=event)

    def _record(self, run: ActiveRun, pieces: RecordList) -> run_state.Record:
        """The record to fill, cut to the steps and events that the caps leave."""
        record, steps, events = run.record, self.max_steps - pieces.steps, self.max_events - pieces.events
        if steps >= RECORD_CAPACITY and events >= RECORD_CAPACITY:
            return record
        events += len(run.scratch.impacts.guards) - 1
        lengths = (steps, steps, steps, events, events, events, None, None, None)
        return run_state.Record(*(array[:n] for array, n in zip(record, lengths)))

    def _status(self, pieces: RecordList) -> Status:
        """Whether a run that has not come to its end goes on."""
        if pieces.steps >= self.max_steps:
            return Status.STEP_CAP
        if pieces.events >= self.max_events:
            return Status.EVENT_CAP
        return Status.MEMORY_CAP if pieces.fills_memory() else Status.RUNNING
