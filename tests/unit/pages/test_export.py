"""What `export_page` refuses, and what its controls are made of."""

import base64
import hashlib
from html.parser import HTMLParser

import numpy as np
import pytest

import frictionlab as fl
from frictionlab.cli import command
from frictionlab.compilation import manifest
from frictionlab.compilation.kernel_sources import digest
from frictionlab.pages import export, page_data
from frictionlab.pages.gallery import LibraryScene, export_gallery
from frictionlab.pages.page_data import chosen_sliders, scene_menu, structures, switch_names
from frictionlab.pages.python_text import python_text
from frictionlab.pages.scene import controls_of_models, shown_model
from frictionlab.plotting.appearance import mode_looks


def test_all_eight_structures_of_the_slider_are_there():
    found = structures(fl.SliderOnBelt(), ("cubic", "nonsmooth", "geometry"))
    assert len(found) == 8
    assert found["cubic,geometry"] == fl.SliderOnBelt().without("cubic", "geometry")


def test_a_nonlinearity_that_the_model_is_without_has_no_switch():
    assert switch_names(fl.SliderOnBelt().without("cubic"), None) == ("nonsmooth", "geometry")


def test_chosen_sliders_come_first_and_all_parameters_are_there():
    model = fl.SliderOnBelt(mu_k=1.4)
    found = controls_of_models([model], *chosen_sliders(model, {"F": (0.0, 1000.0)}))
    assert found[0]["name"] == "F"
    assert (found[0]["low"], found[0]["high"]) == (0.0, 1000.0)
    assert [each["group"] for each in found] == ["main"] + ["structure"] * (len(model.parameters) - 1)
    assert {each["name"] for each in found} == {*model.parameters}


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"sliders": ["mu_x"]}, "sliders has no parameter 'mu_x'"),
        ({"switches": ["cubik"]}, "switches has no nonlinearity 'cubik'"),
        ({"presets": {"a": {"without": ["cubik"]}}}, "has no switch 'cubik'"),
        ({"t_end": -1.0}, "t_end must be"),
        ({"sliders": {"F": (3.0, 1.0)}}, "range of slider 'F'"),
    ],
)
def test_bad_options_are_named_before_anything_is_written(options, text, tmp_path):
    with pytest.raises(ValueError, match=text):
        fl.export_page(fl.SliderOnBelt(), tmp_path / "page.html", **options)
    assert not list(tmp_path.iterdir())


def test_presets_keep_values_and_switches():
    _, found = scene_menu(fl.SliderOnBelt(), ("geometry",), {"a": {"mu_k": 2, "without": "geometry"}})
    assert found == {"name": "a", "state": {"mu_k": 2.0, "switch-geometry": False}}


def test_without_the_solver_the_error_says_how_to_build_it(monkeypatch, tmp_path):
    monkeypatch.setattr(manifest, "FOLDERS", ())
    with pytest.raises(export.SolverNotBuiltError, match=r"not been compiled ahead of time: .* --web` once"):
        fl.export_page(fl.MassOnBelt(), tmp_path / "page.html")


def test_a_solver_older_than_the_kernels_is_refused(monkeypatch, tmp_path):
    old = manifest.Manifest(
        {"hybrid/solve.py": manifest.Source("", "", ())}, objects={"kernels.wasm": digest(b"")}
    )
    monkeypatch.setattr(manifest, "read_manifest", lambda folder: old)
    with pytest.raises(export.SolverNotBuiltError, match=r"have changed since .*solve\.py.* --web` once"):
        fl.export_page(fl.MassOnBelt(), tmp_path / "page.html")


class Elements(HTMLParser):
    """The texts of scripts and styles of a page, its title, and its security policy."""

    def __init__(self, page):
        super().__init__()
        self.texts, self.policy, self._open = {"script": [], "style": [], "title": []}, "", ""
        self.feed(page)

    def handle_starttag(self, tag, attrs):
        attributes = dict(attrs)
        self._open = tag
        if tag in self.texts:
            self.texts[tag].append("")
        if attributes.get("http-equiv") == "Content-Security-Policy":
            self.policy = attributes["content"]
        assert not any(name.startswith("on") or name == "style" for name in attributes)  # the policy forbids

    def handle_data(self, data):
        if self._open in self.texts:
            self.texts[self._open][-1] += data

    def handle_endtag(self, tag):
        self._open = ""


