"""`fl.bifurcation`: steady states against a parameter, kept in memory and in a file."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import groupby
from pathlib import Path
from typing import Any, Unpack, cast

import numpy as np
from numpy.typing import NDArray

from frictionlab.analysis.ensemble import ensemble
from frictionlab.analysis.initial_states import carried_state_of, initial_state_of, named_state
from frictionlab.analysis.options import Execution, SteadyStateOptions, StudyKeywords, settings_of
from frictionlab.analysis.steady_state.classification import MotionKind, largest_coordinate
from frictionlab.analysis.steady_state.steady_state import (
    SteadyState,
    WindowStart,
    check_section,
    find_steady_state,
    run_transient,
    settle,
)
from frictionlab.analysis.sweeps.journal import Journal, read_journal, write_journal
from frictionlab.analysis.sweeps.tasks import (
    URGENT_PRESS,
    ExecutorLost,
    TaskFailure,
    failure,
    run_tasks,
    worker_count,
)
from frictionlab.file_writing import name_written_file
from frictionlab.hybrid.methods.base import Method
from frictionlab.hybrid.methods.taylor import Taylor
from frictionlab.hybrid.solve import by_names, end_of
from frictionlab.interruption import InterruptCounter, progress_bar
from frictionlab.models.composition import parameter_unit
from frictionlab.models.model import (
    ModelOrAutomaton,
    automaton_of,
    check_parameter_name,
    data_of,
    model_from_data,
    require_model_or_automaton,
    values_of,
)
from frictionlab.presentation import Drawable, count, dataframe, dataset, span, tally
from frictionlab.stability.equilibrium_points.frozen_time import refuse_time
from frictionlab.validation import check_choice, explains_keywords, float_array

Array = NDArray[np.float64]
INITIAL_STATES = ("rest", "near", "continue")
TITLE = "bifurcation"  # of the progress bar
GROUP_SIZE = 8  # values in a task, about: enough to fill lanes, and few that have to be finished after ctrl-C
MAX_SECTION_POINTS = 200  # section points kept for each value, the last ones


@dataclass(frozen=True, eq=False)
class Bifurcation(Drawable):
    """Steady states at N values of a parameter; those not computed have the kind "".

    Parameters
    ----------
    parameter : str
    values : array (N,)
    kinds : tuple of str (N,)
        "equilibrium", "periodic", "non-periodic", "not settled yet", "ended early".
    periods, intensities : array (N,)
        s; L_s of Eq. (20).
    onsets : int array (N,)
        Transitions from slip to stick in a period.
    sections : tuple of arrays (K, 2n)
        States at the last crossings of the section, 200 at most.
    shares : mapping of str to array (N,)
        Share of time in each mode.
    names : tuple of str
        Names of the states.
    specification : mapping
        All that determines the result: model, start, method and so on.
    results : mapping of int to mapping
        The results computed, by index.
    """

    drawn_by = "plot_bifurcation"

    parameter: str
    values: Array
    kinds: tuple[str, ...]
    periods: Array
    intensities: Array
    onsets: NDArray[np.int_]
    sections: tuple[Array, ...]
    shares: dict[str, Array]
    names: tuple[str, ...]
    specification: dict[str, Any]
    results: dict[int, Any]

    @property
    def model(self) -> ModelOrAutomaton:
        """The model or automaton whose parameter was varied."""
        return model_from_data(self.specification["model"])

    @property
    def warnings(self) -> tuple[str | None, ...]:
        """The ``SteadyState.warning`` of each value; None where there is none."""
        return tuple(self.results.get(i, {}).get("warning") for i in range(len(self.values)))

    def __repr__(self) -> str:
        counts = tally(kind or "not done" for kind in self.kinds)
        at = f"{self.parameter} {span(self.values)}, {count(len(self.values), 'value')}"
        return f"Bifurcation({at}: {counts})"

    def section(self, name: str, *kinds: str) -> tuple[Array, Array]:
        """Values of the parameter and of a state at all section points, for a scatter plot.

        Parameters
        ----------
        name : str
            The state, e.g. "x1" or "x1'".
        kinds : str
            Kinds of motion; without any, all but equilibria.  For "equilibrium" the points are the states of
            equilibria.

        Raises
        ------
        ValueError
            For an unknown state.
        """
        check_choice("name", name, self.names)
        column = self.names.index(name)
        for kind in kinds:
            check_choice("kinds", kind, tuple(MotionKind), "name some of them")
        selection = kinds or tuple({*self.kinds} - {MotionKind.EQUILIBRIUM, ""})
        points = [
            self._states(i)[:, column] if kind in selection else () for i, kind in enumerate(self.kinds)
        ]
        return np.repeat(self.values, [len(f) for f in points]), np.concatenate([*points, np.zeros(0)])

    def _states(self, i: int) -> Array:
        if self.kinds[i] == MotionKind.EQUILIBRIUM:
            return np.array([self.results[i]["final"]])
        return self.sections[i]

    def to_dataframe(self) -> Any:
        """One row for each value, as a pandas DataFrame (needs the extra ``data``)."""
        return dataframe(self._columns() | self.shares, {self.parameter: self.values}, self._units())

    def to_xarray(self) -> Any:
        """The results as an xarray Dataset (needs the extra ``data``).

        Dimensions: the parameter; "mode" for the shares; "point" and "state" for the section points, which
        are filled up with NaN where a value has fewer than others.
        """
        along = self.parameter
        longest = max((len(s) for s in self.sections), default=0)
        section = np.full((len(self.values), longest, len(self.names)), np.nan)
        for filled, points in zip(section, self.sections):
            filled[: len(points)] = points
        shares = np.array(list(self.shares.values())).reshape(-1, len(self.values))
        variables = {name: (along, column) for name, column in self._columns().items()}
        variables |= {"share": (("mode", along), shares), "section": ((along, "point", "state"), section)}
        coordinates = {along: self.values, "mode": list(self.shares), "state": list(self.names)}
        return dataset(variables, coordinates, self._units())

    def _units(self) -> dict[str, str]:
        unit = parameter_unit(self.model, self.parameter)
        return {self.parameter: unit, "period": "s", "intensity": "m^2"}

    def _columns(self) -> dict[str, Any]:
        columns = {"period": self.periods, "onsets": self.onsets, "intensity": self.intensities}
        return {"kind": np.array(self.kinds, dtype=object), **columns}

    def save(self, path: str | Path) -> Path:
        """Write the result as JSON lines: what :func:`load_bifurcation` reads and `resume` continues."""
        with name_written_file(path):
            return write_journal(path, self.specification, self.results)


def load_bifurcation(path: str | Path) -> Bifurcation:
    """A result that :meth:`Bifurcation.save`, or `resume`, wrote.

    Raises
    ------
    ValueError
        If the file is not of a bifurcation.
    """
    specification, results = read_journal(path)
    if "parameter" not in specification:
        raise ValueError(
            f"{path} must be a file of a bifurcation, and is one of another sweep: give another path"
        )
    return bifurcation_from_results(specification, results)


def bifurcation_from_results(specification: dict[str, Any], results: dict[int, Any]) -> Bifurcation:
    rows = [results.get(i, {}) for i in range(len(specification["values"]))]
    names = tuple(specification["states"])
    # Of modes on demand each value has its own.
    modes = dict.fromkeys(mode for row in rows for mode in row.get("shares", {}))
    return Bifurcation(
        parameter=specification["parameter"],
        values=np.array(specification["values"]),
        kinds=tuple(row.get("kind", "") for row in rows),
        periods=_column(rows, "period"),
        intensities=_column(rows, "intensity"),
        onsets=np.array([row.get("onsets", 0) for row in rows]),
        sections=tuple(np.array(row.get("section", [])).reshape(-1, len(names)) for row in rows),
        shares={mode: np.array([_share(row, mode) for row in rows]) for mode in modes},
        names=names,
        specification=specification,
        results=results,
    )


def _share(row: dict[str, Any], mode: str) -> float:
    """The share of time in a mode: zero where a motion had none of it, NaN of one that ended early."""
    absent = 0.0 if row and row["kind"] != MotionKind.ENDED_EARLY else np.nan
    return row.get("shares", {}).get(mode, absent)


def _column(rows: list[Any], name: str) -> Array:
    return np.array([np.nan if row.get(name) is None else row[name] for row in rows], dtype=float)


@explains_keywords
def bifurcation(
    model: ModelOrAutomaton,
    parameter: str,
    values: Any,
    x0: Any = "rest",
    **keywords: Unpack[StudyKeywords],
) -> Bifurcation:
    """The steady state for each value of a parameter.

    Parameters
    ----------
    model : Model or HybridAutomaton
    parameter : str
    values : array_like (N,)
    x0 : "rest", "near", "continue", mapping or array_like (2n,)
        "continue" starts each value from where the one before ended; the first value, and one after a run
        that ended early, start from rest.  The values are then computed one after another, in one thread.
        Values that ascend and then descend show hysteresis.
    **keywords
        As for :func:`steady_state` and :func:`sweep`: ``transient=60.0, workers=2``.  With `t_max`, values
        that have not settled go on window by window.

    Returns
    -------
    Bifurcation

    Raises
    ------
    TypeError
        For an unknown parameter or keyword, or where `model` is no model.
    ValueError
        For other bad arguments, or a file of another sweep.  Both are raised before any run starts.
    OSError
        Where the file cannot be written, or another sweep is using it.
    RuntimeError
        Where a value fails, raised from its error; the results before it are in the file.
    KeyboardInterrupt
        After ctrl-C; :func:`partial_result` then returns the Bifurcation with the values that were done.  A
        first press lets those that have begun finish, some eight for each worker; a second one abandons those
        that are not done by then.

    Examples
    --------
    >>> import frictionlab as fl
    >>> model = fl.SliderOnBelt().without("geometry")
    >>> fl.bifurcation(model, "mu_k", [0.2, 1.4], transient=150, window=20, progress=False).kinds
    ('equilibrium', 'periodic')
    """
    options, how = settings_of("bifurcation", keywords, SteadyStateOptions, Execution, unused="rtol")
    if isinstance(x0, str):
        check_choice("x0", x0, INITIAL_STATES)
    models = _models(model, parameter, values)
    refuse_time(models[0], "a bifurcation diagram")
    check_section(models[0], options.section)
    starts = _initial_states(models, "rest" if _is_continued(x0) else x0)
    specification = _sweep_arguments(model, parameter, models, x0, options)
    names = [f"{parameter} = {values_of(m)[parameter]:g}" for m in models]
    run = _run_continued if _is_continued(x0) else _run_independently
    with Journal(specification, how.resume) as journal:
        journal.attempt(lambda: run(list(zip(models, starts, names)), options, journal, how))
        return journal.finish(bifurcation_from_results(specification, journal.results), len(models))


def _models(model: ModelOrAutomaton, parameter: str, values: Any) -> list[ModelOrAutomaton]:
    require_model_or_automaton(model, cure="write bifurcation(model, parameter, values)")
    check_parameter_name(model, parameter)
    values = float_array("values", values, "give those of the parameter").ravel()
    if not len(values):
        raise ValueError("values must hold at least one number, got none: give those of the parameter")
    return [model.replace(**{parameter: float(value)}) for value in values]


def _initial_states(models: Sequence[ModelOrAutomaton], x0: Any) -> list[np.ndarray]:
    """The initial state of each model; names and mappings are resolved for each."""
    first, by_name = initial_state_of(models[0], x0), isinstance(by_names(x0), (str, Mapping))
    return [first, *(initial_state_of(m, x0) if by_name else first for m in models[1:])]


def _is_continued(x0: Any) -> bool:
    return isinstance(x0, str) and x0 == "continue"


def _run_independently(
    values: Sequence[tuple[Any, np.ndarray, str]],
    options: SteadyStateOptions,
    journal: Journal,
    execution: Execution,
) -> bool:
    """Compute the values (model, initial state, name) that are not done yet; True if all then are."""
    models, starts, names = zip(*values)

    def compute(groups: Sequence[Sequence[int]]) -> bool:
        arrivals: deque[tuple[int, dict[str, Any]]] = deque()  # threads fill it before their groups are done

        def keep_arrivals() -> None:
            while arrivals:
                i, result = arrivals.popleft()
                if i not in journal.results:
                    journal.keep(i, result)

        def keep(task: int, results: list[dict[str, Any]]) -> None:
            arrivals.extend(zip(groups[task], results))
            keep_arrivals()

        def arguments(group: Sequence[int]) -> tuple[Any, ...]:
            each = [models[i] for i in group], [starts[i] for i in group], options
            return (
                each if execution.executor else (*each, lambda k, result: arrivals.append((group[k], result)))
            )

        return run_tasks(
            steady_states_task,
            [*map(arguments, groups)],
            keep=keep,
            name=lambda task: ", ".join(names[i] for i in groups[task]),
            execution=execution,
            title=TITLE,
            parts=lambda task: len(groups[task]),
            watch=keep_arrivals,
        )

    def left() -> list[int]:
        return [i for i in range(len(models)) if i not in journal.results]

    groups = _groups(left(), models, options.solver, worker_count(execution))
    try:
        return compute(groups)
    except TaskFailure as error:
        if isinstance(error, ExecutorLost) or all(len(group) == 1 for group in groups):
            raise
    # Which value of a group fails shows one by one; the group that failed is the first with values left.
    return compute([[i] for group in groups for i in group if i not in journal.results])


def _groups(
    todo: Sequence[int], models: Sequence[ModelOrAutomaton], method: Method, workers: int
) -> list[Sequence[int]]:
    """Groups of values whose transients are run side by side, each with values from all of the range.

    All workers have as many, where the values suffice: one that waits costs more than lanes save.
    The models of a group have the same modes; each value of a parameter in M of a structure has modes of its
    own.  Modes on demand stay underived, and a class derived from Taylor may do more than lanes know.
    """
    automaton = automaton_of(models[0])
    if type(method) is not Taylor or (automaton.on_demand and len(automaton.names) > 1):
        return [[i] for i in todo]
    modes = {i: automaton_of(models[i]).modes for i in todo}
    alike = [[*group] for _, group in groupby(todo, lambda i: id(modes[i]))]
    rounds = max(1, round(len(todo) / (GROUP_SIZE * workers)))
    most = -(-len(todo) // (rounds * workers))
    counts = [-(-len(group) // most) for group in alike]
    return [group[first::count] for group, count in zip(alike, counts) for first in range(count)]


def steady_states_task(
    models: Sequence[ModelOrAutomaton],
    starts: Sequence[np.ndarray],
    options: SteadyStateOptions,
    note: Callable[[int, dict[str, Any]], None] = lambda i, result: None,
) -> list[dict[str, Any]]:
    """One task: the steady states of some models, the same as if each were computed alone.

    `note` is called with each result as soon as it is known.
    """
    several, method = len(models) > 1 and options.transient > 0.0, cast("Taylor", options.method)
    x0, t = np.array(starts), options.transient
    ends = ensemble(models, t, x0=x0, method=method, workers=1, progress=False) if several else None
    results: list[dict[str, Any]] = []
    for i, model in enumerate(models):
        if ends is None or not ends.status[i].ok:
            steady = find_steady_state(model, starts[i], options, progress=False)
        else:
            mode, reach = ends.mode_names[ends.modes[i]], reach_of_transient(model, starts[i], options)
            window = WindowStart(ends.states[i], mode, options.transient, reach)
            steady = settle(model, window, options, progress=False)[0]
        results.append(_data_of(steady))
        note(i, results[-1])
    return results


def reach_of_transient(
    model: ModelOrAutomaton, start: np.ndarray, options: SteadyStateOptions
) -> Callable[[], float]:
    """What gives the largest coordinate in a transient, of which only the end is known: once, by a run."""
    return cache(lambda: largest_coordinate(run_transient(model, start, None, options, progress=False)))


def _data_of(steady: SteadyState) -> dict[str, Any]:
    """A steady state as data that JSON can hold."""
    period = None if np.isnan(steady.period) else steady.period
    end, mode = end_of(steady.trajectory)
    return {
        "kind": steady.kind,
        "period": period,
        "onsets": steady.onsets_per_period,
        "intensity": None if np.isnan(steady.intensity) else steady.intensity,
        "shares": dict(steady.time_in_mode),
        "section": steady.section.state[-MAX_SECTION_POINTS:].tolist(),
        "final": end.tolist(),
        "mode": mode,
        "warning": steady.warning,
    }


def _run_continued(
    values: Sequence[tuple[Any, np.ndarray, str]],
    options: SteadyStateOptions,
    journal: Journal,
    execution: Execution,
) -> bool:
    """The steady states one after another, each from where the one before ended; True if all were done.

    Ctrl-C stops the run in progress; the values before it are kept.
    """
    bar = progress_bar(values, TITLE, shown=execution.progress)
    start: Any = None
    mode = None
    with InterruptCounter(URGENT_PRESS, bar) as interrupts:
        for i, (model, rest, name) in enumerate(bar):
            if i not in journal.results:
                begins = rest if start is None else carried_state_of(model, start)
                result = _named_task(name, model, begins, options, mode)
                if result is None:
                    return False
                journal.keep(i, result)
            row = journal.results[i]
            ended = row["kind"] == MotionKind.ENDED_EARLY
            start, mode = (None, None) if ended else (np.array(row["final"]), row.get("mode"))
            if interrupts.count:
                return False
    return True


def _named_task(
    name: str, model: ModelOrAutomaton, start: np.ndarray, options: SteadyStateOptions, mode: str | None
) -> dict[str, Any] | None:
    """The steady state at a value; None after ctrl-C.  An error gives the value's name."""
    try:
        return _data_of(find_steady_state(model, start, options, progress=False, mode=mode))
    except KeyboardInterrupt:
        return None
    except Exception as error:
        raise failure(name, error) from error


def _sweep_arguments(
    model: ModelOrAutomaton,
    parameter: str,
    models: Sequence[ModelOrAutomaton],
    x0: Any,
    options: SteadyStateOptions,
) -> Any:
    start = named_state(x0)
    values = [values_of(m)[parameter] for m in models]
    states = list(automaton_of(model).state_names)
    about = {"model": data_of(model), "parameter": parameter, "values": values, "x0": start}
    settings = options.specification("transient", "window", "t_max", "section", "tolerance")
    return {**about, **settings, "states": states}
