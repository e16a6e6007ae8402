"""Kernels that were compiled ahead of time: numba is not imported."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import frictionlab as fl
from frictionlab.compilation import machine_code
from frictionlab.compilation.entry_points import entry_points
from frictionlab.compilation.loaded_kernels import prepared_call
from frictionlab.compilation.manifest import (
    code_digest,
    lacking_objects,
    targets_of_machine,
)
from frictionlab.hybrid.kernels.jets import state_rates
from frictionlab.tape.packing import program_of

ROOT = Path(__file__).parents[2]

SCRIPT = """
import sys
import frictionlab as fl
model = fl.SliderOnBelt(mu_k=1.4)
fl.simulate(model, 0.1, progress=False).defect
fl.simulate(model, 0.01, method="rk4", progress=False)
fl.eigenvalues(model)
fl.energy_audit(fl.simulate(model, 0.1, progress=False))
fl.ensemble([model, model.replace(mu_k=1.2)], 0.05, progress=False)
fl.steady_state(fl.MassOnBelt(), transient=20.0, window=20.0, progress=False)
fl.basins(fl.MassOnBelt(), ("x", [0.0, 1.0]), ("x'", [0.0]), transient=20.0, window=20.0, progress=False)
fl.bifurcation(fl.MassOnBelt(), "v", [0.1, 0.2], section="x'", transient=20.0, window=20.0, progress=False)
fl.explore(fl.MassOnBelt())
print("numba" in sys.modules)
"""


@pytest.mark.skipif(machine_code.LOADED is None, reason="no kernels compiled ahead of time")
def test_numba_is_not_imported():
    done = subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"


@pytest.mark.skipif(machine_code.LOADED is None, reason="no kernels compiled ahead of time")
def test_the_list_of_what_is_compiled_can_be_made_where_kernels_are_loaded():
    """It needs the Python functions behind the loaded ones, for the names of their arguments."""
    assert machine_code.LOADED is not None
    entries = entry_points()
    assert {each.name for each in entries} == set(machine_code.LOADED.manifest.functions)
    for each in entries:
        code = each.kernel.py_func.__code__
        assert list(each.arguments) == list(code.co_varnames[: code.co_argcount])


CODE = """# A comment.
def area(r, shown=("text", 1)):
    \"\"\"Of a circle.\"\"\"
    # pi
    return 3.0 * r  # not quite
"""


@pytest.mark.parametrize(
    ("before", "after", "same"),
    [
        ("# A comment.\n", "", True),
        ("Of a circle.", "Of a circle\n\n    of radius r.", True),
        ("  # not quite", "", True),
        ("    # pi\n", "    'a statement'\n\n", True),
        ("3.0", "3.1", False),
        ('"text"', '"word"', False),
        ("    return", "  return", False),
        ("3.0 * r", "(3.0 *", False),
    ],
)
def test_prose_makes_no_object_stale(before, after, same):
    assert before in CODE
    assert (code_digest(CODE.encode()) == code_digest(CODE.replace(before, after).encode())) == same


HOOK = """
import json, sys
sys.path.insert(0, "frictionlab/compilation")
from build_hook import KernelBuildHook

class App:
    def display_info(self, text): print("info:", text)
    def display_warning(self, text): print("warning:", text)

hook = KernelBuildHook(sys.argv[1], {}, None, None, sys.argv[1], "wheel", App())
data = {"pure_python": True, "artifacts": [], "force_include": {}}
hook.initialize(sys.argv[2], data)
print(json.dumps(data))
"""
PYTHON_ONLY = {"pure_python": True, "artifacts": [], "force_include": {}}


def hooked(version, root=ROOT, **environment):
    """What the build step prints, and what it tells hatchling."""
    pytest.importorskip("hatchling", reason="it builds the wheel; it is not installed")
    done = subprocess.run(
        [sys.executable, "-c", HOOK, str(root), version],
        cwd=ROOT,
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=True,
    )
    *said, data = done.stdout.splitlines()
    return "\n".join(said), json.loads(data)


ALL_FILES = [target.file for target in targets_of_machine()]


@pytest.mark.skipif(bool(lacking_objects(ALL_FILES)), reason="a clone has the object of its own processor")
def test_objects_that_are_there_go_into_the_wheel():
    _, data = hooked("standard")
    assert data["pure_python"] is False
    assert re.fullmatch(r"py3-none-(manylinux|macosx|win|linux)_?\w+", data["tag"])
    assert data["artifacts"] == ["/frictionlab/compilation/objects/"]
    (structures,) = data["force_include"].items()
    assert structures == (str(ROOT / "build/structures.zip"), "frictionlab/models/structures.zip")


def test_a_wheel_of_python_only_can_be_asked_for():
    said, data = hooked("standard", FRICTIONLAB_BUILD_KERNELS="0")
    assert (said, data) == ("", PYTHON_ONLY)


def test_a_build_that_fails_makes_a_wheel_of_python_only_and_says_so(tmp_path):
    (tmp_path / "frictionlab.py").write_text("raise RuntimeError('no compiler')")
    said, data = hooked("standard", root=tmp_path)
    assert data == PYTHON_ONLY
    assert "warning: the solver could not be compiled" in said
    assert "no compiler" in said


@pytest.mark.parametrize("kernel", [state_rates, getattr(state_rates, "__wrapped__", state_rates)])
def test_a_prepared_call_takes_what_its_arrays_hold_now(kernel):
    """Compiled or not: the rates of every mode at states that are written into one array."""
    automaton = fl.SliderOnBelt(mu_k=1.4).automaton()
    program, numbers = program_of(automaton)
    count, random = len(automaton.states), np.random.default_rng(3)
    z, out, jets = np.zeros(count), np.zeros(count), np.zeros((program.slots, 2))
    write_rates = prepared_call(kernel, (program.code, numbers, 0, z, jets, out), 2)
    for mode in range(len(automaton.modes)):
        z[:] = 1e-3 * random.normal(size=count)
        expected = np.zeros(count)
        write_rates(mode)
        kernel(program.code, numbers, mode, z, np.zeros_like(jets), expected)
        assert out.tobytes() == expected.tobytes()
        assert out.any()
