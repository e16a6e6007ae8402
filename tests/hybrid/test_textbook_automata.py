"""The solver on small automata with known answers; nothing here knows the slider on the belt."""

import numpy as np
import pytest
import sympy as sp

import frictionlab as fl

X, V = sp.symbols("x v")
ONCE = pytest.mark.plain_python  # quick enough for a run without numba


def automaton(*modes, states=(X, V), coordinates=1, **parameters):
    numbers = {sp.Symbol(name): value for name, value in parameters.items()}
    return fl.HybridAutomaton(states, modes, numbers, coordinates)


def oscillator(**more):
    return automaton(fl.Mode("only", (V, -X), **more))


# --- bouncing ball


def ball():
    g, e = sp.symbols("g e")
    bounce = fl.Reset({X: sp.S.Zero, V: -e * V})
    lie = fl.Reset({X: sp.S.Zero, V: sp.S.Zero}, {X: 2})
    flight = fl.Mode("flight", (V, -g), (fl.Event("floor", X, ("flight",), bounce, lie),))
    rest = fl.Mode("rest", (V, sp.S.Zero), (fl.Event("pressed", g),), (X, V))
    return automaton(flight, rest, g=9.81, e=0.5)


ACCUMULATION = 3 * np.sqrt(2 / 9.81)  # fall sqrt(2 h/g), then flights that halve


@ONCE
def test_bouncing_ball_comes_to_rest():
    run = fl.solve(ball(), 3.0, x0=[1.0, 0.0])
    assert run.status is fl.Status.FINISHED
    assert ACCUMULATION == pytest.approx(1.354570922957, abs=1e-12)
    assert run.events.t[-1] == pytest.approx(ACCUMULATION, abs=1e-11)
    assert run.events.closed.tolist() == [False] * (len(run.events) - 1) + [True]
    assert run.stats["accumulations"] == 1
    assert (run.events.target[:-1] == "flight").all()
    assert run.events.target[-1] == "rest"
    assert run.final_state.tolist() == [0.0, 0.0]
    assert run.time_in_mode["rest"] == pytest.approx(3.0 - ACCUMULATION, abs=1e-11)


@ONCE
def test_every_bounce_is_where_it_should_be():
    times = fl.solve(ball(), 3.0, x0=[1.0, 0.0]).events.t[:30]
    fall = np.sqrt(2 / 9.81)
    exact = fall * (1 + 2 * (1 - 0.5 ** np.arange(30)))
    assert times == pytest.approx(exact, abs=1e-14)


@ONCE
def test_an_accumulation_can_end_the_run():
    method = fl.Taylor(accumulation="raise")
    closed, raised = fl.solve(ball(), 3.0, x0=[1.0, 0.0]), fl.solve(ball(), 3.0, x0=[1.0, 0.0], method=method)
    assert raised.status is fl.Status.ACCUMULATED
    assert not raised.status.ok
    assert raised.events.t.tolist() == closed.events.t.tolist()
    assert raised.t[-1] == pytest.approx(ACCUMULATION, abs=1e-11)
    assert np.isfinite(raised.states).all()


def test_without_a_closing_reset_the_run_stalls_and_says_so():
    g = sp.Symbol("g")
    flight = fl.Mode("flight", (V, -g), (fl.Event("floor", X, (), fl.Reset({X: sp.S.Zero, V: -V / 2})),))
    run = fl.solve(automaton(flight, g=9.81), 3.0, x0=[1.0, 0.0])
    assert run.status is fl.Status.STALLED
    assert run.events.t[-1] == pytest.approx(ACCUMULATION, abs=1e-11)
    assert np.isfinite(run.states).all()


# --- Coulomb friction


def coulomb(v, mu_s, mu_k):
    """A unit mass on a unit spring, rubbed by a belt of speed v."""
    belt, static, kinetic = sp.symbols("belt mu_s mu_k")
    relative = belt - V
    stop = fl.Reset({V: belt})
    stick = fl.Mode(
        "stick", (V, sp.S.Zero), (fl.Event("+", static - X, ("+",)), fl.Event("-", static + X, ("-",))), (relative,)
    )
    plus = fl.Mode("+", (V, kinetic - X), (fl.Event("v_r", relative, ("stick", "-"), stop),))
    minus = fl.Mode("-", (V, -kinetic - X), (fl.Event("v_r", -relative, ("stick", "+"), stop),))
    return automaton(stick, plus, minus, belt=v, mu_s=mu_s, mu_k=mu_k)


