"""The Taylor method."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

from frictionlab.hybrid import bookkeeping, stepping
from frictionlab.hybrid.affine import advance_affine, change_of, is_affine
from frictionlab.hybrid.jets import HIGHEST
from frictionlab.hybrid.methods import Method, Run
from frictionlab.hybrid.validation import check_choice, check_number


@dataclass(frozen=True)
class Taylor(Method):
    """Taylor series of high order, with every event found to rounding error.

    Parameters
    ----------
    tol : float
        Relative size of the last terms kept, for coordinates and velocities each by their own scale.
    order : int or None
        Order of the series; None takes ceil(1 - 0.7 ln(tol)), 26 at 1e-15.  Where products dominate the
        cost, 0.5 would be cheapest (Jorba & Zou 2005); these models are mostly affine, which favours more.
    chatter : float
        Two flights in a row shorter than this (in seconds) are taken for chatter, and replaced by its limit
        (mode "chatter"); the error goes with the square of it.  0 walks through every flight.
    dwell : float
        Two flights in a row shorter than this (in seconds), where there is no such limit, are taken for an
        accumulation of impacts, which is closed: the gap rate set to zero.
    accumulation : "close" or "raise"
        Whether to go on after chatter or an accumulation, counted in ``run.stats``, or end the run there.
    max_steps, max_events : int
        A run that reaches one ends with a status and keeps what it has.

    Examples
    --------
    >>> import frictionlab as fl
    >>> method = fl.Taylor(tol=1e-6)
    >>> method.degree
    11
    >>> fl.simulate(fl.SliderOnBelt(mu_k=1.4), 0.05, method=method).events.target.tolist()
    ['stick']
    """

    name: ClassVar[str] = "taylor"
    entry: ClassVar[Any] = staticmethod(stepping.advance)
    riders: ClassVar[bool] = True
    parts: ClassVar[int] = 8

    tol: float = 1e-15
    order: int | None = None
    chatter: float = 1e-7
    dwell: float = 1e-12
    accumulation: Literal["close", "raise"] = "close"

    def __post_init__(self) -> None:
        check_number("tol", self.tol, above=0.0, below=0.1, cure="take 1e-15 for full accuracy")
        if self.order is not None:
            check_number("order", self.order, integer=True, least=4, most=HIGHEST, cure="20 is a good order")
        check_number("chatter", self.chatter, least=0.0, cure="1e-7 s is the default")
        check_number("dwell", self.dwell, least=0.0, cure="1e-12 s is the default")
        check_choice("accumulation", self.accumulation, ("close", "raise"))
        self.check_caps()

    @property
    def degree(self) -> int:
        return self.order or max(4, math.ceil(1 - 0.7 * math.log(self.tol)))

    @property
    def limits(self) -> tuple[float, float]:
        return self.dwell, self.chatter

    @property
    def raises(self) -> bool:
        return self.accumulation == "raise"

    def advance(self, run: Run, record: bookkeeping.Record) -> int:
        numbers, cursor = run.problem.numbers, run.cursor
        arrays, settings = (run.natives.code, numbers, run.absolute), (self.degree, self.tol)
        if is_affine(run.problem.program):
            change = change_of(run.natives.code, numbers, *settings, cursor.state, run.work.jets)
            cursor.counts[bookkeeping.READY] = 0  # the jets at hand have been overwritten
            if change is not None:
                return advance_affine(*arrays, *settings, change, cursor, record, run.work)
        return stepping.advance(*arrays, *settings, cursor, record, run.work)
