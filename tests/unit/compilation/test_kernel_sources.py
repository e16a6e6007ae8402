"""Which files compiled code depends on, by which compiled code is known to be old."""

import inspect
from pathlib import Path

import pytest

import frictionlab
from frictionlab.compilation import decorators, machine_code
from frictionlab.compilation.entry_points import entry_points, symbols
from frictionlab.compilation.kernel_sources import kernel_sources

pytestmark = pytest.mark.plain_python

PACKAGE = Path(frictionlab.__file__).parent


def python_function(found):
    """The Python function of what numba has compiled, or what an object has taken the place of."""
    found = getattr(found, "py_func", found)
    return inspect.unwrap(getattr(found, "_defn", found))


def names_in(code):
    inner = [each for each in code.co_consts if inspect.iscode(each)]
    return {*code.co_names}.union(*(names_in(each) for each in inner))


def used_by(function):
    """What a function finds in its module by name, as Python itself would."""
    names, space = names_in(function.__code__), function.__globals__
    for found in (space[name] for name in names if name in space):
        if inspect.ismodule(found):
            yield from (getattr(found, name) for name in names if hasattr(found, name))
        else:
            yield found


def files_of_what_kernels_call():
    left = [point.kernel for point in entry_points()] + [each.function for each in symbols()]
    files, seen = set(), set()
    while left:
        found = python_function(left.pop())
        module = getattr(found, "__module__", None) or ""
        if not callable(found) or id(found) in seen or not module.startswith("frictionlab."):
            continue
        seen.add(id(found))
        files.add(Path(inspect.getfile(found)).relative_to(PACKAGE).as_posix())
        if inspect.isfunction(found) and module != decorators.__name__:
            left += used_by(found)
    return files


def test_every_file_that_a_kernel_calls_is_a_source():
    files = files_of_what_kernels_call()
    assert {"hybrid/kernels/jets.py", "tape/elementary/exponentials.py", "tape/program.py"} <= files
    assert files - {"compilation/decorators.py"} <= set(kernel_sources())


def test_what_no_kernel_uses_is_no_source():
    sources = kernel_sources()
    assert {path.partition("/")[0] for path in sources} == {"compilation", "hybrid", "tape"}
    of_compilation = {path for path in sources if path.startswith("compilation/")}
    assert of_compilation == {"compilation/decorators.py", "compilation/llvm_instructions.py"}
    others = "hybrid/solve hybrid/run_file hybrid/trajectory hybrid/ensemble/batch tape/formulas tape/packing"
    assert not {f"{name}.py" for name in others.split()} & set(sources)


def test_an_edit_of_a_source_names_another_folder(monkeypatch):
    class Numba:
        __version__ = "0"

    def folder(sources):
        monkeypatch.setattr(machine_code, "kernel_sources", lambda: sources)
        return machine_code.cache_folder(Numba)

    sources = kernel_sources()
    edited = {**sources, "tape/program.py": sources["tape/program.py"] + b"# an edit\n"}
    assert folder(sources) == folder(dict(sources)) != folder(edited)


def test_names_under_a_condition_are_followed(monkeypatch):
    from frictionlab.compilation import kernel_sources

    text = (
        b"from frictionlab.tape.program import system_of\n"
        b"if True:\n    def one():\n        return system_of\n"
    )
    read = {"frictionlab.hybrid.made_up": text}
    monkeypatch.setattr(kernel_sources, "read_module", lambda module: read[module])
    kernel_sources.module_contents.cache_clear()
    found = kernel_sources.needed_names("frictionlab.hybrid.made_up", "one")
    kernel_sources.module_contents.cache_clear()
    assert found == [("frictionlab.tape.program", "system_of")]
