"""What ends a sequence of modes on a branch of closed orbits: a stay vanishes, an orbit grazes."""

from __future__ import annotations

import numpy as np
import sympy as sp

from frictionlab.automaton import HybridAutomaton
from frictionlab.hybrid.formulas import formula

from .arclength import Point
from .recurrence import Array

GRAZING, CHANGE, LOST = "grazing", "mode change", "no orbit found"
VANISHING = 1e-3  # share of the period below which a stay is about to vanish
TOUCHING = 1e-4  # share of its largest value to which an event function falls between events, where it grazes
SAMPLES = 4001


def edge_kind(automaton: HybridAutomaton, point: Point, other: Point | None) -> str:
    """What happens to the modes after an orbit, by those of the other side, if that is known."""
    if other is not None:
        few, many = sorted((point, other), key=lambda side: len(side.modes))
        more = len(many.modes) - len(few.modes)
        return GRAZING if more == 2 or (more == 1 and _returns(many) == _returns(few) + 1) else CHANGE
    run, period = point.shot.run, point.period
    if len(run.events):
        stays = np.diff(np.append(run.events.t, run.events.t[0] + period))
        i = int(np.argmin(stays))
        if stays[i] < VANISHING * period:
            return GRAZING if run.events.source[i] == np.roll(run.events.target, -1)[i] else CHANGE
    if _touches(automaton, point):
        return GRAZING
    return CHANGE if _at_limit(automaton, point) else LOST


def _returns(point: Point) -> int:
    """How many events lead back to the mode that they end, as impacts do."""
    events = point.shot.run.events
    return int((events.source == events.target).sum())


def _touches(automaton: HybridAutomaton, point: Point) -> bool:
    """Whether an event function all but vanishes at a minimum within a stay."""
    run = point.shot.run
    t = np.linspace(0.0, point.period, SAMPLES)
    states, modes = run(t), run._modes_of(t, run._step_of(t))
    arguments, numbers = [*automaton.states, *automaton.parameters], automaton.parameters.values()
    for i in np.unique(modes):
        for event in automaton.modes[i].events:
            found = formula(arguments, event.function)(*states.T, *numbers)
            if _dips(np.where(modes == i, found, np.nan)):
                return True
    return False


def _at_limit(automaton: HybridAutomaton, point: Point) -> bool:
    """Whether an event function of a mode is all but zero where that is entered, though not by construction.

    The friction force at an onset of stick that has come to the static limit: beyond it slip goes on.
    """
    events, numbers = point.shot.run.events, automaton.parameters.values()
    modes = {mode.name: mode for mode in automaton.modes}
    arguments = [*automaton.states, *automaton.parameters]
    for source, target, guard, state in zip(
        events.source, events.target, events.guard, events.state, strict=True
    ):
        left = modes[source]
        trigger = next(event for event in left.events if event.name == guard)
        zero = (trigger.function, *left.constraints, *trigger.reset.vanishing)
        for event in modes[target].events:
            if any(sp.expand(event.function - s * f) == 0 for f in zero for s in (1, -1)):
                continue
            value = formula(arguments, event.function)
            along = value(*point.shot.run.states.T, *numbers)
            if abs(value(*state, *numbers)) < TOUCHING * np.abs(along).max():
                return True
    return False


def _dips(values: Array) -> bool:
    """Whether values, NaN in other modes, have a minimum that is all but zero."""
    inner = values[1:-1]
    least = (inner <= values[:-2]) & (inner < values[2:])
    return bool((inner[least] < TOUCHING * np.nanmax(np.abs(values))).any())