@ONCE
def test_stick_slip_on_a_belt_has_its_closed_form_period():
    period = 5 + 2 * np.pi - 2 * np.arctan(2.5)  # stick 2 a/v, then an arc; a = 0.5, v = 0.2
    assert period == pytest.approx(8.902605407815, abs=1e-12)
    run = fl.solve(coulomb(0.2, 1.0, 0.5), 60.0, x0=[0.0, 0.2])
    onsets, releases = run.events.t[run.events.target == "stick"], run.events.t[run.events.source == "stick"]
    assert len(onsets) == 6
    assert np.diff(onsets) == pytest.approx(period, abs=1e-11)
    assert releases[0] == pytest.approx(5.0, abs=1e-13)
    assert run.mode[0] == "stick"
    sticking = run.mode == "stick"
    assert run["v"][sticking] == pytest.approx(0.2, abs=1e-15)


@ONCE
def test_coulomb_oscillator_turns_where_it_should_and_stops():
    run = fl.solve(coulomb(0.0, 1.0, 1.0), 20.0, x0=[10.3, 0.0])
    assert run.events.t == pytest.approx(np.pi * np.arange(1, 6), abs=1e-12)
    assert run.events.state[:, 0] == pytest.approx([-8.3, 6.3, -4.3, 2.3, -0.3], abs=1e-12)
    assert run.events.target.tolist() == ["-", "+", "-", "+", "stick"] or run.events.target.tolist() == [
        "+", "-", "+", "-", "stick",
    ]  # fmt: skip
    assert run.final_state == pytest.approx([-0.3, 0.0], abs=1e-12)
    assert run.status.ok


# --- guards


def clock(*events):
    return automaton(fl.Mode("on", (sp.S.One,), events), fl.Mode("off", (sp.S.Zero,)), states=(X,), coordinates=0)


@ONCE
def test_of_two_guards_in_a_step_the_first_in_time_counts():
    events = fl.Event("late", 7 - 10 * X, ("off",)), fl.Event("early", 3 - 10 * X, ("off",))
    for order in (events, events[::-1]):
        run = fl.solve(clock(*order), 1.0, x0=[0.0])
        assert run.events.guard.tolist() == ["early"]
        assert run.events.t == pytest.approx([0.3], abs=1e-15)


@ONCE
def test_two_guards_at_once_are_one_event():
    run = fl.solve(clock(fl.Event("a", 1 - 2 * X, ("off",)), fl.Event("b", 2 - 4 * X, ("off",))), 1.0, x0=[0.0])
    assert run.events.guard.tolist() == ["a"]
    assert run.final_state == pytest.approx([0.5], abs=1e-15)


@ONCE
def test_two_zeros_of_one_guard_in_a_step_are_not_missed():
    run = fl.solve(clock(fl.Event("dip", (X - sp.Rational(3, 10)) * (X - sp.Rational(301, 1000)), ("off",))), 1.0, x0=[0.0])
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
    assert len(run.events) <= 1
    assert run.events.t == pytest.approx(0.5, abs=1e-7)
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


# --- sections and quadratures


def test_two_hundred_periods_cross_zero_four_hundred_times():
    sections = {"both": X, "rising": (X, 1), "falling": (X, -1)}
    run = fl.solve(oscillator(), 400 * np.pi + 0.1, x0=[0.0, 1.0], sections=sections)
    found = run.sections
    assert [len(found[name].t) for name in sections] == [400, 200, 200]
    assert found["both"].t == pytest.approx(np.pi * np.arange(1, 401), abs=1e-10)
    assert (found["rising"].state[:, 1] > 0).all()
    assert (found["falling"].state[:, 1] < 0).all()
    assert np.abs(found["both"].state[:, 0]).max() < 1e-12


@pytest.mark.parametrize("order", [8, 13, 20, 33])
def test_a_crossing_where_steps_meet_counts_once(order):
    """An event at every zero puts every crossing on a step boundary."""
    plus = fl.Mode("+", (V, -X), (fl.Event("zero", X, ("-",)),))
    minus = fl.Mode("-", (V, -X), (fl.Event("zero", -X, ("+",)),))
    method = fl.Taylor(order=order)
    sections = {"both": X, "rising": (X, 1)}
    run = fl.solve(automaton(plus, minus), 40 * np.pi + 0.1, x0=[0.0, 1.0], sections=sections, method=method)
    assert len(run.events) == 40
    assert [len(run.sections[name].t) for name in sections] == [40, 20]
    assert run.sections["both"].t == pytest.approx(run.events.t, abs=1e-12)


@ONCE
def test_a_jump_across_zero_is_a_crossing_at_its_time():
    """The ball's velocity falls through no zero: it jumps from - to + at a bounce, and rises' tops go + to -."""
    run = fl.solve(ball(), 1.0, x0=[1.0, 0.0], sections={"up": (V, 1), "down": (V, -1)})
    fall = np.sqrt(2 / 9.81)
    assert run.sections["up"].t == pytest.approx([fall, 2 * fall], abs=1e-13)
    assert run.sections["down"].t == pytest.approx([1.5 * fall], abs=1e-13)
    assert (run.sections["up"].state[:, 1] > 0).all()


