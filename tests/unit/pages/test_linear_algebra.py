"""Eigenvalues and spectra that a page computes, against numpy."""

import json
from pathlib import Path

import numpy as np
import pytest

import frictionlab as fl
from frictionlab.pages.page_data import structure_data
from tests.unit.pages.test_javascript import run_in_node

SCRIPTS = Path(__file__).parents[3] / "frictionlab" / "pages" / "scripts"


def code_of(*names):
    # with these, a library leaves its names to the loader of modules
    return "module = exports = undefined;" + "".join((SCRIPTS / f"{name}.js").read_text() for name in names)


def matrices():
    random = np.random.default_rng(7)
    yield random.normal(size=(10, 10))
    yield np.block([[np.zeros((3, 3)), np.eye(3)], [-np.diag([1e4, 2e4, 5e5]), -0.1 * np.eye(3)]])
    yield np.diag([3.0, -1.0])
    yield np.array([[0.0, 1.0], [-4.0, 0.0]])
    yield np.zeros((4, 4))
    yield random.normal(size=(7, 7)) * 10.0 ** np.arange(7)


def test_eigenvalues_are_those_of_numpy():
    code = code_of("vendor/ml-matrix", "linear_algebra")
    given = json.dumps([matrix.tolist() for matrix in matrices()])
    answers = run_in_node(f"{code} console.log(JSON.stringify({given}.map(eigenvaluesOf)))")
    for matrix, pairs in zip(matrices(), answers, strict=True):
        found, known = np.array([complex(*pair) for pair in pairs]), np.linalg.eigvals(matrix)
        assert len(found) == len(known)
        size = max(abs(known).max(), 1.0)
        for value in known:
            nearest = abs(found - value).argmin()
            assert abs(found[nearest] - value) <= 1e-11 * size
            found = np.delete(found, nearest)


def test_the_spectrum_has_the_amplitude_of_a_sine():
    code = code_of("sampling")
    signal = "Float64Array.from({length: 1024}, (_, i) => 5 + 3 * Math.sin(2 * Math.PI * 32 * i / 1024))"
    found = run_in_node(f"{code} console.log(JSON.stringify(Array.from(amplitudes({signal}))))")
    assert np.argmax(found) == 32
    assert found[32] == pytest.approx(3.0, rel=1e-12)
    assert max(found[:30] + found[35:]) < 1e-12


@fl.model
class Wheel(fl.MechanicalModel):
    """A wheel that a motor turns against a brake with friction of a law of its own."""

    friction: fl.FrictionLaw = fl.Jenkins(mu_k=0.3, k_t=40.0)
    coordinates = ("theta", "psi")
    cyclic = ("theta", "psi")

    def mechanics(self, q, v):
        return fl.Mechanics(
            v.theta**2 / 2 + 2.0 * v.psi**2 / 2,
            30.0 * (q.theta - q.psi) ** 2 / 2,
            0.5 * v.theta**2 / 2,
            loads={"theta": 4.0},
            contacts=(fl.Friction(-v.psi, 2.0, self.friction),),
        )


EQUILIBRIA = {
    "states of a law": Wheel(),
    "states with limits": Wheel(friction=fl.Iwan(mu_k=0.3, k_t=40.0)),
    "law with a rate": Wheel(friction=fl.Dahl(mu_k=0.3, sigma_0=50.0)),
    "steady rotation": fl.DrillString(friction=fl.Coulomb(mu_k=0.5, mu_s=1.0)),
    "at zero": fl.HultenOscillator(),
    "at zero, stable": fl.WobblingDisc(d=0.5),
    "growth against symmetry": fl.ModularChain(friction=fl.HyperbolicDecay()),
    "growth": fl.SliderOnBelt(mu_k=1.4),
}


@pytest.mark.parametrize("model", EQUILIBRIA.values(), ids=EQUILIBRIA)
def test_a_page_has_the_equilibrium_its_eigenvalues_and_a_state_near_it(model):
    data, known = structure_data(model), fl.eigenvalues(model)
    rows = ", ".join(
        f"{{mode: {row['mode']}, following: {row['following']}, flow: {row['flow']}, "
        f"jacobian: {row['jacobian']}, guards: {row['guards']}}}"
        for row in data["sliding"]
    )
    names = "functions", "layout", "vendor/ml-matrix", "linear_algebra", "displaced_equilibrium"
    code = "const ROUNDING = 1e-12;" + code_of(*names)
    values = json.dumps([{**data["fixed"], **model.parameters}[name] for name in data["parameters"]])
    script = (
        f"{code} const structure = {{sliding: [{rows}], outputs: {{names: []}}}};"
        f"const found = equilibriumOf(structure, {values}, [{json.dumps(data['near'])}]);"
        f"const near = displacedEquilibrium(found, {values}, {len(model.coordinates)});"
        f"console.log(JSON.stringify([found.z, eigenvaluesAt(found, {values}), near]));"
    )
    state, found, near = run_in_node(script)
    start = fl.simulate(model, 1e-9, x0="near", progress=False).states[0]
    assert np.allclose(near, start, rtol=1e-9, atol=1e-12 * np.abs(start).max())
    assert not np.allclose(near, state, rtol=1e-6)
    assert np.allclose(state, known.equilibrium.state, rtol=1e-12, atol=1e-15)
    found = np.array([complex(*pair) for pair in found])
    assert np.allclose(np.sort_complex(found), np.sort_complex(known.values), rtol=1e-9, atol=1e-9)
