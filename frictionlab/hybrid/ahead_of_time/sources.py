"""The files that compiled code depends on: those of all that a kernel calls or takes a constant from."""

from __future__ import annotations

import ast
from functools import cache
from importlib.util import find_spec
from pathlib import Path

PACKAGE = "frictionlab"
# How the instructions and the tables are made.
BUILDERS = tuple(
    f"frictionlab.hybrid.ahead_of_time.{name}"
    for name in ("capture", "emit", "entry_points", "flat_functions", "targets")
)
# Holds how kernels are compiled, but none of what they compute: what it imports does not matter.
DECORATORS = "frictionlab.hybrid.compilation"


def source_files(functions: list[tuple[str, str]]) -> list[Path]:
    """Files that the code of functions depends on, given by their modules and names."""
    modules, seen, left = {*BUILDERS, DECORATORS}, set(), list(functions)
    while left:
        module, name = left.pop()
        if (module, name) in seen or module == DECORATORS:
            continue
        seen.add((module, name))
        modules.add(module)
        left += _needed(module, name)
    return sorted(_file(module) for module in modules)


def _needed(module: str, name: str) -> list[tuple[str, str]]:
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
    return [(home, one) for home, one in found if not _is_module(f"{home}.{one}")]


@cache
def _contents(module: str) -> tuple[dict[str, list[ast.AST]], dict[str, tuple[str, str]]]:
    """Of a module: what defines each of its names, and for what it imports from the package module and
    name."""
    definitions: dict[str, list[ast.AST]] = {}
    imports: dict[str, tuple[str, str]] = {}
    tree = ast.parse(_file(module).read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith(PACKAGE):
            for alias in node.names:
                imports[alias.asname or alias.name] = (str(node.module), alias.name)
    for node in tree.body:
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            definitions.setdefault(node.name, []).append(node)
        elif isinstance(node, (ast.Assign, ast.AnnAssign)):
            for part in ast.walk(node):
                if isinstance(part, ast.Name) and isinstance(part.ctx, ast.Store):
                    definitions.setdefault(part.id, []).append(node)
    return definitions, imports


@cache
def _is_module(name: str) -> bool:
    try:
        return find_spec(name) is not None
    except ModuleNotFoundError:  # the part before the last dot is no package
        return False


@cache
def _file(module: str) -> Path:
    spec = find_spec(module)
    assert spec is not None
    return Path(str(spec.origin))
