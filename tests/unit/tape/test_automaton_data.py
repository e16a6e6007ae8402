"""An automaton in a file: the same when it is read, to the last bit, and nothing in the file is executed."""

import json
from dataclasses import replace

import numpy as np
import pytest
import sympy as sp

import frictionlab as fl
from frictionlab.models.automaton_of_model import automaton_from_structure_data
from frictionlab.tape import automaton_data
from frictionlab.tape.automaton_data import automaton_from_data, automaton_to_data, storable_automaton
from frictionlab.tape.packing import program_of
from tests.helpers.automata import automaton, ball, coulomb
from tests.helpers.linear_automata import linear
from tests.helpers.lorenz import lorenz

X, V = sp.symbols("x v")
K = sp.Symbol("k", positive=True)
EXPRESSIONS = {
    "functions": sp.tanh(X / K) + sp.exp(-X) * sp.sin(V) - sp.atan(V) ** 3 / sp.cosh(X),
    "as written": sp.Mul(2, sp.Add(V, X, V, evaluate=False), evaluate=False),
    "fractions and roots": sp.Rational(1, 3) * X + sp.sqrt(X**2 + K) / (3 - V) ** 2,
    "numbers": sp.Float("0.1", 40) * X + 0.1 * V + sp.pi * K + sp.E - sp.Float(1e-300) + sp.Float(0.0),
    "powers": (X**2 + 1) ** K + (V**2 + 1) ** sp.Float(1.5),
    "of parameters": sp.Max(K, 2) * X + sp.Abs(K - 3) * V + sp.sign(K) + sp.floor(K) + sp.atan2(K, 2),
    "of Python": 2,
}
AUTOMATA = {
    **{
        name: automaton(fl.Mode("only", (V, expr)), k=1.25)
        if not sp.sympify(expr).has(K)
        else fl.HybridAutomaton((X, V), (fl.Mode("only", (V, expr)),), {K: 1.25}, 1)
        for name, expr in EXPRESSIONS.items()
    },
    "ball": ball(),
    "friction": replace(coulomb(0.5, 1.0, 0.75), period=7.6),
    "linear": linear([4.0]),
    "Lorenz": lorenz(),
    **{name: getattr(fl, name)().automaton() for name in ("MassOnBelt", "SliderOnBelt", "DenHartog")},
}


def through_json(given):
    """The automaton after a way through text."""
    return automaton_from_data(json.loads(json.dumps(automaton_to_data(given))))


def arrays(given):
    """Everything that the solver knows of an automaton."""
    program, numbers = program_of(given)
    return [*(each for each in (*program.code, *numbers) if isinstance(each, np.ndarray)), program.guards]


@pytest.mark.parametrize("name", AUTOMATA)
def test_the_program_is_the_same_to_the_last_bit(name):
    given = AUTOMATA[name]
    again = through_json(given)
    assert again.names == given.names
    assert again.outputs == given.outputs
    assert list(again.parameters) == list(given.parameters)
    assert (again.period, again.cyclic) == (given.period, given.cyclic)
    for one, other in zip(arrays(given), arrays(again), strict=True):
        assert np.array_equal(one, other, equal_nan=True) if isinstance(one, np.ndarray) else one == other


@pytest.mark.parametrize("name", ["ball", "friction", "MassOnBelt", "SliderOnBelt"])
def test_a_run_needs_no_model_to_be_read(name, tmp_path):
    given = AUTOMATA[name]
    start = {"ball": [1.0, 0.0]}.get(name, np.zeros(len(given.states)))
    run = fl.solve(given, 3.0, x0=start, progress=False)
    again = fl.load(run.save(tmp_path / "run"))
    t = np.linspace(0.0, 3.0, 301)
    assert again(t).tobytes() == run(t).tobytes()
    assert again.events.guard.tolist() == run.events.guard.tolist()
    for output in given.outputs:
        assert again[output].tobytes() == run[output].tobytes()
    ends = [fl.solve(each.automaton, 3.0, x0=run(1.0), progress=False).final_state for each in (run, again)]
    assert ends[0].tobytes() == ends[1].tobytes()
    assert again.save(tmp_path / "again").read_bytes() == run.save(tmp_path / "again").read_bytes()


def test_pieces_and_conditions_may_be_in_outputs(tmp_path):
    pieces = sp.Piecewise((X, sp.And(X > 0, V < 1)), (sp.Heaviside(V), sp.Not(sp.Eq(V, 2))), (0, True))
    given = automaton(fl.Mode("only", (V, -X), outputs={"pieces": pieces}))
    assert through_json(given).modes[0].outputs["pieces"] == pieces


def test_symbols_of_one_name_stay_apart():
    """A real x and any x, and two dummies; each is one symbol wherever it stands."""
    real, a, b = sp.Symbol("x", real=True), sp.Dummy("x"), sp.Dummy("x")
    given = fl.HybridAutomaton((X, real, a, b), (fl.Mode("only", (real, a, b, X * a - b * real)),))
    again = through_json(given)
    assert len(set(again.states)) == 4
    assert again.modes[0].flow[:3] == again.states[1:]
    x, y, c, d = again.states
    assert again.modes[0].flow[3] == x * c - d * y


