"""The files that compiled code depends on: those of all that a kernel calls or takes a constant from.

They are read, not imported, so that their digest is known before the first kernel is.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator
from functools import cache
from importlib import resources
from typing import Any

PACKAGE, SOLVER = "frictionlab", "frictionlab.hybrid"
# Holds how kernels are compiled, but none of what they compute: what it imports does not matter.
COMPILATION = "frictionlab.hybrid.compilation"
DECORATORS = ("kernel", "inlined")
# Plain functions that native code calls.
CALLED_BY_NATIVE_CODE = ("frictionlab.hybrid.codegen.kernel_symbols", "KERNELS")
Name = tuple[str, str]  # a module, and a name in it


def kernel_sources() -> dict[str, bytes]:
    """Content of each file that the code of a kernel depends on, by its path in the package."""
    modules, seen, left = {COMPILATION}, set(), [CALLED_BY_NATIVE_CODE, *_kernels()]
    while left:
        module, name = left.pop()
        if (module, name) in seen or module == COMPILATION:
            continue
        seen.add((module, name))
        modules.add(module)
        left += _needed(module, name)
    return source_files(modules)


def source_files(modules: Iterable[str]) -> dict[str, bytes]:
    """Content of the files of modules, by their paths in the package."""
    return {_path(module): _read(module) for module in sorted(modules)}


def _kernels() -> Iterator[Name]:
    """The functions of the solver that are compiled."""
    for module in _modules(resources.files(SOLVER), SOLVER):
        if any(f"\n@{decorator}\n".encode() in _read(module) for decorator in DECORATORS):
            definitions, _ = _contents(module)
            for name, nodes in definitions.items():
                if any(_is_kernel(node) for node in nodes):
                    yield module, name


def _is_kernel(node: ast.AST) -> bool:
    decorators = getattr(node, "decorator_list", [])
    return any(isinstance(each, ast.Name) and each.id in DECORATORS for each in decorators)


def _modules(folder: Any, package: str) -> Iterator[str]:
    """The modules in a folder and those in it; it may be in a zip file."""
    for entry in sorted(folder.iterdir(), key=lambda entry: entry.name):
        if entry.is_dir():
            yield from _modules(entry, f"{package}.{entry.name}")
        elif entry.name.endswith(".py") and entry.name != "__init__.py":
            yield f"{package}.{entry.name.removesuffix('.py')}"


def _needed(module: str, name: str) -> list[Name]:
    """Where the names come from that the definition of a name uses."""
    definitions, imports = _contents(module)
    found = []
    for node in definitions.get(name, []):
        for part in ast.walk(node):
            if isinstance(part, ast.Attribute) and isinstance(part.value, ast.Name):
                origin = imports.get(part.value.id)
                if origin is not None and _is_module(".".join(origin)):
                    found.append((".".join(origin), part.attr))
            elif isinstance(part, ast.Name):
                if part.id in imports:
                    found.append(imports[part.id])
                elif part.id in definitions:
                    found.append((module, part.id))
    if not definitions.get(name) and name in imports:
        found.append(imports[name])
    return [(home, one) for home, one in found if _is_module(home) and not _is_module(f"{home}.{one}")]


@cache
def _contents(module: str) -> tuple[dict[str, list[ast.AST]], dict[str, Name]]:
    """Of a module: what defines each of its names, and for what it imports from the package module and
    name."""
    definitions: dict[str, list[ast.AST]] = {}
    imports: dict[str, Name] = {}
    tree = ast.parse(_read(module))
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith(PACKAGE):
            for alias in node.names:
                imports[alias.asname or alias.name] = (str(node.module), alias.name)
    for node in _statements(tree.body):
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            definitions.setdefault(node.name, []).append(node)
        elif isinstance(node, (ast.Assign, ast.AnnAssign)):
            for part in ast.walk(node):
                if isinstance(part, ast.Name) and isinstance(part.ctx, ast.Store):
                    definitions.setdefault(part.id, []).append(node)
    return definitions, imports


def _statements(body: list[ast.stmt]) -> Iterator[ast.stmt]:
    """The statements of a module, and those under its conditions."""
    for node in body:
        yield node
        for inner in ("body", "orelse", "finalbody"):
            if isinstance(node, (ast.If, ast.Try, ast.With)):
                yield from _statements(getattr(node, inner, []))


def _file(module: str) -> Any:
    """The file of a module of the package, which need not exist."""
    _, *parts = module.split(".")
    return resources.files(PACKAGE).joinpath(*parts[:-1], f"{parts[-1]}.py") if parts else None


def _path(module: str) -> str:
    return module.removeprefix(f"{PACKAGE}.").replace(".", "/") + ".py"


@cache
def _read(module: str) -> bytes:
    return _file(module).read_bytes()


@cache
def _is_module(name: str) -> bool:
    """Whether a name is that of a file of the package; packages hold no code of kernels."""
    file = _file(name) if name.startswith(f"{PACKAGE}.") else None
    return file is not None and file.is_file()
