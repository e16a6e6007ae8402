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


BEGINS = {  # guards whose terms are all zero at x = 0 up to the order, and their first zero after that
    "high power": (X**30 * (1 - X), 1.0),
    "root inside": (X**30 * (R(1, 1000) - X**40), 1e-3 ** (1 / 40)),
    "root far": (R(1, 1000) - X**40, 1e-3 ** (1 / 40)),
    "two factors": (X**30 * (1 - X) * (2 - X) ** 3, 1.0),
    "of the order": (X**26 * (1 - X), 1.0),
    "of a low order": (X**11 * (1 - X), 1.0),
    "with a function": (X**30 * sp.sin(1 - X), 1.0),
    "below all numbers": (sp.exp(-((1000 * (X - R(2, 5))) ** 2)) * (R(2, 5) - X), 0.4),
}


@pytest.mark.parametrize("name", BEGINS)
@pytest.mark.parametrize("tol", TOLERANCES)
def test_a_guard_that_begins_later_than_its_series_shows_ends_its_mode(name, tol):
    guard, root = BEGINS[name]
    for t_end in 3.0, 60.0, 1000.0:
        run = fl.solve(until(guard, flow=(R(1),)), t_end, x0=[0.0], mode="moves", method=fl.Taylor(tol=tol))
        assert run.events.t == pytest.approx([root], abs=1e-12), t_end


@pytest.mark.parametrize("tol", TOLERANCES)
def test_sections_and_integrals_of_what_begins_later_than_its_series_shows(tol):
    """The integral of x^30 (1 - x) exp(-x) from 0 to t is that of two gamma functions."""
    for t_end in 3.0, 60.0, 1000.0:
        run = fl.solve(
            free(1),
            t_end,
            x0=[0.0],
            method=fl.Taylor(tol=tol),
            sections={"s": X**30 * (X**40 - R(1, 1000))},
            quadratures={"q": X**30 * (1 - X) * sp.exp(-X), "t": R(1)},
        )
        assert run.sections["s"].t == pytest.approx([1e-3 ** (1 / 40)], abs=1e-14 + tol / 10)
        exact = gamma(31) * gammainc(31, t_end) - gamma(32) * gammainc(32, t_end)
        assert run.quadratures["q"] == pytest.approx(exact, rel=1e-13 + 10 * tol)


@pytest.mark.parametrize("tol", TOLERANCES)
def test_a_rate_that_begins_later_than_its_series_shows_moves_a_group_of_its_own(tol):
    """x'' = u^30 with u' = 1, from rest: x = t^32 / (31 32)."""
    run = fl.solve(
        free(V, U**30, 1, states=(X, V, U), coordinates=1), 3.0, x0=[0, 0, 0], method=fl.Taylor(tol=tol)
    )
    assert run.final_state[0] == pytest.approx(3.0**32 / (31 * 32), rel=1e-13 + tol)


@pytest.mark.parametrize("tol", TOLERANCES)
def test_a_guard_of_low_degree_begins_late_where_its_argument_does(tol):
    """x = t - sin t begins as t^3/6, so x^9 (1 - x) as t^27."""
    hit = brentq(lambda t: t - np.sin(t) - 1.0, 1.0, 3.0, xtol=1e-15)
    for t_end in 3.0, 60.0, 1000.0:
        automaton = until(X**9 * (1 - X), flow=(1 - sp.cos(U), R(1)), states=(X, U))
        run = fl.solve(automaton, t_end, x0=[0.0, 0.0], mode="moves", method=fl.Taylor(tol=tol))
        assert run.events.t == pytest.approx([hit], abs=1e-12 + tol / 10), t_end


@pytest.mark.parametrize("tol", TOLERANCES)
def test_a_guard_of_low_degree_begins_late_in_linear_equations(tol):
    """Where d^3x/dt^3 = 1 - x, 3 (1 - x) = exp(-t) + 2 exp(t/2) cos(sqrt(3) t/2); x^9 begins as t^27."""
    a = sp.Symbol("a")
    hit = brentq(lambda t: np.exp(-t) + 2 * np.exp(t / 2) * np.cos(3**0.5 * t / 2), 1.0, 3.0, xtol=1e-15)
    for t_end in 3.0, 60.0:
        automaton = until(X**9 * (1 - X), flow=(V, a, 1 - X), states=(X, V, a))
        run = fl.solve(automaton, t_end, x0=[0, 0, 0], mode="moves", method=fl.Taylor(tol=tol))
        assert run.events.t == pytest.approx([hit], abs=1e-12 + tol), t_end


@pytest.mark.parametrize("tol", TOLERANCES)
def test_what_is_zero_as_its_terms_cancel_stops_no_run(tol):
    """Two equal pendulums: sin x - sin y is zero for ever."""
    x, y, u, w = sp.symbols("x y u w")
    flow = u, w, -sp.sin(x), -sp.sin(y)
    automaton = until(sp.sin(x) - sp.sin(y), flow=flow, states=(x, y, u, w), coordinates=2)
    run = fl.solve(
        automaton,
        100.0,
        x0=[1, 1, 0, 0],
        mode="moves",
        method=fl.Taylor(tol=tol),
        quadratures={"q": x**3 * sp.sin(x) - y**3 * sp.sin(y)},
    )
    assert run.status.ok
    assert len(run.events) == 0
    assert run.quadratures["q"] == 0.0
    assert run.stats["steps"] < 5000


def test_runs_side_by_side_do_not_pass_what_begins_later_than_its_series_shows():
    for guard in X**30 * (1 - X), X**3 * (1 - X):
        compiled = until(guard, flow=(R(1),))
        run = fl.solve(compiled, 3.0, x0=[0.0], mode="moves")
        ends = fl.ensemble([compiled] * 8, 3.0, x0=[[0.0]] * 8, progress=False)
        alone = fl.solve(compiled, 3.0, x0=[0.0])
        assert run.events.t == pytest.approx([1.0], abs=1e-12)
        np.testing.assert_array_equal(ends.states, np.tile(alone.final_state, (8, 1)))