def test_parameters_of_any_kind_of_number_are_floats(tmp_path):
    given = fl.HybridAutomaton((X, V), (fl.Mode("only", (V, -K * X)),), {K: sp.pi}, 1)
    run = fl.solve(given, 1.0, x0=[1.0, 0.0])
    again = fl.load(run.save(tmp_path / "run"))
    assert again.automaton.parameters == {K: float(sp.pi)}
    assert again.states.tobytes() == run.states.tobytes()
    assert fl.load(tmp_path / "run.npz", model=given).states.tobytes() == run.states.tobytes()


def test_what_no_file_can_hold_is_said_and_needs_the_automaton(tmp_path):
    given = automaton(fl.Mode("only", (V, -X), outputs={"strange": sp.gamma(X)}))
    assert "gamma" in storable_automaton(given)
    run = fl.solve(given, 1.0, x0=[1.0, 0.0])
    path = run.save(tmp_path / "run")
    with pytest.raises(
        ValueError, match=r"no operation for gamma\(x\): give it as load\(path, model=automaton\)"
    ):
        fl.load(path)
    assert fl.load(path, model=given).states.tobytes() == run.states.tobytes()


def run_of_two_blocks():
    """Modes that are derived when a run comes to them, which no file can hold."""
    given = fl.TwoBlocks().automaton().replace(mu_k=0.25)
    return fl.solve(given, 5.0, x0=[0.0, 0.0, 0.0, 0.0], progress=False)


def test_a_run_of_modes_on_demand_needs_no_model(tmp_path):
    run = run_of_two_blocks()
    again = fl.load(run.save(tmp_path / "run"))
    assert again.source is None
    assert again.automaton.modes is run.automaton.modes
    assert again.automaton.parameters == run.automaton.parameters
    assert again.states.tobytes() == run.states.tobytes()
    assert again.mode.tolist() == run.mode.tolist()
    further = fl.solve(again.automaton, 5.0, x0=again.problem.x0, progress=False)
    assert further.states.tobytes() == run.states.tobytes()


@pytest.mark.parametrize(
    ("name", "changes", "word"),
    [
        ("automaton", {"coordinates": 3}, "3 coordinates instead of 2"),
        ("automaton", {"derived from": None}, "must be a mapping with 'class' and 'structure'"),
        (
            "automaton",
            {"derived from": {"class": "os:system", "structure": {}}},
            "no Model 'os:system' is loaded",
        ),
        ("parameters", {"k": "1.0"}, "its parameters are"),
        ("parameters", {"k": None}, "its parameters are"),
    ],
)
def test_a_file_of_modes_on_demand_that_cannot_be_is_refused(tmp_path, name, changes, word):
    path = run_of_two_blocks().save(tmp_path / "run")
    with np.load(path) as file:
        arrays = {key: file[key] for key in file.files}
    about = json.loads(str(arrays["about"]))
    about[name] = {**about[name], **changes}
    np.savez_compressed(path, **{**arrays, "about": np.array(json.dumps(about))})
    with pytest.raises(ValueError, match=word) as caught:
        fl.load(path)
    assert str(path) in str(caught.value)


def test_a_structure_of_a_model_is_checked():
    model = fl.TwoBlocks()
    data, numbers = model.automaton().modes.origin(), model.parameters
    assert automaton_from_structure_data(data, fl.Model, numbers).modes is model.automaton().modes
    with pytest.raises(ValueError, match="TwoBlocks has"):
        automaton_from_structure_data({**data, "structure": {}}, fl.Model, numbers)
    with pytest.raises(ValueError, match="it lacks the parameters m1, m2"):
        automaton_from_structure_data(data, fl.Model, {})


@pytest.mark.parametrize("row", [["system", 0], ["__import__", 0], ["Add", 0, 10_000], ["sin", 0, 1], []])
def test_only_known_operations_are_made(row):
    data = automaton_to_data(automaton(fl.Mode("only", (V, -X))))
    data["nodes"].append(row)
    with pytest.raises(ValueError, match=r"\w"):
        automaton_from_data(data)


def test_names_are_names_whatever_they_say(tmp_path):
    """lambdify prints expressions as Python: a symbol's name is not a part of the program."""
    evil = sp.Symbol(f"__import__('pathlib').Path({str(tmp_path / 'executed')!r}).touch()")
    mode = fl.Mode("only", (V, -evil * X), outputs={"y": evil * X})
    given = fl.HybridAutomaton((X, V), (mode,), {evil: 1.0}, 1)
    run = fl.solve(given, 1.0, x0=[1.0, 0.0])
    again = fl.load(run.save(tmp_path / "run"))
    assert again["y"].tobytes() == run["y"].tobytes()
    assert [path.name for path in tmp_path.iterdir()] == ["run.npz"]


def test_every_operation_is_made_as_it_was():
    """Each operation that files may hold, of as few arguments as it takes."""
    conditions = sp.Eq, sp.Ne, sp.Gt, sp.Ge, sp.Lt, sp.Le, sp.And, sp.Or, sp.Not
    for operation in automaton_data.operations().values():
        if operation.__name__ in ("ExprCondPair", "Piecewise"):
            continue  # tested above
        symbols = (X < V, V < 1) if operation in (sp.And, sp.Or, sp.Not) else (X, V)
        try:
            made = operation(symbols[0], evaluate=False)
            assert made.func is operation
        except (TypeError, ValueError, AssertionError):
            made = operation(*symbols, evaluate=False)
        made = sp.Piecewise((X, made), (V, True)) if operation in conditions else made
        given = automaton(fl.Mode("only", (V, X), outputs={"made": made}))
        assert through_json(given).modes[0].outputs["made"] == made
