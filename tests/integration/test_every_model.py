"""Every model goes through everything, without code of its own."""

import json
from dataclasses import dataclass

import numpy as np
import pytest
import sympy as sp

import frictionlab as fl
from frictionlab.models.symbols import symbol
from tests.helpers.cases import slow_but

NAMES = {name: getattr(fl, name) for name in fl.__all__ if name[0].isupper()}
CALLS = [row.call for row in fl.list_models("classics") if row.call != "SliderOnBelt()"]
OTHER_LAWS = [call for call in CALLS if "friction=" in call]  # of models that are there without them too
SLOWER = [f"{name}()" for name in ("SliderOnRigidBelt", "ModeCoupling", "TwoBlocks")]
VARIED = ("v", "Omega", "h", "x_0")
FORCED = ("DenHartog", "ImpactOscillator", "FreeCoulomb")


@pytest.fixture(params=slow_but({*CALLS} - {*OTHER_LAWS, *SLOWER}, CALLS))
def model(request):
    return eval(request.param, {"fl": fl, **NAMES})


@dataclass(frozen=True, repr=False)
class Hyperbolic(fl.Coulomb):
    """Galvanetto and Bishop's law: mu = mu_s/(1 + fall |v_r|)."""

    fall: float = fl.parameter(3.0, unit="s/m", symbol="d", meaning="fall", range=(0.0, 10.0))

    def kinetic(self, normal_force, speed):
        return self.mu_s * normal_force / (1 + self.fall * speed)


@fl.model
class VanDerPol(fl.Model):
    """x'' - mu (1 - x^2) x' + x = 0, by its automaton alone."""

    mu: float = fl.parameter(0.5, symbol=r"\mu", meaning="strength", range=(0.0, 5.0))
    coordinates = ("x",)
    period = 6.3

    def derive(self):
        x, v = symbol("x"), symbol("x'")
        return fl.HybridAutomaton((x, v), (fl.Mode("only", (v, self.mu * (1 - x**2) * v - x)),), {}, 1)


class Nothing(fl.MechanicalModel):
    coordinates = ("x",)


def varied(model):
    return next(name for name in VARIED if name in model.parameters)


def test_the_table_of_models_prints():
    table = fl.list_models("classics")
    assert len(table) == 10
    assert all(row.about and row.reference for row in table)
    assert "fl.DenHartog()" in repr(table)
    assert table._repr_html_().count("<tr>") == 11
    for row in table:
        assert isinstance(eval(row.call, {"fl": fl, **NAMES}), fl.Model)


def test_it_passes_the_conformance_suite(model):
    run = fl.testing.check_model(model, t_end=10 * model.period)
    assert run.status.ok


def test_it_says_what_it_is(model):
    assert len(model.describe()) == len(model.parameters)
    assert "$" in model.describe()._repr_html_()
    assert fl.Model.from_dict(json.loads(json.dumps(model.to_dict()))) == model
    assert type(model).__doc__
    assert model.period > 0
    for mode in model.automaton().names:
        equations = model.equations(mode)
        assert len(equations.motion) == len(model.coordinates)
        assert r"\ddot" in equations.latex()
    with pytest.raises(ValueError, match="mode must be one of"):
        model.equations("slipp")


def test_its_equations_are_those_of_its_automaton(model):
    """Accelerations from the printed equations and forces, against the flow, at random states."""
    automaton, n = model.automaton(), len(model.coordinates)
    states = dict(zip(automaton.states, np.random.default_rng(1).uniform(0.1, 0.4, len(automaton.states))))
    time = sp.Symbol("t", real=True)
    for mode in automaton.modes:
        found = model.equations(mode.name)
        functions = {name: found.symbols[name] for name in model.coordinates}
        seconds = [sp.diff(functions[name], time, 2) for name in model.coordinates]
        forces = {e.lhs: e.rhs for e in (*found.definitions, *found.forces)}
        assert len(found.motion) == len(seconds) > 0
        written = [(e.lhs - e.rhs).subs(forces).subs(forces) for e in found.motion]
        solved = sp.solve(written, seconds, dict=True)[0]
        numbers = {symbol.name: value for symbol, value in {**states, **automaton.parameters}.items()}
        at = {sp.diff(functions[x], time): numbers[x + "'"] for x in model.coordinates}
        at |= {functions[x]: numbers[x] for x in model.coordinates}
        if "phase" in numbers:
            at[time] = numbers["phase"] / numbers["Omega"]
        at |= dict(automaton.parameters)
        values = {**states, **automaton.parameters}
        for second, rate in zip(seconds, mode.flow[n : 2 * n]):
            exact = float(sp.sympify(rate).subs(values))
            # Where accelerations are of a size of 1e6 their last bit is more than 1e-12.
            assert float(solved[second].subs(at).subs(automaton.parameters)) == pytest.approx(
                exact, rel=1e-14, abs=1e-12
            )


