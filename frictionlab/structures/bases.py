"""`fl.reduce`: a structure of few freedoms with the modes of a large one, on a basis chosen by tolerance.

The matrices are projected on a basis of displacements: :class:`ComplexModes`, :class:`RealModes` or
:class:`CraigBampton`.
"""

from __future__ import annotations

import warnings
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from frictionlab.models.model import check_parameter_name
from frictionlab.stability.large_system import LargeSystem
from frictionlab.structures.parametric_matrix import Matrix
from frictionlab.structures.quadratic_pencil import Product, QuadraticPencil, factorised, real_modes
from frictionlab.structures.reduction import (
    CLOSE,
    EXACT,
    Point,
    Sample,
    contact_responses,
    error_at,
    extended,
    matters,
    no_modes,
    over_box,
    points_in,
    proper_orthogonal,
    reduced,
)
from frictionlab.structures.sliding_equilibrium import static_solver
from frictionlab.validation import (
    abbreviate,
    check_limits,
    check_mapping,
    check_number,
    check_sequence,
    explains_fields,
    explains_keywords,
)

if TYPE_CHECKING:
    from frictionlab.structures.structure import ReducedStructure, Structure

Array = NDArray[np.float64]
Modes = tuple[Array, Array]  # frequencies (m,), rad/s, and shapes (n, m)
Box = Mapping[str, tuple[float, float]]  # ranges of parameters
LEAST_TOL, MOST_TOL = 1e-10, 0.1  # of eigenvalues
LEFT_OUT = 10.0 ** -np.arange(2, 10)  # of the largest singular value, tried in turn
ESTIMATE_SHARE = 0.5  # of the tolerance: estimates are right to a factor of two
FINER = 2.0**0.25  # ratio of the highest frequencies of modes that are tried in turn
WIDER = 2.0  # the same of those up to which modes are computed
MOST_CUTS = 64  # such frequencies, up to 65,000 times the window's end: freedoms without mass have no modes
MOST_FREEDOMS = 1000  # of a basis of real modes: beyond, full matrices are slow, and motions are refused
SHIFT_SHARE = 0.1  # of the highest frequency: the shift, by which rigid motions are no obstacle
RIGID_SHARE = 1e-3  # of a shift: the frequency up to which rigid motions are looked for


class ReductionBasis(ABC):
    """Base of what a structure is projected on; `cure` says what helps where the tolerance is not reached."""

    cure: ClassVar[str]

    @abstractmethod
    def reduced(self, structure: Structure, box: Box, tol: float) -> tuple[ReducedStructure, float]:
        """The structure on this basis, and by what share eigenvalues may err over ranges of parameters."""


@dataclass(frozen=True)
class ComplexModes(ReductionBasis):
    """Complex modes at samples of the parameters, as a proper orthogonal basis.

    The displacements are those in the span of modes at the samples, of static displacements, and of static
    responses to the contact forces; of more than 300 such responses those under the combinations of forces
    that yield most.  Samples are added until the eigenvalues at two further ones are known already, and
    between them where estimates are above half the tolerance.  Then as many directions are left out as the
    tolerance allows.

    Source: N. Graebner, V. Mehrmann, S. Quraishi, C. Schroeder, U. von Wagner, "Numerical methods for
    parametric model reduction in the simulation of disk brake squeal", ZAMM 96 (2016) 1388-1405.

    Examples
    --------
    >>> import frictionlab as fl
    >>> fl.reduce(fl.DiscBrake(), tol=1e-4, basis=fl.ComplexModes()).size < fl.DiscBrake().size
    True
    """

    cure = "take shorter ranges"

    def reduced(self, structure: Structure, box: Box, tol: float) -> tuple[ReducedStructure, float]:
        """The structure on this basis, and by what share eigenvalues may err over ranges of parameters."""
        samples, error, count = over_box(structure, box, tol)
        others = islice(points_in(box), count, count + len(samples)) if box else ()
        between = [point for point in others if _has_equilibrium(structure, point)]
        samples = _with_samples_between(structure, samples, between, tol)
        small, left_out = _smallest(structure, samples, between, max(tol, error))
        return small, max(error, left_out)


