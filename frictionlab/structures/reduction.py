"""Modes of a structure at samples, the structure in their span, and its errors.

Samples are values of parameters at which the eigenvalues in the window of frequencies are found.  At the
samples a structure in the span of their modes has the same eigenvalues, and between them nearly so.  How
nearly is seen at the next sample, before its modes are added.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice, product
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, sparse

from frictionlab.structures.eigenvalue_bounds import eigenvalue_bounds
from frictionlab.structures.parametric_matrix import Matrix
from frictionlab.structures.quadratic_pencil import QuadraticPencil, factorised
from frictionlab.structures.sliding_equilibrium import static_solver
from frictionlab.structures.window_eigenvalues import WindowEigenvalues, dense_spectrum, unknowns
from frictionlab.validation import abbreviate

if TYPE_CHECKING:
    from frictionlab.structures.structure import ReducedStructure, Structure

Array = NDArray[np.float64]
Point = Mapping[str, float]  # values of some parameters
EXACT = 1e-9  # length that may be left of unit vectors beside a basis which has them
CLOSE = 1e-7  # share of the largest singular value: directions of which modes have less are left out
TOGETHER = 64  # displacements that are solved for at once
MOST_RESPONSES = 300  # to contact forces: with them and some modes all is done by full matrices
STIFF_SHARE = 1e-6  # of the largest compliance of contacts: responses of less are left out
RESPONSE_SHARE = 0.1  # of the largest eigenvalue: the real shift at which responses are taken
KNOWN_RTOL = 1e-6  # share of an eigenvalue by which a reduced structure may miss it at the last sample
EDGE_SHARE = 0.02  # of the window's width: modes so near to its ends may enter or leave it
DAMPED_SHARE = 0.05  # a mode with a larger damping ratio does not grow soon, and need not be known well
MOST_SAMPLES = 17  # of each parameter
HALTON_BASES = (2, 3)


@dataclass(frozen=True, eq=False)
class Sample:
    """The modes of a structure with Im > 0, and real ones that grow, at some values of its parameters.

    Parameters
    ----------
    point : mapping of str to float
    values : complex array (k,)
    shapes : complex array (n, k)
        Of length 1; below them what there is of states of friction laws.
    displacements : array (n,)
        The static ones.
    """

    point: Point
    values: Any
    shapes: Any
    displacements: Array

    @classmethod
    def of(cls, structure: Structure, point: Point) -> Sample:
        """The modes at a point."""
        return cls._of(structure.at_values(point), point)

    @classmethod
    def _of(cls, structure: Structure, point: Point) -> Sample:
        modes: WindowEigenvalues = structure.find_eigenvalues()
        chosen = (modes.values.imag > 0.0) | ((modes.values.imag == 0.0) & _is_slow(structure, modes.values))
        shapes = unknowns(modes.vectors[:, chosen], structure.size)
        sizes = np.linalg.norm(shapes[: structure.size], axis=0)
        shapes /= np.where(sizes > 0.0, sizes, np.linalg.norm(shapes, axis=0))
        return cls(point, modes.values[chosen], shapes, modes.equilibrium.q)

    @classmethod
    def where_known(cls, structure: Structure, points: Iterable[Point]) -> Iterator[Sample | None]:
        """The modes at each point; None where there is no equilibrium.

        Raises
        ------
        ValueError
            If there is none at any point.
        """
        known, missing = False, None
        for point in points:
            there = structure.at_values(point)
            try:
                there.find_equilibrium()
            except ValueError as error:
                missing = error
                yield None
            else:
                known = True
                yield cls._of(there, point)
        if missing is not None and not known:
            raise missing

    def weakly_damped(self, structure: Structure) -> Sample:
        """The modes next to the imaginary axis; all where no vibration is among them."""
        chosen = _is_slow(structure, self.values)
        if not chosen[self.values.imag > 0.0].any():
            return self
        return Sample(self.point, self.values[chosen], self.shapes[:, chosen], self.displacements)

    @property
    def growing(self) -> int:
        """How many modes grow."""
        return int((self.values.real > 0.0).sum())


def _is_slow(structure: Structure, values: Any) -> Any:
    """Which eigenvalues do not decay fast, as seen from the window's upper end."""
    return values.real > (
        -np.inf if structure.window is None else -DAMPED_SHARE * 2 * np.pi * structure.window[1]
    )


