"""`fl.sweep`: any function of a model over a grid of parameters and initial states."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .journal import Journal
from .tasks import run_tasks


@dataclass(frozen=True, eq=False)
class Sweep:
    """Results over a grid.

    Parameters
    ----------
    over : mapping of str to array
        Parameters and their values, one axis of the grid each.
    x0 : tuple
        Initial states, the last axis; empty where the function takes none.
    results : object array
        What the function returned; None for what was not done (after ctrl-C).
    """

    over: Mapping[str, NDArray[np.float64]]
    x0: tuple[Any, ...]
    results: NDArray[np.object_]

    def to_array(self) -> NDArray[np.float64]:
        """The results as numbers; NaN for those that are None."""
        return np.vectorize(lambda r: np.nan if r is None else float(r), otypes=[float])(self.results)


def sweep(
    function: Callable[..., Any],
    model: Any,
    over: Mapping[str, Any],
    *,
    x0: Sequence[Any] = (),
    workers: int | None = None,
    executor: Executor | None = None,
    resume: str | Path | None = None,
    progress: bool = True,
) -> Sweep:
    """Call a function with the model at each point of a grid of parameters.

    Parameters
    ----------
    function : callable
        Called as ``function(model)``, or as ``function(model, start)`` where `x0` is given.
    model : SliderOnBelt
    over : mapping of str to array_like
        Parameters and their values.
    x0 : sequence
        Initial states, as :func:`simulate` takes them.
    workers, executor
        As :func:`bifurcation`.
    resume : path or None
        File in which results are kept as they come; they have to be numbers, texts, or lists and mappings of
        such.  The function itself is not in it: give every function a file of its own.
    progress : bool

    Returns
    -------
    Sweep

    Raises
    ------
    ValueError
        For an unknown parameter or a value that breaks a rule, before any work is done.

    Examples
    --------
    >>> import frictionlab as fl
    >>> found = fl.sweep(lambda m: fl.equilibrium(m).normal_force, fl.SliderOnBelt(), {"F": [100, 200]})
    >>> found.to_array().round(2)
    array([ 60.75, 121.54])
    """
    axes = {name: np.asarray(values, dtype=float).ravel() for name, values in over.items()}
    models = [model.replace(**dict(zip(axes, map(float, point)))) for point in product(*axes.values())]
    tasks = [(m, start) for m in models for start in x0] if x0 else [(m,) for m in models]
    starts = [s if isinstance(s, str) else np.asarray(s, dtype=float).tolist() for s in x0]
    asked = {"model": model.to_dict(), "over": {k: v.tolist() for k, v in axes.items()}, "x0": starts}
    journal = Journal(asked, resume)
    todo = [i for i in range(len(tasks)) if i not in journal.results]
    run_tasks(
        function,
        [tasks[i] for i in todo],
        keep=lambda k, result: journal.keep(todo[k], result),
        workers=workers,
        executor=executor,
        progress="sweep" if progress else None,
    )
    journal.close()
    results = np.empty(len(tasks), dtype=object)
    for i, result in journal.results.items():
        results[i] = result
    shape = [len(values) for values in axes.values()] + ([len(x0)] if x0 else [])
    return Sweep(axes, tuple(x0), results.reshape(shape))
