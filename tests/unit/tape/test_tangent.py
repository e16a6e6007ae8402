"""Exact derivatives of the tape against sympy's."""

from itertools import product

import numpy as np
import pytest
import sympy as sp

import frictionlab as fl
from tests.helpers.cases import slow_but
from tests.helpers.tangents import check_tangents

X, Y = sp.symbols("x y")
MODELS = [fl.SliderOnBelt(mu_k=1.4, impact=fl.PlasticImpact("full")), fl.SliderOnBelt().without("geometry")]


@pytest.mark.plain_python
@pytest.mark.parametrize(
    ("model", "mode"),
    slow_but([*product(MODELS[:1], (0, 3)), (MODELS[1], 1)], [*product(MODELS, range(4))], several=True),
)
def test_the_sliders_jacobian_is_exact(model, mode):
    automaton = model.automaton()
    z = np.random.default_rng(mode).normal(scale=1e-2, size=len(automaton.states))
    check_tangents(automaton, mode, z)


@pytest.mark.plain_python
def test_quotients_and_powers_have_tangents():
    flow = (X**3 * Y / (1 + Y**2), (X - Y) ** 2 / (2 + X) ** 3)
    check_tangents(fl.HybridAutomaton((X, Y), (fl.Mode("only", flow),), {}, 1), 0, np.array([0.3, -1.7]))