def estimated_errors(small: ReducedStructure) -> Array:
    """Estimated distances (m,) of eigenvalues from those of the large structure, 1/s.

    By so much they move where responses of the large structure to what the modes leave in its equations
    join the basis.
    """
    known, full = small.find_eigenvalues(), small.full.at_values(small.parameters)
    if not len(known.values):
        return np.zeros(0)
    pencil = full.with_contacts(full.structural_pencil, small.contact_forces)
    upper = known.values.imag >= 0.0
    vectors = small.expanded(unknowns(known.vectors[:, upper], small.size))
    left_over = pencil.products(known.values[upper], vectors)
    solve = factorised(pencil.at(RESPONSE_SHARE * np.abs(known.values).max()).real.tocsc())
    if solve is None:
        return np.full(len(known.values), np.nan)
    responses = solve(np.hstack([left_over.real, left_over.imag]))[: small.full.size]
    responses /= np.maximum(np.linalg.norm(responses, axis=0), np.finfo(float).tiny)
    wider: Any = extended(small.basis, responses, EXACT)
    if pencil.states:
        wider = sparse.block_diag([wider, sparse.eye_array(pencil.states)], format="csc")
    parts = (sparse.csc_array(wider.T @ (part @ wider)) for part in pencil.parts)
    moved = dense_spectrum(QuadraticPencil(*parts, states=pencil.states)).values
    return np.abs(known.values[:, None] - moved).min(axis=1)


def bounded_errors(small: ReducedStructure, modes: Any) -> Array:
    """Bounds of the distances of eigenvalues, or some of them, from those of the large structure, 1/s."""
    known, pencil = small.find_eigenvalues(), small.full.at_values(small.parameters).pencil
    values, vectors = known.values, small.expanded(unknowns(known.vectors, small.size))
    mirrored = np.abs(values[:, None].conj() - values).argmin(axis=1) if len(values) else 0
    upper = np.where(values.imag < 0.0, mirrored, np.arange(len(values)))
    try:
        places = upper if modes is None else np.atleast_1d(upper[modes])
    except IndexError as error:
        raise IndexError(
            f"modes must be places of the {len(values)} eigenvalues, got {abbreviate(modes)}: give such as "
            "eigenvalues(structure).growing"
        ) from error
    return eigenvalue_bounds(pencil, values, vectors, places)


def reduced(structure: Structure, samples: Sequence[Sample], left_out: float = CLOSE) -> ReducedStructure:
    """The structure in the span of the modes at samples, but for what they have little of."""
    vectors, sizes = proper_orthogonal(structure, samples)
    return structure.projected(vectors[:, sizes > left_out * sizes.max(initial=0.0)])


def proper_orthogonal(structure: Structure, samples: Sequence[Sample]) -> tuple[Array, Array]:
    """Directions (n, k) of modes and static displacements at samples, with what these have of each (k,)."""
    columns = []
    for sample in samples:
        # In this phase modes are as real as they can be, and of their small imaginary parts few matter.
        shapes = sample.shapes[: structure.size]
        shapes = np.exp(-0.5j * np.angle((shapes**2).sum(axis=0))) * shapes
        columns += [shapes.real, shapes.imag]
        if structure.contacts:
            size = np.linalg.norm(sample.displacements) or 1.0
            columns.append(sample.displacements[:, None] / size)
    if not any(column.any() for column in columns):
        raise no_modes(structure)
    parts: Any = linalg.svd(np.hstack(columns), full_matrices=False)
    return parts[0], parts[1]


def no_modes(structure: Structure) -> ValueError:
    """The error of a window without modes."""
    low, high = structure.window or (0.0, np.inf)
    return ValueError(
        f"structure must have modes in its window, got none from {low:g} to {high:g} Hz: give it a "
        "wider window"
    )


def contact_responses(structure: Structure) -> Array:
    """Static displacements (n, k) under forces at the contacts, orthonormal.

    Of many contacts they are those under the combinations of forces that yield most.  All single ones are
    solved for, and not kept.
    """
    rows = [part for one in structure.contacts for part in (one.normal, one.tangential) if part is not None]
    if not rows:
        return np.zeros((structure.size, 0))
    forces: Any = sparse.vstack(rows, format="csr")
    solve = static_solver(structure.static_stiffness)
    compliance = np.hstack([forces @ solve(some.T.toarray()) for some in _in_parts(forces)])
    values, mixes = np.linalg.eigh(0.5 * (compliance + compliance.T))
    soft = np.flatnonzero(values > STIFF_SHARE * values[-1])[-MOST_RESPONSES:]
    loads = (mixes[:, soft] / np.sqrt(values[soft])).T @ forces
    responses = np.empty((structure.size, len(soft)), order="F")
    for i in range(0, len(soft), TOGETHER):
        responses[:, i : i + TOGETHER] = solve(loads[i : i + TOGETHER].T)
    return extended(np.zeros((structure.size, 0)), responses, EXACT)


