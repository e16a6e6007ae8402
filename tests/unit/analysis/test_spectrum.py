"""Peaks of a spectrum against sines whose frequency and amplitude are known."""

import numpy as np
import pytest
import sympy as sp

import frictionlab as fl
from frictionlab.analysis.motion_scales import amplitude_spectrum
from tests.helpers.automata import automaton

SECONDS = 10.0


def sines(*pairs, mean=0.0):
    """A run whose first state is a sum of sines: (frequency in Hz, amplitude)."""
    states, flow, start = [sp.Symbol("x")], [sp.S.Zero], [mean + sum(a for _, a in pairs)]
    for i, (frequency, amplitude) in enumerate(pairs):
        c, s = sp.symbols(f"c{i} s{i}")
        w = 2 * np.pi * frequency
        flow[0] -= amplitude * w * s
        states, flow, start = [*states, c, s], [*flow, -w * s, w * c], [*start, 1.0, 0.0]
    run = automaton(fl.Mode("only", tuple(flow)), states=tuple(states), coordinates=0)
    return fl.solve(run, SECONDS, x0=start, progress=False)


@pytest.mark.parametrize("frequency", [3.0, 7.23, 11.05, 11.0999, 33.333])
def test_a_sine_is_found_to_a_small_part_of_the_resolution(frequency):
    spectrum = amplitude_spectrum(sines((frequency, 2e-3), mean=0.7), "x", start=0.0)
    frequencies, heights = spectrum.peaks()
    assert spectrum.resolution == pytest.approx(1 / SECONDS)
    assert len(frequencies) == 1
    assert abs(frequencies[0] - frequency) < 0.01 * spectrum.resolution
    assert heights[0] == pytest.approx(2e-3, rel=2e-3)
    assert abs(spectrum.strongest - frequency) <= 0.5 * spectrum.resolution + 1e-12


def test_several_sines_come_in_the_order_of_their_amplitudes():
    known = [(5.03, 1.0), (11.07, 3.0), (22.1, 0.2)]
    spectrum = amplitude_spectrum(sines(*known), "x", start=0.0)
    frequencies, heights = spectrum.peaks()
    assert np.allclose(frequencies, [11.07, 5.03, 22.1], atol=0.01 * spectrum.resolution)
    assert np.allclose(heights, [3.0, 1.0, 0.2], rtol=5e-3)
    assert np.allclose(spectrum.peaks(share=0.5)[0], [11.07], atol=1e-3)


def test_a_constant_has_no_peaks_and_a_short_run_no_spectrum():
    frequencies, _ = amplitude_spectrum(sines((5.0, 0.0), mean=1.0), "x", start=0.0).peaks()
    assert len(frequencies) == 0
    assert amplitude_spectrum(sines((5.0, 1.0)), "x", f_max=0.1, start=0.0) is None


def test_the_part_that_is_transformed_is_stated():
    run = sines((5.0, 1.0))
    half = amplitude_spectrum(run, "x")
    assert (half.start, half.stop, half.resolution) == (5.0, 10.0, 0.2)
    assert half.frequencies[-1] <= 60.0
