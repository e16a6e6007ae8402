"""The terms of the energy balance at given states: energies, powers, and jumps at impacts."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import sympy as sp

from frictionlab.analysis.motion_scales import Array
from frictionlab.automaton import HybridAutomaton
from frictionlab.hybrid.outputs import array_function, evaluate_output
from frictionlab.models.mechanical.chatter import CHATTER_MODE
from frictionlab.models.mechanical.equations_of_motion import JOINT, LagrangeSystem, system_of
from frictionlab.models.mechanical.mechanics import Friction
from frictionlab.models.mechanical.modes import contact_suffix
from frictionlab.models.symbols import Structure, parameter_symbols, structure_of_component, structure_values

# Exact for contact laws that are polynomials in sqrt(penetration).
CONTACT_NODES, CONTACT_WEIGHTS = np.polynomial.legendre.leggauss(12)
GAP = sp.Symbol("gap_of_contact", real=True)
WORKS = ("belt drive", "friction", "dampers", "impacts", "loads", "moving springs", "contact", "moving load")


@dataclass(frozen=True, eq=False)
class ContactTerms:
    """The terms of a contact in the energy balance.

    Parameters
    ----------
    number : str
        Suffix that tells its outputs from those of other contacts.
    place : int
        Which of the regimes in a mode's name is that of this contact.
    speed : callable or None
        Speed of the belt (m/s) as a function of states and parameters; None for a stop.
    approach : callable or None
        Material penetration rate -W_N . q' (m/s); None where the contact cannot be lost.
    travel : callable or None
        Full penetration rate less that (m/s), at which the contact does work of its own; None where it is
        zero by construction.
    penetration, law : callable or None
        The penetration (m) as a function of states and parameters, and F_N (N) as one of penetration and
        parameters.
    """

    number: str
    place: int
    speed: Callable[..., Any] | None = None
    approach: Callable[..., Any] | None = None
    travel: Callable[..., Any] | None = None
    penetration: Callable[..., Any] | None = None
    law: Callable[..., Any] | None = None


@dataclass(frozen=True, eq=False)
class Terms:
    """Energies (J) and powers (W) as functions of states and parameters, by their names."""

    kinetic: Callable[..., Any]
    potential: Mapping[str, Callable[..., Any]]
    powers: Mapping[str, Callable[..., Any]]
    contacts: tuple[ContactTerms, ...]


class Balance:
    """The terms of a model's energy balance at states (N, states) in modes (N,) by number."""

    def __init__(self, model: Any, automaton: HybridAutomaton) -> None:
        self.automaton, self._values = automaton, structure_values(model)
        self._terms = terms_of(structure_of_component(model))

    def energies(self, states: Array, modes: Any) -> dict[str, Array]:
        """The energies (J), each (N,)."""
        found = {"kinetic": self._at(self._terms.kinetic, states)}
        found |= {name: self._at(energy, states) for name, energy in self._terms.potential.items()}
        springs = [c for c in self._terms.contacts if c.law is not None]
        if springs:
            found["contact"] = np.sum(
                [self._contact_energy(contact, states, modes) for contact in springs], axis=0
            )
        return found

    def powers(self, states: Array, modes: Any) -> dict[str, Array]:
        """The powers (W), each (N,), that change the sum of the energies, between events."""
        found = {name: self._at(power, states) for name, power in self._terms.powers.items()}
        for contact in self._terms.contacts:
            for name, power in self._contact_powers(contact, states, modes):
                found[name] = found.get(name, 0.0) + power
        return {name: found[name] for name in WORKS if name in found}

    def jumps(self, before: Array, after: Array) -> Array:
        """Energy (J) gained at events: velocities jump there, coordinates do not."""
        return self._at(self._terms.kinetic, after) - self._at(self._terms.kinetic, before)

    def _at(self, function: Any, states: Array) -> Array:
        return np.broadcast_to(np.asarray(function(*states.T, *self._values), dtype=float), len(states))

    def _output(self, name: str, contact: ContactTerms, states: Array, modes: Any) -> Array:
        return evaluate_output(self.automaton, name + contact.number, states, modes)

    def _contact_powers(self, contact: ContactTerms, states: Array, modes: Any) -> Any:
        """Names and powers (W) of a contact with friction."""
        if contact.speed is None:
            return
        friction = self._output("friction_force", contact, states, modes)
        yield "belt drive", friction * self._at(contact.speed, states)
        yield "friction", -friction * self._output("relative_velocity", contact, states, modes)
        if contact.approach is None:
            return
        normal, pressed = (
            self._output("normal_force", contact, states, modes),
            self._modes_in_contact(contact)[modes],
        )
        approaching = self._at(contact.approach, states)
        yield "impacts", np.where(pressed, 0.0, -normal * approaching)
        # the energy that the contact stores is not known: all power of F_N counts as work
        if contact.law is None:
            yield "contact", np.where(pressed, -normal * approaching, 0.0)
        elif contact.travel is not None:
            yield "moving load", np.where(pressed, normal * self._at(contact.travel, states), 0.0)

    def _contact_energy(self, contact: ContactTerms, states: Array, modes: Any) -> Array:
        """Energy stored by the contact (J): the integral of F_N from 0 to the penetration; none in flight."""
        law: Any = contact.law
        penetration = self._at(contact.penetration, states)
        # in sqrt(penetration), in which penetration^1.5 is a polynomial too
        shares = (1.0 + CONTACT_NODES) / 2.0
        at = (law(penetration * share**2, *self._values) * share for share in shares)
        energy = penetration * sum(w * f for w, f in zip(CONTACT_WEIGHTS, at, strict=True))
        return np.where(self._modes_in_contact(contact)[modes], energy, 0.0)

    def _modes_in_contact(self, contact: ContactTerms) -> np.ndarray:
        """Modes in which the contact's spring acts: not in flight, nor in the limit mode of many impacts."""
        apart = "separation", CHATTER_MODE
        return np.array([name.split(JOINT)[contact.place] not in apart for name in self.automaton.names])


