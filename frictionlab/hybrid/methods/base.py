"""What the methods share: settings that end a run, the first mode, and the loop that feeds records to
`advance`.

A method is one frozen dataclass; to add one, give it ``name``, ``series_order`` and :meth:`Method.advance`.
The mode at t = 0 is chosen by the rule that follows every event.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import asdict, dataclass, field
from typing import Any, ClassVar

import numpy as np

from frictionlab.hybrid.codegen.native_cache import NativeCode, native_code
from frictionlab.hybrid.kernels import run_state
from frictionlab.hybrid.kernels.event_location import COEFFICIENT_ROUNDING
from frictionlab.hybrid.kernels.mode_selection import NO_MODE, Rounding, select_mode
from frictionlab.hybrid.kernels.run_state import new_record, new_scratch
from frictionlab.hybrid.problem import ModeNotDerived, Problem, RecordList, RunData, Status
from frictionlab.hybrid.progress import Progress
from frictionlab.hybrid.tape.program import System, system_of
from frictionlab.validation import check_number

RECORD_CAPACITY = 2048  # steps between two updates of the progress bar, which check for ctrl-C

STATUS_OF_CODE = {
    run_state.RUNNING: Status.RUNNING,
    run_state.FINISHED: Status.FINISHED,
    run_state.NO_ADMISSIBLE_MODE: Status.NO_ADMISSIBLE_MODE,
    run_state.STALLED: Status.STALLED,
    run_state.ZENO: Status.ACCUMULATED,
    run_state.NOT_FINITE: Status.NOT_FINITE,
}
_COUNTED = [run_state.STEPS, run_state.EVENTS, run_state.POINTS]


def initial_mode(problem: Problem, system: System, order: int, scratch: run_state.Scratch) -> int:
    """First admissible mode at the initial state, -1 where there is none; leaves its jets in `scratch`.

    Raises
    ------
    ValueError
        Where the mode that was asked for cannot be entered there.
    ModeNotDerived
        Where a mode is to be tried that has yet to be derived.
    """
    program = problem.program
    candidates = program.initial if problem.mode is None else np.array([problem.mode], dtype=np.int64)
    scratch.structural_zeros[:] = 0
    rounding = Rounding(problem.x0, COEFFICIENT_ROUNDING)
    mode, missing = map(int, select_mode(system, candidates, problem.x0, rounding, order, scratch))
    if missing != NO_MODE:
        raise ModeNotDerived(missing)
    if mode < 0 and problem.mode is not None:
        raise ValueError(
            f"the run cannot start in mode {program.modes[problem.mode]!r}: at x0 one of its conditions "
            "does not hold or fails at once; leave mode=None to have the mode chosen"
        )
    return mode


@dataclass(frozen=True)
class ActiveRun:
    """A run in progress: its arrays, as the kernels take them."""

    problem: Problem
    natives: NativeCode
    system: System  # with the addresses of native code
    cursor: run_state.RunState
    scratch: run_state.Scratch


@dataclass(frozen=True)
class Method(ABC):
    """Base of all methods; runs the loop and keeps the records."""

    name: ClassVar[str]
    riders: ClassVar[bool] = False  # whether the method records sections and integrates quadratures
    entry: ClassVar[Any]  # the kernel that takes longest to compile
    parts: ClassVar[int] = 1  # samples a step is cut into where no t_eval is given

    max_steps: int = field(default=3_000_000, kw_only=True)
    max_events: int = field(default=1_000_000, kw_only=True)

    @property
    def limits(self) -> tuple[float, float]:
        """Dwell times (s) below which consecutive events count as Zeno: without a limit mode, and with
        one."""
        return 0.0, 0.0

    @property
    def raises(self) -> bool:
        """Whether a Zeno accumulation ends the run."""
        return False

    @property
    @abstractmethod
    def degree(self) -> int:
        """Order of the Taylor series that choose modes and give the dense output."""

    @abstractmethod
    def advance(self, run: ActiveRun, record: run_state.Record) -> int:
        """Fill `record` until it is full (RUNNING), or return why the run ends; see `run_state`."""

    def describe(self) -> dict[str, Any]:
        """Name and settings, for the record."""
        return {"name": self.name, **asdict(self)}

    def check_caps(self) -> None:
        """Raise ValueError unless the caps are positive integers."""
        for name in ("max_steps", "max_events"):
            check_number(
                name, getattr(self, name), integer=True, least=1, cure="leave it out for the default"
            )

    def integrate(self, problem: Problem, progress: Progress) -> RunData:
        """Run the problem to its end, or as far as it goes; ModeNotDerived where it needs another mode."""
        with np.errstate(all="ignore"):
            return self._integrate(problem, progress)

    def _integrate(self, problem: Problem, progress: Progress) -> RunData:
        run, pieces, status = self._begin(problem), RecordList(), Status.RUNNING
        counts, times = run.cursor.counts, run.cursor.times
        if counts[run_state.MODE] < 0:
            status = Status.NO_ADMISSIBLE_MODE
        while status is Status.RUNNING:
            record = self._record(run, pieces)
            counts[_COUNTED] = 0
            end = int(self.advance(run, record))
            run.natives.used(record.step_modes[: counts[run_state.STEPS]])
            pieces.add(record, *counts[_COUNTED])
            status = self._status(STATUS_OF_CODE.get(end, Status.RUNNING), pieces)
            if progress.update(times[run_state.NOW]) and status is Status.RUNNING:
                status = Status.INTERRUPTED
            elif end == run_state.MODE_NOT_DERIVED:
                raise ModeNotDerived(int(counts[run_state.MISSING_MODE]))
        mode = int(counts[run_state.MODE])
        return pieces.raw(problem.program.code, times[run_state.NOW], run.cursor.state, mode, status)

    def _begin(self, problem: Problem) -> ActiveRun:
        natives = native_code(problem.program)
        system = system_of(problem.program.code, problem.numbers)
        scratch = new_scratch(problem.program.slots, problem.program.code, self.degree)
        mode = initial_mode(problem, system, self.degree, scratch)
        cursor = run_state.new_run_state(problem.x0, mode, problem.t_end, self.limits, self.raises)
        cursor = cursor._replace(signs=np.zeros(problem.program.code.sections.shape[1], dtype=np.int64))
        return ActiveRun(problem, natives, system._replace(code=natives.code), cursor, scratch)

    def _record(self, run: ActiveRun, pieces: RecordList) -> run_state.Record:
        code = run.problem.program.code
        steps = min(RECORD_CAPACITY, self.max_steps - pieces.steps)
        events = min(RECORD_CAPACITY, self.max_events - pieces.events)
        points = (self.degree + 2) * code.sections.shape[1]
        return new_record(code, steps, events, points + (RECORD_CAPACITY if points else 0))

    def _status(self, status: Status, pieces: RecordList) -> Status:
        if status is not Status.RUNNING:
            return status
        if pieces.steps >= self.max_steps:
            return Status.STEP_CAP
        return Status.EVENT_CAP if pieces.events >= self.max_events else status
