"""The limit of chatter: how short two flights in a row must be for the limit mode to take their place.

A method states it as a share of the time in which the limit mode's own motion changes, so that it has no
unit and depends on no run.  With J the Jacobian of the limit mode's rates where all states are zero, the
reciprocal of this time is

    sum of |J_ii|  +  sqrt(sum of |J_ij J_ji| over i < j)  +  |rate of the phase|,

the dampings, the square root of the squared frequencies, and the frequency of a load.  None of the terms
depends on the units of the states.  It is not less than the magnitude of the fastest eigenvalue of an
undamped motion.  A motion without such a time, as that of a body in free fall, has no limit: every flight is
computed.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

from frictionlab.automaton import HybridAutomaton, Mode
from frictionlab.automaton.modes_on_demand import ModesOnDemand
from frictionlab.lazy_names import sympy as sp
from frictionlab.presentation import PHASE
from frictionlab.tape.formulas import Formulas, formulas_of, kept_formulas

CHATTER = "chatter"  # the parameter of an automaton that the solver sets to the limit, s


@lru_cache(maxsize=64)  # an automaton never changes
def with_chatter_limit(automaton: HybridAutomaton, limit: float) -> HybridAutomaton:
    """The automaton with the parameter `chatter` of its limit modes, if it has them, set to a `limit` (s)."""
    if CHATTER not in automaton.values or not _has_limit_mode(automaton):
        return automaton
    return automaton.replace(chatter=limit)


@lru_cache(maxsize=64)
def chatter_limit(automaton: HybridAutomaton, share: float) -> float:
    """The limit (s) that is a `share` of the time of the limit mode's motion; 0.0 where there is none."""
    if not _has_limit_mode(automaton):
        return 0.0
    rate = float(formulas_of_rate(automaton).numbers(*automaton.values.values())[0])
    return share / rate if 0.0 < rate < math.inf else 0.0


def _has_limit_mode(automaton: HybridAutomaton) -> bool:
    if automaton.derivations is not None or automaton.on_demand:  # nothing is derived for the question
        return CHATTER in automaton.values
    return any(mode.limit for mode in automaton.modes)


def formulas_of_rate(automaton: HybridAutomaton) -> Formulas:
    """The rate (1/s) at which the motion of the limit modes changes, of the automaton's parameters."""

    def derive() -> Formulas:
        modes = automaton.modes
        modes = modes.known().modes if isinstance(modes, ModesOnDemand) else modes  # limit modes are derived
        rates = [rate_of_change(mode, automaton.states) for mode in modes if mode.limit]
        return formulas_of([*automaton.parameters], [sp.Add(*rates)])

    return kept_formulas(automaton.derivations, "rate of the limit mode", derive)


def rate_of_change(mode: Mode, states: tuple[Any, ...]) -> Any:
    """The expression above for one mode; without a value where its rates have no derivatives at zero."""
    reals = [sp.Dummy(state.name, real=True) for state in states]  # where |x| has a derivative
    index, at_zero = {x: i for i, x in enumerate(reals)}, dict.fromkeys(reals, 0)
    real = dict(zip(states, reals, strict=True))
    flow = [sp.sympify(rate, strict=True).xreplace(real) for rate in mode.flow]
    jacobian = {
        (i, index[x]): _slope_at_zero(rate, x, at_zero)
        for i, rate in enumerate(flow)
        for x in rate.free_symbols & index.keys()
    }
    diagonal = [abs(entry) for (i, j), entry in jacobian.items() if i == j]
    pairs = [
        abs(entry * jacobian[j, i]) for (i, j), entry in jacobian.items() if i < j and (j, i) in jacobian
    ]
    phases = [abs(flow[i].subs(at_zero)) for i, state in enumerate(states) if state.name == PHASE]
    return sp.Add(*diagonal, *phases) + sp.sqrt(sp.Add(*pairs))


def _slope_at_zero(rate: Any, x: Any, at_zero: dict[Any, int]) -> Any:
    """The derivative by `x` where all states are zero: that of what is left once the others are."""
    alone = rate.xreplace({other: zero for other, zero in at_zero.items() if other is not x})
    return alone.diff(x).subs(x, 0)
