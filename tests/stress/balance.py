"""The energy balance of a slider on a belt, by quadratures along a run and the jumps at its impacts."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import sympy as sp

import frictionlab as fl
from frictionlab.models.energies import dissipation, kinetic_energy, potential_energy


def with_power(model):
    """The model's automaton with the outputs power and lost, and the energy as a function of states.

    The contact's spring is left out of the energy: its force does work like friction's. Lost is what
    dampers take.
    """
    automaton = model.automaton()
    n, states = automaton.coordinates, automaton.states
    zero = {"phi": sp.S.Zero}
    q = SimpleNamespace(**zero | {x.name: x for x in states[:n]})
    v = SimpleNamespace(**zero | {x.name: rate for x, rate in zip(states[:n], states[n:])})
    # without the belt's rotation J, l1 and l2 are no parameters and belong to phi = 0 only
    p = SimpleNamespace(**dict.fromkeys(("J", "l1", "l2"), 0) | {s.name: s for s in automaton.parameters})
    lost, closing = 2 * dissipation(p, v), v.y2 - v.y1 - (q.x1 - q.x2) * v.phi

    def supplied(mode):
        out = mode.outputs
        power = out["friction_force"] * (v.x1 - v.x2) - out["normal_force"] * closing - lost
        return replace(mode, outputs={**out, "power": power, "lost": lost})

    energy = (kinetic_energy(p, v) + potential_energy(p, q)).subs(dict(automaton.parameters))
    of_states = sp.lambdify(states, energy)
    automaton = replace(automaton, modes=tuple(supplied(mode) for mode in automaton.modes))
    return automaton, lambda states: of_states(*np.asarray(states).T)


def residual(model, t_end, x0, mode=None):
    """What the energy balance misses over a run from a state on (J), and the energy that is turned over."""
    automaton, energy = with_power(model)
    riders = {name: name for name in ("power", "lost")}
    run = fl.solve(automaton, t_end, x0=x0, mode=mode, quadratures=riders, progress=False)
    assert run.status is fl.Status.FINISHED
    jumps = energy(run.events.state) - energy(run.events.before)
    begin, end = float(energy(x0)), float(energy(run.final_state))
    turned_over = abs(begin) + abs(end) + run.quadratures["lost"] + math.fsum(abs(jumps))
    return math.fsum([end, -begin, -run.quadratures["power"], *-jumps]), turned_over
