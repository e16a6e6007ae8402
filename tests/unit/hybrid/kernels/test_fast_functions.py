"""Guards, sections and integrands that change fast against the motion: none is stepped over, at any t_end,
tolerance or unit of time.  The motions are polynomials or sines of time, so all right values are those of
known functions."""

import numpy as np
import pytest
import sympy as sp
from scipy.optimize import brentq
from scipy.special import gamma, gammainc

import frictionlab as fl
from frictionlab import Event, HybridAutomaton, Mode
from frictionlab.components import functions
from frictionlab.models import Mechanics
from frictionlab.models.mechanical.mechanics import Friction
from tests.helpers.assertions import assert_same_times

X, V, U = sp.symbols("x v u")
R = sp.Rational
TOLERANCES = [1e-15, 1e-6]


SLOWLY = (R(1, 5),)  # the rate of x


def until(guard, flow=SLOWLY, states=(X,), coordinates=0):
    """An automaton that moves until `guard` is zero, and then rests."""
    moves, rests = (
        Mode("moves", flow, (Event("hit", guard, ("rests",)),)),
        Mode("rests", (R(0),) * len(states)),
    )
    return HybridAutomaton(states, (moves, rests), {}, coordinates)


def free(*flow, states=(X,), coordinates=0):
    """An automaton of one mode without events."""
    return HybridAutomaton(states, (Mode("moves", tuple(map(sp.sympify, flow))),), {}, coordinates)


def first_zero(function, end, points=400_001):
    """The first zero of a function of time, by a grid and bisection."""
    t = np.linspace(0.0, end, points)
    i = np.flatnonzero(np.diff(np.sign(function(t))))[0]
    return brentq(function, t[i], t[i + 1], xtol=1e-15)


PEAK = 1 - X - R(9, 10) * sp.exp(-((1000 * (X - R(2, 5))) ** 2))
FAST = {  # guards that are positive at x = 0, and zero first between 0 and 1
    "peak": PEAK,
    "harmonic": R(11, 10) - X / 4 + sp.sin(300 * X),
    "layers": 1
    - X / 4
    - sp.tanh(500 * (X - R(1, 3))) / 2
    + sp.tanh(500 * (X - R(1, 2))) / 2
    - R(1, 2) * (1 - X),
    "pole beside": 1 - X / 9 - R(99, 100) / (1 + (2000 * (X - R(7, 10))) ** 2),
    "high degree": 1 - (X * R(11, 10)) ** 61,
    "product": 1 + sp.cos(200 * X) * sp.exp(-((3 * X - 2) ** 2)) * R(101, 100),
    "power of a wave": (R(11, 10) + sp.cos(30 * X)) ** R(7, 10) - R(19, 100) - X / 90,
}


@pytest.mark.parametrize("name", FAST)
def test_a_guard_that_changes_fast_ends_its_mode_whatever_the_run_and_its_unit_of_time(name):
    known = sp.lambdify(X, FAST[name])
    hit = 5 * first_zero(known, 1.0)
    for unit, t_end in (1.0, 3e3), (1.0, 1e5), (1e-6, 5e-6):
        automaton = until(FAST[name], flow=(sp.Float(0.2 / unit),))
        for tol in TOLERANCES:
            run = fl.solve(automaton, t_end, x0=[0.0], mode="moves", method=fl.Taylor(tol=tol))
            assert run.events.t / unit == pytest.approx([hit], abs=1e-12 + tol / 100), (unit, t_end, tol)


@pytest.mark.parametrize("tol", TOLERANCES)
def test_all_crossings_of_a_harmonic_are_recorded(tol):
    run = fl.solve(
        free(1), 20.005, x0=[0.0], method=fl.Taylor(tol=tol), sections={"s": sp.sin(100 * sp.pi * X)}
    )
    assert_same_times(run.sections["s"].t, np.arange(1, 2001) / 100, abs=1e-11 + tol)


