"""Eigenvalues of a structure in its window of frequencies, with errors, left vectors and sensitivities."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray
from scipy import linalg
from scipy.optimize import linear_sum_assignment

from frictionlab.presentation import count, dataframe, shorten
from frictionlab.stability.eigenproblems.eigenvalues import UNITS, Eigenvalues, participation_factors
from frictionlab.stability.equilibrium_points.equilibria import Equilibrium
from frictionlab.stability.state_matrices import (
    SINGULAR_RTOL,
    eigenpairs_of_matrices,
    eigenvalue_order,
    inverse_of,
)
from frictionlab.structures.quadratic_pencil import QuadraticPencil, Spectrum

if TYPE_CHECKING:
    from frictionlab.structures.structure import Structure

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
MOST_DENSE = 400  # freedoms up to which all eigenvalues are found, by a full matrix
SHIFT_SHARE = 0.1  # of the window's upper end: the real shift of windows that begin low
RADIUS_SHARE = 1.03  # of the window's upper end: the radius of the disc, which reaches beyond the window
LOW_SHARE = 0.5  # of the upper end: a window that begins higher has a complex shift in its middle
CENTRED_RADIUS = 1.2  # of half the width of such a window
EQUAL_RTOL = 1e-9  # share of the largest eigenvalue by which equal ones may differ
INFINITE = 1e10  # times the size of eigenvalues: beyond, they are those of freedoms without mass
NEUTRAL_FACTOR = 4.0  # times the rounding error of an eigenvalue: a smaller growth rate counts as zero
DOUBTFUL_FACTOR = 1e3 * NEUTRAL_FACTOR  # the same of an estimate without left vectors
MACHINE_EPSILON = float(np.finfo(float).eps)


@dataclass(frozen=True, eq=False)
class WindowEigenvalues(Eigenvalues):
    """The eigenvalues of a structure in its window of frequencies, and their modes.

    Of a window that begins low they are all with damping ratios up to 14 % at its upper end, and more below
    it.  It has what :class:`Eigenvalues` has; `stable` speaks of the window alone.

    Parameters
    ----------
    residuals : array (m,)
        |Q(s) x| as a share of |s^2 M x| + |s C x| + |K x|, with Q(s) = s^2 M + s C + K.
    backward_errors : array (m,)
        By what share of their norms M, C and K would have to change for the pair to be exact.
    """

    residuals: Array
    backward_errors: Array

    @property
    def structure(self) -> Structure:
        """The structure whose eigenvalues they are."""
        return cast("Structure", self.equilibrium.model)

    @cached_property
    def left_vectors(self) -> ComplexArray:
        """Left vectors y as columns, without conjugation: y Q(s) = 0 and y Q'(s) x = 1.

        Q has n rows, and one for each state of a friction law.
        """
        return _left_vectors(self.structure, Spectrum(self.values, self._unknowns))

    @property
    def error_estimates(self) -> Array:
        """Distances (m,) of the eigenvalues from exact ones, to first order |y Q(s) x|, 1/s."""
        products = self.structure.pencil.products(self.values, self._unknowns)
        return np.abs((self.left_vectors * products).sum(axis=0))

    @property
    def participation(self) -> Array:
        """Share of each freedom in each mode, (n, m); columns sum to 1."""
        pencil, x, y, n = self.structure.pencil, self._unknowns, self.left_vectors, self.structure.size
        velocities = pencil.M.T @ y
        rates = self.values * velocities + pencil.C.T @ y
        rigid = ~y.any(axis=0)  # at rest: a double eigenvalue, whose left vectors are those of momentum
        rates[:, rigid] = pencil.M.T @ x[:, rigid].conj()
        left = np.vstack([rates[:n], velocities[:n], rates[n:]])
        return participation_factors(left.T, self.vectors, n)

    def sensitivities(self, parameter: str) -> ComplexArray:
        """Derivatives (m,) of the eigenvalues by a parameter, 1/s over its unit: -y (dQ/dp) x.

        Raises
        ------
        TypeError
            For an unknown parameter.
        """
        slope = self.structure.pencil_derivative(parameter)
        return -(self.left_vectors * slope.products(self.values, self._unknowns)).sum(axis=0)

    def mac(self, other: Eigenvalues) -> Array:
        """Modal assurance criterion (m, k) of these modes with those of others: 1 for the same shape."""
        a, b = self.shapes, other.shapes
        sizes = np.outer((np.abs(a) ** 2).sum(axis=0), (np.abs(b) ** 2).sum(axis=0))
        return np.abs(a.conj().T @ b) ** 2 / sizes

    @property
    def growing(self) -> NDArray[np.intp]:
        """Places of the eigenvalues with Im >= 0 that grow, the fastest first."""
        places = np.flatnonzero((self.growth_rates > 0.0) & (self.values.imag >= 0.0))
        return places[np.argsort(-self.growth_rates[places])]

    @property
    def _unknowns(self) -> ComplexArray:
        return unknowns(self.vectors, self.structure.size)

    def to_dataframe(self) -> Any:
        """One row for each eigenvalue, as a pandas DataFrame (needs the extra ``data``).

        Columns: growth rate, frequency, damping ratio, residual and backward error.
        """
        columns = {"growth_rate": self.growth_rates, "frequency": self.frequencies}
        columns |= {"damping_ratio": self.damping_ratios, "residual": self.residuals}
        columns |= {"backward_error": self.backward_errors}
        return dataframe(columns, {"eigenvalue": np.arange(len(self.values))}, UNITS)

    def __repr__(self) -> str:
        modes = count(int((self.values.imag >= 0.0).sum()), "mode")
        if not len(self.values):
            return f"WindowEigenvalues({modes})"
        growing = shorten(
            f"{v.real:+.4g}/s at {v.imag / (2 * np.pi):.5g} Hz" for v in self.values[self.growing]
        )
        where = f"{modes}, {self.frequencies.min():.4g} to {self.frequencies.max():.4g} Hz"
        what = f"{len(self.growing)} growing: {growing}" if growing else "none growing"
        return f"WindowEigenvalues({where}, {what})"


def window_eigenvalues(structure: Structure, equilibrium: Equilibrium) -> WindowEigenvalues:
    """The eigenvalues of a structure, linearised at its equilibrium."""
    pencil = structure.pencil
    spectrum = _in_window(_spectrum(pencil, structure.window), structure)
    values, x = spectrum
    order = eigenvalue_order(values)
    values, x = values[order], x[:, order] / np.linalg.norm(x[:, order], axis=0)
    values[pencil.at_rest(values, x)] = 0.0
    residuals, backward = pencil.residuals(values, x), pencil.backward_errors(values, x)
    values.real[_neutral(structure, Spectrum(values, x))] = 0.0
    n = structure.size
    vectors = np.vstack([x[:n], values * x[:n], x[n:]])
    return WindowEigenvalues(values, vectors, equilibrium, residuals, backward)


def _spectrum(pencil: QuadraticPencil, window: tuple[float, float] | None) -> Spectrum:
    """All eigenvalues of a small structure; those in a disc around the window of a large one."""
    if window is None or pencil.size <= MOST_DENSE:
        return dense_spectrum(pencil)
    low, high = (2 * np.pi * end for end in window)
    if low <= LOW_SHARE * high:
        return pencil.near(SHIFT_SHARE * high, RADIUS_SHARE * high)
    middle, half = 0.5j * (low + high), 0.5 * (high - low)
    upper = pencil.near(middle, CENTRED_RADIUS * half)
    if np.iscomplexobj(pencil.K.data):
        return upper
    return Spectrum(
        np.concatenate([upper.values, upper.values.conj()]), np.hstack([upper.vectors, upper.vectors.conj()])
    )


def dense_spectrum(pencil: QuadraticPencil) -> Spectrum:
    """All finite eigenvalues of a small pencil, from a full matrix of twice its size."""
    if not has_regular_mass(pencil):
        return _spectrum_with_massless_motions(pencil)
    C, K = pencil.C.toarray(), pencil.K.toarray()
    matrix = state_matrices(pencil.of_highest_rates, C, K, pencil.states)
    values, vectors = (part[0] for part in eigenpairs_of_matrices(matrix[None]))
    return Spectrum(values.astype(complex), unknowns(vectors, pencil.size - pencil.states).astype(complex))


def has_regular_mass(pencil: QuadraticPencil) -> bool:
    """Whether every motion has kinetic energy, and every state of a law a rate, by more than rounding."""
    return inverse_of(pencil.of_highest_rates) is not None


def unknowns(vectors: Any, freedoms: int) -> Any:
    """Of vectors of displacements, velocities and further states, all but the velocities."""
    return np.vstack([vectors[:freedoms], vectors[2 * freedoms :]])


def _spectrum_with_massless_motions(pencil: QuadraticPencil) -> Spectrum:
    """The finite eigenvalues of a small pencil with a singular M.

    In the directions of M's eigenvectors its zeros are exact.  Otherwise rounding makes large finite
    eigenvalues of infinite ones.

    Raises
    ------
    ArithmeticError
        Where a motion has neither mass nor damping nor stiffness.
    """
    n = pencil.size
    M, C, K = (part.toarray() for part in (pencil.M, pencil.C, pencil.K))
    scales = 1.0 / np.sqrt(np.where(M.diagonal() > 0.0, M.diagonal(), 1.0))
    masses, directions = np.linalg.eigh(scales[:, None] * M * scales)
    masses[masses <= SINGULAR_RTOL * n * masses[-1]] = 0.0
    directions = scales[:, None] * directions
    massless, massive = directions[:, masses == 0.0], directions[:, masses > 0.0]
    held = np.vstack([C, K]) @ massless
    sizes = np.linalg.svd(held, compute_uv=False)
    if sizes[-1] <= SINGULAR_RTOL * n * sizes[0]:
        raise ArithmeticError(
            "M, C and K must not have a common null vector, got a motion with neither mass nor damping nor "
            "stiffness: hold it, or leave its freedoms out"
        )
    scale = np.sqrt(np.linalg.norm(massive.T @ K @ massive, 2))
    C, K = directions.T @ C @ directions, directions.T @ K @ directions
    unit, zero = np.eye(n), np.zeros((n, n))
    given = np.block([[zero, unit], [-K, -C]]), np.block([[unit, zero], [zero, np.diag(masses)]])
    pairs: Any = linalg.eig(*given)
    values, vectors = pairs
    sizes = np.abs(values)
    finite = np.isfinite(sizes)
    finite &= sizes <= INFINITE * max(np.median(sizes[finite]), scale)  # a median may be a rigid motion's
    return Spectrum(values[finite].astype(complex), directions @ vectors[:n, finite].astype(complex))


def state_matrices(of_highest_rates: Array, C: Array, K: Array, states: int) -> Array:
    """The matrix A of (q, v, z)' = A (q, v, z), of a regular M; z are the states of friction laws.

    The matrices are full and may be stacked.
    """
    n = C.shape[-1] - states
    rates = np.linalg.solve(
        of_highest_rates, np.concatenate([-K[..., :n], -C[..., :n], -K[..., n:]], axis=-1)
    )
    unit = np.eye(n, rates.shape[-1], n)
    whole: Any = np.concatenate([np.broadcast_to(unit, (*rates.shape[:-2], *unit.shape)), rates], axis=-2)
    return whole


def _in_window(spectrum: Spectrum, structure: Structure) -> Spectrum:
    low, high = structure.window or (0.0, np.inf)
    frequencies = np.abs(spectrum.values.imag) / (2 * np.pi)
    chosen = (low <= frequencies) & (frequencies <= high)
    if np.iscomplexobj(structure.pencil.K.data):  # with the wrong sign of its damping below the real axis
        chosen &= spectrum.values.imag >= 0.0
    return Spectrum(spectrum.values[chosen], spectrum.vectors[:, chosen])


def _neutral(structure: Structure, spectrum: Spectrum) -> NDArray[np.bool_]:
    """Whether the real part of each eigenvalue is nothing but rounding, as without damping.

    Rounding moves an eigenvalue by up to eps |y| (|s|^2 |M| + |s| |C| + |K|) |x|, with y Q'(s) x = 1.  Left
    vectors cost as much as the eigenvalues.  So first conjugate right ones take their place: mostly they
    leave no doubt.
    """
    values, x = spectrum
    with np.errstate(divide="ignore", invalid="ignore"):  # 0 where two coalesce, as in a rigid motion
        rough = x.conj() / _products_of_pairs(structure.pencil, x.conj(), spectrum)
    rounding = _rounding(structure.pencil, rough, spectrum)
    neutral = ~(np.abs(values.real) > DOUBTFUL_FACTOR * rounding)  # also where there is no estimate
    if neutral.any():
        left = _left_vectors(structure, spectrum)
        # the two-sided Rayleigh quotient leaves nothing but rounding
        rates = (values - (left * structure.pencil.products(values, x)).sum(axis=0)).real
        neutral &= np.abs(rates) <= NEUTRAL_FACTOR * _rounding(structure.pencil, left, spectrum)
    return neutral


def _rounding(pencil: QuadraticPencil, left: ComplexArray, right: Spectrum) -> Array:
    """Bound of what rounding of the entries moves each eigenvalue (m,), 1/s."""
    sizes, x, y = np.abs(right.values), np.abs(right.vectors), np.abs(left)
    terms = sizes**2 * (abs(pencil.M) @ x) + sizes * (abs(pencil.C) @ x) + abs(pencil.K) @ x
    with np.errstate(invalid="ignore"):
        return MACHINE_EPSILON * (y * terms).sum(axis=0)


def _products_of_pairs(pencil: QuadraticPencil, left: ComplexArray, right: Spectrum) -> ComplexArray:
    """y Q'(s) x (m,) of vectors y and x in the same columns."""
    values, x = right
    return (left * (2.0 * values * (pencil.M @ x) + pencil.C @ x)).sum(axis=0)


