"""Contact forces against time."""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from .figure import axes_or_new
from .palette import BLUE, GREEN, ORANGE, VERMILLION
from .time_panel import finish
from .windows import LAST, Window, dense_times, limits, refuse_no_run

LETTERS = {"normal_force": "F_N", "friction_force": "F_T"}
FORCES = {"normal_force": ("$F_N$ (N)", BLUE), "friction_force": ("$F_T$ (N)", VERMILLION)}
SECOND = {"normal_force": GREEN, "friction_force": ORANGE}  # of a second contact


def force_outputs(automaton: Any) -> dict[str, tuple[str, str]]:
    """Label and colour of every contact force among an automaton's outputs; none where it has none."""
    found = {name: drawn for name, drawn in FORCES.items() if name in automaton.outputs}
    for name in automaton.outputs:
        base, _, number = name.rpartition("_")
        kind = base if number.isdigit() else name
        if name in FORCES or kind not in LETTERS:
            continue
        text = LETTERS[kind].replace("_", "_{") + (f",{number}" if number.isdigit() else "") + "}"
        colours = SECOND if number == "2" else {kind: drawn[1] for kind, drawn in FORCES.items()}
        found[name] = f"${text}$ (N)", colours.get(kind, BLUE)
    return found


def plot_contact_forces(
    run: Any, ax: Axes | None = None, *, window: Window = LAST, shade: bool = True
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
    refuse_no_run(run)
    found = force_outputs(run.automaton)
    if not found:
        raise ValueError(
            "run must have contact forces among its outputs (normal_force, friction_force), got "
            f"{', '.join(run.automaton.outputs) or 'none'}: draw its rates with plot_rates"
        )
    ax = axes_or_new(ax)
    start, stop = limits(run, window)
    t = dense_times(start, stop)
    lines = []
    for name, (text, colour) in found.items():
        lines += ax.plot(t, run.output(name, t), label=text, color=colour, linewidth=1.2)
    finish(run, ax, (start, stop), shade, "Contact forces", "contact force (N)")
    return lines
