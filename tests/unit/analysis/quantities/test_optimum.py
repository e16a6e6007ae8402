"""Optima by exact gradients, against closed forms and searches on grids."""

import numpy as np
import pytest

import frictionlab as fl

FREE = float("inf")


def test_the_least_damping_that_keeps_coupled_modes_quiet():
    """Where the growth rate is zero: by halving."""
    model = fl.ModeCoupling(mu_k=0.53)
    low, high = 0.01, 1.0
    for _ in range(30):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if fl.GrowthRate()(model.replace(c=middle)) > 0 else (low, middle)
    assert 0.1 < low < 0.2
    quiet = (fl.GrowthRate(), -FREE, 0.0)
    found = fl.optimum(model.replace(c=0.4), fl.ParameterValue("c"), {"c": (0.01, 1.0)}, [quiet])
    assert found["c"] == pytest.approx(low, rel=1e-6)
    assert found.active == ("largest growth rate (1/s)",)


def test_of_two_dampers_none_on_a_grid_are_better():
    """No pair of dampers on a grid has a smaller growth rate."""
    model = fl.SliderOnBelt(mu_k=1.6)
    bounds = {"c1": (0.1, 5.0), "c2": (0.1, 5.0)}
    found = fl.optimum(model, fl.GrowthRate(), bounds)
    c1, c2 = (column.ravel() for column in np.meshgrid(*(np.linspace(*b, 15) for b in bounds.values())))
    best = fl.GrowthRate().values(model, {"c1": c1, "c2": c2}).min()
    assert found.value <= best + 1e-9 * abs(best)


def test_the_slowest_stick_slip_of_a_given_amplitude():
    """T = 2 a/v + (2 pi - 2 atan(a w/v))/w grows with a = (mu_s - mu_k) N/k; X^2 = a^2 + v^2/w^2 holds it."""
    model = fl.MassOnBelt(v=0.3)
    largest = 0.7
    amplitude = (fl.OrbitAmplitude("x"), -FREE, largest)
    found = fl.optimum(model, fl.OrbitPeriod(), {"mu_s": (0.7, 1.5)}, [amplitude], goal="largest")
    a = np.sqrt(largest**2 - 0.3**2)
    assert found["mu_s"] == pytest.approx(0.5 + a, rel=1e-8)
    assert found.value == pytest.approx(2 * a / 0.3 + 2 * np.pi - 2 * np.arctan(a / 0.3), rel=1e-8)
    assert found.active == (amplitude[0].label,)


def test_a_bound_that_holds_is_named():
    found = fl.optimum(fl.MassOnBelt(), fl.EquilibriumCoordinate("x"), {"k": (0.5, 2.0)})  # mu_k N/k
    assert (found["k"], found.value) == (pytest.approx(2.0), pytest.approx(0.25))
    assert found.active == ("k at most 2",)
