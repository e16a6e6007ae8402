"""Eigenvalues of s^2 M + s C + K next to a shift, of large sparse matrices.

The quadratic Q(s) is linearised: z = (u, s u) turns it into a pencil A - s B of twice the size.  Arnoldi's
method is applied to (A - shift B)^-1 B, whose largest eigenvalues 1/(s - shift) belong to the s nearest to
the shift.  A product with it takes one solution with Q(shift), which is factorised once; with a real shift
all is real.

Time is measured in units of 1/`scale`, so that displacements and velocities have alike sizes.  Without that
residuals are thousands of times larger.

The Krylov space grows until all Ritz values in the disc have converged.  Then the search starts again beside
what it has, from another vector, since one vector sees only one of two equal eigenvalues.  It ends when
nothing is left in the disc.  Source: Y. Saad, "Numerical Methods for Large Eigenvalue Problems", 2nd ed.
(SIAM 2011), sections 4.2, 6.2 and 8.1; F. Tisseur and K. Meerbergen, "The quadratic eigenvalue problem", SIAM
Review 43 (2001) 235-286.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from importlib import import_module
from importlib.util import find_spec
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, sparse
from scipy.sparse import linalg as sparse_linalg

from frictionlab.structures.parametric_matrix import Matrix

Array = NDArray[Any]
Product: TypeAlias = Callable[[Array], Array]  # a matrix times columns
ComplexArray = NDArray[np.complex128]
FIRST_STEPS = 40  # of Arnoldi's method, before Ritz values are looked at
GROWTH = 1.2  # of the number of steps between two looks
RITZ_RTOL = 1e-13  # residual of a Ritz value, as a share of it, that counts as converged
OUTSIDE_RTOL = (
    1e-3  # the same of the nearest Ritz value outside the disc, which shows that the disc is covered
)
MOST_STEPS = 3000
DEPENDENT = 1e-10  # length of a unit vector that is left beside others, below which it depends on them
PIVOT_SHARE = 0.01  # of a column's largest entry: a smaller diagonal entry is no pivot
ACCURATE = 1e-10  # share of what is solved that a solution may leave
REST_RTOL = 16.0 * float(np.finfo(float).eps)  # of the energies of all springs: that of a rigid motion
RIGID_RTOL = 1e-6  # of the forces of all springs: those of a rigid motion, whose vector is less exact
SLOW_RTOL = 1e3 * REST_RTOL  # of the energies of all springs: that of a motion which rounding lets begin
DISSECTED = 20_000  # freedoms from which an order by nested dissection is worth its time
INVERSE_STEPS = 12
ASIDE = 1e-6  # share of an eigenvalue by which a shift lies beside it
SETTLED_RTOL = 1e-11  # of an eigenvalue: Rayleigh quotients that move by less are settled
CLOSE = 1e-5  # of unit vectors: their errors, which are squared in the quotient
SHIFT_MOVES = (0.0, 0.07, -0.05)  # of the radius: where a shift is next to an eigenvalue, it is moved
LARGEST = 1e4  # radii over the distance of the nearest eigenvalue, which takes so many digits from the others
POWER_STEPS = 3


class Spectrum(NamedTuple):
    """Eigenvalues (m,) in 1/s, and vectors (n, m) as columns."""

    values: ComplexArray
    vectors: ComplexArray


class Mode(NamedTuple):
    """An eigenvalue, 1/s, with its right and left vector (n,), y Q'(s) x = 1."""

    value: complex
    right: ComplexArray
    left: ComplexArray


