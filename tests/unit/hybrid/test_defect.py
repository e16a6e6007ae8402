"""The defect of a run: against closed forms, against the tolerance, and of other methods."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
import sympy as sp

import frictionlab as fl
from frictionlab.compilation.machine_code import HAS_MACHINE_CODE
from frictionlab.hybrid.accuracy import CHECK_POINTS, has_residual_above, stored_steps
from frictionlab.hybrid.codegen import native_cache
from frictionlab.tape.packing import program_of
from tests.helpers.automata import ONCE, V, X, automaton, ball, oscillator

POINT = 0.5 * (1 + math.cos(0.5 * math.pi / CHECK_POINTS))  # the last, as a share of the step


def defect(run):
    return max(run.defect.values())


@ONCE
@pytest.mark.parametrize("order", [4, 5, 8, 11])
def test_that_of_a_cut_series_is_its_last_term(order):
    """One step of x'' = -x from x = 1, v = 0, in polynomials of degree p.

    Where p is even, x' lacks nothing, and v' lacks the term of -x in s^p/p!; where it is odd, v' lacks
    nothing, and x' lacks the last term of v.  The polynomials' sizes are cos and sin but for less than that.
    """
    t = 0.5
    run = fl.solve(oscillator(), t, x0=[1.0, 0.0], method=fl.Taylor(tol=0.09, order=order))
    assert len(run.raw.step_modes) == 1
    size = math.sin(t) if order % 2 == 0 else 1.0  # of the velocities; of the coordinate
    expected = t * (POINT * t) ** order / math.factorial(order) / size
    assert defect(run) == pytest.approx(expected, rel=2e-2)


@ONCE
def test_a_mode_that_is_no_step_long_has_none():
    run = fl.solve(ball(), 1.0, x0=[1.0, 0.0])
    assert set(run.defect) == {"flight"}
    assert run.defect["flight"] == 0.0  # of a parabola: exact but for rounding, which does not count
    with pytest.raises(TypeError):
        run.defect["flight"] = 1.0  # pyright: ignore[reportIndexIssue]  # what is tested


@pytest.mark.parametrize("tol", [1e-3, 1e-6, 1e-10])
def test_a_loose_run_has_a_defect_near_its_tolerance(tol):
    """The last term that is kept is below `tol`; the first that is not, times its order, is the residual."""
    run = fl.simulate(fl.SliderOnBelt(mu_k=1.4), 2.0, method=fl.Taylor(tol=tol), progress=False)
    assert 0.01 * tol < defect(run) < 10 * tol


@ONCE
@pytest.mark.parametrize("squared", [0, sp.Rational(1, 1000)])  # steps by a matrix, and by series
def test_rounding_is_no_defect(squared):
    """At rest under forces that balance, the velocities are rounding alone, and so are their residuals."""
    law = automaton(fl.Mode("on", (V, 1000 - X - V - squared * V**2)))
    run = fl.solve(law, 100.0, x0=[999.0, 0.0])
    assert np.abs(run.final_state[1]) < 1e-11
    assert defect(run) < 1e-13


def test_that_of_rk4_is_its_error_in_a_step():
    """From x = 1, v = 0 a step is the series up to h^4: it misses h^5/120 in v, of the size h.

    Where v passes zero within a step, that size is h/2 at least.  All other steps have larger ones.
    """
    for h in (0.1, 0.05, 0.025):
        run = fl.solve(oscillator(), 20.0, x0=[1.0, 0.0], method=fl.RK4(step=h))
        assert h**4 / 120 * (1 - h) < defect(run) < h**4 / 60 * (1 + h)


def test_of_scipy_it_goes_with_its_tolerance():
    """RK45 keeps the error of its order 4 below the tolerance, and goes on with order 5."""
    tolerances = (1e-4, 1e-7, 1e-10)
    methods = [fl.Scipy("RK45", tol, 1e-3 * tol) for tol in tolerances]
    found = [defect(fl.solve(oscillator(), 20.0, x0=[1.0, 0.0], method=method)) for method in methods]
    assert (np.array(found) < tolerances).all()
    assert (np.diff(np.log10(found)) < -2).all()


def test_ends_of_steps_are_those_before_the_reset():
    run = fl.solve(ball(), 1.0, x0=[1.0, 0.0])
    ends = stored_steps(run.raw).ends
    hit = np.isin(np.append(run.raw.step_times[1:, 0], run.raw.t), run.events.t)
    assert hit.any()
    assert (ends[hit, 1] < 0.0).all()  # still falling
    assert ends[hit, 0] == pytest.approx(0.0, abs=1e-15)


@pytest.mark.slow  # test_jet_codegen compares the jets themselves
@pytest.mark.skipif(not HAS_MACHINE_CODE, reason="needs numba")
@pytest.mark.parametrize("contact", [fl.CubicContact(), fl.HertzContact()])
def test_native_and_interpreted_jets_give_the_same(contact):
    model = fl.SliderOnBelt(mu_k=1.4, contact=contact)
    method = fl.Taylor(tol=1e-8)
    program = program_of(model.automaton())[0]
    native = native_cache.native_code(program)
    native.forget()
    run = fl.simulate(model, 0.5, method=method, progress=False)
    interpreted = dict(run.defect)
    for mode in range(len(native.code.native)):
        native.compile(mode)
    again = fl.simulate(model, 0.5, method=method, progress=False)
    assert dict(again.defect) == interpreted
    assert max(interpreted.values()) > 1e-10


def test_it_outlasts_a_file(tmp_path):
    run = fl.simulate(fl.SliderOnBelt(mu_k=1.4), 1.0, method=fl.Taylor(tol=1e-6))
    assert dict(fl.load(run.save(tmp_path / "run")).defect) == dict(run.defect)


def test_a_power_that_starts_at_zero():
    """x'' = x^1.5-like laws at their zero: steps are short there, and of shorter series; still exact."""
    law = automaton(fl.Mode("on", (V, 1 - X ** sp.Rational(3, 2))))
    run = fl.solve(law, 1.0, x0=[0.0, 0.0])
    assert 0.0 <= defect(run) < 1e-13


@pytest.mark.parametrize(("slope", "seen"), [(1.0, False), (3.0, True), (math.inf, True), (math.nan, True)])
def test_a_residual_is_seen_that_is_infinite_beside_an_infinite_state(slope, seen):
    """No share of an infinite size, and no number, is below a bound."""
    size = 4.0 if slope < 10.0 else math.inf
    code = SimpleNamespace(groups=np.array([0, 1, 1, 1]), flow=np.array([[0]]))
    scratch = SimpleNamespace(jets=np.array([[0.0, slope]]), values=np.zeros((1, 1)), sizes=np.array([size]))
    kernel = getattr(has_residual_above, "py_func", has_residual_above)
    assert kernel(code, 1, 0, 0.5, 0.5, scratch) == seen