class _ModesUpToFrequency(ReductionBasis):
    """Base of bases of real modes, whose highest frequency the tolerance chooses.

    Errors are measured at the corners of the ranges of parameters and in the middle.
    """

    cure = "take fl.ComplexModes(), or a larger tolerance"

    @abstractmethod
    def fixed(self, structure: Structure) -> Array:
        """Displacements (n, k) that are in the basis whatever the tolerance, orthonormal."""

    @abstractmethod
    def modes(self, structure: Structure, highest: float) -> Sequence[Modes]:
        """Groups of modes up to a frequency, rad/s."""

    def reduced(self, structure: Structure, box: Box, tol: float) -> tuple[ReducedStructure, float]:
        """The structure on this basis, and by what share eigenvalues may err over ranges of parameters."""
        count = 2 ** len(box) + bool(box)
        at_points = Sample.where_known(structure, islice(points_in(box), count))
        samples = [one.weakly_damped(structure) for one in at_points if one is not None]
        if not any(len(one.values) for one in samples):
            raise no_modes(structure)
        fixed = self.fixed(structure)
        if structure.contacts:
            fixed = extended(fixed, np.stack([one.displacements for one in samples], axis=1), EXACT)
        for vectors in islice(self._ever_more(structure), MOST_CUTS):
            small = structure.projected(extended(fixed, vectors, EXACT))
            error = _largest_error(small, samples, tol)
            if error <= tol or small.size >= min(MOST_FREEDOMS, structure.size):
                break
        return small, error

    def _ever_more(self, structure: Structure) -> Iterator[Array]:
        """Modes (n, k) up to higher and higher frequencies, from the window's end on."""
        cut = reach = 2 * np.pi * structure.window[1]
        groups: Sequence[Modes] = ()
        while True:
            cut *= FINER
            if cut > reach:
                reach *= WIDER
                groups = self.modes(structure, reach)
            yield np.hstack([shapes[:, w <= cut] for w, shapes in groups])


@dataclass(frozen=True)
class RealModes(_ModesUpToFrequency):
    """Real modes of M and K, without damping, rotation and friction, up to a frequency.

    Springs of closed contacts are in K.  Static displacements and static responses to the contact forces are
    in the basis, as in :class:`ComplexModes`.  The modes are those at the values of the parameters at hand.

    Examples
    --------
    >>> import numpy as np
    >>> import frictionlab as fl
    >>> springs = 2 * np.eye(60) - np.eye(60, k=1) - np.eye(60, k=-1)
    >>> chain = fl.Structure(np.eye(60), springs, window=(0, 0.05))
    >>> fl.reduce(chain, basis=fl.RealModes())  # its modes are real
    ReducedStructure(60 freedoms to 7 freedoms, 0 to 0.05 Hz)
    """

    def fixed(self, structure: Structure) -> Array:
        """Responses to the contact forces."""
        return contact_responses(structure)

    def modes(self, structure: Structure, highest: float) -> Sequence[Modes]:
        """The real modes."""
        K, M = _without_friction(structure)
        shift = SHIFT_SHARE * highest
        solve = static_solver(K + shift**2 * M)
        return [real_modes(K.__matmul__, M.__matmul__, solve, structure.size, highest, shift)]


