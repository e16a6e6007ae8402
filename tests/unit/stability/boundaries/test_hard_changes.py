"""Degenerate, stiff and extreme systems: the search for changes ends, and soon."""

from __future__ import annotations

import numpy as np
import pytest
import sympy

import frictionlab as fl
from tests.helpers.cases import slow_but
from tests.helpers.linear_automata import P, linear

S = fl.SliderOnBelt
UNDAMPED = dict.fromkeys(["c1", "c2", "c4", "c5", "c6"], 0.0)
MANY = 5_000  # eigenvalue problems

SAME = sympy.Matrix([[5 + P]])
HARD = [
    linear([[1 + P, 0.05], [-0.05, 2 - P]]),
    linear(sympy.diag(*[sympy.Matrix([[1 + P, 0.05], [-0.05, 2 - P]])] * 2)),  # every mode twice
    linear(sympy.diag(sympy.Matrix([[1 + P, 0.05], [-0.05, 2 - P]]), SAME, SAME)),  # twins elsewhere
    linear(sympy.diag(sympy.Matrix([[1 + P, 0.05], [-0.05, 2 - P]]), SAME, SAME), 1e-6),
    # a mode of 1e-5 1/s beside one of 1e7 1/s
    linear(sympy.diag(sympy.Matrix([[1 + P, 0.05], [-0.05, 2 - P]]), 1e14, 1e-10), 1e-9),
]


@pytest.fixture
def problems(monkeypatch):
    """How many eigenvalue problems each call of numpy has solved."""
    solve, counted = np.linalg.eigvals, []

    def eigvals(matrices):
        counted.append(int(np.prod(np.shape(matrices)[:-2])))
        return solve(matrices)

    monkeypatch.setattr(np.linalg, "eigvals", eigvals)
    return counted


@pytest.mark.parametrize("model", slow_but(HARD[::3], HARD))
def test_degenerate_and_stiff_systems_are_quick(model, problems):
    """Flutter between 0.45 and 0.55, whatever else there is."""
    changes = fl.stability_changes(model, "p", (0, 1))
    assert [(c.kind, c.direction) for c in changes] == [("flutter", "loss"), ("flutter", "regain")]
    np.testing.assert_allclose([c.value for c in changes], [0.45, 0.55], atol=1e-4)
    assert sum(problems) < MANY


EXTREME = [
    UNDAMPED,
    dict.fromkeys(UNDAMPED, 1e-12),
    {"c1": 1e6},
    {"k4": 1e12, "k5": 1e12, "k6": 1e12},
    {"k1": 1e15},
    {"k_nl": 1e20},
    {"M": 1e-6, "m": 1e-6, "J": 1e-7},
    {"M": 1e6, "m": 1e6, "J": 1e5},
    {"F": 1e-9},
    {"F": 1e9},
    {"l1": 1e-9, "l2": 1e-9},
]


@pytest.mark.parametrize("values", slow_but([EXTREME[i] for i in (5,)], EXTREME))
def test_extreme_scenes_are_quick(values, problems):
    model = S(**values)
    changes = fl.stability_changes(model, "mu_k", (0, 4))
    locus = fl.root_locus(model, "mu_k", np.linspace(0, 4, 500))
    assert np.isfinite([c.value for c in changes]).all()
    for c in changes:
        i = np.searchsorted(locus.at, c.value)
        assert locus.unstable[i - 1] in c.unstable
    assert sum(problems) < MANY
