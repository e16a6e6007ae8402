"""`fl.root_locus`: the eigenvalues of every mode against a parameter."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionlab.drawable import Drawable
from frictionlab.models.parameter_namespace import parameter_unit
from frictionlab.presentation import count, dataframe, dataset, span
from frictionlab.stability.equilibrium_points.equilibria import equilibrium_problem
from frictionlab.stability.equilibrium_problem import EquilibriumProblem, check_path

from .eigenvalues import UNITS, mode_shapes, participation_factors
from .mode_tracking import Modes, modes_of_matrices, track_modes

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class RootLocus(Drawable):
    """Eigenvalues of n modes at N values of a parameter, each mode in one column.

    Parameters
    ----------
    model : Model or HybridAutomaton
    parameter : str
    at : array (N,)
        Its values.
    values : complex array (N, n)
        1/s, with Im >= 0; NaN where there is no equilibrium.  Of an overdamped mode's two real eigenvalues
        it is the less stable one.
    coordinates : tuple of str
    shapes : complex array (N, n, n)
        Mode shapes: ``shapes[i, :, j]`` are the coordinates in mode j, the largest of them 1.
    participation : array (N, n, n)
        Share of each coordinate in each mode: ``participation[i, :, j]`` sums to 1.
    unstable : int array (N,)
        Number of growing pairs of eigenvalues; two real ones count as a pair, one alone too.
    """

    drawn_by = "plot_root_locus"

    model: Any
    parameter: str
    at: Array
    values: ComplexArray
    coordinates: tuple[str, ...]
    shapes: ComplexArray
    participation: Array
    unstable: NDArray[np.int_]

    @property
    def frequencies(self) -> Array:
        """Im/(2 pi), Hz, (N, n)."""
        return self.values.imag / (2 * np.pi)

    @property
    def growth_rates(self) -> Array:
        """Real parts, 1/s, (N, n)."""
        return self.values.real

    def to_dataframe(self) -> Any:
        """One row for each value of the parameter and each mode, as a pandas DataFrame (needs the extra
        ``data``).

        Columns: growth rate, frequency, and the share of each coordinate, as "participation of x1".
        """
        n, modes = self.values.shape
        columns = {"growth_rate": self.growth_rates.ravel(), "frequency": self.frequencies.ravel()}
        for i, name in enumerate(self.coordinates):
            columns[f"participation of {name}"] = self.participation[:, i].ravel()
        index = {self.parameter: np.repeat(self.at, modes), "mode": np.tile(np.arange(modes), n)}
        return dataframe(columns, index, UNITS | self._parameter_unit())

    def to_xarray(self) -> Any:
        """All of it as an xarray Dataset (needs the extra ``data``), with the parameter, "mode" and
        "coordinate" as dimensions."""
        two = (self.parameter, "mode")
        three, shapes = (self.parameter, "coordinate", "mode"), self.shapes
        variables = {"growth_rate": (two, self.growth_rates), "frequency": (two, self.frequencies)}
        variables |= {
            "unstable": (self.parameter, self.unstable),
            "participation": (three, self.participation),
        }
        variables |= {"shape_real": (three, shapes.real), "shape_imag": (three, shapes.imag)}
        coordinates = {self.parameter: self.at, "coordinate": list(self.coordinates)}
        return dataset(variables, coordinates, UNITS | self._parameter_unit())

    def _parameter_unit(self) -> dict[str, str]:
        return {self.parameter: parameter_unit(self.model, self.parameter)}

    def __repr__(self) -> str:
        path = f"{self.parameter} {span(self.at)} in {count(len(self.at), 'value')}"
        growing = f"at most {count(int(self.unstable.max()), 'pair')} of eigenvalues growing"
        return f"RootLocus({path}, {count(self.values.shape[1], 'mode')}, {growing})"


def root_locus(model: Any, parameter: str, values: Any) -> RootLocus:
    """Eigenvalues of all modes at the sliding equilibrium, for each value of a parameter.

    The modes are followed by their vectors, not sorted, so that a column is one mode through crossings and
    veerings.  Where two coalesce exactly, the order of the two beyond is arbitrary.

    Parameters
    ----------
    model : Model or HybridAutomaton
    parameter : str
    values : array_like (N,)
        Along a path: neighbours in it are compared.

    Returns
    -------
    RootLocus

    Raises
    ------
    TypeError
        For an unknown parameter, or what is no model.
    ValueError
        For a value that breaks its rule, or where no value has an equilibrium.

    Examples
    --------
    >>> import frictionlab as fl
    >>> locus = fl.root_locus(fl.SliderOnBelt(), "mu_k", [0.0, 1.0, 2.0])
    >>> locus.values.shape, [bool(rates.max() < 0) for rates in locus.growth_rates]
    ((3, 5), [True, True, False])
    """
    problem = equilibrium_problem(model)
    at = check_path(problem, parameter, values)

    def sample(points: Array) -> Modes:
        return modes_of_matrices(points, problem.linearised({parameter: points})[1])

    path: Any = sample(at)
    _refuse_nothing(path, parameter)
    path = track_modes(path, sample)
    return RootLocus(
        model,
        parameter,
        at,
        path.values,
        problem.names,
        *_shapes_and_participation(problem, path),
        path.unstable,
    )


def _shapes_and_participation(problem: EquilibriumProblem, path: Any) -> tuple[ComplexArray, Array]:
    n = len(problem.names)
    with np.errstate(invalid="ignore"):  # NaN where there is no equilibrium
        return mode_shapes(path.right, n), participation_factors(path.left, path.right, n)


def _refuse_nothing(path: Modes, parameter: str) -> None:
    if not np.isfinite(path.values).any():
        raise ValueError(
            f"there must be an equilibrium with F_N > 0 at a value of {parameter} at least, "
            f"got none from {path.at.min():g} to {path.at.max():g}: change the values or the model"
        )
