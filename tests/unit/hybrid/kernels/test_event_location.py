"""Events are found where they are: together, grazing, at the end of a run."""

import numpy as np
import pytest
import sympy as sp

import frictionlab as fl
from tests.helpers.automata import ONCE, V, X, automaton, ball, clock, oscillator


@ONCE
def test_of_two_guards_in_a_step_the_first_in_time_counts():
    events = fl.Event("late", 7 - 10 * X, ("off",)), fl.Event("early", 3 - 10 * X, ("off",))
    for order in (events, events[::-1]):
        run = fl.solve(clock(*order), 1.0, x0=[0.0])
        assert run.events.guard.tolist() == ["early"]
        assert run.events.t == pytest.approx([0.3], abs=1e-15)


@ONCE
def test_two_guards_at_once_are_one_event():
    run = fl.solve(
        clock(fl.Event("a", 1 - 2 * X, ("off",)), fl.Event("b", 2 - 4 * X, ("off",))), 1.0, x0=[0.0]
    )
    assert run.events.guard.tolist() == ["a"]
    assert run.final_state == pytest.approx([0.5], abs=1e-15)


@ONCE
def test_two_zeros_of_one_guard_in_a_step_are_not_missed():
    run = fl.solve(
        clock(fl.Event("dip", (X - sp.Rational(3, 10)) * (X - sp.Rational(301, 1000)), ("off",))),
        1.0,
        x0=[0.0],
    )
    assert run.events.t == pytest.approx([0.3], abs=1e-12)


def thrown(ceiling):
    """Thrown up to height 1/4 at time 1/2, elastic ceiling."""
    c = sp.Symbol("c")
    up = fl.Mode("up", (V, sp.Integer(-2)), (fl.Event("ceiling", c - X, ("up",), fl.Reset({V: -V})),))
    return automaton(up, c=ceiling)


@ONCE
def test_a_graze_that_just_touches_passes():
    run = fl.solve(thrown(0.25), 1.0, x0=[0.0, 1.0])
    assert run.status.ok
    # Rounding decides whether the double zero is seen; at the speed zero an impact changes nothing.
    assert run.events.t.tolist() in ([], [pytest.approx(0.5, abs=1e-7)])
    assert run.final_state == pytest.approx([0.0, -1.0], abs=1e-7)


@ONCE
@pytest.mark.parametrize("exponent", range(3, 14))
def test_through_tangency_every_ceiling_is_kept(exponent):
    for sign in (1, -1):
        ceiling = 0.25 + sign * 10.0**-exponent
        run = fl.solve(thrown(ceiling), 1.0, x0=[0.0, 1.0])
        assert run.status.ok
        assert run["x"].max() <= ceiling + 1e-15
        if sign > 0:
            assert len(run.events) == 0
            assert run.final_state == pytest.approx([0.0, -1.0], abs=1e-14)
        else:
            hit = 0.5 - np.sqrt(10.0**-exponent)
            assert run.events.t == pytest.approx([hit], abs=1e-14 / np.sqrt(10.0**-exponent))
            after = 1 - hit
            fall = ceiling - (1 - 2 * hit) * after - after**2
            assert run.final_state[0] == pytest.approx(fall, abs=1e-9)


@ONCE
@pytest.mark.parametrize("amplitude", [1.0, 1 - 1e-9, 1 + 1e-9, 1 - 1e-13, 1 + 1e-13])
def test_a_graze_that_changes_mode_ends_in_one_of_two_consistent_motions(amplitude):
    """A sine against a threshold at one: beyond it another regime with the same flow."""
    below = fl.Mode("below", (V, -X), (fl.Event("up", 1 - X, ("above",)),))
    above = fl.Mode("above", (V, -X), (fl.Event("down", X - 1, ("below",)),))
    run = fl.solve(automaton(below, above), 20.0, x0=[0.0, amplitude])
    assert run.status.ok
    assert run.final_state == pytest.approx(amplitude * np.array([np.sin(20), np.cos(20)]), abs=1e-13)
    inside = run["x"] - 1
    assert inside[run.mode == "below"].max() <= 1e-15
    assert inside[run.mode == "above"].min(initial=0.0) >= -1e-15
    if amplitude > 1:
        assert run.events.target.tolist() == ["above", "below"] * 3


@ONCE
@pytest.mark.parametrize("power", [1, 2, 3, 5, 9])
def test_a_guard_that_varies_faster_than_the_states_is_resolved(power):
    """The step is chosen by the states' series; that of x^9 converges nine times slower."""
    half = sp.Rational(1, 2)
    below = fl.Mode("below", (V, -X), (fl.Event("up", half**power - X**power, ("above",)),))
    above = fl.Mode("above", (V, -X), (fl.Event("down", X**power - half**power, ("below",)),))
    run = fl.solve(automaton(below, above), 20.0, x0=[0.0, 1.0])
    assert len(run.events) == (13 if power % 2 == 0 else 7)
    assert np.abs(run.events.state[:, 0]) == pytest.approx(0.5, abs=1e-13)


@ONCE
def test_an_event_at_the_end_time_happens():
    run = fl.solve(clock(fl.Event("bell", 1 - X, ("off",))), 1.0, x0=[0.0])
    assert run.status.ok
    assert run.events.t.tolist() == [1.0]
    assert run.t[-1] == 1.0
    assert run.mode[-1] == "off"


@ONCE
def test_an_event_just_after_the_end_time_does_not():
    run = fl.solve(clock(fl.Event("bell", 1 - X, ("off",))), 1 - 1e-12, x0=[0.0])
    assert len(run.events) == 0
    assert run.mode[-1] == "on"


@ONCE
def test_a_sample_at_an_event_is_the_state_after_it():
    first = fl.solve(ball(), 3.0, x0=[1.0, 0.0])
    times = first.events.t[:5]
    run = fl.solve(ball(), 3.0, x0=[1.0, 0.0], t_eval=times)
    assert run.t.tolist() == times.tolist()
    assert run.states.tolist() == first.events.state[:5].tolist()
    assert first(times).tolist() == first.events.state[:5].tolist()
    assert (run["v"] > 0).all()


@ONCE
def test_a_call_takes_times_in_any_order_and_refuses_others():
    run = fl.solve(oscillator(), 5.0, x0=[1.0, 0.0])
    times = np.array([4.0, 0.0, 5.0, 2.5])
    assert run(times)[:, 0] == pytest.approx(np.cos(times), abs=1e-14)
    assert run(2.5) == pytest.approx([np.cos(2.5), -np.sin(2.5)], abs=1e-14)
    with pytest.raises(ValueError, match="within the run"):
        run(5.1)


@ONCE
def test_a_name_that_the_run_lacks_is_told_with_the_nearest():
    run = fl.solve(oscillator(outputs={"height": X}), 1.0, x0=[1.0, 0.0])
    assert run.output("height", [0.0]).tolist() == [1.0]
    with pytest.raises(KeyError, match=r"no output 'heigth': did you mean 'height'.*it has height"):
        run.output("heigth")
    with pytest.raises(KeyError, match=r"no output 'x': write run\['x'\]"):
        run.output("x")
    with pytest.raises(KeyError, match="has no 'heigth': did you mean 'height'"):
        run["heigth"]