def _left_vectors(structure: Structure, right: Spectrum) -> ComplexArray:
    pencil = structure.pencil
    return left_vectors_of(pencil, right, lambda: _spectrum(pencil.transposed(), structure.window))


def left_vectors_of(
    pencil: QuadraticPencil, right: Spectrum, of_transposed: Callable[[], Spectrum]
) -> ComplexArray:
    """Left vectors (n, m), y Q'(s) x = 1, for eigenvalues that are known.

    Parameters
    ----------
    pencil : QuadraticPencil
    right : Spectrum
    of_transposed : callable
        Gives the spectrum of the transposed pencil, where it is needed.
    """
    left = right if _is_symmetric(pencil) else _matched(of_transposed(), right)
    products = pencil.products_of_modes(left, right)
    # Among equal eigenvalues any combination is a left vector: that is taken which belongs to each right one.
    return left.vectors @ np.linalg.pinv(np.where(equal_values(right.values), products, 0.0)).T


def equal_values(values: ComplexArray) -> NDArray[np.bool_]:
    """Which eigenvalues (k, k) are equal but for rounding."""
    equal: Any = np.abs(values[:, None] - values) <= EQUAL_RTOL * np.abs(values).max(initial=0.0)
    return equal


def _is_symmetric(pencil: QuadraticPencil) -> bool:
    return all(not (part - part.T).count_nonzero() for part in (pencil.M, pencil.C, pencil.K))


def _matched(left: Spectrum, right: Spectrum) -> Spectrum:
    """Of the eigenvalues of the transposed pencil those that are nearest to known ones, in their order."""
    distances = np.abs(right.values[:, None] - left.values)
    _, order = linear_sum_assignment(distances)
    return Spectrum(left.values[order], left.vectors[:, order])
