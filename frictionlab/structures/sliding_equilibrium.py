"""Static displacements of a structure under its load and its contacts.

Newton's method on K q = load + forces of the contacts: which contacts are open is part of the answer.  One
factorisation serves all steps of a large structure, as a preconditioner of GMRES: the changes of contact
stiffnesses are of low rank (Y. Saad, "Iterative Methods for Sparse Linear Systems", 2nd ed., SIAM 2003).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import linalg as sparse_linalg

from frictionlab.presentation import count, in_units_of
from frictionlab.stability.equilibrium_points.equilibria import Equilibrium
from frictionlab.stability.equilibrium_points.newton import solve_matrices
from frictionlab.stability.state_matrices import inverse_of
from frictionlab.structures.parametric_matrix import Matrix
from frictionlab.structures.quadratic_pencil import factorised
from frictionlab.structures.sliding_contacts import ContactForces, SlidingContacts
from frictionlab.structures.window_eigenvalues import MOST_DENSE

if TYPE_CHECKING:
    from frictionlab.structures.structure import Structure

Array = NDArray[np.float64]
Solve = Callable[[Array], Array]
NEWTON_STEPS = 60
SMALLEST_STEP = 2.0**-16  # of a step of Newton's method
DECREASE = 1e-4  # share of a step by which the residual has to fall
ROUNDING = 16.0 * float(np.finfo(float).eps)  # of all forces at a freedom: a smaller residual is none
LARGEST_RESIDUAL = 1e-9  # of the largest force: an equilibrium with a larger one is none
GMRES_STEPS, GMRES_RTOL = 40, 1e-4  # Newton's method corrects what a step leaves
GMRES_RESTARTS = 3  # scipy ends a cycle early where the preconditioned residual is small
LOAD_SHARES = (1 / 16, 1 / 8, 1 / 4, 1 / 2, 1.0)  # where the whole load at once finds no equilibrium


@dataclass(frozen=True, eq=False)
class SlidingEquilibrium(Equilibrium):
    """Static displacements of a structure with contacts that slide.

    Beside what it has of :class:`Equilibrium`, where forces are sums and the penetration is the largest:

    Parameters
    ----------
    penetrations : array (k,)
        Of all contacts, m; negative where they are open, NaN where their normal force is given.
    normal_forces, friction_forces : array (k,)
        N.
    """

    penetrations: Array
    normal_forces: Array
    friction_forces: Array

    @property
    def open(self) -> NDArray[np.bool_]:
        """Which contacts (k,) are open."""
        return self.normal_forces == 0.0

    def __repr__(self) -> str:
        contacts = f"{count(len(self.open), 'contact')}, {int(self.open.sum())} open"
        unit = in_units_of(self.model, "N")
        forces = f"F_N {self.normal_force:.4g} {unit}, F_T {self.friction_force:.4g} {unit}"
        return f"SlidingEquilibrium({count(len(self.q), 'freedom')}, {contacts}, {forces})"


def equilibrium_of(structure: Structure) -> Equilibrium:
    """The static displacements of a structure, with the forces of its contacts."""
    q, problem = structure.displacements, structure.statics
    forces = problem.contact_forces(q)
    state = np.concatenate([q, np.zeros(structure.size), structure.steady_states(forces)])
    largest = max([np.abs(problem.load).max(), *(np.abs(one.normal).max() for one in forces)])
    residual = float(np.abs(problem.residual(q, 1.0)).max() / (largest or 1.0))
    if not forces:
        return Equilibrium(state, np.nan, np.nan, np.nan, residual, structure, structure.coordinates)
    penetrations, normal, friction = (
        np.concatenate([getattr(one, name) for one in forces])
        for name in ("penetration", "normal", "friction")
    )
    known = penetrations[np.isfinite(penetrations)]
    totals = float(known.max()) if len(known) else np.nan, float(normal.sum()), float(friction.sum())
    parts = penetrations, normal, friction
    return SlidingEquilibrium(state, *totals, residual, structure, structure.coordinates, *parts)


@dataclass(frozen=True, eq=False)
class Statics:
    """The static equations at values of the parameters: K q = load + forces of contacts.

    Parameters
    ----------
    K : csc_array or array (n, n)
        Without contacts.  Where it is full, so are the rows of contacts.
    load : array (n,)
    contacts : tuple of SlidingContacts
    values : mapping of str to float
    """

    K: Any
    load: Array
    contacts: tuple[SlidingContacts, ...]
    values: Mapping[str, float]

    def solve(self, start: Array | None = None) -> Array:
        """Displacements (n,) of steady sliding, found from a start (n,), or from linear contacts.

        Raises
        ------
        ValueError
            Where the stiffness is singular, all contacts are open, or no equilibrium is found.
        """
        if not self.contacts:
            return self.linear()
        found = None if start is None else self.newton(start, 1.0)
        if found is None:
            first, solve = self.secant_start()
            found = self.newton(first, 1.0, solve)
            if found is None:
                found = self._by_load_steps(first)
        if not any((one.normal > 0.0).any() for one in self.contact_forces(found)):
            known = sum(one.count for one in self.contacts)
            raise ValueError(
                f"a contact must be closed, and all {known} are open: raise the load that presses, or the "
                "penetration of the contacts"
            )
        return found

    def _by_load_steps(self, q: Array) -> Array:
        for share in LOAD_SHARES:
            found = self.newton(q, share)
            if found is None:
                raise ValueError(
                    "there must be an equilibrium with sliding contacts, and none was found at "
                    f"{share:.3g} of the load: lower friction, or change load or stiffnesses"
                )
            q = found
        return q

    def contact_forces(self, q: Array) -> list[ContactForces]:
        """Of each group of contacts."""
        return [one.forces(q, self.values) for one in self.contacts]

    def residual(self, q: Array, share: float) -> Array:
        """What is left over of the forces (n,), N, under a share of the load."""
        return self._left_over(q, self.contact_forces(q), share)

    def linear(self) -> Array:
        """The displacements without contacts."""
        if not self.load.any():
            return np.zeros(len(self.load))
        solve = factorised(self.K)
        if solve is None:
            raise ValueError(
                "K and circulatory must hold all freedoms where there is a load, got a singular stiffness: "
                "add supports, or leave out the load"
            )
        return solve(self.load)

    def secant_start(self) -> tuple[Array, Solve]:
        """The displacements with linear contacts, all closed, that carry the load; what solves for them."""
        pressed = float(np.abs(self.load).sum())
        K, right = self.K, self.load
        for one in self.contacts:
            if one.normal is None:
                right = right + one.on_structure(one.forces(0.0 * self.load, self.values))
                continue
            secants = one.secant_stiffness(pressed, self.values)
            weighted = one.normal.T * secants[None, :]
            K = K + weighted @ one.normal
            right = right - weighted @ one.penetration
        solve = static_solver(K)
        return solve(right), solve

    def newton(self, q: Array, share: float, solve: Solve | None = None) -> Array | None:
        """The equilibrium from a start (n,); None where the method does not settle.

        `solve` solves nearly the equations of the first step, where it is given.
        """
        forces = self.contact_forces(q)
        left_over = self._left_over(q, forces, share)
        for _ in range(NEWTON_STEPS):
            size = np.linalg.norm(left_over)
            if self._is_rounding(left_over, q, forces):
                return q
            step, solve = self._step(self.tangent(forces), left_over, solve)
            scale = 1.0
            while scale >= SMALLEST_STEP:
                ahead = q - scale * step
                forces = self.contact_forces(ahead)
                new = self._left_over(ahead, forces, share)
                if np.linalg.norm(new) <= (1.0 - DECREASE * scale) * size:
                    break
                scale *= 0.5
            else:
                small = self._largest(self.contact_forces(q)) * LARGEST_RESIDUAL
                return q if np.abs(left_over).max() <= small else None
            q, left_over = ahead, new
        return None

    def _left_over(self, q: Array, forces: list[ContactForces], share: float) -> Array:
        acting = sum(one.on_structure(f) for one, f in zip(self.contacts, forces, strict=True))
        return self.K @ q - share * self.load - acting

    def _largest(self, forces: list[ContactForces]) -> float:
        return max(np.abs(self.load).max(), *(np.abs(one.normal).max() for one in forces))

    def _is_rounding(self, left_over: Array, q: Array, forces: list[ContactForces]) -> bool:
        held = abs(self.K) @ np.abs(q)
        bound = ROUNDING * (held + np.abs(self.load) + self._largest(forces))
        return bool((np.abs(left_over) <= bound).all())

    def tangent(self, forces: list[ContactForces]) -> Matrix:
        """K with what contacts add in steady sliding, (n, n)."""
        added = [one.steady_stiffness(f) for one, f in zip(self.contacts, forces, strict=True)]
        return self.K + sum(added)

    def _step(self, tangent: Matrix, left_over: Array, solve: Solve | None) -> tuple[Array, Solve]:
        """A step of Newton's method, and what solves nearly the next one."""
        if len(left_over) > MOST_DENSE and solve is not None:
            make: Any = sparse_linalg.LinearOperator  # its stub has one dtype too many
            operator = make(tangent.shape, solve, dtype=float)
            step, failed = sparse_linalg.gmres(
                tangent, left_over, M=operator, rtol=GMRES_RTOL, restart=GMRES_STEPS, maxiter=GMRES_RESTARTS
            )
            if not failed:
                return step, solve
        solve = static_solver(tangent)
        return solve(left_over), solve


