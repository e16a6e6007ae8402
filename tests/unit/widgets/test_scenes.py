"""The scenes of the menu are what their sentences say; a link opens one as it was left."""

import numpy as np
import pytest

import frictionlab as fl
from frictionlab.models.library.catalogue import PRESETS, ROW_MODELS
from frictionlab.pages.gallery import library_scenes
from frictionlab.widgets.scenes import Scenes
from tests.helpers.explorers import MODELS

MODEL = {preset.name: preset.model for preset in PRESETS}


def test_the_menu_has_the_scenes_worth_seeing_and_all_models():
    found = {each.name: each for each in library_scenes()}
    assert list(found) == [*MODEL, *(row.call for row in fl.list_models())]
    assert all(found[name].model == model for name, model in {**MODEL, **MODELS}.items())
    assert all(each.about for each in found.values())
    assert len({each.file for each in found.values()}) == len(found)


def test_the_menus_models_are_those_that_the_calls_make():
    assert dict(zip(MODELS, ROW_MODELS, strict=True)) == MODELS


def test_two_fates():
    model = MODEL["two fates"]
    assert fl.eigenvalues(model).stable
    rest, near = (fl.simulate(model, 20.0, x0=x0, progress=False) for x0 in ("rest", "near"))
    t = np.linspace(19.0, 20.0, 200)
    assert np.ptp(rest(t)[:, 0]) > 100 * np.ptp(near(t)[:, 0])


def test_flutter():
    found = fl.eigenvalues(MODEL["flutter"])
    worst = found.values[np.argmax(found.values.real)]
    assert worst.real > 1.0
    assert abs(worst.imag) > 1.0
    run = fl.simulate(MODEL["flutter"], 10.0, progress=False)
    assert "separation" in run.events.target


def test_stick_slip():
    run = fl.simulate(MODEL["stick-slip"], 200.0, progress=False)
    late = run.events.target[run.events.t > 150.0]
    assert {"stick", "slip+"} <= set(late)


@pytest.mark.slow
def test_chaos():
    spectrum = fl.lyapunov(MODEL["chaos"], transient=200.0, t_end=3000.0, progress=False)
    assert spectrum.chaotic


def test_grazing_by_its_closed_form():
    model = MODEL["grazing"]
    amplitude = model.F / np.hypot(model.k - model.m * model.Omega**2, model.c * model.Omega)
    assert amplitude < model.d < 1.001 * amplitude
    assert amplitude > 0.4
    for d, strikes in ((model.d, False), (0.4, True)):
        run = fl.simulate(model.replace(d=d), 400.0, progress=False)
        assert bool(np.any((run.events.guard == "impact") & (run.events.t > 350.0))) is strikes


def test_the_first_scene_moves():
    scenes = Scenes(panels=("response",))
    assert scenes.widget.scene["name"] == PRESETS[0].name
    assert scenes.widget.scene["about"] == PRESETS[0].about
    assert scenes.explorer.result.is_moving


def test_a_browser_opens_a_scene_with_what_was_changed():
    scenes = Scenes(panels=("eigenvalues",))
    left = scenes.explorer
    changed = {"a1": 0.6, "start": "near", "k1": 1 / 3}
    scenes.widget._handle_custom_msg({"open": {"name": "ModeCoupling()", "changed": changed}}, [])
    assert scenes.widget.scene["name"] == "ModeCoupling()"
    assert scenes.explorer.model == fl.ModeCoupling(a1=0.6, k1=1 / 3)
    assert scenes.widget.state == scenes.explorer.values()
    updates = left.updates
    scenes.widget.set_state({"state": scenes.explorer.values() | {"a1": 0.7}})
    assert (scenes.explorer.model.a1, left.updates) == (0.7, updates)


@pytest.mark.parametrize(
    ("name", "changed", "words"),
    [
        ("two fate", {}, "scene must be one of the menu, got 'two fate': did you mean 'two fates'"),
        ("flutter", {"mu": 3.0}, "control 'mu', got none of that name"),
        ("flutter", {"mu_k": -1.0}, "mu_k must be at least 0"),
    ],
)
def test_what_cannot_be_opened_is_told_in_words(name, changed, words):
    scenes = Scenes(panels=("eigenvalues",))
    scenes.widget._handle_custom_msg({"open": {"name": name, "changed": changed}}, [])
    assert words in scenes.widget.error
