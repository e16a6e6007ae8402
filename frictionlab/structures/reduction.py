"""A structure of few freedoms that has the modes of a large one at some values of its parameters.

The displacements are those in the span of modes at samples: values of parameters at which the eigenvalues in
the window of frequencies are found.  The matrices are projected on it.  At the samples the smaller structure
has the same eigenvalues, and between them nearly so.  How nearly is seen at the next sample, before its modes
are added: samples are added until the eigenvalues there are known already.  Source: N. Graebner, V. Mehrmann,
S. Quraishi, C. Schroeder, U. von Wagner, "Numerical methods for parametric model reduction in the simulation
of disk brake squeal", ZAMM 96 (2016) 1388-1405.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from frictionlab.structures.window_eigenvalues import WindowEigenvalues

if TYPE_CHECKING:
    from frictionlab.structures.structure import Structure

Array = NDArray[np.float64]
Point = Mapping[str, float]  # values of some parameters
EXACT, CLOSE = 1e-9, 1e-6  # lengths that may be left of unit vectors beside a basis which has them
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
        Of length 1.
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
        there = structure.at_values(point)
        modes: WindowEigenvalues = there.find_eigenvalues()
        chosen = (modes.values.imag > 0.0) | ((modes.values.real > 0.0) & (modes.values.imag == 0.0))
        shapes = modes.vectors[: structure.size, chosen]
        shapes /= np.linalg.norm(shapes, axis=0)
        return cls(point, modes.values[chosen], shapes, modes.equilibrium.q)

    @property
    def growing(self) -> int:
        """How many modes grow."""
        return int((self.values.real > 0.0).sum())


@dataclass(frozen=True, eq=False)
class Reduction:
    """A large structure and a basis of displacements.

    Parameters
    ----------
    full : Structure
    basis : array (n, r)
        Orthonormal.
    """

    full: Structure
    basis: Array

    @classmethod
    def of(cls, structure: Structure, samples: Sequence[Sample], tol: float = CLOSE) -> Reduction:
        """The reduction that has the modes of samples."""
        reduction = cls(structure, np.zeros((structure.size, 0)))
        for sample in samples:
            reduction = reduction.with_modes(sample, tol)
        return reduction

    def with_modes(self, sample: Sample, tol: float = CLOSE) -> Reduction:
        """The reduction that has further modes, and static displacements where there are contacts."""
        # In this phase modes are as real as they can be, and of their small imaginary parts few matter.
        phases = np.exp(-0.5j * np.angle((sample.shapes**2).sum(axis=0)))
        shapes = np.hstack([(phases * sample.shapes).real, (phases * sample.shapes).imag])
        if self.full.contacts:
            size = np.linalg.norm(sample.displacements) or 1.0
            shapes = np.column_stack([shapes, sample.displacements / size])
        left = shapes - self.basis @ (self.basis.T @ shapes)
        left -= self.basis @ (self.basis.T @ left)
        parts: Any = linalg.qr(left, mode="economic", pivoting=True)
        directions, sizes = parts[0], np.abs(np.diagonal(parts[1]))
        new = directions[:, : int((sizes > tol).sum())]
        # A direction of which little was left is not orthogonal to the basis, to rounding.
        new, _ = np.linalg.qr(new - self.basis @ (self.basis.T @ new))
        return Reduction(self.full, np.hstack([self.basis, new]))

    @property
    def structure(self) -> Structure:
        """The structure of r freedoms."""
        return self.full.projected(self.basis)


def along_path(structure: Structure, parameter: str, bounds: tuple[float, float]) -> list[Sample]:
    """Samples between two values of a parameter, by which a reduction knows the modes between them."""
    return over_box(structure, {parameter: bounds})


def over_box(structure: Structure, box: Mapping[str, tuple[float, float]]) -> list[Sample]:
    """Samples over ranges of parameters, by which a reduction knows the modes there."""
    points = _points(box)
    samples = [Sample.of(structure, next(points)) for _ in range(2 ** len(box))]
    reduction = Reduction.of(structure, samples)
    known = 0
    for _ in range(MOST_SAMPLES * len(box) - len(samples)):
        sample = Sample.of(structure, next(points))
        known = known + 1 if _is_known(reduction.structure, sample) else 0
        samples.append(sample)
        if known == 2 or reduction.basis.shape[1] == structure.size:
            break
        reduction = reduction.with_modes(sample)
    return samples


def _points(box: Mapping[str, tuple[float, float]]) -> Iterator[Point]:
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


def _is_known(small: Structure, sample: Sample) -> bool:
    """Whether a reduced structure has the eigenvalues of a sample, away from the window's ends."""
    found = small.at_values(sample.point).find_eigenvalues().values
    frequencies = sample.values.imag / (2 * np.pi)
    low, high = small.window or (-np.inf, np.inf)
    edge = EDGE_SHARE * (high - low) if small.window else 0.0
    matters = np.abs(sample.values.real) < DAMPED_SHARE * np.abs(sample.values)
    matters &= (frequencies >= low + edge * (low > 0.0)) & (frequencies <= high - edge)
    values = sample.values[matters]
    if not len(values) or not len(found):
        return not len(values)
    return bool((np.abs(values[:, None] - found).min(axis=1) <= KNOWN_RTOL * np.abs(values)).all())
