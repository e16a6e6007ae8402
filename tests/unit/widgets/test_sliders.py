"""Sliders say what the parameter's metadata say."""

import numpy as np
import pytest

import frictionlab as fl
from frictionlab.components import Parameter
from frictionlab.models.composition import parameter_metadata
from frictionlab.widgets.number_control import equal_within_rounding, remove_browser_rounding, slider

pytestmark = pytest.mark.plain_python

MODEL = fl.SliderOnBelt()
ABOUT = parameter_metadata(type(MODEL), MODEL.components)


def test_the_range_is_made_wide_enough_for_the_value():
    assert slider("mu_k", ABOUT["mu_k"], 3.7).max == 3.7
    assert slider("k5", ABOUT["k5"], 20.0).min == 20.0
    assert slider("v", ABOUT["v"], -8.0).min == -8.0


def test_a_logarithmic_slider_cannot_be_at_zero_so_it_is_linear_there():
    made = slider("k_nl", ABOUT["k_nl"], 0.0)
    assert (made.min, made.value, made.max) == (0.0, 0.0, 1e8)


@pytest.mark.parametrize("value", [-2.0, 0.0, 1e-3, 5.0])
def test_a_parameter_without_a_range_gets_one_about_its_value(value):
    made = slider("a", Parameter("a"), value)
    assert made.min <= value < made.max
    assert np.isfinite([made.min, made.max]).all()


def test_the_guessed_range_keeps_to_the_bounds():
    made = slider("a", Parameter("a", exclusive_minimum=0.0, maximum=3.0), 2.0)
    assert 0.0 < made.min < 2.0 < made.max <= 3.0


@pytest.mark.parametrize("value", [np.pi / 6, np.radians(150.0), np.pi / 4, 1 / 3])
def test_a_value_that_is_not_round_is_a_position_to_the_last_bit(value):
    angle = Parameter("a", "rad", range=(-np.pi, np.pi))
    positions = slider("a", angle, value).positions
    assert value in positions
    assert (positions[0], positions[-1]) == (-np.pi, np.pi)
    assert {-1.0, 0.0, 0.55, 3.1} < set(positions)


def test_steps_are_round_numbers():
    made = [slider(name, ABOUT[name], MODEL.parameters[name]) for name in ("mu_k", "F", "l1")]
    steps = [np.diff(one.positions[1:-1]) for one in made]
    assert [step.min() for step in steps] == pytest.approx([0.01, 5.0, 0.002])
    assert [step.max() for step in steps] == pytest.approx([0.01, 5.0, 0.002])


@pytest.mark.parametrize("name", [name for name in MODEL.parameters if ABOUT[name].log])
def test_a_logarithmic_slider_has_fifty_positions_a_decade(name):
    positions = np.array(slider(name, ABOUT[name], MODEL.parameters[name]).positions)
    ratios = positions[1:] / positions[:-1]
    assert ratios.max() == pytest.approx(10**0.02, rel=6e-3)  # of three digits
    assert all(power in positions for power in 10.0 ** np.arange(*np.log10(ABOUT[name].range)))


def test_rounding_is_undone_and_nothing_else():
    assert remove_browser_rounding(20.000000000000004, 5.0) == 20.0
    assert remove_browser_rounding(0.30000000000000004, 5.0) == 0.3
    assert remove_browser_rounding(1.23456789012 * (1 + 1e-12), 1.23456789012) == 1.23456789012
    for own in (1 / 3, 1.0 + 1e-10, 0.0, -2.5):
        assert remove_browser_rounding(own, 7.0) == own
    assert equal_within_rounding((0.0, 1.0), (0.0, 1.0 + 1e-13))
    assert not equal_within_rounding((0.0, 1.0), (0.0, 1.1))
    assert not equal_within_rounding(None, 1.0)
    assert not equal_within_rounding(True, False)
