"""Special points of a branch of periodic orbits: folds, period doublings, Neimark-Sacker points, by their
test functions; and why the sequence of modes changes along it: a stay in a mode vanishes, or an orbit grazes
a guard.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq

from frictionlab.analysis.continuation.pseudo_arclength import BranchPoint, continuation_step
from frictionlab.analysis.motion_scales import Array
from frictionlab.analysis.orbits.shooting import floquet_multipliers
from frictionlab.automaton import HybridAutomaton
from frictionlab.hybrid.outputs import array_function
from frictionlab.hybrid.tape.structural_zeros import sign_normal_form

LOCATION_XTOL = 1e-12  # share of the step to which a special point is located
UNIT_CIRCLE_ATOL = (
    1e-3  # how far from the unit circle the pair of a Neimark-Sacker point may be, with rounding
)

GRAZING, MODE_CHANGE, NO_ORBIT = "grazing", "mode change", "no orbit found"
VANISHING_STAY_SHARE = 1e-3  # share of the period below which a stay is about to vanish
GRAZING_RTOL = (
    1e-4  # an orbit grazes where an event function falls to this share of its largest value between events
)
SAMPLES_PER_PERIOD = 4001


def transverse_multipliers(point: BranchPoint) -> Array:
    """The multipliers but for that along the orbit."""
    values = floquet_multipliers(point.monodromy)
    return np.delete(values, np.argmin(np.abs(values - 1.0)))


def fold_test(point: BranchPoint) -> float:
    """How fast the parameter grows along the branch."""
    return float(point.tangent[-1])


def period_doubling_test(point: BranchPoint) -> float:
    """Zero where a multiplier is -1."""
    return float(np.prod(1.0 + transverse_multipliers(point)).real)


def neimark_sacker_test(point: BranchPoint) -> float:
    """Zero where the product of two multipliers is 1."""
    values = transverse_multipliers(point)
    products = np.outer(values, values)[np.triu_indices(len(values), 1)]
    return float(np.prod(1.0 - products).real)


TEST_FUNCTIONS: dict[str, Callable[[BranchPoint], float]] = {
    "fold": fold_test,
    "period doubling": period_doubling_test,
    "Neimark-Sacker": neimark_sacker_test,
}


class SpecialPoint(NamedTuple):
    """A special point, its kind, and the parameter there."""

    kind: str
    point: BranchPoint
    value: float


def special_points_between(
    automaton: HybridAutomaton, point: BranchPoint, after: BranchPoint, step: float
) -> list[SpecialPoint]:
    """The special points between a point and the one a step after it, in their order.

    Where one cannot be located, as no orbit is found within the step, it is put at the latter point.
    """
    found = []
    for kind, test in TEST_FUNCTIONS.items():
        if test(point) * test(after) < 0.0:
            try:
                at, share = locate_zero(automaton, point, step, test)
            except ValueError:
                at, share = after, step
            found += [(share, SpecialPoint(kind, at, at.value))] if _is_special(kind, at) else []
    return [special for _, special in sorted(found, key=lambda pair: pair[0])]


def locate_zero(
    automaton: HybridAutomaton, point: BranchPoint, step: float, test: Callable[[BranchPoint], float]
) -> tuple[BranchPoint, float]:
    """The point at which a test function changes its sign within a step, and how far into the step it is."""

    def value(share: float) -> float:
        return test(continuation_step(automaton, point, share)) if share else test(point)

    share: Any = brentq(value, 0.0, step, xtol=LOCATION_XTOL * step)
    return continuation_step(automaton, point, share), share


def _is_special(kind: str, point: BranchPoint) -> bool:
    """Whether a zero is a special point: two real multipliers whose product is 1 are no Neimark-Sacker
    point."""
    values = transverse_multipliers(point)
    pairs = values[np.abs(values.imag) > 0.0]
    return kind != "Neimark-Sacker" or bool((np.abs(np.abs(pairs) - 1.0) < UNIT_CIRCLE_ATOL).any())


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
        for event in automaton.mode(run.mode_names[i]).events:
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
    modes = {
        name: automaton.mode(name) for name in {*events.source.tolist(), *events.target.tolist()} if name
    }
    arguments = [*automaton.states, *automaton.parameters]
    for source, target, guard, state in zip(
        events.source, events.target, events.guard, events.state, strict=True
    ):
        left = modes[source]
        trigger = next(event for event in left.events if event.name == guard)
        zero = {*map(sign_normal_form, (trigger.function, *left.constraints, *trigger.reset.vanishing))}
        for event in modes[target].events:
            if sign_normal_form(event.function) in zero:
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
