"""The sources of kernels: the files that define what a kernel calls, or a constant that it uses.

They are read, not imported, so that their digests are known before any kernel is imported.
"""

from __future__ import annotations

import ast
import hashlib
import io
import tokenize
from collections.abc import Iterable, Iterator
from functools import cache
from importlib import resources
from typing import Any

PACKAGE = "frictionlab"
WITH_KERNELS = "frictionlab.tape", "frictionlab.hybrid"  # the packages that define kernels
# They determine how kernels are compiled and where the code is, not what it computes: what they import does
# not matter.
DECORATORS_MODULE, MACHINE_CODE = "frictionlab.compilation.decorators", "frictionlab.compilation.machine_code"
DECORATORS = ("kernel", "inlined")
# Plain functions that native code calls.
CALLED_BY_NATIVE_CODE = ("frictionlab.hybrid.codegen.jet_codegen", "KERNELS")
Name = tuple[str, str]  # a module, and a name in it


def kernel_sources() -> dict[str, bytes]:
    """Content of each file that the code of a kernel depends on, by its path in the package."""
    return source_files(kernel_names())


def kernel_names() -> dict[str, set[str]]:
    """The names that the code of a kernel depends on, by the module that defines them; none: all of it."""
    names: dict[str, set[str]] = {DECORATORS_MODULE: set()}
    left = [CALLED_BY_NATIVE_CODE, *_kernels()]
    while left:
        module, name = left.pop()
        if module in (DECORATORS_MODULE, MACHINE_CODE) or name in names.get(module, ()):
            continue
        names.setdefault(module, set()).add(name)
        left += needed_names(module, name)
    return {module: own | _named_tuples(module) if own else own for module, own in names.items()}


def _named_tuples(module: str) -> set[str]:
    """Classes of named tuples in a module: kernels take their fields by the order that they have there."""
    definitions, _ = module_contents(module)
    nodes = [(name, node) for name, statements in definitions.items() for node in statements]
    return {name for name, node in nodes if isinstance(node, ast.ClassDef) and _is_named_tuple(node)}


def _is_named_tuple(node: ast.ClassDef) -> bool:
    return any(isinstance(base, ast.Name) and base.id == "NamedTuple" for base in node.bases)


def source_files(modules: Iterable[str]) -> dict[str, bytes]:
    """Content of the files of modules, by their paths in the package."""
    return {path_of(module): read_module(module) for module in sorted(modules)}


def _kernels() -> Iterator[Name]:
    """The functions that have a decorator of kernels."""
    for module in (each for package in WITH_KERNELS for each in _modules(resources.files(package), package)):
        if any(f"\n@{decorator}\n".encode() in read_module(module) for decorator in DECORATORS):
            definitions, _ = module_contents(module)
            for name, nodes in definitions.items():
                if any(_is_kernel(node) for node in nodes):
                    yield module, name


def _is_kernel(node: ast.AST) -> bool:
    decorators = getattr(node, "decorator_list", [])
    return any(isinstance(each, ast.Name) and each.id in DECORATORS for each in decorators)


def _modules(folder: Any, package: str) -> Iterator[str]:
    """The modules in a folder and its subfolders; the folder may be in a zip file."""
    for entry in sorted(folder.iterdir(), key=lambda entry: entry.name):
        if entry.is_dir():
            yield from _modules(entry, f"{package}.{entry.name}")
        elif entry.name.endswith(".py") and entry.name != "__init__.py":
            yield f"{package}.{entry.name.removesuffix('.py')}"


def needed_names(module: str, name: str) -> list[Name]:
    """The names of the package that the definition of a name uses, each with the module it comes from."""
    definitions, imports = module_contents(module)
    needed = []
    for node in definitions.get(name, []):
        for part in ast.walk(node):
            if isinstance(part, ast.Attribute) and isinstance(part.value, ast.Name):
                origin = imports.get(part.value.id)
                if origin is not None and _is_module(".".join(origin)):
                    needed.append((".".join(origin), part.attr))
            elif isinstance(part, ast.Name):
                if part.id in imports:
                    needed.append(imports[part.id])
                elif part.id in definitions:
                    needed.append((module, part.id))
    if not definitions.get(name) and name in imports:
        needed.append(imports[name])
    return [(home, one) for home, one in needed if _is_module(home) and not _is_module(f"{home}.{one}")]