@dataclass(frozen=True, eq=False)
class QuadraticPencil:
    """s^2 M + s C + K.

    Parameters
    ----------
    M, C, K : csc_array (n, n)
    states : int
        How many of the n unknowns, at the end, are states of friction laws: M has no rows of these.
    """

    M: Matrix
    C: Matrix
    K: Matrix
    states: int = 0

    @property
    def size(self) -> int:
        """The number n of unknowns: freedoms, and states of friction laws."""
        return int(self.M.shape[0])

    @property
    def parts(self) -> tuple[Matrix, Matrix, Matrix]:
        """M, C and K."""
        return self.M, self.C, self.K

    def transposed(self) -> QuadraticPencil:
        """The pencil whose right vectors are the left vectors of this one."""
        return QuadraticPencil(self.M.T.tocsc(), self.C.T.tocsc(), self.K.T.tocsc(), self.states)

    @cached_property
    def of_highest_rates(self) -> Array:
        """The full matrix (n, n) of accelerations, and of the rates of states."""
        n = self.size - self.states
        return np.hstack([self.M[:, :n].toarray(), self.C[:, n:].toarray().real])

    def at(self, s: complex) -> Matrix:
        """Q(s) (n, n)."""
        return s * s * self.M + s * self.C + self.K

    def products(self, values: ComplexArray, vectors: ComplexArray) -> ComplexArray:
        """Q(s) x (n, m) for each eigenvalue s and its vector x."""
        return values**2 * (self.M @ vectors) + values * (self.C @ vectors) + self.K @ vectors

    def residuals(self, values: ComplexArray, vectors: ComplexArray) -> Array:
        """|Q(s) x| (m,) as a share of |s^2 M x| + |s C x| + |K x|; 0 where all are nothing but rounding."""
        terms = values**2 * (self.M @ vectors), values * (self.C @ vectors), self.K @ vectors
        sizes = np.sum([np.linalg.norm(term, axis=0) for term in terms], axis=0)
        sizes[self.at_rest(values, vectors)] = 0.0
        return _shares(np.linalg.norm(sum(terms), axis=0), sizes)

    def at_rest(self, values: ComplexArray, vectors: ComplexArray) -> NDArray[np.bool_]:
        """Which eigenpairs (m,) are rigid bodies at rest: s is 0 but for rounding.

        The eigenvalue 0 of a rigid motion is a double one, so that rounding of K moves it by the root of its
        share.  The elastic energy x K x tells more: it errs by that share only.
        """
        x = np.abs(vectors)
        size = (x * (abs(self.K) @ x)).sum(axis=0)
        held = self.K @ vectors
        moving = np.abs(values) ** 2 * np.abs((vectors.conj() * (self.M @ vectors)).sum(axis=0))
        damped = np.abs(values) * np.abs((vectors.conj() * (self.C @ vectors)).sum(axis=0))
        rest = np.abs((vectors.conj() * held).sum(axis=0)) <= REST_RTOL * size
        rest &= (held.real**2 + held.imag**2).sum(axis=0) <= RIGID_RTOL**2 * ((abs(self.K) @ x) ** 2).sum(
            axis=0
        )
        return rest & (moving + damped <= SLOW_RTOL * size)

    def backward_errors(self, values: ComplexArray, vectors: ComplexArray) -> Array:
        """|Q(s) x| (m,) as a share of (|s|^2 |M| + |s| |C| + |K|) |x|, by Tisseur (2000), Theorem 1.

        A change of the matrices by this share of their (1-)norms makes the eigenpair exact.
        """
        mass, damping, stiffness = self._norms
        sizes = np.abs(values) ** 2 * mass + np.abs(values) * damping + stiffness
        left_over = np.linalg.norm(self.products(values, vectors), axis=0)
        return _shares(left_over, sizes * np.linalg.norm(vectors, axis=0))

    @cached_property
    def _norms(self) -> tuple[float, ...]:
        return tuple(float(sparse_linalg.norm(part, 1)) for part in self.parts)

    def products_of_modes(self, left: Spectrum, right: Spectrum) -> ComplexArray:
        """y ((s + t) M + C) x (k, m) for left vectors y at s and right vectors x at t.

        It is 0 for two modes of this pencil with different eigenvalues, and y Q'(s) x for one.
        """
        y, x = left.vectors, right.vectors
        return (left.values[:, None] + right.values) * (y.T @ (self.M @ x)) + y.T @ (self.C @ x)

    def mode_at(self, guess: complex) -> Mode | None:
        """The mode whose eigenvalue is next to a guess, by residual inverse iteration; None where it fails.

        One factorisation serves the right and the left vector; the eigenvalue is their Rayleigh quotient.
        Source: A. Neumaier, "Residual inverse iteration for the nonlinear eigenvalue problem", SIAM J. Numer.
        Anal. 22 (1985) 914-923.
        """
        solve = factorised(self.at(guess * (1.0 + ASIDE)))  # at an eigenvalue itself it is singular
        if solve is None:
            return None
        start: Any = np.random.default_rng(0).standard_normal(self.size).astype(complex)
        x: Any = solve(start)
        y: Any = solve(start, "T")
        value = guess
        for _ in range(INVERSE_STEPS):
            x, y = x / np.linalg.norm(x), y / np.linalg.norm(y)
            before, value = value, self._quotient(y, x, value)
            there = self.at(value)
            errors = solve(there @ x), solve(there.T @ y, "T")
            if abs(value - before) <= SETTLED_RTOL * abs(value) and max(map(np.linalg.norm, errors)) < CLOSE:
                slope = complex(y @ (2.0 * value * (self.M @ x) + self.C @ x))
                return Mode(value, x, y / slope) if slope else None
            x, y = x - errors[0], y - errors[1]
        return None

    def slope_of(self, mode: Mode) -> complex:
        """-y (dQ/dp) x, the derivative of a mode's eigenvalue, where this pencil is dQ/dp."""
        return -complex(mode.left @ self.products(np.array([mode.value]), mode.right[:, None])[:, 0])

    def _quotient(self, y: ComplexArray, x: ComplexArray, guess: complex) -> complex:
        """The root of y Q(s) x = 0 next to a guess."""
        parts = [y @ (part @ x) for part in self.parts]
        roots = np.roots(np.array(parts) / max(map(abs, parts)))
        return complex(roots[np.abs(roots - guess).argmin()])

    def near(self, shift: complex, radius: float) -> Spectrum:
        """All eigenvalues within a distance from the shift.

        Raises
        ------
        ArithmeticError
            If the search does not come to an end.
        """
        operator = _shift_invert(self, shift, radius)
        known = _invariant_subspace(operator, _nothing(operator))
        pairs: Any = np.linalg.eig(known.action)
        inverses, small = pairs
        values = operator.shift + operator.scale / inverses.astype(complex)
        return Spectrum(values, known.basis[: operator.size] @ small.astype(complex))