@explains_fields
@dataclass(frozen=True)
class CraigBampton(_ModesUpToFrequency):
    """Modes with the interface held, and interface modes, up to a frequency.

    Interface modes are those of the structure that follows its interface statically; so the size of the
    interface is not that of the basis.  Rigid motions are among them, and where the interface does not hold
    the structure, among the modes with the interface held.  Matrices are those of :class:`RealModes`.

    Sources: R. R. Craig, M. C. C. Bampton, "Coupling of substructures for dynamic analyses", AIAA J. 6 (1968)
    1313-1319; M. P. Castanier, Y.-C. Tan, C. Pierre, "Characteristic constraint modes for component mode
    synthesis", AIAA J. 39 (2001) 1182-1187.

    Parameters
    ----------
    interface : sequence of int, optional
        Freedoms, counted from 0.  Without it those on which contacts or the circulatory matrix act.

    Raises
    ------
    ValueError
        For what are no freedoms.

    Examples
    --------
    >>> import numpy as np
    >>> import frictionlab as fl
    >>> springs = 2 * np.eye(60) - np.eye(60, k=1) - np.eye(60, k=-1)
    >>> chain = fl.Structure(np.eye(60), springs, window=(0, 0.05))
    >>> small = fl.reduce(chain, tol=1e-4, basis=fl.CraigBampton(interface=[20]))
    >>> bool(np.allclose(fl.eigenvalues(small).values, fl.eigenvalues(chain).values, rtol=1e-4))
    True
    """

    interface: Any = None

    def __post_init__(self) -> None:
        if self.interface is None:
            return
        cure = "give freedoms, counted from 0, such as [0, 4]"
        given = check_sequence("interface", self.interface, cure)
        freedoms = [check_number("interface", one, integer=True, least=0, cure=cure) for one in given]
        if not freedoms or len({*freedoms}) < len(freedoms):
            raise ValueError(
                f"interface must be different freedoms, got {abbreviate(self.interface)}: {cure}"
            )
        object.__setattr__(self, "interface", tuple(sorted(freedoms)))

    def fixed(self, structure: Structure) -> Array:
        """None."""
        return np.zeros((structure.size, 0))

    def modes(self, structure: Structure, highest: float) -> Sequence[Modes]:
        """Interface modes, and modes with the interface held."""
        held, free = self._freedoms(structure)
        K, M = _without_friction(structure)
        inner, inertia, coupling = K[free][:, free], M[free][:, free], K[free][:, held]
        solve_all, rigid = _statics(K, M, SHIFT_SHARE * 2 * np.pi * structure.window[1])
        _, sizes, mixes = np.linalg.svd(rigid[held])
        moving = int((sizes > EXACT * np.linalg.norm(rigid)).sum())
        rigid_moving, rigid_held = np.split(rigid @ mixes.T, [moving], axis=1)  # by the interface
        solve_inner = _statically_held(inner, rigid_held[free])[0] if len(free) else np.copy

        def follow(u: Array) -> Array:
            """Displacements of all freedoms by those of the interface."""
            q = np.empty((structure.size, *u.shape[1:]))
            q[held], q[free] = u, -solve_inner(coupling @ u)
            return q

        def condensed(f: Array) -> Array:
            """Forces on all freedoms as those on the interface."""
            return f[held] - coupling.T @ solve_inner(f[free])

        def solve(f: Array) -> Array:
            forces = np.zeros((structure.size, *f.shape[1:]))
            forces[held] = f
            return solve_all(forces)[held]

        w, shapes = real_modes(
            lambda u: (K @ follow(u))[held],
            lambda u: condensed(M @ follow(u)),
            solve,
            len(held),
            highest,
            rigid=rigid_moving[held],
        )
        w_inner, inner_shapes = real_modes(
            inner.__matmul__, inertia.__matmul__, solve_inner, len(free), highest, rigid=rigid_held[free]
        )
        spread = np.zeros((structure.size, len(w_inner)))
        spread[free] = inner_shapes
        return [(w, follow(shapes)), (w_inner, spread)]

    def _freedoms(self, structure: Structure) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Those of the interface, and all others."""
        on_it = np.zeros(structure.size, dtype=bool)
        if self.interface is not None:
            if self.interface[-1] >= structure.size:
                raise ValueError(
                    f"interface must be freedoms from 0 to {structure.size - 1}, got {self.interface[-1]}: "
                    "count them from 0"
                )
            on_it[list(self.interface)] = True
        else:
            for one in structure.contacts:
                for rows in (one.normal, one.tangential):
                    on_it[[] if rows is None else rows.indices] = True
            for matrix in () if structure.circulatory is None else structure.circulatory.matrices:
                on_it[np.concatenate(matrix.nonzero())] = True
        if not on_it.any():
            raise ValueError(
                "a structure must have contacts or a circulatory matrix to have an interface, got none: give "
                "CraigBampton(interface=...), or take fl.RealModes()"
            )
        return np.flatnonzero(on_it), np.flatnonzero(~on_it)


def _statics(K: Matrix, M: Matrix, shift: float) -> tuple[Product, Array]:
    """What solves K q = f for loads f that do no work on rigid motions, and these motions (n, r)."""
    pencil, n = QuadraticPencil(M, 0.0 * M, K), K.shape[0]
    solve = factorised(K)
    if solve is not None:
        q = solve(np.random.default_rng(0).standard_normal((n, 1)))
        if not pencil.at_rest(np.zeros(1, complex), q)[0]:
            return solve, np.zeros((n, 0))
    solve = static_solver(K + shift**2 * M)
    _, shapes = real_modes(K.__matmul__, M.__matmul__, solve, n, RIGID_SHARE * shift, shift)
    return _statically_held(K, shapes[:, pencil.at_rest(np.zeros(shapes.shape[1], complex), shapes)])


def _statically_held(K: Matrix, rigid: Array) -> tuple[Product, Array]:
    """The same, where rigid motions (n, r) are known roughly: r freedoms are held, whose forces are zero."""
    parts: Any = linalg.qr(rigid.T, mode="r", pivoting=True)
    order = parts[1]
    others, held = np.sort(order[rigid.shape[1] :]), order[: rigid.shape[1]]
    solve_others = static_solver(K[others][:, others]) if len(others) else np.copy

    def solve(f: Array) -> Array:
        q = np.zeros_like(f)
        q[others] = solve_others(f[others])
        return q

    exact = -solve(K[:, held] @ rigid[held]) if len(held) else rigid
    exact[held] = rigid[held]
    return solve, exact


def _without_friction(structure: Structure) -> tuple[Matrix, Matrix]:
    """K with the springs of closed contacts, and M."""
    K = structure.K.at(structure.parameters).real
    for one, forces in zip(structure.contacts, structure.contact_forces, strict=True):
        K = K + one.without_friction().stiffness(forces)
    return K.tocsc(), structure.M.at(structure.parameters).tocsc()


@explains_keywords
def reduce(
    structure: Structure, over: Any = None, *, tol: float = 1e-6, basis: ReductionBasis | None = None
) -> ReducedStructure:
    """A structure of few freedoms that has the modes of a large one in its window of frequencies.

    Its displacements are those in the span of a basis, of as many as the tolerance asks for.  How far its
    eigenvalues err is measured at samples of the parameters, and bounded at any values by
    :meth:`ReducedStructure.error_bounds`, whatever the basis.

    Parameters
    ----------
    structure : Structure
        With a window.
    over : mapping of str to (float, float), optional
        Ranges of parameters, over which it has these modes.  Without it at the values at hand.
    tol : float
        Share by which eigenvalues may err, of modes that are damped by less than 5 % of critical damping, or
        of all vibrations where none is.
    basis : ReductionBasis, optional
        :class:`ComplexModes`, which is the default, :class:`RealModes` or :class:`CraigBampton`.

    Returns
    -------
    ReducedStructure

    Raises
    ------
    TypeError
        For an unknown parameter, or what is no structure or no basis.
    ValueError
        For a structure without a window or modes in it, ranges that are not two ascending numbers, a
        tolerance that is not between 1e-10 and 0.1, or a basis that the structure has not.

    Warns
    -----
    RuntimeWarning
        Where the tolerance is not reached with 17 samples for each range, or with 1,000 freedoms.

    Examples
    --------
    >>> import numpy as np
    >>> import frictionlab as fl
    >>> springs = 2 * np.eye(60) - np.eye(60, k=1) - np.eye(60, k=-1)
    >>> chain = fl.Structure(np.eye(60), springs, window=(0, 0.05))
    >>> small = fl.reduce(chain)
    >>> small
    ReducedStructure(60 freedoms to 6 freedoms, 0 to 0.05 Hz)
    >>> bool(np.allclose(fl.eigenvalues(small).values, fl.eigenvalues(chain).values))
    True
    """
    if not isinstance(structure, LargeSystem):
        raise TypeError(f"structure must be a fl.Structure, got {abbreviate(structure)}: give one")
    tol = check_number("tol", tol, least=LEAST_TOL, most=MOST_TOL)
    if structure.window is None:
        raise ValueError(
            "structure must have a window of frequencies to be reduced, got None: give it one, such as "
            "structure.replace(window=(0, 8000))"
        )
    cure = 'give ranges such as {"mu": (0, 1)}'
    check_mapping("over", {} if over is None else over, cure)
    box = {name: check_limits(f"over[{abbreviate(name)}]", ends, cure) for name, ends in (over or {}).items()}
    for name in box:
        check_parameter_name(structure, name)
    basis = ComplexModes() if basis is None else basis
    if not isinstance(basis, ReductionBasis):
        raise TypeError(
            f"basis must be one of displacements, got {abbreviate(basis)}: give fl.ComplexModes()"
        )
    small, error = basis.reduced(structure, box, tol)
    object.__setattr__(small, "error", error)  # of this structure, which nothing else knows yet
    if error > tol:
        warnings.warn(
            f"eigenvalues of the reduced structure may err by {error:.1e}, more than tol = {tol:.1e}: "
            f"{basis.cure}",
            RuntimeWarning,
            3,  # past `explains_keywords`
        )
    return small


def _with_samples_between(
    structure: Structure, samples: Sequence[Sample], between: Sequence[Point], tol: float
) -> Sequence[Sample]:
    """Samples, and those between them where by estimates an eigenvalue errs by more than the tolerance."""
    small = reduced(structure, samples)
    for point in between:
        if small.size < structure.size and _estimate_at(small, point) > ESTIMATE_SHARE * tol:
            samples = [*samples, Sample.of(structure, point).weakly_damped(structure)]
            small = reduced(structure, samples)
    return samples


def _has_equilibrium(structure: Structure, point: Point) -> bool:
    try:
        structure.at_values(point).find_equilibrium()
    except ValueError:
        return False
    return True


def _estimate_at(small: ReducedStructure, point: Point) -> float:
    """Largest share by which an eigenvalue errs at a point, as estimated there."""
    there = small.at_values(point)
    values = there.find_eigenvalues().values
    known = matters(small, values) & (values.imag >= 0.0)
    return float(np.max(there.error_estimates()[known] / np.abs(values[known]), initial=0.0))


def _smallest(
    structure: Structure, samples: Sequence[Sample], between: Sequence[Point], tol: float
) -> tuple[ReducedStructure, float]:
    """The reduced structure with the fewest freedoms whose eigenvalues err by less than `tol`, and by what.

    Those between the samples are compared with what all directions of the samples give.
    """
    vectors, sizes = proper_orthogonal(structure, samples)
    fixed = contact_responses(structure)
    known = [*samples]
    if between:
        full = structure.projected(extended(fixed, vectors[:, sizes > CLOSE * sizes[0]], EXACT))
        known += [Sample.of(full, point) for point in between]
        del full  # its basis is large
    for share in LEFT_OUT:
        small = structure.projected(extended(fixed, vectors[:, sizes > share * sizes[0]], EXACT))
        error = _largest_error(small, known, tol)
        if error <= tol:
            break
    return small, error


def _largest_error(small: ReducedStructure, samples: Sequence[Sample], tol: float) -> float:
    """Largest share by which eigenvalues of samples are missed, or the first that is above `tol`."""
    error = 0.0
    for one in samples:
        error = max(error, error_at(small, one))
        if error > tol:
            break
    return error
