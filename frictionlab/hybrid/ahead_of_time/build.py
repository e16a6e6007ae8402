"""Compile the kernels: capture their instructions, make objects of them, write the folder of objects.

Run as ``python -m frictionlab.hybrid.ahead_of_time``, which has numba compile although there are objects.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from itertools import repeat
from multiprocessing import get_context
from pathlib import Path

import llvmlite.binding as llvm

from frictionlab.hybrid.ahead_of_time import emit, flat_functions
from frictionlab.hybrid.ahead_of_time.entry_points import entry_points, symbols
from frictionlab.hybrid.ahead_of_time.flat_functions import flat_function, scalar_function
from frictionlab.hybrid.ahead_of_time.manifest import (
    FILE,
    Function,
    Manifest,
    digest,
    kernel_sources,
    objects_folder,
    source_files,
)
from frictionlab.hybrid.ahead_of_time.targets import WEB, Target

# How the instructions and the tables are made.
BUILDERS = tuple(
    f"frictionlab.hybrid.ahead_of_time.{name}"
    for name in ("emit", "entry_points", "flat_functions", "targets")
)
# With more targets it pays to optimise once what holds for all processors; that takes as long as one.
MOST_WITHOUT_SIMPLIFICATION = 2


def build(targets: Sequence[Target], report: Callable[[str], None]) -> None:
    """Compile for the targets, in place of all that the folder of objects has held."""
    folder = Path(str(objects_folder()))
    start, sources = time.perf_counter(), _sources()
    report("kernels: numba compiles them once, for all processors ...")
    instructions, tables, names = _capture()
    report(f"kernels: machine code for {', '.join(target.name for target in targets)} ...")
    contents = _machine_code(instructions, [*tables, *names], targets)
    folder.mkdir(exist_ok=True)
    for old in folder.iterdir():
        old.unlink()
    objects = {}
    for target, content in zip(targets, contents, strict=True):
        (folder / target.file).write_bytes(content)
        objects[target.file] = digest(content)
    manifest = Manifest(sources, tables, tuple(names), objects)
    (folder / FILE).write_text(manifest.to_json(), encoding="utf-8")
    report(f"kernels: compiled in {time.perf_counter() - start:.0f} s, in {folder}")


def _machine_code(instructions: str, exports: list[str], targets: Sequence[Target]) -> list[bytes]:
    """The file of each target; several at once where there are several processors."""
    of_processors = instructions
    if sum(target != WEB for target in targets) > MOST_WITHOUT_SIMPLIFICATION:
        of_processors = emit.simplified(instructions, exports)
    given = [instructions if target == WEB else of_processors for target in targets]
    count = min(len(targets), os.cpu_count() or 1)
    if count == 1:
        return [emit.object_file(*each) for each in zip(given, repeat(exports), targets)]
    with ProcessPoolExecutor(count, get_context("spawn")) as pool:
        return list(pool.map(emit.object_file, given, repeat(exports), targets))


def _capture() -> tuple[str, dict[str, Function], list[str]]:
    """The instructions, the tables of the entry points, the names of the functions of numbers."""
    entries, called = entry_points(), symbols()  # before, as to make specimens runs compiled code
    with flat_functions.captured_libraries() as libraries:
        flat = [flat_function(entry) for entry in entries]
        scalar = [(each, scalar_function(each)) for each in called]
        module = flat_functions.linked(libraries)
    for function in flat:
        module.link_in(llvm.parse_assembly(emit.shim(function.name, function.symbol)))
    for symbol, function in scalar:
        shim = emit.scalar_shim(symbol.name, function.symbol, symbol.signature)
        module.link_in(llvm.parse_assembly(shim))
    return str(module), {each.name: each.table for each in flat}, [each.name for each, _ in scalar]


def _sources() -> dict[str, str]:
    """Digests of the files that the kernels and their objects depend on."""
    files = kernel_sources() | source_files(BUILDERS)
    return {path: digest(content) for path, content in sorted(files.items())}
