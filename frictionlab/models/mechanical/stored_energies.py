"""The energies that contacts store along a run: in their springs, and in the states of friction laws."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from frictionlab.automaton import HybridAutomaton, Mode
from frictionlab.automaton.hybrid_automaton import module_of_pieces
from frictionlab.automaton.modes_on_demand import JOINT
from frictionlab.models.symbols import dot, gradient
from frictionlab.tape.formulas import function_along_run

from .mechanics import Friction

if TYPE_CHECKING:
    from .equations_of_motion import LagrangeSystem

Array = NDArray[np.float64]
# Of an integral over the root of the penetration: exact for its powers up to 15, of a law in pieces in each.
NODES, WEIGHTS = np.polynomial.legendre.leggauss(16)
PLACES = np.linspace(0.0, 1.0, 1001)  # shares of a depth, between which borders are looked for
Energies = Mapping[int, tuple[Any, Any]]  # J, pressed and apart, by the place of the contact


def energy_of_spring(force: Callable[[Array], Any], depth: Array, borders: Sequence[float] = ()) -> Array:
    """The integral of F_N from 0 to a depth, J; at the borders, ascending and above 0, the law changes."""
    first = np.minimum(depth, borders[0]) if borders else depth
    shares = (1.0 + NODES) / 2.0
    energy = first * sum(w * share * force(first * share**2) for w, share in zip(WEIGHTS, shares))
    for low, high in pairwise([*borders, np.inf] if borders else []):
        half = np.maximum(np.minimum(depth, high) - low, 0.0) / 2.0
        energy = energy + half * sum(w * force(low + half * (1.0 + x)) for x, w in zip(NODES, WEIGHTS))
    return energy


def borders_of_law(force: Any, penetration: Any) -> set[Any]:
    """Functions of the penetration at whose zeros a force in pieces changes its formula."""
    pieces = module_of_pieces()
    beyond = {x - border for x, border in (() if pieces is None else pieces.borders_in(force))}
    return {one for one in beyond if one.has(penetration)}


def borders_within(beyond: Iterable[Callable[[Array], Any]], depth: Array) -> list[float]:
    """The zeros of functions of the penetration between 0 and the greatest depth, ascending."""
    from scipy import optimize

    brentq: Any = optimize.brentq

    places, roots = depth.max(initial=0.0) * PLACES, list[float]()
    for function in beyond:
        signs = np.sign(function(places) * np.ones(len(places)))
        for k in np.flatnonzero(signs[:-1] * signs[1:] < 0.0):
            root = brentq(function, places[k], places[k + 1], xtol=1e-300, rtol=1e-15)
            roots.append(float(root))
        roots += places[1:-1][signs[1:-1] == 0.0].tolist()
    return sorted(roots)


def energies_of_bristles(system: LagrangeSystem) -> Energies:
    """The energies in the states of the contacts' friction laws, of those that store any."""
    from .dynamic_laws import energies_in_states

    contacts = [(i, one) for i, one in enumerate(system.mechanics.contacts) if isinstance(one, Friction)]
    energies = {i: energies_in_states(contact, system.of_laws[i]) for i, contact in contacts}
    return {i: each for i, each in energies.items() if each is not None}


@dataclass(frozen=True, eq=False)
class Bristles:
    """The energies in the states of friction laws of an automaton, at states (N, states) in modes (N,)."""

    energies: Energies
    automaton: HybridAutomaton
    mode_names: Sequence[str]

    def energy(self, states: Array, modes: Any) -> Array:
        """The energy in all of them (N,), J."""
        return self._evaluated(states, modes, lambda energy, _: energy)

    def power(self, states: Array, modes: Any) -> Array:
        """Its rate by the flow (N,), W."""
        return self._evaluated(states, modes, self._rate)

    def gains(self, events: Any) -> Array:
        """The energy gained at each event (E,), J; it is lost with the contact."""
        before = [self.mode_names.index(name) if name else 0 for name in events.source]
        after = [self.mode_names.index(name) if name else i for i, name in zip(before, events.target)]
        return self.energy(events.state, np.array(after)) - self.energy(events.before, np.array(before))

    def _evaluated(self, states: Array, modes: Any, of: Callable[[Any, Mode], Any]) -> Array:
        """What `of` makes of the energy and a mode, (N,)."""
        from .contact_regimes import APART, CHATTER_MODE

        values = np.zeros(len(states))
        arguments = [*self.automaton.states, *self.automaton.parameters]
        for i in np.unique(modes):
            name, in_mode = self.mode_names[int(i)], modes == i
            apart = [regime in (*APART, CHATTER_MODE) for regime in name.split(JOINT)]
            energy = sum(each[apart[place]] for place, each in self.energies.items())
            formula = function_along_run(arguments, of(energy, self.automaton.mode(name)))
            values[in_mode] = formula(*states[in_mode].T, *self.automaton.values.values())
        return values

    def _rate(self, energy: Any, mode: Mode) -> Any:
        return dot(gradient(energy, self.automaton.states), mode.flow)
