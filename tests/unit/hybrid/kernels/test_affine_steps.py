"""Scenes whose rates are affine: one map for all steps, against the matrix exponential with 40 digits."""

import mpmath as mp
import numpy as np
import pytest
import sympy as sp

import frictionlab as fl
from frictionlab.hybrid.methods.taylor import is_affine
from frictionlab.tape.packing import program_of
from tests.helpers.cases import slow_but

LINEAR = fl.SliderOnBelt(mu_k=0.2).without("cubic", "nonsmooth", "geometry")


def exact(automaton, times, x0):
    """States at some times."""
    states = list(automaton.states)
    rates = sp.Matrix(automaton.modes[0].flow).subs(
        {p: sp.nsimplify(v) for p, v in automaton.parameters.items()}
    )
    A, b = rates.jacobian(states), rates.subs(dict.fromkeys(states, 0))
    with mp.workdps(40):
        whole = mp.zeros(len(states) + 1)
        for i, row in enumerate(A.row_join(b).tolist()):
            for j, entry in enumerate(row):
                whole[i, j] = mp.mpf(entry.p) / entry.q
        start = mp.matrix([*map(mp.mpf, map(float, x0)), 1])
        return np.array([[float(x) for x in (mp.expm(mp.mpf(float(t)) * whole) * start)[:-1]] for t in times])


@pytest.mark.plain_python
@pytest.mark.parametrize("start", slow_but(["moving"], ["rest", "moving"]))
def test_states_and_what_lies_between(start):
    x0 = np.zeros(8) if start == "rest" else np.linspace(-0.02, 0.03, 8)
    times = np.sort(np.random.default_rng(1).uniform(0, 2.0, 6))
    run = fl.simulate(LINEAR, 2.0, x0=x0, t_eval=times, progress=False)
    states = np.hstack([run.q, run.v])
    expected = exact(LINEAR.automaton(), times, x0)
    assert np.abs(states - expected).max() < 5e-14 * np.abs(expected).max()


def test_long_runs_keep_their_digits():
    undamped = LINEAR.replace(**dict.fromkeys(("c1", "c2", "c4", "c5", "c6"), 0.0))
    run = fl.simulate(undamped, 1000.0, progress=False)
    expected = exact(undamped.automaton(), [1000], np.zeros(8))[0]
    assert np.abs(run.final_state - expected).max() < 2e-11 * np.abs(expected).max()
    assert run.t[-1] == 1000.0


def test_runs_in_turns_have_maps_of_their_own():
    """The map of a run is kept for the next one with the same numbers and tolerance, and for no other."""
    stiff, start = LINEAR.replace(k1=2.0 * LINEAR.k1), np.linspace(-0.02, 0.03, 8)
    for model, tol, x0 in (
        (LINEAR, 1e-15, np.zeros(8)),
        (stiff, 1e-15, np.zeros(8)),
        (LINEAR, 1e-15, start),
        (LINEAR, 1e-4, start),
        (LINEAR, 1e-15, start),
    ):
        run = fl.simulate(model, 0.7, x0=x0, method=fl.Taylor(tol=tol), progress=False)
        expected = exact(model.automaton(), [0.7], x0)[0]
        assert np.abs(run.final_state - expected).max() < max(50 * tol, 5e-14) * np.abs(expected).max()


def test_steps_do_not_depend_on_the_end_of_the_run():
    """Though steps are taken by blocks, of which the end cuts the last one."""
    short, long = (fl.simulate(LINEAR, t_end, progress=False).raw.step_states for t_end in (0.33, 0.5))
    np.testing.assert_array_equal(short, long[: len(short)])


def test_a_looser_tolerance_means_fewer_steps_which_are_as_exact_as_it_says():
    x, v = sp.symbols("x v")
    swing = fl.HybridAutomaton((x, v), (fl.Mode("on", (v, -x)),), coordinates=1)
    times, steps = np.linspace(0.0, 100.0, 501), []
    for tol in (1e-15, 1e-9, 1e-6, 1e-3):
        run = fl.solve(swing, 100.0, x0=[1.0, 0.0], method=fl.Taylor(tol=tol), t_eval=times, progress=False)
        assert np.abs(run["x"] - np.cos(times)).max() < 200 * max(tol, 1e-14)
        steps.append(run.stats["steps"])
    assert steps == sorted(set(steps), reverse=True)


@pytest.mark.parametrize("count", [1, 3, 17])  # the maps of several steps are for few states
def test_oscillators_side_by_side(count):
    x, v = sp.symbols(f"x:{count}"), sp.symbols(f"v:{count}")
    rates = (*v, *(-((i + 1) ** 2) * x[i] for i in range(count)))
    automaton = fl.HybridAutomaton((*x, *v), (fl.Mode("on", rates),), coordinates=count)
    run = fl.solve(automaton, 20.0, x0=[1.0] * count + [0.0] * count, progress=False)
    assert is_affine(run.problem.program)
    w = np.arange(1, count + 1)
    expected = np.concatenate([np.cos(20 * w), -w * np.sin(20 * w)])
    assert run.final_state == pytest.approx(expected, abs=2e-12 * count)


def test_runs_shorter_than_a_step_and_ends_between_steps():
    for t_end in (1e-4, 0.01234):
        run = fl.simulate(LINEAR, t_end, progress=False)
        expected = exact(LINEAR.automaton(), [t_end], np.zeros(8))[0]
        assert run.t[-1] == t_end
        assert run.final_state == pytest.approx(expected, rel=1e-12, abs=1e-17)


def test_an_unbounded_motion_ends_with_its_status_and_finite_states():
    run = fl.simulate(LINEAR.replace(mu_k=3.0), 1e4, progress=False, method=fl.Taylor(max_steps=10**6))
    assert run.status is fl.Status.NOT_FINITE
    assert np.isfinite(run.final_state).all()
    assert np.abs(run.final_state).max() > 1e200


def test_what_counts_as_affine():
    """Neither nonlinear rates, nor events, nor what is recorded along the way."""
    automaton = LINEAR.automaton()
    assert is_affine(program_of(automaton)[0])
    assert not is_affine(program_of(fl.SliderOnBelt().without("nonsmooth").automaton())[0])
    assert not is_affine(program_of(fl.SliderOnBelt().without("cubic", "geometry").automaton())[0])
    x, y = automaton.states[:2]
    assert not is_affine(program_of(automaton, None, {"work": x * y})[0])
    run = fl.simulate(
        LINEAR, 1.0, sections={"turns": "penetration"}, quadratures={"work": x * y}, progress=False
    )
    assert run.final_state == pytest.approx(fl.simulate(LINEAR, 1.0, progress=False).final_state, rel=1e-11)
