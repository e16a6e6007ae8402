"""Our solver beside reference states and other tools, by the scripts of docs/performance."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

import measure
import page_figures
import pages
import work_precision
from adapters import Cvode, Diffrax, Heyoka, PathSim, SolveIvp
from compared_methods import METHODS, ComparedMethod, InterpretedTaylor, run_regularised
from frictionlab.hybrid.methods.taylor import Taylor
from frictionlab.hybrid.problem import Status
from frictionlab.hybrid.solve import solve
from reference_scenes import FULL_GAP_RATE_SLIDER, ReferenceScene, scenes
from work_precision import WorkPrecisionRow

EXACT = {"A": 1e-10, "B": 1e-10, "C": 1e-10, "D": 1e-9, "Coulomb": 1e-9, "linear": 1e-10}
ABSENT = ComparedMethod("nobody", "nobody's", lambda automaton: Taylor(), "no_such_package")


@pytest.mark.parametrize("name", scenes())
def test_the_solver_reaches_every_reference(name):
    """mpmath with 40 digits for A, B and C; a closed form for Coulomb, the matrix exponential for linear."""
    scene = scenes()[name]
    run = solve(scene.automaton, scene.t_end, x0=scene.x0, progress=False)
    assert scene.error(run.final_state) < EXACT[name]


def shorter(name, t_end):
    """A scene whose reference is the solver's own state."""
    scene = scenes()[name]
    end = solve(scene.automaton, t_end, x0=scene.x0, progress=False)
    return ReferenceScene(name, "", scene.automaton, scene.x0, t_end, lambda: end.final_state), end


OTHERS = {
    "heyoka": (Heyoka, "heyoka"),
    "cvode": (Cvode, "sksundae"),
    "pathsim": (PathSim, "pathsim"),
    "diffrax": (Diffrax, "diffrax"),
    "solve_ivp": (SolveIvp, "scipy"),
    "radau": (partial(SolveIvp, integrator="Radau", rtol=1e-7, atol=1e-10), "scipy"),
}


@pytest.mark.parametrize("other", OTHERS)
@pytest.mark.parametrize("name", ["A", "B", "C", "Coulomb", "linear"])
def test_unlike_tools_find_the_same_events_and_the_same_end(name, other):
    create, package = OTHERS[other]
    pytest.importorskip(package, reason=f"{package} is in docs/performance/requirements.txt")
    scene, exact = shorter(name, {"C": 0.1, "Coulomb": 30.0}.get(name, 0.5))
    method = create(scene.automaton)
    run = solve(scene.automaton, scene.t_end, x0=scene.x0, method=method, progress=False)
    assert run.events.target.tolist() == exact.events.target.tolist()
    assert np.abs(run.events.t - exact.events.t).max(initial=0.0) < 1e-7
    assert scene.error(run.final_state) < 1e-5
    assert method.steps > len(run.events)


def test_a_tool_that_takes_too_many_steps_is_cut_off():
    scene, _ = shorter("B", 0.5)
    method = SolveIvp(scene.automaton, max_steps=40)
    run = solve(scene.automaton, 0.5, x0=scene.x0, method=method, progress=False)
    assert run.status is Status.STEP_CAP
    assert 40 <= method.steps < 200


@pytest.mark.parametrize(("create", "package"), [(PathSim, "pathsim"), (Diffrax, "diffrax")])
def test_a_tool_is_cut_off_within_a_mode(create, package):
    pytest.importorskip(package, reason=f"{package} is in docs/performance/requirements.txt")
    scene, _ = shorter("linear", 0.5)
    method = create(scene.automaton, max_steps=20)
    run = solve(scene.automaton, 0.5, x0=scene.x0, method=method, progress=False)
    assert run.status is Status.STEP_CAP
    assert method.steps == 20
    assert 0.0 < run.raw.t < 0.5


def test_interpreted_it_is_the_same_to_the_last_bit():
    scene, exact = shorter("B", 1.0)
    run = solve(scene.automaton, 1.0, x0=scene.x0, method=InterpretedTaylor(), progress=False)
    assert run.final_state.tolist() == exact.final_state.tolist()
    assert run.stats["steps"] == exact.stats["steps"]


def test_a_smoothed_model_starts_alike_and_ends_elsewhere():
    """No impacts and no stick: the same until the first event, another motion after it."""
    early, *_ = run_regularised(FULL_GAP_RATE_SLIDER, 0.02)
    late, *_ = run_regularised(FULL_GAP_RATE_SLIDER, 1.0)
    exact = [solve(scenes()["B"].automaton, t, x0=np.zeros(10)).final_state for t in (0.02, 1.0)]
    assert np.abs(early - exact[0])[:5].max() < 1e-5
    assert np.abs(late - exact[1])[:5].max() > 1e-2


@pytest.fixture(scope="module")
def rows():
    scene, exact = shorter("B", 0.2)
    scene = replace(scene, events=(len(exact.events), len(exact.events)))
    return work_precision.measure(scene, [*METHODS[:8], ABSENT], repeats=1)


def test_rows_rank_the_methods(rows):
    errors = {row.method: row.error for row in rows}
    assert errors["frictionlab, tol 1e-15"] == 0.0
    assert errors["RK4, step 0.0001 s"] < errors["RK4, step 0.001 s"] / 100


def test_an_absent_tool_is_a_row_that_says_so(rows):
    note = "no_such_package is not installed"
    assert rows[-1] == WorkPrecisionRow("B", "nobody", "nobody's", *[None] * 5, note=note)
    assert f"| nobody's | {note} |" in work_precision.work_precision_table(rows)


def test_steps_and_what_was_missed(rows):
    of = {row.method: row for row in rows}
    assert of["frictionlab, tol 1e-15"].missed == 0
    assert of["frictionlab, tol 1e-15"].steps == of["frictionlab, tol 1e-15, interpreted"].steps > 0
    assert of["RK4, step 0.001 s"].steps > 200
    assert [scenes()["Coulomb"].missed(n) for n in (1998, 1999, 2000, 2001)] == [1, 0, 0, -1]
    assert scenes()["D"].missed(15) is None


def test_one_scene_as_printed(monkeypatch, tmp_path, capsys, rows):
    monkeypatch.setattr(work_precision, "measure", lambda scene, repeats: rows)
    files = tmp_path / "b.json", tmp_path / "b.png"
    measure.main(["--scene", "B", "--json", str(files[0]), "--picture", str(files[1])])
    assert capsys.readouterr().out.startswith("\nB: with it, full gap rate, 20 s\n")
    assert all(path.stat().st_size > 500 for path in files)


def test_the_page_has_all_scenes_and_parts(tmp_path, rows):
    every = [replace(row, scene=name) for name in scenes() for row in rows]
    parts = pages.scene_parts(every, "today")
    parts |= {title: pages.part(title, f"| table of {title} |", "today") for title in pages.PARTS}
    text = pages.write_performance(tmp_path, parts).read_text(encoding="utf-8")
    assert text.count("frictionlab, tol 1e-15 |") == 6
    places = [text.index(f"| table of {title} |") for title in pages.PARTS]
    assert places == sorted(places)
    again = pages.write_performance(tmp_path, {"Starting": pages.part("Starting", "| new |", "later")})
    assert again.read_text(encoding="utf-8") == text.replace(
        parts["Starting"], pages.part("Starting", "| new |", "later")
    )
    labels = [line.get_label() for line in page_figures.draw_work_precision(rows).axes[0].lines]
    assert labels == ["frictionlab", "frictionlab, interpreted", "RK4"]
