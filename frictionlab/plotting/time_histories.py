"""Displacements, rates and contact forces of a run against time, with the modes shaded behind them.

A window is the part of a run that a panel shows: a number of seconds or of the model's periods at the end,
the part between two times, or (None) the whole run.
"""

from __future__ import annotations

from numbers import Real
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.lines import Line2D
from matplotlib.ticker import ScalarFormatter
from numpy.typing import NDArray

from frictionlab.analysis.motion_scales import moving_span, period_of_run
from frictionlab.hybrid.trajectory import check_run
from frictionlab.plotting.appearance import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    SKY,
    VERMILLION,
    line_style,
    mode_fills,
    pen,
)
from frictionlab.plotting.figure import axes_or_new, restyle, set_title
from frictionlab.plotting.labels import coordinate_axis_label, secondary_axis_angles, state_with_unit
from frictionlab.plotting.turns import cut_at_turns, tick_turns, turning_angles
from frictionlab.presentation import (
    FORCE_SYMBOLS,
    force_symbol,
    in_units_of,
    is_angle,
    output_of_contact,
    output_unit,
    unit_of_state,
)
from frictionlab.validation import abbreviate, check_number, float_array, plain_number

if TYPE_CHECKING:
    from collections.abc import Iterable

    from frictionlab.automaton import HybridAutomaton
    from frictionlab.hybrid.trajectory import Trajectory

Array = NDArray[np.float64]
WINDOW_CURE = "give seconds, Periods(10), (start, stop), or None for the whole run"
SAMPLES = 4001
SAMPLING_RTOL = 1e-12  # rounding allowed for where the whole steps within a window are counted
# of the first contact, the second ...
FORCE_COLOURS = {"F_N": (BLUE, GREEN, SKY, BLACK), "F_T": (VERMILLION, ORANGE, PURPLE, GREY)}


class ForceLook(NamedTuple):
    """How a contact force, or moment, is drawn: its symbol in mathtext, its unit and its colour."""

    symbol: str
    unit: str
    colour: str


class Periods(NamedTuple):
    """A window at the end of a run, as long as `count` periods of the model."""

    count: float


class MovingPeriods(Periods):
    """The same or, where nothing moves in it, the run from its start until shortly after it came to rest."""


Window = float | tuple[float, float] | Periods | None

DEFAULT_WINDOW = MovingPeriods(7.5)  # 0.75 s of the slider on a belt


def check_run_with_two_states(run: Trajectory) -> None:
    """Raise TypeError unless it is a run, ValueError unless it has two states, as a phase plane needs."""
    check_run(run)
    if len(run.names) < 2:
        raise ValueError(
            f"run must have two states, got {', '.join(run.names)} alone: plot run.t and run.states"
        )


def window_limits(run: Trajectory, window: Window = DEFAULT_WINDOW) -> tuple[float, float]:
    """Start and end of a window: the last seconds or periods, the two times given, or (None) the whole run.

    Raises
    ------
    ValueError
        If the window is empty or lies outside the run.
    TypeError
        If `run` is not a Trajectory.
    """
    check_run(run)
    end = float(run.raw.t)
    window = plain_number(window)
    if window is None:
        return 0.0, end
    if isinstance(window, Periods):
        seconds = window.count * period_of_run(run)
        if isinstance(window, MovingPeriods):
            return moving_span(run, seconds)
        window = seconds
    if isinstance(window, Real):
        seconds = check_number("window", window, cure=WINDOW_CURE)
        start, stop = max(0.0, end - seconds), end
    else:
        start, stop = _two_times(window)
    if not 0.0 <= start <= stop <= end or (start == stop and end > 0):
        raise ValueError(
            f"window must lie within the run, 0 to {end:g} s, got {abbreviate(window)}: change its times"
        )
    return float(start), float(stop)


def _two_times(window: Any) -> Array:
    times = float_array("window", window, WINDOW_CURE)
    if times.shape != (2,):
        raise ValueError(f"window must be one number or two, got {abbreviate(window)}: {WINDOW_CURE}")
    return times


def sample_times(start: float, stop: float, points: int = SAMPLES) -> Array:
    """Evenly spaced times, kept within the window against rounding."""
    return np.clip(np.linspace(start, stop, points), start, stop)


def window_text(run: Trajectory, start: float, stop: float) -> str:
    """The window in words, for a title."""
    end = float(run.raw.t)
    if (start, stop) == (0.0, end):
        return f"whole run, {end:.4g} s"
    if stop == end:
        return f"last {stop - start:.4g} s of {end:.4g} s"
    return f"{start:.4g} s to {stop:.4g} s of {end:.4g} s"


