"""`fl.eigenvalues`: eigenvalues of the system linearised about steady sliding, Eq. (19)."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any, TypeVar, overload

import numpy as np
from numpy.typing import NDArray

from frictionlab.models.model import ModelOrAutomaton
from frictionlab.presentation import Drawable, dataframe, dataset, shorten
from frictionlab.stability.equilibrium_points.borders import borders_at
from frictionlab.stability.equilibrium_points.equilibria import Equilibrium, equilibrium, equilibrium_problem
from frictionlab.stability.equilibrium_points.sliding import sliding_equations
from frictionlab.stability.equilibrium_problem import EquilibriumProblem
from frictionlab.stability.large_system import LargeSystem
from frictionlab.stability.state_matrices import (
    eigenpairs_of_matrices,
    eigenvalue_order,
    is_neutral,
    left_eigenvectors,
)

Array = NDArray[np.float64]
UNITS = {"growth_rate": "1/s", "frequency": "Hz"}  # in tables
ComplexArray = NDArray[np.complex128]
E = TypeVar("E", bound="Eigenvalues")


@dataclass(frozen=True, eq=False)
class Eigenvalues(Drawable):
    """Eigenvalues and modes of the linearised system.

    Parameters
    ----------
    values : complex array (m,)
        1/s, by ascending magnitude of the imaginary part; conjugate pairs are adjacent.  A growth rate that
        rounding of the state matrix could explain is 0.
    vectors : complex array (m, m)
        The eigenvectors as columns: coordinates, then velocities, then further states; m = 2n without these.
        Of coordinates that turn together m does not count one, from which the others are measured; nor does
        it count a coordinate, and its velocity, that a closed rigid contact gives by the others.
    equilibrium : Equilibrium
        Where the system was linearised.
    """

    drawn_by = "plot_eigenvalues"
    instead_of_array = "write .values"

    values: ComplexArray
    vectors: ComplexArray
    equilibrium: Equilibrium

    @property
    def frequencies(self) -> Array:
        """|Im|/(2 pi), Hz, (m,)."""
        return np.abs(self.values.imag) / (2 * np.pi)

    @property
    def growth_rates(self) -> Array:
        """Real parts, 1/s, (m,): positive ones grow, those that are 0 neither grow nor decay."""
        return self.values.real

    @property
    def damping_ratios(self) -> Array:
        """-Re/|lambda|, (m,): shares of critical damping, negative where a mode grows; 0 for lambda = 0."""
        return damping_ratios(self.values)

    @property
    def stable(self) -> bool:
        """Whether every growth rate is negative."""
        return bool((self.growth_rates < 0).all())

    @property
    def marginal(self) -> bool:
        """Whether no mode grows, and not all decay, as without damping."""
        return bool(self.growth_rates.max() == 0.0)

    @property
    def shapes(self) -> ComplexArray:
        """Mode shapes (n, m) as columns: the coordinates, the largest of them 1."""
        return mode_shapes(self.vectors, len(self.equilibrium.q))

    @property
    def participation(self) -> Array:
        """Share of each coordinate in each mode, (n, m); columns sum to 1."""
        problem = equilibrium_problem(self.equilibrium.model)
        matrix = problem.without_following(_state_matrix(problem, self.equilibrium.state))
        right = np.delete(self.vectors, problem.following, axis=0)
        (left,) = left_eigenvectors(matrix[None], self.values[None], right[None])
        left = problem.with_following(left.T).T
        return participation_factors(left, self.vectors, len(self.equilibrium.q))

    def to_dataframe(self) -> Any:
        """One row for each eigenvalue, as a pandas DataFrame (needs the extra ``data``).

        Columns: growth rate, frequency, damping ratio, and the share of each coordinate, as "participation of
        x1".
        """
        shares = zip(self.equilibrium.names, self.participation)
        columns = {"growth_rate": self.growth_rates, "frequency": self.frequencies}
        columns |= {"damping_ratio": self.damping_ratios}
        columns |= {f"participation of {name}": share for name, share in shares}
        return dataframe(columns, {"eigenvalue": np.arange(len(self.values))}, UNITS)

    def to_xarray(self) -> Any:
        """Growth rates, frequencies, participation and mode shapes as an xarray Dataset (needs the extra
        ``data``), with the dimensions "eigenvalue" and "coordinate"."""
        one, both, shapes = "eigenvalue", ("coordinate", "eigenvalue"), self.shapes
        variables = {"growth_rate": (one, self.growth_rates), "frequency": (one, self.frequencies)}
        variables |= {"participation": (both, self.participation)}
        variables |= {"shape_real": (both, shapes.real), "shape_imag": (both, shapes.imag)}
        names = {"coordinate": list(self.equilibrium.names)}
        return dataset(variables, names, UNITS)

    def __repr__(self) -> str:
        upper = self.values[self.values.imag >= 0]  # one of each conjugate pair
        rates = (f"{v.real:+.3g}" if v.real else "0" for v in upper)
        modes = shorten(f"{rate}/s at {v.imag / (2 * np.pi):.4g} Hz" for rate, v in zip(rates, upper))
        kind = "stable" if self.stable else "marginal" if self.marginal else "unstable"
        return f"Eigenvalues({kind}: {modes})"


@overload
def eigenvalues(model: LargeSystem[E]) -> E: ...


@overload
def eigenvalues(model: ModelOrAutomaton) -> Eigenvalues: ...


def eigenvalues(model: ModelOrAutomaton) -> Eigenvalues:
    """Eigenvalues at the sliding equilibrium, Eq. (19), from the exact Jacobian of the sliding mode.

    Parameters
    ----------
    model : Model, HybridAutomaton or Structure
        Of a structure, those within its window of frequencies.

    Returns
    -------
    Eigenvalues
        With `values`, `frequencies` (Hz), `growth_rates` (1/s), `stable`, `marginal`, `vectors`, `shapes`,
        `participation` and the `equilibrium`; of a structure :class:`WindowEigenvalues`.

    Raises
    ------
    TypeError
        If it is neither a model nor an automaton.
    ValueError
        If there is no sliding equilibrium with F_N > 0, or the belt rests.

    Warns
    -----
    RuntimeWarning
        Where the equilibrium is on a border of a law in pieces, on whose sides eigenvalues differ.

    Examples
    --------
    >>> import frictionlab as fl
    >>> fl.eigenvalues(fl.ModeCoupling())
    Eigenvalues(stable: -0.0968/s at 0.1894 Hz, -0.00323/s at 0.1894 Hz)
    >>> fl.eigenvalues(fl.TwoBlocks())  # without damping
    Eigenvalues(marginal: 0/s at 0.1592 Hz, 0/s at 0.2935 Hz)
    >>> modes = fl.eigenvalues(fl.SliderOnBelt(mu_k=1.4))
    >>> modes.stable, modes.frequencies.round(2)[::2].tolist()
    (True, [13.51, 14.92, 15.71, 17.74, 25.63])
    """
    if isinstance(model, LargeSystem):
        return model.find_eigenvalues()
    point = equilibrium(model)
    if borders := borders_at(model, point.state):
        warnings.warn(
            f"the equilibrium is on the border {borders[0]} of a law in pieces: the eigenvalues are those "
            "above it, and others hold below",
            RuntimeWarning,
            2,
        )
    problem = equilibrium_problem(model)
    whole = _state_matrix(problem, point.state)
    matrix = problem.without_following(whole)
    values, vectors = (part[0] for part in eigenpairs_of_matrices(matrix[None]))
    values.real[is_neutral(matrix, values)] = 0.0
    order = eigenvalue_order(values)
    return Eigenvalues(values[order], problem.with_following(vectors[:, order], whole), point)


def damping_ratios(values: ComplexArray) -> Array:
    """-Re/|lambda| of eigenvalues (m,), 0 where they are 0."""
    sizes: Any = np.abs(values)
    shares: Any = -values.real / np.where(sizes > 0.0, sizes, 1.0)
    return shares


def jacobian(model: ModelOrAutomaton, state: Array) -> Array:
    """The state matrix (m, m) of the mode that has the default equilibrium, at a state (m,).

    Raises
    ------
    ValueError
        If friction has no derivative, as the belt rests and the model has stick; or if a law has no
        derivative or no value at this state.
    """
    return _state_matrix(equilibrium_problem(model), state)


def _state_matrix(problem: EquilibriumProblem, state: Array) -> Array:
    model = problem.model
    equations = sliding_equations(model)
    if equations is not None and equations.rests(problem.values):
        raise ValueError("v must not be 0 for steady sliding, got 0.0: give the belt a speed")
    with np.errstate(all="ignore"):
        matrix = problem.flow.jacobian(state, problem.values)
    if not np.isfinite(matrix).all():
        raise ValueError(
            f"the state matrix of {model!r} must be finite at its equilibrium, and is not: a law has no "
            "derivative there, or no value; change its parameters, or the law"
        )
    return matrix


def mode_shapes(vectors: ComplexArray, n: int) -> ComplexArray:
    """The coordinates' part (..., n, m) of vectors (..., m, m), the largest entry of each column 1."""
    part = vectors[..., :n, :]
    largest = np.take_along_axis(part, np.abs(part).argmax(axis=-2)[..., None, :], axis=-2)
    with np.errstate(invalid="ignore"):  # vectors of no equilibrium are zero
        return part / largest


def participation_factors(left: ComplexArray, right: ComplexArray, n: int) -> Array:
    """Participation factors |w v| of left (..., k, m) and right vectors (..., m, k), as (..., n, k).

    A coordinate's is summed with that of its rate; all are 0 of a mode of further states alone.  They do not
    depend on the units of the coordinates; without damping and friction they are the shares of the mode's
    kinetic energy.  I. J. Perez-Arriaga, G. C. Verghese, F. C. Schweppe, "Selective modal analysis", IEEE
    Trans. Power Apparatus and Systems 101 (1982) 3117-3125.
    """
    factors = np.abs(np.swapaxes(left, -1, -2) * right)
    coordinates = factors[..., :n, :]
    if factors.shape[-2] >= 2 * n:
        coordinates = coordinates + factors[..., n : 2 * n, :]
    whole = coordinates.sum(axis=-2, keepdims=True)
    return np.divide(coordinates, whole, out=np.zeros_like(coordinates), where=whole != 0.0)
