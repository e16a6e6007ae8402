"""Amplitude spectrum of a state over the second half of a run."""

from __future__ import annotations

import math
from typing import Any

from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from frictionlab.analysis.spectrum import Spectrum, amplitude_spectrum, highest_frequency
from frictionlab.plotting.appearance import pen
from frictionlab.plotting.figure import axes_or_new, set_long_title
from frictionlab.plotting.style import BLACK, state_label
from frictionlab.presentation import state_unit

from .time_window import Array, check_run

DECADES = 5


def plot_spectrum(
    run: Any, ax: Axes | None = None, *, name: str | None = None, f_max: float | None = None
) -> list[Line2D]:
    """Draw the amplitude spectrum of a state over the second half of a run.

    Parameters
    ----------
    run : Trajectory
    ax : Axes or None
        None draws into a new figure.
    name : str or None
        The state; None takes the first.
    f_max : float or None
        Right end of the frequency axis, Hz; None takes six times about the model's own frequency.

    Returns
    -------
    list of Line2D
        The spectrum; empty where the run is too short for one, which the panel then says.
    """
    check_run(run)
    shown: str = run.names[0] if name is None else name
    f_max = f_max or highest_frequency(run.source)
    found = amplitude_spectrum(run, shown, f_max=f_max)
    ax = axes_or_new(ax)
    if found is None:
        ax.set(
            xlabel="frequency (Hz)",
            ylabel=f"amplitude of {state_label(shown)} ({state_unit(shown)})",
            xlim=(0, f_max),
        )
        ax.set_title(f"Spectrum of {state_label(shown)}")
        ax.text(
            0.5, 0.5, "the run is too short\nfor a spectrum", ha="center", va="center", transform=ax.transAxes
        )
        return []
    lines = plot_amplitudes(found, ax)
    ax.set_xlim(0, f_max)
    return lines


def plot_amplitudes(found: Spectrum, ax: Axes | None = None) -> list[Line2D]:
    """Draw an amplitude spectrum.

    Parameters
    ----------
    found : Spectrum
    ax : Axes or None
        None draws into a new figure.

    Returns
    -------
    list of Line2D
    """
    ax = axes_or_new(ax)
    lines = ax.plot(found.frequencies, found.amplitudes, **pen(BLACK, 1.0, ax))
    _logarithmic(ax, found.amplitudes)
    ax.set(
        xlabel="frequency (Hz)",
        ylabel=f"amplitude of {state_label(found.name)} ({state_unit(found.name)})",
        xlim=(0.0, found.frequencies[-1]),
    )
    set_long_title(ax, _title(found.name, found))
    return lines


def _logarithmic(ax: Axes, amplitudes: Array) -> None:
    top = float(amplitudes.max())
    if top > 0:  # a state at rest has no logarithm
        ax.set_yscale("log")
        ax.set_ylim(top * 10.0**-DECADES, top * 2)


def _title(name: str, found: Spectrum) -> str:
    digits = max(0, math.ceil(-math.log10(found.resolution)))
    strongest = f"strongest line {found.strongest:.{digits}f} Hz" if found.amplitudes.any() else "at rest"
    part = f"{found.start:.4g} s to {found.stop:.4g} s, Hann window"
    return f"Spectrum of {state_label(name)}, {part}\nresolution {found.resolution:.2g} Hz, {strongest}"
