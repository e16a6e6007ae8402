"""Motions against a parameter: section points and intensity of steady states; branches of periodic orbits;
results of a sweep over its grid, as curves over one parameter, colours over two.

Branches are solid where the orbit is stable and dashed where it is not, with their special points.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from frictionlab.analysis.steady_state.classification import MotionKind
from frictionlab.models.model import automaton_of
from frictionlab.plotting.appearance import (
    BLACK,
    BLUE,
    DASHED,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    SKY,
    VERMILLION,
    background,
    legible,
    line_style,
    marker_size,
    pen,
)
from frictionlab.plotting.figure import axes_or_new, legend_beside, restyle
from frictionlab.plotting.labels import check_compared, parameter_label, state_label, state_with_unit
from frictionlab.presentation import unit_of_state
from frictionlab.validation import abbreviate

if TYPE_CHECKING:
    from frictionlab.analysis.orbits.periodic_orbit import PeriodicOrbit
    from frictionlab.analysis.sweeps.bifurcation import Bifurcation
    from frictionlab.analysis.sweeps.cea_against_motion import CEAAgainstMotion
    from frictionlab.analysis.sweeps.sweep import Sweep

Array = NDArray[np.float64]
MOTION_STYLES: dict[str, dict[str, Any]] = {
    MotionKind.PERIODIC: {"color": BLUE, "marker": ".", "markersize": 4.0},
    MotionKind.NON_PERIODIC: {"color": VERMILLION, "marker": ".", "markersize": 2.0},
    MotionKind.NOT_SETTLED: {"color": GREY, "marker": ".", "markersize": 3.0},
    MotionKind.ENDED_EARLY: {"color": GREY, "marker": "x", "markersize": 3.0},
    MotionKind.EQUILIBRIUM: {"color": BLACK, "marker": "_", "markersize": 6.0},
}
# share of the axes' height at which runs that ended early are marked; most of these motions grew
# without bounds
EARLY_END_HEIGHT = 0.03
SPECTRUM_DECADES = 3.0  # of amplitudes against a parameter
LOG_SCALE_RATIO = 30.0  # largest over smallest intensity above which the axis is logarithmic

DISAGREEMENT_STYLES = {
    "vibrates though stable": (ORANGE, "^"),
    "rests though unstable": (PURPLE, "s"),
    "not settled": (GREY, "x"),
}

SPECIAL_POINT_STYLES = {
    "fold": (VERMILLION, "o"),
    "period doubling": (ORANGE, "s"),
    "Neimark-Sacker": (PURPLE, "D"),
    "grazing": (GREEN, "^"),
    "mode change": (SKY, "v"),
    "Hopf": (BLACK, "*"),
}


def plot_bifurcation(
    result: Bifurcation,
    ax: Axes | None = None,
    *,
    name: str | None = None,
    legend: bool = True,
    **line: Any,
) -> list[Line2D]:
    """Draw a state at the points of the section against the parameter, and the equilibria.

    Parameters
    ----------
    result : Bifurcation
    ax : Axes or None
        None draws into a new figure, ``lines[0].axes.figure``.
    name : str or None
        The state, e.g. "x1" or "x1'"; None takes the first.
    legend : bool
        Whether to put a legend beside the panel.
    **line
        Properties of matplotlib's Line2D for all lines: color, linewidth, alpha ...

    Returns
    -------
    list of Line2D
        The points of every kind of motion that occurs; runs that ended early are marked at the bottom.

    Raises
    ------
    ValueError
        For an unknown state.
    """
    automaton = automaton_of(result.model)
    state: str = name or automaton.shown_state
    unit = unit_of_state(result.model, state)
    groups = {kind: result.section(state, kind) for kind in MOTION_STYLES}
    ax = axes_or_new(ax)
    lines = []
    for kind, (values, states) in groups.items():
        if kind == MotionKind.ENDED_EARLY:
            states, where = np.full(len(values), EARLY_END_HEIGHT), ax.get_xaxis_transform()
        else:
            where = ax.transData
        if len(values):
            style = _point_style(MOTION_STYLES[kind], ax)
            lines += ax.plot(values, states, label=kind, transform=where, **style)
    ax.set(
        xlabel=_swept_parameter_label(result),
        ylabel=f"{state_label(state)} at {_section_text(result)}{unit and f' ({unit})'}",
    )
    if legend:
        legend_beside(ax)
    return restyle(lines, line)


def _point_style(style: dict[str, Any], ax: Axes) -> dict[str, Any]:
    size = marker_size(style["markersize"])
    return style | {"color": legible(style["color"], ax), "markersize": size, "linestyle": "none"}


def plot_intensity(
    results: Any,
    ax: Axes | None = None,
    *,
    labels: Sequence[str] | None = None,
    legend: bool = True,
    **line: Any,
) -> list[Line2D]:
    """Draw the intensity L_s of the motion, Eq. (20), against the parameter.

    If the intensities of the motions span decades, the axis is logarithmic above the smallest of them and
    linear below it, so that equilibria, drawn hollow, are at zero at its foot.

    Parameters
    ----------
    results : Bifurcation, or a sequence of them
        Over the same parameter.
    ax : Axes or None
        None draws into a new figure, ``lines[0].axes.figure``.
    labels : sequence of str or None
        A label for each result; None takes its initial state.
    legend : bool
        Whether to put a legend beside the panel, where there is more than one line.
    **line
        Properties of matplotlib's Line2D for all lines: color, linewidth, alpha ...

    Returns
    -------
    list of Line2D
        One for each result, broken where there is no intensity.

    Raises
    ------
    ValueError
        Where the parameters differ, or there are not as many labels as results.
    """
    results = [results] if hasattr(results, "kinds") else list(results)
    labels = [_start_text(result) for result in results] if labels is None else list(labels)
    check_compared("results", [result.parameter for result in results], labels)
    ax = axes_or_new(ax)
    lines = []
    for i, (result, text) in enumerate(zip(results, labels)):
        style: dict[str, Any] = {"marker": "."} | line_style(i, ax)
        lines += ax.plot(result.values, result.intensities, label=text, **style)
        resting = np.array(result.kinds) == MotionKind.EQUILIBRIUM
        hollow = {"color": style["color"], "markerfacecolor": background(ax), "linestyle": "none"}
        at_rest = ax.plot(
            result.values[resting], result.intensities[resting], "o", label="_at rest", **hollow
        )
        at_rest[0].set_markersize(marker_size(4.0))
    _set_intensity_scale(ax, results)
    ax.set(xlabel=_swept_parameter_label(results[0]), ylabel=r"intensity $L_{\mathrm{s}}$ (m$^{2}$)")
    if legend and len(lines) > 1:
        legend_beside(ax)
    return restyle(lines, line)


def _set_intensity_scale(ax: Axes, results: list[Any]) -> None:
    moving = np.concatenate([r.intensities[np.array(r.kinds) != MotionKind.EQUILIBRIUM] for r in results])
    moving = moving[moving > 0]  # drops NaN as well, which stands for values not computed
    if len(moving) and moving.max() > LOG_SCALE_RATIO * moving.min():
        foot = 10.0 ** np.floor(np.log10(moving.min()))
        ax.set_yscale("symlog", linthresh=foot, linscale=0.3)
        ax.set_ylim(-0.1 * foot, None)
    else:
        ax.set_ylim(0.0 if len(moving) else None, None)


def _swept_parameter_label(result: Bifurcation) -> str:
    return parameter_label(result.model, result.parameter)


def _section_text(result: Bifurcation) -> str:
    section = result.specification["section"]
    if section is None or section == "stick":
        return "the onset of stick" if section else "the section"
    text, direction = (section, 0) if isinstance(section, str) else section
    return f"{text} = 0" + {1: ", rising", -1: ", falling"}.get(direction, "")


def _start_text(result: Bifurcation) -> str:
    x0 = result.specification["x0"]
    return {"rest": "from rest", "near": "from near the equilibrium", "continue": "continued"}.get(
        x0 if isinstance(x0, str) else "", "from a state"
    )


def plot_orbit_branch(
    branch: Any, ax: Axes | None = None, *, name: str | None = None, **line: Any
) -> list[Line2D]:
    """Draw the largest value of a state along each orbit, or the period, against the parameter.

    Parameters
    ----------
    branch : OrbitBranch
    ax : Axes or None
        None draws into a new figure, ``lines[0].axes.figure``.
    name : str or None
        The state, e.g. "x1"; None draws the period.
    **line
        Properties of matplotlib's Line2D for all lines: color, linewidth, alpha ...

    Returns
    -------
    list of Line2D
        The stretches of equal stability along the branch, then the special points of each kind.

    Raises
    ------
    ValueError
        For an unknown state.

    Examples
    --------
    >>> import frictionlab as fl
    >>> model = fl.SliderOnBelt(mu_k=1.4).without("geometry")
    >>> branch = fl.continue_orbit(fl.periodic_orbit(model, fl.simulate(model, 30.0)), "mu_k", (1.3, 1.5))
    >>> [line.get_label() for line in plot_orbit_branch(branch, name="x1")]
    ['stable']
    """
    _check_state_name(branch, name)
    ax = axes_or_new(ax)
    heights, lines = np.array([_orbit_measure(orbit, name) for orbit in branch.orbits]), []
    for stable, part in _stability_intervals(branch.stable):
        dashes = "-" if stable else DASHED
        lines += ax.plot(branch.values[part], heights[part], linestyle=dashes, **pen(BLUE, 1.4, ax))
        lines[-1].set_label("stable" if stable else "unstable")
    for kind in dict.fromkeys(special.kind for special in branch.special):
        points = [special for special in branch.special if special.kind == kind]
        at = (
            [special.value for special in points],
            [_orbit_measure(special.orbit, name) for special in points],
        )
        colour, marker = SPECIAL_POINT_STYLES[kind]
        lines += ax.plot(*at, marker, color=legible(colour, ax), label=kind)
    text = "period (s)" if name is None else f"largest {state_with_unit(branch.orbits[0].model, name)}"
    ax.set(xlabel=parameter_label(branch.orbits[0].model, branch.parameter), ylabel=text)
    legend_beside(ax, lines)
    return restyle(lines, line)


def _check_state_name(branch: Any, name: str | None) -> None:
    names = branch.orbits[0].trajectory.names
    if name is not None and name not in names:
        raise ValueError(
            f"name must be one of {', '.join(names)}, or None for the period, got {abbreviate(name)}"
        )


def _orbit_measure(orbit: PeriodicOrbit, name: str | None) -> float:
    return orbit.period if name is None else float(orbit.trajectory[name].max())


def _stability_intervals(stable: np.ndarray) -> list[tuple[bool, slice]]:
    """Stretches of equal stability; each includes the next one's first orbit, so the line is not broken."""
    intervals, start = [], 0
    for value, group in groupby(stable.tolist()):
        count = len(list(group))
        intervals.append((value, slice(start, start + count + 1)))
        start += count
    return intervals


