"""The next mode: resets, and the first mode that is admissible at a state.

A mode can be entered where its constraints hold and the first non-zero Taylor coefficient of each of its
event functions is positive, so that it lasts.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from frictionlab.hybrid.compilation import kernel
from frictionlab.hybrid.kernels.event_location import LOW_ORDER, leading_order
from frictionlab.hybrid.kernels.jets import has_native_jets, majorant, mode_jets, reset_values

NO_MODE = -1
REFUSED, AT_ANOTHER_EVENT, UNDECIDED, ADMITTED = range(4)


class Rounding(NamedTuple):
    """What counts as zero: coefficients below a share of their bounds, for states of some sizes."""

    sizes: np.ndarray
    share: float


class Selection(NamedTuple):
    """The mode to enter, or a mode that comes to be tried and has yet to be derived; NO_MODE where none."""

    mode: int
    missing: int


@kernel
def apply_reset(system, reset, z, J):
    """Overwrite the state by its values after the reset number `reset`; none for -1."""
    if reset >= 0:
        reset_values(system.code, system.numbers, reset, z, J)
        for i in range(z.shape[0]):
            z[i] = J[system.code.reset_out[reset, i], 0]


@kernel
def admissibility(system, mode, rounding, order, scratch):
    """Whether a mode can be entered, judged by its Taylor coefficients in `scratch` up to `order`.

    Its constraints must be met up to rounding, and the first non-zero coefficient of every guard must be
    positive; where a guard has none up to `order` the matter is undecided.  A guard that is zero and falls,
    though the event before does not say that it is zero, is at another event.  Writes how many leading
    coefficients of each guard are zero.
    """
    code, J, bounds, declared = system.code, scratch.jets, scratch.bounds, scratch.structural_zeros
    majorant(code, system.magnitudes, mode, order, rounding.sizes, J, bounds)
    for f in range(code.mode_constraints[mode], code.mode_constraints[mode + 1]):
        slot = code.function_slots[f]
        if declared[f] == 0 and leading_order(J[slot], bounds[slot], 0, order, rounding.share) == 0:
            return REFUSED
    verdict = ADMITTED
    first = code.mode_guards[mode]
    for g in range(first, code.mode_guards[mode + 1]):
        slot = code.function_slots[g]
        k = leading_order(J[slot], bounds[slot], declared[g], order, rounding.share)
        scratch.leading_zeros[g - first] = k
        if k > order:
            verdict = min(verdict, UNDECIDED)
        elif J[slot, k] < 0.0:
            if k == 0 or declared[g] > 0:
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
def is_excluded(system, mode, z, rounding, declared, scratch):
    """Whether what is known of a mode that is not derived forbids to enter it at `z`.

    ``declared`` leading coefficients of each function vanish at `z` by construction.
    """
    code, J, bounds = system.code, scratch.jets, scratch.bounds
    mode_jets(code, system.numbers, mode, 0, z, J)
    majorant(code, system.magnitudes, mode, 0, rounding.sizes, J, bounds)
    for f in range(code.mode_constraints[mode], code.mode_constraints[mode + 1]):
        slot = code.function_slots[f]
        if leading_order(J[slot], bounds[slot], declared[f], 0, rounding.share) == 0 and J[slot, 0] < 0.0:
            return True
    return False


@kernel
def select_mode(system, candidates, z, rounding, order, scratch):
    """First admissible mode of `candidates` at `z`, a :class:`Selection`; leaves its jets in `scratch`.

    A guard that vanishes identically stays zero, so it does not end the mode.  Where several events fall
    upon one instant no mode may be admissible after the first of them; then the first mode is entered that
    is at another event, which ends it at once.
    """
    passed = NO_MODE
    for mode in candidates:
        if system.code.built[mode] == 0:
            if is_excluded(system, mode, z, rounding, scratch.structural_zeros, scratch):
                continue
            return Selection(NO_MODE, mode)
        verdict = try_mode(system, mode, z, rounding, order, scratch)
        if verdict > AT_ANOTHER_EVENT:
            return Selection(mode, NO_MODE)
        if verdict == AT_ANOTHER_EVENT and passed == NO_MODE:
            passed = mode
    if passed != NO_MODE:
        mode_jets(system.code, system.numbers, passed, order, z, scratch.jets)
        admissibility(system, passed, rounding, order, scratch)
    return Selection(passed, NO_MODE)
