"""`fl.bifurcation`: steady states against a parameter."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionlab.hybrid.choice import method_of
from frictionlab.hybrid.methods import Method
from frictionlab.hybrid.validation import check_choice
from frictionlab.models import SliderOnBelt

from .journal import Journal, read, write
from .sections import Section
from .simulate import initial_state
from .steady_state import EQUILIBRIUM, steady_state
from .tasks import run_tasks

Array = NDArray[np.float64]
KEPT = 200  # section points that are kept of each value, the last ones


@dataclass(frozen=True, eq=False)
class Bifurcation:
    """Steady states at N values of a parameter; those not computed (after ctrl-C) have the kind "".

    Parameters
    ----------
    parameter : str
    values : array (N,)
    kinds : tuple of str (N,)
        "equilibrium", "periodic", "non-periodic", "not settled yet".
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
    asked : mapping
        All that determines the result: model, start, method and so on.
    results : mapping of int to mapping
        What was computed, by index.
    """

    parameter: str
    values: Array
    kinds: tuple[str, ...]
    periods: Array
    intensities: Array
    onsets: NDArray[np.int_]
    sections: tuple[Array, ...]
    shares: dict[str, Array]
    names: tuple[str, ...]
    asked: dict[str, Any]
    results: dict[int, Any]

    @property
    def model(self) -> SliderOnBelt:
        """The model whose parameter was varied."""
        return SliderOnBelt.from_dict(self.asked["model"])

    def section(self, name: str, *kinds: str) -> tuple[Array, Array]:
        """Values of the parameter and of a state at all section points, for a scatter plot.

        Parameters
        ----------
        name : str
            The state, e.g. "x1" or "x1'".
        kinds : str
            Kinds of motion; none takes all that move.  "equilibrium" gives the states at rest instead.

        Raises
        ------
        ValueError
            For an unknown state.
        """
        check_choice("name", name, self.names)
        column = self.names.index(name)
        chosen = kinds or tuple({*self.kinds} - {EQUILIBRIUM, ""})
        found = [self._states(i)[:, column] if kind in chosen else () for i, kind in enumerate(self.kinds)]
        return np.repeat(self.values, [len(f) for f in found]), np.concatenate([*found, np.zeros(0)])

    def _states(self, i: int) -> Array:
        if self.kinds[i] == EQUILIBRIUM:
            return np.array([self.results[i]["final"]])
        return self.sections[i]

    def to_dataframe(self) -> Any:
        """One row for each value, as a pandas DataFrame (needs the extra ``data``)."""
        try:
            import pandas as pd
        except ImportError as error:
            raise ImportError("to_dataframe needs pandas: pip install 'frictionlab[data]'") from error
        columns = {
            "kind": self.kinds,
            "period": self.periods,
            "onsets": self.onsets,
            "intensity": self.intensities,
        }
        return pd.DataFrame({**columns, **self.shares}, index=pd.Index(self.values, name=self.parameter))

    def save(self, path: str | Path) -> Path:
        """Write the result as JSON lines: what :func:`load_bifurcation` reads and `resume` continues."""
        return write(path, self.asked, self.results)


def load_bifurcation(path: str | Path) -> Bifurcation:
    """A result that :meth:`Bifurcation.save`, or `resume`, wrote.

    Raises
    ------
    ValueError
        If the file is none.
    """
    return _collected(*read(path))


def bifurcation(
    model: Any,
    parameter: str,
    values: Any,
    x0: Any = "rest",
    *,
    transient: float = 200.0,
    window: float = 100.0,
    method: str | Method = "taylor",
    section: Section | None = None,
    tolerance: float = 1e-6,
    workers: int | None = None,
    executor: Executor | None = None,
    resume: str | Path | None = None,
    progress: bool = True,
) -> Bifurcation:
    """The steady state for each value of a parameter.

    Parameters
    ----------
    model : SliderOnBelt
    parameter : str
    values : array_like (N,)
    x0 : "rest", "near", "continue" or array_like (2n,)
        "continue" starts each value from where the one before ended, the first from rest: ascending and
        descending values show hysteresis.  One after another, so in one thread.
    transient, window, method, section, tolerance
        As :func:`steady_state`.
    workers : int or None
        Threads; None takes one for each processor.
    executor : concurrent.futures.Executor or None
        Used instead of threads: a ProcessPoolExecutor, or a cluster's, such as Dask's
        ``client.get_executor()``.
    resume : path or None
        File in which results are kept as they come; if it is there, what it holds is not computed again.
    progress : bool

    Returns
    -------
    Bifurcation
        After ctrl-C with the values that were done.

    Raises
    ------
    ValueError
        For bad arguments, before any work is done.
    """
    values = np.asarray(values, dtype=float).ravel()
    models = [model.replace(**{parameter: float(value)}) for value in values]
    settings = {"transient": transient, "window": window, "section": section, "tolerance": tolerance}
    asked = _asked(model, parameter, values, x0, method, settings)
    journal = Journal(asked, resume)
    todo = [i for i in range(len(values)) if i not in journal.results]
    options = {**settings, "method": method_of(method)}
    if isinstance(x0, str) and x0 == "continue":
        _in_turn(models, options, journal, progress)
    else:
        initial_state(model, x0)
        tasks = [(models[i], x0, options) for i in todo]
        bar = f"bifurcation over {parameter}" if progress else None
        run_tasks(
            one,
            tasks,
            keep=lambda k, r: journal.keep(todo[k], r),
            workers=workers,
            executor=executor,
            progress=bar,
        )
    journal.close()
    return _collected(asked, journal.results)


def one(model: Any, x0: Any, options: dict[str, Any]) -> dict[str, Any]:
    """One task: the steady state as data that JSON can hold."""
    found = steady_state(model, x0, progress=False, **options)
    period = None if np.isnan(found.period) else found.period
    return {
        "kind": found.kind,
        "period": period,
        "onsets": found.onsets_per_period,
        "intensity": None if np.isnan(found.intensity) else found.intensity,
        "shares": dict(found.time_in_mode),
        "section": found.section.state[-KEPT:].tolist(),
        "final": found.trajectory.final_state.tolist(),
    }


def _in_turn(models: Sequence[Any], options: dict[str, Any], journal: Journal, progress: bool) -> None:
    """Each from where the one before ended; ctrl-C ends it with what is done."""
    from tqdm.auto import tqdm

    start: Any = "rest"
    try:
        for i, model in enumerate(tqdm(models, "bifurcation", delay=1.0, leave=False, disable=not progress)):
            if i not in journal.results:
                journal.keep(i, one(model, start, options))
            start = np.array(journal.results[i]["final"])
    except KeyboardInterrupt:
        return


def _asked(model: Any, parameter: str, values: Array, x0: Any, method: Any, settings: dict[str, Any]) -> Any:
    start = x0 if isinstance(x0, str) else np.asarray(x0, dtype=float).tolist()
    about = {"model": model.to_dict(), "parameter": parameter, "values": values.tolist(), "x0": start}
    names = [symbol.name for symbol in model.automaton().states]
    return {**about, "method": method_of(method).describe(), **settings, "states": names}


def _collected(asked: dict[str, Any], results: dict[int, Any]) -> Bifurcation:
    rows = [results.get(i, {}) for i in range(len(asked["values"]))]
    names = tuple(asked["states"])
    modes = next((list(row["shares"]) for row in rows if row), [])
    return Bifurcation(
        parameter=asked["parameter"],
        values=np.array(asked["values"]),
        kinds=tuple(row.get("kind", "") for row in rows),
        periods=_column(rows, "period"),
        intensities=_column(rows, "intensity"),
        onsets=np.array([row.get("onsets", 0) for row in rows]),
        sections=tuple(np.array(row.get("section", [])).reshape(-1, len(names)) for row in rows),
        shares={m: np.array([row.get("shares", {}).get(m, np.nan) for row in rows]) for m in modes},
        names=names,
        asked=asked,
        results=results,
    )


def _column(rows: list[Any], name: str) -> Array:
    return np.array([np.nan if row.get(name) is None else row[name] for row in rows], dtype=float)
