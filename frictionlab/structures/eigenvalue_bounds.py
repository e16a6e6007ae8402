"""Bounds of the distances of known eigenvalues from those of Q(s) = s^2 M + s C + K.

Close eigenvalues are bounded together.  Near a group of p of them, Q(s) gets p further rows and columns, by
which it is regular there:

    [Q(s)  B] [X]   [0]
    [C*    0] [G] = [I],

where B and C are n x p matrices.  The determinant of G(s), a p x p matrix, is zero at the eigenvalues of Q
and nowhere else, with the same multiplicity.  The Taylor coefficients of G at a shift take one factorisation
of Q, and p solutions each.  Since Q is a polynomial, a geometric series bounds the remainder of the Taylor
polynomial.

The Taylor polynomial has a solvent, a p x p matrix A.  The exact eigenvalues are those of A but for what the
remainder moves them; the theorems of Bauer and Fike and of Elsner bound that.  By Rouche's theorem exactly p
eigenvalues lie in a disc around the shift.  Where eigenvalues coalesce A is much larger than they are, so all
is scaled along its Schur vectors, and a generalised vector takes the place of one that depends on others.

Two of the norms are those of n x n matrices with the inverse in them.  They are bounded by images of random
vectors: the component of a complex normal vector along any direction is less than t with a probability of at
most t^2.  Each of the two bounds is too small with a probability of at most 1e-10, so one of a group's two
with at most 2e-10.

Sources: A. Spence, C. Poulton, "Photonic band structure calculations using nonlinear eigenvalue techniques",
J. Comput. Phys. 204 (2005) 65-81; I. C. Gohberg, E. I. Sigal, "An operator generalization of the logarithmic
residue theorem and the theorem of Rouche", Math. USSR-Sb. 13 (1971) 603-625; L. Elsner, "An optimal bound for
the spectral variation of two matrices", Linear Algebra Appl. 71 (1985) 77-80.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, sparse
from scipy.optimize import linear_sum_assignment
from scipy.sparse.csgraph import connected_components

from frictionlab.structures.parametric_matrix import Matrix
from frictionlab.structures.quadratic_pencil import QuadraticPencil, factorised

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
CLOSE = 1e-4  # share of an eigenvalue: those nearer to each other are bounded together
ASIDE = 1e-3  # of the distance to the next eigenvalue: the shift, at which Q is regular, lies so far aside
DEPENDENT = 1e-8  # length of a unit vector that is left beside others, below which it depends on them
SAMPLES = 5  # random vectors
FACTOR = 10.0  # their largest image, times this, is less than a norm with the probability FACTOR^(-2 SAMPLES)
MOST_TERMS = 12  # Taylor coefficients
SHARP = 1e-3  # of the distance from the known eigenvalues: a remainder that needs no further term
SOLVENT_STEPS = 50
MACHINE_EPSILON = float(np.finfo(float).eps)
ROUNDING = 8.0 * MACHINE_EPSILON  # of the terms of y Q x


def eigenvalue_bounds(
    pencil: QuadraticPencil, values: ComplexArray, vectors: ComplexArray, places: NDArray[np.intp]
) -> Array:
    """Distances (k,) within which the pencil has eigenvalues, 1/s; infinite where that is not known.

    Of close ones it has as many within their distances as are known.

    Parameters
    ----------
    pencil : QuadraticPencil
    values : array (m,)
        Eigenvalues that are nearly right, with those next to them.
    vectors : array (n, m)
        Their vectors.
    places : array (k,)
        Of the eigenvalues whose bounds are asked for.
    """
    if not len(values):
        return np.zeros(0)
    distances = np.abs(values[:, None] - values)
    _, group = connected_components(sparse.csr_array(distances <= CLOSE * np.abs(values)), directed=False)
    # the exact eigenvalue of a rigid motion is 0, a double one, where no Taylor polynomial tells
    bounds = np.where(pencil.at_rest(values, vectors), np.abs(values), np.inf)
    for each in np.unique(group[places[np.isinf(bounds[places])]]):
        own = group == each
        most = np.abs(values[own]).max() or np.abs(values).max()  # a group at 0 has no size of its own
        next_one = distances[np.ix_(own, ~own)].min(initial=most)
        bounds[own] = _bounds_of_group(pencil, values[own], vectors[:, own], ASIDE * next_one)
    return bounds[places]


def _bounds_of_group(
    pencil: QuadraticPencil, values: ComplexArray, vectors: ComplexArray, aside: float
) -> Array:
    """The distances (p,) of a group of close eigenvalues."""
    none = np.full(len(values), np.inf)
    bordered = _Bordered.of(pencil, complex(values.mean() + aside), vectors)
    disc = None if bordered is None else bordered.eigenvalues(values)
    if disc is None:
        return none
    exact, radius = disc
    distances = np.abs(values[:, None] - exact)
    _, place = linear_sum_assignment(distances)
    touching = np.abs(exact[:, None] - exact) <= 2.0 * radius
    _, part = connected_components(sparse.csr_array(touching), directed=False)
    same = part[place][:, None] == part
    return np.where(same, distances, 0.0).max(axis=1) + radius


@dataclass(frozen=True, eq=False)
class _Bordered:
    """The inverse of the bordered matrix at a shift, in four blocks.

    The blocks are :meth:`inverse` and `right` above, `left` and `corner` below.  Displacements are weighted
    by the roots of their masses, so that norms are about those of kinetic energy.

    Parameters
    ----------
    pencil : QuadraticPencil
    shift : complex
    solve : callable
        Gives Q(shift)^-1 b of b.
    weights : array (n,)
    right, left : array (n, p), array (p, n)
        Nearly the right and left vectors.
    corner : array (p, p)
        G(shift).
    fixed : array (p, n)
        The rows C* of the border.
    """

    pencil: QuadraticPencil
    shift: complex
    solve: Callable[..., Any]
    weights: Array
    right: ComplexArray
    left: ComplexArray
    corner: ComplexArray
    fixed: ComplexArray

    @classmethod
    def of(cls, pencil: QuadraticPencil, shift: complex, vectors: ComplexArray) -> _Bordered | None:
        """With borders C = X and B = Q'(shift) X of vectors X; None where these do not make it regular."""
        solve = factorised(sparse.csc_array(pencil.at(shift), dtype=complex))
        if solve is None:
            return None
        weights = _weights(pencil)
        basis = _orthonormal(weights[:, None] * vectors)
        if basis is None:  # a vector and a generalised one, where eigenvalues coalesce
            some = np.random.default_rng(0).standard_normal(vectors.shape)
            generalised = solve(_slope(pencil, shift) @ (some / weights[:, None]))
            basis = _orthonormal(weights[:, None] * vectors, weights[:, None] * generalised)
        if basis is None:
            return None
        fixed: Any = basis.conj().T * weights
        columns = solve(_slope(pencil, shift) @ (basis / weights[:, None]))
        try:
            inner = np.linalg.inv(fixed @ columns)
        except np.linalg.LinAlgError:
            return None
        left = inner @ solve(np.ascontiguousarray(fixed.T), "T").T
        return cls(pencil, shift, solve, weights, columns @ inner, left, -inner, fixed)

    def inverse(self, b: ComplexArray) -> ComplexArray:
        """The product of the first block (n, n) with b (n, k)."""
        x = self.solve(b)
        return x - self.right @ (self.fixed @ x)

    def eigenvalues(self, known: ComplexArray) -> tuple[ComplexArray, float] | None:
        """All p eigenvalues near the shift, and by how much they may err; None where this is not known.

        Taylor coefficients are added until the bound is sharp.  The last order that gives a bound counts.

        Parameters
        ----------
        known : array (p,)
            Nearly these eigenvalues, which tell how sharp they have to be.
        """
        slope, M = _slope(self.pencil, self.shift), self.pencil.M
        norms = self._norms()
        rounding = self._rounding()
        before, last, terms, disc = np.zeros_like(self.right), self.right, [self.corner], None
        while len(terms) < MOST_TERMS:
            pushed = slope @ last + M @ before
            before, last = last, -self.inverse(pushed)
            terms.append(-self.left @ pushed)
            sizes = (float(np.linalg.norm(self.weights[:, None] * part)) for part in (before, last))
            with np.errstate(over="ignore", invalid="ignore"):
                try:
                    latest = _near_shift(terms, norms, *sizes, rounding)
                except np.linalg.LinAlgError:  # a small matrix is singular, or not finite
                    latest = None
            if latest is not None:
                exact, radius = disc = latest[0] + self.shift, latest[1]
                distance = np.abs(known[:, None] - exact).min(axis=1).max()
                if radius <= max(SHARP * distance, 2.0 * rounding):
                    break
        return disc

    def _norms(self) -> _Norms:
        slope, M = _slope(self.pencil, self.shift), self.pencil.M
        shape = (len(self.weights), SAMPLES)
        random = np.random.default_rng(0)
        samples: Any = random.standard_normal(shape) + 1j * random.standard_normal(shape)
        samples /= np.sqrt(2.0) * self.weights[:, None]
        both = self.inverse(np.hstack([slope @ samples, M @ samples]))
        images = np.linalg.norm(self.weights[:, None] * both, axis=0).reshape(2, SAMPLES).max(axis=1)
        rows = (np.linalg.norm((part.T @ self.left.T).T / self.weights) for part in (slope, M))
        return _Norms(*(FACTOR * images), *rows)

    def _rounding(self) -> float:
        """What rounding of the entries changes in G."""
        size, x, y = abs(self.shift), np.abs(self.right), np.abs(self.left)
        M, C, K = self.pencil.parts
        terms = size**2 * (abs(M) @ x) + size * (abs(C) @ x) + abs(K) @ x
        return ROUNDING * float(np.linalg.norm(y @ terms))


