"""Where a run ends because a rigid contact that rubs has no reaction, Painleve's paradox, or cannot begin
because it is behind one."""

from __future__ import annotations

import numpy as np

from frictionlab.automaton import HybridAutomaton
from frictionlab.hybrid.guard_bounds import Tape
from frictionlab.hybrid.outputs import evaluate_outputs
from frictionlab.hybrid.problem import Problem
from frictionlab.presentation import DISTANCE, REACTION, WEDGE

ZERO_SHARE = 1e-9  # share of a function's size that counts as zero


def jammed_contact(automaton: HybridAutomaton, problem: Problem, state: np.ndarray) -> str:
    """Words for a contact that a state keeps closed in some mode without a reaction; empty where none is."""
    for number, name in enumerate(problem.program.modes):
        mode = automaton.mode(name)
        events, of_rigid = mode.events, {f"{WEDGE}{one.removeprefix(REACTION)}" for one in mode.outputs}
        places = [i for i, event in enumerate(events) if event.name in of_rigid]
        if not places:
            continue
        tape = Tape(problem.program.code, problem.numbers, number)
        states = state[None, : problem.program.code.inputs]  # integrals may follow
        with np.errstate(all="ignore"):
            shares = tape.values(states)[0] / np.maximum(tape.sizes(states), np.finfo(float).tiny)
        others = np.delete(shares[: len(events)], places)
        closed = (np.abs(shares[len(events) :]) <= ZERO_SHARE).all() and (others >= -ZERO_SHARE).all()
        for i in places if closed else ():
            if shares[i] <= ZERO_SHARE:
                sign = "negative" if shares[i] < -ZERO_SHARE else "zero"
                return (
                    f"Painleve's paradox in mode {name!r}: {events[i].name!r}, by which a normal force "
                    f"moves its contact apart with its friction, is {sign}, so that no reaction keeps it "
                    "closed: lower its friction, or give it a stiffness, Contact in place of Stop"
                )
    return ""


def contact_behind(automaton: HybridAutomaton, state: np.ndarray) -> str:
    """Words for the rigid contact whose bodies overlap most at a start; empty where none do."""
    states, mode = state[None, : len(automaton.states)], next(iter(automaton.names))
    outputs = automaton.outputs
    names = [n for n in outputs if n.startswith(DISTANCE) and n.replace(DISTANCE, REACTION) in outputs]
    values = evaluate_outputs(automaton, names, states, np.zeros(1, dtype=int), [mode])
    distances = {name: float(value[0]) for name, value in values.items()}
    name = min(distances, key=distances.__getitem__, default="")
    if not distances.get(name, 0.0) < 0.0:
        return ""
    return f"x0 behind a stop: {name!r} is {distances[name]:.3g}: start where it is zero or positive"
