"""Imports between files of the package, and what calls go through: `python -m tests.helpers.layout`."""

import ast
import inspect
import sys
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from types import FrameType
from typing import Any

PACKAGE = Path(__file__).parents[2] / "frictionlab"
Graph = dict[str, set[str]]


def module_name(path: Path) -> str:
    """The dotted name of a file; of an `__init__.py` that of its package."""
    parts = path.relative_to(PACKAGE.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def imports() -> Graph:
    """The files that each file imports, within functions too; what a package passes on counts at its home."""
    paths = {module_name(path): path for path in PACKAGE.rglob("*.py")}
    statements = {module: list(_imports(module, path)) for module, path in paths.items()}
    homes = {
        f"{module}.{name}": f"{origin}.{name}"
        for module, path in paths.items()
        if path.name == "__init__.py"
        for origin, name in statements[module]
    }

    def home(name: str) -> str:
        while name in homes and name not in paths:
            name = homes[name]
        return name if name in paths else name.rpartition(".")[0]

    graph: Graph = {}
    for module, path in paths.items():
        if path.name != "__init__.py":
            reached = {home(f"{origin}.{name}") for origin, name in statements[module]}
            graph[module] = {one for one in reached if one in paths and paths[one].name != "__init__.py"} - {
                module
            }
    return graph


def _imports(module: str, path: Path) -> Iterator[tuple[str, str]]:
    package = module if path.name == "__init__.py" else module.rpartition(".")[0]
    for node in _without_type_checking(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom):
            above = package.split(".")[: package.count(".") + 2 - node.level] if node.level else []
            origin = ".".join([*above, *([node.module] if node.module else [])])
            yield from ((origin, alias.name) for alias in node.names)


def _without_type_checking(node: ast.AST) -> Iterator[ast.AST]:
    for child in ast.iter_child_nodes(node):
        if not (isinstance(child, ast.If) and ast.unparse(child.test) == "TYPE_CHECKING"):
            yield child
            yield from _without_type_checking(child)


def cycles(graph: Graph) -> list[list[str]]:
    """The sets of files each of which leads to every other."""
    reach = {module: _reachable(graph, module) for module in graph}
    sets = {frozenset(other for other in reach[one] if one in reach[other]) for one in graph}
    return [sorted(each) for each in sets if len(each) > 1]


def _reachable(graph: Graph, start: str) -> set[str]:
    seen: set[str] = set()
    left = [start]
    while left:
        new = graph[left.pop()] - seen
        seen |= new
        left += new
    return seen


def touched(call: Callable[[], object]) -> tuple[int, int]:
    """Files whose functions a call goes through, and these functions; a kernel counts once.

    Bodies of modules and classes, lambdas and comprehensions are none.
    """
    seen: set[tuple[str, str, int]] = set()

    def note(frame: FrameType, event: str, _: object) -> None:
        code = frame.f_code
        is_function = code.co_flags & inspect.CO_OPTIMIZED and not code.co_name.startswith("<")
        if event == "call" and is_function and code.co_filename.startswith(str(PACKAGE)):
            seen.add((code.co_filename, code.co_name, code.co_firstlineno))

    sys.setprofile(note)
    try:
        call()
    finally:
        sys.setprofile(None)
    return len({file for file, *_ in seen if not file.endswith("__init__.py")}), len(seen)


def _calls() -> dict[str, Callable[[], object]]:
    """Calls that are followed through the package, each the first time after those before it."""
    import frictionlab as fl

    model = fl.SliderOnBelt(mu_k=1.4)
    return {
        "simulate": lambda: fl.simulate(model, 1.0),
        "explore": lambda: fl.explore(model),
        "bifurcation": lambda: fl.bifurcation(
            model, "mu_k", [0.5, 1.0], transient=5.0, window=5.0, workers=1, progress=False
        ),
        "critical_value": lambda: fl.critical_value(model, "mu_k", bounds=(0, 4)),
        "a slider's step": lambda: _move(_slider()),
    }


@cache
def _slider() -> Any:
    import frictionlab as fl

    explorer = fl.explore(fl.SliderOnBelt(mu_k=1.4))
    explorer.widget.sliding = True
    return explorer.controls["mu_k"]


def _move(slider: Any) -> None:
    slider.value += 0.01


def main() -> None:
    """Print what calls go through, the first time and again."""
    for name, call in _calls().items():
        print(f"files, functions called by {name}: {touched(call)}; again: {touched(call)}")


if __name__ == "__main__":
    main()
