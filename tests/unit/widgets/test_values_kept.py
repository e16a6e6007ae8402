"""To show an explorer changes no value: what a browser makes of every control, in every model."""

import ipywidgets
import pytest

import frictionlab as fl
from frictionlab.widgets.number_control import NumberControl
from tests.helpers.cases import slow_but
from tests.helpers.explorers import MODELS

KINDS = NumberControl, ipywidgets.Checkbox, ipywidgets.Dropdown, ipywidgets.Text, ipywidgets.ToggleButton


def told_by_browser(control):
    """The value that a browser has after showing a control, by how it shows it."""
    if isinstance(control, NumberControl):
        values = control.positions
        return values[min(range(len(values)), key=lambda i: abs(values[i] - control.value))]
    if isinstance(control, ipywidgets.FloatRangeSlider):
        low, step = control.min, control.step
        return tuple(low + round((value - low) / step) * step for value in control.value)
    assert isinstance(control, KINDS)
    return control.value


@pytest.fixture(params=slow_but(["SliderOnBelt()", "BouncingBall()", "DenHartog()"], MODELS), scope="module")
def explorer(request):
    explorer = fl.explore(MODELS[request.param], panels=("eigenvalues",))
    assert explorer.model == MODELS[request.param]
    yield explorer
    explorer.close()


def test_showing_an_explorer_changes_nothing(explorer):
    model, settings, updates = explorer.model, explorer.settings, explorer.updates
    for name, control in explorer.controls.items():
        if not hasattr(control, "value"):
            continue
        told = told_by_browser(control)
        assert told == control.value, name
        if isinstance(control, NumberControl):
            control.field.value = told
        else:
            control.value = told
    assert (explorer.settings, explorer.updates) == (settings, updates)
    assert explorer.model == model


def test_every_control_gives_back_the_value_that_is_set(explorer):
    model = explorer.model
    with explorer.scheduler.batch():
        for control in explorer.parameters.sliders.values():
            before = control.value
            for value in (*control.positions[:: max(1, len(control.positions) // 7)], before):
                control.value = value
                assert told_by_browser(control) == control.field.value == value
    assert explorer.model == model


@pytest.mark.slow
def test_the_range_of_a_diagram_comes_back_from_a_browser_without_a_change():
    explorer = fl.explore_bifurcation(fl.ModeCoupling(), "a1")
    explorer.scheduler.cancel()
    updates, found = explorer.updates, dict(explorer.picture.panels["bifurcation"].steady_states)
    explorer.controls["range"].value = told_by_browser(explorer.controls["range"])
    assert explorer.model == fl.ModeCoupling()
    assert explorer.updates == updates
    assert explorer.picture.panels["bifurcation"].steady_states == found
    explorer.close()