def real_modes(
    stiffness: Product,
    mass: Product,
    solve: Product,
    size: int,
    highest: float,
    shift: float = 0.0,
    rigid: Array | None = None,
) -> tuple[Array, Array]:
    """Modes of K x = w^2 M x with w up to `highest`, both matrices symmetric and none negative.

    Parameters
    ----------
    stiffness, mass, solve : callable
        Give K x, M x and (K + shift^2 M)^-1 b of columns (n, k) or (n,).
    size : int
        The number n.
    highest, shift : float
        rad/s.
    rigid : array (n, r), optional
        Motions without elastic energy.  Then `solve`, without a shift, gives any solution, of loads b that do
        no work on these.

    Returns
    -------
    w : array (m,)
        Ascending, rad/s.
    shapes : array (n, m)
        x M x = 1 of each.
    """
    operator = _SymmetricShiftInvert(np.hypot(highest, shift), size, mass, solve)
    known = _nothing(operator)
    if rigid is not None and rigid.shape[1]:
        x: Array = rigid @ np.linalg.inv(np.linalg.cholesky(rigid.T @ mass(rigid))).T  # x M x = 1 of each
        operator = _without_rigid(operator, x, mass(x))
        known = _Invariant(np.linalg.qr(x)[0], np.zeros((x.shape[1],) * 2))
    basis = _invariant_subspace(operator, known).basis
    if not basis.shape[1]:
        return np.zeros(0), basis
    pairs: Any = linalg.eigh(basis.T @ stiffness(basis), basis.T @ mass(basis))
    return np.sqrt(np.maximum(pairs[0], 0.0)), basis @ pairs[1]


def _shares(parts: Array, wholes: Array) -> Array:
    """Parts as shares of wholes; 0 of nothing, as of a rigid motion, in which all terms are zero."""
    return np.divide(parts, wholes, out=np.zeros_like(parts), where=wholes > 0.0)