@ONCE
def test_a_section_of_odd_order_is_crossed_and_one_of_even_order_touched():
    sections = {"up": (X**2, 1), "down": (X**2, -1), "cross": X**3}
    run = fl.solve(oscillator(), 20.0, x0=[0.0, 1.0], sections=sections)
    # Rounding may take the square below zero, but then also back.
    assert len(run.sections["up"].t) == len(run.sections["down"].t)
    assert run.sections["cross"].t == pytest.approx(np.pi * np.arange(1, 7), abs=1e-4)


@ONCE
def test_quadratures_are_exact():
    end = 17.3
    run = fl.solve(oscillator(), end, x0=[0.0, 1.0], quadratures={"square": X**2, "time": 1})
    assert run.quadratures["square"] == pytest.approx(end / 2 - np.sin(2 * end) / 4, abs=1e-12)
    assert run.quadratures["time"] == pytest.approx(end, rel=1e-14)
    assert run.final_state.shape == (2,)


@ONCE
def test_quadratures_go_on_through_jumps():
    run = fl.solve(ball(), 3.0, x0=[1.0, 0.0], quadratures={"distance": V**2, "weight": V})
    # the integral of v is the change of height; that of v^2 over arcs of impact speed u is u^3/3g a branch
    speed = np.sqrt(2 * 9.81)
    assert run.quadratures["weight"] == pytest.approx(-1.0, abs=1e-12)
    assert run.quadratures["distance"] == pytest.approx(speed**3 / (3 * 9.81) * (1 + 2 / 7), rel=1e-12)


@ONCE
def test_riders_change_nothing():
    plain = fl.solve(coulomb(0.2, 1.0, 0.5), 20.0, x0=[0.0, 0.2])
    ridden = fl.solve(coulomb(0.2, 1.0, 0.5), 20.0, x0=[0.0, 0.2], sections={"x": X}, quadratures={"x": X})
    assert ridden.events.t == pytest.approx(plain.events.t, abs=1e-12)
    assert ridden.final_state == pytest.approx(plain.final_state, abs=1e-12)


def test_riders_need_the_taylor_method():
    with pytest.raises(ValueError, match="method='taylor'"):
        fl.solve(oscillator(), 1.0, x0=[1.0, 0.0], sections={"x": X}, method="rk4")


@pytest.mark.parametrize("rider", [sp.Symbol("nowhere"), "nowhere"], ids=["symbol", "output"])
@pytest.mark.parametrize("kind", ["sections", "quadratures"])
def test_an_unknown_name_in_a_rider_is_refused(kind, rider):
    with pytest.raises(ValueError, match=r"'mine'.*nowhere"):
        fl.solve(oscillator(), 1.0, x0=[1.0, 0.0], **{kind: {"mine": rider}})


# --- ends of a run


@ONCE
def test_the_step_cap_keeps_what_was_computed():
    run = fl.solve(oscillator(), 1e4, x0=[1.0, 0.0], method=fl.Taylor(max_steps=7))
    assert run.status is fl.Status.STEP_CAP
    assert run.stats["steps"] == 7
    assert 0 < run.t[-1] < 1e4
    assert run["x"] == pytest.approx(np.cos(run.t), abs=1e-13)


@ONCE
def test_the_event_cap_keeps_what_was_computed():
    run = fl.solve(coulomb(0.2, 1.0, 0.5), 1e4, x0=[0.0, 0.2], method=fl.Taylor(max_events=3))
    assert run.status is fl.Status.EVENT_CAP
    assert len(run.events) == 3
    assert run.t[-1] == run.events.t[-1]


@ONCE
def test_no_admissible_mode_after_an_event_is_a_status():
    run = fl.solve(automaton(fl.Mode("only", (sp.Integer(-1),), (fl.Event("x", X),)), states=(X,), coordinates=0), 2.0, x0=[1.0])
    assert run.status is fl.Status.NO_ADMISSIBLE_MODE
    assert run.events.t == pytest.approx([1.0])
    assert run.events.target.tolist() == [""]
    assert run.t[-1] == pytest.approx(1.0)
    assert run.final_state == pytest.approx([0.0], abs=1e-15)


@ONCE
def test_no_admissible_mode_at_the_start_is_a_status():
    run = fl.solve(automaton(fl.Mode("only", (V, -X), (fl.Event("x", X),))), 2.0, x0=[-1.0, 0.0])
    assert run.status is fl.Status.NO_ADMISSIBLE_MODE
    assert len(run.events) == 0
    assert run.final_state.tolist() == [-1.0, 0.0]
    assert run.t.tolist() == [0.0]


