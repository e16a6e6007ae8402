"""A run at a glance: `fl.plot_run`, four panels; a coordinate against its rate, coloured by mode; the
amplitude spectrum of a state; and checks: energies and the works that changed them, the balance of
:func:`frictionlab.energy_audit`, and what a verification found.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import cycle
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.patheffects import Normal, Stroke
from matplotlib.text import Annotation
from matplotlib.ticker import MaxNLocator

from frictionlab.analysis.motion_scales import (
    MAX_SAMPLES,
    MIN_LINES,
    OVERSAMPLING,
    Spectrum,
    amplitude_spectrum,
    heard_state,
    highest_frequency,
    period_of_run,
)
from frictionlab.analysis.verify import TRUSTED_DEVIATION
from frictionlab.hybrid.accuracy import largest_sound_defect
from frictionlab.hybrid.kernels.jets import MACHINE_EPSILON
from frictionlab.plotting.appearance import (
    BLACK,
    BLUE,
    DASHED,
    ENERGY_COLOURS,
    HALO_WIDTH,
    LEGEND_SHADE,
    SPARE_COLOURS,
    VERMILLION,
    WORK_COLOURS,
    background,
    crowding,
    font_size,
    in_print,
    ink,
    legible,
    line_width,
    marker_size,
    mode_fills,
    mode_lines,
    pen,
    whole_names,
)
from frictionlab.plotting.figure import (
    axes_or_new,
    check_figure,
    first_handles,
    legend_below,
    legend_beside,
    new_figure,
    restyle,
    set_long_title,
    set_title,
)
from frictionlab.plotting.labels import state_label, state_with_unit, with_unit
from frictionlab.plotting.time_histories import (
    DEFAULT_WINDOW,
    Array,
    MovingPeriods,
    Window,
    check_run,
    check_run_with_two_states,
    force_outputs,
    plot_contact_forces,
    plot_displacements,
    plot_rates,
    sample_times,
    window_limits,
    window_text,
)
from frictionlab.plotting.turns import cut_at_turns, tick_turns, turning_angles
from frictionlab.presentation import output_unit, unit_of_state
from frictionlab.validation import abbreviate, check_choice, check_number, explains_keywords

if TYPE_CHECKING:
    from frictionlab.analysis.energy_audit import EnergyAudit
    from frictionlab.analysis.verify import Verification
    from frictionlab.hybrid.trajectory import Trajectory

PHASE_PLANE_WINDOW = MovingPeriods(20.0)  # long enough to tell a cycle that closes from one that does not
DECADES = 5
SPECTROGRAM_DECADES = 4  # 80 dB
SIZE, FONT_SIZE = (12.0, 7.0), 9.0  # inches, points
MOST_IN_LEGEND = 6  # modes on sides of the borders of laws in pieces
SHORTEST_LABELLED = 0.02  # of the size of a panel
LABEL_DISTANCE = 5.0  # points between a line and its name
LONGEST_TITLE = 400  # characters of a model that are shown


def plot_phase_plane(
    run: Trajectory,
    ax: Axes | None = None,
    *,
    name: str | None = None,
    window: Window = PHASE_PLANE_WINDOW,
    **line: Any,
) -> list[Line2D]:
    """Draw a coordinate against its rate, coloured by mode; an angle that turns modulo a turn.

    Of an automaton without coordinates a state is drawn against the next one.

    Parameters
    ----------
    run : Trajectory
    ax : Axes or None
        None draws into a new figure, ``lines[0].axes.figure``.
    name : str or None
        The coordinate, or state; None takes the first.
    window : float, (float, float) or None
        Seconds at the end, start and end time, or None for the whole run; by default some twenty periods.
    **line
        Properties of matplotlib's Line2D for all lines: color, linewidth, alpha ...

    Returns
    -------
    list of Line2D
        One line for every mode that occurs, broken (NaN) where the run is in other modes.

    Raises
    ------
    TypeError
        If `run` is not a Trajectory.
    ValueError
        For a name that is not a coordinate, a run of a single state, or a window outside the run.
    """
    check_run_with_two_states(run)
    state: str = run.automaton.shown_state if name is None else name
    check_choice("name", state, run.automaton.shown_states)
    start, stop = window_limits(run, window)
    ax = axes_or_new(ax, (5.0, 4.5))
    t = sample_times(start, stop, 12001)
    against = run.automaton.drawn_against(state)
    states = run(t)[:, [run.names.index(state), run.names.index(against)]]
    here = run.modes_at(t)
    lines, turns = [], state in turning_angles(run.automaton)
    for mode, pen_of_mode in mode_lines(run, ax).items():
        x, rate = _masked_states(states, here == mode)
        if not np.isnan(x).all():
            x, rate = cut_at_turns(x, rate) if turns else (x, rate)
            lines += ax.plot(x, rate, label=mode, **pen_of_mode)
    title = f"Phase plane of {state_label(state)}, {window_text(run, start, stop)}"
    label_phase_plane(run, ax, state, title)
    if turns:
        tick_turns(ax.xaxis)
    if isinstance(ax.xaxis.get_major_locator(), MaxNLocator):
        ax.locator_params(axis="x", nbins=round(6 / crowding()))  # small numbers have long labels
    return restyle(lines, line)


def label_modes(ax: Axes) -> list[Annotation]:
    """Write the name of each mode, as stick and slip, beside its line in a phase plane, in place of a legend.

    A name stands once, at the longest stretch of its line.  A mode whose longest stretch is shorter than a
    fiftieth of the panel, as the flights of chatter, gets none.

    Parameters
    ----------
    ax : Axes
        With the lines of :func:`plot_phase_plane`, or of an orbit or a steady state.

    Returns
    -------
    list of Annotation

    Examples
    --------
    >>> import frictionlab as fl
    >>> orbit = fl.periodic_orbit(fl.MassOnBelt(), fl.simulate(fl.MassOnBelt(), 30.0))
    >>> [text.get_text() for text in fl.label_modes(orbit.plot())]
    ['stick', 'slip+']
    """
    if not isinstance(ax, Axes):
        raise TypeError(
            f"ax must be axes of matplotlib, got {abbreviate(ax)}: write fl.label_modes(orbit.plot())"
        )
    ax.autoscale_view()  # else matplotlib finds the limits when they are first asked for
    curves = {line: _longest_stretch(line) for line in ax.lines if not str(line.get_label()).startswith("_")}
    curves = {line: way for line, way in curves.items() if _length(way) > SHORTEST_LABELLED}
    if not curves:
        return []
    middle = np.nanmean(np.concatenate(list(curves.values())), axis=0)
    texts = [_label_inside(line, way, middle) for line, way in curves.items()]
    figure: Any = ax.figure
    for legend in (ax.get_legend(), *(figure.legends if figure.axes == [ax] else ())):
        if legend is not None:
            legend.remove()
    return texts


def _longest_stretch(line: Line2D) -> Array:
    """Points (N, 2) of the longest part of a line without a break, as shares of the panel."""
    ax: Any = line.axes
    points = ax.transAxes.inverted().transform(ax.transData.transform(line.get_xydata()))
    breaks = np.flatnonzero(np.isnan(points).any(axis=1))
    return max(np.split(points, breaks), key=_length, default=points)


def _length(points: Array) -> float:
    steps = np.diff(points[~np.isnan(points).any(axis=1)], axis=0)
    return float(np.hypot(*steps.T).sum())


def _label_inside(line: Line2D, way: Array, middle: Array) -> Annotation:
    """The label of a line at the middle of a stretch of it, on the side of the middle of all lines."""
    way = way[~np.isnan(way).any(axis=1)]
    along = np.append(0.0, np.hypot(*np.diff(way, axis=0).T).cumsum())
    place = np.array([np.interp(0.5 * along[-1], along, column) for column in way.T])
    i = min(int(np.searchsorted(along, 0.5 * along[-1])), len(way) - 1)
    direction = way[i] - way[max(i - 1, 0)]
    inwards = np.array([-direction[1], direction[0]]) / (np.hypot(*direction) or 1.0)
    inwards *= 1.0 if inwards @ (middle - place) >= 0 else -1.0
    ax: Any = line.axes
    return ax.annotate(
        line.get_label(),
        place,
        xycoords="axes fraction",
        xytext=font_size(LABEL_DISTANCE) * inwards,
        textcoords="offset points",
        ha="left" if inwards[0] > 0.3 else "right" if inwards[0] < -0.3 else "center",
        va="bottom" if inwards[1] > 0.3 else "top" if inwards[1] < -0.3 else "center",
        color=ink(ax),
        path_effects=[Stroke(linewidth=2.0 * HALO_WIDTH, foreground=background(ax)), Normal()],
        annotation_clip=False,
    )


def label_phase_plane(run: Trajectory, ax: Axes, name: str, title: str) -> None:
    """Label the axes with a coordinate and its rate, or with a state and the next."""
    automaton = run.automaton
    against = f"{name}'" if automaton.coordinates else automaton.drawn_against(name)
    x, rate = (state_with_unit(run.source, each) for each in (name, against))
    ax.set(xlabel=x, ylabel=rate)
    set_title(ax, title)


def _masked_states(states: np.ndarray, samples: np.ndarray) -> np.ndarray:
    """The two columns, NaN outside the chosen samples and the one after each, so that lines meet."""
    with_next = samples | np.append(False, samples[:-1])
    return np.where(with_next[:, None], states, np.nan).T


def plot_spectrum(
    run: Trajectory,
    ax: Axes | None = None,
    *,
    name: str | None = None,
    f_max: float | None = None,
    **line: Any,
) -> list[Line2D]:
    """Draw the amplitude spectrum of a state over the second half of a run.

    Parameters
    ----------
    run : Trajectory
    ax : Axes or None
        None draws into a new figure.
    name : str or None
        The state; None takes the first coordinate, or its rate if it may turn for ever.
    f_max : float or None
        Right end of the frequency axis, Hz; None takes about six times the model's own frequency.
    **line
        Properties of matplotlib's Line2D for all lines: color, linewidth, alpha ...

    Returns
    -------
    list of Line2D
        The spectrum; empty where the run is too short for one, as the panel then says.
    """
    check_run(run)
    state = heard_state(run) if name is None else name
    f_max = f_max or highest_frequency(period_of_run(run))
    spectrum = amplitude_spectrum(run, state, f_max=f_max)
    ax = axes_or_new(ax)
    if spectrum is None:
        _label_spectrum(ax, state_with_unit(run.source, state), f_max)
        set_title(ax, f"Spectrum of {state_label(state)}")
        ax.text(
            0.5, 0.5, "the run is too short\nfor a spectrum", ha="center", va="center", transform=ax.transAxes
        )
        return restyle([], line)
    lines = plot_amplitudes(spectrum, ax)
    ax.set_xlim(0, f_max)
    return restyle(lines, line)


def plot_spectrogram(
    run: Trajectory,
    ax: Axes | None = None,
    *,
    name: str | None = None,
    f_max: float | None = None,
    window: float | None = None,
) -> QuadMesh:
    """Draw how the spectrum of a state or an output changes in time, as along a ramp.

    The dense output is sampled evenly and goes through a short-time Fourier transform with a Hann window,
    each slice without its mean.  A sine of amplitude a has a line of 20 log10(a) dB, where the window holds a
    whole number of its periods.

    Parameters
    ----------
    run : Trajectory
    ax : Axes or None
        None draws into a new figure.
    name : str or None
        The state, e.g. "x1" or "x1'", or the output, e.g. "friction_force"; None takes the first state.
    f_max : float or None
        Highest frequency, Hz; None takes about six times the model's own.
    window : float or None
        Length of the window (s), one over which is the resolution in Hz; None takes a tenth of the run, or
        of a short one five periods of f_max.

    Returns
    -------
    QuadMesh

    Raises
    ------
    ValueError
        For an unknown name, a window that resolves fewer than five lines or is longer than half the run, or
        one of more samples than fit.

    Examples
    --------
    >>> import frictionlab as fl
    >>> run = fl.simulate(fl.BrakedOscillator(), 100.0)
    >>> mesh = fl.plot_spectrogram(run, name="x'", window=20.0)
    >>> mesh.axes.get_ylabel()
    'frequency (Hz)'
    """
    from scipy.signal import ShortTimeFFT
    from scipy.signal.windows import hann

    check_run(run)
    what: str = run.automaton.shown_state if name is None else name
    check_choice("name", what, (*run.names, *run.automaton.outputs))
    stop, f_max = float(run.raw.t), highest_frequency(period_of_run(run)) if f_max is None else f_max
    highest = float(
        check_number("f_max", f_max, above=0.0, cure="leave it out for six times the model's own")
    )
    length = float(
        check_number(
            "window",
            min(max(stop / 10, MIN_LINES / highest), stop / 2) if window is None else window,
            least=MIN_LINES / highest,
            most=stop / 2,
            cure="it holds five periods of f_max, and is half the run at most; run longer, or raise f_max",
        )
    )
    samples = stop * highest * OVERSAMPLING
    check_number("the number of samples", samples, most=MAX_SAMPLES, cure="lower f_max")
    t = np.linspace(0.0, stop, int(samples) + 1)
    x = run.output(what, t) if what in run.automaton.outputs else run(t)[:, run.names.index(what)]
    rate, size = int(samples) / stop, max(int(length * int(samples) / stop), 2)
    transform = ShortTimeFFT(
        hann(size, sym=False), max(size // 8, 1), rate, fft_mode="onesided2X", scale_to="magnitude"
    )
    inside = transform.lower_border_end[1], transform.upper_border_begin(len(x))[1]  # with whole windows
    amplitudes = np.abs(transform.stft_detrend(x, "constant", p0=inside[0], p1=inside[1]))
    times, near = transform.t(len(x), p0=inside[0], p1=inside[1]), transform.f <= highest
    top = float(amplitudes[near].max()) or 1.0
    decibels = 20.0 * np.log10(np.maximum(amplitudes[near], top * 10.0**-SPECTROGRAM_DECADES))
    ax = axes_or_new(ax)
    mesh = ax.pcolormesh(times, transform.f[near], decibels, shading="nearest", rasterized=True)
    unit = output_unit(what, run.source) if what in run.automaton.outputs else unit_of_state(run.source, what)
    label = f"amplitude of {state_label(what)} (dB re {f'1 {unit}'.strip()})"
    ax.figure.colorbar(mesh, ax=ax, label=label)
    ax.set(xlabel="time (s)", ylabel="frequency (Hz)")
    return mesh


def plot_amplitudes(spectrum: Spectrum, ax: Axes | None = None, **line: Any) -> list[Line2D]:
    """Draw an amplitude spectrum.

    Parameters
    ----------
    spectrum : Spectrum
    ax : Axes or None
        None draws into a new figure.
    **line
        Properties of matplotlib's Line2D for all lines: color, linewidth, alpha ...

    Returns
    -------
    list of Line2D
    """
    ax = axes_or_new(ax)
    lines = ax.plot(spectrum.frequencies, spectrum.amplitudes, **pen(BLACK, 1.0, ax))
    _logarithmic(ax, spectrum.amplitudes)
    _label_spectrum(ax, with_unit(spectrum.name, spectrum.unit), spectrum.frequencies[-1])
    set_long_title(ax, _spectrum_title(spectrum))
    return restyle(lines, line)


def _label_spectrum(ax: Axes, name: str, f_max: float) -> None:
    ax.set(xlabel="frequency (Hz)", ylabel=f"amplitude of {name}", xlim=(0.0, f_max))


def _logarithmic(ax: Axes, amplitudes: Array) -> None:
    top = float(amplitudes.max())
    if top > 0:  # at rest all are zero and have no logarithm
        ax.set_yscale("log")
        ax.set_ylim(top * 10.0**-DECADES, top * 2)


def _spectrum_title(spectrum: Spectrum) -> str:
    digits = max(0, math.ceil(-math.log10(spectrum.resolution)))
    strongest = (
        f"strongest line {spectrum.strongest:.{digits}f} Hz" if spectrum.amplitudes.any() else "at rest"
    )
    part = f"{spectrum.start:.4g} s to {spectrum.stop:.4g} s, Hann window"
    resolution = f"resolution {spectrum.resolution:.2g} Hz"
    return f"Spectrum of {state_label(spectrum.name)}, {part}\n{resolution}, {strongest}"


@explains_keywords
def plot_run(run: Trajectory, figure: Figure | None = None, *, window: Window = DEFAULT_WINDOW) -> Figure:
    """Draw a run: displacements and contact forces against time, phase plane and spectrum of a coordinate.

    Phase plane and spectrum are of the first coordinate.  Without contact forces
    the rates are drawn instead.  Of an automaton without coordinates the states are drawn, and one against
    the next if there are two.

    Parameters
    ----------
    run : Trajectory
    figure : Figure or None
        Where to draw; None makes a new figure that belongs to no window.
    window : float, (float, float) or None
        What the panels over time show: seconds at the end, start and end time, or None for the whole run;
        by default some eight periods, or what moved before them where they show nothing.

    Returns
    -------
    Figure
        Its axes are displacements, phase plane, forces, spectrum, in this order, those that there are; where
        an angle has an axis beside the displacements, that comes last.  A notebook shows the figure.

    Examples
    --------
    >>> import frictionlab as fl
    >>> figure = fl.plot_run(fl.simulate(fl.SliderOnBelt(mu_k=1.4), 0.3))
    >>> [ax.get_xlabel() for ax in figure.axes[:4]]
    ['time (s)', '$x_{1}$ (m)', 'time (s)', 'frequency (Hz)']
    """
    check_run(run)
    check_figure(figure)
    own = figure is None
    figure = new_figure(*SIZE) if figure is None else figure
    panels = figure.subplot_mosaic(_places(run), width_ratios=(1.5, 1))
    displacements, phase = panels["displacements"], panels.get("phase plane")
    coordinates = plot_displacements(run, displacements, window=window)
    # An angle has its axis next to the panel; the legends stand to the right of it.
    right = 1.0 + 0.17 * crowding() if any(line.axes is not displacements for line in coordinates) else 1.0
    _legend_right_of(displacements, coordinates, right)
    if phase is not None:
        plot_phase_plane(run, phase)
    if "forces" in panels:
        draw = plot_contact_forces if force_outputs(run.automaton, run.source) else plot_rates
        _legend_right_of(panels["forces"], draw(run, panels["forces"], window=window), right)
    plot_spectrum(run, panels["spectrum"])
    for ax in panels.values():
        # In panels this wide no title meets the power of ten above an axis: to check takes 10 % of the time.
        place = {"y": 1.0} if own and ax is not phase else {}
        ax.set_title(ax.get_title(), fontsize=font_size(FONT_SIZE + 1) / crowding(), **place)
    _title(figure, run)
    return figure


def _places(run: Trajectory) -> list[Any]:
    """Which panels there are of a run, and where: one that has no partner takes its place too."""
    has_lower = run.automaton.coordinates or force_outputs(run.automaton, run.source)
    beside = "phase plane" if len(run.names) > 1 else "spectrum"
    return [["displacements", beside], ["forces" if has_lower else "displacements", "spectrum"]]


def _legend_right_of(ax: Axes, lines: list[Line2D], x: float) -> None:
    """A legend of the lines to the right of the panel, where it covers nothing."""
    place: dict[str, Any] = {"loc": "center left", "bbox_to_anchor": (x, 0.5)}
    ax.legend(handles=first_handles(lines), frameon=False, fontsize=font_size(FONT_SIZE), **place)


def _title(figure: Figure, run: Trajectory) -> None:
    fills = mode_fills(run, shade=LEGEND_SHADE)
    # Modes that last a few thousandths of the time are listed too, though too short to be visible.
    modes = [name for name, seconds in run.time_in_mode.items() if seconds > 0]
    labels = _modes_in_legend(run, modes)
    edge = {"linewidth": line_width(0.5)} if in_print() else {}
    handles = [Patch(label=label, **fills[name] | edge) for label, name in labels.items()]
    what = "run" if run.source is None else repr(run.source)
    if len(what) > LONGEST_TITLE:
        what = type(run.source).__name__
    state = "" if run.status.ok else f" ({run.status.name.lower().replace('_', ' ')})"
    about = run.description.get("method", {})
    method = about.get("integrator", about.get("name", ""))
    size = font_size(FONT_SIZE + 3) / crowding()
    if not in_print():
        figure.suptitle(f"{what}, {run.raw.t:.4g} s, {method}{state}", fontsize=size, wrap=True)
    legend_below(figure, handles)


def _modes_in_legend(run: Trajectory, modes: list[str]) -> dict[str, str]:
    """Labels, each with a mode: many that differ in the pieces of laws are listed as one, or in part."""
    wholes = whole_names(run)
    if len(modes) <= MOST_IN_LEGEND or all(name == whole for name, whole in wholes.items()):
        return {name: name for name in modes}
    labels: dict[str, str] = {}
    for name in modes:
        labels.setdefault(wholes[name], name)
    return labels if len(labels) > 1 else {name: name for name in modes[:MOST_IN_LEGEND]}


def plot_energies(audit: EnergyAudit, ax: Axes | None = None, **line: Any) -> list[Line2D]:
    """Draw every energy of an audit against time, and their sum, dashed.

    Parameters
    ----------
    audit : EnergyAudit
    ax : Axes or None
        None draws into a new figure, ``lines[0].axes.figure``.
    **line
        Properties of matplotlib's Line2D for all lines: color, linewidth, alpha ...

    Returns
    -------
    list of Line2D
        One for every energy, then the sum.

    Examples
    --------
    >>> import frictionlab as fl
    >>> audit = fl.energy_audit(fl.simulate(fl.SliderOnBelt(mu_k=1.4), 0.2))
    >>> [line.get_label() for line in plot_energies(audit)]
    ['kinetic', 'springs', 'preload', 'contact', 'sum']
    """
    return restyle(
        _draw_contributions(
            audit, ax, audit.energies, ENERGY_COLOURS, audit.total, f"energy ({audit.unit})", "Energies"
        ),
        line,
    )


def plot_works(audit: EnergyAudit, ax: Axes | None = None, **line: Any) -> list[Line2D]:
    """Draw the work of every contribution from 0 to t, and dashed their sum, the energy that the system
    gained.  What is rounding is left out.

    Parameters
    ----------
    audit : EnergyAudit
    ax : Axes or None
        None draws into a new figure, ``lines[0].axes.figure``.
    **line
        Properties of matplotlib's Line2D for all lines: color, linewidth, alpha ...

    Returns
    -------
    list of Line2D
        One for every contribution that is more than rounding, then the sum.

    Examples
    --------
    >>> import frictionlab as fl
    >>> audit = fl.energy_audit(fl.simulate(fl.SliderOnBelt(mu_k=1.4), 0.2))
    >>> [line.get_label() for line in plot_works(audit)]
    ['belt drive', 'friction', 'dampers', 'impacts', 'moving load', 'sum']
    """
    title = f"Work since the start; the balance misses {audit.error:.1g} of the energy turned over"
    return restyle(
        _draw_contributions(
            audit,
            ax,
            audit.works_above_rounding,
            WORK_COLOURS,
            audit.total - audit.total[0],
            f"work from 0 to $t$ ({audit.unit})",
            title,
        ),
        line,
    )


def _draw_contributions(
    audit: EnergyAudit,
    ax: Axes | None,
    parts: Mapping[str, Array],
    colours: Mapping[str, str],
    total: Array,
    ylabel: str,
    title: str,
) -> list[Line2D]:
    ax = axes_or_new(ax, (8.0, 4.0))
    colours_of_parts, lines = {colours.get(name) for name in parts}, []
    spare = cycle(colour for colour in SPARE_COLOURS if colour not in colours_of_parts)
    for name, values in parts.items():
        colour = colours.get(name) or next(spare)
        lines += ax.plot(audit.t, values, label=name, **pen(colour, ax=ax))
    lines += ax.plot(audit.t, total, linestyle=DASHED, label="sum", **pen(BLACK, ax=ax))
    ax.set(xlabel="time (s)", ylabel=ylabel)
    set_long_title(ax, title)
    ax.margins(x=0)
    legend_beside(ax)
    return lines


def plot_verification(verification: Verification, ax: Axes | None = None) -> list[Line2D]:
    """Draw the deviation from other runs and the defect in each mode, with the largest values trusted.

    Parameters
    ----------
    verification : Verification
    ax : Axes or None
        None draws into a new figure, ``lines[0].axes.figure``.

    Returns
    -------
    list of Line2D
        What was found, and the limits.  Values below the machine epsilon are drawn there.  Defects of methods
        without a tolerance have no limit.

    Examples
    --------
    >>> import frictionlab as fl
    >>> verification = fl.verify(fl.SliderOnBelt(mu_k=1.4).without("geometry"), 0.5)
    >>> [line.get_label() for line in plot_verification(verification)]
    ['found', 'largest trusted']
    """
    ax = axes_or_new(ax)
    tol = verification.run.description["method"].get("tol")
    sound = np.nan if tol is None else largest_sound_defect(tol)
    rows = {"deviation from other runs": (verification.error, TRUSTED_DEVIATION)}
    rows |= {f"defect in mode {mode}": (size, sound) for mode, size in verification.defect.items()}
    sizes, limits = np.array(list(rows.values())).T
    places = np.arange(len(rows))
    lines = ax.plot(np.maximum(sizes, MACHINE_EPSILON), places, "o", color=legible(BLUE, ax), label="found")
    limit: dict[str, Any] = {"markersize": marker_size(16.0), "markeredgewidth": 2.0}
    limit["color"] = legible(VERMILLION, ax)
    lines += ax.plot(limits, places, "|", label="largest trusted", **limit)
    ax.set_yticks(places, list(rows))
    ax.set(xscale="log", xlabel="share of the motion's size", ylim=(len(rows) - 0.5, -0.5))
    set_title(ax, _verdict_title(verification))
    ax.grid(axis="y", linewidth=0.5)
    legend_beside(ax)
    return lines


def _verdict_title(verification: Verification) -> str:
    trust = f"To be trusted up to t = {verification.until:.4g} s" if verification.ok else "Not to be trusted"
    return f"{trust}; the events {'agree' if verification.events_agree else 'differ'}"