_Operator: TypeAlias = "_ShiftInvert | _SymmetricShiftInvert"


class _Invariant(NamedTuple):
    """An invariant subspace: its orthonormal basis V (2n, k) and S (k, k), with which T V = V S."""

    basis: Array
    action: Array


@dataclass(frozen=True, eq=False)
class _ShiftInvert:
    """T = (A - shift B)^-1 B in the unit of time 1/scale, in which the disc has the radius 1.

    Parameters
    ----------
    shift : complex
    scale : float
        The disc's radius, 1/s.
    M, C : csc_array (n, n)
        scale^2 M and scale C.
    solve : callable
        Solves Q(shift) x = b.
    """

    shift: complex
    scale: float
    M: Matrix
    C: Matrix
    solve: Callable[[Array], Array]

    @property
    def size(self) -> int:
        return int(self.M.shape[0])  # as the pencil's

    @property
    def rows(self) -> int:
        """Of the vectors that it takes."""
        return 2 * self.size

    @property
    def dtype(self) -> Any:
        return complex if isinstance(self.shift, complex) else float

    def __call__(self, z: Array) -> Array:
        u, v = z[: self.size], z[self.size :]
        at = self.shift / self.scale
        x = -self.solve(self.M @ (v + at * u) + self.C @ u)
        return np.concatenate([x, u + at * x])

    def largest(self) -> float:
        """Size of the largest eigenvalue, about: of the one next to the shift."""
        z = np.random.default_rng(0).standard_normal(2 * self.size).astype(self.dtype)
        size = 1.0
        for _ in range(POWER_STEPS):
            z = self(z / np.linalg.norm(z))
            size = float(np.linalg.norm(z))
        return size


@dataclass(frozen=True, eq=False)
class _SymmetricShiftInvert:
    """T = scale^2 K^-1 M: its eigenvalues of 1 and more are those of modes with w up to `scale`, rad/s."""

    scale: float
    rows: int
    mass: Product
    solve: Product
    dtype: Any = float

    def __call__(self, x: Array) -> Array:
        return self.scale**2 * self.solve(self.mass(x))


def _without_rigid(operator: _SymmetricShiftInvert, rigid: Array, momenta: Array) -> _SymmetricShiftInvert:
    """The operator beside rigid motions x (n, r), x M x = 1, of these momenta M x, which it makes zero."""

    def mass(x: Array) -> Array:
        loads = operator.mass(x)
        return loads - momenta @ (rigid.T @ loads)

    def solve(loads: Array) -> Array:
        x = operator.solve(loads)
        return x - rigid @ (momenta.T @ x)

    return replace(operator, mass=mass, solve=solve)


def _shift_invert(pencil: QuadraticPencil, shift: complex, radius: float) -> _ShiftInvert:
    """The operator at a shift, or at one nearby where this one is next to an eigenvalue."""
    whole = np.iscomplexobj(pencil.K.data) or bool(np.imag(shift))
    last = None
    for move in SHIFT_MOVES:
        at = shift + move * radius * shift / abs(shift)
        at = complex(at) if whole else float(np.real(at))
        # a disc around a moved shift has to hold the one that was asked for
        reach = radius + abs(at - shift)
        solve = factorised(pencil.at(at))
        if solve is not None:
            last = _ShiftInvert(at, reach, reach**2 * pencil.M, reach * pencil.C, solve)
            if last.largest() <= LARGEST:
                return last
    if last is not None:
        return last
    raise ArithmeticError(
        f"s^2 M + s C + K is singular at s = {shift:.6g}/s and nearby: a freedom has neither mass nor "
        "stiffness, or M and K have a common null vector"
    )