def test_its_equilibrium_is_one_or_it_says_why_not(model):
    if type(model).__name__ in FORCED:
        assert fl.equilibria(model) == ()
        with pytest.raises(ValueError, match="must have a mode with an equilibrium inside its guards"):
            fl.eigenvalues(model)
        with pytest.raises(ValueError, match="must have a mode"):
            fl.simulate(model, 1.0, x0="near")
        return
    point = fl.equilibrium(model)
    assert point.residual < 1e-12
    if isinstance(model, fl.BouncingBall):  # it rests on the ground, which holds its only coordinate
        assert (point.q.tolist(), point.normal_force) == ([0.0], model.m * model.g)
        with pytest.raises(ValueError, match="must leave a coordinate free to have eigenvalues"):
            fl.eigenvalues(model)
        return
    start = [*point.q, *np.zeros(len(point.q))]
    run = fl.simulate(model, model.period, x0=start, progress=False)
    assert run.final_state == pytest.approx(start, abs=1e-12)
    values = fl.eigenvalues(model).values
    assert len(values) == 2 * len(model.coordinates)
    locus = fl.root_locus(model, "c", [0.1, 0.2])
    assert np.isfinite(locus.values).all()


def test_it_can_be_swept(model):
    name = varied(model)
    values = [0.95 * getattr(model, name), getattr(model, name)]
    times = {"transient": 20 * model.period, "window": 10 * model.period}
    found = fl.bifurcation(model, name, values, progress=False, **times)
    assert all(found.kinds)
    assert "ended early" not in found.kinds
    assert found.model == model
    swept = fl.sweep(model, lambda m: len(m.coordinates), {name: values}, progress=False)
    assert swept is not None


def test_it_can_be_drawn_and_saved(model, tmp_path):
    run = fl.simulate(model, 12 * model.period, progress=False)
    again = fl.load(run.save(tmp_path / "run"))
    assert again.source == model
    assert (again.final_state == run.final_state).all()
    figure = fl.plot_run(run)
    figure.canvas.draw()
    assert len(figure.axes) >= 4
    assert all(ax.get_xlabel() for ax in figure.axes[:4])


def test_a_model_without_nonlinearities_by_name_says_so():
    assert dict(VanDerPol().nonlinearities) == {}
    assert VanDerPol().without() == VanDerPol()
    with pytest.raises(ValueError, match="VanDerPol has no nonlinearity to leave out by name"):
        VanDerPol().without("cubic")


def test_a_start_may_leave_out_the_phase():
    model = fl.DenHartog()
    short, whole = (fl.simulate(model, 5.0, x0=x0, progress=False) for x0 in ([1.0, 0.0], [1.0, 0.0, 0.0]))
    assert short.final_state.tolist() == whole.final_state.tolist()


TAKE_ANY_LAW = fl.MassOnBelt(), fl.FreeCoulomb(x_0=3.0), fl.DenHartog(), fl.ModeCoupling(), fl.TwoBlocks()


@pytest.mark.parametrize("model", slow_but(TAKE_ANY_LAW[:2], TAKE_ANY_LAW), ids=lambda m: type(m).__name__)
def test_a_law_of_ones_own_goes_into_any_model(model):
    run = fl.testing.check_model(model.replace(friction=Hyperbolic(mu_s=0.9)), t_end=20.0)
    assert run.status.ok


def test_a_model_of_ones_own_by_its_automaton():
    """With derive() alone everything else works."""
    model = VanDerPol(mu=0.1)
    fl.testing.check_model(model)
    found = np.sort_complex(fl.eigenvalues(model).values)
    assert found == pytest.approx(np.sort_complex(np.roots([1, -0.1, 1])), abs=1e-12)
    assert not fl.eigenvalues(model).stable
    found = fl.steady_state(model, [0.1, 0.0], transient=300.0, window=100.0, progress=False)
    assert found.kind == "periodic"
    assert found.period == pytest.approx(2 * np.pi * (1 + 0.1**2 / 16), rel=1e-5)
    assert r"\mu" in model.equations("only").latex()
    fl.plot_run(fl.simulate(model, 30.0, progress=False)).canvas.draw()
    explorer = fl.explore(model)
    assert explorer.error is None
    explorer.close()


def test_what_is_missing_is_said():
    with pytest.raises(NotImplementedError, match="Nothing must define mechanics"):
        Nothing().automaton()
