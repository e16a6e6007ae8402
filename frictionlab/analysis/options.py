"""Settings that several analyses share: how a steady state is found, and how a set of computations is run.

`SteadyStateOptions` and `Execution` hold them, each checked once when it is made.  Analyses take their fields
as keywords (`settings_of`).
"""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import Executor
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, TypedDict

from frictionlab.hybrid.methods.base import Method
from frictionlab.hybrid.solve import method_of
from frictionlab.validation import (
    abbreviate,
    check_field,
    check_flag,
    check_path,
    explains_fields,
    unknown_keyword,
)

from .steady_state.poincare_sections import Section, check_section_form


@explains_fields
@dataclass(frozen=True)
class SteadyStateOptions:
    """How a steady state is found and classified.

    Parameters
    ----------
    transient, window : float
        Seconds that are discarded, and seconds after them that are classified.
    t_max : float or None
        Longest time: windows follow each other until the motion has settled or this many seconds have passed.
        None takes one window only.  Not for basins.
    method : "taylor", Taylor, RK4, ...
        A name is replaced by the method of that name.
    section : None, "stick", str or (str, int)
        Where recurrence is checked: transitions from slip to stick, or where an expression of the states
        (or an output, "penetration") passes zero.  None takes the transitions where there are enough,
        else ("x1'", -1).
    tolerance : float
        Share of the motion's size within which a periodic motion returns.
    rtol : float
        A motion counts as having reached an attractor where every state is within this share of the
        attractors' size.  For basins only.

    Raises
    ------
    ValueError
        For a value that breaks its rule.

    Examples
    --------
    >>> import frictionlab as fl
    >>> options = fl.SteadyStateOptions(transient=300.0)
    >>> round(fl.OrbitPeriod(options=options)(fl.MassOnBelt()), 9)
    8.902605408
    """

    transient: float = 200.0
    window: float = 100.0
    t_max: float | None = None
    method: str | Method = "taylor"
    section: Section | None = None
    tolerance: float = 1e-6
    rtol: float = 1e-3

    def __post_init__(self) -> None:
        check_field(self, "window", above=0.0, cure="give the seconds to look at")
        check_field(self, "transient", least=0.0, cure="give the seconds to throw away")
        check_field(self, "tolerance", above=0.0, cure="1e-6 suits the exact solver")
        check_field(self, "rtol", above=0.0, below=1.0, cure="1e-3 suits attractors well apart")
        if self.t_max is not None:
            check_field(self, "t_max", above=0.0, cure="give the most seconds to go on for")
        if self.section is not None:
            check_section_form(self.section)
        object.__setattr__(self, "method", method_of(self.method))

    @property
    def solver(self) -> Method:
        """The method as an object, also where it was given by name."""
        return method_of(self.method)

    def specification(self, *names: str) -> dict[str, Any]:
        """The method and some other fields, as data by which files tell computations apart."""
        return {name: getattr(self, name) for name in names} | {"method": self.solver.describe()}


@explains_fields
@dataclass(frozen=True)
class Execution:
    """How a set of independent computations is run: in which workers, with which file and progress bar.

    Parameters
    ----------
    workers, executor, resume, progress
        As for :func:`frictionlab.sweep`.

    Raises
    ------
    ValueError
        For a number of workers that is no positive integer.
    """

    workers: int | None = None
    executor: Executor | None = None
    resume: str | Path | None = None
    progress: bool = True

    def __post_init__(self) -> None:
        if self.workers is not None:
            check_field(self, "workers", integer=True, least=1, cure="leave it out for all processors")
        if self.executor is not None and not callable(getattr(self.executor, "submit", None)):
            raise TypeError(
                f"executor must be one of concurrent.futures, got {abbreviate(self.executor)}: "
                "give one such as ProcessPoolExecutor(), or workers=2 for threads"
            )
        if self.resume is not None:
            check_path("resume", self.resume)
        check_flag("progress", self.progress)


class SteadyStateKeywords(TypedDict, total=False):
    """The fields of :class:`SteadyStateOptions`, for editors and type checkers."""

    transient: float
    window: float
    t_max: float | None
    method: str | Method
    section: Section | None
    tolerance: float
    rtol: float


class ExecutionKeywords(TypedDict, total=False):
    """The fields of :class:`Execution`, for editors and type checkers."""

    workers: int | None
    executor: Executor | None
    resume: str | Path | None
    progress: bool


class StudyKeywords(SteadyStateKeywords, ExecutionKeywords, total=False):
    """The fields of :class:`SteadyStateOptions` and :class:`Execution`."""


def settings_of(function: str, values: Mapping[str, Any], *kinds: type, unused: str = "") -> list[Any]:
    """An object of each class of settings, from the keywords that a function was given.

    Parameters
    ----------
    function : str
        Its name, for error messages.
    values : mapping of str to object
        The keywords.
    *kinds : type
        `SteadyStateOptions`, `Execution` or both.
    unused : str
        Names of fields that the function does not take, separated by spaces.

    Raises
    ------
    TypeError
        For a keyword that is no field.
    """
    names_of = {kind: [f.name for f in fields(kind) if f.name not in unused.split()] for kind in kinds}
    every = [name for names in names_of.values() for name in names]
    for name in values:
        if name not in every:
            raise unknown_keyword(function, name, every)
    return [
        kind(**{name: values[name] for name in names if name in values}) for kind, names in names_of.items()
    ]