def plot_cea_against_motion(
    result: CEAAgainstMotion, ax: Axes | None = None, *, legend: bool = True
) -> list[Artist]:
    """Draw the spectra of the motions in colours, and the frequencies of the modes that grow as points.

    Below are marks where the motion does not do what the eigenvalues say.

    Parameters
    ----------
    result : CEAAgainstMotion
    ax : Axes or None
        None draws into a new figure.
    legend : bool

    Returns
    -------
    list of Artist
        The mesh of colours, then points.

    Examples
    --------
    >>> import frictionlab as fl
    >>> comparison = fl.cea_against_motion(fl.ModeCoupling(c=0.1), "mu_k", [0.1, 1.0], progress=False)
    >>> comparison.plot().get_ylabel()
    'frequency (Hz)'
    """
    ax = axes_or_new(ax)
    lines = np.nan_to_num(result.lines)
    top = max(lines.max(initial=0.0), np.finfo(float).tiny)
    foot = top * 10.0**-SPECTRUM_DECADES
    grid = np.linspace(0.0, result.f_max, lines.shape[1] + 1)
    levels, scale = np.maximum(lines.T, foot), LogNorm(foot, top)
    mesh = ax.pcolormesh(
        _cell_edges(result.values), grid, levels, norm=scale, cmap="viridis", rasterized=True
    )
    ax.figure.colorbar(mesh, ax=ax, label=f"amplitude of {state_with_unit(result.model, result.state)}")
    artists: list[Artist] = [mesh]
    style: dict[str, Any] = {"marker": "o", "markersize": 3.0, "linestyle": "none", "color": VERMILLION}
    points = ax.plot(result.values, result.unstable, **style)
    points[0].set_label("unstable eigenfrequency")
    artists += points
    for kind, (colour, marker) in DISAGREEMENT_STYLES.items():
        at = result.values[[one == kind for one in result.agreement]]
        if len(at):
            style = {"marker": marker, "color": colour, "linestyle": "none", "clip_on": False}
            artists += ax.plot(at, np.full(len(at), 0.0), label=kind, **style)
    ax.set(ylim=(0.0, result.f_max), xlabel=parameter_label(result.model, result.parameter))
    ax.set_ylabel("frequency (Hz)")
    if legend:
        legend_beside(ax)
    return artists


