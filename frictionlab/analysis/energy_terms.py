"""Energies and powers of a slider on a belt at given states: the terms of its energy balance."""

from __future__ import annotations

from functools import lru_cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import sympy as sp

from frictionlab.automaton import HybridAutomaton
from frictionlab.hybrid.formulas import formula
from frictionlab.hybrid.outputs import evaluate
from frictionlab.models.assembly import derive
from frictionlab.models.energies import dissipation, kinetic_energy, potential_energy
from frictionlab.models.symbols import Structure, parameter_symbols, structure
from frictionlab.models.symbols import numbers as numbers_of

from .recurrence import Array

ENERGIES = ("kinetic", "springs", "contact", "preload")
WORKS = ("belt drive", "friction", "dampers", "impacts", "moving load")
ALL = ("x1", "y1", "x2", "y2", "phi")
# Exact for contact laws that are polynomials in sqrt(gap).
NODES, WEIGHTS = np.polynomial.legendre.leggauss(12)


def stored(model: Any, automaton: HybridAutomaton, states: Array, modes: Any) -> dict[str, Array]:
    """The energies (J), each (N,), at states (N, 2n) in modes (N,) by number."""
    q, v = _coordinates(model, states)
    preload = model.F * q.y1
    return {
        "kinetic": kinetic_energy(model, v),
        "springs": potential_energy(model, q) - preload,
        "contact": np.where(_pressed(automaton)[modes], _contact_energy(model, states), 0.0),
        "preload": preload,
    }


def powers(model: Any, automaton: HybridAutomaton, states: Array, modes: Any) -> dict[str, Array]:
    """The powers (W), each (N,), that change the sum of the energies, between events."""
    normal, friction, v_r = (
        evaluate(automaton, name, states, modes)
        for name in ("normal_force", "friction_force", "relative_velocity")
    )
    travel, material_rate = _rates(model, states)
    pressed = _pressed(automaton)[modes]
    return {
        "belt drive": friction * model.v,
        "friction": -friction * v_r,
        "dampers": -2.0 * dissipation(model, _coordinates(model, states)[1]),
        "impacts": np.where(pressed, 0.0, -normal * material_rate),
        "moving load": np.where(pressed, normal * travel, 0.0),
    }


def jumps(model: Any, before: Array, after: Array) -> Array:
    """Energy (J) gained at events: velocities jump there, coordinates do not."""
    first, last = (kinetic_energy(model, _coordinates(model, states)[1]) for states in (before, after))
    return last - first


def _coordinates(model: Any, states: Array) -> tuple[SimpleNamespace, SimpleNamespace]:
    """Coordinates and velocities by name; a model without the belt's rotation has phi = 0."""
    n, zero = len(model.coordinates), dict.fromkeys(ALL, 0.0)
    q, v = (dict(zip(model.coordinates, part.T, strict=True)) for part in (states[:, :n], states[:, n:]))
    return SimpleNamespace(**zero | q), SimpleNamespace(**zero | v)


def _pressed(automaton: HybridAutomaton) -> np.ndarray:
    """Modes in which the contact's spring is at work: not in flight, nor in the limit of many impacts."""
    return np.array([mode.name != "separation" and not mode.limit for mode in automaton.modes])


def _contact_energy(model: Any, states: Array) -> Array:
    """The integral of F_N from 0 to the gap."""
    gap = np.asarray(model.geometry.gap(*states[:, : len(model.coordinates)].T))
    force = _law(structure(model))
    shares = (1.0 + NODES) / 2.0  # of sqrt(gap), in which gap^1.5 is a polynomial too
    at = (force(gap * share**2, *numbers_of(model)) * share for share in shares)
    return gap * sum(w * f for w, f in zip(WEIGHTS, at, strict=True))


def _rates(model: Any, states: Array) -> list[Array]:
    """Full less material gap rate, and the material rate -W_N . q' (m/s)."""
    found = _rate_functions(structure(model))(*states.T, *numbers_of(model))
    return [np.broadcast_to(rate, len(states)) for rate in found]


@lru_cache(maxsize=64)
def _rate_functions(key: Structure) -> Any:
    s = derive(key)
    return sp.lambdify(
        [*s.q, *s.v, *parameter_symbols(key)], [sp.expand(s.gap_rate - s.material_rate), s.material_rate]
    )


@lru_cache(maxsize=64)
def _law(key: Structure) -> Any:
    """F_N as a function of the gap and the parameters: laws of one's own may be written for symbols."""
    gap = sp.Symbol("gap_of_contact", real=True)
    return formula([gap, *parameter_symbols(key)], derive(key).model.contact.force(gap))
