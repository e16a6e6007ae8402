"""`fl.listen`: a run as sound."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from frictionlab.analysis.motion_scales import period_of_run
from frictionlab.file_writing import write_file
from frictionlab.hybrid.trajectory import check_run
from frictionlab.interruption import progress_bar
from frictionlab.models.model import Tone, tone_of
from frictionlab.plotting.time_histories import SAMPLING_RTOL, Array, Window, window_limits
from frictionlab.validation import check_choice, check_number, check_path

if TYPE_CHECKING:
    from frictionlab.hybrid.trajectory import Trajectory

PEAK_LEVEL = 0.9  # of full scale: no player clips it
FADE_TIME, MOST_FADED = 0.01, 0.1  # s and share of the sound at each end: a cut waveform clicks
# oversampling: stick-slip has corners and impacts are jumps, whose high harmonics must not be aliased
OVERSAMPLING = 8
SILENCE_LEVEL = 1e-9  # a signal that varies by less than this share of its size is rounding, not sound
MAX_SAMPLES = 2e7  # of a sound: some eight minutes, computed in as much time
MAX_RATE = 1_000_000  # samples a second, more than any player takes
MIN_SAMPLES = 16  # samples
CHUNK_SAMPLES = 200_000  # samples computed at a time


@dataclass(frozen=True, eq=False)
class Sound:
    """Samples of a sound; a notebook shows a player.

    Parameters
    ----------
    samples : (N,) array
        Within -1 to 1.
    rate : int
        Samples a second.
    signal : str
        The quantity heard.
    pitch : float
        Factor by which all frequencies are higher than in the motion, which is played so much faster.
    window : (float, float)
        Start and end (s) of the part of the run that is heard.
    """

    samples: Array
    rate: int
    signal: str
    pitch: float
    window: tuple[float, float]

    @property
    def duration(self) -> float:
        """Length of the sound, s."""
        return len(self.samples) / self.rate

    @property
    def audio(self) -> Any:
        """The player, an ``IPython.display.Audio``."""
        try:
            from IPython.display import Audio
        except ModuleNotFoundError as error:
            cure = "pip install ipython, or write a file with save()"
            raise ImportError(f"a sound is played by IPython, which is not installed: {cure}") from error
        return Audio(self.samples, rate=self.rate, normalize=False)

    def save(self, path: str | Path) -> Path:
        """Write a WAV file of 16 bits; returns its path."""
        from scipy.io import wavfile

        path = check_path("path", path, (".wav",))
        with write_file(path) as beside:
            wavfile.write(beside, self.rate, np.round(self.samples * np.iinfo(np.int16).max).astype(np.int16))
        return path

    def __repr__(self) -> str:
        start, stop = self.window
        what = f"{self.signal}, {start:.4g} s to {stop:.4g} s of the run in {self.duration:.3g} s"
        return f"Sound({what}, pitch {self.pitch:g} times that of the motion, {self.rate} Hz)"

    def _repr_html_(self) -> str:
        return f"{self.audio._repr_html_()}<small>{self!r}</small>"


def listen(
    run: Trajectory,
    signal: str | None = None,
    *,
    window: Window = None,
    pitch: float | None = None,
    rate: int = 44100,
) -> Sound:
    """Make a quantity of a run audible.

    The quantity less its mean, played `pitch` times faster: the paper's system vibrates at some 11 Hz, too
    low to hear.  Low-pass filtered, faded in and out, scaled to nine tenths of full scale.

    Parameters
    ----------
    run : Trajectory
    signal : str or None
        An output, such as "relative_velocity", "friction_force", "normal_force", or a state, such as "x1'".
        None takes that of the model's `sound`: the relative velocity, or the first coordinate's rate.
    window : float, (float, float) or None
        Seconds at the end, start and end time, or None for the whole run.
    pitch : float or None
        How much faster: 20 takes 11 Hz to 220 Hz, and 20 s of a run last 1 s.  None takes that of the model's
        `sound`, by which the model's period is heard as 200 Hz.
    rate : int
        Samples a second of the sound.

    Returns
    -------
    Sound
        A notebook shows a player; ``.save("run.wav")`` writes a file.

    Raises
    ------
    TypeError
        If `run` is not a Trajectory.
    ValueError
        For an unknown signal, a window outside the run or too short, or a pitch or rate not above zero.

    Examples
    --------
    >>> import frictionlab as fl
    >>> run = fl.simulate(fl.SliderOnBelt(mu_k=1.4), 4.0)
    >>> fl.listen(run, "friction_force")
    Sound(friction_force, 0 s to 4 s of the run in 0.2 s, pitch 20 times that of the motion, 44100 Hz)
    """
    from scipy.signal import resample_poly, windows

    check_run(run)
    usual: Tone = getattr(run.source, "sound", None) or tone_of(run.automaton, period_of_run(run))
    signal, pitch = usual.signal if signal is None else signal, usual.pitch if pitch is None else pitch
    check_choice("signal", signal, (*run.automaton.outputs, *run.names))
    pitch = float(check_number("pitch", pitch, above=0.0, cure="20 takes 11 Hz to 220 Hz"))
    rate = check_number("rate", rate, integer=True, least=1, most=MAX_RATE, cure="44100 is that of a CD")
    start, stop = window_limits(run, window)
    seconds = (stop - start) / pitch
    if not seconds * rate <= MAX_SAMPLES:
        raise ValueError(
            f"the sound must have at most {MAX_SAMPLES:.0e} samples, got {seconds:.3g} s of {rate} a second: "
            "take a shorter window or a larger pitch"
        )
    count = int(seconds * rate * (1 + SAMPLING_RTOL))
    if count < MIN_SAMPLES:
        cure = "take a longer window or a smaller pitch"
        raise ValueError(
            f"window must last at least {MIN_SAMPLES * pitch / rate:.3g} s, got {stop - start:g} s: {cure}"
        )
    fine = start + np.arange(count * OVERSAMPLING) * (pitch / rate / OVERSAMPLING)
    samples = resample_poly(_signal_samples(run, signal, np.minimum(fine, stop)), 1, OVERSAMPLING)
    faded = samples * windows.tukey(count, 2 * min(FADE_TIME * rate / count, MOST_FADED))
    scaled = PEAK_LEVEL * faded / (np.abs(faded).max() or 1.0)
    return Sound(scaled, rate, signal, pitch, (start, stop))


def _signal_samples(run: Trajectory, signal: str, t: Array) -> Array:
    """The signal less its mean; zero where it does not vary beyond rounding."""
    # In parts, as all states at all samples would fill the memory.
    parts = np.array_split(t, len(t) // CHUNK_SAMPLES + 1)
    x = np.concatenate([_signal_at(run, signal, part) for part in progress_bar(parts, desc="listen")])
    return x - x.mean() if np.ptp(x) > SILENCE_LEVEL * np.abs(x).max() else np.zeros_like(x)


def _signal_at(run: Trajectory, signal: str, t: Array) -> Array:
    return run(t)[:, run.names.index(signal)] if signal in run.names else run.output(signal, t)
