"""Several events at one instant: every run ends with a status, the same one whenever it is repeated."""

import numpy as np
import pytest
import sympy as sp

import frictionlab as fl
from tests.helpers.automata import ONCE, X, automaton, ball, clock, coulomb

A, B, VA, VB = sp.symbols("a b va vb")
DROP = np.sqrt(0.2)  # s, from a height of 1 m at 10 m/s^2


def solved(system, t_end, x0, **options):
    """A run, made twice, that ended by itself."""
    one, two = (fl.solve(system, t_end, x0=x0, progress=False, **options) for _ in range(2))
    assert one.status in (fl.Status.FINISHED, fl.Status.NO_ADMISSIBLE_MODE)
    assert one.events.t.tobytes() == two.events.t.tobytes()
    assert one.events.guard.tolist() == two.events.guard.tolist()
    assert one.final_state.tobytes() == two.final_state.tobytes()
    assert np.isfinite(one.states).all()
    return one


@ONCE
@pytest.mark.parametrize("names", ["ab", "ba", "abc", "cba"])
def test_of_identical_guards_the_first_listed_decides(names):
    """All are zero at 1/2; each leads to a mode of its own with a rate of its own."""
    rates = {"a": 1, "b": 2, "c": 3}
    on = fl.Mode("on", (sp.S.One,), tuple(fl.Event(name, 1 - 2 * X, (name,)) for name in names))
    others = (fl.Mode(name, (sp.Integer(rates[name]),)) for name in sorted(names))
    run = solved(automaton(on, *others, states=(X,), coordinates=0), 1.0, [0.0])
    assert run.status is fl.Status.FINISHED
    assert run.events.target.tolist() == [names[0]]
    assert run.final_state == pytest.approx([0.5 + rates[names[0]] / 2], abs=1e-15)


@ONCE
@pytest.mark.parametrize("end", [0.5, 1.0])
def test_two_guards_at_the_end_time_and_at_once(end):
    twice = clock(fl.Event("a", end - X, ("off",)), fl.Event("b", 2 * end - 2 * X, ("off",)))
    run = solved(twice, end, [0.0])
    assert (run.status, run.events.t.tolist(), run.mode[-1]) == (fl.Status.FINISHED, [end], "off")


@ONCE
def test_a_run_that_ends_exactly_where_an_event_was_found():
    """The event of the longer run is at the shorter one's end to the last bit, or just beyond it."""
    whole = solved(ball(), 2.0, [1.0, 0.0])
    assert len(whole.events) >= 20
    for t in whole.events.t[:20]:
        run = solved(ball(), t, [1.0, 0.0])
        assert run.status is fl.Status.FINISHED
        assert run.t[-1] == t
        assert abs(len(run.events) - (whole.events.t <= t).sum()) <= 1


def balls():
    """Two elastic balls that know nothing of each other."""
    floors = (fl.Event("a", A, (), fl.Reset({A: sp.S.Zero, VA: -VA})),)
    floors += (fl.Event("b", B, (), fl.Reset({B: sp.S.Zero, VB: -VB})),)
    down = sp.Integer(-10)
    return automaton(fl.Mode("flight", (VA, VB, down, down), floors), states=(A, B, VA, VB), coordinates=2)


@ONCE
@pytest.mark.parametrize("apart", [1e-15, 1e-13, 1e-10, 1e-6])
def test_two_balls_from_nearly_one_height_both_bounce(apart):
    run = solved(balls(), 1.5, [1.0, 1.0 + apart, 0.0, 0.0])
    assert run.status is fl.Status.FINISHED
    assert run.events.guard.tolist() == ["a", "b"] * 2
    assert run.events.t == pytest.approx([DROP, DROP, 3 * DROP, 3 * DROP], abs=max(3 * apart, 1e-14))


@ONCE
def test_two_balls_from_one_height_both_bounce():
    """After a's reset the guard of b is zero and falling: that is b's event, at the same time."""
    run = solved(balls(), 1.5, [1.0, 1.0, 0.0, 0.0])
    assert run.status is fl.Status.FINISHED
    assert run.events.guard.tolist() == ["a", "b"] * 2
    assert run.events.t == pytest.approx([DROP, DROP, 3 * DROP, 3 * DROP], abs=1e-15)
    assert run.final_state[0] == pytest.approx(run.final_state[1], abs=1e-15)


@ONCE
@pytest.mark.parametrize(
    ("rates", "bounces", "times"),
    [
        ((1.0, 1.5), "aba", [0.2, 0.3, 0.4]),
        ((-1.0, 1.5), "aaba", [0.0, 0.2, 0.3, 0.4]),
        ((-1.0, 1.0), "aabab", [0.0, 0.2, 0.2, 0.4, 0.4]),
        ((-1.0, -1.0), "ababab", [0.0, 0.0, 0.2, 0.2, 0.4, 0.4]),
    ],
    ids=["both leave", "one arrives", "then both", "both arrive"],
)
def test_two_guards_that_are_zero_at_the_start(rates, bounces, times):
    """What leaves is let go, what arrives bounces at t = 0."""
    run = solved(balls(), 0.5, [0.0, 0.0, *rates])
    assert run.status is fl.Status.FINISHED
    assert run.events.guard.tolist() == list(bounces)
    assert run.events.t == pytest.approx(times, abs=1e-15)


@ONCE
def test_what_lies_on_a_floor_that_only_bounces_ends_the_run():
    run = solved(balls(), 0.5, [0.0, 0.0, 0.0, 1.0])
    assert run.status is fl.Status.NO_ADMISSIBLE_MODE
    assert (run.events.guard.tolist(), run.events.target.tolist()) == (["a"], [""])
    assert run.t[-1] == 0.0


@ONCE
@pytest.mark.parametrize("rate", [0.2, 0.2 - 1e-15, 0.2 + 1e-15])
@pytest.mark.parametrize("place", [1.0, 1 - 1e-15, 1 + 1e-15])
def test_at_the_limit_of_stick_at_the_start(place, rate):
    """v_r = 0 and friction at its limit, both at t = 0 and up to rounding: it is pulled off at once."""
    run = solved(coulomb(0.2, 1.0, 0.5), 2.0, [place, rate])
    assert run.status is fl.Status.FINISHED
    # from x = 1, v = 1/5 in slip: x = 1/2 + cos(t)/2 + sin(t)/5
    assert run.final_state[0] == pytest.approx(0.5 + np.cos(2) / 2 + np.sin(2) / 5, abs=1e-13)


@ONCE
def test_guards_that_vanish_together_and_change_over_for_ever_stall_or_end():
    """Two modes that hand over to each other at the same zero without moving: a status, no hang."""
    there = fl.Mode("there", (sp.S.One,), (fl.Event("go", 1 - X, ("back",)),))
    back = fl.Mode("back", (-sp.S.One,), (fl.Event("come", X - 1, ("there",)),))
    run = fl.solve(automaton(there, back, states=(X,), coordinates=0), 2.0, x0=[0.0], progress=False)
    assert run.status in (fl.Status.STALLED, fl.Status.NO_ADMISSIBLE_MODE)
    assert run.t[-1] == pytest.approx(1.0, abs=1e-15)
