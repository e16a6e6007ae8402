"""Eigenvalues, vectors and growth rates of state matrices, which may be stacked.

Without damping the squares of the eigenvalues are computed, so that growth rates are exact zeros until two
modes coalesce.  Computed eigenvalues of A are exact ones of A + E, where |E| is about m eps |A|.  Source:
Golub and Van Loan, Matrix Computations, 4th ed., sections 7.2 and 7.5.

Such an error spoils modes that are many decades slower than the fastest, as those of a light mass that
friction damps strongly.  They are the fastest of A^-1, whose error is as small beside them.  So slow
eigenvalues are computed as reciprocals of its eigenvalues, and judged by the largest of themselves
(:func:`growth_scales`).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complexfloating[Any, Any]]

SMALLEST_EIGENVALUE = 1e-280  # taken for the largest where all are zero
NEUTRAL_RTOL = 1e-10  # growth rates below this share of the largest eigenvalue count as zero
SLOW_RTOL = 1e-5  # share of the largest eigenvalue: rounding may be NEUTRAL_RTOL of one that is slower
# Share of the largest eigenvalue, or of a frequency, by which rounding may separate equal ones.
EQUAL_RTOL = 1e-10
MACHINE_EPSILON = float(np.finfo(float).eps)  # spacing of floats at 1
BALANCING_GAIN = 0.95  # a factor is used if it reduces the norm of a row and a column below this share
BACKWARD_ERROR = 4.0 * MACHINE_EPSILON  # of the problem and of A itself, with a factor of two to spare
EQUILIBRATION_ROUNDS = 8  # each halves the decades by which norms differ from 1
DEPENDENT = 1e-12  # share of the largest singular value of vectors, below which they are dependent
INDEPENDENT = 0.99  # least share of a vector in the row space where others do not depend on it
SINGULAR_RTOL = 1e-13  # of the largest singular value, of a matrix scaled by its rows and columns


def eigenvalues_of_matrices(matrices: Array) -> ComplexArray:
    """Eigenvalues (N, m) of state matrices (N, m, m)."""
    undamped = _is_undamped(matrices)
    matrix = _stiffness(matrices) if undamped else matrices
    values = np.linalg.eigvals(matrix).astype(complex)
    _refine_slow(matrix, values)
    if undamped:
        values = np.sqrt(values)
        return np.concatenate([values, -values], axis=-1)
    return values


def eigenpairs_of_matrices(matrices: Array) -> tuple[ComplexArray, ComplexArray]:
    """Eigenvalues (N, m) and vectors of length 1 as columns (N, m, m)."""
    undamped = _is_undamped(matrices)
    matrix = _stiffness(matrices) if undamped else matrices
    pairs: Any = np.linalg.eig(matrix)
    values, vectors = pairs.eigenvalues.astype(complex), pairs.eigenvectors.astype(complex)
    _refine_slow(matrix, values, vectors)
    if not undamped:
        return values, vectors
    roots = np.sqrt(values)
    values = np.concatenate([roots, -roots], axis=-1)
    coordinates = np.concatenate([vectors, vectors], axis=-1)
    vectors = np.concatenate([coordinates, coordinates * values[:, None, :]], axis=-2)
    return values, vectors / np.linalg.norm(vectors, axis=-2, keepdims=True)


def left_eigenvectors(matrices: Array, values: Any, right: Any) -> Any:
    """Left vectors (N, m, m) of state matrices (N, m, m): left @ right = 1.

    Known are the eigenvalues (N, m), and right vectors of length 1 as columns (N, m, m).  These may be
    dependent, as those of a rigid motion.
    """
    try:
        left = np.linalg.inv(right)
    except np.linalg.LinAlgError:
        left = np.linalg.pinv(right, DEPENDENT)  # of a matrix that is regular its inverse
    with np.errstate(over="ignore", invalid="ignore"):  # of an inverse of 1e300
        ranks = np.einsum("nij,nji->n", left, right).real
        regular = (np.linalg.norm(left, axis=(-2, -1)) <= 1.0 / DEPENDENT) & (ranks > right.shape[-1] - 0.5)
    for i in np.flatnonzero(~regular):
        left[i] = _left_of_dependent(matrices[i], values[i], right[i])
    return left


def _left_of_dependent(matrix: Array, values: Any, right: Any) -> Any:
    """Left vectors (m, m) of a matrix that lacks right vectors, since eigenvalues coalesce.

    Those of the simple eigenvalues are vectors of the transposed matrix: they annihilate generalised vectors
    too.  What they leave of the pseudo-inverse stands for the others: for a rigid motion the momentum.
    """
    shares: Any = np.diag(np.linalg.pinv(right, DEPENDENT) @ right)
    simple = shares.real > INDEPENDENT
    (same_values,), (vectors,) = eigenpairs_of_matrices(matrix.T[None])
    away = np.abs(same_values[:, None] - values[~simple]).min(axis=1, initial=np.inf)
    rows = vectors[:, np.argsort(away)[len(values) - simple.sum() :]].T
    left = np.empty_like(right)
    left[simple] = np.linalg.pinv(rows @ right[:, simple], DEPENDENT) @ rows
    rest = np.eye(len(matrix)) - right[:, simple] @ left[simple]
    left[~simple] = np.linalg.pinv(right[:, ~simple], DEPENDENT) @ rest
    return left


def _is_undamped(matrices: Array) -> bool:
    """Whether all are those of q'' = -K q: squares of eigenvalues are then real until modes coalesce."""
    n, odd = divmod(matrices.shape[-1], 2)
    unit = np.eye(n, 2 * n, n)
    return not odd and not matrices[:, n:, n:].any() and bool((matrices[:, :n] == unit).all())


def _stiffness(matrices: Array) -> Array:
    n = matrices.shape[-1] // 2
    return matrices[:, n:, :n]


def _refine_slow(matrices: Array, values: ComplexArray, vectors: ComplexArray | None = None) -> None:
    """Put the reciprocals of the inverse's eigenvalues in place of slow ones (N, m), and its vectors.

    If a matrix has no inverse, its zero eigenvalue is taken out first.
    """
    slow = is_slow(values)
    for i in np.flatnonzero((values == 0.0).any(axis=1)):
        if inverse_of(matrices[i]) is not None:  # a zero of a regular matrix is rounding
            slow[i] = is_slow(np.where(values[i] == 0.0, SMALLEST_EIGENVALUE, values[i]))
    for i in np.flatnonzero(slow.any(axis=1)):
        inverse = inverse_of(matrices[i])
        if inverse is None:
            values[i], singular_vectors = _singular_eigenpairs(matrices[i])
            if vectors is not None:
                vectors[i] = singular_vectors
            continue
        pairs: Any = np.linalg.eig(inverse)
        largest = np.argsort(-np.abs(pairs.eigenvalues), kind="stable")[: slow[i].sum()]
        values[i, slow[i]] = 1.0 / pairs.eigenvalues[largest]
        if vectors is not None:
            vectors[i][:, slow[i]] = pairs.eigenvectors[:, largest]


def _singular_eigenpairs(matrix: Array) -> tuple[ComplexArray, ComplexArray]:
    """Eigenvalues (m,) and vectors (m, m) of a singular matrix, one of them exactly zero.

    With n the null vector, coordinates y relative to it, x = y + n x_p/n_p with y_p = 0, have a matrix of one
    row less.  For a body that nothing holds they are distances from it.
    """
    _, columns, equilibrated = _equilibrated(matrix)
    scaled_null = np.linalg.svd(equilibrated)[2][-1]
    p = int(np.abs(scaled_null).argmax())
    others = np.delete(np.arange(len(matrix)), p)
    null = columns * scaled_null
    null = null / null[p]
    relative = matrix[np.ix_(others, others)] - np.outer(null[others], matrix[p, others])
    (values,), (vectors,) = eigenpairs_of_matrices(relative[None])
    along = matrix[p, others] @ vectors
    shift = np.divide(along, values, out=np.zeros_like(along), where=values != 0.0)
    whole = null[:, None] * shift
    whole[others] += vectors
    whole[:, values == 0.0] = null[:, None]
    whole = np.column_stack([null, whole])
    return np.append(0.0, values), whole / np.linalg.norm(whole, axis=0)


def is_slow(spectra: ComplexArray) -> NDArray[np.bool_]:
    """Which eigenvalues (..., m) are below the widest gap, where the slowest are far below the fastest.

    None are where one is zero: rounding of a singular matrix is not to be told from slow modes.
    """
    sizes = np.abs(spectra)
    least, largest = sizes.min(axis=-1), sizes.max(axis=-1)
    apart = (least > 0.0) & (least < SLOW_RTOL * largest)
    if not apart.any():
        return np.zeros(spectra.shape, dtype=bool)
    ascending = np.sort(sizes, axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        gaps = ascending[..., 1:] / ascending[..., :-1]
    below = np.take_along_axis(ascending, gaps.argmax(axis=-1)[..., None], axis=-1)
    return apart[..., None] & (sizes <= below)


def growth_scales(spectra: ComplexArray) -> Array:
    """The sizes (..., m) by which growth is judged: the largest eigenvalue, of slow ones the largest slow."""
    sizes, slow = np.abs(spectra), is_slow(spectra)
    largest = sizes.max(axis=-1, keepdims=True, initial=SMALLEST_EIGENVALUE)
    if not slow.any():
        return np.broadcast_to(largest, sizes.shape)
    return np.where(slow, np.where(slow, sizes, 0.0).max(axis=-1, keepdims=True), largest)


def growth_rates(spectra: ComplexArray) -> Array:
    """Growth rates; those that are zero up to rounding are set a little below zero."""
    bound = NEUTRAL_RTOL * growth_scales(spectra)
    return np.where(np.abs(spectra.real) < bound, -bound, spectra.real)


def unstable_pairs(spectra: ComplexArray) -> NDArray[np.int_]:
    """Number of growing pairs of eigenvalues; two real ones count as a pair, and so does one alone."""
    return ((growth_rates(spectra) > 0).sum(axis=-1) + 1) // 2


def eigenvalue_distances(spectra: ComplexArray, others: ComplexArray) -> Array:
    """Distances (..., m, m) of each eigenvalue of spectra (..., m) to each of others."""
    return np.abs(spectra[..., :, None] - others[..., None, :])


def equal_eigenvalues(spectra: ComplexArray) -> NDArray[np.bool_]:
    """Which eigenvalues (..., m, m) of spectra (..., m) are equal but for rounding; none equals itself."""
    equal = eigenvalue_distances(spectra, spectra) <= EQUAL_RTOL * growth_scales(spectra)[..., :, None]
    return equal & ~np.eye(spectra.shape[-1], dtype=bool)


def eigenvalue_order(values: ComplexArray) -> NDArray[np.intp]:
    """Places of eigenvalues (m,) by frequency, then growth rate; those that differ by rounding are equal.

    The two of a conjugate pair agree exactly in |Im| and Re, and are neighbours.
    """
    frequencies = np.abs(values.imag)
    ascending = np.argsort(frequencies, kind="stable")
    rank = np.empty(len(values), dtype=int)
    rank[ascending] = np.cumsum(
        np.diff(frequencies[ascending], prepend=0.0) > EQUAL_RTOL * frequencies[ascending]
    )
    half = np.sign(values.imag)
    by_half = np.lexsort((frequencies, values.real, rank, half))
    place = np.empty(len(values), dtype=int)  # in its half plane: the same for the two of a pair
    place[by_half] = np.arange(len(values)) - np.searchsorted(half[by_half], half[by_half])
    return np.lexsort((values.imag, place, values.real, rank))


def is_neutral(matrix: Array, values: NDArray[np.complex128]) -> NDArray[np.bool_]:
    """Whether the real part of each eigenvalue (m,) of a real matrix (m, m) is nothing but rounding.

    Slow ones are judged as reciprocals of the inverse's eigenvalues.
    """
    slow = is_slow(values)
    inverse = inverse_of(matrix) if slow.any() else None
    if inverse is None:
        return _is_rounding(matrix, values)
    neutral = np.zeros(len(values), dtype=bool)
    neutral[slow], neutral[~slow] = (
        _is_rounding(inverse, 1.0 / values[slow]),
        _is_rounding(matrix, values[~slow]),
    )
    return neutral


def _is_rounding(matrix: Array, values: NDArray[np.complex128]) -> NDArray[np.bool_]:
    """Whether the real part of each of some eigenvalues (k,) may be the backward error's.

    To first order a perturbation E moves an eigenvalue by |E| times its condition number.  If two coalesce,
    as at critical damping, that number is infinite and tells nothing.  So there is a second condition: some E
    of this size puts an eigenvalue on the imaginary axis at this frequency.  Both are evaluated for the
    balanced matrix.
    """
    equilibrated = balanced(matrix)
    error = len(matrix) * BACKWARD_ERROR * np.linalg.norm(equilibrated, 2)
    pairs: Any = np.linalg.eig(equilibrated)
    eigenvalues, right = pairs.eigenvalues, pairs.eigenvectors
    nearest = np.abs(values[:, None] - eigenvalues).argmin(axis=1)
    neutral = np.abs(values.real) * _cosines(right)[nearest] <= error
    for i in np.flatnonzero(neutral):  # one by one: matrices of many states are large
        on_axis = equilibrated - 1j * values.imag[i] * np.eye(len(matrix))
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
    """D^-1 A D with the units of :func:`balancing_units` in the diagonal D; it rounds nothing."""
    units = balancing_units(matrix)
    return matrix * (units / units[:, None])


def balancing_units(matrix: Array) -> Array:
    """Powers of two (m,), units of the states that make norms of rows and columns alike.

    They change no eigenvalue.  R. James, J. Langou, B. R. Lowery, "On matrix balancing and
    eigenvector computation", arXiv:1401.5766 (2014), algorithm 3, which LAPACK's gebal is.  scipy has it, and
    takes a third of a second to load.
    """
    similar, units = np.array(matrix, dtype=float), np.ones(len(matrix))
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
                units[i] *= power
                similar[:, i] *= power
                similar[i] /= power
    return units


def solve_regular(matrix: Any, right: Any) -> Any:
    """The solution of a linear system with a state matrix.

    Raises
    ------
    ValueError
        Where the matrix is singular, to rounding.
    """
    rows, columns, equilibrated = _equilibrated(matrix)
    sizes = np.linalg.svd(equilibrated, compute_uv=False)
    if sizes[-1] < SINGULAR_RTOL * sizes[0]:
        raise ValueError(
            "the equilibrium must depend smoothly on the parameters to have derivatives, got one where the "
            "state matrix is singular: take another value"
        )
    return columns.reshape(-1, *[1] * (np.ndim(right) - 1)) * np.linalg.solve(
        equilibrated, rows.reshape(-1, *[1] * (np.ndim(right) - 1)) * right
    )


def null_vector(matrix: Any) -> Array | None:
    """A direction (m,) that a finite state matrix takes to zero; None where it is regular, to rounding."""
    if not np.isfinite(matrix).all():
        return None
    _, columns, equilibrated = _equilibrated(matrix)
    _, sizes, rows = np.linalg.svd(equilibrated)
    along = np.where(np.abs(rows[-1]) < SINGULAR_RTOL, 0.0, rows[-1])  # others are rounding
    return columns * along if sizes[-1] <= SINGULAR_RTOL * sizes[0] else None


def _equilibrated(matrix: Any) -> tuple[Array, Array, Array]:
    """Factors of rows and columns, and a matrix times both, whose rows and columns have entries up to 1.

    State matrices have stiffnesses beside ones.  D. Ruiz, "A scaling algorithm to equilibrate both rows and
    columns norms in matrices", RAL-TR-2001-034 (2001).
    """
    rows, columns, equilibrated = np.ones(len(matrix)), np.ones(len(matrix)), np.array(matrix, dtype=float)
    for _ in range(EQUILIBRATION_ROUNDS):
        by_row, by_column = (np.sqrt(np.abs(equilibrated).max(axis=axis)) for axis in (1, 0))
        rows, columns = rows / np.where(by_row, by_row, 1.0), columns / np.where(by_column, by_column, 1.0)
        equilibrated = rows[:, None] * matrix * columns
    return rows, columns, equilibrated


def inverse_of(matrix: Array) -> Array | None:
    """The inverse of a matrix (m, m); None where it is singular, to rounding."""
    try:
        return solve_regular(matrix, np.eye(len(matrix)))
    except ValueError:
        return None


class Eigenpair(NamedTuple):
    """An eigenvalue (1/s) with its left and right vectors (m,); `product` is l r, 0 where two coalesce."""

    value: complex
    left: Any  # real vectors of a real eigenvalue
    right: Any
    product: complex

    @property
    def normalised(self) -> Eigenpair:
        """The pair with a right vector of length 1, and l r = 1."""
        length = float(np.linalg.norm(self.right))
        return Eigenpair(self.value, self.left * (length / self.product), self.right / length, 1.0)


def eigenpair(matrix: Array, value: complex) -> Eigenpair:
    """The vectors of the eigenvalue nearest to a value, also where two coalesce.

    They are the last singular vectors of A - lambda 1, of length 1 in units of the states that balance A; of
    slow modes in units that give velocities the size of coordinates.
    """
    n, odd = divmod(len(matrix), 2)
    units = balancing_units(matrix)
    largest = float(np.linalg.norm(matrix * (units / units[:, None]), 2))
    inverse = inverse_of(matrix) if 0.0 < abs(value) < SLOW_RTOL * largest else None
    of, at = matrix, value
    if inverse is not None:
        of, at, units = inverse, 1.0 / value, np.ones(len(matrix)) if odd else np.repeat([1.0, abs(value)], n)
    shifted = of * (units / units[:, None]) - at * np.eye(len(matrix))
    u, _, vh = np.linalg.svd(shifted)
    left, right = u[:, -1].conj(), vh[-1].conj()
    return Eigenpair(value, left / units, right * units, complex(left @ right))
