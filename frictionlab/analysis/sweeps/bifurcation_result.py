"""`Bifurcation`: steady states against a parameter, as `fl.bifurcation` returns them, in memory and in a
file.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionlab.analysis.steady_state.classification import MotionKind
from frictionlab.analysis.sweeps.journal import read_journal, write_journal
from frictionlab.file_writing import name_written_file
from frictionlab.models import Model
from frictionlab.models.composition import parameter_unit
from frictionlab.presentation import Drawable, count, dataframe, dataset, span, tally
from frictionlab.validation import check_choice

Array = NDArray[np.float64]


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
    def model(self) -> Model:
        """The model whose parameter was varied."""
        return Model.from_dict(self.specification["model"])

    @property
    def warnings(self) -> tuple[str | None, ...]:
        """The ``SteadyState.warning`` of each value; None where there is none."""
        return tuple(self.results.get(i, {}).get("warning") for i in range(len(self.values)))

    def __repr__(self) -> str:
        found = tally(kind or "not done" for kind in self.kinds)
        return (
            f"Bifurcation({self.parameter} {span(self.values)}, {count(len(self.values), 'value')}: {found})"
        )

    def section(self, name: str, *kinds: str) -> tuple[Array, Array]:
        """Values of the parameter and of a state at all section points, for a scatter plot.

        Parameters
        ----------
        name : str
            The state, e.g. "x1" or "x1'".
        kinds : str
            Kinds of motion; without any, all but equilibria.  "equilibrium" gives the states of equilibria
            instead.

        Raises
        ------
        ValueError
            For an unknown state.
        """
        check_choice("name", name, self.names)
        column = self.names.index(name)
        chosen = kinds or tuple({*self.kinds} - {MotionKind.EQUILIBRIUM, ""})
        found = [self._states(i)[:, column] if kind in chosen else () for i, kind in enumerate(self.kinds)]
        return np.repeat(self.values, [len(f) for f in found]), np.concatenate([*found, np.zeros(0)])

    def _states(self, i: int) -> Array:
        if self.kinds[i] == MotionKind.EQUILIBRIUM:
            return np.array([self.results[i]["final"]])
        return self.sections[i]

    def to_dataframe(self) -> Any:
        """One row for each value, as a pandas DataFrame (needs the extra ``data``)."""
        return dataframe(self._columns() | self.shares, {self.parameter: self.values}, self._units())

    def to_xarray(self) -> Any:
        """All of it as an xarray Dataset (needs the extra ``data``).

        Dimensions: the parameter; "mode" of the shares; "point" and "state" of the section points, where
        values with fewer of them than others are filled up with NaN.
        """
        along = self.parameter
        longest = max((len(s) for s in self.sections), default=0)
        section = np.full((len(self.values), longest, len(self.names)), np.nan)
        for filled, found in zip(section, self.sections):
            filled[: len(found)] = found
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
        raise ValueError(f"{path} must be a file of a bifurcation, and is one of another sweep")
    return bifurcation_from_results(specification, results)


def bifurcation_from_results(specification: dict[str, Any], results: dict[int, Any]) -> Bifurcation:
    rows = [results.get(i, {}) for i in range(len(specification["values"]))]
    names = tuple(specification["states"])
    modes = next((list(row["shares"]) for row in rows if row), [])
    return Bifurcation(
        parameter=specification["parameter"],
        values=np.array(specification["values"]),
        kinds=tuple(row.get("kind", "") for row in rows),
        periods=_column(rows, "period"),
        intensities=_column(rows, "intensity"),
        onsets=np.array([row.get("onsets", 0) for row in rows]),
        sections=tuple(np.array(row.get("section", [])).reshape(-1, len(names)) for row in rows),
        shares={m: np.array([row.get("shares", {}).get(m, np.nan) for row in rows]) for m in modes},
        names=names,
        specification=specification,
        results=results,
    )


def _column(rows: list[Any], name: str) -> Array:
    return np.array([np.nan if row.get(name) is None else row[name] for row in rows], dtype=float)
