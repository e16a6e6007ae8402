"""`fl.sweep`: any function of a model over a grid of parameters and initial states."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from math import prod
from pathlib import Path
from typing import Any, Unpack

import numpy as np
from numpy.typing import NDArray

from frictionlab.analysis.initial_states import initial_state_of, named_state
from frictionlab.analysis.options import Execution, ExecutionKeywords, settings_of
from frictionlab.analysis.sweeps.function_name import function_name, own_name
from frictionlab.analysis.sweeps.journal import Journal
from frictionlab.models.composition import parameter_unit
from frictionlab.models.model import ModelOrAutomaton, data_of, require_model_or_automaton
from frictionlab.presentation import Drawable, count, import_optional, shorten, span
from frictionlab.validation import (
    abbreviate,
    check_mapping,
    check_number,
    check_sequence,
    explains_keywords,
    float_array,
)

MOST_CHECKED = 10_000  # points of a grid whose combinations of values are checked before any is computed


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
        What the function returned; None for what was not done before ctrl-C.
    model : Model or HybridAutomaton
        With the values that are not in `over`.
    function : str
        Name of the function; "result" of one that has none.
    """

    drawn_by = "plot_sweep"

    over: Mapping[str, NDArray[np.float64]]
    x0: tuple[Any, ...]
    results: NDArray[np.object_]
    model: ModelOrAutomaton
    function: str

    def __repr__(self) -> str:
        axes = [f"{name} {span(values)} ({len(values)})" for name, values in self.over.items()]
        axes += [count(len(self.x0), "initial state")] if self.x0 else []
        undone = sum(result is None for result in self.results.ravel())
        return f"Sweep({self.function} over {shorten(axes)}{f'; {undone} without result' if undone else ''})"

    def to_array(self) -> NDArray[np.float64]:
        """The results as numbers; NaN for those that are None."""
        return np.vectorize(lambda r: np.nan if r is None else float(r), otypes=[float])(self.results)

    def to_dataframe(self) -> Any:
        """One row for each point of the grid, as a pandas DataFrame (needs the extra ``data``).

        Mappings have a column for each key, other results one named "result".
        """
        pd = import_optional("pandas", "to_dataframe")
        axes = axes_of(self)
        index = pd.MultiIndex.from_product(list(axes.values()), names=list(axes))
        index = index if len(axes) > 1 else index.get_level_values(0)
        table = pd.DataFrame([_row(result) for result in self.results.ravel()], index=index)
        table.attrs["units"] = self._units()
        return table

    def _units(self) -> dict[str, str]:
        return {name: unit for name in self.over if (unit := parameter_unit(self.model, name))}

    def to_xarray(self) -> Any:
        """The table of :meth:`to_dataframe` as an xarray Dataset, a dimension for each parameter (needs the
        extra ``data``).

        The values of each parameter have to differ from each other.
        """
        import_optional("xarray", "to_xarray")
        table = self.to_dataframe().to_xarray()
        for name, unit in self._units().items():
            table[name].attrs["units"] = unit
        return table

    def labels(self) -> list[str]:
        """A label for each initial state: its name, or its index."""
        return [start if isinstance(start, str) else f"state {i}" for i, start in enumerate(self.x0)]


