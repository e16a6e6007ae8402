"""Every system of the zoo goes through every analysis, or says in a sentence why not."""

import ast
import inspect
import json
import math
import re
from pathlib import Path

import numpy as np
import pytest

import frictionlab as fl
from frictionlab.models.zoo.topics import TOPICS
from frictionlab.models.zoo.zoo_model import ZooModel
from tests.helpers.cases import slow_but

CLASSES = [cls for classes in TOPICS.values() for cls in classes]
FAST = fl.PoppStelter, fl.BallOnTable, fl.DrillString
VARIED = ("v", "Omega", "U", "mu", "e", "F")
NOT_PHYSICS = ("about", "reference", "not_applicable", "period")
MEDIAN_LINES = 12


OF_THE_LIBRARY = fl.ModeCoupling, fl.SliderOnRigidBelt  # N. Hoffmann et al., Z. Li et al.
PAGES = "".join(path.read_text(encoding="utf-8") for path in sorted(Path("docs/zoo").glob("*.md")))


@pytest.fixture(params=slow_but(FAST, (*CLASSES, *OF_THE_LIBRARY)), ids=lambda make: make.__name__)
def model(request):
    return request.param()


def settled(model):
    return fl.simulate(model, 100.3 * model.period, progress=False)


def varied(model):
    return next(name for name in VARIED if name in model.parameters)


def steady_state(model, tmp_path):
    found = fl.steady_state(model, transient=150 * model.period, window=30 * model.period, progress=False)
    assert found.kind in ("equilibrium", "periodic", "non-periodic")


def periodic_orbit(model, tmp_path):
    orbit = fl.periodic_orbit(model, settled(model))
    assert orbit.period > 0
    assert np.isfinite(orbit.multipliers).all()


def continue_orbit(model, tmp_path):
    name = varied(model)
    value = model.parameters[name]
    orbit = fl.periodic_orbit(model, settled(model))
    branch = fl.continue_orbit(orbit, name, (value, 1.01 * value), max_points=2, progress=False)
    assert len(branch.values) > 1


def bifurcation(model, tmp_path):
    name = varied(model)
    values = np.array([0.98, 1.0]) * model.parameters[name]
    times = {"transient": 20 * model.period, "window": 10 * model.period}
    found = fl.bifurcation(model, name, values, progress=False, **times)
    assert "ended early" not in found.kinds


def eigenvalues(model, tmp_path):
    assert np.isfinite(fl.eigenvalues(model).values).all()


def ablation(model, tmp_path):
    def amplitude(alternative):
        run = fl.simulate(alternative, 20 * model.period, progress=False)
        return np.abs(run.q).max() if run.status.ok else math.inf

    found = fl.ablation(model, amplitude, progress=False)
    assert len(found.results) == 2 ** len(model.nonlinearities)
    assert np.isfinite([*found.results]).all()


def energy_audit(model, tmp_path):
    run = fl.simulate(model, 10 * model.period, progress=False)
    assert fl.energy_audit(run, progress=False).error < 1e-10


def simulate(model, tmp_path):
    run = fl.testing.check_model(model, t_end=4 * model.period)
    assert run.status.ok


def animate(model, tmp_path):
    run = fl.simulate(model, 3 * model.period, progress=False)
    assert len(fl.watch(run).picture["samples"]["times"]) > 0
    assert fl.animate(run, fps=1).to_jshtml().count("data:image/png") > 1


def explore(model, tmp_path):
    explorer = fl.explore(model)
    assert explorer.error is None
    explorer.close()


def export_page(model, tmp_path):
    path = tmp_path / "page.html"
    fl.export_page(model, path)
    text = path.read_text(encoding="utf-8")
    assert f"<title>{type(model).__name__}" in text
    assert '"mechanism":true' in text
    for source in (getattr(model, "about", ""), model.reference):
        assert json.dumps(source, ensure_ascii=False)[1:-1] in text


ANALYSES = (
    simulate,
    eigenvalues,
    steady_state,
    periodic_orbit,
    continue_orbit,
    bifurcation,
    ablation,
    energy_audit,
    animate,
    explore,
    export_page,
)
FAST_ANALYSES = simulate, eigenvalues, energy_audit, ablation


@pytest.mark.parametrize("analysis", slow_but(FAST_ANALYSES, ANALYSES), ids=lambda one: one.__name__)
def test_it_takes_every_analysis_or_says_why_not(model, analysis, tmp_path):
    if why := getattr(model, "not_applicable", {}).get(analysis.__name__):
        assert why[0].isupper()
        assert why[-1] == "."
        with pytest.raises((ValueError, AssertionError)):  # a sentence that is no longer true is taken out
            analysis(model, tmp_path)
    else:
        analysis(model, tmp_path)


def test_reasons_are_of_analyses_that_there_are():
    names = {one.__name__ for one in ANALYSES}
    for cls in CLASSES:
        assert set(cls.not_applicable) <= names
        assert cls.about
        assert cls.reference
        assert cls.mechanism is not None


@pytest.mark.parametrize("cls", CLASSES)
def test_its_page_has_its_schematic_its_source_and_facts_that_are_checked(cls):
    (section,) = (
        one for one in PAGES.split("\n## ") if f"\n\n{{py:class}}`~frictionlab.{cls.__name__}`" in one
    )
    assert f"```{{schematic}} {cls.__name__}(" in section
    assert cls.reference  # which stands below the schematic
    assert re.search(r"^ *assert ", section, re.MULTILINE)
    assert "References\n" in (inspect.getdoc(cls) or "")


def lines_of_physics(cls):
    """Lines of the class, its fields, the names of coordinates and states, and `mechanics`; no docstrings."""
    lines = 1
    for node in ast.parse(inspect.getsource(cls)).body[0].body:
        if isinstance(node, ast.FunctionDef) and node.name in ("coordinates", "mechanics"):
            lines += len(node.decorator_list) + 1 + sum(map(lines_of, node.body[1:]))
        elif isinstance(node, (ast.Assign, ast.AnnAssign)):
            (target,) = getattr(node, "targets", None) or [node.target]
            lines += lines_of(node) * (target.id not in NOT_PHYSICS)
    return lines


def lines_of(node):
    return node.end_lineno - node.lineno + 1


def test_a_system_is_said_in_a_few_lines():
    assert np.median([lines_of_physics(cls) for cls in CLASSES]) <= MEDIAN_LINES
    bases = {base for cls in CLASSES for base in cls.__bases__} - {ZooModel}
    assert all(getattr(fl, base.__name__) is base for base in bases)  # no physics is hidden in others


def test_topics_are_listed():
    table = fl.list_models()
    assert table.topics == ("classics", *TOPICS)
    for topic, classes in TOPICS.items():
        assert [row.call for row in fl.list_models(topic)] == [f"{cls.__name__}()" for cls in classes]
    with pytest.raises(ValueError, match=r"topic must be one of 'classics', .*: did you mean 'impacts'"):
        fl.list_models("impact")
