"""The disc brake of Graebner, Mehrmann, Quraishi, Schroeder and von Wagner (2016), where its matrices are."""

from pathlib import Path

import numpy as np
import pytest

import frictionlab as fl

DATA = Path(__file__).parents[4] / "shared" / "data" / "brake-squeal"
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not DATA.is_dir(), reason=f"the matrices of the brake are not in {DATA}"),
]


def brake(r, window=(0.0, 8000.0)):
    M, D, Y, R, H, K, N, W = (
        DATA / f"{name}00.mat" for name in ("BMLL", "BDLL", "BYLL", "BDIWLL", "BHLL", "BKLL", "BKQLL", "BWLL")
    )
    return fl.Structure(
        M,
        [(1, K), ("r**2 - 1", W)],
        [(1, D), ("1/r - 1", R), (1 / (2 * np.pi * 1600.0), H)],
        gyroscopic=[("r", Y)],
        circulatory=N,
        parameters={"r": r},
        window=window,
    )


def test_unstable_eigenvalues_have_small_residuals():
    for r in (1.0, 5.0, 20.0):
        found = fl.eigenvalues(brake(r))
        assert len(found.growing) >= 3
        assert found.residuals.max() < 1e-8
        assert found.error_estimates.max() < 1e-6 * 2 * np.pi * 8000


def test_unstable_eigenvalues_are_those_of_the_full_problem():
    """LAPACK's dgeev for all eigenvalues at r = 5, with 1/(2 pi 4000 Hz) as unit of time: 367 s, once."""
    frequencies = [782.6776021465844, 2775.1520898268404, 4186.644520190261, 5795.776335591744]
    growth = [0.5959100481134696, 67.7940315771524, 107.43822851045587, 5.098598811151364]
    found = fl.eigenvalues(brake(5.0))
    growing = np.sort(found.growing)
    assert (
        len(found.values) == 132
    )  # of the full problem as many are in the disc, and 28 with more damping beyond
    assert np.allclose(found.frequencies[growing], frequencies, rtol=1e-11)
    assert np.allclose(found.growth_rates[growing], growth, rtol=0, atol=1e-7)


def test_all_modes_that_begin_to_grow():
    """By full spectra at 61 values of r between 1 and 20, in which as many modes grow as by these changes."""
    changes = fl.stability_changes(brake(5.0), "r", (1.0, 20.0))
    values = [4.57630007535, 7.01321711, 7.21554457018, 12.6058222102]
    assert np.allclose([one.value for one in changes], values, rtol=1e-8)
    assert [one.unstable for one in changes] == [(3, 4), (4, 5), (5, 6), (6, 7)]
    for one in changes:
        mode = brake(one.value).pencil.mode_at(2j * np.pi * one.frequency)
        assert mode is not None
        assert abs(mode.value.real) < 1e-7


def test_few_freedoms_have_the_modes_over_the_range():
    large = brake(5.0)
    small = fl.reduce(large, {"r": (1.0, 20.0)})
    assert small.size < 300
    for r in (2.3, 9.4, 18.1):  # none is a sample
        exact = fl.eigenvalues(brake(r)).values
        exact = exact[(exact.imag > 0.0) & (np.abs(exact.real) < 0.05 * np.abs(exact))]
        found = fl.eigenvalues(small.replace(r=r)).values
        errors = np.abs(exact[:, None] - found).min(axis=1) / np.abs(exact)
        assert errors[exact.imag < 2 * np.pi * 7840].max() < 1e-6


def test_a_mode_begins_to_grow():
    """Between r = 4 and 6 the mode at 783 Hz does, beside three that grow throughout."""
    (change,) = fl.stability_changes(brake(5.0, window=(500.0, 900.0)), "r", (4.0, 6.0))
    assert np.isclose(change.value, 4.57630007537, rtol=1e-7)
    assert fl.eigenvalues(brake(change.value, (700.0, 900.0))).growth_rates.max() < 1e-5
