"""The paper's algorithm, the starts of implicit methods, what methods say of themselves, ctrl-C."""

import signal
import threading

import numpy as np
import pytest
import sympy as sp

import frictionlab as fl
from tests.helpers.assertions import assert_same_times

X, V = sp.symbols("x v")
FULL = fl.PlasticImpact("full")
A = fl.SliderOnBelt(mu_k=1.4).without("geometry")
B = fl.SliderOnBelt(mu_k=1.4, impact=FULL)


# --- RK4


def test_rk4_approaches_the_exact_motion_with_events():
    exact = fl.simulate(A, 1.0)
    errors = []
    for step in (2e-4, 1e-4, 5e-5):
        run = fl.simulate(A, 1.0, method=fl.RK4(step=step))
        assert run.events.target.tolist() == exact.events.target.tolist()
        errors.append(np.abs(run.events.t - exact.events.t).max())
    assert errors[0] > errors[1] > errors[2]
    assert errors[2] < 1e-6


def test_rk4_bisects_inside_the_step_in_which_a_condition_fails():
    run = fl.simulate(B, 0.3, method=fl.RK4(step=2e-4))
    starts, lengths = run.raw.step_times.T
    assert lengths.max() <= 2e-4 * (1 + 1e-12)
    ends = starts + lengths
    assert np.isin(run.events.t, ends).all()
    # the guard has just failed there: within the last bisection, so by no more than rounding
    exact = fl.simulate(B, 0.3)
    assert_same_times(run.events.t[:10], exact.events.t[:10], abs=1e-6)


def test_rk4_sees_conditions_only_at_the_ends_of_steps():
    """A dip below zero that begins and ends within a step is not seen; Taylor sees it."""
    dip = (X - sp.Rational(52, 100)) * (X - sp.Rational(53, 100))
    clock = fl.Mode("on", (sp.S.One,), (fl.Event("dip", dip, ("off",)),))
    automaton = fl.HybridAutomaton((X,), (clock, fl.Mode("off", (sp.S.Zero,))))
    assert len(fl.solve(automaton, 1.0, x0=[0.0], method=fl.RK4(step=0.1)).events) == 0
    assert fl.solve(automaton, 1.0, x0=[0.0]).events.t == pytest.approx([0.52], abs=1e-12)


def test_rk4_enters_slip_after_a_re_contact():
    run = fl.simulate(fl.SliderOnBelt(mu_k=1.4), 2.0, method="rk4")
    landed = run.events.target[run.events.source == "separation"]
    assert landed.size
    assert set(landed) <= {"slip+", "slip-"}
    taylor = fl.simulate(fl.SliderOnBelt(mu_k=1.4), 2.0)
    assert "separation" in set(taylor.events.target[taylor.events.source == "separation"])


@pytest.mark.plain_python
def test_rk4_of_the_oscillator_takes_the_steps_it_was_told():
    oscillator = fl.HybridAutomaton((X, V), (fl.Mode("only", (V, -X)),), {}, 1)
    run = fl.solve(oscillator, 1.05, x0=[1.0, 0.0], method=fl.RK4(step=0.1))
    assert run.stats["steps"] == 11
    assert run.t[-1] == 1.05
    # one step is the Taylor polynomial of order four
    h = 0.1
    assert run(0.1) == pytest.approx([1 - h**2 / 2 + h**4 / 24, -h + h**3 / 6], abs=1e-16)


# --- scipy


@pytest.mark.parametrize("name", ["Radau", "BDF", "LSODA"])
def test_implicit_methods_start_from_rest_in_steps_of_the_motions_own_size(name):
    # where all is zero, finite differences for a Jacobian are noise, and the steps shrink to 1e-19 s
    run = fl.simulate(A, 0.01, method=name)
    assert run.status is fl.Status.FINISHED
    assert run.stats["steps"] < 600


# --- settings


@pytest.mark.plain_python
def test_methods_describe_themselves():
    about = fl.Taylor(tol=1e-10).describe()
    assert (about["name"], about["tol"], about["order"], about["accumulation"]) == (
        "taylor",
        1e-10,
        None,
        "close",
    )
    assert set(about) == {
        "name",
        "tol",
        "order",
        "chatter",
        "accumulation",
        "max_steps",
        "max_events",
    }
    assert fl.RK4().describe()["step"] == 2e-4
    assert fl.Scipy("Radau").describe()["integrator"] == "Radau"


@pytest.mark.parametrize(
    "model", [A, A.without("cubic"), A.without("nonsmooth"), A.without(*A.nonlinearities)]
)
def test_a_degree_of_ones_own_is_the_least_order(model):
    class Higher(fl.Taylor):
        degree = 33

    run = fl.simulate(model, 0.01, method=Higher())
    assert run.samples.order == 33
    assert Higher(order=12).order_of(run.problem.program) == 33


# --- ctrl-C


@pytest.mark.parametrize("method", ["taylor", "rk4", "DOP853"])
def test_ctrl_c_ends_a_run_and_keeps_it(method):
    previous = signal.getsignal(signal.SIGINT)
    fl.simulate(A, 0.01, method=method)
    timer = threading.Timer(0.3, lambda: signal.raise_signal(signal.SIGINT))
    timer.start()
    with pytest.raises(
        KeyboardInterrupt, match=r"stopped at .* of 1e\+06 s by ctrl-C; frictionlab.partial_result"
    ):
        fl.simulate(A, 1e6, method=method, progress=False)
    timer.join()
    run = fl.partial_result()
    assert run.status is fl.Status.INTERRUPTED
    assert 0 < run.raw.t < 1e6
    assert run.stats["steps"] > 0
    assert np.isfinite(run.final_state).all()
    assert signal.getsignal(signal.SIGINT) is previous


def test_runs_in_other_threads_leave_signals_alone():
    runs = []
    threads = [threading.Thread(target=lambda: runs.append(fl.simulate(A, 1.0))) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len({run.final_state.tobytes() for run in runs}) == 1
