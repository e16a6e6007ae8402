"""Powers whose base becomes negative, and numbers that floats cannot hold, in equations of users."""

import numpy as np
import pytest
import sympy as sp

import frictionlab as fl
from frictionlab.components import FrictionLaw
from frictionlab.hybrid.solve import RunOptions, run_automaton
from frictionlab.models import Friction, MechanicalModel, Mechanics
from tests.helpers.automata import V, X, automaton

P = sp.Symbol("p")


def solved(flow, t_end, x0, **values):
    states = (X, V)[: len(flow)]
    scene = automaton(fl.Mode("only", flow), states=states, coordinates=len(flow) // 2, **values)
    return fl.solve(scene, t_end, x0=x0, progress=False)


@pytest.mark.parametrize(
    ("flow", "x0", "values"),
    [
        ((V, -(X**P)), [-0.5, 0.0], {"p": 3.0}),
        ((sp.sqrt(X - 2),), [0.0], {}),
        ((V, -(X**1.5)), [-1e-9, 0.0], {}),
    ],
)
def test_a_run_does_not_begin_where_a_power_has_no_real_value(flow, x0, values):
    with pytest.raises(
        ValueError, match=r"x0 must be where the laws have real values, got x.* = -.* to the power"
    ):
        solved(flow, 1.0, x0, **values)


@pytest.mark.parametrize("exponent", [1.5, P])
def test_a_run_ends_where_the_base_of_a_power_becomes_negative(exponent):
    """x'' = -9 - x^1.5 from 1: v at x = 0 by the energy, v^2 = 2 (9 + 0.4)."""
    values = {"p": 1.5} if exponent is P else {}
    with pytest.warns(RuntimeWarning, match=r"it ended at .* with x = -.* to the power"):
        run = solved((V, -9 - X**exponent), 0.46, [1.0, 0.0], **values)
    assert run.status.name == "NOT_FINITE"
    assert run.states[:, 0].min() > -1e-4
    assert run.stats["steps"] < 100  # the steps after its end, which are not its own, are few as well
    assert run.final_state[1] == pytest.approx(-np.sqrt(2 * 9.4), abs=1e-3)


@pytest.mark.parametrize(("x0", "t_end"), [([1.0, 0.0], 0.46), ([3.0, -1.0], 0.7)])  # past x = 0
def test_runs_of_an_ensemble_end_where_single_runs_do(x0, t_end):
    scene = automaton(fl.Mode("only", (V, -9 - X**1.5)))
    starts = [x0, [1.0, 20.0]]
    ends = fl.ensemble([scene] * 2, t_end, x0=starts, progress=False)
    for i, start in enumerate(starts):
        run = run_automaton(scene, t_end, np.array(start), fl.Taylor(), RunOptions(progress=False))
        assert ends.status[i] is run.status
        assert (ends.t[i], ends.steps[i]) == (run.raw.t, run.stats["steps"])
        np.testing.assert_array_equal(ends.states[i], run.raw.state)
    assert ends.status[0].name == "NOT_FINITE"
    assert ends.status[1].ok


def test_an_ensemble_does_not_begin_where_a_power_has_no_real_value():
    scene = automaton(fl.Mode("only", (V, -(X**P))), p=3.0)
    with pytest.raises(ValueError, match=r"x0 of models\[1\] must be where .* real values, got x = -"):
        fl.ensemble([scene] * 2, 1.0, x0=[[0.5, 0.3], [-0.5, 0.0]], progress=False)


@pytest.mark.parametrize("tol", [1e-6, 1e-15])
def test_a_law_of_both_signs_is_written_by_the_size_of_its_base(tol):
    """x'' = -x^3 from 1/2, as x |x|^(p - 1), and the slope of |x|^(p + 1), against the integer power."""
    exact = solved((V, -(X**3)), 30.0, [0.5, 0.0])
    size = sp.Abs(X)
    real = {X: sp.Symbol("x", real=True)}
    slope = (sp.Abs(real[X]) ** (P + 1)).diff(real[X]).xreplace({real[X]: X}) / (P + 1)
    for force in X * size ** (P - 1), slope:
        scene = automaton(fl.Mode("only", (V, -force)), p=3.0)
        run = fl.solve(scene, 30.0, x0=[0.5, 0.0], method=fl.Taylor(tol=tol), progress=False)
        assert run.final_state == pytest.approx(exact.final_state, abs=1e-14 + tol)


def test_a_root_that_comes_to_rest_at_zero_goes_on():
    """x' = -sqrt(x): x = (1 - t/2)^2 until 2, then 0."""
    run = solved((-sp.sqrt(X),), 4.0, [1.0])
    assert run.status.ok
    assert abs(run.final_state[0]) < 1e-12


def test_an_exponential_function_with_a_number_that_floats_cannot_hold():
    """sympy makes 5e-435 exp(1000.0 x) of it.  exp(-k (x - 1)) = k t + exp(-k (x0 - 1))."""
    run = solved((-sp.exp(1000.0 * (X - 1)),), 1.0, [1.01])
    assert run.final_state[0] == pytest.approx(1 - np.log(1000 + np.exp(-10.0)) / 1000, rel=1e-13)


def test_an_exponent_written_as_a_float_is_the_integer():
    works = {"float": sp.Float(3.7) * (X - 3) ** sp.Float(1.0), "integer": 3.7 * (X - 3)}
    scene = automaton(fl.Mode("only", (V, -X)), coordinates=1)
    run = fl.solve(scene, 7.3, x0=[0.3, 0.1], quadratures=works, progress=False)
    assert run.quadratures["float"] == run.quadratures["integer"]


@pytest.mark.parametrize("name", ["power", "sqrt", "exp", "select"])
def test_a_parameter_may_have_the_name_of_a_function(name):
    number = sp.Symbol(name)
    outputs = {"f": (X + 3) ** sp.Rational(3, 2) * number * sp.exp(X)}
    scene = automaton(fl.Mode("only", (V, -X - V + sp.exp(number)), outputs=outputs), **{name: 2.0})
    run = fl.solve(scene, 1.0, x0=[0.0, 0.0], progress=False)
    assert run.f == pytest.approx(2 * (run["x"] + 3) ** 1.5 * np.exp(run["x"]), rel=1e-14)
    assert [one.state[0] for one in fl.equilibria(scene)] == [pytest.approx(np.exp(2.0), rel=1e-14)]


@fl.model
class Row(MechanicalModel):
    """Four blocks on the ground, of which the first is drawn by -9 - x^1.5 to zero and beyond."""

    friction: FrictionLaw = fl.Coulomb(mu_k=0.1, mu_s=0.1)
    coordinates = ("x1", "x2", "x3", "x4")

    def mechanics(self, q, v):
        v = (v.x1, v.x2, v.x3, v.x4)
        return Mechanics(
            kinetic=sum(each**2 for each in v) / 2,
            potential=9 * q.x1 + q.x1**2.5 / 2.5,
            contacts=tuple(Friction(-each, 1.0, self.friction) for each in v),
        )


def test_runs_with_modes_on_demand_end_where_single_runs_do():
    """The modes are those that runs come to, so that the program grows as they go on."""
    model = Row()
    assert model.automaton().on_demand
    starts = [[1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0], [9.0, 0.0, 0.0, 0.0, 40.0, 0.0, 0.5, 0.0]]
    ends = fl.ensemble([model] * 2, 1.0, x0=starts, progress=False)
    for i, start in enumerate(starts):
        run = run_automaton(model.automaton(), 1.0, np.array(start), fl.Taylor(), RunOptions(progress=False))
        assert ends.status[i] is run.status
        np.testing.assert_array_equal(ends.states[i], run.raw.state)
    assert [status.name for status in ends.status] == ["NOT_FINITE", "FINISHED"]