def mode_intervals(run: Trajectory) -> tuple[Array, list[str]]:
    """Edges (n + 1,) of the intervals of a run spent in one mode, and their names.

    Events that lead back into the same mode, such as the re-contacts of chatter, split no interval.
    """
    events, end = run.events, float(run.raw.t)
    if len(events) == 0:
        names = [name for name, seconds in run.time_in_mode.items() if seconds > 0]
        return (np.array([0.0, end]), names) if names else (np.array([0.0]), [])
    modes = np.append(events.source[:1], events.target)
    starts = np.append(0.0, events.t)
    # Of several events at one instant only the mode entered last has a duration.
    lasting = np.append(starts[1:] > starts[:-1], end > starts[-1])
    modes, starts = modes[lasting], starts[lasting]
    new = np.append([True], modes[1:] != modes[:-1])[: len(modes)]
    return np.append(starts[new], end), modes[new].tolist()


def shade_modes(run: Trajectory, ax: Axes, window: Window = DEFAULT_WINDOW) -> list[PolyCollection]:
    """Shade the intervals of every mode over the whole height of a panel over time.

    Parameters
    ----------
    run : Trajectory
    ax : Axes
    window : float, (float, float) or None
        Seconds at the end, start and end time, or None for the whole run.

    Returns
    -------
    list of PolyCollection
        One for every mode that occurs, labelled with its name.
    """
    start, stop = window_limits(run, window)
    edges, names = mode_intervals(run)
    shades = []
    for mode, fill in mode_fills(run, ax).items():
        spans = _intervals_in_window(edges, [name == mode for name in names], start, stop)
        if spans:
            across = ax.get_xaxis_transform()
            shades.append(ax.broken_barh(spans, (0, 1), transform=across, label=mode, zorder=0, **fill))
    return shades


def _intervals_in_window(
    edges: Array, selection: list[bool], start: float, stop: float
) -> list[tuple[float, float]]:
    """(start, length) of the selected intervals, cut to the window."""
    left, right = np.maximum(edges[:-1], start), np.minimum(edges[1:], stop)
    inside = np.array(selection, dtype=bool) & (right > left)
    return list(zip(left[inside].tolist(), (right - left)[inside].tolist(), strict=True))


def label_time_axes(
    run: Trajectory, ax: Axes, span: tuple[float, float], shade: bool, what: str, ylabel: str
) -> None:
    """Shade the modes, if wanted; label the axes; say in the title what is drawn in which part of the run."""
    if shade:
        shade_modes(run, ax, span)
    ax.set(xlabel="time (s)", ylabel=ylabel)
    set_title(ax, f"{what}, {window_text(run, *span)}")
    ax.margins(x=0)


def plot_displacements(
    run: Trajectory,
    ax: Axes | None = None,
    *,
    window: Window = DEFAULT_WINDOW,
    shade: bool = True,
    **line: Any,
) -> list[Line2D]:
    """Draw all coordinates, or states where none is one, against time, with the modes shaded behind them.

    Lengths belong to the axis on the left.  Where there are some, an angle (phi, theta, alpha ...) is dashed
    and belongs to an axis on the right, as it has another unit and size.  One that turns is drawn modulo a
    turn.

    Parameters
    ----------
    run : Trajectory
    ax : Axes or None
        None draws into a new figure, ``lines[0].axes.figure``.
    window : float, (float, float) or None
        Seconds at the end, start and end time, or None for the whole run; by default some eight periods,
        or what moved before them where they show nothing.
    shade : bool
        Whether to shade the modes.
    **line
        Properties of matplotlib's Line2D for all lines: color, linewidth, alpha ...

    Returns
    -------
    list of Line2D
        One line for every coordinate, in SI units.
    """
    ax = axes_or_new(ax)
    start, stop = window_limits(run, window)
    t = sample_times(start, stop)
    states, names = run(t), run.automaton.shown_states
    has_units = bool(unit_of_state(run.source, run.names[0]))
    angles = secondary_axis_angles(names) if has_units else ()
    right = _angle_axis(ax) if angles else ax
    for axis in (ax, right):
        if isinstance(axis.yaxis.get_major_formatter(), ScalarFormatter):
            axis.ticklabel_format(axis="y", scilimits=(-3, 4))  # 1e-4 once, not 0.00012 at every tick
    lines, turning = [], turning_angles(run.automaton)
    for i, name in enumerate(names):
        axis, text = right if name in angles else ax, state_with_unit(run.source, name)
        x, time = states[:, i], t
        if name in turning:
            x, time = cut_at_turns(x, t)
        lines += axis.plot(time, x, label=text, **line_style(i, ax, dashed=name in angles))
    for axis, shown in ((ax, [name for name in names if name not in angles]), (right, angles)):
        if shown and {*shown} <= {*turning}:  # what else the axis shows may be large
            tick_turns(axis.yaxis)
    label_time_axes(
        run,
        ax,
        (start, stop),
        shade,
        "Displacements" if run.automaton.coordinates else "States",
        in_units_of(run.source, coordinate_axis_label(names)) if has_units else "",
    )
    return restyle(lines, line)


