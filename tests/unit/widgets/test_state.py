"""Undo and redo, saved states, and what an explorer gives away as files."""

import io
import json
import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import frictionlab as fl
from frictionlab.widgets.panels.picture import PANEL_WIDTH
from frictionlab.widgets.state import PRINT_DPI, History
from tests.helpers.explorers import made


@pytest.fixture
def short():
    return made(fl.SliderOnBelt(mu_k=1.4), ("phase",), 2.0)


@pytest.fixture(scope="module")
def unchanged():
    """One for all tests that change no value."""
    return made(fl.SliderOnBelt(mu_k=1.4), ("phase",), 2.0)


def test_undo_and_redo_go_through_all_states(short):
    models = [short.model]
    for name, value in {"mu_k": 0.5, "switch-cubic": False, "F": 300.0}.items():
        short.controls[name].value = value
        models.append(short.model)
    for expected in (*models[-2::-1],):
        short.layout.undo.click()
        assert short.model == expected
    for expected in models[1:]:
        short.layout.redo.click()
        assert short.model == expected
    assert short.layout.redo.disabled
    short.layout.undo.click()
    short.controls["F"].value = 250.0
    assert short.layout.redo.disabled  # what had been undone is forgotten


def test_after_an_error_undo_gives_the_last_values_that_worked(short):
    short.controls["mu_s"].value = 1.0
    assert short.error is not None
    short.layout.undo.click()
    assert short.error is None
    assert short.model == fl.SliderOnBelt(mu_k=1.4)


def test_the_steps_of_one_drag_are_undone_together(monkeypatch):
    clock = [0.0]
    monkeypatch.setattr("frictionlab.widgets.state.time.monotonic", lambda: clock[0])
    history = History()
    for seconds, state in ((0.0, {"a": 0, "b": 0}), (5.0, {"a": 1, "b": 0}), (5.1, {"a": 2, "b": 0})):
        clock[0] = seconds
        history.record(state)
    clock[0] = 9.0
    history.record({"a": 3, "b": 0})
    assert [state["a"] for state in history.states] == [0, 2, 3]
    assert history.initial == {"a": 0, "b": 0}


def test_a_state_that_was_saved_is_loaded_again(short):
    short.controls["impact"].label = "restitution"
    for name, value in {"e": 0.35, "mu_k": 1.27, "switch-geometry": False, "start": "near"}.items():
        short.controls[name].value = value
    content = short.files.buttons["save state"].make().content
    other = fl.explore(fl.SliderOnBelt(mu_k=1.4), panels=("eigenvalues",))
    other.load(content)
    assert other.settings == short.settings
    assert other.model == fl.SliderOnBelt(mu_k=1.27, impact=fl.RestitutionImpact(e=0.35)).without("geometry")


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"no json", "must be one that an explorer saved"),
        (b"{}", "must be one that an explorer saved"),
        (b'{"format": "other", "model": {}, "changed": {}}', "got the format 'other'"),
    ],
)
def test_what_is_no_state_is_refused_in_words(unchanged, content, words):
    before = unchanged.values()
    unchanged.layout.message.value = ""
    unchanged.files.load_state({"new": ({"content": content},)})
    assert words in unchanged.layout.message.value
    assert unchanged.values() == before


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"mu_kk": 1.0}, "control 'mu_kk', got none of that name: did you mean 'mu_k'"),
        ({"mu_k": 0.7, "F": "abc"}, "F must be one number, got 'abc'"),
        ({"mu_k": -1.0}, "mu_k must be at least 0, got -1.0"),
        ({"mu_k": float("nan")}, "mu_k must be a finite number"),
        ({"start": "sideways"}, "start must be a value of its control, got 'sideways'"),
        ({"switch-cubic": "perhaps"}, "switch-cubic must be a value of its control"),
    ],
)
def test_values_that_cannot_be_set_change_nothing(unchanged, values, words):
    before, model = unchanged.values(), unchanged.model
    with pytest.raises(ValueError, match=words):
        unchanged.set_values(values)
    assert (unchanged.values(), unchanged.model) == (before, model)


def test_the_figure_is_saved_with_its_curves(unchanged):
    svg = unchanged.files.buttons["figure svg"].make()
    assert (svg.name, svg.type) == ("SliderOnBelt.svg", "image/svg+xml")
    assert svg.content.startswith(b"<?xml")
    colour = unchanged.picture.tiles["phase"].lines["stick"].get_color()
    assert colour.lower().encode() in svg.content.lower()
    assert unchanged.files.buttons["figure pdf"].make().content.startswith(b"%PDF")


def test_the_figure_is_saved_on_white_paper_from_a_dark_page_too(short):
    short.controls["compare"].value = True
    light = short.files.buttons["figure svg"].make().content
    short.layout.screen.set_state({"pixels": 440, "dark": True})
    dark = short.files.buttons["figure svg"].make().content
    assert colours(dark) == colours(light)
    assert {b"#ffffff", b"#000000"} <= colours(dark)
    png = Image.open(io.BytesIO(short.files.buttons["figure png"].make().content)).convert("RGB")
    assert png.getpixel((1, 1)) == (255, 255, 255)
    assert png.width == round(PRINT_DPI * PANEL_WIDTH)
    shown = Image.open(io.BytesIO(short.picture.images["phase"].value)).convert("RGB")
    assert shown.getpixel((1, 1)) == (17, 17, 17)


def colours(svg):
    return set(re.findall(rb"(?:fill|stroke): (#[0-9a-f]{6})", svg))


def test_data_are_saved_with_all_digits(unchanged):
    content = unchanged.files.buttons["data csv"].make().content.decode()
    head, *rows = content.splitlines()
    names = head.split(",")
    t = np.array([float(row.split(",")[0]) for row in rows])
    x = np.array([float(row.split(",")[names.index("phi'")]) for row in rows])
    assert np.array_equal(t, unchanged.result.times())
    assert np.array_equal(x, unchanged.run(t)[:, unchanged.run.names.index("phi'")])
    assert [row.split(",")[-1] for row in rows] == list(unchanged.result.modes)


def test_parquet_holds_the_same(unchanged):
    pandas = pytest.importorskip("pandas", reason="pandas reads parquet; it is not installed")
    pytest.importorskip("pyarrow", reason="pyarrow reads parquet; it is not installed")
    table = pandas.read_parquet(io.BytesIO(unchanged.files.buttons["data parquet"].make().content))
    assert np.array_equal(table["x1"], unchanged.result.state("x1"))
    assert list(table["mode"]) == list(unchanged.result.modes)


def test_a_button_sends_a_file_and_tells_what_fails(unchanged, monkeypatch):
    sent, button = [], unchanged.files.buttons["save state"]
    monkeypatch.setattr(button, "send", lambda *message: sent.append(message))
    button._handle_custom_msg({"asked": True}, [])
    (about, (content,)) = sent[0]
    assert about == {"name": "SliderOnBelt.json", "type": "application/json"}
    assert json.loads(content)["changed"] == {"duration": 2.0}
    monkeypatch.setattr(button, "make", lambda: Path("/no/such/file").read_text())
    button._handle_custom_msg({"asked": True}, [])
    assert "FileNotFoundError" in unchanged.layout.message.value
