"""Run time against error: complete rows, real errors, unlike tools agree; nothing looks at a clock."""

import numpy as np
import pytest

from frictionlab import cli
from frictionlab.bench import harness, picture
from frictionlab.bench.harness import Row, Way
from frictionlab.bench.heyoka import Heyoka
from frictionlab.bench.scenes import BenchScene, scenes
from frictionlab.bench.solve_ivp import SolveIvp
from frictionlab.bench.sundials import Cvode
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
        pytest.importorskip("heyoka")
    if other == "cvode":
        pytest.importorskip("sksundae")
    method = {"heyoka": Heyoka, "cvode": Cvode, "solve_ivp": SolveIvp}[other](scene.automaton)
    run = solve(scene.automaton, scene.t_end, x0=scene.x0, method=method, progress=False)
    assert run.events.target.tolist() == exact.events.target.tolist()
    assert np.abs(run.events.t - exact.events.t).max(initial=0.0) < 1e-7
    assert scene.error(run.final_state) < 1e-5


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


def test_an_unknown_scene_is_refused(capsys):
    with pytest.raises(SystemExit):
        cli.main(["bench", "--scene", "E"])
    assert "--scene must be one of A, B, C, D, Coulomb, linear, got 'E'" in capsys.readouterr().err
