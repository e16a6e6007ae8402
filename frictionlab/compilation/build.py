"""Compile the kernels: capture their instructions, make machine code of them for each target, write a folder
of objects.

Run it as ``python -m frictionlab.compilation``, which makes numba compile even where objects exist.
"""

from __future__ import annotations

import lzma
import os
import re
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from importlib import metadata
from importlib.util import find_spec
from itertools import repeat
from multiprocessing import get_context
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import llvmlite.binding as llvm

from frictionlab.compilation.entry_points import entry_points, symbols
from frictionlab.compilation.flat_functions import flat_function, scalar_function
from frictionlab.compilation.kernel_sources import digest, kernel_names, kernel_sources, path_of, source_files
from frictionlab.compilation.manifest import FILE, Function, Manifest, Source, read_manifest, source
from frictionlab.compilation.numba_internals import captured_libraries, linked
from frictionlab.compilation.targets import TARGETS, WEB, Target

# The modules that make the instructions and the tables.
BUILDERS = tuple(
    f"frictionlab.compilation.{name}"
    for name in ("build", "entry_points", "flat_functions", "numba_internals", "targets")
)
PACKAGES = "numba", "llvmlite", "ziglang"  # by whose versions the machine code may differ
# With more targets it pays to do once the optimisations that hold for all processors; this takes as long as
# one target.
MOST_WITHOUT_SIMPLIFICATION = 2
ALIGNMENT = 5  # 2^5 bytes, of blocks that are jumped to: else it is by chance how fast a loop is
OPTIMISATION = 2  # level 3 makes objects larger and no run faster
COMMON = TARGETS[1]  # x86-64 without extensions
# Kernels that are not inlined: they take longer than a call and are called in many places.
CALLED = "run_tape", "function_value", "function_range", "power"
STACK_BYTES, MEMORY_BYTES = 1 << 18, 1 << 25  # in a browser; the memory grows
LINKER = ("wasm-ld", "--no-entry", "--allow-undefined", "--export-table", "--growable-table", "--strip-all")
SCALARS = {"int64": "i64", "float64": "double"}


def build(targets: Sequence[Target], folder: Path, report: Callable[[str], None]) -> None:
    """Compile for the targets, and replace all that a folder of objects has held."""
    if WEB in targets and find_spec("ziglang") is None:
        raise ModuleNotFoundError("the linker for WebAssembly is part of ziglang: pip install ziglang")
    start, sources = time.perf_counter(), _sources()
    report("kernels: numba compiles them once, for all processors ...")
    instructions, tables, names = _capture()
    report(f"kernels: machine code for {', '.join(target.name for target in targets)} ...")
    contents = _machine_code(instructions, [*tables, *names], targets)
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.iterdir():
        old.unlink()
    objects = {}
    for target, content in zip(targets, contents, strict=True):
        (folder / target.file).write_bytes(content)
        objects[target.file] = digest(content)
    manifest = Manifest(sources, tables, tuple(names), objects, _versions())
    (folder / FILE).write_text(manifest.to_json(), encoding="utf-8", newline="\n")
    report(f"kernels: compiled in {time.perf_counter() - start:.0f} s, in {folder}")


def differences(folder: Path, report: Callable[[str], None]) -> list[str]:
    """What differs where the objects in a folder, for all targets, are compiled again."""
    with TemporaryDirectory() as again:
        build([*TARGETS, WEB], Path(again), report)
        there, other = read_manifest(folder), read_manifest(Path(again))
        files = {path.name for path in (*folder.iterdir(), *Path(again).iterdir())} - {FILE}
        names = [name for name in sorted(files) if _content(folder / name) != _content(Path(again) / name)]
    if there is None or other is None:
        return [FILE]
    if [each.code for each in there.sources.values()] != [each.code for each in other.sources.values()]:
        names.append("the sources")
    if (there.functions, there.symbols, there.objects) != (other.functions, other.symbols, other.objects):
        names.append(FILE)
    versions = {name: (there.versions.get(name), version) for name, version in other.versions.items()}
    others = [f"{name} ({was}, now {now})" for name, (was, now) in versions.items() if was != now]
    return [*names, *others] if names else []