def _angle_axis(ax: Axes) -> Axes:
    right = ax.twinx()
    right.set_ylabel("angle (rad), dashed")
    right.margins(x=0)
    return right


def plot_rates(
    run: Trajectory,
    ax: Axes | None = None,
    *,
    window: Window = DEFAULT_WINDOW,
    shade: bool = True,
    **line: Any,
) -> list[Line2D]:
    """Draw the rates of all coordinates against time, with the modes shaded behind them.

    Parameters
    ----------
    run : Trajectory
    ax : Axes or None
        None draws into a new figure, ``lines[0].axes.figure``.
    window : float, (float, float) or None
        Seconds at the end, start and end time, or None for the whole run; by default some eight periods,
        or what moved before them where they show nothing.
    shade : bool
        Whether to shade the modes.
    **line
        Properties of matplotlib's Line2D for all lines: color, linewidth, alpha ...

    Returns
    -------
    list of Line2D
        One line for every coordinate, in SI units.
    """
    ax = axes_or_new(ax)
    start, stop = window_limits(run, window)
    t, n = sample_times(start, stop), run.automaton.coordinates
    states, lines = run(t), []
    names = run.names[n : 2 * n]
    has_units = bool(unit_of_state(run.source, run.names[0]))
    angles = secondary_axis_angles(names) if has_units else ()
    label = "rate" if any(map(is_angle, names)) else in_units_of(run.source, "velocity (m/s)")
    for i, name in enumerate(names):
        text = state_with_unit(run.source, name)
        lines += ax.plot(t, states[:, n + i], label=text, **line_style(i, ax, dashed=name in angles))
    label_time_axes(run, ax, (start, stop), shade, "Rates", label if has_units else "rate")
    return restyle(lines, line)


def force_outputs(automaton: HybridAutomaton, source: Any) -> dict[str, ForceLook]:
    """How every contact force among the outputs of an automaton is drawn; none where it has none.

    `source` is the model that it was derived from, or None.  The reaction of a stop without friction is not
    among them: it is zero but for rest.
    """
    looks = {}
    for name in automaton.outputs:
        kind, number = output_of_contact(name)
        if kind in FORCE_SYMBOLS and name.replace(kind, "friction_force") in automaton.outputs:
            colours = FORCE_COLOURS[FORCE_SYMBOLS[kind]]
            colour = colours[(int(number or 1) - 1) % len(colours)]
            looks[name] = ForceLook(f"${force_symbol(name, source)}$", output_unit(name, source), colour)
    return looks


def force_axis_label(looks: Iterable[ForceLook]) -> str:
    """Label of the axis of contact forces, of moments, or of both."""
    units = sorted({look.unit for look in looks}, key=len)
    return ", ".join(f"contact {'moment' if unit.endswith(' m') else 'force'} ({unit})" for unit in units)


def plot_contact_forces(
    run: Trajectory,
    ax: Axes | None = None,
    *,
    window: Window = DEFAULT_WINDOW,
    shade: bool = True,
    **line: Any,
) -> list[Line2D]:
    """Draw the contact forces against time, with the modes shaded behind them.

    Parameters
    ----------
    run : Trajectory
        Of an automaton with outputs ``normal_force`` or ``friction_force``, or those of several contacts,
        ``normal_force_1`` and so on.
    ax : Axes or None
        None draws into a new figure, ``lines[0].axes.figure``.
    window : float, (float, float) or None
        Seconds at the end, start and end time, or None for the whole run; by default some eight periods,
        or what moved before them where they show nothing.
    shade : bool
        Whether to shade the modes.
    **line
        Properties of matplotlib's Line2D for all lines: color, linewidth, alpha ...

    Returns
    -------
    list of Line2D
        F_N and F_T, of every contact.

    Raises
    ------
    ValueError
        For a run without contact forces.
    """
    check_run(run)
    outputs = force_outputs(run.automaton, run.source)
    if not outputs:
        raise ValueError(
            "run must have contact forces among its outputs (normal_force, friction_force), got "
            f"{', '.join(run.automaton.outputs) or 'none'}: draw its rates with plot_rates"
        )
    ax = axes_or_new(ax)
    start, stop = window_limits(run, window)
    t = sample_times(start, stop)
    lines = []
    for name, (symbol, unit, colour) in outputs.items():
        lines += ax.plot(t, run.output(name, t), label=f"{symbol} ({unit})", **pen(colour, ax=ax))
    label_time_axes(run, ax, (start, stop), shade, "Contact forces", force_axis_label(outputs.values()))
    return restyle(lines, line)
