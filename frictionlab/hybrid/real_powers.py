"""Powers of a base that has become negative: there a law has no real value, and a run ends.

A root has a real value only for a base that is not negative.  So has any power whose exponent is 1.5, a
parameter, or anything else that is no integer in the structure of the equations.  The solver counts a base
that rounding has made negative as zero.  A base that is more negative than that, beside its terms along the
run, is seen here, at the steps of a run.
"""

from __future__ import annotations

import numpy as np

from frictionlab.automaton import HybridAutomaton
from frictionlab.automaton.expressions import integer_exponent, real_power_cure
from frictionlab.hybrid.guard_bounds import Tape
from frictionlab.hybrid.kernels.step_length import BASE_ROUNDING_SHARE
from frictionlab.hybrid.problem import Problem, RunData, Status
from frictionlab.lazy_names import sympy


def cut_where_undefined(problem: Problem, raw: RunData) -> RunData:
    """The run up to the first step at which a base is negative, with the status "not finite".

    If there is no such step, it is the run itself.
    """
    code = problem.program.code
    if not problem.program.has_powers:
        return raw
    modes = np.append(raw.step_modes, raw.mode)
    visited = np.unique(modes[modes >= 0])
    firsts = [_first_negative(problem, mode, raw, modes) for mode in visited[code.powers[visited] != 0]]
    first = min((at for at in firsts if at is not None), default=None)
    if first is None:
        return raw
    if first == len(raw.step_modes):  # after the last step
        return raw._replace(status=Status.NOT_FINITE)
    t = float(raw.step_times[first, 0])
    before = {"step_": np.arange(len(raw.step_modes)) < first}
    before |= {part: getattr(raw, part + "times") <= (t if first else -1.0) for part in ("event_", "point_")}
    arrays = {
        name: getattr(raw, name)[before[part]] for name in raw._fields for part in before if part in name
    }
    mode, state = int(modes[first]), raw.step_states[first].copy()
    return raw._replace(**arrays, t=t, state=state, mode=mode, status=Status.NOT_FINITE)


def undefined_start(automaton: HybridAutomaton, problem: Problem, mode: int) -> str:
    """A message on a base that is negative at the start in a mode; empty if none is."""
    words = negative_base(automaton, problem, problem.x0[: problem.program.code.inputs], mode)
    return f"must be where the laws have real values, got {words}" if words else ""


def negative_base(automaton: HybridAutomaton, problem: Problem, state: np.ndarray, mode: int) -> str:
    """A message that names the first base that is negative at a state; empty if none is."""
    of = automaton.mode(problem.program.modes[mode])
    values = dict(zip(automaton.states, state.tolist())) | dict(automaton.parameters)
    for expression in (*of.flow, *(event.function for event in of.events), *of.constraints):
        for power in sympy.sympify(expression, strict=True).atoms(sympy.Pow):
            if integer_exponent(power) is None and not power.base.free_symbols.isdisjoint(automaton.states):
                base = complex(power.base.subs(values)).real
                if base < 0.0:
                    exponent = f"{float(power.exp):g}" if power.exp.is_Number else power.exp
                    return (
                        f"{power.base} = {base:.6g} to the power {exponent} in mode {of.name!r}: "
                        f"{real_power_cure(power.base, exponent)}, or let an event end the mode where the "
                        "base is zero"
                    )
    return ""


def _first_negative(problem: Problem, mode: int, raw: RunData, modes: np.ndarray) -> int | None:
    """The first step in a mode at whose start a base is negative; after the last step the end counts."""
    code = problem.program.code
    tape, inside = Tape(code, problem.numbers, mode), np.flatnonzero(modes == mode)
    states = raw.step_states[inside[inside < len(raw.step_modes)], : code.inputs]  # integrals may follow
    if raw.mode == mode:
        states = np.vstack([states, raw.state[: code.inputs]])
    with np.errstate(all="ignore"):
        values = tape.values(states, tape.bases)
    least = -BASE_ROUNDING_SHARE * tape.sizes(states, tape.bases)
    negative = np.flatnonzero((values < least).any(axis=1))
    return int(inside[negative[0]]) if len(negative) else None
