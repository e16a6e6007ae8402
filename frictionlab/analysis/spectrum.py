"""Amplitude spectrum of a state."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionlab.presentation import Drawable, count
from frictionlab.validation import check_choice

from .motion_scales import oscillation_period, rounded_period

Array = NDArray[np.float64]
HARMONICS_SHOWN = 6.0  # multiples of the model's own frequency that are shown
MAX_PERIODS = (
    # periods transformed at most: that resolves a thousandth of the frequency, more than a picture shows
    1000.0
)
# samples per period of f_max, so that the high harmonics of kinks are not aliased into view
OVERSAMPLING = 16
MIN_LINES = 5


class Spectrum(NamedTuple):
    """Amplitudes of the state `name` at frequencies (Hz) `resolution` apart, from `start` to `stop` (s)."""

    frequencies: Array
    amplitudes: Array
    resolution: float
    start: float
    stop: float
    name: str = ""

    drawn_by = "plot_amplitudes"
    several_axes = False
    plot = Drawable.plot

    def __repr__(self) -> str:
        lines = f"{count(len(self.frequencies), 'line')} {self.resolution:.2g} Hz apart"
        return f"Spectrum({self.name}, {lines}, strongest {self.strongest:.4g} Hz)"

    @property
    def strongest(self) -> float:
        """Frequency (Hz) of the largest amplitude."""
        return float(self.frequencies[np.argmax(self.amplitudes)])

    def peaks(self, share: float = 0.05) -> tuple[Array, Array]:
        """Frequencies (Hz) and amplitudes of the local maxima above a share of the largest, strongest first.

        A peak between two lines is interpolated by the ratio of the two highest, which the Hann window
        determines: frequencies are right to some hundredths of the resolution, and amplitudes to some
        thousandths, where other peaks are several lines away.
        """
        a = self.amplitudes
        i = 1 + np.flatnonzero((a[1:-1] > a[:-2]) & (a[1:-1] >= a[2:]) & (a[1:-1] > share * a.max()))
        ratio = np.maximum(a[i - 1], a[i + 1]) / a[i]
        aside = np.clip((2 * ratio - 1) / (1 + ratio), 0.0, 0.5)
        heights = a[i] * (1 - aside**2) / np.sinc(aside)
        order = np.argsort(-heights)
        lines = self.frequencies[i] + np.where(a[i + 1] > a[i - 1], aside, -aside) * self.resolution
        return lines[order], heights[order]


def amplitude_spectrum(
    run: Any, name: str | None = None, *, f_max: float | None = None, start: float | None = None
) -> Spectrum | None:
    """Amplitude spectrum of a state, with a Hann window and without the mean.

    A sine of amplitude a has a line of height a, where a whole number of its periods is transformed.

    Parameters
    ----------
    run : Trajectory
    name : str or None
        The state, e.g. "x1" or "x1'"; None takes the first.
    f_max : float or None
        Highest frequency kept, Hz; None takes six times about the model's own, of the slider on a belt 60 Hz.
    start : float or None
        Start (s) of the part that is transformed, which lasts to the end of the run; None takes the second
        half, but no more than some thousand periods.

    Returns
    -------
    Spectrum or None
        None where the part is too short to resolve five lines up to `f_max`.
    """
    shown: str = run.names[0] if name is None else name
    check_choice("name", shown, run.names)
    f_max = f_max or highest_frequency(run.source)
    stop = float(run.raw.t)
    length = min(stop / 2, MAX_PERIODS * oscillation_period(run.source)) if start is None else stop - start
    if length * f_max < MIN_LINES:
        return None
    count = int(np.ceil(length * f_max * OVERSAMPLING))
    t = np.clip(stop - length + np.arange(count) * (length / count), 0.0, stop)
    x = run(t)[:, run.names.index(shown)]
    window = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(count) / count)
    # Subtract the mean weighted by the window, so that nothing of it is left in the first lines.
    amplitudes = np.abs(np.fft.rfft((x - np.average(x, weights=window)) * window)) * (2 / window.sum())
    frequencies = np.arange(len(amplitudes)) / length
    kept = frequencies <= f_max
    return Spectrum(frequencies[kept], amplitudes[kept], 1 / length, stop - length, stop, shown)


def highest_frequency(source: Any) -> float:
    """The highest frequency (Hz) that a spectrum of a model shows."""
    return HARMONICS_SHOWN / rounded_period(source)