def _content(file: Path) -> bytes:
    return file.read_bytes() if file.is_file() else b""


def _versions() -> dict[str, str]:
    """Versions of what takes part; that of ziglang only where it is installed."""
    packages = {name: metadata.version(name) for name in PACKAGES if find_spec(name) is not None}
    return {"python": "{}.{}".format(*sys.version_info), **packages}


def _machine_code(instructions: str, exports: list[str], targets: Sequence[Target]) -> list[bytes]:
    """Content of each target's file; several are made at once where there are several processors."""
    of_processors = instructions
    if sum(target != WEB for target in targets) > MOST_WITHOUT_SIMPLIFICATION:
        of_processors = simplified(instructions, exports)
    sources = [instructions if target == WEB else of_processors for target in targets]
    count = min(len(targets), os.cpu_count() or 1)
    if count == 1:
        return [object_file(*each) for each in zip(sources, repeat(exports), targets)]
    with ProcessPoolExecutor(count, get_context("spawn")) as pool:
        return list(pool.map(object_file, sources, repeat(exports), targets))


def _capture() -> tuple[str, dict[str, Function], list[str]]:
    """The instructions, the tables of the entry points, and the names of the functions of numbers."""
    entries, called = entry_points(), symbols()  # before capturing, as making specimens runs compiled code
    with captured_libraries() as libraries:
        flat = [flat_function(entry) for entry in entries]
        scalar = [(each, scalar_function(each)) for each in called]
        module = linked(libraries)
    for function in flat:
        module.link_in(llvm.parse_assembly(shim(function.name, function.symbol)))
    for symbol, function in scalar:
        text = scalar_shim(symbol.name, function.symbol, symbol.signature)
        module.link_in(llvm.parse_assembly(text))
    tables, names = {each.name: each.table for each in flat}, [each.name for each, _ in scalar]
    _rename(module, {*tables, *names})
    return str(module), tables, names


def _rename(module: Any, exports: set[str]) -> None:
    """Give what is not visible from outside names that depend on its place alone.

    Those of numba are long and count what a process has compiled before, so objects would differ.
    """
    for place, function in enumerate(module.functions):
        if not function.is_declaration and function.name not in exports:
            function.name = f"{_function_name(function.name)}.{place}"
    for place, variable in enumerate(module.global_variables):
        if not variable.name.startswith("llvm."):
            variable.name = f"constant.{place}"


def _function_name(symbol: str) -> str:
    """Name of the function in a symbol as "_ZN11frictionlab4tape5powerB3v39...": the last of its names."""
    name, rest = "", symbol.removeprefix("_ZN")
    while match := re.match(r"[0-9]+", rest):
        begin, length = match.end(), int(match.group())
        name, rest = rest[begin : begin + length], rest[begin + length :]
    return name or "function"


def _sources() -> dict[str, Source]:
    """The files that the kernels and their objects depend on: what kernels name in them, or the whole."""
    names = {path_of(module): tuple(sorted(names)) for module, names in kernel_names().items()}
    names |= dict.fromkeys(source_files(BUILDERS), ())
    files = kernel_sources() | source_files(BUILDERS)
    return {path: source(content, names[path]) for path, content in sorted(files.items())}


def shim(name: str, symbol: str) -> str:
    """``int name(int64 *table)`` in LLVM's language; numba's own function takes two more pointers."""
    return f"""
declare i32 @"{symbol}"(ptr, ptr, ptr)
define i32 @{name}(ptr %table) {{
  %result = alloca [4 x i64]
  %error = alloca ptr
  %status = call i32 @"{symbol}"(ptr %result, ptr %error, ptr %table)
  ret i32 %status
}}
"""


