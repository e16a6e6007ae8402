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
