"""Kernels that were compiled ahead of time: numba is not imported."""

import json
import os
import platform
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import frictionlab as fl
from frictionlab.compilation import machine_code
from frictionlab.compilation.entry_points import entry_points
from frictionlab.compilation.kernel_sources import code_digest, digest, kernel_names, path_of
from frictionlab.compilation.loaded_kernels import prepared_call
from frictionlab.compilation.manifest import (
    FILE,
    REPOSITORY,
    Manifest,
    changed_sources,
    objects_folder,
    read_manifest,
    source,
)
from frictionlab.compilation.targets import TARGETS, WEB, targets_of_system
from frictionlab.hybrid.kernels.jets import state_rates
from frictionlab.tape.packing import program_of
from tests.helpers.cases import slow_but

ROOT = Path(__file__).parents[2]

SCRIPT = """
import sys
import frictionlab as fl
slider, model = fl.SliderOnBelt(mu_k=1.4), fl.MassOnBelt()
fl.simulate(slider, 0.1, progress=False).defect
fl.simulate(slider, 0.01, method="rk4", progress=False)
fl.ensemble([slider, slider.replace(mu_k=1.2)], 0.05, progress=False)
fl.eigenvalues(model)
fl.energy_audit(fl.simulate(model, 20.0, progress=False))
fl.steady_state(model, transient=20.0, window=20.0, progress=False)
fl.basins(model, ("x", [0.0, 1.0]), ("x'", [0.0]), transient=20.0, window=20.0, progress=False)
fl.bifurcation(model, "v", [0.1, 0.2], section="x'", transient=20.0, window=20.0, progress=False)
fl.explore(model, ("response",))
print("numba" in sys.modules)
"""


@pytest.mark.slow
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
@pytest.mark.parametrize("names", [(), ("area",)])
def test_prose_makes_no_object_stale(before, after, same, names):
    assert before in CODE
    edited = CODE.replace(before, after)
    assert (code_digest(CODE.encode(), names) == code_digest(edited.encode(), names)) == same


MODULE = """from frictionlab.tape.program import system_of
import math
SIZE, WIDTH = 3, 4
LENGTH = 5

@kernel
def area(r):
    return SIZE * system_of(r)

def volume(r):
    return math.pi * r
"""


@pytest.mark.parametrize(
    ("before", "after", "same"),
    [
        ("math.pi", "math.tau", True),
        ("LENGTH = 5", "LENGTH = 6", True),
        ("WIDTH = 3, 4", "WIDTH = 4, 4", False),
        ("@kernel", "@inlined", False),
        ("tape.program import", "tape.tape import", False),
        ("import math", "import numpy as math", False),
        ("LENGTH = 5", "LENGTH = 5\nif LENGTH:\n    SIZE = 6", False),
        ("LENGTH = 5", "LENGTH = 5\nSIZE += 1", False),
        ("LENGTH = 5", "LENGTH = 5\nglobals()['SIZE'] = 1", False),
    ],
)
def test_definitions_that_no_kernel_uses_make_no_object_stale(before, after, same):
    edited, names = MODULE.replace(before, after), ("SIZE", "area")
    assert edited != MODULE
    assert (code_digest(MODULE.encode(), names) == code_digest(edited.encode(), names)) == same


def named_tuples(value):
    if isinstance(value, tuple):
        yield from ([type(value)] if hasattr(value, "_fields") else [])
        for each in value:
            yield from named_tuples(each)


def test_the_order_of_fields_that_kernels_are_given_is_part_of_the_sources():
    names = kernel_names()
    kinds = {kind for each in entry_points() for kind in named_tuples(tuple(each.arguments.values()))}
    assert len(kinds) > 10
    assert [kind for kind in kinds if kind.__name__ not in names[kind.__module__]] == []


def test_the_objects_of_the_repository_fit_the_sources():
    """After an edit of a kernel: python -m frictionlab.compilation --all."""
    manifest = read_manifest(objects_folder(REPOSITORY))
    assert manifest is not None
    assert changed_sources(manifest) == []
    assert {*manifest.objects} == {target.file for target in (*TARGETS, WEB)}
    for name, expected in manifest.objects.items():
        assert digest((objects_folder(REPOSITORY) / name).read_bytes()) == expected


HOOK = """
import json, platform, sys
sys.path.insert(0, "frictionlab/compilation")
from build_hook import KernelBuildHook

class App:
    def display_info(self, text): print("info:", text)
    def display_warning(self, text): print("warning:", text)

root, version, machine = sys.argv[1:]
platform.machine = lambda: machine
hook = KernelBuildHook(root, {}, None, None, root, "wheel", App())
needed = hook.dependencies()
data = {"pure_python": True, "artifacts": [], "force_include": {}}
hook.initialize(version, data)
print(json.dumps([needed, data]))
"""
# The files of a clone that say what its objects were made from, and what the hook runs.
EDITED = Path("frictionlab/hybrid/kernels/jets.py")
COMPILE = """
from pathlib import Path
import sys
sys.path.insert(0, {tests!r})
from test_kernels_ahead_of_time import write_objects
write_objects(Path("frictionlab"), "objects_of_machine")
"""
ANY = {"pure_python": True, "artifacts": [], "force_include": {}}
PLACE = "frictionlab/compilation/objects/manifest.json"
SLOW = "kernels will be compiled by numba when they are used, or run as plain Python"


def write_objects(package, folder):
    """Files in place of objects, with a manifest that fits the sources of a package."""
    chosen = {path_of(module): tuple(names) for module, names in kernel_names().items()}
    sources = {path: source((package / path).read_bytes(), names) for path, names in chosen.items()}
    names = [target.file for target in (*TARGETS, WEB)]
    manifest = Manifest(sources, objects={name: digest(name.encode()) for name in names})
    (package / "compilation" / folder).mkdir()
    for name in names:
        (package / "compilation" / folder / name).write_bytes(name.encode())
    (package / "compilation" / folder / FILE).write_text(manifest.to_json())


