"""Settings that several analyses share: how a steady state is found, and how a set of computations is run.

`SteadyStateOptions` and `Execution` hold them, each checked once when it is made.  Analyses take such an
object, its fields as keywords, or both: `merge_keywords` combines them.
"""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import Executor
from dataclasses import dataclass, fields, replace
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
    >>> options = fl.SteadyStateOptions(transient=60.0, window=10.0)
    >>> fl.steady_state(fl.SliderOnBelt(mu_k=1.4).without("geometry"), options=options).kind
    'periodic'
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
    workers : int or None
        Threads; None takes one for each processor.  Of an executor the workers that get tasks at a time; None
        takes all that it says it has, 32 where it does not say.
    executor : concurrent.futures.Executor or None
        Used instead of threads, and left open: a ProcessPoolExecutor, or a cluster's, such as Dask's
        ``client.get_executor()``.  It gets tasks in chunks of about a second, two for each worker at a time.
    resume : path or None
        File in which results are kept as they come; results that it already holds are not computed again.
        The complete file does not depend on the number of workers, nor on how often the computation was
        interrupted.  Results on damaged lines are computed again, with a RuntimeWarning.
    progress : bool

    Raises
    ------
    ValueError
        For a number of workers that is no positive integer.

    Examples
    --------
    >>> import frictionlab as fl
    >>> quietly = fl.Execution(workers=1, progress=False)
    >>> sweep = fl.sweep(fl.SliderOnBelt(), lambda m: m.F, {"F": [100, 200]}, execution=quietly)
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


def merge_keywords(
    function: str, given: Mapping[str, Any], unused: str = "", **bundles: tuple[type, Any]
) -> list[Any]:
    """Each bundle of settings, its fields replaced by the keywords that were given for them.

    Parameters
    ----------
    function : str
        Name of the calling function, for error messages.
    given : mapping of str to object
    unused : str
        Names of fields that the function does not take, separated by spaces.
    **bundles : (class, object or None)
        For each argument its class and the object that was given; None stands for the defaults.

    Raises
    ------
    TypeError
        For a keyword that is no field, or an argument of another class.
    """
    owners: dict[str, str] = {}
    for argument, (kind, bundle) in bundles.items():
        if bundle is not None and not isinstance(bundle, kind):
            raise TypeError(
                f"{argument} must be of the class {kind.__name__}, got {abbreviate(bundle)}: "
                f"write fl.{kind.__name__}(...)"
            )
        owners |= {field.name: argument for field in fields(kind) if field.name not in unused.split()}
    for name in given:
        if name not in owners:
            raise unknown_keyword(function, name, [*owners, *bundles])
    changes = {a: {n: v for n, v in given.items() if owners[n] == a} for a in bundles}
    return [_changed(bundle, kind, changes[argument]) for argument, (kind, bundle) in bundles.items()]


def _changed(bundle: Any, kind: type, changes: dict[str, Any]) -> Any:
    return kind(**changes) if bundle is None else replace(bundle, **changes)
