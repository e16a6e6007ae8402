"""`fl.stability_map`: the number of growing pairs over a plane of two parameters, and its exact boundary."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionlab.interruption import progress_bar
from frictionlab.models.composition import parameter_unit
from frictionlab.presentation import Drawable, count, dataframe, dataset, span
from frictionlab.stability.equilibrium_points.equilibria import equilibrium_problem
from frictionlab.stability.equilibrium_problem import EquilibriumProblem, check_parameter, unstable_pairs

from .boundary_curves import Boundary, boundary_curves

Array = NDArray[np.float64]
NO_EQUILIBRIUM = -1
GRID_CHUNK = 4096  # grid points between two updates of the progress bar


@dataclass(frozen=True, eq=False)
class StabilityMap(Drawable):
    """Stability of the sliding equilibrium over a grid of two parameters.

    Parameters
    ----------
    model : Model or HybridAutomaton
    x, y : str
        The parameters.
    x_values, y_values : array (nx,), (ny,)
    unstable : int array (ny, nx)
        Number of growing pairs of eigenvalues, two real ones or one alone counting as a pair; -1 where
        there is no equilibrium.
    growth : array (ny, nx)
        Largest growth rate, 1/s; NaN where there is no equilibrium.
    boundary : tuple of Boundary
        The curves on which a growth rate is zero, to rounding.
    """

    drawn_by = "plot_stability_map"

    model: Any
    x: str
    y: str
    x_values: Array
    y_values: Array
    unstable: NDArray[np.int_]
    growth: Array
    boundary: tuple[Boundary, ...]

    def to_dataframe(self) -> Any:
        """One row for each point of the grid, as a pandas DataFrame (needs the extra ``data``)."""
        columns = {"unstable": self.unstable.ravel(), "growth": self.growth.ravel()}
        up, across = np.meshgrid(self.y_values, self.x_values, indexing="ij")
        return dataframe(columns, {self.y: up.ravel(), self.x: across.ravel()}, self._units())

    def to_xarray(self) -> Any:
        """The grid as an xarray Dataset (needs the extra ``data``), with the parameters as dimensions."""
        plane = (self.y, self.x)
        variables = {"unstable": (plane, self.unstable), "growth": (plane, self.growth)}
        return dataset(variables, {self.y: self.y_values, self.x: self.x_values}, self._units())

    def _units(self) -> dict[str, str]:
        return {name: parameter_unit(self.model, name) for name in (self.x, self.y)} | {"growth": "1/s"}

    def __repr__(self) -> str:
        axes = ", ".join(
            f"{name} {span(values)} in {count(len(values), 'value')}"
            for name, values in ((self.x, self.x_values), (self.y, self.y_values))
        )
        stable = f"stable at {int((self.unstable == 0).sum())} of {self.unstable.size}"
        curves = f"{len(self.boundary)} boundary curve{'' if len(self.boundary) == 1 else 's'}"
        return f"StabilityMap({axes}; {stable}, {curves})"


def stability_map(
    model: Any, x: tuple[str, Any], y: tuple[str, Any], *, progress: bool = True
) -> StabilityMap:
    """Number of growing pairs and largest growth rate over a grid, and the curves between.

    The curves start where neighbours on the grid differ, and are followed from there; one that closes
    between the points of the grid is missed.

    Parameters
    ----------
    model : Model or HybridAutomaton
    x, y : (str, array_like)
        Two parameters and their values, ascending, two at least.
    progress : bool
        Show a progress bar where it takes more than a second.

    Returns
    -------
    StabilityMap

    Raises
    ------
    TypeError
        For an unknown parameter, or what is no model.
    ValueError
        For a value that breaks its rule, or values that do not ascend.

    Examples
    --------
    >>> import frictionlab as fl
    >>> plane = fl.stability_map(fl.SliderOnBelt(), ("F", [100, 500, 1000]), ("mu_k", [0.5, 1.5]))
    >>> plane.unstable.tolist()
    [[0, 0, 0], [0, 1, 1]]
    """
    problem = equilibrium_problem(model)
    xs, ys = (_check_axis(problem, which, given) for which, given in (("x", x), ("y", y)))
    if x[0] == y[0]:
        raise ValueError(f"x and y must be different parameters, got {x[0]!r} twice: change one")
    spectra = _spectra_on_grid(problem, (x[0], xs), (y[0], ys), progress)
    growing = np.where(np.isnan(spectra[..., 0]), NO_EQUILIBRIUM, unstable_pairs(spectra))
    curves = boundary_curves(problem, (x[0], xs), (y[0], ys), spectra)
    return StabilityMap(model, x[0], y[0], xs, ys, growing, spectra[..., 0].real, curves)


def _check_axis(problem: EquilibriumProblem, which: str, given: tuple[str, Any]) -> Array:
    try:
        name, values = given[0], np.asarray(given[1], dtype=float).ravel()
    except (TypeError, ValueError, IndexError):
        raise ValueError(
            f"{which} must be a parameter and its values, got {given!r}: ('F', [1, 2])"
        ) from None
    if len(values) < 2 or not (np.diff(values) > 0).all():
        raise ValueError(f"the values of {which} must ascend, two at least, got {values}: sort them")
    check_parameter(problem.model, name, values.tolist())
    return values


def _spectra_on_grid(
    problem: EquilibriumProblem, x: tuple[str, Array], y: tuple[str, Array], progress: bool
) -> Any:
    """Sorted spectra (ny, nx, m)."""
    across, up = (plane.ravel() for plane in np.meshgrid(x[1], y[1]))
    starts = progress_bar(range(0, len(up), GRID_CHUNK), "stability map", shown=progress)
    parts = [
        problem.spectra({x[0]: across[i : i + GRID_CHUNK], y[0]: up[i : i + GRID_CHUNK]}) for i in starts
    ]
    return np.concatenate(parts).reshape(len(y[1]), len(x[1]), -1)