def _in_parts(rows: Matrix) -> Iterator[Matrix]:
    return (rows[i : i + TOGETHER] for i in range(0, rows.shape[0], TOGETHER))


def extended(basis: Array, vectors: Array, tol: float) -> Array:
    """An orthonormal basis (n, r) and what vectors (n, k) add to it, but for less than `tol`."""
    sizes = np.linalg.norm(vectors, axis=0)
    left = np.asfortranarray(vectors[:, sizes > 0.0])
    left /= sizes[sizes > 0.0]
    for _ in range(2 * (basis.shape[1] > 0)):
        left -= basis @ (basis.T @ left)
    parts: Any = linalg.qr(left, mode="economic", pivoting=True, overwrite_a=True)
    new = parts[0][:, np.abs(np.diagonal(parts[1])) > tol]
    if not basis.shape[1]:
        return new
    # A direction of which little was left is not orthogonal to the basis, to rounding.
    new, _ = np.linalg.qr(new - basis @ (basis.T @ new))
    return np.hstack([basis, new])


def over_box(
    structure: Structure, box: Mapping[str, tuple[float, float]], tol: float = KNOWN_RTOL
) -> tuple[list[Sample], float, int]:
    """Samples over ranges of parameters, by which modes there are known, and by what share they may err.

    Points without an equilibrium have no sample.  The last number counts all points.
    """
    corners = 2 ** len(box)
    points = islice(points_in(box), max(corners, MOST_SAMPLES * len(box)))
    samples: list[Sample] = []
    number, known, errors = 0, 0, [0.0, 0.0]
    for number, sample in enumerate(Sample.where_known(structure, points), 1):
        if sample is None:
            continue
        sample = sample.weakly_damped(structure)
        if number > corners and samples:
            small = reduced(structure, samples)
            if small.size == structure.size:
                errors = [0.0, 0.0]
                break
            errors.append(error_at(small, sample))
            known = known + 1 if errors[-1] <= tol else 0
        samples.append(sample)
        if known == 2:
            break
    return samples, max(errors[-2:]), number


def points_in(box: Mapping[str, tuple[float, float]]) -> Iterator[Point]:
    """The corners of a box, then points that fill it evenly (J. H. Halton, 1960)."""
    yield from (dict(zip(box, corner, strict=True)) for corner in product(*box.values()))
    i = 1
    while True:
        shares = (_radical_inverse(i, base) for base in HALTON_BASES)
        yield {name: low + s * (high - low) for (name, (low, high)), s in zip(box.items(), shares)}
        i += 1


def _radical_inverse(i: int, base: int) -> float:
    """The digits of i behind the point, in reverse: 1/2, 1/4, 3/4, 1/8, ... for the base 2."""
    share, digit = 0.0, 1.0 / base
    while i:
        i, rest = divmod(i, base)
        share += rest * digit
        digit /= base
    return share


def error_at(small: Structure, sample: Sample) -> float:
    """Largest share by which a reduced structure misses an eigenvalue of a sample.

    Those near the window's ends do not count, nor those of strongly damped modes where others are not.
    """
    found = small.at_values(sample.point).find_eigenvalues().values
    values = sample.values[matters(small, sample.values)]
    if not len(values) or not len(found):
        return np.inf if len(values) else 0.0
    return float((np.abs(values[:, None] - found).min(axis=1) / np.abs(values)).max())


def matters(small: Structure, values: Any) -> NDArray[np.bool_]:
    """Which eigenvalues are to be known: not near the window's ends, nor strongly damped if some are not."""
    frequencies = np.abs(values.imag) / (2 * np.pi)
    low, high = small.window or (-np.inf, np.inf)
    edge = EDGE_SHARE * (high - low) if small.window else 0.0
    inside = (frequencies >= low + edge * (low > 0.0)) & (frequencies <= high - edge)
    weak = inside & (np.abs(values.real) < DAMPED_SHARE * np.abs(values))
    return weak if weak.any() else inside & (values.imag != 0.0)
