"""Losses of stability with closed forms, on automata of one's own; and equilibria of such."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
import sympy as sp

import frictionlab as fl
from tests.helpers.cases import slow_but

pytestmark = pytest.mark.blas


def automaton(rates, *, n, events=(), **parameters):
    """x'' = rates(x, v, parameters) for n coordinates x1 ... xn."""
    x, v = (sp.symbols(f"{name}1:{n + 1}", real=True) for name in "xv")
    symbols = {name: sp.Symbol(name, real=True) for name in parameters}
    mode = fl.Mode("slip", (*v, *rates(x, v, **symbols)), tuple(e(x, v) for e in events))
    return fl.HybridAutomaton((*x, *v), (mode,), {symbols[k]: p for k, p in parameters.items()}, n)


PLACES, COUPLINGS = (0.3721, 1 / np.pi, 0.5), (1e-3, 1e-5, 1e-7)


@pytest.mark.parametrize(
    ("place", "coupling"), slow_but([*zip(PLACES, COUPLINGS)], [*product(PLACES, COUPLINGS)], several=True)
)
def test_a_window_as_narrow_as_the_coupling_is_weak(coupling, place):
    """Frequencies cross at `place`; an antisymmetric coupling e makes them lock where |k1 - k2| < 2e."""

    def rates(x, v, p, e):
        return -(1 + p - place) * x[0] - e * x[1], -(1 - (p - place)) * x[1] + e * x[0]

    changes = fl.stability_changes(automaton(rates, n=2, p=0.1, e=coupling), "p", (0.0, 1.0))
    assert [c.direction for c in changes] == ["loss", "regain"]
    assert [c.value for c in changes] == pytest.approx([place - coupling, place + coupling], abs=1e-11)
    assert {c.kind for c in changes} == {"flutter"}


@pytest.mark.parametrize("damping", [0.0, 0.1])
def test_divergence(damping):
    found = fl.stability_changes(
        automaton(lambda x, v, p: (-(1 - p**2) * x[0] - damping * v[0],), n=1, p=0.0), "p", (-2, 2)
    )
    assert [(c.kind, c.direction) for c in found] == [("divergence", "regain"), ("divergence", "loss")]
    assert [c.value for c in found] == pytest.approx([-1, 1], abs=1e-12)
    assert all(c.frequency == 0 for c in found)
