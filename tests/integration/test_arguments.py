"""What functions take: initial states by name, sections and methods as text, arrays of no dimension."""

import inspect
from dataclasses import fields
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

import frictionlab as fl
from frictionlab.analysis.options import Execution, ExecutionKeywords, SteadyStateKeywords
from frictionlab.pages.export import SolverNotBuiltError
from tests.helpers.assertions import assert_all

QUIET = {"progress": False}
BELT = fl.MassOnBelt(c=0.05, mu_k=0.5, mu_s=1.0)
BALL = fl.BouncingBall()
FORCED = fl.DenHartog()
SHORT = {"transient": 2.0, "window": 2.0}
NUMBER = np.array(0.5)
TIMES = np.linspace(0.1, 1.0, 10)
RECORD = fl.TimeRecord(TIMES, {"x": 0.2 + 0.1 * np.cos(TIMES)}, error=0.01)


def test_states_that_are_left_out_are_as_at_rest():
    assert_all(fl.simulate(BELT, 0.1, x0={"x": 0.1}, **QUIET)(0.0) == [0.1, 0.0])
    assert_all(fl.simulate(BALL, 0.1, x0={"y'": 0.5}, **QUIET)(0.0) == [1.0, 0.5])  # released at 1 m
    assert_all(fl.simulate(FORCED, 0.1, x0={"x": 0.1, "phase": 1.0}, **QUIET)(0.0) == [0.1, 0.0, 1.0])
    assert_all(fl.simulate(BELT, 0.1, x0={}, **QUIET)(0.0) == [0.0, 0.0])


def test_of_an_automaton_they_are_zero():
    automaton = BALL.automaton()
    assert_all(fl.solve(automaton, 0.1, x0={"y": 2.0}, **QUIET)(0.0) == [2.0, 0.0])


def test_a_state_with_labels_is_read_by_them():
    """By place a Series with x' first had its velocity for the place."""
    pandas = pytest.importorskip("pandas")
    start = pandas.Series({"x'": 2.0, "x": 1.0})
    assert_all(fl.simulate(BELT, 0.1, x0=start, **QUIET)(0.0) == [1.0, 2.0])
    assert_all(fl.solve(BELT.automaton(), 0.1, x0=start, **QUIET)(0.0) == [1.0, 2.0])
    with pytest.raises(ValueError, match="x0 has no state 'y'"):
        fl.simulate(BELT, 0.1, x0=pandas.Series({"y": 2.0}))


ANALYSES = {
    "simulate": lambda x0: fl.simulate(BELT, 1.0, x0=x0, **QUIET).states,
    "solve": lambda x0: fl.solve(BELT.automaton(), 1.0, x0=x0, **QUIET).states,
    "steady_state": lambda x0: fl.steady_state(BELT, x0, **SHORT, **QUIET).trajectory.states,
    "bifurcation": lambda x0: fl.bifurcation(BELT, "v", [0.3], x0, **SHORT, **QUIET).sections[0],
    "cea_against_motion": lambda x0: (
        fl.cea_against_motion(BELT, "v", [0.3], x0, **SHORT, t_max=None, **QUIET).amplitudes
    ),
    "ensemble": lambda x0: fl.ensemble([BELT, BELT], 1.0, x0=x0, **QUIET).states,
    "lyapunov": lambda x0: fl.lyapunov(BELT, x0, transient=1.0, t_end=1.0, blocks=2, **QUIET).final_state,
    "verify": lambda x0: fl.verify(BELT, 1.0, x0=x0, **QUIET).run.states,
    "basins": lambda x0: (
        fl.basins(
            BELT, ("x", [0.0, 0.1]), ("x'", [0.0, 0.1]), x0, transient=20.0, window=20.0, **QUIET
        ).labels
    ),
    "basin_stability": lambda x0: (
        fl.basin_stability(BELT, {"x": (0.0, 0.2)}, 3, x0=x0, transient=20.0, window=20.0, **QUIET).labels
    ),
    "fit": lambda x0: np.array([fl.fit(BELT, RECORD, ["k"], x0=x0, segments=1)["k"]]),
    "periodic_orbit": lambda x0: fl.periodic_orbit(BELT, x0).state,
    "sweep": lambda x0: np.array(
        list(fl.sweep(BELT, final_state, {"v": [0.3]}, x0=[x0], **QUIET).results.ravel())
    ),
    "ablation": lambda x0: np.array(
        [found.results[0] for found in fl.ablation(BELT, final_state, x0=[x0], **QUIET).results]
    ),
    "explore": lambda x0: fl.explore(BELT, ["response"], x0=x0, t_end=1.0).run.states,
    "explore_bifurcation": lambda x0: fl.explore_bifurcation(BELT, x0=x0).run.states,
    "export_page": lambda x0: page_text(x0),
}


