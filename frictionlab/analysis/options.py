"""Settings that several analyses share: how a steady state is found, and how many of them are computed.

`SteadyStateOptions` and `Execution` hold them, each checked once when it is made.  Analyses take them whole
or field by field: `merge_keywords` puts the two together.
"""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import Executor
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, TypedDict

from frictionlab.hybrid.methods.base import Method
from frictionlab.hybrid.solve import method_of
from frictionlab.validation import abbreviate, check_number, did_you_mean, store_plain_numbers

from .steady_state.poincare_sections import Section


@dataclass(frozen=True)
class SteadyStateOptions:
    """How a run is taken to what it settles to, and what that is.

    Parameters
    ----------
    transient, window : float
        Seconds that are thrown away, and that are looked at.
    t_max : float or None
        Go on, window by window, until the motion has settled or so many seconds have passed; None looks at
        one window only.  Not for basins.
    method : "taylor", Taylor, RK4, ...
        A name becomes the method.
    section : None, "stick", str or (str, int)
        Where recurrence is looked at: transitions from slip to stick, or where an expression of the states
        (or an output, "penetration") passes zero.  None takes the first where there are such transitions,
        else ("x1'", -1).
    tolerance : float
        Share of the motion's size within which a periodic motion returns.
    rtol : float
        Share of the attractors' size within which a motion counts as having reached one, in every state.
        For basins only.

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
        store_plain_numbers(self)
        check_number("window", self.window, above=0.0, cure="give the seconds to look at")
        check_number("transient", self.transient, least=0.0, cure="give the seconds to throw away")
        check_number("tolerance", self.tolerance, above=0.0, cure="1e-6 suits the exact solver")
        check_number("rtol", self.rtol, above=0.0, below=1.0, cure="1e-3 suits attractors well apart")
        if self.t_max is not None:
            check_number("t_max", self.t_max, above=0.0, cure="give the most seconds to go on for")
        object.__setattr__(self, "method", method_of(self.method))

    @property
    def solver(self) -> Method:
        """The method."""
        return method_of(self.method)


@dataclass(frozen=True)
class Execution:
    """How many independent computations are done.

    Parameters
    ----------
    workers : int or None
        Threads; None takes one for each processor.
    executor : concurrent.futures.Executor or None
        Used instead of threads, and left open: a ProcessPoolExecutor, or a cluster's, such as Dask's
        ``client.get_executor()``.
    resume : path or None
        File in which results are kept as they come; if it is there, what it holds is not computed again.  In
        the end it does not depend on the number of workers, or on how often the computation was cut off.
        Damaged lines are computed again, with a RuntimeWarning.
    progress : bool

    Raises
    ------
    ValueError
        For a number of workers that is none.

    Examples
    --------
    >>> import frictionlab as fl
    >>> quietly = fl.Execution(workers=1, progress=False)
    >>> found = fl.sweep(fl.SliderOnBelt(), lambda m: m.F, {"F": [100, 200]}, execution=quietly)
    """

    workers: int | None = None
    executor: Executor | None = None
    resume: str | Path | None = None
    progress: bool = True

    def __post_init__(self) -> None:
        store_plain_numbers(self)
        if self.workers is not None:
            check_number(
                "workers", self.workers, integer=True, least=1, cure="leave it out for all processors"
            )


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
    """The fields of both."""


def merge_keywords(
    function: str, given: Mapping[str, Any], unused: str = "", **bundles: tuple[type, Any]
) -> list[Any]:
    """Each bundle of settings with the keywords that were given in the place of its fields.

    Parameters
    ----------
    function : str
        What errors call the function that was given them.
    given : mapping of str to object
    unused : str
        Names of fields that the function has no use for.
    **bundles : (class, object or None)
        Of each argument its class and what was given; None stands for the defaults.

    Raises
    ------
    TypeError
        For a keyword that is no field, or an argument that is of another class.
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
            raise TypeError(f"{function} takes no {name!r}{did_you_mean(name, [*owners, *bundles])}")
    changes = {a: {n: v for n, v in given.items() if owners[n] == a} for a in bundles}
    return [_changed(bundle, kind, changes[argument]) for argument, (kind, bundle) in bundles.items()]


def _changed(bundle: Any, kind: type, changes: dict[str, Any]) -> Any:
    return kind(**changes) if bundle is None else replace(bundle, **changes)
