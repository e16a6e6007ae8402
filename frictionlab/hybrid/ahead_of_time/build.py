"""Compile the kernels: capture their instructions, make objects of them, write the folder of objects.

Run as ``python -m frictionlab.hybrid.ahead_of_time``, which has numba compile although there are objects.
"""

from __future__ import annotations

import lzma
import time
from collections.abc import Callable, Iterable
from pathlib import Path

import llvmlite.binding as llvm

from frictionlab.hybrid.ahead_of_time import capture, emit
from frictionlab.hybrid.ahead_of_time.entry_points import entry_points, symbols
from frictionlab.hybrid.ahead_of_time.flat_functions import flat_function, scalar_function
from frictionlab.hybrid.ahead_of_time.loaded_kernels import SUFFIX
from frictionlab.hybrid.ahead_of_time.manifest import FILE, Function, Manifest, digest, objects_folder
from frictionlab.hybrid.ahead_of_time.sources import source_files
from frictionlab.hybrid.ahead_of_time.targets import WEB, Target

PACKAGE = Path(__file__).parents[2]
WEB_FILE = "kernels.wasm"


def build(targets: Iterable[Target], report: Callable[[str], None]) -> None:
    """Compile for the targets, in place of all that the folder of objects has held."""
    folder = Path(str(objects_folder()))
    start, sources = time.perf_counter(), _sources()
    report("kernels: numba compiles them once, for all processors ...")
    instructions, tables, names = _capture()
    folder.mkdir(exist_ok=True)
    for old in folder.iterdir():
        old.unlink()
    objects = {}
    plain = emit.simplified(instructions, [*tables, *names])
    for target in targets:
        report(f"kernels: machine code for {target.name} ...")
        exports = [*tables, *names]
        if target is WEB:
            name, content = WEB_FILE, emit.link_for_web(emit.emit_object(instructions, exports, WEB), exports)
        else:
            name = target.name + SUFFIX
            content = lzma.compress(emit.emit_object(plain, exports, target), preset=9)
        (folder / name).write_bytes(content)
        objects[name] = digest(content)
    manifest = Manifest(sources, tables, tuple(names), objects)
    (folder / FILE).write_text(manifest.to_json(), encoding="utf-8")
    report(f"kernels: compiled in {time.perf_counter() - start:.0f} s, in {folder}")


def _capture() -> tuple[str, dict[str, Function], list[str]]:
    """The instructions, the tables of the entry points, the names of the functions of numbers."""
    with capture.captured_libraries() as libraries:
        flat = [flat_function(entry) for entry in entry_points()]
        scalar = [(each, scalar_function(each)) for each in symbols()]
        module = capture.linked(libraries)
    for function in flat:
        module.link_in(llvm.parse_assembly(emit.shim(function.name, function.symbol)))
    for symbol, function in scalar:
        shim = emit.scalar_shim(symbol.name, function.symbol, symbol.signature)
        module.link_in(llvm.parse_assembly(shim))
    return str(module), {each.name: each.table for each in flat}, [each.name for each, _ in scalar]


def _sources() -> dict[str, str]:
    """Digests of the files that the kernels depend on."""
    kernels = [getattr(entry.kernel, "py_func", entry.kernel) for entry in entry_points()]
    functions = [*kernels, *(getattr(each.function, "py_func", each.function) for each in symbols())]
    files = source_files([(each.__module__, each.__name__) for each in functions])
    return {file.relative_to(PACKAGE).as_posix(): digest(file.read_bytes()) for file in files}
