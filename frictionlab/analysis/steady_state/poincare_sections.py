"""Poincare sections of a run: onsets of stick, or zeros of an expression of the states.

The phase of a periodic force is a state, too.  Its reset once a period does not count as an event of the
motion.  For comparisons it is mapped to a circle, so that the end of a period coincides with its beginning.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from frictionlab.analysis.motion_scales import Array
from frictionlab.automaton import HybridAutomaton, Mode
from frictionlab.automaton.modes_on_demand import JOINT, has_regime
from frictionlab.hybrid.run_events import SectionPoints
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.tape.arguments import read_expression
from frictionlab.tape.formulas import function_along_run
from frictionlab.validation import abbreviate, check_number, check_text

STICK = "stick"
BISECTIONS = 40
MEAN_SAMPLES = 2001  # of a run, for the mean of a state
EVENT_TIME_SHARE = 1e-7  # of the longest stay: so much, sqrt(eps), rounding moves the zero of a parabola
Section = str | tuple[Any, int]


def phase_resets(run: Trajectory) -> np.ndarray:
    """Which events (E,) only set a phase back: no coordinate, velocity or mode changes."""
    events, automaton = run.events, run.automaton
    if not _other_states(run):
        return np.zeros(len(events), dtype=bool)
    pairs = list(zip(events.source.tolist(), events.guard.tolist()))
    modes = {name: automaton.mode(name) for name in {*events.source.tolist()}}
    guards = {(name, guard) for name, mode in modes.items() for guard in _phase_guards(run, mode)}
    return np.array([pair in guards for pair in pairs], dtype=bool)


def _phase_guards(run: Trajectory, mode: Mode) -> list[str]:
    """The events of a mode that set a phase back."""
    others = _other_states(run)
    return [
        e.name
        for e in mode.events
        if e.targets == (mode.name,) and e.reset.jump and {*e.reset.jump} <= others
    ]


def _other_states(run: Trajectory) -> set[Any]:
    """The states that are neither coordinates nor velocities."""
    first = 2 * run.automaton.coordinates
    return {*run.automaton.states[first:]} if first else set()


def turns_of_phases(run: Trajectory) -> tuple[tuple[np.ndarray, np.ndarray], ...]:
    """The phases of a run that are set back by a number: how many periods a change of the states is, as a row
    (m,), and how far the states move in one (m,)."""
    if not _other_states(run):
        return ()
    automaton = run.automaton
    mode, turns = automaton.mode(run.mode_names[run.raw.mode]), {}
    guards = _phase_guards(run, mode)
    for jump in (event.reset.jump for event in mode.events if event.name in guards):
        for state, after in jump.items():
            shift = state - after
            if shift.is_number and shift.is_positive:
                place = automaton.states.index(state)
                along = np.eye(len(automaton.states))[place]
                turns[place] = along / float(shift), float(shift) * along
    return tuple(turns.values())


def only_phase_resets(run: Trajectory) -> bool:
    """Whether a motion stays in one mode, with no events but the resets of a phase."""
    return bool(phase_resets(run).all())


def covers_period(run: Trajectory) -> bool:
    """Whether every phase has gone through a whole period, in a run without events but its resets.

    True where there is no phase.
    """
    events, passed = run.events, run.final_state - run.raw.step_states[0]
    for guard in _phase_guards(run, run.automaton.mode(run.mode_names[run.raw.mode])):
        at = np.flatnonzero(events.guard == guard)
        if not len(at) or (len(at) == 1 and (passed * (events.before[at] - events.state[at]) < 0.0).any()):
            return False
    return True


def phase_on_circle(run: Trajectory, states: Array) -> Array:
    """States (N, m) of a run with every phase as a point on a circle."""
    at, columns = phase_resets(run), [*states.T]
    if not at.any():
        return states
    for i, (before, after) in enumerate(zip(run.events.before[at].T, run.events.state[at].T)):
        jumps = np.flatnonzero(before != after)
        if len(jumps):
            first, last = after[jumps[0]], before[jumps[0]]
            angle = 2 * np.pi * (columns[i] - first) / (last - first)
            columns[i] = np.cos(angle)
            columns.append(np.sin(angle))
    return np.column_stack(columns)


def section_function(automaton: HybridAutomaton, section: Section) -> dict[str, Any]:
    """The section as :func:`frictionlab.solve` takes it; empty for onsets of stick, which are events anyway.

    Parameters
    ----------
    automaton : HybridAutomaton
    section : "stick", str or (str, int)
        "stick": transitions from slip to stick.  Else an expression of the states ("x1'", "x1 - x2") or an
        output's name ("penetration"), and the direction in which it passes zero: 1 rising, -1 falling,
        0 both.

    Raises
    ------
    ValueError
        For an unknown name in the expression, or no expression; for another direction; for "stick" where
        no contact has that mode.
    """
    if isinstance(section, str) and section == STICK:
        if not has_regime(automaton.names, STICK):
            modes = ", ".join(automaton.names)
            raise ValueError(f"section 'stick' needs a mode of that name, got {modes}: leave it out")
        return {}
    text, direction = check_section_form(section)
    return {"section": (read_expression(automaton, text, "section"), direction)}


def check_section_form(section: Any) -> tuple[str, int]:
    """The text and the direction of a section, whatever the automaton; raises for what can be none."""
    pair = isinstance(section, (tuple, list)) and len(section) == 2
    text, direction = section if pair else (section, 0)
    cure = 'write "stick", an expression such as "x1\'", or ("x1\'", -1)'
    if not isinstance(text, str) or not text.strip():
        raise ValueError(
            f'section must be "stick", an expression, or (expression, direction), got {abbreviate(section)}: '
            f"{cure}"
        )
    direction = check_number(
        "the section's direction", direction, integer=True, least=-1, most=1, cure="0 takes both"
    )
    return check_text("section", text, cure), direction


def sections_to_record(automaton: HybridAutomaton, section: Section | None) -> dict[str, Any]:
    """The section that a run records to check recurrence.

    It is the given one; turning points where there is none, or where it is "stick", whose onsets are events.
    """
    return section_function(automaton, section or turning_section(automaton)) or section_function(
        automaton, turning_section(automaton)
    )


def turning_section(automaton: HybridAutomaton) -> tuple[str, int]:
    """The section where the first coordinate is largest; without coordinates, where the first state passes
    zero."""
    return (str(automaton.states[automaton.coordinates]), -1)


def section_crossings(run: Trajectory, section: Section) -> SectionPoints:
    """Crossings of the section in a run: times (K,), states (K, m).

    At an onset of stick the state is that after the event, at other events that before it.
    """
    if section == STICK:
        onsets = stick_onsets(run)
        return SectionPoints(run.events.t[onsets], run.events.state[onsets])
    if not isinstance(section, str) and not isinstance(section[0], str):  # an expression for this run alone
        return _states_before_events(run, _search_crossings(run, *section))
    crossings = run.sections.get("section")
    return _states_before_events(
        run, crossings or _search_crossings(run, *section_function(run.automaton, section)["section"])
    )


def _states_before_events(run: Trajectory, points: SectionPoints) -> SectionPoints:
    """The crossings; one at an event gets the time of the event and the state before it.

    The crossing found there may have the state after the event.
    """
    events = run.events
    if not len(events):
        return points
    t, last = events.t, len(events) - 1
    after = np.clip(np.searchsorted(t, points.t), 0, last)
    before = np.maximum(after - 1, 0)
    nearest = np.where(np.abs(t[before] - points.t) <= np.abs(t[after] - points.t), before, after)
    i = np.searchsorted(t, t[nearest])  # the first of several at once
    near = EVENT_TIME_SHARE * np.diff(t, prepend=0.0, append=run.raw.t).max()
    at_event = np.abs(t[i] - points.t) <= near
    states = np.where(at_event[:, None], events.before[i], points.state)
    return SectionPoints(np.where(at_event, t[i], points.t), states)


def stick_onsets(run: Trajectory) -> Any:
    """Which events lead a contact from slip to stick."""
    return contacts_that_stick(run) > 0


def contacts_that_stick(run: Trajectory) -> Any:
    """How many contacts each event leads from slip to stick; a mode has the regimes of all contacts."""
    pairs = list(zip(run.events.source.tolist(), run.events.target.tolist()))
    counts = {pair: sum(map(_begins_to_stick, *(_regimes(name) for name in pair))) for pair in {*pairs}}
    return np.array([counts[pair] for pair in pairs], dtype=int)


def _regimes(mode: str) -> list[str]:
    return mode.split(JOINT)


def _begins_to_stick(before: str, after: str) -> bool:
    return after == STICK and before not in (STICK, "separation", "chatter")


def phase_returns(run: Trajectory) -> SectionPoints:
    """Where the phase of a force begins anew: the slowest one, which others have to return with.

    None where there is no phase.
    """
    at = np.flatnonzero(phase_resets(run))
    guards, counts = np.unique(run.events.guard[at], return_counts=True)
    returns = at[run.events.guard[at] == guards[np.argmin(counts)]] if len(at) else at
    return SectionPoints(run.events.t[returns], run.events.state[returns])


def returns_without_coordinates(run: Trajectory, least: int) -> SectionPoints:
    """Where a motion of states that are no coordinates returns: at its rarest event.

    Without `least` events it is where the first state falls through zero or, if it does not, through its
    mean.
    """
    events, automaton = run.events, run.automaton
    guards, counts = np.unique(events.guard, return_counts=True)
    if len(events) >= least:
        at = events.guard == guards[np.argmin(np.where(counts < least, len(events), counts))]
        return SectionPoints(events.t[at], events.before[at])
    through_zero = section_crossings(run, turning_section(automaton))
    if len(through_zero.t):
        return through_zero
    mean = run(np.linspace(0.0, run.raw.t, MEAN_SAMPLES))[:, 0].mean()
    return section_crossings(run, (automaton.states[0] - float(mean), -1))


def _search_crossings(run: Trajectory, function: Any, direction: int) -> SectionPoints:
    """Crossings for methods that record no sections: changes of sign between samples, located by
    bisection."""
    level = _section_values(run, function)
    value = level(run.t)
    rising = (value[:-1] < 0) & (value[1:] >= 0) & (direction >= 0)
    falling = (value[:-1] > 0) & (value[1:] <= 0) & (direction <= 0)
    i = np.flatnonzero(rising | falling)
    low, high, sign = run.t[i], run.t[i + 1], np.sign(value[i])
    for _ in range(BISECTIONS if len(i) else 0):
        middle = 0.5 * (low + high)
        before = np.sign(level(middle)) == sign
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    return SectionPoints(low, run(low))


def _section_values(run: Trajectory, function: Any) -> Any:
    """The section's function of times."""
    if isinstance(function, str):
        return lambda t: run.output(function, t)
    parameters = run.automaton.parameters
    value = function_along_run([*run.automaton.states, *parameters], function)
    return lambda t: value(*run(t).T, *parameters.values())