@lru_cache(maxsize=64)
def terms_of(key: Structure) -> Terms:
    """The terms of the energy balance of a structure."""
    found = system_of(key)
    mechanics = found.mechanics
    arguments = [*found.states, *parameter_symbols(key)]

    def compiled(expression: Any) -> Callable[..., Any]:
        return array_function(arguments, sp.sympify(expression))

    given = (
        mechanics.potential if isinstance(mechanics.potential, Mapping) else {"potential": mechanics.stored}
    )
    return Terms(
        kinetic=compiled(mechanics.kinetic),
        potential={name: compiled(energy) for name, energy in given.items() if energy != 0},
        powers={name: compiled(power) for name, power in _powers(found).items()},
        contacts=tuple(_contact(found, i, compiled, key) for i in range(len(mechanics.contacts))),
    )


def _powers(found: LagrangeSystem) -> dict[str, Any]:
    """The powers of dampers, of loads, and of energies that depend on time."""
    damping = [sp.diff(found.mechanics.dissipation, rate) for rate in found.v]
    powers = {"dampers": -_dot(damping, found.v), "impacts": sp.S.Zero}
    if any(load != 0 for load in found.loads):
        powers["loads"] = _dot(found.loads, found.v)
    for phase in found.phase:
        moved = sp.diff(found.mechanics.stored, phase) * found.mechanics.frequency
        powers |= {} if moved == 0 else {"moving springs": moved}
    return powers


def _contact(found: LagrangeSystem, i: int, compiled: Callable[..., Any], key: Structure) -> ContactTerms:
    contact, numbered = found.mechanics.contacts[i], contact_suffix(found, i)
    if not isinstance(contact, Friction):
        return ContactTerms(numbered, i)
    speed = compiled(found.at_rest(contact.relative_velocity))
    if contact.penetration is None:
        return ContactTerms(numbered, i, speed)
    approach = -_dot(found.normal(contact), found.v)
    travel = (
        None if contact.normal is None else compiled(sp.expand(found.rate(contact.penetration) - approach))
    )
    if not callable(contact.normal_force):
        return ContactTerms(numbered, i, speed, compiled(approach))
    law = array_function([GAP, *parameter_symbols(key)], contact.normal_force(GAP))
    return ContactTerms(numbered, i, speed, compiled(approach), travel, compiled(contact.penetration), law)


def _dot(one: Any, other: Any) -> Any:
    return sum((a * b for a, b in zip(one, other, strict=True)), sp.S.Zero)