@explains_keywords
def sweep(
    model: ModelOrAutomaton,
    function: Callable[..., Any],
    over: Mapping[str, Any],
    *,
    x0: Sequence[Any] = (),
    shard: tuple[int, int] | None = None,
    **keywords: Unpack[ExecutionKeywords],
) -> Sweep:
    """Call a function with the model at each point of a grid of parameters.

    Parameters
    ----------
    model : Model or HybridAutomaton
    function : callable
        Called as ``function(model)``, or as ``function(model, start)`` where `x0` is given.
    over : mapping of str to array_like
        Parameters and their values.
    x0 : sequence
        Initial states: names, or arrays (2n,), as :func:`simulate` takes them.
    shard : (int, int) or None
        ``(i, n)`` computes every n-th task only, from the i-th on, i from 0 to n - 1, as one job of an array
        of n.  With ``resume="sweep.jsonl"`` the job has a file of its own, ``sweep.i-of-n.jsonl``.  The same
        call without `shard` takes over what is in such files beside its own, and computes what is missing.
    **keywords
        How tasks are run, by the names that follow.
    workers : int or None
        Threads; None takes one for each processor.  Of an executor the workers that get tasks at a time; None
        takes all that it says it has, 32 where it does not say.
    executor : concurrent.futures.Executor or None
        Used instead of threads, and left open: a ProcessPoolExecutor, or a cluster's, such as Dask's
        ``client.get_executor()``.  It gets tasks in chunks of about a second, two for each worker at a time.
    resume : path or None
        File in which results are kept as they come; results that it already holds are not computed again.
        They have to be numbers, texts, or lists and mappings of such.  The file knows the function by its
        name, its code, and the content of its closure, defaults and partial arguments: numbers, texts,
        lists, dictionaries, arrays, models, laws, functions, attributes of objects.  A function that changes
        these while it runs, as one that adds to a list or fills a cache, is refused at the next call: make
        the list or the cache anew before.  The file does not know the functions that it calls by name, nor
        methods of classes, nor states of generators of random numbers: use another file where these have
        changed.
        The complete file does not depend on the number of workers, nor on how often the sweep was
        interrupted.  Results on damaged lines are computed again, with a RuntimeWarning.
    progress : bool

    Returns
    -------
    Sweep

    Raises
    ------
    TypeError
        For an unknown parameter or keyword, or where an argument is no model or function.
    ValueError
        For a value that breaks a rule or a bad initial state.  Both are raised before any task starts, but
        for the TypeError of a result that JSON cannot hold; of a grid of more than 10,000 points the values
        are checked one by one before, their combinations where they are computed.
    OSError
        Where the file cannot be written, or another sweep is using it.
    RuntimeError
        Where the function fails, raised from its error, or the executor is lost; the results before it are in
        the file, and :func:`partial_result` returns the Sweep with None for what was not done.
    KeyboardInterrupt
        After ctrl-C; :func:`partial_result` then returns the same.  A first
        press lets tasks that have begun finish, a second one abandons them.

    Examples
    --------
    >>> import frictionlab as fl
    >>> sweep = fl.sweep(fl.SliderOnBelt(), lambda m: fl.equilibrium(m).normal_force, {"F": [100, 200]})
    >>> sweep.to_array().round(2)
    array([ 60.75, 121.54])
    """
    cure = "write sweep(model, function, over), the model made, such as fl.SliderOnBelt()"
    require_model_or_automaton(model, cure)
    check_function("function", function, "write sweep(model, function, over)")
    (how,) = settings_of("sweep", keywords, Execution)
    axes, starts = check_over(over), check_sequence("x0", x0, f"write [{abbreviate(x0)}]")
    grid = Grid(axes, starts)
    for changes in grid.points() if grid.size <= MOST_CHECKED else grid.points_of_axes():
        model.replace(**changes)
    for start in starts:
        initial_state_of(model, start)
    part = _check_shard(shard)
    path = how.resume if shard is None or how.resume is None else _file_of_shard(Path(how.resume), part)
    specification = {}
    if path is not None:
        named = {"model": data_of(model), "function": function_name(function)}
        specification = named | grid.specification()
    tasks, at_point = GridTasks(grid), FunctionAtPoint(function, model, tuple(axes))
    indices, parts = range(part[0], len(tasks), part[1]), _files_of_shards(how.resume, shard)
    with Journal(specification, path, parts) as journal:
        journal.run_tasks(at_point, tasks, tasks.name, how, "sweep", chosen=indices)
        results = [journal.results.get(i) for i in range(len(tasks))]
        return journal.finish(grid.sweep(results, model, own_name(function)), len(indices))


def _check_shard(shard: Any) -> tuple[int, int]:
    """The index and the number of shards; (0, 1) where there is one."""
    if shard is None:
        return 0, 1
    cure = "write shard=(0, 8) in the first of 8 jobs, (7, 8) in the last"
    pair = check_sequence("shard", shard, cure)
    if len(pair) != 2:
        raise ValueError(f"shard must be an index and a number of jobs, got {abbreviate(shard)}: {cure}")
    count = check_number("shard[1]", pair[1], integer=True, least=1, cure=cure)
    return check_number("shard[0]", pair[0], integer=True, least=0, below=count, cure=cure), count


def _file_of_shard(path: Path, part: tuple[int, int]) -> Path:
    """The file of one job of an array."""
    return path.with_name(f"{path.stem}.{part[0]}-of-{part[1]}{path.suffix}")


def _files_of_shards(resume: str | Path | None, shard: Any) -> list[Path]:
    """The files of an array's jobs that the sweep of the whole grid takes over."""
    if resume is None or shard is not None:
        return []
    path = Path(resume)
    form = re.compile(re.escape(path.stem) + r"\.\d+-of-\d+" + re.escape(path.suffix))
    return sorted(beside for beside in path.parent.glob("*") if form.fullmatch(beside.name))