@cache
def module_contents(module: str) -> tuple[dict[str, list[ast.AST]], dict[str, Name]]:
    """What a module's statements define, by name; and what it imports from the package: for each name the
    module that it comes from, and its name there."""
    definitions: dict[str, list[ast.AST]] = {}
    imports: dict[str, Name] = {}
    tree = ast.parse(read_module(module))
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
    """The statements of a module, and those inside its `if`, `try` and `with` statements."""
    for node in body:
        yield node
        for inner in ("body", "orelse", "finalbody"):
            if isinstance(node, (ast.If, ast.Try, ast.With)):
                yield from _statements(getattr(node, inner, []))


def _file(module: str) -> Any:
    """The file of a module of the package, which need not exist."""
    _, *parts = module.split(".")
    return resources.files(PACKAGE).joinpath(*parts[:-1], f"{parts[-1]}.py") if parts else None


def path_of(module: str) -> str:
    """The path of a module's file in the package."""
    return module.removeprefix(f"{PACKAGE}.").replace(".", "/") + ".py"


@cache
def read_module(module: str) -> bytes:
    """Content of a module's file."""
    return _file(module).read_bytes()


@cache
def _is_module(name: str) -> bool:
    """Whether a name is that of a module's file; packages do not count, as they hold no kernels."""
    file = _file(name) if name.startswith(f"{PACKAGE}.") else None
    return file is not None and file.is_file()


def digest(content: bytes) -> str:
    """Digest by which files are compared."""
    return hashlib.sha256(content).hexdigest()


def code_digest(content: bytes, names: tuple[str, ...] = ()) -> str:
    """Digest of what machine code may depend on: neither docstrings, comments and blank lines nor, where
    names are given, the definitions of others."""
    try:
        text = _chosen_statements(content.decode(), names) if names else content.decode()
        return digest(_without_prose(text).encode())
    except (tokenize.TokenError, SyntaxError):
        return digest(content)


def _chosen_statements(text: str, names: tuple[str, ...]) -> str:
    """The statements of a module that define one of the names, and those that do anything but define."""
    tree, lines = ast.parse(text), text.splitlines()
    statements = [node for node in tree.body if _defined_names(node) is None or _defines(node, names)]
    used_names = {part.id for node in statements for part in ast.walk(node) if isinstance(part, ast.Name)}
    origins = [
        f"from {node.module} import {alias.name} as {alias.asname or alias.name}"
        for node in tree.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
        if (alias.asname or alias.name) in used_names
    ]
    return "\n".join([*sorted(origins), *(_text(node, lines) for node in statements)])


def _defines(node: ast.stmt, names: tuple[str, ...]) -> bool:
    """Whether a statement defines one of the names."""
    return not (_defined_names(node) or set()).isdisjoint(names)


def _defined_names(node: ast.stmt) -> set[str] | None:
    """The names that a statement of a module defines; None for one that does something else."""
    if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
        return {node.name}
    if isinstance(node, (ast.Assign, ast.AnnAssign)):
        parts = (part for part in ast.walk(node) if isinstance(part, ast.Name))
        stored = {part.id for part in parts if isinstance(part.ctx, ast.Store)}
        return stored or None
    is_text = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
    return set() if is_text or isinstance(node, ast.ImportFrom) else None


def _text(node: ast.stmt, lines: list[str]) -> str:
    """The lines of a statement, with its decorators."""
    first = min([node.lineno, *(each.lineno for each in getattr(node, "decorator_list", []))])
    return "\n".join(lines[first - 1 : node.end_lineno])


def _without_prose(text: str) -> str:
    """Code without its docstrings, comments and blank lines."""
    tokens = list(tokenize.generate_tokens(io.StringIO(text).readline))
    lines = text.splitlines()
    befores = [None, *tokens]
    for before, token, after in reversed(list(zip(befores, tokens, tokens[1:], strict=False))):
        is_statement = (before is None or before.type in STATEMENT_ENDS) and after.type == tokenize.NEWLINE
        if token.type == tokenize.COMMENT or (token.type == tokenize.STRING and is_statement):
            (first, begin), (last, end) = token.start, token.end
            lines[first - 1 : last] = [lines[first - 1][:begin] + lines[last - 1][end:]]
    return "\n".join(line.rstrip() for line in lines if line.strip())


# What stands before a statement that is a string alone.
STATEMENT_ENDS = (
    *(tokenize.NEWLINE, tokenize.NL),
    *(tokenize.INDENT, tokenize.DEDENT, tokenize.COMMENT),
)
