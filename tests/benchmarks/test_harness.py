"""Run time against error: complete rows, real errors, unlike tools agree; nothing looks at a clock."""

from dataclasses import replace

import numpy as np
import pytest

from frictionlab import cli
from frictionlab.bench import harness, page, picture, regularised, switches
from frictionlab.bench.harness import Row, Way
from frictionlab.bench.scenes import BenchScene, scenes
from frictionlab.bench.with_cvode import Cvode
from frictionlab.bench.with_heyoka import Heyoka
from frictionlab.bench.with_scipy import SolveIvp
from frictionlab.hybrid.solve import solve
from frictionlab.hybrid.taylor import Taylor

EXACT = {"A": 1e-10, "B": 1e-10, "C": 1e-10, "D": 1e-9, "Coulomb": 1e-9, "linear": 1e-10}
ABSENT = Way("nobody", "nobody's", lambda automaton: Taylor(), "no_such_package")


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
    return BenchScene(name, "", scene.automaton, scene.x0, t_end, lambda: end.final_state), end


@pytest.mark.parametrize("name", ["A", "B", "C", "Coulomb", "linear"])
@pytest.mark.parametrize("other", ["heyoka", "cvode", "solve_ivp"])
def test_unlike_tools_find_the_same_events_and_the_same_end(name, other):
    scene, exact = shorter(name, 0.5 if name != "Coulomb" else 30.0)
    if other == "heyoka":
        pytest.importorskip("heyoka", reason="heyoka comes with the extra bench")
    if other == "cvode":
        pytest.importorskip("sksundae", reason="CVODE comes with the extra bench")
    method = {"heyoka": Heyoka, "cvode": Cvode, "solve_ivp": SolveIvp}[other](scene.automaton)
    run = solve(scene.automaton, scene.t_end, x0=scene.x0, method=method, progress=False)
    assert run.events.target.tolist() == exact.events.target.tolist()
    assert np.abs(run.events.t - exact.events.t).max(initial=0.0) < 1e-7
    assert scene.error(run.final_state) < 1e-5


def test_a_smoothed_model_starts_alike_and_ends_elsewhere():
    """No impacts and no stick: the same until the first event, another motion after it."""
    early, _ = regularised.run(switches.SCENE, 0.02)
    late, _ = regularised.run(switches.SCENE, 1.0)
    exact = [solve(scenes()["B"].automaton, t, x0=np.zeros(10)).final_state for t in (0.02, 1.0)]
    assert np.abs(early - exact[0])[:5].max() < 1e-5
    assert np.abs(late - exact[1])[:5].max() > 1e-2


@pytest.fixture(scope="module")
def rows():
    scene, _ = shorter("B", 0.2)
    return harness.measure(scene, [*harness.WAYS[:5], ABSENT], repeats=1)


def test_rows_rank_the_methods(rows):
    errors = {row.method: row.error for row in rows}
    assert errors["frictionlab, tol 1e-15"] == 0.0
    assert errors["RK4, step 0.0001 s"] < errors["RK4, step 0.001 s"] / 100


def test_an_absent_tool_is_a_row_that_says_so(rows):
    assert rows[-1] == Row("B", "nobody", "nobody's", None, None, None, "no_such_package is not installed")
    lines = harness.table(rows).splitlines()
    assert len(lines) == 2 + len(rows)
    assert lines[-1] == "| nobody's | no_such_package is not installed | | | |"
    assert "| 1 |" in lines[2]


def test_the_picture_has_a_panel_for_each_scene(rows):
    figure = picture.draw(rows)
    labels = [line.get_label() for line in figure.axes[0].lines]
    assert labels == ["frictionlab", "RK4"]
    assert figure.axes[0].get_xscale() == figure.axes[0].get_yscale() == "log"


def test_the_command(monkeypatch, tmp_path, capsys, rows):
    monkeypatch.setattr(harness, "measure", lambda scene, repeats: rows)
    files = tmp_path / "b.json", tmp_path / "b.png"
    assert cli.main(["bench", "--scene", "B", "--json", str(files[0]), "--picture", str(files[1])]) == 0
    assert capsys.readouterr().out.startswith("\nB: with it, full gap rate, 20 s\n")
    assert all(path.stat().st_size > 500 for path in files)


def test_the_page(tmp_path, rows):
    every = [replace(row, scene=name) for name in scenes() for row in rows]
    text = page.write(tmp_path, every, ["| one |", "| two |", "| three |"]).read_text()
    assert text.startswith("# Performance\n")
    assert text.count("frictionlab, tol 1e-15 |") == 6
    assert (tmp_path / "images" / "performance.png").exists()
    assert [text.index(f"| {word} |") for word in ("one", "two", "three")] == sorted(
        text.index(f"| {word} |") for word in ("one", "two", "three")
    )


def test_an_unknown_scene_is_refused(capsys):
    with pytest.raises(SystemExit):
        cli.main(["bench", "--scene", "E"])
    assert "--scene must be one of A, B, C, D, Coulomb, linear, got 'E'" in capsys.readouterr().err
