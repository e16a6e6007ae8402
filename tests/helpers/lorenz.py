"""The Lorenz system as an automaton, whose Hopf point and cycles are known."""

from __future__ import annotations

import sympy as sp

import frictionlab as fl

X, Y, Z = sp.symbols("x y z", real=True)
P, A, B, R = sp.symbols("p A B r", real=True)


def automaton(flow, states, coordinates=0, events=(), **parameters):
    values = {sp.Symbol(name, real=True): value for name, value in parameters.items()}
    return fl.HybridAutomaton(tuple(states), (fl.Mode("only", tuple(flow), events),), values, coordinates)


def lorenz():
    """The Lorenz system with the origin moved near the equilibrium that turns unstable."""
    x, y, z = X + 8, Y + 8, Z + 24
    return automaton((10 * (y - x), x * (R - z) - y, x * y - sp.Rational(8, 3) * z), (X, Y, Z), r=22.0)