def newton_of_many(
    K: Array, loads: Array, contacts: Sequence[SlidingContacts], values: Mapping[str, Array], start: Array
) -> tuple[Array, NDArray[np.bool_]]:
    """Equilibria (N, n) of structures with full K (N, n, n) from one start (n,), and which were found (N,).

    Newton's method with whole steps; one that does not lower the residual or opens all contacts ends it.
    """
    q, columns = np.tile(start, (len(K), 1)), {name: each[:, None] for name, each in values.items()}
    found, going = np.zeros((2, len(K)), dtype=bool)
    going[:], size = True, np.full(len(K), np.inf)
    with np.errstate(all="ignore"):
        for _ in range(NEWTON_STEPS):
            forces = [one.forces(q, columns) for one in contacts]
            left_over = (K @ q[..., None])[..., 0] - loads
            left_over -= sum(one.on_structure(f) for one, f in zip(contacts, forces, strict=True))
            pressed = np.max([f.normal.max(axis=1) for f in forces], axis=0)
            held = (np.abs(K) @ np.abs(q)[..., None])[..., 0] + np.abs(loads)
            bound = held + np.maximum(np.abs(loads).max(axis=1), pressed)[:, None]
            found |= going & (np.abs(left_over) <= ROUNDING * bound).all(axis=1) & (pressed > 0.0)
            new = np.linalg.norm(left_over, axis=1)
            going &= ~found & (new <= (1.0 - DECREASE) * size)
            if not going.any():
                break
            tangents = K + sum(one.steady_stiffness(f) for one, f in zip(contacts, forces, strict=True))
            steps = solve_matrices(tangents[going], left_over[going][..., None])
            q[going] -= steps[..., 0]
            size = new
    return q, found


def static_solver(stiffness: Matrix | Array) -> Solve:
    """What solves K q = f; ValueError where K, sparse or full, is singular."""
    full = isinstance(stiffness, np.ndarray)
    solve = _solver_of_full(stiffness) if full else factorised(stiffness.tocsc())
    if solve is None:
        raise ValueError(
            "K and the contacts must hold all freedoms, got a singular stiffness: add supports or contacts"
        )
    return solve


def _solver_of_full(matrix: Array) -> Solve | None:
    """What solves matrix x = b; None where a full matrix is singular to rounding."""
    inverse = inverse_of(matrix)

    def solve(b: Array) -> Any:
        return np.linalg.solve(matrix, b)

    return None if inverse is None else solve
