"""What a function may do within a step: bounds against complex values, runs against closed forms."""

from dataclasses import dataclass

import numpy as np
import pytest
import sympy

import frictionlab as fl
from frictionlab import HybridAutomaton, Mode, parameter
from frictionlab.components import functions as fn
from frictionlab.hybrid.kernels.remainder import power_range
from frictionlab.tape.functions import EXP, FUNCTIONS, SECH2, TANH, function_range, function_value
from frictionlab.tape.packing import program_of

CIRCLE = np.exp(2j * np.pi * np.arange(400) / 400)
NOWHERE = np.inf
SINGULARITY = {  # distance of a from the nearest point where the function is not analytic
    "exp": lambda a: NOWHERE,
    "log": abs,
    "sin": lambda a: NOWHERE,
    "cos": lambda a: NOWHERE,
    "tan": lambda a: abs(np.pi / 2 - abs(a) % np.pi),
    "tanh": lambda a: np.hypot(a, np.pi / 2),
    "sinh": lambda a: NOWHERE,
    "cosh": lambda a: NOWHERE,
    "atan": lambda a: np.hypot(a, 1.0),
    "asinh": lambda a: np.hypot(a, 1.0),
    "sech2": lambda a: np.hypot(a, np.pi / 2),
}
X = sympy.Symbol("x")


def as_numpy(expr):
    """A function of complex arrays."""
    return sympy.lambdify(X, expr, [{"sech2": lambda a: 1 / np.cosh(a) ** 2}, "numpy"])


@pytest.fixture(params=FUNCTIONS, ids=lambda function: function.name)
def function(request):
    """An entry of the tape's functions, with its value and its slope by numpy."""
    expr = request.param.expression(X)
    slope = sympy.diff(expr, X) if request.param.public else -2 * sympy.tanh(X) * expr
    return request.param, as_numpy(expr), as_numpy(slope)


def starts(name):
    return 0.02, 0.3, 1.0, 4.0, 30.0, *((-0.02, -1.0, -7.0) if name != "log" else ())


def test_a_function_has_its_value_and_its_slope(function):
    entry, f, slope = function
    for a in starts(entry.name):
        assert function_value(entry.kind, a) == pytest.approx(f(a), rel=1e-15)
        h = 1e-30  # the complex step's error is its square
        assert (f(a + 1j * h) / h).imag == pytest.approx(slope(a), rel=1e-13)


def test_a_range_is_not_left_on_the_disc(function):
    entry, f, slope = function
    compared = 0
    for a in starts(entry.name):
        for d in (1e-6, 0.01, 0.1, 0.3, 0.7, 1.3, 3.0, 20.0):
            bound = function_range(entry.kind, a, abs(float(f(a))), abs(float(slope(a))), d)
            if d >= SINGULARITY[entry.name](a):
                assert bound == np.inf, (a, d)
            elif bound < np.inf:
                rounding = 1e-15 * abs(f(a))  # of the difference on the left
                assert np.abs(f(a + d * CIRCLE) - f(a)).max() <= bound * (1 + 1e-9) + rounding, (a, d)
                compared += 1
    assert compared > 15


def test_a_small_disc_has_a_range_near_the_slope_times_its_radius(function):
    entry, f, slope = function
    for a in (0.1, 0.7, 1.2):
        bound = function_range(entry.kind, a, abs(float(f(a))), abs(float(slope(a))), 1e-6)
        assert bound == pytest.approx(abs(slope(a)) * 1e-6, rel=1e-3)


def test_what_is_saturated_or_tiny_has_no_range():
    """Of what may be below the smallest number, as of exp(-1e6), the range is found all the same."""
    assert function_range(TANH, 1e6, 1.0, 0.0, 9e5) < 1e-300
    assert function_range(TANH, 1e6, 1.0, 0.0, 1.1e6) == np.inf
    assert function_range(EXP, -1e6, 0.0, 0.0, 9e5) < 1e-300
    assert function_range(EXP, -1e6, 0.0, 0.0, 1e6 + 2.0) == pytest.approx(np.exp(2.0))


def test_a_saturated_tanh_keeps_the_digits_of_its_slope():
    """x' = tanh(x) has sinh(x) = sinh(x_0) e^t: from saturation far below zero back into the layer."""
    x = sympy.Symbol("x", real=True)
    automaton = HybridAutomaton((x,), (Mode("creep", (-sympy.tanh(x),)),), {}, 0)
    for start in (-15.0, 17.0, 18.2):
        run = fl.solve(automaton, abs(start), x0=[start])
        exact = np.arcsinh(np.sinh(start) * np.exp(-abs(start)))
        assert run.final_state[0] == pytest.approx(exact, abs=5e-15)
    slope = function_value(SECH2, 18.0)
    assert slope == pytest.approx(float(4 * sympy.exp(-36) / (1 + sympy.exp(-36)) ** 2), rel=1e-15)


