"""`fl.sweep`: any function of a model over a grid of parameters and initial states."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, Unpack

import numpy as np
from numpy.typing import NDArray

from frictionlab.analysis.options import Execution, ExecutionKeywords, merge_keywords
from frictionlab.analysis.simulate import initial_state_of, named_state
from frictionlab.models.coercion import require_model
from frictionlab.models.composition import parameter_unit
from frictionlab.presentation import Drawable, count, import_optional, shorten, span
from frictionlab.validation import check_mapping, float_array

from .journal import Journal
from .task_runner import check_function, function_name, run_tasks


@dataclass(frozen=True, eq=False)
class Sweep(Drawable):
    """Results over a grid of parameters and initial states.

    Parameters
    ----------
    over : mapping of str to array
        Parameters and their values, one axis of the grid each.
    x0 : tuple
        Initial states, the last axis; empty where the function takes none.
    results : object array
        What the function returned; None for what was not done, where ctrl-C stopped it.
    model : Model
        With the values that are not in `over`.
    function : str
        Name of the function; "result" of one that has none.
    """

    drawn_by = "plot_sweep"

    over: Mapping[str, NDArray[np.float64]]
    x0: tuple[Any, ...]
    results: NDArray[np.object_]
    model: Any
    function: str

    def __repr__(self) -> str:
        axes = [f"{name} {span(values)} ({len(values)})" for name, values in self.over.items()]
        axes += [count(len(self.x0), "initial state")] if self.x0 else []
        left = sum(result is None for result in self.results.ravel())
        return f"Sweep({self.function} over {shorten(axes)}{f'; {left} without result' if left else ''})"

    def to_array(self) -> NDArray[np.float64]:
        """The results as numbers; NaN for those that are None."""
        return np.vectorize(lambda r: np.nan if r is None else float(r), otypes=[float])(self.results)

    def to_dataframe(self) -> Any:
        """One row for each point of the grid, as a pandas DataFrame (needs the extra ``data``).

        Mappings have a column for each key, other results one named "result".
        """
        pd = import_optional("pandas", "to_dataframe")
        axes = {**self.over, **({"x0": self.labels()} if self.x0 else {})}
        index = pd.MultiIndex.from_product(list(axes.values()), names=list(axes))
        index = index if len(axes) > 1 else index.get_level_values(0)
        table = pd.DataFrame([_row(result) for result in self.results.ravel()], index=index)
        table.attrs["units"] = {
            name: unit for name in self.over if (unit := parameter_unit(self.model, name))
        }
        return table

    def to_xarray(self) -> Any:
        """The table of :meth:`to_dataframe` as an xarray Dataset, a dimension for each parameter (needs the
        extra ``data``).

        Values of a parameter have to differ.
        """
        import_optional("xarray", "to_xarray")
        return self.to_dataframe().to_xarray()

    def labels(self) -> list[str]:
        """A label for each initial state: its name, or its index."""
        return [start if isinstance(start, str) else f"state {i}" for i, start in enumerate(self.x0)]


def sweep(
    model: Any,
    function: Callable[..., Any],
    over: Mapping[str, Any],
    *,
    x0: Sequence[Any] = (),
    execution: Execution | None = None,
    **keywords: Unpack[ExecutionKeywords],
) -> Sweep:
    """Call a function with the model at each point of a grid of parameters.

    Parameters
    ----------
    model : Model
    function : callable
        Called as ``function(model)``, or as ``function(model, start)`` where `x0` is given.
    over : mapping of str to array_like
        Parameters and their values.
    x0 : sequence
        Initial states: names, or arrays (2n,), as :func:`simulate` takes them.
    execution : Execution or None
        Workers, executor, file and progress bar; None takes the usual ones.  Results that the file of
        `resume` keeps have to be numbers, texts, or lists and mappings of such.  Of the function the file
        knows only the name: give every function, and every setting that it has inside, a file of its own.
    **keywords
        Fields of :class:`Execution`, in the place of those of `execution`: ``workers=2``.

    Returns
    -------
    Sweep

    Raises
    ------
    TypeError
        For an unknown parameter or keyword, what is no function, or no model.
    ValueError
        For a value that breaks a rule or a bad initial state; like the others before any work is done.
    OSError
        Where the file cannot be written, or another sweep is using it.
    RuntimeError
        Where the function fails, from its error; what was done before is in the file.
    KeyboardInterrupt
        After ctrl-C; :func:`partial_result` is then the Sweep with None for what was not done.  A first press
        lets what has begun be finished, a second one leaves it.

    Examples
    --------
    >>> import frictionlab as fl
    >>> found = fl.sweep(fl.SliderOnBelt(), lambda m: fl.equilibrium(m).normal_force, {"F": [100, 200]})
    >>> found.to_array().round(2)
    array([ 60.75, 121.54])
    """
    require_model(model, cure="write sweep(model, function, over), the model made, such as fl.SliderOnBelt()")
    check_function("function", function, "write sweep(model, function, over)")
    (how,) = merge_keywords("sweep", keywords, execution=(Execution, execution))
    axes = grid_axes(over)
    points = list(product(*axes.values()))
    models = [model.replace(**dict(zip(axes, map(float, point)))) for point in points]
    if isinstance(x0, (str, Mapping)):
        raise ValueError(f"x0 must be a sequence of initial states, got {x0!r}: write [{x0!r}]")
    starts = [named_state(start) for start in x0]
    for start in starts:
        initial_state_of(model, start)
    specification = {"function": function_name(function), "model": model.to_dict(), "x0": starts}
    specification |= {"over": {k: v.tolist() for k, v in axes.items()}}
    tasks = [(m, start) for m in models for start in x0] if starts else [(m,) for m in models]
    with Journal(specification, how.resume) as journal:
        complete = run_tasks(
            function,
            tasks,
            keep=journal.keep,
            names=[_point(axes, points[i // (len(starts) or 1)]) for i in range(len(tasks))],
            done=frozenset(journal.results),
            execution=how,
            title="sweep",
        )
        journal.put_in_order()
    results = np.empty(len(tasks), dtype=object)
    for i, result in journal.results.items():
        results[i] = result
    shape = [len(values) for values in axes.values()] + ([len(starts)] if starts else [])
    found = Sweep(axes, tuple(x0), results.reshape(shape), model, own_name(function))
    if not complete:
        raise journal.interruption(found, len(tasks))
    return found


def grid_axes(over: Mapping[str, Any]) -> dict[str, NDArray[np.float64]]:
    """Parameters and their values (N,), one axis of a grid each."""
    cure = 'give each its values, such as {"mu_k": [0.5, 1.0]}'
    check_mapping("over", over, cure)
    axes = {name: float_array(f"over[{name!r}]", values, cure).ravel() for name, values in over.items()}
    empty = [name for name, values in axes.items() if not len(values)]
    if empty or not axes:
        raise ValueError(
            f"over must hold values of each parameter, got none of {', '.join(empty) or 'any'}: {cure}"
        )
    return axes


def _point(axes: Mapping[str, Any], point: tuple[float, ...]) -> str:
    return ", ".join(f"{name} = {value:g}" for name, value in zip(axes, point))


def own_name(function: Callable[..., Any]) -> str:
    """The name of a function; "result" of one that has none."""
    name = getattr(function, "__name__", "<lambda>")
    return "result" if name == "<lambda>" else name


def _row(result: Any) -> Mapping[str, Any]:
    if result is None:
        return {}
    return result if isinstance(result, Mapping) else {"result": result}


def studies_by_name(studies: Any) -> dict[str, Callable[..., Any]]:
    """The studies by name."""
    named = dict(studies) if isinstance(studies, Mapping) else {own_name(studies): studies}
    if not named:
        raise ValueError('studies must be one at least, got none: give {"onset": a function of a model}')
    for study in named.values():
        check_function(
            "studies" if isinstance(studies, Mapping) else "study", study, "give one such as fl.steady_state"
        )
    return {str(name): study for name, study in named.items()}
