"""What users of event-driven solvers report, each as a test with its source.

===============================  =======================================================================
event at t0                      sys-bio/tellurium #339; sksat/orts #545
re-trigger after a reset         SciML/DiffEqBase.jl #1245, #672
several roots in one step        scipy #9228; DiffEqBase.jl #271; CyRK #98
cubic root, g = u^3              DiffEqBase.jl #671
simultaneous guards              DifferentialEquations.jl #516, DiffEqBase.jl #837, #889;
                                 tests/integration/test_simultaneous_events.py
guard zero throughout stick      OrdinaryDiffEq.jl #3627, DiffEqBase.jl #599
falling through the floor        DifferentialEquations.jl #138, #551; OpenModelica #16009
stuck-slip ping-pong             OpenModelica #16022
root at the end of a step        scipy #17066, #19418; tests/unit/hybrid/kernels/test_event_location.py
event times beyond rounding      scipy #15262
chatter (a sliding mode)         OpenModelica #12190; tests/unit/hybrid/kernels/test_chatter.py
a stick machine                  OrdinaryDiffEq.jl #3222 (tests/slow/solver/test_stick_machine.py)
grazing                          tests/unit/hybrid/kernels/test_event_location.py
accumulation                     tests/integration/test_textbook_automata.py
===============================  =======================================================================
"""

import numpy as np
import pytest
import sympy as sp

import frictionlab as fl
from tests.helpers.automata import ONCE, V, X, automaton

Y = sp.Symbol("y")


def solved(system, t_end, x0, **options):
    run = fl.solve(system, t_end, x0=x0, progress=False, **options)
    assert run.status is fl.Status.FINISHED
    return run


def alternating(g, **more):
    """x' = 1; two modes take turns wherever g changes its sign, so every root is an event."""
    above = fl.Mode("above", (sp.S.One,), (fl.Event("down", g, ("below",)),))
    below = fl.Mode("below", (sp.S.One,), (fl.Event("up", -g, ("above",)),))
    return automaton(above, below, states=(X,), coordinates=0, **more)


# --- event at t0


@ONCE
@pytest.mark.parametrize("first", ["rising", "falling"])
def test_a_guard_that_is_zero_at_the_start(first):
    """t (1/2 - t) and its negative at 0: one leaves zero, the other is in the wrong mode there."""
    g = X * (sp.Rational(1, 2) - X)
    run = solved(alternating(g if first == "rising" else -g), 1.0, [0.0])
    assert run.mode[0] == ("above" if first == "rising" else "below")
    assert run.events.t == pytest.approx([0.5], abs=1e-15)


@ONCE
def test_an_event_that_is_due_at_the_start_and_leads_on():
    """Two functions zero at once: of the mode that is refused nothing is run."""
    off = fl.Mode("off", (sp.S.Zero,))
    on = fl.Mode("on", (sp.S.One,), (fl.Event("due", -X, ("off",)),))
    run = solved(automaton(on, off, states=(X,), coordinates=0), 1.0, [0.0])
    assert run.final_state.tolist() == [0.0]
    assert set(run.mode) == {"off"}


# --- re-trigger after a reset


@ONCE
@pytest.mark.parametrize("places", [(1e-8, 2e-8, 2e-7), (0.3, 0.3 + 1e-13, 0.7), (1e-14, 0.5, 0.5 + 1e-12)])
def test_events_close_to_each_other_are_each_found_once(places):
    """DiffEqBase #1245: backwards from 1 the event at 2e-7 was triggered twice."""
    back = tuple(fl.Event(f"{p:g} {i}", X - p, (f"after {i}",)) for i, p in enumerate(sorted(places)))
    modes = [
        fl.Mode("start" if i == len(places) else f"after {i}", (-sp.S.One,), back[i - 1 : i] if i else ())
        for i in range(len(places), -1, -1)
    ]
    run = solved(automaton(*modes, states=(X,), coordinates=0), 2.0, [1.0])
    assert run.events.target.tolist() == [f"after {i}" for i in range(len(places) - 1, -1, -1)]
    assert 1.0 - run.events.t == pytest.approx(sorted(places)[::-1], abs=1e-15)


@ONCE
def test_a_reset_that_leaves_the_guard_at_zero():
    """A throw up from the floor: the height is zero before and after each bounce, and counts once."""
    up = fl.Reset({V: -V})
    run = solved(
        automaton(fl.Mode("flight", (V, -sp.S.One), (fl.Event("floor", X, (), up),))), 10.5, [0, 1.0]
    )
    assert run.events.t == pytest.approx([2, 4, 6, 8, 10], abs=1e-13)


# --- several roots in one step