@pytest.fixture(scope="module")
def original(tmp_path_factory):
    """The package, with objects that fit its sources."""
    pytest.importorskip("hatchling", reason="it builds the wheel; it is not installed")
    package = tmp_path_factory.mktemp("original") / "frictionlab"
    ignored = shutil.ignore_patterns("__pycache__", "objects*", "tutorials")
    shutil.copytree(ROOT / "frictionlab", package, ignore=ignored)
    write_objects(package, REPOSITORY)
    return package


@pytest.fixture
def clone(original, tmp_path):
    """A clone whose objects fit its sources."""
    shutil.copytree(original, tmp_path / "frictionlab")
    return tmp_path


@pytest.fixture
def edited_clone(clone):
    """One in which a kernel has been edited since; its compiler is a script that the test writes."""
    text = (clone / EDITED).read_text()
    (clone / EDITED).write_text(text.replace("def mode_jets(", "def mode_jets(edited, "))
    assert (clone / EDITED).read_text() != text
    return clone


def hooked(root, version="standard", machine="", **environment):
    """What the build step prints, the packages that it needs, and what it tells hatchling."""
    done = subprocess.run(
        [sys.executable, "-c", HOOK, str(root), version, machine or platform.machine()],
        cwd=root,
        env={**os.environ, "PYTHONPATH": "", **environment},
        capture_output=True,
        text=True,
        check=True,
    )
    *said, data = done.stdout.splitlines()
    return said, *json.loads(data)


def as_it_is(clone, **more):
    """What hatchling is told of a wheel whose manifest is that of the clone."""
    return {**ANY, "force_include": {str(clone / PLACE): PLACE, **more}}


def compiler(clone, script):
    (clone / "frictionlab" / "compilation" / "__main__.py").write_text(script)


HAS_TARGET = pytest.mark.skipif(not targets_of_system(), reason="there is no compiler for this system")


@HAS_TARGET
@pytest.mark.parametrize("version", ["standard", "editable"])
def test_where_the_objects_fit_nothing_is_needed_nor_done(clone, version):
    """One wheel for all systems."""
    compiler(clone, "raise RuntimeError('nothing to compile')")
    assert hooked(clone, version) == ([], [], ANY if version == "editable" else as_it_is(clone))


@pytest.mark.slow
@HAS_TARGET
def test_after_an_edit_of_prose_the_wheel_has_a_new_manifest(clone):
    """So that no start has to find out that nothing but prose has changed."""
    (clone / EDITED).write_text("# A comment.\n" + (clone / EDITED).read_text())
    said, needed, data = hooked(clone)
    assert (said, needed) == ([], [])
    path = clone / "build" / FILE
    assert data == {**ANY, "force_include": {str(path): PLACE}}
    edited = read_manifest(path.parent).sources["hybrid/kernels/jets.py"]
    assert edited.bytes == digest((clone / EDITED).read_bytes())
    assert hooked(clone, "editable") == ([], [], ANY)


@pytest.mark.slow
@HAS_TARGET
def test_after_an_edit_of_a_kernel_it_is_compiled_for_this_machine(edited_clone):
    """With numba; the wheel is of this system, and a second one needs nothing."""
    compiler(edited_clone, COMPILE.format(tests=str(Path(__file__).parent)))
    said, needed, data = hooked(edited_clone)
    assert said == ["info: frictionlab compiles its solver for this machine, a minute or two ..."]
    assert needed[0].startswith("numba==")
    assert data["pure_python"] is False
    assert data["tag"] == f"py3-none-{targets_of_system()[0].wheel}"
    assert data["artifacts"] == ["/frictionlab/compilation/objects_of_machine/"]
    assert hooked(edited_clone) == ([], [], data)


@HAS_TARGET
def test_a_compiler_that_fails_says_so_in_one_line(edited_clone):
    compiler(edited_clone, "import sys\nprint('much', file=sys.stderr)\nraise RuntimeError('no compiler')")
    (_, warning), _, data = hooked(edited_clone)
    assert data == as_it_is(edited_clone)
    assert warning == f"warning: the solver could not be compiled, {SLOW}: RuntimeError: no compiler"


@pytest.mark.parametrize("edited", slow_but([True], [True, False]))
def test_a_processor_without_a_target_is_told_so_in_one_line(clone, edited, request):
    if edited:
        request.getfixturevalue("edited_clone")
    compiler(clone, "raise RuntimeError('it should not have been called')")
    said, needed, data = hooked(clone, machine="riscv64")
    assert said == [f"warning: no compiler for this processor and system: {SLOW}"]
    assert (needed, data) == ([], as_it_is(clone))


def test_compiling_can_be_declined(edited_clone):
    assert hooked(edited_clone, FRICTIONLAB_BUILD_KERNELS="0") == ([], [], as_it_is(edited_clone))


@pytest.mark.slow
def test_a_wheel_that_is_published_has_structures(clone):
    (clone / "frictionlab/cli/shipped_structures.py").write_text("import sys\nopen(sys.argv[1], 'w').close()")
    (clone / "build").mkdir()
    said, needed, data = hooked(clone, FRICTIONLAB_BUILD_STRUCTURES="1")
    assert said == []
    assert any(each.startswith("sympy") for each in needed)
    path = clone / "build/structures.zip"
    assert data == as_it_is(clone, **{str(path): "frictionlab/models/structures.zip"})
    assert path.exists()


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
