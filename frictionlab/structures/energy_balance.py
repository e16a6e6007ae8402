"""The energy balance of a structure that moves: energies of its matrices and contacts, and their powers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from frictionlab.automaton import HybridAutomaton
from frictionlab.hybrid.outputs import evaluate_outputs
from frictionlab.models.mechanical.stored_energies import Bristles

if TYPE_CHECKING:
    from frictionlab.hybrid.trajectory import Trajectory
    from frictionlab.structures.structure import Structure

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class StructureBalance:
    """Energies and powers of a structure along a run.

    Parameters
    ----------
    structure : Structure
    automaton : HybridAutomaton
    mode_names : sequence of str
    """

    structure: Structure
    automaton: HybridAutomaton
    mode_names: Sequence[str]

    def energies(self, states: Array, modes: Any) -> dict[str, Array]:
        """The energies (J), each (N,); that of a contact is the integral of F_N over the penetration."""
        q, v = self._split(states)
        energies = {
            "kinetic": _form(self.structure.M, v, v, self.structure) / 2,
            "springs": _form(self.structure.K, q, q, self.structure) / 2,
        }
        if self.structure.load is not None:
            energies["preload"] = -q @ self.structure.load_vector
        pressed = [one for one in self.structure.contacts if one.normal is not None]
        if pressed:
            stored = (one.stored_energy(q, self.structure.parameters) for one in pressed)
            energies["contact"] = np.sum([*stored], axis=0)
        if self._bristles.energies:
            energies["bristles"] = self._bristles.energy(states, modes)
        return energies

    def powers(self, states: Array, modes: Any) -> dict[str, Array]:
        """The powers (W), each (N,), that change the sum of the energies between events."""
        q, v = self._split(states)
        _, damping, _ = self.structure.terms
        powers = {"dampers": -sum((_form(one, v, v, self.structure) for one in damping), np.zeros(len(v)))}
        if self.structure.circulatory is not None:
            powers["circulatory"] = -_form(self.structure.circulatory, v, q, self.structure)
        for i, row, belt in self._rubbing():
            name = "friction_force" + (f"_{i + 1}" if self._count > 1 else "")
            force = evaluate_outputs(self.automaton, [name], states, modes, self.mode_names)[name]
            powers["belt drive"] = powers.get("belt drive", 0.0) + force * belt
            powers["friction"] = powers.get("friction", 0.0) - force * (belt - v @ row)
        if self._bristles.energies:
            powers["friction"] = powers["friction"] + self._bristles.power(states, modes)
        return powers

    def jumps(self, run: Trajectory) -> dict[str, Array]:
        """Energy (J) that impacts add at each event."""
        n, M = self.structure.size, self.structure.M
        after, before = (
            _form(M, states[:, n : 2 * n], states[:, n : 2 * n], self.structure) / 2
            for states in (run.events.state, run.events.before)
        )
        jumps = {"impacts": after - before}
        if self._bristles.energies:
            jumps["friction"] = self._bristles.gains(run.events)
        return jumps

    def _split(self, states: Array) -> tuple[Array, Array]:
        """Displacements and velocities."""
        n = self.structure.size
        return states[:, :n], states[:, n : 2 * n]

    @cached_property
    def _bristles(self) -> Bristles:
        from frictionlab.structures.motion import bristles_of_structure

        energies = bristles_of_structure(self.structure) if any(self.structure.law_states) else {}
        return Bristles(energies, self.automaton, self.mode_names)

    @property
    def _count(self) -> int:
        return sum(one.count for one in self.structure.contacts)

    def _rubbing(self) -> Iterator[tuple[int, Array, float]]:
        """The contacts with friction: their numbers, rows, and speeds of their counterparts."""
        first = 0
        for group in self.structure.contacts:
            if group.friction is not None:
                rows = group.tangential.toarray()
                belt = self.structure.parameters[group.parameter("v")]
                yield from ((first + i, row, belt) for i, row in enumerate(rows))
            first += group.count


def _form(matrix: Any, one: Array, other: Array, structure: Structure) -> Array:
    """x^T A y (N,) of rows x and y."""
    return (one * (matrix.at(structure.parameters) @ other.T).T).sum(axis=1)