class _Norms(NamedTuple):
    """Bounds of the norms of `inverse` and `left` of :class:`_Bordered`, times Q' (slope) and times M."""

    inverse_slope: float
    inverse_mass: float
    left_slope: float
    left_mass: float


def _near_shift(
    terms: Sequence[ComplexArray], norms: _Norms, before: float, last: float, rounding: float
) -> tuple[ComplexArray, float] | None:
    """The p eigenvalues in a disc around the shift, less the shift, and by how much they may err.

    None where this order of the Taylor polynomial does not tell.

    Parameters
    ----------
    terms : sequence of arrays (p, p)
        Taylor coefficients of G.
    norms : _Norms
    before, last : float
        Sizes of the last but one and the last Taylor coefficient of X.
    rounding : float

    Raises
    ------
    LinAlgError
        Where a small matrix is singular, or not finite.
    """
    order, p = len(terms) - 1, len(terms[0])
    unscale: Any = np.linalg.inv(terms[1])
    A, left_over = _solvent(terms, unscale)
    T = _nearly_normal(A)
    back: Any = np.linalg.inv(T)
    A, unscale = back @ A @ T, back @ unscale
    size = float(np.linalg.norm(A, 2))
    r = 2.0 * size  # the disc's radius
    growth = r * norms.inverse_slope + r**2 * norms.inverse_mass
    bent = sum(
        k * r ** (k - 1) * float(np.linalg.norm(unscale @ terms[k] @ T, 2)) for k in range(2, order + 1)
    )
    if not (growth < 1.0 and bent < 1.0):  # also where one overflows
        return None
    rest = r**order * last + r ** (order + 1) * norms.inverse_mass * before
    rest *= (r * norms.left_slope + r**2 * norms.left_mass) / (1.0 - growth)
    rest += r ** (order + 1) * norms.left_mass * before + left_over + rounding
    rest *= float(np.linalg.norm(unscale, 2) * np.linalg.norm(T, 2)) / (1.0 - bent)
    if not rest < size:
        return None
    exact, mixes = np.linalg.eig(A)
    by_condition = float(np.linalg.cond(mixes)) * rest
    return exact, min(by_condition, (2.0 * size + rest) ** (1.0 - 1.0 / p) * rest ** (1.0 / p))


