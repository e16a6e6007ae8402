"""The next mode: resets, and the first mode that is admissible at a state.

A mode can be entered where its constraints hold and the first non-zero Taylor coefficient of each of its
event functions is positive, so that it lasts.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from frictionlab.hybrid.compilation import inlined, kernel
from frictionlab.hybrid.kernels.event_location import COEFFICIENT_ROUNDING, LOW_ORDER, leading_order
from frictionlab.hybrid.kernels.jets import has_native_jets, majorant, mode_jets, reset_values

NO_MODE, MISSING = -1, -2
BY_VALUES = 0  # the order of series that stands for a choice by the values of conditions
REFUSED, AT_ANOTHER_EVENT, UNDECIDED, ADMITTED = range(4)


class Rounding(NamedTuple):
    """What counts as zero: coefficients below a share of their bounds, for states of some sizes."""

    sizes: np.ndarray
    share: float


class Selection(NamedTuple):
    """The mode to enter, NO_MODE where there is none, and MISSING where one has to be derived first."""

    mode: int
    missing: int


@inlined
def has_modes_on_demand(code):
    """Whether modes are derived on demand, so that no event lists those that may follow it."""
    return code.targets.shape[1] == 0


@kernel
def apply_reset(system, reset, z, J):
    """Overwrite the state by its values after the reset number `reset`; none for -1."""
    if reset >= 0:
        reset_values(system.code, system.numbers, reset, z, J)
        for i in range(z.shape[0]):
            z[i] = J[system.code.reset_out[reset, i], 0]


@inlined
def set_zeros_by_construction(code, guard, closing, scratch):
    """Note which functions vanish after a reset of an event: its own, or that for an accumulation."""
    forget_zeros(scratch)
    row = 2 * guard + closing
    for k in range(code.zeros[row], code.zeros[row + 1]):
        scratch.structural_zeros[code.zero_classes[k]] = code.zero_counts[k]


@inlined
def forget_zeros(scratch):
    """Note that no function vanishes by construction."""
    for i in range(scratch.structural_zeros.shape[0]):
        scratch.structural_zeros[i] = 0
    scratch.ended[0] = NO_MODE


@inlined
def zeros_by_construction(code, scratch, f):
    """How many leading coefficients of a function vanish after the last reset."""
    zeros = scratch.structural_zeros[code.function_classes[f]]
    return max(zeros, scratch.ended[1]) if f == scratch.ended[0] else zeros


@kernel
def admissibility(system, mode, rounding, order, scratch):
    """Whether a mode can be entered, judged by its Taylor coefficients in `scratch` up to `order`.

    Its constraints must be met up to rounding, and the first non-zero coefficient of every guard must be
    positive; where a guard has none up to `order` the matter is undecided.  A guard that is zero and falls,
    though the event before does not say that it is zero, is at another event.  Writes how many leading
    coefficients of each guard are zero.
    """
    code, J, bounds = system.code, scratch.jets, scratch.bounds
    majorant(code, system.magnitudes, mode, order, rounding.sizes, J, bounds)
    for f in range(code.mode_constraints[mode], code.mode_constraints[mode + 1]):
        slot, zeros = code.function_slots[f], zeros_by_construction(code, scratch, f)
        if zeros == 0 and leading_order(J[slot], bounds[slot], 0, order, rounding.share) == 0:
            return REFUSED
    verdict = ADMITTED
    first = code.mode_guards[mode]
    for g in range(first, code.mode_guards[mode + 1]):
        slot, zeros = code.function_slots[g], zeros_by_construction(code, scratch, g)
        k = leading_order(J[slot], bounds[slot], zeros, order, rounding.share)
        scratch.leading_zeros[g - first] = k
        if k > order:
            verdict = min(verdict, UNDECIDED)
        elif J[slot, k] < 0.0:
            if k == 0 or zeros > 0:
                return REFUSED
            verdict = AT_ANOTHER_EVENT
    return verdict


@kernel
def try_mode(system, mode, z, rounding, order, scratch):
    """Whether a mode can be entered at `z`; if so, leaves all its jets in `scratch`.

    Values alone refuse most modes, and few orders nearly always decide; native code has all orders at once.
    """
    verdict, at_hand = UNDECIDED, -1
    code, J = system.code, scratch.jets
    for upto in (0, min(LOW_ORDER, order), order):
        if upto > at_hand:
            full = upto > 0 and (verdict == ADMITTED or has_native_jets(code, mode, J))
            at_hand = order if full else upto
            mode_jets(code, system.numbers, mode, at_hand, z, J)
        if verdict == UNDECIDED:
            verdict = admissibility(system, mode, rounding, upto, scratch)
        if verdict < UNDECIDED:
            break
    return verdict


@kernel
def try_mode_by_values(system, mode, z, scratch):
    """Whether the conditions of a mode hold at `z` by their values alone; what the event made zero holds."""
    code, J = system.code, scratch.jets
    mode_jets(code, system.numbers, mode, 0, z, J)
    majorant(code, system.magnitudes, mode, 0, z, J, scratch.bounds)
    for g in range(code.mode_guards[mode], code.mode_guards[mode + 1]):
        if zeros_by_construction(code, scratch, g) == 0 and J[code.function_slots[g], 0] < 0.0:
            return REFUSED
    for f in range(code.mode_constraints[mode], code.mode_constraints[mode + 1]):
        slot, zeros = code.function_slots[f], zeros_by_construction(code, scratch, f)
        if zeros == 0 and abs(J[slot, 0]) > COEFFICIENT_ROUNDING * scratch.bounds[slot, 0]:
            return REFUSED
    return ADMITTED


@kernel
def select_mode(system, candidates, z, rounding, order, scratch):
    """First admissible mode of `candidates` at `z`, a :class:`Selection`; leaves its jets in `scratch`.

    A guard that vanishes identically stays zero, so it does not end the mode.  Where several events fall
    upon one instant no mode may be admissible after the first of them; then the first mode is entered that
    is at another event, which ends it at once.
    """
    passed = NO_MODE
    for mode in candidates:
        verdict = try_mode(system, mode, z, rounding, order, scratch)
        if verdict > AT_ANOTHER_EVENT:
            return Selection(mode, NO_MODE)
        if verdict == AT_ANOTHER_EVENT and passed == NO_MODE:
            passed = mode
    return enter_passed(system, passed, z, rounding, order, scratch)


@inlined
def enter_passed(system, passed, z, rounding, order, scratch):
    """Select a mode that is at another event, if there is one; leaves its jets in `scratch`."""
    if passed != NO_MODE:
        mode_jets(system.code, system.numbers, passed, order, z, scratch.jets)
        admissibility(system, passed, rounding, order, scratch)
    return Selection(passed, NO_MODE)