@ONCE
def test_the_cubic_with_three_roots():
    """scipy #9228: y = (x - 2)(x + 2)(x + 6) from x = -8 to 4, of whose roots solve_ivp found the first."""
    g = (X - 2) * (X + 2) * (X + 6)
    run = solved(alternating(g), 12.0, [-8.0])
    assert run.events.state[:, 0] == pytest.approx([-6.0, -2.0, 2.0], abs=1e-13)


@ONCE
@pytest.mark.parametrize("apart", [0.1, 1e-3, 1e-6])
def test_two_roots_as_close_as_they_may_be(apart):
    """DiffEqBase #271: (t - 0.5)(t - 0.6)."""
    run = solved(alternating((X - 0.5) * (X - 0.5 - apart)), 1.0, [0.0])
    assert run.events.t == pytest.approx([0.5, 0.5 + apart], abs=1e-15 / apart)


@ONCE
def test_sections_count_every_root_too():
    scene = automaton(fl.Mode("on", (sp.S.One,)), states=(X,), coordinates=0)
    run = solved(scene, 12.0, [-8.0], sections={"root": (X - 2) * (X + 2) * (X + 6)})
    assert run.sections["root"].t == pytest.approx([2.0, 6.0, 10.0], abs=1e-13)


# --- cubic root


@ONCE
@pytest.mark.parametrize("power", [1, 3, 5])
def test_a_root_of_odd_order_is_where_the_simple_one_is(power):
    """DiffEqBase #671: a fall from 50 m, u^3 in place of u: 3.146 s instead of 3.194 s.

    The p-th root of rounding is all that g^p tells, so times agree to that.
    """
    floor = fl.Event("floor", X**power, ("below",))
    flight = fl.Mode("flight", (V, sp.Float(-9.8)), (floor,))
    run = solved(automaton(flight, fl.Mode("below", (V, sp.Float(-9.8)))), 5.0, [50.0, 0.0])
    exact = np.sqrt(100 / 9.8)
    assert run.events.t == pytest.approx([exact], abs=1e-14 if power == 1 else 50 * 1e-16 ** (1 / power))
    assert run.events.target.tolist() == ["below"]


# --- simultaneous guards


@ONCE
def test_two_oscillations_that_cross_together():
    """DiffEqBase #837: two equal cosines reach a threshold at once, and the solver stood still."""
    a, b, va, vb = sp.symbols("a b va vb")
    half = sp.Rational(1, 2)
    events = (
        fl.Event("a", half - a, ("on",), fl.Reset({va: -va})),
        fl.Event("b", half - b, ("on",), fl.Reset({vb: -vb})),
    )
    scene = automaton(fl.Mode("on", (va, vb, -a, -b), events), states=(a, b, va, vb), coordinates=2)
    run = solved(scene, 20.0, [0.0, 0.0, 1.0, 1.0])
    first = np.pi / 6
    times = first + (np.pi + 2 * first) * np.arange(5)
    assert run.events.t == pytest.approx(np.repeat(times, 2), abs=1e-13)
    assert all(set(pair) == {"a", "b"} for pair in run.events.guard.reshape(5, 2))


# --- guard zero throughout


@ONCE
def test_a_guard_that_stays_at_zero_blocks_no_other():
    """OrdinaryDiffEq #3627: u2 sticks at 1 from t = 1 on, u1 = t/2 comes to 5 at t = 10."""
    one, two = fl.Event("u1", 5 - X, ("done",)), fl.Event("u2", 1 - Y, ("stuck",))
    free = fl.Mode("free", (sp.Rational(1, 2), sp.S.One), (one, two))
    stuck = fl.Mode("stuck", (sp.Rational(1, 2), sp.S.Zero), (one, two))
    done = fl.Mode("done", (sp.Rational(1, 2), sp.S.Zero))
    run = solved(automaton(free, stuck, done, states=(X, Y), coordinates=0), 20.0, [0.0, 0.0])
    assert run.events.t == pytest.approx([1.0, 10.0], abs=1e-14)
    assert run.events.guard.tolist() == ["u2", "u1"]


# --- falling through the floor


@ONCE
@pytest.mark.parametrize(("e", "height"), [(0.7, 1.0), (0.8, 50.0), (0.9, 9.0), (0.99, 1.0)])
def test_no_ball_is_ever_below_the_floor(e, height):
    """DifferentialEquations #138: through it on the sixth bounce; OpenModelica #16009: to -0.96 m."""
    model = fl.BouncingBall(e=e, h=height, g=9.8)
    end = np.sqrt(2 * height / 9.8) * (1 + e) / (1 - e)
    run = fl.simulate(model, 1.2 * end, progress=False)
    assert run(np.linspace(0.0, run.t[-1], 50_001))[:, 0].min() >= -1e-13 * height
    assert run.mode[-1] == "contact"
    assert run.final_state.tolist() == [0.0, 0.0]
    assert run.events.t[-1] == pytest.approx(end, rel=1e-9)


