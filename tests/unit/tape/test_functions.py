"""Flows with functions and powers of the states, against closed forms."""

import math
from itertools import product

import mpmath
import numpy as np
import pytest
import sympy as sp
from scipy.special import ellipk

import frictionlab as fl
from tests.helpers.automata import ONCE, V, X, automaton, clock
from tests.helpers.cases import slow_but
from tests.helpers.tangents import check_tangents


def run(scene, t_end, z, **more):
    result = fl.solve(scene, t_end, x0=np.array(z, dtype=float), progress=False, **more)
    assert result.status.ok
    return result


@ONCE
@pytest.mark.parametrize("amplitude", [0.1, 1.0, 3.0])
def test_the_period_of_a_pendulum(amplitude):
    pendulum = automaton(fl.Mode("only", (V, -sp.sin(X))))
    period = 4 * ellipk(math.sin(amplitude / 2) ** 2)
    assert run(pendulum, 10 * period, [amplitude, 0.0]).final_state == pytest.approx(
        [amplitude, 0], abs=1e-11
    )


def integral_of_atan(x):
    return x * mpmath.atan(x) - mpmath.log(1 + x * x) / 2


GROWTHS = {  # x' as a function of x, and x(1) from x(0)
    "exp": (-sp.exp(X), 0.5, -math.log(math.exp(-0.5) + 1)),
    "log": (X * sp.log(X), 2.0, 2**math.e),
    "tan": (sp.tan(X), 0.2, math.asin(math.sin(0.2) * math.e)),
    "tanh": (-sp.tanh(X), 0.7, math.asinh(math.sinh(0.7) / math.e)),
    "cosh": (1 / sp.cosh(X), 0.3, math.asinh(math.sinh(0.3) + 1)),
    "sinh": (-sp.sinh(X), 0.7, 2 * math.atanh(math.tanh(0.35) / math.e)),
    "cos": (sp.cos(X), 0.0, math.asin(math.tanh(1))),
    "atan": (1 / sp.atan(X), 1.0, None),
    "asinh": (-sp.sqrt(1 + X**2) * sp.asinh(X), 0.7, math.sinh(math.asinh(0.7) / math.e)),
    "power": (X ** sp.Rational(5, 2), 0.5, (0.5**-1.5 - 1.5) ** (-2 / 3)),
    "root": (sp.sqrt(X), 0.5, (math.sqrt(0.5) + 0.5) ** 2),
    "negative": (X ** sp.Rational(-1, 2), 0.5, (0.5**1.5 + 1.5) ** (2 / 3)),
}


@ONCE
@pytest.mark.parametrize("name", GROWTHS)
def test_growth_by_every_function(name):
    rate, start, end = GROWTHS[name]
    scene = automaton(fl.Mode("only", (rate,)), states=(X,), coordinates=0)
    if end is None:
        end = float(mpmath.findroot(lambda x: integral_of_atan(x) - integral_of_atan(start) - 1, 2.0))
    assert run(scene, 1.0, [start]).final_state[0] == pytest.approx(end, rel=2e-14)


@ONCE
@pytest.mark.parametrize("exponent", [2.0, 1.5, 0.25, -1.0, -0.3])
def test_an_exponent_may_be_a_parameter(exponent):
    p = sp.Symbol("p")
    scene = automaton(fl.Mode("only", (X**p,)), states=(X,), coordinates=0, p=exponent)
    end = (0.5 ** (1 - exponent) + (1 - exponent) * 0.3) ** (1 / (1 - exponent))
    assert run(scene, 0.3, [0.5]).final_state[0] == pytest.approx(end, rel=1e-14)


def test_a_guard_of_functions_is_found():
    found = run(clock(fl.Event("done", sp.cos(X) + sp.exp(-X))), 5.0, [0.0]).events
    exact = float(mpmath.findroot(lambda t: mpmath.cos(t) + mpmath.exp(-t), 1.7))
    assert found.t == pytest.approx([exact], abs=1e-15)


@ONCE
def test_functions_and_powers_have_tangents():
    y, p = sp.symbols("y p")
    flow = (sp.exp(sp.sin(X * y)) + sp.tanh(X) ** 2, (1 + X**2) ** p * sp.log(2 + y) - sp.sqrt(1 + y))
    scene = fl.HybridAutomaton((X, y), (fl.Mode("only", flow),), {p: 1.7}, 1)
    check_tangents(scene, 0, np.array([0.3, 1.7]))


def test_the_tangent_flow_of_functions():
    """x' = -tanh(x): sinh(x) falls like exp(-t), so dx(t)/dx(0) = cosh(x0) exp(-t) / cosh(x)."""
    scene = automaton(fl.Mode("only", (-sp.tanh(X),)), states=(X,), coordinates=0)
    end = run(scene, 2.0, [0.7])
    exact = math.cosh(0.7) * math.exp(-2.0) / math.cosh(end.final_state[0])
    assert fl.tangent_flow(end).matrix == pytest.approx(exact, rel=1e-13)


# --- powers whose base begins at zero


def between_walls(exponent):
    """A unit mass that two walls push back with a force k (distance beyond)^p; they are 2 apart."""
    k, p = sp.symbols("k p")
    right = fl.Mode("right", (V, -k * (X - 1) ** p), (fl.Event("off", X - 1, ("free",)),))
    left = fl.Mode("left", (V, k * (-1 - X) ** p), (fl.Event("off", -1 - X, ("free",)),))
    free = fl.Mode(
        "free", (V, sp.S.Zero), (fl.Event("+", 1 - X, ("right",)), fl.Event("-", 1 + X, ("left",)))
    )
    return automaton(free, right, left, k=1e4, p=exponent)


def cycle(exponent, k=1e4, v=1.0):
    """Twice the flight and twice the contact, whose depth is d: k d^(p+1)/(p+1) = v^2/2."""
    n = exponent + 1
    depth = (n * v * v / (2 * k)) ** (1 / n)
    contact = 2 * depth / v * math.sqrt(math.pi) / n * math.gamma(1 / n) / math.gamma(1 / n + 0.5)
    return 2 * (2 / v) + 2 * contact


@ONCE
@pytest.mark.parametrize("exponent", [1.5, 2.5, 1.0, 2.0, 0.5, 1.1])
def test_a_mass_between_two_walls_of_any_exponent(exponent):
    """Hertz's law has the exponent 3/2; the energy and the period of 20 cycles."""
    found = run(between_walls(exponent), 20 * cycle(exponent), [0.0, 1.0])
    assert len(found.events) == 80
    assert found.final_state == pytest.approx([0.0, 1.0], abs=1e-12 * found.t[-1])
    assert np.isfinite(found(np.linspace(0, found.t[-1], 999))).all()


def test_a_negative_exponent_at_zero_has_no_value():
    scene = automaton(fl.Mode("only", (X ** sp.Rational(-1, 2),)), states=(X,), coordinates=0)
    assert fl.solve(scene, 1.0, x0=[0.0], progress=False).status is fl.Status.NOT_FINITE


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