@pytest.mark.parametrize("t_end", [5.0, 1e3])
def test_a_ball_meets_corrugated_ground(t_end):
    """y = 2 - 4.905 t^2 above waves of 0.1 m along x = 3 t."""
    y, w = sp.symbols("y w")
    ground = y - R(1, 10) - sp.sin(20 * sp.pi * X) / 20
    flight = until(ground, (V, w, R(0), R(-981, 100)), (X, y, V, w), 2)
    hit = first_zero(lambda t: 1.9 - 4.905 * t**2 - np.sin(60 * np.pi * t) / 20, 1.0)
    for tol in TOLERANCES:
        run = fl.solve(flight, t_end, x0=[0, 2, 3, 0], mode="moves", method=fl.Taylor(tol=tol))
        assert run.events.t == pytest.approx([hit], abs=1e-12 + tol / 100)


class Harmonics(fl.DenHartog):
    """Den Hartog's mass with a ninth harmonic in the force."""

    def mechanics(self, q, v):
        """One contact, held until the load exceeds friction."""
        load = self.F * (functions.sin(q.phase) / 2 + functions.sin(9 * q.phase) / 4)
        return Mechanics(
            kinetic=self.m * v.x**2 / 2,
            potential=self.k * q.x**2 / 2,
            contacts=(Friction(-v.x, self.N, self.friction),),
            loads={"x": load},
            frequency=self.Omega,
        )


@pytest.mark.parametrize("t_end", [40.0, 1e4])
def test_a_mass_that_sticks_is_freed_by_a_harmonic(t_end):
    model = Harmonics(N=0.6, F=1.0, Omega=0.2)
    freed = first_zero(lambda t: 0.6 - np.sin(0.2 * t) / 2 - np.sin(1.8 * t) / 4, 20.0)
    run = fl.simulate(model, t_end, x0=[0, 0, 0], method=fl.Taylor(max_events=1))
    assert run.events.t == pytest.approx([freed], abs=1e-11)


@pytest.mark.parametrize("t_end", [3.0, 1e3])
@pytest.mark.parametrize("tol", TOLERANCES)
def test_powers_of_a_base_that_starts_at_zero(tol, t_end):
    """x = t: what depends on x^p counts as constant at first, and no longer than that is true."""
    method, root = fl.Taylor(tol=tol), sp.sqrt(X)
    for power in (R(1, 2), R(3, 2)):
        hit = fl.solve(until(1 - X**power, (R(1),)), t_end, x0=[0.0], mode="moves", method=method)
        assert hit.events.t == pytest.approx([1.0], abs=1e-13 + tol)
    pulse = X ** R(9, 10) * sp.exp(-10_000 * X) * R(9, 10) * 10_000 ** R(19, 10)
    run = fl.solve(
        free(1, pulse, states=(X, U)),
        t_end,
        x0=[0.0, 0.0],
        method=method,
        sections={"one": root - 1},
        quadratures={"root": root, "pulse": root * sp.exp(-X)},
    )
    assert_same_times(run.sections["one"].t, [1.0], abs=1e-13 + tol)
    assert run.quadratures["root"] == pytest.approx(t_end**1.5 / 1.5, rel=1e-13 + tol)
    assert run.quadratures["pulse"] == pytest.approx(gamma(1.5) * gammainc(1.5, t_end), rel=1e-13 + 10 * tol)
    assert run.final_state[1] == pytest.approx(0.9 * gamma(1.9), rel=1e-12 + 100 * tol)


@pytest.mark.parametrize("tol", TOLERANCES)
def test_zeros_and_poles_of_sections_are_recorded_once(tol):
    """A function that is not finite at all stops no run."""
    sections = {"tan": sp.tan(X), "log": sp.log(X), "pole": 1 / (X - 4) - 2, "nowhere": sp.sin(V) / V}
    run = fl.solve(
        free(1, 0, states=(X, V)), 5.0, x0=[0.0, 0.0], method=fl.Taylor(tol=tol), sections=sections
    )
    right = {"tan": np.pi / 2 * np.arange(1, 4), "log": [1.0], "pole": [4.0, 4.5]}
    for name, times in right.items():
        assert_same_times(run.sections[name].t, times, abs=1e-10 + 10 * tol)
    assert len(run.sections["nowhere"].t) == 0
    assert run.stats["steps"] < 2000
