"""What the methods share: settings that end a run, and the loop that feeds buffers to `advance`.

A method is one frozen dataclass; to add one, give it ``name``, ``degree`` and :meth:`Method.advance`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import asdict, dataclass, field
from typing import Any, ClassVar

import numpy as np

from frictionlab.hybrid import bookkeeping
from frictionlab.hybrid.buffers import Pieces, new_record, new_work
from frictionlab.hybrid.layout import Numbers
from frictionlab.hybrid.natives import Natives, natives
from frictionlab.hybrid.problem import Problem, Raw, Unbuilt
from frictionlab.hybrid.progress import Progress
from frictionlab.hybrid.start import start
from frictionlab.hybrid.status import Status
from frictionlab.hybrid.transitions import UNBUILT
from frictionlab.hybrid.validation import check_number

CHUNK = 2048  # steps between two looks at the progress bar and ctrl-C

ENDS = {
    bookkeeping.RUNNING: Status.RUNNING,
    bookkeeping.FINISHED: Status.FINISHED,
    bookkeeping.NO_ADMISSIBLE_MODE: Status.NO_ADMISSIBLE_MODE,
    bookkeeping.STALLED: Status.STALLED,
    bookkeeping.ACCUMULATED: Status.ACCUMULATED,
    bookkeeping.NOT_FINITE: Status.NOT_FINITE,
}
_COUNTED = [bookkeeping.STEPS, bookkeeping.EVENTS, bookkeeping.POINTS]


@dataclass(frozen=True)
class Run:
    """A problem under way: its arrays, as the kernels take them."""

    problem: Problem
    natives: Natives
    absolute: Numbers
    cursor: bookkeeping.Cursor
    work: bookkeeping.Work


@dataclass(frozen=True)
class Method(ABC):
    """Base of all methods; owns the bookkeeping."""

    name: ClassVar[str]
    riders: ClassVar[bool] = False  # whether sections and quadratures can ride along
    entry: ClassVar[Any]  # the kernel that takes longest to compile
    parts: ClassVar[int] = 1  # samples a step is cut into where no t_eval is given

    max_steps: int = field(default=3_000_000, kw_only=True)
    max_events: int = field(default=1_000_000, kw_only=True)

    @property
    def limits(self) -> tuple[float, float]:
        """Dwell times (s) below which events in a row pile up: without a limit mode, and with one."""
        return 0.0, 0.0

    @property
    def raises(self) -> bool:
        """Whether an accumulation ends the run."""
        return False

    @property
    @abstractmethod
    def degree(self) -> int:
        """Order of the Taylor series that choose modes and give the dense output."""

    @abstractmethod
    def advance(self, run: Run, record: bookkeeping.Record) -> int:
        """Fill `record` until it is full (bookkeeping.RUNNING), the run ends, or a mode is UNBUILT."""

    def describe(self) -> dict[str, Any]:
        """Name and settings, for the record."""
        return {"name": self.name, **asdict(self)}

    def check_caps(self) -> None:
        """Raise ValueError unless the caps are positive integers."""
        for name in ("max_steps", "max_events"):
            check_number(
                name, getattr(self, name), integer=True, least=1, cure="leave it out for the default"
            )

    def integrate(self, problem: Problem, progress: Progress) -> Raw:
        """Run the problem to its end, or as far as it goes; raise Unbuilt where it needs another mode."""
        with np.errstate(all="ignore"):
            return self._integrate(problem, progress)

    def _integrate(self, problem: Problem, progress: Progress) -> Raw:
        run, pieces, status = self._begin(problem), Pieces(), Status.RUNNING
        counts, times = run.cursor.counts, run.cursor.times
        if counts[bookkeeping.MODE] < 0:
            status = Status.NO_ADMISSIBLE_MODE
        while status is Status.RUNNING:
            record = self._record(run, pieces)
            counts[_COUNTED] = 0
            end = int(self.advance(run, record))
            run.natives.used(record.step_modes[: counts[bookkeeping.STEPS]])
            pieces.add(record, *counts[_COUNTED])
            status = self._status(ENDS.get(end, Status.RUNNING), pieces)
            if progress.update(times[bookkeeping.NOW]) and status is Status.RUNNING:
                status = Status.INTERRUPTED
            elif end <= UNBUILT:
                raise Unbuilt(UNBUILT - end)
        mode = int(counts[bookkeeping.MODE])
        return pieces.raw(problem.program.code, times[bookkeeping.NOW], run.cursor.state, mode, status)

    def _begin(self, problem: Problem) -> Run:
        absolute = Numbers(*map(np.abs, problem.numbers))
        work = new_work(problem.program.slots, problem.program.code, self.degree)
        mode = start(problem, self.degree, absolute, work)
        cursor = bookkeeping.new_cursor(problem.x0, mode, problem.t_end, self.limits, self.raises)
        cursor = cursor._replace(signs=np.zeros(problem.program.code.sections.shape[1], dtype=np.int64))
        return Run(problem, natives(problem.program), absolute, cursor, work)

    def _record(self, run: Run, pieces: Pieces) -> bookkeeping.Record:
        code = run.problem.program.code
        steps = min(CHUNK, self.max_steps - pieces.steps)
        events = min(CHUNK, self.max_events - pieces.events)
        points = (self.degree + 2) * code.sections.shape[1]
        return new_record(code, steps, events, points + (CHUNK if points else 0))

    def _status(self, status: Status, pieces: Pieces) -> Status:
        if status is not Status.RUNNING:
            return status
        if pieces.steps >= self.max_steps:
            return Status.STEP_CAP
        return Status.EVENT_CAP if pieces.events >= self.max_events else status
