"""Eigenvalues and spectra that a page computes, against numpy."""

import json
from pathlib import Path

import numpy as np
import pytest

from tests.unit.pages.test_javascript import run_in_node

SCRIPTS = Path(__file__).parents[3] / "frictionlab" / "pages" / "scripts"


def matrices():
    random = np.random.default_rng(7)
    yield random.normal(size=(10, 10))
    yield np.block([[np.zeros((3, 3)), np.eye(3)], [-np.diag([1e4, 2e4, 5e5]), -0.1 * np.eye(3)]])
    yield np.diag([3.0, -1.0])
    yield np.array([[0.0, 1.0], [-4.0, 0.0]])
    yield np.zeros((4, 4))
    yield random.normal(size=(7, 7)) * 10.0 ** np.arange(7)


@pytest.mark.parametrize("matrix", list(matrices()))
def test_eigenvalues_are_those_of_numpy(matrix):
    code = (SCRIPTS / "linear_algebra.js").read_text()
    rows = json.dumps(matrix.tolist())
    found = np.array(
        [complex(*pair) for pair in run_in_node(f"{code} console.log(JSON.stringify(eigenvaluesOf({rows})))")]
    )
    known = np.linalg.eigvals(matrix)
    assert len(found) == len(known)
    size = max(abs(known).max(), 1.0)
    for value in known:
        nearest = abs(found - value).argmin()
        assert abs(found[nearest] - value) <= 1e-11 * size
        found = np.delete(found, nearest)


def test_the_spectrum_has_the_amplitude_of_a_sine():
    code = (SCRIPTS / "sampling.js").read_text()
    signal = "Float64Array.from({length: 1024}, (_, i) => 5 + 3 * Math.sin(2 * Math.PI * 32 * i / 1024))"
    found = run_in_node(f"{code} console.log(JSON.stringify(Array.from(amplitudes({signal}))))")
    assert np.argmax(found) == 32
    assert found[32] == pytest.approx(3.0, rel=1e-12)
    assert max(found[:30] + found[35:]) < 1e-12
