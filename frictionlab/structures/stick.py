"""A structure whose contacts with counterparts at rest stick: its freedoms are those that these leave.

A contact whose counterpart rests has no steady sliding: its friction is any within the static limit.  In
stick its tangential displacement t q is zero, as without load.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, sparse

if TYPE_CHECKING:
    from frictionlab.structures.sliding_contacts import SlidingContacts
    from frictionlab.structures.structure import ReducedStructure, Structure

Array = NDArray[np.float64]
DEPENDENT = 1e-10  # share of the longest row below which a row depends on others
MOST_TRIALS = 30  # of which contacts are closed
TOGETHER = 10  # of these, in which all contacts that are not right change at once
MAY_EXCEED = 1e-9  # share of a static limit


def structure_in_stick(structure: Structure) -> ReducedStructure:
    """The structure whose closed contacts with counterparts at rest stick."""
    contacts = [one.with_values(structure.parameters) for one in structure.contacts]
    groups = [i for i, one in enumerate(contacts) if one.friction is not None and one.v == 0.0]
    for one in (contacts[i].friction for i in groups):
        if one is not None and one.states:
            raise ValueError(
                f"contacts with counterparts at rest must have friction laws without states to stick, got "
                f"{one!r}, whose force depends on how they came to rest: take a law such as Coulomb, or give "
                "the counterpart a speed"
            )
    smooth = {i: contacts[i].without_friction() for i in groups if contacts[i].normal is not None}
    kept = [smooth.get(i, one) for i, one in enumerate(contacts) if i in smooth or i not in groups]
    loose = structure.replace(contacts=kept)
    closed = {i: np.ones(contacts[i].count, dtype=bool) for i in groups}
    normal = {i: contacts[i].area * contacts[i].N for i in groups if i not in smooth}
    for trial in range(MOST_TRIALS):
        rows = [contacts[i].tangential[closed[i]] for i in groups]
        rows = sparse.vstack([sparse.csr_array((0, structure.size)), *rows], format="csr")
        held = loose.projected(_basis(rows))
        q = held.basis @ held.displacements
        normal |= {i: one.forces(q, structure.parameters).normal for i, one in smooth.items()}
        wrong = [(i, j) for i in groups for j in np.flatnonzero((normal[i] > 0.0) != closed[i])]
        if not wrong:
            break
        for i, j in wrong[: 1 if trial >= TOGETHER else None]:
            closed[i][j] = not closed[i][j]
    else:
        raise ValueError(
            "contacts must be closed or open to stick, got some that open where they stick and close where "
            "they do not: change the load"
        )
    needed = _forces_along(rows, loose.statics.residual(q, 1.0))
    limits = [_static_limits(contacts[i], normal[i])[closed[i]] for i in groups]
    _check_limits(needed, np.concatenate([np.zeros(0), *limits]))
    object.__setattr__(held, "full", structure)
    return held


def _basis(rows: Any) -> Any:
    """A basis (n, r) of the displacements q with rows q = 0: some freedoms follow from the others."""
    if not rows.shape[0]:
        return sparse.eye_array(rows.shape[1], format="csc")
    columns = np.unique(rows.indices)
    parts: Any = linalg.qr(rows[:, columns].toarray(), mode="r", pivoting=True)
    triangle, order = parts[0], columns[parts[1]]
    sizes = np.abs(np.diagonal(triangle))
    rank = int((sizes > DEPENDENT * sizes.max(initial=0.0)).sum())
    shares = -linalg.solve_triangular(triangle[:rank, :rank], triangle[:rank, rank:])
    free = np.setdiff1d(np.arange(rows.shape[1]), order[:rank])
    if not len(free):
        raise ValueError(
            f"contacts in stick must leave a freedom, got {rows.shape[1]} that hold all: give one a speed"
        )
    i, j = np.nonzero(shares)
    places = (
        np.concatenate([free, order[i]]),
        np.concatenate([np.arange(len(free)), np.searchsorted(free, order[rank:][j])]),
    )
    entries = np.concatenate([np.ones(len(free)), shares[i, j]])
    return sparse.csc_array((entries, places), shape=(rows.shape[1], len(free)))


def _forces_along(rows: Any, forces: Array) -> Array:
    """Forces (k,) along rows (k, n) that add up to forces (n,); the least of those that do."""
    columns = np.unique(rows.indices)
    return np.linalg.lstsq(rows[:, columns].toarray().T, forces[columns])[0]


def _static_limits(one: SlidingContacts, normal: Array) -> Array:
    """The largest friction forces (k,) of contacts in stick, N."""
    assert one.friction is not None
    return one.area * one.friction.static_limit(normal / one.area)


def _check_limits(needed: Array, limits: Array) -> None:
    beyond = np.flatnonzero(np.abs(needed) > (1.0 + MAY_EXCEED) * limits)
    if len(beyond):
        at = beyond[0]
        raise ValueError(
            f"contacts with counterparts at rest must hold by less than their static limits to stick, got "
            f"{abs(needed[at]):.4g} of one that holds {limits[at]:.4g} at most ({len(beyond)} in all): raise "
            "mu_s or what presses, or give the counterpart a speed"
        )
