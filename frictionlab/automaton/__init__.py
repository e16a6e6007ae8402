"""A hybrid automaton as plain data: modes with a flow, event functions that guard them, resets.

The common language of the models, which write automata, and of the solver, which runs them.  It knows nothing
of friction and computes nothing: expressions are sympy expressions in the symbols of states and parameters,
which :mod:`frictionlab.hybrid` turns into numbers.

``mode``
    `Mode`, `Event`, `Reset`: one smooth regime, what ends it, what jumps then; `ModesOnDemand`: modes that
    are derived when a run first tries to enter them, and `Regime`, what is known of a mode before.
``expressions``
    `Combinations`: many sums of few expressions, as numbers times these; what finite elements need.
    Expressions multiplied out, so far as that is short; parts of them that have no value.
``straight_line``
    `StraightLine`: a function that sympy has compiled, as data that a file can hold.
``hybrid_automaton``
    `HybridAutomaton`: the modes over one state space, with the values of the parameters; derived at once, or
    when it is asked for.
"""

from __future__ import annotations

from .hybrid_automaton import HybridAutomaton
from .mode import Event, Mode, Reset

__all__ = ["Event", "HybridAutomaton", "Mode", "Reset"]
