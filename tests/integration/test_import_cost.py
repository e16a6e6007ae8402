"""`import frictionlab` is cheap, and every public name is there when asked for."""

import ast
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import frictionlab as fl
from frictionlab import plotting, stability

HEAVY = [
    "anywidget",
    "dask",
    "IPython",
    "ipywidgets",
    "matplotlib",
    "numba",
    "pandas",
    "scipy.signal",
    "sympy",
]

PUBLIC = """
    SliderOnBelt CubicContact LinearContact Coulomb
    StickSlipSeparation SlidingOnly MovingLoad FixedLoad PlasticImpact RestitutionImpact
    simulate solve load Taylor RK4 equilibria equilibrium eigenvalues
""".split()


def heavy_modules_after(statement: str) -> list[str]:
    code = f"{statement}\nimport sys, json\nprint(json.dumps([m for m in {HEAVY!r} if m in sys.modules]))"
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return json.loads(answer.stdout)


def test_import_loads_nothing_heavy():
    assert heavy_modules_after("import frictionlab as fl; dir(fl)") == []


def test_the_functions_of_runs_load_no_sympy():
    """It takes longer than all the rest of a first run whose equations are kept."""
    assert "sympy" not in heavy_modules_after("import frictionlab as fl; fl.simulate, fl.critical_value")


@pytest.mark.slow
def test_a_run_from_the_command_line_loads_what_it_needs(tmp_path):
    """Neither scipy nor a compiler, no window, of the plots those of a run: each costs part of a second.

    sympy where the equations have not been derived before.
    """
    drawn, picture = "frictionlab.plotting.root_locus", str(tmp_path / "run.png")
    never = ["scipy", "numba", "matplotlib.pyplot", "numpy.f2py", "numpy.testing", "pandas", drawn]
    code = f"""
import json, sys
from frictionlab.cli.command import main
main(["run", "--model", "MassOnBelt", "--quiet", "--t-end", "1", "-o", {picture!r}])
print(json.dumps([[m for m in {never!r} if m in sys.modules], "sympy" in sys.modules]))
"""
    environment = {**os.environ, "FRICTIONLAB_CACHE_DIR": str(tmp_path / "cache")}
    command = [sys.executable, "-c", code]
    for derives in (True, False):  # that sympy is seen at first shows that all would be
        answer = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
        assert json.loads(answer.stdout.splitlines()[-1]) == [[], derives]
    assert Path(picture).stat().st_size > 10_000


def test_the_probe_sees_what_is_loaded():
    assert heavy_modules_after("import matplotlib") == ["matplotlib"]


@pytest.mark.plain_python
def test_everything_listed_resolves():
    assert set(PUBLIC) <= set(fl.__all__) <= set(dir(fl))
    for name in fl.__all__:
        getattr(fl, name)


@pytest.mark.plain_python
@pytest.mark.parametrize("package", [fl, plotting, stability], ids=lambda package: package.__name__)
def test_the_stub_lists_each_name_once_and_nothing_else(package):
    """What a package reads of its stub is what Python's own parser reads, and so type checkers."""
    stub = Path(package.__file__).with_suffix(".pyi")
    assert Path(fl.__file__).with_name("py.typed").exists()
    *imports, listed = ast.parse(stub.read_text()).body
    assert ast.unparse(listed) == "__all__: list[str]"
    assert all(isinstance(node, ast.ImportFrom) and node.level == 1 for node in imports)
    names = [(alias.name, alias.asname) for node in imports for alias in node.names]
    assert all(name == alias for name, alias in names)
    assert [name for name, _ in names] == package.__all__
    assert len(set(names)) == len(names)
    assert all(getattr(package, name) is not None for name in package.__all__)


@pytest.mark.plain_python
@pytest.mark.parametrize(("typed", "meant"), [("simulat", "simulate"), ("SliderOnbelt", "SliderOnBelt")])
def test_unknown_name_is_answered_with_the_nearest(typed, meant):
    with pytest.raises(AttributeError, match=f"(?i)did you mean.*{meant}"):
        getattr(fl, typed)
    assert not hasattr(fl, "qwertyuiop")