def page_text(x0):
    with TemporaryDirectory() as folder:
        try:
            return fl.export_page(BELT, Path(folder) / "page.html", x0=x0).read_text(encoding="utf-8")
        except SolverNotBuiltError as error:
            pytest.skip(str(error))


def final_state(model, x0):
    return fl.simulate(model, 1.0, x0=x0, **QUIET).final_state


@pytest.mark.parametrize("name", ANALYSES)
def test_every_analysis_takes_states_by_name(name):
    np.testing.assert_array_equal(ANALYSES[name]({"x'": 0.2}), ANALYSES[name]([0.0, 0.2]))


@pytest.mark.parametrize("name", ANALYSES)
def test_an_unknown_state_is_named(name):
    with pytest.raises(ValueError, match=r"has no state \"x1'\".*did you mean \"x'\"|has no state 'xx'"):
        ANALYSES[name]({"x1'": 0.2})


def test_every_function_with_an_initial_state_is_tried():
    functions = {name: getattr(fl, name) for name in fl.__all__ if inspect.isfunction(getattr(fl, name))}
    taking = {name for name, each in functions.items() if "x0" in inspect.signature(each).parameters}
    assert taking <= set(ANALYSES)


def test_a_state_that_is_no_number_is_refused():
    with pytest.raises(ValueError, match="x0"):
        fl.simulate(BELT, 1.0, x0={"x": "far"}, **QUIET)
    with pytest.raises(ValueError, match="x0"):
        fl.simulate(BELT, 1.0, x0={"x": np.nan}, **QUIET)


def test_sections_are_expressions_in_text():
    x, rate = BELT.automaton().states
    given = {"turns": (rate, -1), "passes": x - 0.5}
    written = {"turns": ("x'", -1), "passes": "x - 0.5"}
    first, second = (fl.simulate(BELT, 20.0, sections=sections, **QUIET) for sections in (given, written))
    for name in given:
        assert len(first.sections[name].t) > 0
        assert_all(second.sections[name].t == first.sections[name].t)
    third = fl.solve(BELT.automaton(), 20.0, x0=[0.0, 0.0], sections=written, **QUIET)
    assert_all(third.sections["turns"].t == first.sections["turns"].t)


def test_a_section_may_have_parameters_and_outputs():
    sections = {"speed": "x1' - v / 2", "force": ("friction_force", 0)}
    run = fl.simulate(fl.SliderOnBelt(mu_k=1.4), 0.3, sections=sections, **QUIET)
    assert len(run.sections["speed"].t) > 0
    assert len(run.sections["force"].t) > 0


def test_quadratures_are_expressions_in_text():
    rate = BELT.automaton().states[1]
    given = fl.simulate(BELT, 5.0, quadratures={"square": rate**2}, **QUIET).quadratures
    assert fl.simulate(BELT, 5.0, quadratures={"square": "x'**2"}, **QUIET).quadratures == given


@pytest.mark.parametrize("section", ["x'' - v", "y", "import os", "x' +", "1 + 1", ("y", 1)])
def test_a_section_that_is_no_expression_is_named(section):
    with pytest.raises(ValueError, match="section 'turns'"):
        fl.simulate(BELT, 1.0, sections={"turns": section}, **QUIET)


@pytest.mark.parametrize("method", ["rk45", "RK45", "RK4", "Taylor", "TAYLOR", "lsoda", "dop853", "Rk4"])
def test_methods_are_found_whatever_the_case_of_their_letters(method):
    run = fl.simulate(BELT, 0.1, method=method, **QUIET)
    assert (
        run.description["method"].get("integrator", run.description["method"]["name"]).lower()
        == method.lower()
    )


def test_a_method_that_there_is_not_is_answered_with_the_nearest():
    with pytest.raises(ValueError, match="did you mean 'DOP853'"):
        fl.simulate(BELT, 0.1, method="dop854", **QUIET)
    with pytest.raises(ValueError, match="did you mean 'taylor'"):
        fl.steady_state(BELT, method="tayler", **QUIET)


NUMBERS = {
    "t_end": lambda n: fl.simulate(BELT, n, **QUIET).states,
    "a parameter": lambda n: [BELT.replace(v=n).v, fl.MassOnBelt(v=n).v],
    "a parameter of a law": lambda n: fl.LinearContact(k2=n).k2,
    "tol": lambda n: fl.simulate(BELT, 1.0, method=fl.Taylor(tol=n / 1e9), **QUIET).states,
    "step": lambda n: fl.simulate(BELT, 1.0, method=fl.RK4(n / 100), **QUIET).states,
    "window": lambda n: fl.steady_state(BELT, transient=n, window=n, **QUIET).trajectory.states,
    "exponents": lambda n: fl.lyapunov(BELT, transient=n, t_end=2 * n, blocks=2, **QUIET).exponents,
    "bounds": lambda n: fl.critical_value(fl.SliderOnBelt(), "mu_k", (n, 6 * n)),
    "values": lambda n: fl.root_locus(fl.SliderOnBelt(), "mu_k", [n, 2 * n]).values,
    "panel": lambda n: [fl.plot_run(fl.simulate(BELT, 1.0, **QUIET), window=n).axes[0].get_xlim()],
}


