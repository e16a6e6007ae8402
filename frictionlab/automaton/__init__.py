"""A hybrid automaton as plain data: modes with a flow, event functions that guard them, resets.

This package is the common language of the models, which write automata, and of the solver, which runs
them.  It knows nothing of friction and does no work: expressions are sympy expressions in the state and
parameter symbols, and :mod:`frictionlab.hybrid` turns them into numbers.
"""

from __future__ import annotations

from .hybrid_automaton import HybridAutomaton
from .mode import Event, Mode, Reset

__all__ = ["Event", "HybridAutomaton", "Mode", "Reset"]