def scalar_shim(name: str, symbol: str, signature: str) -> str:
    """A C function of numbers, as ``double name(int64, double)``; `signature` is as numba writes it."""
    words = re.findall(r"\w+", signature)
    result, *kinds = (SCALARS[word] for word in words)
    declared = ", ".join(["ptr", "ptr", *kinds])
    parameters = ", ".join(f"{kind} %a{i}" for i, kind in enumerate(kinds))
    return f"""
declare i32 @"{symbol}"({declared})
define {result} @{name}({parameters}) {{
  %result = alloca {result}
  %error = alloca ptr
  %status = call i32 @"{symbol}"(ptr %result, ptr %error, {parameters})
  %value = load {result}, ptr %result
  ret {result} %value
}}
"""


def simplified(instructions: str, exports: list[str]) -> str:
    """The instructions after the optimisations that hold for all 64-bit processors, done once for them."""
    machine = _machine(COMMON)
    return str(_optimised(instructions, exports, COMMON, machine, vectorise=False))


def object_file(instructions: str, exports: list[str], target: Target) -> bytes:
    """Content of a target's file: a compressed object, or a module of WebAssembly."""
    code = emit_object(instructions, exports, target)
    return link_for_web(code, exports) if target == WEB else lzma.compress(code, preset=9)


def emit_object(instructions: str, exports: list[str], target: Target) -> bytes:
    """Object file of a target, in which only the exports are visible from outside."""
    llvm.set_option("frictionlab", f"--align-all-nofallthru-blocks={ALIGNMENT}")
    machine = _machine(target)
    return machine.emit_object(_optimised(instructions, exports, target, machine, vectorise=True))


def _optimised(
    instructions: str, exports: list[str], target: Target, machine: Any, *, vectorise: bool
) -> Any:
    module = llvm.parse_assembly(_adapted(instructions, target, machine))
    for function in module.functions:
        if not function.is_declaration:
            function.linkage = "external" if function.name in exports else "internal"
            if _is_called(function.name):
                function.add_function_attribute("noinline")
    for variable in module.global_variables:
        if not variable.name.startswith("llvm."):
            variable.linkage = "internal"
    options = llvm.create_pipeline_tuning_options(speed_level=OPTIMISATION)
    options.loop_vectorization = options.slp_vectorization = vectorise
    builder = llvm.create_pass_builder(machine, options)
    builder.getModulePassManager().run(module, builder)
    module.verify()
    return module


def _is_called(name: str) -> bool:
    """Whether a function, named by :func:`_rename`, is one of :data:`CALLED`."""
    return "." in name and name.partition(".")[0] in CALLED


def _machine(target: Target) -> Any:
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    web = target == WEB
    place: dict[str, Any] = {"reloc": "static"}
    if not web:
        place = {"reloc": "pic", "codemodel": "default", "jit": True}
    triple = llvm.Target.from_triple(target.triple)
    return triple.create_target_machine(opt=OPTIMISATION, cpu=target.cpu, features=target.features, **place)


def _adapted(instructions: str, target: Target, machine: Any) -> str:
    """The instructions with the target's data layout; addresses of this process become null."""
    text = re.sub(r'target datalayout = ".*"', f'target datalayout = "{machine.target_data}"', instructions)
    text = re.sub(r'target triple = ".*"', f'target triple = "{target.triple}"', text)
    return re.sub(r"inttoptr \(i64 \d+ to ptr\)", "null", text)


def link_for_web(code: bytes, exports: list[str]) -> bytes:
    """An object of :data:`WEB` made a module of WebAssembly by the linker that comes with zig."""
    with TemporaryDirectory() as folder:
        object_path, module_path = Path(folder) / "kernels.o", Path(folder) / "kernels.wasm"
        object_path.write_bytes(code)
        sizes = ["-z", f"stack-size={STACK_BYTES}", f"--initial-memory={MEMORY_BYTES}"]
        symbols = [f"--export={name}" for name in [*exports, "__heap_base"]]
        files = [str(object_path), "-o", str(module_path)]
        command = [sys.executable, "-m", "ziglang", *LINKER, "--gc-sections", "-O2", *sizes, *symbols, *files]
        linker = subprocess.run(command, capture_output=True, text=True, check=False)
        if linker.returncode:
            raise RuntimeError(f"the linker for WebAssembly failed: {linker.stderr[:2000]}")
        return module_path.read_bytes()
