"""Section events: zero crossings that are recorded along a step but change no mode."""

from __future__ import annotations

from frictionlab.hybrid.compilation import kernel
from frictionlab.hybrid.kernels.event_location import absolute_sum, rescale
from frictionlab.hybrid.kernels.jets import polynomial_value, states_at
from frictionlab.hybrid.kernels.roots import isolate_roots

NOW = 0  # places in RunState.times and RunState.counts, see run_state
POINTS = 3
SECTION_ROUNDING = 1e-14  # a value below this share of its terms has no sign


@kernel
def sign_beyond_rounding(value, size):
    """Sign of a value; 0 where it is not above the rounding error of terms of this `size`."""
    if abs(value) <= SECTION_ROUNDING * size:
        return 0
    return 1 if value > 0.0 else -1


@kernel
def sign_after_start(c, order, h, size):
    """Sign just after the start of a step, and the number of leading terms that are zero."""
    power = 1.0
    for k in range(order + 1):
        sign = sign_beyond_rounding(c[k] * power, size)
        if sign != 0:
            return sign, k
        power *= h
    return 0, order + 1


@kernel
def record_section_point(section, s, order, cursor, record, work):
    """Record the state at `s` after the start of the step."""
    row = cursor.counts[POINTS]
    record.point_times[row] = cursor.times[NOW] + s
    record.point_sections[row] = section
    states_at(work.jets, order, s, record.point_states[row])
    cursor.counts[POINTS] += 1


@kernel
def record_section_events(code, order, mode, h, cursor, record, work):
    """Record every crossing in (0, h]; a crossing between two steps, by a jump, belongs to the later."""
    for section in range(code.sections.shape[1]):
        c = work.jets[code.sections[mode, section]]
        size = absolute_sum(c, 0, order, h)
        start, skipped = sign_after_start(c, order, h, size)
        if start != 0:
            if cursor.signs[section] == -start and code.directions[section] != -start:
                record_section_point(section, 0.0, order, cursor, record, work)
            cursor.signs[section] = start
            record_crossings(code, section, skipped, mode, order, h, cursor, record, work)
        end = sign_beyond_rounding(polynomial_value(c, order, h), size)
        if end != 0:
            cursor.signs[section] = end


@kernel
def record_crossings(code, section, skipped, mode, order, h, cursor, record, work):
    """Record the sign changes in (0, h], the first `skipped` coefficients counted as zero.

    The section's sign just after the start is known.
    """
    c = work.jets[code.sections[mode, section]]
    n = rescale(c, skipped, order, h, work.scaled)
    sign = cursor.signs[section]
    count = isolate_roots(work.scaled, n, n + 1, work.stack, work.intervals, work.roots, work.multiplicity)
    for i in range(count):
        if work.multiplicity[i] % 2 == 1:
            sign = -sign
            if sign != 0 and code.directions[section] != -sign:
                record_section_point(section, work.roots[i] * h, order, cursor, record, work)
    cursor.signs[section] = sign
