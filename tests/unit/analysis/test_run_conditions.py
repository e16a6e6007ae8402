"""Runs that break the conditions of their modes are told, whatever other runs say; sound ones are not."""

import numpy as np
import pytest
import sympy as sp

import frictionlab as fl
from frictionlab import Event, HybridAutomaton, Mode, Reset
from frictionlab.analysis.run_comparison import mode_stays
from frictionlab.analysis.run_conditions import broken_condition, judged_size, steps_to_stops, unjudged_steps
from frictionlab.hybrid.guard_bounds import Tape
from frictionlab.hybrid.problem import Problem
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.tape.packing import program_of
from tests.helpers.automata import ONCE, V, X, automaton, ball

PEAK = 1 - X - sp.Rational(9, 10) * sp.exp(-((1000 * (X - sp.Rational(2, 5))) ** 2))


def walk(guard):
    """x = t/5 up to where a guard is zero."""
    end = Mode("end", (sp.S.Zero,))
    return HybridAutomaton((X,), (Mode("go", (sp.Rational(1, 5),), (Event("peak", guard, ("end",)),)), end))


def ground(guard):
    """A ball that falls with 2 m/s^2, reflected where a guard is zero."""
    return automaton(Mode("flight", (V, sp.Integer(-2)), (Event("hit", guard, ("flight",), Reset({V: -V})),)))


def as_run_of(law, run):
    """A run, as if it were one of another automaton with the same modes and guards."""
    problem = Problem(*program_of(law), run.problem.x0, run.problem.t_end)
    return Trajectory(law, problem, run.raw, run.samples, description=run.description)


@ONCE
@pytest.mark.parametrize(
    ("law", "blind", "start", "first"),
    [
        (walk(PEAK), walk(1 - X), [0.0], 1.997),  # a peak 1/200 s wide in 5 s
        (ground(X), ground(X + 0.1), [1.0, 0.0], 1.0),  # below the ground before it hits
        (ground(X - sp.cos(40 * X) / 50), ground(X), [1.0, 0.0], 0.98),
    ],
    ids=["peak", "late", "corrugated"],
)
def test_events_that_a_run_lacks(law, blind, start, first):
    run = fl.solve(blind, 6.0, x0=start, progress=False)
    assert broken_condition(run) == ""
    said = broken_condition(as_run_of(law, run))
    assert "is missed" in said
    assert float(said.split("t = ")[1].split(" s")[0]) == pytest.approx(first, abs=0.03)


@ONCE
def test_a_velocity_that_a_reset_takes_away():
    """A turning crank has v_r = cos(x) x' = 0 at its dead centre, where it must not stop."""
    stop = Event("v_r", sp.cos(X) * V, ("stick",), Reset({V: sp.S.Zero}))
    crank = automaton(
        Mode("stick", (V, sp.S.Zero), (), (sp.cos(X) * V,)), Mode("slip+", (V, sp.S.Zero), (stop,))
    )
    said = broken_condition(fl.solve(crank, 5.0, x0=[0.0, 1.0], progress=False))
    assert "at t = 1.5708 s the reset of event 'v_r' takes away 1 of the velocities" in said


@ONCE
def test_a_long_run_is_judged_by_its_motion():
    """Rounding errors of the rates over 1e4 periods, summed twice, come to 7e-6 of the motion."""
    stop, blind = (
        automaton(Mode("swing", (V, -X), (Event("hit", X + reach, ("swing",), Reset({V: -V})),)))
        for reach in (1 - 1e-6, 2.0)
    )
    run = fl.solve(blind, 6e4, x0=[1.0, 0.0], method=fl.Taylor(tol=1e-13), progress=False)
    assert broken_condition(run) == ""
    assert "beyond zero, in the worst case by 5e-07 of its size" in broken_condition(as_run_of(stop, run))


@ONCE
@pytest.mark.parametrize("tol", [1e-15, 1e-6])
def test_sound_runs_break_none(tol):
    method = fl.Taylor(tol=tol)
    assert broken_condition(fl.solve(ball(), 3.0, x0=[1.0, 0.0], method=method, progress=False)) == ""
    # Balls at rest touch up to rounding, and no step begins where they are apart.
    assert broken_condition(fl.simulate(fl.NewtonsCradle(), 3.0, method=method, progress=False)) == ""
    for model in (fl.MassOnBelt(), fl.ImpactOscillator(), fl.TwoBlocks(), fl.DenHartog()):
        assert broken_condition(fl.simulate(model, 8.0, method=method, progress=False)) == ""


@ONCE
def test_an_event_that_is_called_stop_is_judged_as_any_other():
    """Only friction in the plane comes to a norm's zero, over a step of constant accelerations."""
    law = HybridAutomaton(
        (X,), (Mode("go", (sp.S.One,), (Event("stop", 1 - X, ("end",)),)), Mode("end", (sp.S.Zero,)))
    )
    run = fl.solve(law, 6.0, x0=[0.0], progress=False)
    assert len(run.events) == 1
    assert not len(steps_to_stops(run))
    assert unjudged_steps(run) == ""


@ONCE
def test_rounding_of_rates_adds_up_over_a_short_part_of_a_run():
    """A force that is rounding alone acts for 0.3 s of 10 s."""
    t = sp.Symbol("t")
    after = Mode("after", (V, sp.S.Zero, sp.S.One))
    rounding = sp.sin(t) ** 2 + sp.cos(t) ** 2 - 1
    acting = Mode("acting", (V, rounding, sp.S.One), (Event("end", sp.Rational(3, 10) - t, ("after",)),))
    run = fl.solve(automaton(acting, after, states=(X, V, t)), 10.0, x0=[0.0] * 3, progress=False)
    assert judged_size(run)[1] > 1e-6


@ONCE
def test_modes_whose_rates_are_not_finite_keep_their_names(monkeypatch):
    go = Mode("a", (sp.S.One, sp.S.Zero), (Event("turn", 2 - X, ("b",)),), (V,))
    back = Mode("b", (sp.S.NegativeOne, sp.S.Zero), (), (V,))
    run = fl.solve(automaton(go, back, coordinates=0), 4.0, x0=[0.0, 0.0], mode="a", progress=False)
    monkeypatch.setattr(Tape, "values", lambda tape, states, some: np.full((len(states), len(some)), np.nan))
    assert mode_stays(run, 0.0, judged_size(run)).mode.tolist() == ["b"]
