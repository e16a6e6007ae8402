"""Critical points on many lines, searched in long intervals, are those that scans of each find."""

import numpy as np
import pytest
import sympy
from scipy.stats import qmc

import frictionlab as fl
from frictionlab.stability.boundaries.stability_changes import (
    MANY_LINES,
    changes_on_lines,
    critical_change,
    critical_points,
)
from frictionlab.stability.equilibrium_points.equilibria import equilibrium_problem

COUNT = 256  # lines
CASES = {
    "near": (fl.ModeCoupling(c=0.1), (0.0, 4.0), {"k1": (0.9, 1.1), "k3": (0.9, 1.1), "c": (0.5, 1.5)}),
    "some without a loss": (fl.ModeCoupling(c=0.1), (0.0, 1.5), {"k1": (0.6, 1.5), "k3": (0.8, 1.3)}),
    "undamped": (fl.ModeCoupling(c=0.0), (0.0, 4.0), {"k1": (0.9, 1.1), "k3": (0.9, 1.1)}),
    "slider": (fl.SliderOnBelt(), (0.0, 4.0), {"F": (0.75, 1.25), "k2": (0.8, 1.2), "c1": (0.5, 1.5)}),
}


def lines_of(model, shares, count):
    points = qmc.Sobol(len(shares), rng=np.random.default_rng(3)).random(count)
    columns = zip(shares.items(), points.T)
    return {n: model.parameters[n] * (a + (b - a) * column) for (n, (a, b)), column in columns}


def assert_those_of_scans(problem, parameter, bounds, fixed, gaps=None):
    found = critical_points(problem, parameter, bounds, fixed)
    scanned = [critical_change(c) for c in changes_on_lines(problem, parameter, bounds, fixed)]
    values = np.array([np.nan if c is None else c.value for c in scanned])
    frequencies = np.array([np.nan if c is None else c.frequency for c in scanned])
    assert COUNT >= MANY_LINES
    assert np.isfinite(values).sum() > COUNT / 4
    assert gaps in (None, np.isnan(values).any())
    assert found.values == pytest.approx(values, rel=1e-9, abs=1e-9, nan_ok=True)
    assert found.frequencies == pytest.approx(frequencies, rel=1e-7, nan_ok=True)


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_they_are_those_of_scans(name):
    model, bounds, shares = CASES[name]
    fixed, problem = lines_of(model, shares, COUNT), equilibrium_problem(model)
    assert_those_of_scans(problem, "mu_k", bounds, fixed, name == "some without a loss")


def random_oscillators(seed):
    """x'' = -(K0 + a K1 + b K2) x - C x' - p N x with random matrices, N not symmetric, damping light."""
    rng, n = np.random.default_rng(seed), 2 + seed % 3
    x, v = (sympy.symbols(f"{name}:{n}", real=True) for name in "xv")
    p, a, b = sympy.symbols("p a b", real=True)
    stiff = np.diag(rng.uniform(0.5, 3.0, n))
    parts = [0.2 * (m + m.T) for m in rng.normal(size=(2, n, n))]
    damping = np.diag(10.0 ** rng.uniform(-3.0, -1.0, n))
    follower = rng.normal(size=(n, n))
    stiffness = sympy.Matrix(stiff) + a * sympy.Matrix(parts[0]) + b * sympy.Matrix(parts[1])
    forces = -(stiffness + p * sympy.Matrix(follower)) * sympy.Matrix(x) - sympy.Matrix(
        damping
    ) * sympy.Matrix(v)
    return fl.HybridAutomaton((*x, *v), (fl.Mode("flow", (*v, *forces)),), {p: 0.0, a: 0.0, b: 0.0}, n)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(8))
def test_random_oscillators_lose_stability_where_scans_say(seed):
    """Weak coupling makes narrow windows of instability, which end before the lasting one begins."""
    points = qmc.Sobol(2, rng=np.random.default_rng(seed)).random(COUNT)
    fixed = {"a": 0.3 * points[:, 0], "b": 0.3 * points[:, 1]}
    assert_those_of_scans(equilibrium_problem(random_oscillators(seed)), "p", (0.0, 1.5), fixed)


@pytest.mark.slow
def test_fewer_spectra_are_computed(monkeypatch):
    model, bounds, shares = CASES["near"]
    problem, asked = equilibrium_problem(model), []
    plain = type(problem).spectra

    def counted(self, changes):
        asked.append(max(np.size(column) for column in changes.values()))
        return plain(self, changes)

    monkeypatch.setattr(type(problem), "spectra", counted)
    totals = []
    for count in (512, 1024):
        asked.clear()
        critical_points(problem, "mu_k", bounds, lines_of(model, shares, count))
        totals.append(sum(asked))
    assert totals[1] - totals[0] < 512 * 80