def factorised(matrix: Matrix) -> Callable[..., Array] | None:
    """What solves matrix x = b, or with "T" its transpose; None where the matrix is singular to rounding."""
    if not matrix.data.flags.c_contiguous:  # the real part of a complex matrix is a view of it
        matrix = matrix.copy()
    sample = np.random.default_rng(0).standard_normal(matrix.shape[0]).astype(matrix.dtype)
    symmetric = {"diag_pivot_thresh": PIVOT_SHARE, "options": {"SymmetricMode": True}}
    # An order for symmetric patterns makes half the entries; pivots by size are needed where it is not exact.
    for options in (symmetric | {"permc_spec": "MMD_AT_PLUS_A"}, {}):
        order = _nested_dissection(matrix) if options else None
        try:
            if order is None:
                solve = sparse_linalg.splu(matrix, **options).solve
            else:
                solve = _in_order(order, matrix, symmetric | {"permc_spec": "NATURAL"})
        except RuntimeError:  # exactly singular
            continue
        x = solve(sample)
        size = sparse_linalg.norm(matrix, np.inf) * np.abs(x).max() + np.abs(sample).max()
        if np.isfinite(x).all() and np.abs(matrix @ x - sample).max() <= ACCURATE * size:
            return solve
    return None


def _in_order(order: NDArray[np.intp], matrix: Matrix, options: Any) -> Callable[..., Array]:
    """What solves matrix x = b by factors of the matrix in an order (n,) of its rows and columns."""
    factors = sparse_linalg.splu(matrix[order][:, order].tocsc(), **options)

    def solve(b: Array, trans: Any = "N") -> Array:
        x = np.empty_like(b)
        x[order] = factors.solve(b[order], trans)
        return x

    return solve


def _nested_dissection(matrix: Matrix) -> NDArray[np.intp] | None:
    """An order of a large matrix in which its factors have few entries, by METIS; None without pymetis.

    Freedoms of one node have the same neighbours, and stay together.  G. Karypis, V. Kumar, "A fast and high
    quality multilevel scheme for partitioning irregular graphs", SIAM J. Sci. Comput. 20 (1998) 359-392.
    """
    n = matrix.shape[0]
    if n < DISSECTED or find_spec("pymetis") is None:
        return None
    metis: Any = import_module("pymetis")
    pattern = sparse.csr_array((np.ones(matrix.nnz, dtype=np.int64), matrix.indices, matrix.indptr), (n, n))
    pattern = (pattern + pattern.T).tocsr()
    pattern.data[:] = 1
    names = pattern @ np.random.default_rng(0).integers(1, 2**40, n)  # the same for the same neighbours
    _, node = np.unique(names, return_inverse=True)
    nodes = int(node.max()) + 1
    gather = sparse.csr_array((np.ones(n, dtype=np.int64), (node, np.arange(n))), (nodes, n))
    graph = sparse.coo_array(gather @ pattern @ gather.T)
    beside = graph.row != graph.col
    graph = sparse.csr_array((graph.data[beside], (graph.row[beside], graph.col[beside])), graph.shape)
    order, _ = metis.nested_dissection(metis.CSRAdjacency(graph.indptr, graph.indices))
    rank = np.empty(nodes, dtype=np.intp)
    rank[np.asarray(order)] = np.arange(nodes)
    return np.argsort(rank[node], kind="stable")


def _nothing(operator: _Operator) -> _Invariant:
    return _Invariant(np.zeros((operator.rows, 0), operator.dtype), np.zeros((0, 0), operator.dtype))


def _invariant_subspace(operator: _Operator, known: _Invariant) -> _Invariant:
    """The subspace of all eigenvalues in the disc, beside what is known."""
    while (wider := _extend(operator, known)) is not None:
        known = wider
    return known


def _extend(operator: _Operator, known: _Invariant) -> _Invariant | None:
    """A larger invariant subspace, with eigenvalues in the disc that were missing; None if none is."""
    if known.basis.shape[1] == known.basis.shape[0]:  # all eigenvalues are in the disc
        return None
    krylov = _Krylov.start(operator, known)
    look = FIRST_STEPS
    while True:
        exhausted = krylov.grow(min(look, krylov.most))
        inside, settled = krylov.look()
        if settled or exhausted:
            break
        if krylov.steps >= min(MOST_STEPS, krylov.most):
            raise ArithmeticError(
                f"{MOST_STEPS} steps of Arnoldi's method did not find all eigenvalues within "
                f"{operator.scale / (2 * np.pi):.6g} Hz: take a smaller window"
            )
        look = int(np.ceil(GROWTH * look))
    return krylov.extended(known) if inside else None


