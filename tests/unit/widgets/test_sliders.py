"""Sliders say what the parameter's metadata say; their positions are round numbers and the value itself."""

import json

import numpy as np
import pytest

import frictionlab as fl
from frictionlab.components import Parameter
from frictionlab.models.composition import parameter_metadata
from frictionlab.pages.export import text_of
from frictionlab.pages.scene import number
from frictionlab.widgets.controls import Control
from tests.helpers.cases import slow_but
from tests.helpers.explorers import MODELS
from tests.unit.pages.test_javascript import run_in_node

pytestmark = pytest.mark.plain_python

MODEL = fl.SliderOnBelt()
ABOUT = parameter_metadata(type(MODEL), MODEL.components)


def slider(name, about, value):
    return Control(number(name, about, value, "main"), rule=about)


def positions_of(abouts):
    """The positions of sliders as a browser makes them."""
    code = text_of("controls.js").replace("function nearest", "function nearestPosition")
    given = json.dumps([[a["low"], a["high"], a["value"], a["log"]] for a in abouts])
    return run_in_node(f"{code} console.log(JSON.stringify({given}.map((a) => sliderPositions(...a))))")


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


def test_a_value_that_is_not_round_is_a_position_to_the_last_bit():
    angle, values = Parameter("a", "rad", range=(-np.pi, np.pi)), (np.pi / 6, np.radians(150.0), 1 / 3)
    for value, positions in zip(values, positions_of([number("a", angle, v, "main") for v in values])):
        assert value in positions
        assert (positions[0], positions[-1]) == (-np.pi, np.pi)
        assert {-1.0, 0.0, 0.55, 3.1} < set(positions)


def test_steps_are_round_numbers():
    abouts = [number(name, ABOUT[name], MODEL.parameters[name], "main") for name in ("mu_k", "F", "l1")]
    steps = [np.diff(positions[1:-1]) for positions in positions_of(abouts)]
    assert [step.min() for step in steps] == pytest.approx([0.01, 5.0, 0.002])
    assert [step.max() for step in steps] == pytest.approx([0.01, 5.0, 0.002])


def test_a_logarithmic_slider_has_fifty_positions_a_decade():
    names = [name for name in MODEL.parameters if ABOUT[name].log]
    for name, found in zip(
        names, positions_of([number(n, ABOUT[n], MODEL.parameters[n], "") for n in names])
    ):
        positions = np.array(found)
        ratios = positions[1:] / positions[:-1]
        assert ratios.max() == pytest.approx(10**0.02, rel=6e-3)  # of three digits
        assert all(power in positions for power in 10.0 ** np.arange(*np.log10(ABOUT[name].range)))


@pytest.mark.parametrize("name", slow_but(["SliderOnBelt()", "DenHartog()"], MODELS))
def test_every_value_of_every_model_is_a_position_of_its_slider(name):
    explorer = fl.explore(MODELS[name], panels=("eigenvalues",))
    abouts = [one.about for one in explorer.controls.values() if one.about["kind"] == "number"]
    for about, positions in zip(abouts, positions_of(abouts)):
        assert about["value"] in positions
        assert positions == sorted(positions)
    assert explorer.model == MODELS[name]


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("0,5", 0.5),
        ("2e2", 200.0),
        ("\u22123", -3.0),
        ("1,234", None),
        ("abc", None),
        ("", None),
        ("1 2", None),
    ],
)
def test_a_number_is_typed_with_point_or_comma(text, found):
    attempt = f"try {{ said = typedNumber({json.dumps(text)}) }} catch (error) {{ said = error.message }}"
    said = run_in_node(f"{text_of('controls.js')} let said; {attempt}; console.log(JSON.stringify(said))")
    assert said == found or (found is None and "write" in said)