def _cell_edges(values: Array) -> Array:
    """Edges (N + 1,) of cells around values (N,)."""
    if len(values) < 2:
        return np.concatenate([values - 0.5, values + 0.5])
    middles = 0.5 * (values[1:] + values[:-1])
    return np.concatenate([[values[0]], middles, [values[-1]]])


def plot_sweep(
    sweep: Sweep, ax: Axes | None = None, *, label: str | None = None, **line: Any
) -> list[Artist]:
    """Draw the numbers that a sweep gave: curves over one parameter, or colours over two.

    Parameters
    ----------
    sweep : Sweep
        Over one parameter, with a curve for each initial state, or over two parameters with at most one
        initial state.  Its results are numbers, or None.
    ax : Axes or None
        None draws into a new figure.
    label : str or None
        What the numbers are, with their unit; None takes the name of the function.
    **line
        Properties of matplotlib's Line2D for all lines: color, linewidth, alpha ...

    Returns
    -------
    list of Artist
        A line for each initial state, or one mesh of colours.

    Raises
    ------
    TypeError
        For results that are no numbers.
    ValueError
        For a grid of more dimensions.

    Examples
    --------
    >>> import frictionlab as fl
    >>> sweep = fl.sweep(fl.SliderOnBelt(), lambda m: fl.equilibrium(m).normal_force, {"F": [100, 200]})
    >>> sweep.plot(label="normal force (N)").get_xlabel()
    'preload on the slider $F$ (N)'
    """
    values, text = _numbers(sweep), sweep.function if label is None else label
    names, starts = list(sweep.over), sweep.labels() or [""]
    values = values.reshape(*(len(at) for at in sweep.over.values()), len(starts))
    if len(names) > 2 or (len(names) == 2 and len(starts) > 1):
        raise ValueError(
            f"a sweep must have one parameter, or two and one initial state, to be drawn, got "
            f"{', '.join(names)} and {len(starts)} states: draw parts of sweep.to_array()"
        )
    ax = axes_or_new(ax)
    ax.set_xlabel(parameter_label(sweep.model, names[0]))
    if len(names) == 1:
        return restyle(_draw_curves(sweep.over[names[0]], values, starts, text, ax), line)
    ax.set_ylabel(parameter_label(sweep.model, names[1]))
    mesh = ax.pcolormesh(*sweep.over.values(), values[..., 0].T, shading="nearest", rasterized=True)
    ax.figure.colorbar(mesh, ax=ax, label=text)
    return restyle([mesh], line)


def _numbers(sweep: Sweep) -> np.ndarray:
    try:
        return sweep.to_array()
    except (TypeError, ValueError) as error:
        raise TypeError(
            f"results must be numbers to be drawn ({error}): let the function return a number"
        ) from error


def _draw_curves(at: np.ndarray, values: np.ndarray, starts: list[str], label: str, ax: Axes) -> list[Artist]:
    lines: list[Artist] = []
    for i, start in enumerate(starts):
        style: dict[str, Any] = {"marker": "."} | line_style(i, ax)
        lines += ax.plot(at, values[:, i], label=start or None, **style)
    ax.set_ylabel(label)
    if len(starts) > 1:
        legend_beside(ax)
    return lines
