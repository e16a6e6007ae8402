"""The paper's algorithm, scipy's methods, files, ctrl-C, and what is said about bad settings."""

import signal
import threading

import numpy as np
import pytest
import sympy as sp

import frictionlab as fl
from frictionlab.compilation.machine_code import cache_folder
from tests.helpers.assertions import assert_same_times
from tests.helpers.cases import slow_but

X, V = sp.symbols("x v")
FULL = fl.PlasticImpact("full")
A = fl.SliderOnBelt(mu_k=1.4).without("geometry")
B = fl.SliderOnBelt(mu_k=1.4, impact=FULL)
NAMES = ("RK23", "RK45", "DOP853", "Radau", "BDF", "LSODA")


def ball():
    bounce = fl.Reset({X: sp.S.Zero, V: -V / 2})
    flight = fl.Mode("flight", (V, sp.Integer(-10)), (fl.Event("floor", X, (), bounce),), (), {"height": X})
    return fl.HybridAutomaton((X, V), (flight,), {}, 1)


# --- RK4


def test_rk4_converges_with_order_four_where_the_motion_is_smooth():
    smooth = fl.SliderOnBelt(mu_k=1.4).without("nonsmooth")
    exact = fl.simulate(smooth, 0.5).final_state
    steps = np.array([1e-3, 5e-4, 2.5e-4])
    errors = [
        np.abs(fl.simulate(smooth, 0.5, method=fl.RK4(step=h)).final_state - exact).max() for h in steps
    ]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert orders == pytest.approx(4.0, abs=0.2)


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


@pytest.mark.parametrize("name", slow_but({*NAMES} - {"RK23", "BDF", "Radau"}, NAMES))
def test_scipys_methods_run_by_name(name):
    exact = fl.simulate(A, 0.15)
    run = fl.simulate(A, 0.15, method=name)
    assert run.status is fl.Status.FINISHED
    assert run.t[-1] == 0.15
    assert run.events.target.tolist() == exact.events.target.tolist()
    assert_same_times(run.events.t, exact.events.t, abs=1e-6)
    assert run.final_state == pytest.approx(exact.final_state, abs=1e-5)


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


# --- files


def assert_same(one, other):
    assert other.t.tolist() == one.t.tolist()
    assert other.states.tolist() == one.states.tolist()
    assert other.mode.tolist() == one.mode.tolist()
    for field in ("t", "source", "target", "guard", "closed", "state", "before"):
        assert getattr(other.events, field).tolist() == getattr(one.events, field).tolist()
    assert other.final_state.tolist() == one.final_state.tolist()
    assert other.status is one.status
    assert dict(other.stats) == dict(one.stats)
    assert dict(other.quadratures) == dict(one.quadratures)
    assert other.time_in_mode == one.time_in_mode
    assert other.description == one.description
    for name, points in one.sections.items():
        assert other.sections[name].t.tolist() == points.t.tolist()
        assert other.sections[name].state.tolist() == points.state.tolist()


@pytest.mark.parametrize("t_eval", [None, np.linspace(0, 0.3, 11)], ids=["steps", "t_eval"])
def test_a_model_run_comes_back_from_its_file(tmp_path, t_eval):
    sections, quadratures = {"v_r": "relative_velocity", "gap": ("penetration", 1)}, {"force": "normal_force"}
    run = fl.simulate(B, 0.3, t_eval=t_eval, sections=sections, quadratures=quadratures)
    assert len(run.sections["v_r"].t) > 0
    path = run.save(tmp_path / "run")
    assert path == tmp_path / "run.npz"
    again = fl.load(path)
    assert_same(run, again)
    assert again.source == B
    assert again.penetration.tolist() == run.penetration.tolist()
    assert again(0.123).tolist() == run(0.123).tolist()


def test_an_automatons_run_is_loaded_with_it_or_without(tmp_path):
    run = fl.solve(ball(), 1.0, x0=[1.0, 0.0])
    path = run.save(tmp_path / "ball.npz")
    assert_same(run, fl.load(path, model=ball()))
    assert fl.load(path, model=ball()).height.tolist() == run.height.tolist()
    assert_same(run, fl.load(path))
    with pytest.raises(ValueError, match="the model"):
        fl.load(path, model=B)


def test_arrays_of_someone_else_are_no_run(tmp_path):
    np.savez(tmp_path / "other.npz", a=np.arange(3))
    np.save(tmp_path / "single.npy", np.arange(3))
    for name in ("other.npz", "single.npy"):
        with pytest.raises(ValueError, match="no saved run"):
            fl.load(tmp_path / name)
    with pytest.raises(FileNotFoundError):
        fl.load(tmp_path / "missing.npz")


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


# --- compiled code


class Numba:
    __version__ = "0"


@pytest.mark.plain_python
def test_compiled_code_goes_where_the_user_says(tmp_path, monkeypatch):
    monkeypatch.setenv("FRICTIONLAB_CACHE_DIR", str(tmp_path / "here"))
    assert cache_folder(Numba).startswith(str(tmp_path / "here"))


@pytest.mark.plain_python
def test_a_cache_folder_that_cannot_be_made_is_replaced(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("not a folder")
    monkeypatch.setenv("FRICTIONLAB_CACHE_DIR", str(tmp_path / "file" / "below"))
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    assert cache_folder(Numba).startswith(str(tmp_path / "frictionlab-"))
    monkeypatch.setattr("tempfile.gettempdir", lambda: str(tmp_path / "file"))
    assert cache_folder(Numba) == ""