def _solvent(terms: Sequence[ComplexArray], unscale: ComplexArray) -> tuple[ComplexArray, float]:
    """The small matrix A with G_0 + G_1 A + G_2 A^2 + ... = 0, and the size of what it leaves."""
    A, value = np.zeros_like(terms[0]), terms[0]
    first = np.linalg.norm(unscale @ value)
    for _ in range(SOLVENT_STEPS):
        step = unscale @ value
        A, value = A - step, np.zeros_like(A)
        for term in reversed(terms):
            value = value @ A + term
        size = np.linalg.norm(A)
        if np.linalg.norm(step) <= MACHINE_EPSILON * size or size > 2.0 * first:  # that is no solvent
            break
    return A, float(np.linalg.norm(value))


def _orthonormal(*vectors: Any) -> Any:
    """An orthonormal basis (n, p) of p vectors, with further ones where these depend on each other.

    None where there are not as many directions.
    """
    unit = [part / np.linalg.norm(part, axis=0) for part in vectors]
    parts: Any = linalg.qr(np.hstack(unit), mode="economic", pivoting=len(unit) > 1)
    p = unit[0].shape[1]
    sizes = np.abs(np.diagonal(parts[1]))[:p]
    return parts[0][:, :p] if sizes.min() > DEPENDENT * sizes.max() else None


def _nearly_normal(A: ComplexArray) -> ComplexArray:
    """T, by which the off-diagonal entries of Schur's form of A are no larger than the diagonal ones.

    Where eigenvalues coalesce they would be, and the norm of A much larger than its eigenvalues.
    """
    parts: Any = linalg.schur(A, output="complex")
    triangle, rotation = parts
    largest = np.abs(np.diagonal(triangle)).max()
    beside = np.abs(np.triu(triangle, 1)).max(initial=0.0)
    if beside <= largest:
        return np.eye(len(A), dtype=complex)
    return rotation * (largest / beside) ** np.arange(len(A))


def _slope(pencil: QuadraticPencil, s: complex) -> Matrix:
    """Q'(s)."""
    return 2.0 * s * pencil.M + pencil.C


def _weights(pencil: QuadraticPencil) -> Array:
    """Roots of the masses (n,); freedoms without mass have the share of it that others have of stiffness."""
    masses, springs = pencil.M.diagonal(), np.abs(pencil.K.diagonal())
    springs[springs == 0.0] = springs.max()
    shares = masses / springs
    return np.sqrt(np.where(masses > 0.0, masses, np.median(shares[masses > 0.0]) * springs))