@pytest.mark.parametrize("method", ["taylor", "rk4", "DOP853"])
def test_a_motion_that_escapes_in_finite_time_ends_with_a_status(method):
    escape = automaton(fl.Mode("only", (X**2,)), states=(X,), coordinates=0)
    run = fl.solve(escape, 2.0, x0=[1.0], method=method)
    assert run.status in (fl.Status.NOT_FINITE, fl.Status.STALLED)
    assert np.isfinite(run.states).all()
    assert np.isfinite(run.t).all()
    assert run.t[-1] == pytest.approx(1.0, abs=1e-3)


@ONCE
def test_division_by_zero_ends_with_a_status():
    run = fl.solve(automaton(fl.Mode("only", (1 / X,)), states=(X,), coordinates=0), 2.0, x0=[0.0])
    assert run.status is fl.Status.NOT_FINITE
    assert np.isfinite(run.states).all()


@ONCE
def test_a_motion_from_rest_whose_first_coefficients_vanish():
    """x'' = sin t from rest: the series of x starts at t^3."""
    s, c = sp.symbols("s c")
    forced = automaton(fl.Mode("only", (V, s, c, -s)), states=(X, V, s, c))
    run = fl.solve(forced, 5.0, x0=[0.0, 0.0, 0.0, 1.0])
    assert run.status.ok
    assert run.final_state[:2] == pytest.approx([5 - np.sin(5), 1 - np.cos(5)], abs=1e-13)


@ONCE
def test_nothing_moves_in_a_state_of_rest():
    run = fl.solve(oscillator(), 1e6, x0=[0.0, 0.0])
    assert run.status.ok
    assert run.final_state.tolist() == [0.0, 0.0]


# --- arguments


@ONCE
def test_the_first_mode_can_be_chosen():
    twins = automaton(fl.Mode("a", (V, -X)), fl.Mode("b", (V, -4 * X)))
    assert fl.solve(twins, 1.0, x0=[1.0, 0.0]).mode[0] == "a"
    run = fl.solve(twins, 1.0, x0=[1.0, 0.0], mode="b")
    assert run.mode[0] == "b"
    assert run.final_state[0] == pytest.approx(np.cos(2), abs=1e-14)


@ONCE
def test_a_mode_that_cannot_be_entered_is_refused():
    with pytest.raises(ValueError, match="cannot start in mode 'stick'"):
        fl.solve(coulomb(0.2, 1.0, 0.5), 1.0, x0=[0.0, 0.0], mode="stick")
    with pytest.raises(ValueError, match="did you mean 'stick'"):
        fl.solve(coulomb(0.2, 1.0, 0.5), 1.0, x0=[0.0, 0.2], mode="stik")


@ONCE
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"x0": [1.0]}, "one number per state"),
        ({"x0": [1.0, np.nan]}, "finite"),
        ({"x0": ["a", "b"]}, "numbers for the states"),
        ({"t_end": 0.0}, "t_end"),
        ({"t_end": np.inf}, "t_end"),
        ({"t_end": "1"}, "t_end"),
        ({"t_eval": [0.5, 0.2]}, "ascending"),
        ({"t_eval": [0.5, 1.5]}, "ascending"),
        ({"t_eval": [np.nan]}, "ascending"),
        ({"t_eval": 0.5}, "ascending"),
        ({"sections": {"a": (X, 2)}}, "direction of section 'a'"),
    ],
)
def test_bad_arguments_are_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        fl.solve(oscillator(), **{"t_end": 1.0, "x0": [1.0, 0.0], **arguments})


@ONCE
@pytest.mark.parametrize(
    ("broken", "message"),
    [
        (automaton(), "at least one mode"),
        (automaton(fl.Mode("a", (V, -X)), fl.Mode("a", (V, -X))), "must differ"),
        (automaton(fl.Mode("a", (V,))), "one expression per state"),
        (automaton(fl.Mode("a", (V, -X), (fl.Event("e", X, ("b",)),))), r"leads to \['b'\]"),
        (automaton(fl.Mode("a", (V, -sp.Symbol("k") * X))), r"the flow of mode 'a' uses \['k'\]"),
        (automaton(fl.Mode("a", (V, -X), (fl.Event("e", X - sp.Symbol("c")),))), "event 'e'"),
        (automaton(fl.Mode("a", (V, -X), (fl.Event("e", X, (), fl.Reset({V: sp.Symbol("w")})),))), "reset of event 'e'"),
        (automaton(fl.Mode("a", (V, -X), outputs={"energy": sp.Symbol("k") * X})), "output 'energy'"),
        (automaton(fl.Mode("a", (V, -X)), coordinates=2), "coordinates"),
    ],
)  # fmt: skip
def test_malformed_automata_are_refused(broken, message):
    with pytest.raises(ValueError, match=message):
        fl.solve(broken, 1.0, x0=[1.0, 0.0])