@pytest.mark.parametrize("name", NUMBERS)
def test_an_array_of_no_dimension_is_a_number(name):
    np.testing.assert_array_equal(NUMBERS[name](NUMBER), NUMBERS[name](0.5))


def test_settings_are_plain_numbers():
    options = fl.SteadyStateOptions(transient=NUMBER, window=NUMBER)
    assert (type(options.transient), type(options.window)) == (float, float)
    assert type(fl.Taylor(tol=np.array(1e-10)).tol) is float
    assert type(fl.Taylor(order=np.array(12)).order) is int
    assert hash(fl.Taylor(tol=np.array(1e-10))) == hash(fl.Taylor(tol=1e-10))


@pytest.mark.parametrize("value", [np.array([0.5]), np.array("0.5"), np.array(True), np.array(1j), True])
def test_what_is_no_number_is_refused(value):
    with pytest.raises((ValueError, TypeError), match="t_end must be a finite number"):
        fl.simulate(BELT, value, **QUIET)
    with pytest.raises(TypeError, match="v must be one real number"):
        fl.MassOnBelt(v=value)


SLIDER = fl.SliderOnBelt()
CRITICAL = fl.CriticalValue("mu_k", (0.0, 4.0))
BY_PARAMETER = {
    "made": lambda name: fl.SliderOnBelt(**{name: 1.0}),
    "replace": lambda name: SLIDER.replace(**{name: 1.0}),
    "stability_changes": lambda name: fl.stability_changes(SLIDER, name, (0.0, 4.0)),
    "critical_value": lambda name: fl.critical_value(SLIDER, name, (0.0, 4.0)),
    "critical_curve": lambda name: fl.critical_curve(SLIDER, "mu_k", (0.0, 4.0), over=(name, [1.0, 2.0])),
    "stability_map": lambda name: fl.stability_map(SLIDER, (name, [1.0, 2.0]), ("F", [1.0, 2.0]), **QUIET),
    "hopf": lambda name: fl.hopf(SLIDER, name, (0.0, 4.0)),
    "root_locus": lambda name: fl.root_locus(SLIDER, name, [1.0, 2.0]),
    "bifurcation": lambda name: fl.bifurcation(SLIDER, name, [1.0], **SHORT, **QUIET),
    "cea_against_motion": lambda name: fl.cea_against_motion(SLIDER, name, [1.0], **QUIET),
    "sweep": lambda name: fl.sweep(SLIDER, repr, {name: [1.0]}, **QUIET),
    "ablation": lambda name: fl.ablation(SLIDER, repr, over={name: [1.0]}, **QUIET),
    "sensitivity": lambda name: fl.sensitivity(SLIDER, fl.CriticalValue(name, (0.0, 4.0))),
    "uncertainty": lambda name: fl.uncertainty(SLIDER, CRITICAL, {name: (0.0, 1.0)}, **QUIET),
    "sobol_indices": lambda name: fl.sobol_indices(SLIDER, CRITICAL, {name: (0.0, 1.0)}, **QUIET),
    "optimum": lambda name: fl.optimum(SLIDER, CRITICAL, {name: (0.0, 1.0)}),
    "fit": lambda name: fl.fit(SLIDER, fl.TimeRecord(TIMES, {"x1": TIMES}, error=0.01), [name]),
    "explore_bifurcation": lambda name: fl.explore_bifurcation(SLIDER, name),
    "explore_stability": lambda name: fl.explore_stability(SLIDER, name),
}


@pytest.mark.parametrize("name", BY_PARAMETER)
def test_a_parameter_that_there_is_not_is_the_same_error_everywhere(name):
    with pytest.raises(TypeError, match=r"^SliderOnBelt has no parameter 'muk': did you mean 'mu_k'"):
        BY_PARAMETER[name]("muk")


def test_keywords_for_editors_are_the_fields():
    for keywords, kind in (
        (SteadyStateKeywords, fl.SteadyStateOptions),
        (ExecutionKeywords, Execution),
    ):
        assert list(keywords.__annotations__) == [field.name for field in fields(kind)]


def test_a_name_of_a_method_is_resolved_once():
    assert fl.SteadyStateOptions(method="rk4").method == fl.RK4()
