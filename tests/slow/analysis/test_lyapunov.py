"""Lyapunov exponents against published and closed-form values."""

import numpy as np
import pytest
import sympy as sp

import frictionlab as fl
from tests.helpers.automata import V, X, automaton, coulomb

Y, Z = sp.symbols("y z")
LORENZ = automaton(
    fl.Mode("only", (10 * (Y - X), 28 * X - Y - X * Z, X * Y - sp.Rational(8, 3) * Z)),
    states=(X, Y, Z),
    coordinates=0,
)


def test_lorenz():
    """Sprott, Chaos and Time-Series Analysis (2003): 0.9056, 0, -14.5723."""
    found = fl.lyapunov(LORENZ, [1.0, 1.0, 1.0], transient=50.0, t_end=1000.0, progress=False)
    assert (np.abs(found.exponents - [0.9056, 0.0, -14.5723]) < 4 * found.standard_errors).all()
    assert (found.standard_errors < 0.02).all()
    assert found.exponents.sum() == pytest.approx(-41 / 3, abs=1e-12)  # the divergence is constant
    assert found.chaotic


def test_a_linear_system_has_the_real_parts_of_its_eigenvalues():
    scene = automaton(fl.Mode("only", (V, -4 * X - V, -3 * Y)), states=(X, V, Y))
    found = fl.lyapunov(scene, [1.0, 0.0, 1.0], transient=0.0, t_end=300.0, progress=False)
    # Within a turn of the pair its two vectors grow in turns.
    assert found.exponents == pytest.approx([-0.5, -0.5, -3.0], abs=0.01)
    assert found.exponents.sum() == pytest.approx(-4.0, abs=1e-12)
    assert not found.chaotic


def test_stick_takes_all_of_a_direction():
    found = fl.lyapunov(coulomb(0.2, 1.0, 0.5), [0.0, 0.2], transient=50.0, t_end=300.0, progress=False)
    assert found.exponents[0] == pytest.approx(0.0, abs=0.01)
    assert found.exponents[1] == -np.inf
    assert np.isnan(found.standard_errors[1])
    assert not found.chaotic


@pytest.mark.parametrize("geometry", ["flat", "tilted"])
def test_those_of_a_cycle_are_the_logarithms_of_its_multipliers(geometry):
    model = fl.SliderOnBelt(mu_k=1.4, impact=fl.PlasticImpact("full"))
    model = model.without("geometry") if geometry == "flat" else model
    orbit = fl.periodic_orbit(model, fl.simulate(model, 100.0, progress=False))
    options = {"transient": 0.0, "t_end": 300 * orbit.period, "blocks": 6, "progress": False}
    found = fl.lyapunov(model, orbit.state, **options)
    exact = np.log(np.abs(orbit.multipliers[:-1])) / orbit.period
    assert found.exponents[:-1] == pytest.approx(exact, abs=0.02)
    assert found.exponents[:-1].sum() == pytest.approx(exact.sum(), abs=1e-6)
    assert found.exponents[-1] == -np.inf


def test_blocks_may_end_where_a_joint_slips():
    """Each block begins in the mode in which the one before ended; chosen anew it would stick."""
    model, period = fl.JenkinsOscillator(), 2 * np.pi
    settled = fl.steady_state(model, transient=50 * period, window=40 * period, progress=False)
    multipliers = np.abs(fl.periodic_orbit(model, settled).multipliers)
    exact = np.log(np.sort(multipliers)[::-1][:3]) / period
    found = fl.lyapunov(model, transient=50 * period, t_end=100 * period, progress=False)
    assert found.exponents[:3] == pytest.approx(exact, abs=2e-3)


def test_bad_arguments_and_ends():
    with pytest.raises(ValueError, match=r"blocks must be an integer, at least 2, at most 1e\+06, got 1"):
        fl.lyapunov(LORENZ, [1.0, 1.0, 1.0], blocks=1)
    with pytest.raises(ValueError, match="t_end must be a finite number, above 0"):
        fl.lyapunov(LORENZ, [1.0, 1.0, 1.0], t_end=0.0)
    explosion = automaton(fl.Mode("only", (X**2,)), states=(X,), coordinates=0)
    with pytest.raises(ValueError, match="the motion must not end early"):
        fl.lyapunov(explosion, [1.0], transient=0.0, t_end=10.0)
