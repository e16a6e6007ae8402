"""Section events: zero crossings that are recorded along a step but change no mode."""

from __future__ import annotations

from frictionlab.hybrid.compilation import kernel
from frictionlab.hybrid.kernels.event_location import absolute_sum, rescale
from frictionlab.hybrid.kernels.jets import polynomial_value, states_at
from frictionlab.hybrid.kernels.roots import isolate_roots
from frictionlab.hybrid.kernels.run_state import NOW, POINTS

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
def record_section_point(section, s, order, run, record, scratch):
    """Record the state at `s` after the start of the step."""
    row = run.counts[POINTS]
    record.point_times[row] = run.times[NOW] + s
    record.point_sections[row] = section
    states_at(scratch.jets, order, s, record.point_states[row])
    run.counts[POINTS] += 1


@kernel
def record_section_events(code, order, mode, h, run, record, scratch):
    """Record every crossing in (0, h]; a crossing between two steps, by a jump, belongs to the later."""
    for section in range(code.sections.shape[1]):
        c = scratch.jets[code.sections[mode, section]]
        size = absolute_sum(c, 0, order, h)
        start, skipped = sign_after_start(c, order, h, size)
        if start != 0:
            if run.signs[section] == -start and code.directions[section] != -start:
                record_section_point(section, 0.0, order, run, record, scratch)
            run.signs[section] = start
            record_crossings(code, (section, skipped), mode, order, h, run, record, scratch)
        end = sign_beyond_rounding(polynomial_value(c, order, h), size)
        if end != 0:
            run.signs[section] = end


@kernel
def record_crossings(code, start, mode, order, h, run, record, scratch):
    """Record the sign changes in (0, h] of a section whose sign just after the start is known.

    `start` is the number of the section, and how many of its leading coefficients count as zero.
    """
    section, skipped = start
    roots = scratch.roots
    c = scratch.jets[code.sections[mode, section]]
    n = rescale(c, skipped, order, h, roots.scaled)
    sign = run.signs[section]
    count = isolate_roots(n, n + 1, roots)
    for i in range(count):
        if roots.multiplicity[i] % 2 == 1:
            sign = -sign
            if sign != 0 and code.directions[section] != -sign:
                record_section_point(section, roots.places[i] * h, order, run, record, scratch)
    run.signs[section] = sign
