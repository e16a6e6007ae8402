"""What is heard has the frequencies of the motion times the stated factor."""

import numpy as np
import pytest
from scipy.io import wavfile

import frictionlab as fl

# Without friction and with a bilateral linear contact everything is linear, and the belt's x2 an oscillator
# of its own: frequency sqrt(k4/m) / (2 pi).
FREQUENCY = 11.0


def linear(frequency):
    k4 = (2 * np.pi * frequency) ** 2
    return fl.SliderOnBelt(mu_k=0.0, k4=k4, c4=0.0).without("geometry", "nonsmooth", "cubic")


def swinging(frequency, seconds, slider=0.0):
    """A run in which only x2 moves, or the slider's x1 too."""
    model = linear(frequency)
    q = fl.equilibrium(model).q + np.array([slider, 0.0, 0.01, 0.0])
    return fl.simulate(model, seconds, x0=np.append(q, np.zeros(4)), progress=False)


@pytest.fixture(scope="module")
def run():
    return swinging(FREQUENCY, 20.0)


def spectrum(sound):
    weighted = sound.samples * np.hanning(len(sound.samples))
    return np.fft.rfftfreq(len(weighted), 1 / sound.rate), np.abs(np.fft.rfft(weighted))


def tone(sound):
    """Frequency of the strongest line, between lines by a parabola through the logarithms."""
    f, a = spectrum(sound)
    k = int(a.argmax())
    left, middle, right = np.log(a[k - 1 : k + 2])
    return f[k] + f[1] * (left - right) / (left - 2 * middle + right) / 2


@pytest.mark.parametrize("rate", [44100, 16000])
@pytest.mark.parametrize("pitch", [20.0, 50.0, 33.3])
@pytest.mark.parametrize("signal", ["relative_velocity", "x2"])
def test_the_pitch_is_the_eigenfrequency_times_the_factor(run, signal, pitch, rate):
    sound = fl.listen(run, signal, pitch=pitch, rate=rate)
    assert len(sound.samples) == int(20.0 / pitch * rate)
    assert sound.duration == pytest.approx(20.0 / pitch, abs=1 / rate)
    assert tone(sound) == pytest.approx(FREQUENCY * pitch, rel=2e-4)


def test_a_pure_oscillation_is_a_pure_tone(run):
    f, a = spectrum(fl.listen(run))
    away = np.abs(f - FREQUENCY * 20.0) > 20.0
    assert a[away].max() < 1e-3 * a.max()


def test_the_waveform_is_the_signal(run):
    sound = fl.listen(run, "x2", window=(2.0, 12.0))
    t = 2.0 + np.arange(len(sound.samples)) * sound.pitch / sound.rate
    inner = slice(1000, -1000)  # without the faded ends
    expected = 0.9 * np.cos(2 * np.pi * FREQUENCY * t)
    assert np.abs(sound.samples - expected)[inner].max() < 2e-3


def test_what_is_too_high_is_left_out_instead_of_folded_back():
    high, pitch, rate = 1000.0, 40.0, 44100
    folded = rate - high * pitch
    assert 0.0 < folded < rate / 2 < high * pitch
    sound = fl.listen(swinging(high, 4.0, slider=0.05), pitch=pitch, rate=rate)
    f, a = spectrum(sound)
    # The belt's velocity swings with 63 m/s, the slider's with a few: unfiltered the tone would drown it.
    assert a[np.abs(f - folded) < 50.0].max() < 0.1 * a[f < 1500.0].max()


def test_full_scale_is_nearly_reached_and_the_ends_are_silent(run):
    for signal in ("relative_velocity", "normal_force", "friction_force", "x1'"):
        sound = fl.listen(fl.simulate(fl.SliderOnBelt(mu_k=1.4), 4.0, progress=False), signal)
        assert np.abs(sound.samples).max() == pytest.approx(0.9)
        assert sound.samples[0] == sound.samples[-1] == 0.0
        assert np.abs(sound.samples[:10]).max() < 0.01


def test_a_wav_file_holds_the_samples(run, tmp_path):
    sound = fl.listen(run, rate=22050)
    path = sound.save(tmp_path / "run.wav")
    rate, samples = wavfile.read(path)
    assert rate == 22050
    assert samples.dtype == np.int16
    assert np.abs(samples / 32767 - sound.samples).max() <= 0.5 / 32767 * (1 + 1e-9)


def test_rest_is_silence():
    model = fl.SliderOnBelt(mu_k=0.3).without("nonsmooth")
    x0 = np.append(fl.equilibrium(model).q, np.zeros(5))
    still = fl.listen(fl.simulate(model, 2.0, x0=x0, progress=False), "normal_force")
    assert not still.samples.any()
