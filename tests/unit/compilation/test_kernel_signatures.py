"""Every kernel says what it does."""

import ast
from pathlib import Path

import pytest

import frictionlab

DECORATORS = {"kernel", "inlined"}


def kernels():
    """Every function that is compiled, with its module."""
    root = Path(frictionlab.__file__).parent
    for path in sorted(root.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.FunctionDef) and DECORATORS & {
                ast.unparse(d) for d in node.decorator_list
            }:
                yield pytest.param(node, id=f"{path.stem}.{node.name}")


FOUND = list(kernels())


def test_kernels_are_found():
    assert len(FOUND) > 100


@pytest.mark.parametrize("function", FOUND)
def test_a_kernel_says_what_it_does(function):
    assert ast.get_docstring(function)
