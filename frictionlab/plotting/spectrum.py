"""Amplitude spectrum of a state."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from .figure import axes_or_new
from .palette import BLACK, label, unit
from .windows import Array, end_of

F_MAX = 60.0
LONGEST = 100.0  # seconds transformed at most: a resolution of 0.01 Hz is more than a picture shows
OVERSAMPLING = 16  # samples per period of f_max: kinks of the motion must not fold back into view
FEWEST_LINES = 5
DECADES = 5


class Spectrum(NamedTuple):
    """Amplitudes (unit of the state) at frequencies (Hz) `resolution` apart, from `start` to `stop` (s)."""

    frequencies: Array
    amplitudes: Array
    resolution: float
    start: float
    stop: float

    @property
    def strongest(self) -> float:
        """Frequency (Hz) of the largest amplitude."""
        return float(self.frequencies[np.argmax(self.amplitudes)])


def amplitude_spectrum(run: Any, name: str = "x1", *, f_max: float = F_MAX) -> Spectrum | None:
    """Amplitude spectrum of a state over the second half of a run, with a Hann window and without the mean.

    A sine of amplitude a has a line of height a, where its period divides the half.

    Parameters
    ----------
    run : Trajectory
    name : str
        The state, e.g. "x1" or "x1'".
    f_max : float
        Highest frequency kept, Hz.

    Returns
    -------
    Spectrum or None
        None where the half is too short to resolve five lines up to `f_max`.
    """
    stop = end_of(run)
    length = min(stop / 2, LONGEST)
    if length * f_max < FEWEST_LINES:
        return None
    count = int(np.ceil(length * f_max * OVERSAMPLING))
    t = np.clip(stop - length + np.arange(count) * (length / count), 0.0, stop)
    x = run(t)[:, run.names.index(name)]
    window = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(count) / count)
    # Less the mean as the window weighs it, so that nothing of it is left in the first lines.
    amplitudes = np.abs(np.fft.rfft((x - np.average(x, weights=window)) * window)) * (2 / window.sum())
    frequencies = np.arange(len(amplitudes)) / length
    kept = frequencies <= f_max
    return Spectrum(frequencies[kept], amplitudes[kept], 1 / length, stop - length, stop)


def plot_spectrum(
    run: Any, ax: Axes | None = None, *, name: str = "x1", f_max: float = F_MAX
) -> list[Line2D]:
    """Draw the amplitude spectrum of a state over the second half of a run.

    Parameters
    ----------
    run : Trajectory
    ax : Axes or None
        None draws into a new figure.
    name : str
        The state.
    f_max : float
        Right end of the frequency axis, Hz.

    Returns
    -------
    list of Line2D
        The spectrum; empty where the run is too short for one, which the panel then says.
    """
    ax = axes_or_new(ax)
    ax.set(xlabel="frequency (Hz)", ylabel=f"amplitude of {label(name)} ({unit(name)})", xlim=(0, f_max))
    found = amplitude_spectrum(run, name, f_max=f_max)
    if found is None:
        ax.set_title(f"Spectrum of {label(name)}")
        ax.text(
            0.5, 0.5, "the run is too short\nfor a spectrum", ha="center", va="center", transform=ax.transAxes
        )
        return []
    lines = ax.plot(found.frequencies, found.amplitudes, color=BLACK, linewidth=1.0)
    _logarithmic(ax, found.amplitudes)
    ax.set_title(_title(name, found))
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
    return f"Spectrum of {label(name)}, {part}\nresolution {found.resolution:.2g} Hz, {strongest}"
