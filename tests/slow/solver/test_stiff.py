"""Dampers far beyond critical, 1e3 to 1e6 N s/m, against the exponential of the matrix in mpmath."""

import math

import numpy as np
import pytest
import sympy as sp
from mpmath import mp

import frictionlab as fl
from frictionlab.hybrid.methods.base import RECORD_CAPACITY
from tests.helpers.energy_balance import assert_balanced

BARE = fl.SliderOnBelt(mu_k=1.4).without("cubic", "nonsmooth", "geometry")
ALL, SLIDERS = ("c1", "c2", "c4", "c5", "c6"), ("c1", "c2")
RESOLVED = (math.factorial(26) * 1e-15) ** (1 / 26)  # rate times step at which a decay's last term is small
STABLE = 26 / np.e  # a series of order 26 is stable on the real axis somewhat beyond (Szegö: order/e)


def exact(automaton, t_end):
    """State after t_end from rest: the last column of exp(t [[A, b], [0, 0]]), with 40 digits."""
    numbers = {symbol: sp.Rational(str(value)) for symbol, value in automaton.parameters.items()}
    flow = sp.Matrix(automaton.modes[0].flow).subs(numbers)
    rest = dict.fromkeys(automaton.states, 0)
    matrix = flow.jacobian(automaton.states).row_join(flow.subs(rest)).col_join(sp.zeros(1, len(rest) + 1))
    with mp.workdps(60):  # squared 20 times or more
        entries = [[mp.mpf(x.p) / x.q for x in matrix.row(i)] for i in range(matrix.rows)]
        return [+x for x in mp.expm(t_end * mp.matrix(entries))[:, len(rest)]][:-1]


def matrix_of(automaton):
    flow = sp.Matrix(automaton.modes[0].flow).subs(dict(automaton.parameters))
    return np.array(flow.jacobian(automaton.states), dtype=float)


@pytest.mark.parametrize("dampers", [ALL, SLIDERS], ids=["all", "slider's"])
@pytest.mark.parametrize("damping", [1e3, 1e4, 1e5, 1e6])
def test_overdamped_motion_is_exact_at_a_cost_in_proportion_to_the_damping(damping, dampers):
    """Found: errors of 1.3e-15 at most, 4e-12 of every single state; 181,000 steps and 0.2 s a second at 1e6.

    An explicit method takes the steps for which it is stable, in proportion to the fastest decay; before
    that those of one map for every state, which resolve it, as long as one look at the run lasts.
    """
    model = BARE.replace(**dict.fromkeys(dampers, damping))
    run = fl.simulate(model, 1.0, method=fl.Taylor(max_steps=400_000), progress=False)
    reference = np.array([float(x) for x in exact(model.automaton(), 1)])
    assert run.status is fl.Status.FINISHED
    assert_balanced(run)
    assert run.final_state == pytest.approx(reference, rel=1e-11, abs=1e-16)
    fastest = np.abs(np.linalg.eigvals(matrix_of(model.automaton()))).max()
    assert run.stats["steps"] < min(fastest / RESOLVED, RECORD_CAPACITY + fastest / STABLE) + 100
