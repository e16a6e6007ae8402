"""Why the sequence of modes changes along a branch of periodic orbits: a stay in a mode vanishes, or an orbit
grazes a guard.
"""

from __future__ import annotations

import numpy as np
import sympy as sp

from frictionlab.analysis.motion_scales import Array
from frictionlab.automaton import HybridAutomaton
from frictionlab.hybrid.outputs import array_function

from .pseudo_arclength import BranchPoint

GRAZING, MODE_CHANGE, NO_ORBIT = "grazing", "mode change", "no orbit found"
VANISHING_STAY_SHARE = 1e-3  # share of the period below which a stay is about to vanish
GRAZING_RTOL = (
    1e-4  # an orbit grazes where an event function falls to this share of its largest value between events
)
SAMPLES_PER_PERIOD = 4001


def branch_end_kind(automaton: HybridAutomaton, point: BranchPoint, other: BranchPoint | None) -> str:
    """How the sequence of modes changes after an orbit, by the modes beyond the change where these are
    known."""
    if other is not None:
        few, many = sorted((point, other), key=lambda side: len(side.modes))
        more = len(many.modes) - len(few.modes)
        return (
            GRAZING
            if more == 2 or (more == 1 and _self_transitions(many) == _self_transitions(few) + 1)
            else MODE_CHANGE
        )
    run, period = point.shot.run, point.period
    if len(run.events):
        stays = np.diff(np.append(run.events.t, run.events.t[0] + period))
        i = int(np.argmin(stays))
        if stays[i] < VANISHING_STAY_SHARE * period:
            return GRAZING if run.events.source[i] == np.roll(run.events.target, -1)[i] else MODE_CHANGE
    if _grazes(automaton, point):
        return GRAZING
    return MODE_CHANGE if _at_guard_limit(automaton, point) else NO_ORBIT


def _self_transitions(point: BranchPoint) -> int:
    """How many events lead back to the mode that they end, as impacts do."""
    events = point.shot.run.events
    return int((events.source == events.target).sum())


def _grazes(automaton: HybridAutomaton, point: BranchPoint) -> bool:
    """Whether an event function has a minimum of nearly zero within a stay."""
    run = point.shot.run
    t = np.linspace(0.0, point.period, SAMPLES_PER_PERIOD)
    states, modes = run.states_and_modes(t)
    arguments, numbers = [*automaton.states, *automaton.parameters], automaton.parameters.values()
    for i in np.unique(modes):
        for event in automaton.modes[i].events:
            found = array_function(arguments, event.function)(*states.T, *numbers)
            if _has_zero_minimum(np.where(modes == i, found, np.nan)):
                return True
    return False


def _at_guard_limit(automaton: HybridAutomaton, point: BranchPoint) -> bool:
    """Whether an event function of a mode is nearly zero where the mode is entered, though not by
    construction.

    So is the margin of friction where it has reached its static limit at an onset of stick: beyond, slip goes
    on.
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
            value = array_function(arguments, event.function)
            along = value(*point.shot.run.states.T, *numbers)
            if abs(value(*state, *numbers)) < GRAZING_RTOL * np.abs(along).max():
                return True
    return False


def _has_zero_minimum(values: Array) -> bool:
    """Whether values, NaN in other modes, have a minimum of nearly zero."""
    inner = values[1:-1]
    least = (inner <= values[:-2]) & (inner < values[2:])
    return bool((inner[least] < GRAZING_RTOL * np.nanmax(np.abs(values))).any())