@dataclass(frozen=True)
class FunctionAtPoint:
    """A function of a model at a point of a grid; the model is made where it is computed."""

    function: Callable[..., Any]
    model: ModelOrAutomaton
    names: tuple[str, ...]

    def __call__(self, values: Sequence[float], *start: Any) -> Any:
        return self.function(self.model.replace(**dict(zip(self.names, values))), *start)


class GridTasks(Sequence[tuple[Any, ...]]):
    """The arguments of :class:`FunctionAtPoint` at all points of a grid, made when they are asked for."""

    def __init__(self, grid: Grid) -> None:
        self._starts = grid.starts()
        self._names, self._axes = tuple(grid.over), [values.tolist() for values in grid.over.values()]
        self._shape = (*map(len, self._axes), len(self._starts))

    def __len__(self) -> int:
        return prod(self._shape)

    def __getitem__(self, i: Any) -> Any:
        if not 0 <= i < len(self):
            raise IndexError(i)
        *places, start = np.unravel_index(i, self._shape)
        return tuple(axis[k] for axis, k in zip(self._axes, places)), *self._starts[start]

    def name(self, i: int) -> str:
        """The values of a point in words."""
        return point_name(dict(zip(self._names, self[i][0])))


@dataclass(frozen=True)
class Grid:
    """All combinations of the values of some parameters, and of initial states, which vary fastest."""

    over: Mapping[str, NDArray[np.float64]]
    x0: tuple[Any, ...]

    def points(self) -> list[dict[str, float]]:
        """The values of the parameters at each point, as arguments of ``replace``."""
        return [dict(zip(self.over, map(float, point))) for point in product(*self.over.values())]

    @property
    def size(self) -> int:
        """The number of points."""
        return prod(map(len, self.over.values()))

    def points_of_axes(self) -> Iterator[dict[str, float]]:
        """Each value of each parameter once, and all combinations of least and greatest values."""
        ends = [sorted({float(values.min()), float(values.max())}) for values in self.over.values()]
        yield from (dict(zip(self.over, corner)) for corner in product(*ends))
        yield from ({name: float(value)} for name, values in self.over.items() for value in values)

    def starts(self) -> list[tuple[Any, ...]]:
        """The arguments of a function after the model: an initial state, or nothing."""
        return [(start,) for start in self.x0] or [()]

    def specification(self) -> dict[str, Any]:
        """The grid as data that JSON can hold."""
        over = {name: values.tolist() for name, values in self.over.items()}
        return {"x0": [named_state(start) for start in self.x0], "over": over}

    def sweep(self, results: Sequence[Any], model: ModelOrAutomaton, function: str) -> Sweep:
        """The results at all points, from all initial states."""
        cells = np.empty(len(results), dtype=object)
        for i, result in enumerate(results):
            cells[i] = result
        shape = [*map(len, self.over.values()), *([len(self.x0)] if self.x0 else [])]
        return Sweep(self.over, self.x0, cells.reshape(shape), model, function)


def check_over(over: Any) -> dict[str, NDArray[np.float64]]:
    """Parameters and their values (N,), one axis of a grid each."""
    cure = 'give each its values, such as {"mu_k": [0.5, 1.0]}'
    check_mapping("over", over, cure)
    axes = {
        name: float_array(f"over[{abbreviate(name)}]", values, cure).ravel() for name, values in over.items()
    }
    empty = [name for name, values in axes.items() if not len(values)]
    if empty or not axes:
        raise ValueError(
            f"over must hold values of each parameter, got none of {', '.join(empty) or 'any'}: {cure}"
        )
    return axes


def point_name(changes: Mapping[str, float]) -> str:
    """The values of parameters in words."""
    return ", ".join(f"{name} = {value:g}" for name, value in changes.items())


def axes_of(sweep: Sweep) -> dict[str, Any]:
    """The axes of a sweep: the values of each parameter, and labels of initial states if there are any."""
    return {**sweep.over, **({"x0": sweep.labels()} if sweep.x0 else {})}


def check_function(name: str, function: Any, cure: str) -> None:
    """Raise unless `function` can be called."""
    if not callable(function):
        raise TypeError(f"{name} must be a function of a model, got {abbreviate(function)}: {cure}")


def _row(result: Any) -> Mapping[str, Any]:
    if result is None:
        return {}
    return result if isinstance(result, Mapping) else {"result": result}
