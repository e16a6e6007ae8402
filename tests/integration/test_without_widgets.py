"""On a node of a cluster, without ipywidgets and what comes with it, all but the views of notebooks works."""

import subprocess
import sys

import pytest

HIDDEN = "ipywidgets", "anywidget", "traitlets", "IPython", "comm"
HIDING = f"""
import sys

class Hidden:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {HIDDEN!r}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)

sys.meta_path.insert(0, Hidden())
import frictionlab as fl
"""
COMPUTING = """
import matplotlib
matplotlib.use("Agg")
model = fl.MassOnBelt()
run = fl.simulate(model, 20.0)
state = fl.steady_state(model, transient=20.0, window=30.0, progress=False)
fl.eigenvalues(model), fl.energy_audit(run), fl.verify(model, 5.0)
diagram = fl.bifurcation(model, "v", [0.2, 0.3], transient=10.0, window=20.0, workers=1, progress=False)
diagram.plot(), fl.plot_run(run)
fl.animate(run)
assert state.kind == "periodic"
assert fl.listen(run).save("run.wav").exists()
assert not {"ipywidgets", "IPython", "traitlets"} & set(sys.modules)
"""


def run_hidden(code, folder):
    command = [sys.executable, "-c", HIDING + code]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


@pytest.mark.slow
def test_computing_and_plotting_need_none_of_them(tmp_path):
    answer = run_hidden(COMPUTING, tmp_path)
    assert answer.returncode == 0, answer.stderr


VIEWS = {"explore": "traitlets", "explore_stability": "traitlets", "watch": "anywidget"}
VIEWING = f"""
for name in {[*VIEWS]!r}:
    try:
        getattr(fl, name)
    except ImportError as error:
        print(error)
fl.explore()
"""


@pytest.mark.slow
def test_a_view_of_notebooks_says_what_to_install(tmp_path):
    answer = run_hidden(VIEWING, tmp_path)
    assert answer.returncode == 1
    said = [
        f"fl.{name} needs {package}, which is not installed: pip install {package}"
        for name, package in VIEWS.items()
    ]
    assert answer.stdout.splitlines() == said
    assert answer.stderr.splitlines()[-1] == f"ImportError: {said[0]}"
