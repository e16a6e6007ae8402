"""Motions that stop in finite time where a power in their rates ends: against their closed forms.

There the solution is a polynomial of time, whose last terms say nothing of the power, and the guard that is
the power's base has a multiple zero.
"""

import numpy as np
import pytest
import sympy as sp

import frictionlab as fl
from frictionlab import Event, HybridAutomaton, Mode, Reset
from tests.helpers.automata import ONCE

P, X, Y, U, W = sp.symbols("p x y u w", real=True)
MU, K = sp.symbols("mu k", positive=True)
TOLERANCES = (1e-6, 1e-9, 1e-15)
ROUNDING = 1e-14


def tank(exponent):
    """p' = -p^a: a tank empties (a = 1/2, Torricelli) at p0^(1 - a)/(1 - a)."""
    full = Mode("full", (-(P**exponent),), (Event("empty", P, ("dry",), Reset({P: sp.S.Zero})),))
    return HybridAutomaton((P,), (full, Mode("dry", (sp.S.Zero,), (), (P,))))


@ONCE
@pytest.mark.parametrize("tol", TOLERANCES)
def test_a_tank_is_empty_in_finite_time(tol):
    for p, q, start in ((1, 2, 1.0), (1, 2, 1e3), (2, 3, 3.7e-5), (3, 4, 1e3)):
        law, exponent = tank(sp.Rational(p, q)), p / q
        empty = start ** (1 - exponent) / (1 - exponent)
        run = fl.solve(law, 3 * empty, x0=[start], method=fl.Taylor(tol=tol), progress=False)
        assert run.events.t == pytest.approx([empty], rel=ROUNDING)
        assert run.warning is None


def puck(stiffness=0.0):
    """A puck on rough ground, on springs of the stiffnesses k and 3 k: friction acts against its velocity."""
    speed = sp.sqrt(U**2 + W**2)
    flow = (U, W, -K * X - MU * U / speed, -3 * K * Y - MU * W / speed)
    stop = Event("stop", U**2 + W**2, ("rest",), Reset({U: sp.S.Zero, W: sp.S.Zero}))
    breaks = Event("breaks", MU**2 - K**2 * (X**2 + 9 * Y**2), ("slide",))
    rest = Mode("rest", (sp.S.Zero,) * 4, (breaks,), (U, W))
    return HybridAutomaton((X, Y, U, W), (rest, Mode("slide", flow, (stop,))), {MU: 0.5, K: stiffness}, 2)


@ONCE
@pytest.mark.parametrize("tol", TOLERANCES)
@pytest.mark.parametrize("velocity", [(1.0, 0.0), (0.6, 0.8), (3e-3, -4e-4)])
def test_a_puck_stops_when_its_speed_is_used_up(velocity, tol):
    """The speed falls at the rate mu, so the puck stops at u0/mu, after u0^2/(2 mu)."""
    speed = np.hypot(*velocity)
    run = fl.solve(puck(), 8 * speed, x0=[0, 0, *velocity], method=fl.Taylor(tol=tol), progress=False)
    assert run.events.t == pytest.approx([2 * speed], rel=ROUNDING)
    assert run.final_state == pytest.approx([*(speed * np.array(velocity)), 0, 0], rel=ROUNDING)
    assert run.warning is None


@ONCE
@pytest.mark.parametrize("tol", TOLERANCES)
def test_a_puck_on_springs_stops_where_an_independent_integrator_says(tol):
    """By DOP853 up to a speed of 1e-7, and on along the last velocity; near the stop the speed falls at the
    rate mu plus the spring's force along it."""
    from scipy.integrate import solve_ivp

    def rates(_, z):
        friction = 0.5 * z[2:] / np.hypot(*z[2:])
        return [*z[2:], *(-np.array([1.0, 3.0]) * z[:2] - friction)]

    start = [0.2, 0.3, 1.0, 2.3]

    def slow(_, z):
        return np.hypot(*z[2:]) - 1e-7

    slow.terminal = True
    end = solve_ivp(rates, (0, 30), start, "DOP853", rtol=3e-14, atol=1e-16, events=slow)
    z, rate = end.y[:, -1], np.array(rates(0, end.y[:, -1])[2:])
    remaining = -np.hypot(*z[2:]) / (rate @ z[2:] / np.hypot(*z[2:]))
    run = fl.solve(puck(1.0), 30.0, x0=start, method=fl.Taylor(tol=tol), progress=False)
    assert run.events.t == pytest.approx([end.t[-1] + remaining], rel=max(1e-9, 10 * tol))
    assert run.warning is None