@pytest.mark.parametrize("exponent", [1.5, 0.1, 0.5, -0.7, 2.3])
def test_a_powers_range_is_not_left_on_the_disc(exponent):
    for base in (1e-8, 0.3, 5.0):
        for share in (1e-3, 0.3, 0.9):
            d = share * base
            found = np.abs((base + d * CIRCLE) ** exponent - base**exponent).max()
            assert found <= power_range(exponent, base, d) * (1 + 1e-9)
        assert power_range(exponent, base, base) == np.inf


@dataclass(frozen=True, repr=False)
class Switch(fl.FrictionLaw):
    """A smooth step of friction at a speed: the user's law that steps used to jump over."""

    v_s: float = parameter(0.01, symbol="v_s")

    def kinetic(self, normal_force, speed):
        return (0.6 + 0.3 * fn.tanh((speed - 0.2) / self.v_s)) * normal_force

    def static_limit(self, normal_force):
        return 0.9 * normal_force


def test_a_friction_layer_far_below_the_speed_is_seen():
    """By DOP853, by RK4 and by an integrator of its own there are 24 onsets of stick in 150 s."""
    law = fl.Stribeck(mu_k=0.3, mu_s=1, v_s=0.2, mu_v=0.02)
    run = fl.simulate(fl.MassOnBelt(friction=law, c=0.02, v=2.5), 150.0, x0=[4, 0])
    assert (run.events.target == "stick").sum() == 24


@pytest.mark.parametrize("v_s", [1.0, 1e-2, 1e-4])
@pytest.mark.parametrize("law", ["gaussian", "exponential", "switch"])
def test_the_error_falls_with_the_tolerance_and_the_events_stay(law, v_s):
    laws = {"gaussian": fl.Stribeck, "exponential": fl.ExponentialDecay}
    chosen = Switch(v_s=max(v_s, 1e-3)) if law == "switch" else laws[law](mu_k=0.3, mu_s=1.0, v_s=v_s)
    model = fl.MassOnBelt(friction=chosen, c=0.02, v=1.0)
    exact = fl.simulate(model, 20.0, x0=[4, 0], method=fl.Taylor(tol=1e-17, order=40))
    assert len(exact.events) > 0
    for tol in (1e-15, 1e-12, 1e-9, 1e-6, 1e-4):
        run = fl.simulate(model, 20.0, x0=[4, 0], method=fl.Taylor(tol=tol))
        assert run.events.target.tolist() == exact.events.target.tolist(), tol
        # Errors of the order of the tolerance grow in the layer, where friction falls: up to a thousandfold.
        assert np.abs(run.final_state - exact.final_state).max() < max(1e3 * tol, 1e-11), tol


def test_a_polynomial_whose_last_terms_all_vanish_does_not_end_the_control_of_steps():
    """x'' = -100 x^5 from x = 0: only the terms 1, 7, 13, 19 ... are not zero: none of the last at 23."""
    x, v = sympy.symbols("x v", real=True)
    automaton = HybridAutomaton((x, v), (Mode("spring", (v, -100 * x**5)),), {}, 1)
    for order in (21, 22, 23, 24):
        run = fl.solve(automaton, 20.0, x0=[0.0, 1.0], method=fl.Taylor(order=order))
        x1, v1 = run.final_state
        assert v1**2 / 2 + 100 * x1**6 / 6 == pytest.approx(0.5, rel=1e-11), order


def test_polynomials_of_low_degree_need_no_bound():
    """Scenes of polynomials cost what they did: their steps are those of the last two terms."""
    code = program_of(fl.SliderOnBelt().automaton())[0].code
    slip = fl.SliderOnBelt().automaton().names.index("slip+")
    assert 1 < code.degrees[slip] < 12
    assert program_of(fl.MassOnBelt().automaton())[0].code.degrees.max() == 1
    layered = program_of(fl.MassOnBelt(friction=fl.Stribeck()).automaton())[0].code
    assert layered.degrees.max() > 60


def test_a_power_of_a_guard_needs_one():
    """Near its zero the motion may be a polynomial, whose last terms say nothing of the power."""
    model = fl.SliderOnBelt(contact=fl.HertzContact(), friction=fl.Coulomb())
    code = program_of(model.automaton())[0].code
    assert code.degrees[model.automaton().names.index("slip+")] > 60


@pytest.mark.parametrize("n", [0.5, 0.7, 0.8, 0.9])
def test_powers_that_begin_at_zero_take_no_more_than_ten_times_the_steps(n):
    """F_N^(1-n) from F_N = 0: before 1e-11 s a full series has coefficients beyond all numbers."""
    plain = fl.simulate(fl.SliderOnBelt(friction=fl.PressureDependent(n=0.0)), 0.05)
    run = fl.simulate(fl.SliderOnBelt(friction=fl.PressureDependent(n=n)), 0.05)
    assert run.status is fl.Status.FINISHED
    assert run.stats["steps"] <= 10 * plain.stats["steps"]
    exact = fl.simulate(
        fl.SliderOnBelt(friction=fl.PressureDependent(n=n)),
        0.05,
        method=fl.Scipy("DOP853", rtol=1e-12, atol=1e-15),
    )
    assert run.events.target.tolist() == exact.events.target.tolist()
    assert np.abs(run.final_state - exact.final_state).max() < 1e-10
