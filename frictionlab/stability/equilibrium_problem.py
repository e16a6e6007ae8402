"""Equilibria and state matrices as functions of the parameters, on which all stability analyses work.

State matrices and `solve` are enough for most analyses.  Those that take further derivatives ask for the
`flow`.  Also here: eigenvalues, vectors and growth rates of stacks of state matrices, and the checks of
parameter names, values and bounds.

Without damping the squares of the eigenvalues are computed, so that growth rates are exact zeros until two
modes coalesce.  A single growth rate counts as zero if the backward error of the eigenvalue problem could
explain it (:func:`is_neutral`).  Computed eigenvalues of A are exact ones of A + E, where |E| is about
m eps |A|.  Source: Golub and Van Loan, Matrix Computations, 4th ed., sections 7.2 and 7.5.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionlab.components.component import check_value
from frictionlab.models.composition import parameter_metadata
from frictionlab.models.model import Model, ModelOrAutomaton, check_parameter_name
from frictionlab.stability.flow import Flow
from frictionlab.tape.formulas import Formulas
from frictionlab.validation import abbreviate, check_limits, check_pair, float_array

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complexfloating[Any, Any]]

SMALLEST_EIGENVALUE = 1e-280  # taken for the largest where all are zero
# Growth rates below this share of the largest eigenvalue count as zero, as without damping.
NEUTRAL_RTOL = 1e-10
# Share of the largest eigenvalue: of a slower mode, growth by more than 1e-3 of its size counts as zero.
SLOW_RTOL = 1e3 * NEUTRAL_RTOL
EQUAL_RTOL = 1e-10  # share of the largest eigenvalue by which rounding may separate equal ones
MACHINE_EPSILON = float(np.finfo(float).eps)  # spacing of floats at 1
BALANCING_GAIN = 0.95  # a factor is used if it reduces the norm of a row and a column below this share
BACKWARD_ERROR = 4.0 * MACHINE_EPSILON  # of the problem and of A itself, with a factor of two to spare


def eigenvalues_of_matrices(matrices: Array) -> ComplexArray:
    """Eigenvalues (N, m) of state matrices (N, m, m)."""
    if _is_undamped(matrices):
        roots = np.sqrt(np.linalg.eigvals(_stiffness(matrices)).astype(complex))
        return np.concatenate([roots, -roots], axis=-1)
    return np.linalg.eigvals(matrices).astype(complex)


def eigenpairs_of_matrices(matrices: Array) -> tuple[ComplexArray, ComplexArray]:
    """Eigenvalues (N, m) and vectors of length 1 as columns (N, m, m)."""
    if not _is_undamped(matrices):
        pairs: Any = np.linalg.eig(matrices)
        return pairs.eigenvalues.astype(complex), pairs.eigenvectors.astype(complex)
    squares: Any = np.linalg.eig(_stiffness(matrices))
    roots, shapes = np.sqrt(squares.eigenvalues.astype(complex)), squares.eigenvectors
    values = np.concatenate([roots, -roots], axis=-1)
    coordinates = np.concatenate([shapes, shapes], axis=-1)
    vectors = np.concatenate([coordinates, coordinates * values[:, None, :]], axis=-2)
    return values, vectors / np.linalg.norm(vectors, axis=-2, keepdims=True)


def _is_undamped(matrices: Array) -> bool:
    """Whether all are those of q'' = -K q: squares of eigenvalues are then real until modes coalesce."""
    n, odd = divmod(matrices.shape[-1], 2)
    unit = np.eye(n, 2 * n, n)
    return not odd and not matrices[:, n:, n:].any() and bool((matrices[:, :n] == unit).all())


def _stiffness(matrices: Array) -> Array:
    n = matrices.shape[-1] // 2
    return matrices[:, n:, :n]


def eigenvalue_distances(spectra: ComplexArray, others: ComplexArray) -> Array:
    """Distances (N, m, m) of each eigenvalue of N spectra (N, m) to each of N others."""
    return np.abs(spectra[:, :, None] - others[:, None, :])


def equal_eigenvalues(spectra: ComplexArray) -> NDArray[np.bool_]:
    """Which eigenvalues (N, m, m) of N spectra (N, m) are equal but for rounding; none equals itself."""
    largest = np.abs(spectra).max(axis=1, initial=0.0)
    equal = eigenvalue_distances(spectra, spectra) <= EQUAL_RTOL * largest[:, None, None]
    return equal & ~np.eye(spectra.shape[1], dtype=bool)


def growth_rates(spectra: ComplexArray) -> Array:
    """Growth rates; those that are zero up to rounding are set a little below zero."""
    bound = NEUTRAL_RTOL * np.abs(spectra).max(axis=-1, keepdims=True, initial=SMALLEST_EIGENVALUE)
    return np.where(np.abs(spectra.real) < bound, -bound, spectra.real)


def warn_of_slow_modes(problem: EquilibriumProblem) -> None:
    """Warn where a mode is so slow beside the fastest that the growth rates which count as zero matter to it.

    Of a light mass that friction damps strongly, as rate and state at a low speed, the eigenvalues are nine
    decades apart.
    """
    _, matrices = problem.linearised({})
    matrices = problem.without_following(matrices)
    if not np.isfinite(matrices).all():
        return
    sizes: Any = np.abs(eigenvalues_of_matrices(matrices)[0])
    slow = sizes[sizes < SLOW_RTOL * sizes.max()]
    singular = np.linalg.svd(balanced(matrices[0]), compute_uv=False)
    # Where the matrix is singular, eigenvalues near zero are rounding: a body that nothing holds.
    if slow.size and singular[-1] > len(singular) * BACKWARD_ERROR * singular[0]:
        least, largest = NEUTRAL_RTOL * sizes.max(), sizes.max()
        warnings.warn(
            f"growth rates below {least:.2g} 1/s count as zero, as the largest eigenvalue is {largest:.2g} "
            f"1/s, and a mode has {slow.max():.2g} 1/s: where it begins to grow is uncertain; make what is "
            "fast slower, as by a larger mass",
            RuntimeWarning,
            stacklevel=3,
        )


def unstable_pairs(spectra: ComplexArray) -> NDArray[np.int_]:
    """Number of growing pairs of eigenvalues; two real ones count as a pair, and so does one alone."""
    return ((growth_rates(spectra) > 0).sum(axis=-1) + 1) // 2


def is_neutral(matrix: Array, values: NDArray[np.complex128]) -> NDArray[np.bool_]:
    """Whether the real part of each eigenvalue (m,) of a real matrix (m, m) is nothing but rounding.

    To first order a perturbation E moves an eigenvalue by |E| times its condition number.  If two coalesce,
    as at critical damping, that number is infinite and tells nothing.  So there is a second condition: some E
    of this size puts an eigenvalue on the imaginary axis at this frequency.  Both are evaluated for the
    balanced matrix.
    """
    scaled = balanced(matrix)
    error = len(matrix) * BACKWARD_ERROR * np.linalg.norm(scaled, 2)
    pairs: Any = np.linalg.eig(scaled)
    known, right = pairs.eigenvalues, pairs.eigenvectors
    nearest = np.abs(values[:, None] - known).argmin(axis=1)
    neutral = np.abs(values.real) * _cosines(right)[nearest] <= error
    for i in np.flatnonzero(neutral):  # one by one: matrices of many states are large
        on_axis = scaled - 1j * values.imag[i] * np.eye(len(matrix))
        # The residual of a unit vector is no less than the least singular value, and takes less time.
        left_over = np.linalg.norm(on_axis @ right[:, nearest[i]])
        neutral[i] = left_over <= error or np.linalg.svd(on_axis, compute_uv=False)[-1] <= error
    return neutral


def _cosines(right: ComplexArray) -> Array:
    """|w v| (m,) of the left and right vectors w, v of length 1: inverse condition numbers of eigenvalues.

    `right` holds the vectors v as columns.  Where eigenvalues coalesce these are no basis, and w v = 0.
    """
    try:
        left = np.linalg.inv(right)
    except np.linalg.LinAlgError:
        return np.zeros(len(right))
    with np.errstate(over="ignore", invalid="ignore"):  # where they are hardly a basis
        return np.nan_to_num(1.0 / np.linalg.norm(left, axis=1))


def balanced(matrix: Array) -> Array:
    """D^-1 A D with powers of two in the diagonal D that make norms of rows and columns alike.

    It changes no eigenvalue and rounds nothing.  R. James, J. Langou, B. R. Lowery, "On matrix balancing and
    eigenvector computation", arXiv:1401.5766 (2014), algorithm 3, which LAPACK's gebal is.
    """
    similar = np.array(matrix, dtype=float)
    unchanged = False
    while not unchanged:
        unchanged = True
        for i in range(len(similar)):
            column, row = np.linalg.norm(similar[:, i]), np.linalg.norm(similar[i])
            if not (column and row and np.isfinite(column + row)):
                continue
            power = 2.0 ** np.round(0.5 * np.log2(row / column))
            if np.hypot(column * power, row / power) < BALANCING_GAIN * np.hypot(column, row):
                unchanged = False
                similar[:, i] *= power
                similar[i] /= power
    return similar


@dataclass(frozen=True, eq=False)
class EquilibriumProblem:
    """Equilibria and linearised flow of one mode.

    Parameters
    ----------
    model : Model or HybridAutomaton
    names : tuple of str
        Names of the coordinates, or of all states where there are none.
    parameter_names : tuple of str
    values : tuple of float
        The parameters, in the flow's order.
    solve : callable
        Takes values of the parameters (numbers or arrays (N,)) and N; gives the states (m, N) of the
        equilibrium, NaN where there is none.
    flow : Flow
    derive_guards : callable
        Gives the functions that are positive while the motion stays in this mode: v_r, the penetration.
    following : tuple of int
        Places of states that follow from the others, such as the angle of what turns.
    """

    model: ModelOrAutomaton
    names: tuple[str, ...]
    parameter_names: tuple[str, ...]
    values: tuple[float, ...]
    solve: Callable[[Sequence[Any], int], Array]
    flow: Flow
    derive_guards: Callable[[], Formulas]
    following: tuple[int, ...] = ()

    @property
    def parameters(self) -> dict[str, float]:
        """Name -> value."""
        return dict(zip(self.parameter_names, self.values, strict=True))

    def at(self, changes: Mapping[str, Any]) -> tuple[tuple[Any, ...], int]:
        """The values with some changed to arrays (N,), and N."""
        arrays = {name: np.asarray(values, dtype=float).ravel() for name, values in changes.items()}
        count = max((len(a) for a in arrays.values()), default=1)
        return tuple(arrays.get(name, value) for name, value in self.parameters.items()), count

    def linearised(self, changes: Mapping[str, Any]) -> tuple[Array, Array]:
        """Equilibria (m, N) and state matrices (N, m, m); NaN where there is no equilibrium."""
        values, count = self.at(changes)
        x = self.solve(values, count)
        matrices = self.flow.jacobian(x, values)
        matrices[np.isnan(x).any(axis=0)] = np.nan  # entries that do not depend on x are still numbers
        return x, matrices

    def without_following(self, matrices: Array) -> Array:
        """State matrices (..., m, m) without the states that follow from the others."""
        for axis in (-2, -1) if self.following else ():
            matrices = np.delete(matrices, self.following, axis=axis)
        return matrices

    def with_following(self, vectors: Any, axis: int = -2) -> Any:
        """Vectors (..., m, k) of these matrices with zeros at the states that follow from the others."""
        places = [place - i for i, place in enumerate(self.following)]
        return np.insert(vectors, places, 0.0, axis=axis) if places else vectors

    def spectra(self, changes: Mapping[str, Any]) -> ComplexArray:
        """Eigenvalues (N, m), the largest growth rate first."""
        _, matrices = self.linearised(changes)
        eigenvalues: Any = np.full(matrices.shape[:2], complex(np.nan, np.nan))
        matrices = self.without_following(matrices)
        eigenvalues = eigenvalues[:, : matrices.shape[1]]
        known = np.isfinite(matrices).all(axis=(1, 2))
        eigenvalues[known] = eigenvalues_of_matrices(matrices[known])
        return np.take_along_axis(eigenvalues, np.argsort(-eigenvalues.real, axis=1), axis=1)


def check_parameter(model: ModelOrAutomaton, name: Any, values: Sequence[float]) -> None:
    """Refuse an unknown parameter, and values that break its own rule.

    Rules between parameters (mu_s is at least mu_k) do not matter here: no steady motion depends on both.
    """
    check_parameter_name(model, name)
    if isinstance(model, Model):
        about = parameter_metadata(type(model), model.components)[name]
        for value in values:
            check_value(name, value, about)


def check_path(problem: EquilibriumProblem, name: Any, values: Any) -> NDArray[np.float64]:
    """The values (N,) of a parameter, at least one, checked against its rule."""
    check_parameter_name(problem.model, name)
    at = float_array("values", values, f"give those of {name}").ravel()
    if not len(at):
        raise ValueError(f"values must be one number or more, got {abbreviate(values)}: give those of {name}")
    check_parameter(problem.model, name, at.tolist())
    return at


def check_axis(problem: EquilibriumProblem, which: str, given: tuple[str, Any]) -> Array:
    """The values (N,) of a parameter along one side of a grid, given as its name and values; they ascend."""
    name, numbers = check_pair(which, given, "a parameter and its values", "give ('F', [1, 2])")
    check_parameter_name(problem.model, name)
    values = float_array(f"the values of {which}", numbers, f"give those of {name}").ravel()
    if len(values) < 2 or not (np.diff(values) > 0).all():
        raise ValueError(
            f"the values of {which} must ascend, two at least, got {abbreviate(values)}: sort them"
        )
    check_parameter(problem.model, name, values.tolist())
    return values


def check_bounds(model: ModelOrAutomaton, name: Any, bounds: Any) -> tuple[float, float]:
    """Two values of a parameter, in ascending order."""
    check_parameter_name(model, name)
    low, high = check_limits("bounds", bounds, "give (low, high)")
    check_parameter(model, name, (low, high))
    return low, high
