"""The scenes of the menu are what their sentences say; a link opens one as it was left."""

import numpy as np
import pytest

import frictionlab as fl
from frictionlab.models.library.catalogue import PRESETS, ROW_MODELS
from frictionlab.widgets.scenes import Scenes, scene_models
from tests.helpers.explorers import MODELS

MODEL = {preset.name: preset.model for preset in PRESETS}


def test_the_menu_has_the_scenes_worth_seeing_and_all_models():
    found = scene_models()
    assert list(found) == [*MODEL, *(row.call for row in fl.list_models())]
    assert all(found[name][0] == model for name, model in {**MODEL, **MODELS}.items())
    assert all(about for _, about in found.values())


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
    assert scenes.menu.value == PRESETS[0].name
    assert scenes.explorer.result.is_moving
    assert PRESETS[0].about in scenes.about.value


def test_a_link_opens_the_scene_with_what_was_changed():
    scenes = Scenes(panels=("eigenvalues",))
    scenes.menu.value = "ModeCoupling()"
    for name, value in {"a1": 0.6, "start": "near", "k1": 1 / 3}.items():
        scenes.explorer.controls[name].value = value
    again = Scenes(scenes.link(), panels=("eigenvalues",))
    assert again.menu.value == "ModeCoupling()"
    assert again.explorer.settings == scenes.explorer.settings
    assert again.explorer.model == fl.ModeCoupling(a1=0.6, k1=1 / 3)


@pytest.mark.parametrize(
    ("link", "words"),
    [
        ("?scene=two+fate", "scene in the link must be one of the menu"),
        ("?scene=flutter&mu=3", "control 'mu', got none of that name"),
        ("?mu_k=abc", "mu_k must be one number, got 'abc'"),
        ("?mu_k=-1", "mu_k must be at least 0"),
    ],
)
def test_what_a_link_cannot_say_is_told_in_words(link, words):
    scenes = Scenes(link, panels=("eigenvalues",))
    assert words.replace("'", "&#x27;") in scenes.explorer.layout.message.value.replace("'", "&#x27;")
    assert scenes.explorer.error is None


def test_a_saved_state_opens_its_model():
    other = fl.explore(fl.TwoBlocks(), panels=("eigenvalues",))
    other.controls["v"].value = 0.3
    scenes = Scenes(panels=("eigenvalues",))
    scenes.load(other.files.buttons["save state"].make().content)
    assert (scenes.menu.value, scenes.explorer.model) == ("TwoBlocks()", fl.TwoBlocks(v=0.3))
    own = fl.explore(fl.TwoBlocks(v=0.37), panels=("eigenvalues",))
    scenes.load(own.files.buttons["save state"].make().content)
    assert scenes.explorer.model == fl.TwoBlocks(v=0.37)
    with pytest.raises(ValueError, match="save its state"):
        scenes.link()


def test_no_part_of_a_scene_that_was_left_stays():
    def parts(widget):
        return [widget, *(part for child in getattr(widget, "children", ()) for part in parts(child))]

    scenes = Scenes(panels=("eigenvalues",))
    left = parts(scenes.explorer.widget)
    assert len(left) > 50
    scenes.menu.value = "ModeCoupling()"
    assert [part for part in left if part.comm is not None] == []
    assert all(part.comm is not None for part in parts(scenes.widget))