def _is_inside(value: complex, imaginary: float = 0.0) -> bool:
    """Whether a Ritz value is of the disc; of a real matrix its real and imaginary parts come apart."""
    return bool(np.hypot(np.abs(value), imaginary) >= 1.0)


class _Krylov:
    """An Arnoldi factorisation T Q = V G + Q H + q e^T beside an invariant subspace V; it grows."""

    def __init__(self, operator: _Operator, known: _Invariant, start: Array) -> None:
        self.operator, self.known, self.steps = operator, known, 0
        self.most = len(start) - known.basis.shape[1]
        room = min(2 * FIRST_STEPS, self.most) + 1
        self._basis = np.zeros((len(start), room), operator.dtype, order="F")
        self._action = np.zeros((room, room), operator.dtype)
        self._coupling = np.zeros((known.basis.shape[1], room), operator.dtype)
        self._basis[:, 0] = start

    @classmethod
    def start(cls, operator: _Operator, known: _Invariant) -> _Krylov:
        """From a random vector, always the same one."""
        rng = np.random.default_rng(known.basis.shape[1])
        vector = operator(rng.standard_normal(operator.rows).astype(operator.dtype))
        for _ in range(2):
            vector = vector - known.basis @ (known.basis.conj().T @ vector)
        return cls(operator, known, vector / np.linalg.norm(vector))

    def grow(self, steps: int) -> bool:
        """Up to so many steps; whether the space is invariant and can grow no further."""
        while self.steps < steps:
            j = self.steps
            self._make_room(j + 2)
            vector = self.operator(self._basis[:, j])
            size = np.linalg.norm(vector)
            left = self.known.basis, self._basis[:, : j + 1]
            for _ in range(2):  # once is not enough (Gram and Schmidt's method loses half the digits)
                for basis, into in zip(left, (self._coupling[:, j], self._action[: j + 1, j])):
                    part = (vector.conj() @ basis).conj()  # not so many numbers are conjugated
                    vector = vector - basis @ part
                    into += part
            rest = np.linalg.norm(vector)
            self._action[j + 1, j] = rest
            self.steps += 1
            if rest <= DEPENDENT * size or self.steps == self.most:
                return True
            self._basis[:, j + 1] = vector / rest
        return False

    def look(self) -> tuple[bool, bool]:
        """Whether there are Ritz values in the disc; whether all there have converged, and it is covered."""
        m = self.steps
        ritz, vectors = np.linalg.eig(self._action[:m, :m])
        sizes = np.abs(ritz)
        errors = self._action[m, m - 1].real * np.abs(vectors[-1]) / np.linalg.norm(vectors, axis=0)
        inside = sizes >= 1.0
        outside = np.where(inside, 0.0, sizes)
        nearest = int(outside.argmax())
        covered = bool(errors[nearest] <= OUTSIDE_RTOL * outside[nearest])
        return bool(inside.any()), covered and bool((errors <= RITZ_RTOL * sizes)[inside].all())

    def extended(self, known: _Invariant) -> _Invariant:
        """The known subspace and that of the Ritz values in the disc."""
        m = self.steps
        kind = "complex" if self.operator.dtype is complex else "real"
        form: Any = linalg.schur(self._action[:m, :m], kind, sort=_is_inside)
        schur, vectors, count = form
        chosen = vectors[:, :count]
        coupling = self._coupling[:, :m] @ chosen
        corner = np.zeros((count, known.action.shape[1]), self.operator.dtype)
        return _Invariant(
            np.hstack([known.basis, self._basis[:, :m] @ chosen]),
            np.block([[known.action, coupling], [corner, schur[:count, :count]]]),
        )

    def _make_room(self, columns: int) -> None:
        held = self._basis.shape[1]
        if columns <= held:
            return
        more = max(columns, held + held // 2) - held
        self._basis = np.asfortranarray(np.pad(self._basis, ((0, 0), (0, more))))
        self._action = np.pad(self._action, (0, more))
        self._coupling = np.pad(self._coupling, ((0, 0), (0, more)))