@ONCE
def test_at_an_event_the_guard_has_come_to_zero():
    """DifferentialEquations #551: the state handed to the callback was before the crossing."""
    run = fl.simulate(fl.BouncingBall(e=0.8), 3.0, progress=False)
    assert np.abs(run.events.before[:, 0]).max() < 1e-15
    assert (run.events.before[:, 1] < 0).all()
    assert (run.events.state[:, 0] == 0).all()


# --- stuck and slip


@ONCE
@pytest.mark.parametrize("speed", [1e-12, 1e-8, 1e-3])
def test_stick_and_slip_do_not_play_ping_pong(speed):
    """OpenModelica #16022: near rest a bearing went to and fro between stuck and slipping, time frozen."""
    ratio = 1e-3 / speed  # (mu_s - mu_k) N/k over the speed
    period = 2 * ratio + 2 * np.pi - 2 * np.arctan(ratio)
    model = fl.MassOnBelt(v=speed, mu_k=0.999, mu_s=1.0)
    run = fl.simulate(model, 10.5 * period, x0=[1.0, speed], progress=False)
    assert run.status is fl.Status.FINISHED
    assert len(run.events) in (20, 21)
    onsets = run.events.t[run.events.target == "stick"]
    assert len(onsets) >= 10
    assert np.diff(onsets) == pytest.approx(period, rel=1e-10)


@ONCE
@pytest.mark.parametrize("place", [1.0, 1 - 1e-16, 1 + 1e-16, -1.0])
def test_at_the_edge_of_stick_a_mass_stays_or_goes_once(place):
    """mu_s = mu_k: at |k x| = mu N both are one motion, and it is over at once."""
    run = fl.simulate(fl.FreeCoulomb(x_0=place), 50.0, progress=False)
    assert run.status is fl.Status.FINISHED
    assert len(run.events) <= 2
    assert abs(run.final_state[0]) == pytest.approx(1.0, abs=1e-15)


# --- the end of a step, and of a run


@ONCE
@pytest.mark.parametrize("end", [0.1, 1.0, 3.7])
def test_an_event_at_every_sample(end):
    """scipy #17066, #19418: a root that is the step's own end makes a time twice, and an error."""
    times = np.linspace(0.0, end, 11)
    run = solved(alternating(sp.sin(sp.pi * X * 10 / end)), end, [0.0], t_eval=times)
    assert run.events.t[:9] == pytest.approx(times[1:10], abs=1e-14)
    assert run.t.tolist() == times.tolist()
    assert np.isfinite(run.states).all()


@ONCE
@pytest.mark.parametrize("unit", [1e-12, 1e-6, 1.0, 1e6])
def test_time_has_no_unit(unit):
    """scipy #15262: an electron crosses a micrometre in picoseconds, less than brentq's tolerance."""
    fall = automaton(
        fl.Mode("on", (V, sp.Symbol("a")), (fl.Event("there", 1 - X, ("off",)),)),
        fl.Mode("off", (V, sp.S.Zero)),
        a=2.0 / unit**2,
    )
    run = solved(fall, 2 * unit, [0.0, 0.0])
    assert run.events.t == pytest.approx([unit], rel=1e-15)


# --- chatter


def switched(*more):
    """OpenModelica #12190: x' = 2 - 4 (x > y), y' = 1.5 - 4.5 (y > x), both pushed to x = y."""
    over = fl.Mode("x > y", (sp.Integer(-2), sp.Rational(3, 2)), (fl.Event("equal", X - Y),))
    under = fl.Mode("y > x", (sp.Integer(2), sp.Integer(-3)), (fl.Event("equal", Y - X),))
    return automaton(over, under, *more, states=(X, Y), coordinates=0)


@ONCE
def test_a_sliding_mode_that_is_left_out_is_named_and_not_walked():
    """Variable steps get stuck there: here the run ends with a sentence."""
    run = fl.solve(switched(), 1.0, x0=[1.5, 1.0], progress=False)
    assert run.status is fl.Status.NO_ADMISSIBLE_MODE
    assert run.t[-1] == pytest.approx(0.5 / 3.5, abs=1e-15)


@ONCE
def test_a_sliding_mode_is_one_mode_with_a_constraint():
    """Filippov's: 5/8.5 of one flow and 3.5/8.5 of the other keep x = y, both fall at 3/8.5."""
    along = -sp.Rational(30, 85)
    run = solved(switched(fl.Mode("x = y", (along, along), (), (X - Y,))), 1.0, [1.5, 1.0])
    meet = 0.5 / 3.5
    assert run.events.target.tolist() == ["x = y"]
    assert run.events.t == pytest.approx([meet], abs=1e-15)
    end = 1.5 - 2 * meet - 3 / 8.5 * (1 - meet)
    assert run.final_state == pytest.approx([end, end], abs=1e-14)