@pytest.mark.parametrize("title", ["a <!--<script> b", "</script><script>alert(1)</script>", "<!--SCRIPT-->"])
def test_a_page_may_run_its_own_scripts_and_nothing_else(title):
    """The digests are computed anew from what a parser of HTML takes for scripts and styles."""
    constants = {"SCENE": {"title": title}, "SOLVER": {"module": "", "tables": {}}}
    page = Elements(export.html_page(title, constants, export.script_text(export.SCRIPTS)))
    assert page.texts["title"] == [title]
    assert [len(page.texts[kind]) for kind in ("script", "style")] == [1, 1]
    assert not any("<!--" in text for text in page.texts["script"])  # such a text would hide their end
    rules = dict(rule.split(" ", 1) for rule in page.policy.split("; "))
    own = {
        kind: [base64.b64encode(hashlib.sha256(text.encode()).digest()).decode() for text in texts]
        for kind, texts in page.texts.items()
    }
    assert rules == {
        "default-src": "'none'",
        "script-src": " ".join([f"'sha256-{digest}'" for digest in own["script"]] + ["'wasm-unsafe-eval'"]),
        "style-src": f"'sha256-{own['style'][0]}'",
        "base-uri": "'none'",
        "form-action": "'none'",
    }


OSCILLATOR = LibraryScene("FreeCoulomb()", "classics", fl.FreeCoulomb(), "dry friction alone")
BALL = LibraryScene("BouncingBall()", "classics", fl.BouncingBall(), "infinitely many impacts")


def test_a_page_is_written_once_and_what_has_none_is_said_in_the_index(tmp_path, monkeypatch):
    first = export_gallery(tmp_path / "pages", [OSCILLATOR])
    assert (first.written, first.present, first.refused) == (("FreeCoulomb()",), (), {})
    page = tmp_path / "pages" / "FreeCoulomb.html"
    before = page.stat().st_mtime_ns
    monkeypatch.setattr(page_data, "MAX_MODES", 0)
    again = export_gallery(tmp_path / "pages", [OSCILLATOR, BALL])
    assert (again.written, again.present) == ((), ("FreeCoulomb()",))
    assert page.stat().st_mtime_ns == before
    assert list(again.refused) == ["BouncingBall()"]
    assert again.refused["BouncingBall()"] in again.index.read_text(encoding="utf-8")
    page.write_text("of another version", encoding="utf-8")
    assert export_gallery(tmp_path / "pages", [OSCILLATOR]).refused.keys() == {"FreeCoulomb()"}


@pytest.mark.parametrize("options", [["-o", "a.html"], ["--model", "DenHartog"], ["--set", "m=2"]])
def test_a_folder_of_all_has_no_option_of_one_model(options, tmp_path, capsys):
    with pytest.raises(SystemExit):
        command.main(["page", "--all", str(tmp_path), *options])
    assert f"--all must have no {options[0]}" in capsys.readouterr().err


class Coulomb(fl.Coulomb):
    """Of its user, who calls it as the package calls another."""


class HalfSteps(fl.OneStepMethod):
    """A method of its user."""


def test_copied_python_has_the_classes_of_its_user():
    model, start = fl.MassOnBelt(friction=Coulomb(0.2, 0.3)), np.array([0.0, 1.0])
    text = python_text(model, np.float64(2.0), start, HalfSteps(step=np.float64(0.5)))
    assert text.splitlines() == [
        "import frictionlab as fl",
        f"from {__name__} import HalfSteps",
        f"from {__name__} import Coulomb",
        "model = fl.MassOnBelt(friction=Coulomb(mu_k=0.2, mu_s=0.3))",
        "run = fl.simulate(model, 2.0, x0=[0.0, 1.0], method=HalfSteps(step=0.5))",
    ]


def test_copied_python_calls_a_structure_a_structure():
    structure = fl.Structure([[1.0]], lambda k: k * np.eye(1), parameters={"k": 2.0})
    shown, start = shown_model(structure.replace(k=np.float64(3.0)), [0.0, 1.0], "")
    scope = {"structure": structure}
    exec(python_text(shown, 1.0, start, fl.Taylor()), scope)
    assert scope["model"].parameters == {"k": 3.0}
    assert scope["run"].final_state == pytest.approx([np.sin(3**0.5) / 3**0.5, np.cos(3**0.5)])


@pytest.mark.parametrize("model", [fl.BoltedJoint(), fl.OscillatorChain()], ids=lambda m: type(m).__name__)
def test_modes_look_on_a_page_as_in_figures(model):
    """A page has all modes, a run those that it came to, which it derives in another order."""
    data = page_data.structure_data(model)
    shown = dict(zip(data["modes"], zip(data["colours"], data["dashes"], strict=True), strict=True))
    looks = mode_looks(fl.simulate(model, 10.0, progress=False))
    assert len(looks) > 1
    assert {name: shown[name] for name in looks} == {n: (m.colour, list(m.dashes)) for n, m in looks.items()}
