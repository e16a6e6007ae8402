"""A hybrid automaton as plain data: modes with a flow, event functions that guard them, resets.

It is what models produce and what the solver runs.  Nothing here knows of friction or computes motions:
expressions are sympy expressions in the symbols of states and parameters, which :mod:`frictionlab.tape`
turns into numbers.

``mode``
    `Mode`, `Event`, `Reset`: one smooth regime, what ends it, what jumps then.
``modes_on_demand``
    `ModesOnDemand`: modes that are derived when a run first tries to enter them; `Regime`: what is known of a
    mode before that.
``expressions``
    `Combinations`: many sums of a few expressions, as numbers times these, for finite elements.  Also
    products multiplied out, unless that gets too long.
``matrix_rows``
    Rows of products of a matrix with expressions, which are atoms to sympy.
``hybrid_automaton``
    `HybridAutomaton`: the modes over one state space, with the values of the parameters.
"""

from __future__ import annotations

from .hybrid_automaton import HybridAutomaton
from .mode import Event, Mode, Reset

__all__ = ["Event", "HybridAutomaton", "Mode", "Reset"]
