"""Our method without its native jets: what those are worth."""

from __future__ import annotations

from dataclasses import dataclass

from frictionlab.hybrid import bookkeeping, stepping
from frictionlab.hybrid.methods import Run
from frictionlab.hybrid.taylor import Taylor


@dataclass(frozen=True)
class Interpreted(Taylor):
    """The Taylor method on the tape alone: the program's own code holds no addresses of native code."""

    def advance(self, run: Run, record: bookkeeping.Record) -> int:
        problem = run.problem
        arrays = problem.program.code, problem.numbers, run.absolute
        return stepping.advance(*arrays, self.degree, self.tol, run.cursor, record, run.work)
