"""Displacements, rates and contact forces of a run against time, with the modes shaded behind them."""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from frictionlab.plotting.appearance import pen
from frictionlab.plotting.figure import axes_or_new
from frictionlab.plotting.style import (
    BLUE,
    GREEN,
    ORANGE,
    VERMILLION,
    coordinate_axis_label,
    line_style,
    secondary_axis_angles,
    state_label,
)
from frictionlab.presentation import is_angle, state_unit

from .time_window import DEFAULT_WINDOW, Window, check_run, label_time_axes, sample_times, window_limits

FORCE_SYMBOLS = {"normal_force": "F_N", "friction_force": "F_T"}
FORCES = {"normal_force": ("$F_N$ (N)", BLUE), "friction_force": ("$F_T$ (N)", VERMILLION)}
SECOND_CONTACT_COLOURS = {"normal_force": GREEN, "friction_force": ORANGE}  # of a second contact


def plot_displacements(
    run: Any, ax: Axes | None = None, *, window: Window = DEFAULT_WINDOW, shade: bool = True
) -> list[Line2D]:
    """Draw all coordinates against time, with the modes shaded behind them.

    Lengths belong to the axis on the left; an angle (named phi, theta or psi) is dashed, as it has another
    unit and size, and where there are lengths belongs to an axis on the right.

    Parameters
    ----------
    run : Trajectory
    ax : Axes or None
        None draws into a new figure, ``lines[0].axes.figure``.
    window : float, (float, float) or None
        The last so many seconds, from one time to another, or the whole run; without it some eight periods.
    shade : bool
        Whether to shade the modes.

    Returns
    -------
    list of Line2D
        One line for every coordinate, in SI units.
    """
    ax = axes_or_new(ax)
    start, stop = window_limits(run, window)
    t = sample_times(start, stop)
    states, names = run(t), run.names[: run.automaton.coordinates]
    angles = secondary_axis_angles(names)
    right = _angle_axis(ax) if angles else ax
    for axis in (ax, right):
        axis.ticklabel_format(axis="y", scilimits=(-3, 4))  # 1e-4 once rather than 0.00012 at every tick
    lines = []
    for i, name in enumerate(names):
        axis, text = right if name in angles else ax, f"{state_label(name)} ({state_unit(name)})"
        lines += axis.plot(t, states[:, i], label=text, **line_style(i, name, ax))
    label_time_axes(run, ax, (start, stop), shade, "Displacements", coordinate_axis_label(names))
    return lines


def _angle_axis(ax: Axes) -> Axes:
    right = ax.twinx()
    right.set_ylabel("angle (rad), dashed")
    right.margins(x=0)
    return right


def plot_rates(
    run: Any, ax: Axes | None = None, *, window: Window = DEFAULT_WINDOW, shade: bool = True
) -> list[Line2D]:
    """Draw the rates of all coordinates against time, with the modes shaded behind them.

    Parameters
    ----------
    run : Trajectory
    ax : Axes or None
        None draws into a new figure, ``lines[0].axes.figure``.
    window : float, (float, float) or None
        The last so many seconds, from one time to another, or the whole run; without it some eight periods.
    shade : bool
        Whether to shade the modes.

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
    for i, name in enumerate(names):
        text = f"{state_label(name)} ({state_unit(name)})"
        lines += ax.plot(t, states[:, n + i], label=text, **line_style(i, name, ax))
    label_time_axes(
        run, ax, (start, stop), shade, "Rates", "rate" if any(map(is_angle, names)) else "velocity (m/s)"
    )
    return lines


def force_outputs(automaton: Any) -> dict[str, tuple[str, str]]:
    """Label and colour of every contact force among an automaton's outputs; none where it has none."""
    found = {name: drawn for name, drawn in FORCES.items() if name in automaton.outputs}
    for name in automaton.outputs:
        base, _, number = name.rpartition("_")
        kind = base if number.isdigit() else name
        if name in FORCES or kind not in FORCE_SYMBOLS:
            continue
        text = FORCE_SYMBOLS[kind].replace("_", "_{") + (f",{number}" if number.isdigit() else "") + "}"
        colours = (
            SECOND_CONTACT_COLOURS if number == "2" else {kind: drawn[1] for kind, drawn in FORCES.items()}
        )
        found[name] = f"${text}$ (N)", colours.get(kind, BLUE)
    return found


def plot_contact_forces(
    run: Any, ax: Axes | None = None, *, window: Window = DEFAULT_WINDOW, shade: bool = True
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
        The last so many seconds, from one time to another, or the whole run; without it some eight periods.
    shade : bool
        Whether to shade the modes.

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
    found = force_outputs(run.automaton)
    if not found:
        raise ValueError(
            "run must have contact forces among its outputs (normal_force, friction_force), got "
            f"{', '.join(run.automaton.outputs) or 'none'}: draw its rates with plot_rates"
        )
    ax = axes_or_new(ax)
    start, stop = window_limits(run, window)
    t = sample_times(start, stop)
    lines = []
    for name, (text, colour) in found.items():
        lines += ax.plot(t, run.output(name, t), label=text, **pen(colour, ax=ax))
    label_time_axes(run, ax, (start, stop), shade, "Contact forces", "contact force (N)")
    return lines
