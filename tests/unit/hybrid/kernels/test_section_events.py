"""Sections record every crossing once, quadratures are exact, and neither changes the motion."""

from itertools import pairwise

import numpy as np
import pytest
import sympy as sp

import frictionlab as fl
from tests.helpers.assertions import assert_same_times
from tests.helpers.automata import ONCE, V, X, automaton, ball, coulomb, oscillator


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
    """The ball's velocity jumps from - to + at a bounce, and passes from + to - at the tops."""
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
    assert_same_times(ridden.events.t, plain.events.t, abs=1e-12)
    assert ridden.final_state == pytest.approx(plain.final_state, abs=1e-12)


def test_sections_need_the_taylor_method():
    with pytest.raises(ValueError, match="method='taylor'"):
        fl.solve(oscillator(), 1.0, x0=[1.0, 0.0], sections={"x": X}, method="rk4")


@pytest.mark.parametrize("function", [sp.Symbol("nowhere"), "nowhere"], ids=["symbol", "output"])
@pytest.mark.parametrize("kind", ["sections", "quadratures"])
def test_an_unknown_name_in_a_function_is_refused(kind, function):
    with pytest.raises(ValueError, match=r"'mine'.*nowhere"):
        fl.solve(oscillator(), 1.0, x0=[1.0, 0.0], **{kind: {"mine": function}})


@ONCE
@pytest.mark.parametrize("tol", [1e-15, 1e-9, 1e-5])
def test_to_touch_the_surface_is_no_crossing(tol):
    """Every bounce ends one arc on the ground and begins the next there; a power of the gap is no other."""
    sections = {"up": (X, 1), "down": (X, -1), "cube": X**3, "square": X**2, "jumps": (V, 1)}
    run = fl.solve(ball(), 2.5, x0=[1.0, 0.0], sections=sections, method=fl.Taylor(tol=tol), progress=False)
    fewer = {name: len(points.t) for name, points in run.sections.items()}
    assert fewer == {"up": 0, "down": 0, "cube": 0, "square": 0, "jumps": (~run.events.closed).sum()}


@ONCE
@pytest.mark.parametrize("tol", [1e-15, 1e-9, 1e-5])
def test_to_lie_on_the_surface_is_no_crossing(tol):
    """v_r of a mass on a belt is positive, zero in stick, and positive again; that of the free slider changes
    its sign as often as slip changes its direction."""
    method, sections = fl.Taylor(tol=tol), {"v_r": "relative_velocity"}
    run = fl.simulate(fl.MassOnBelt(), 30.0, sections=sections, method=method, progress=False)
    assert "slip+ -> stick" in run.events.counts()
    assert len(run.sections["v_r"].t) == 0
    run = fl.simulate(fl.SliderOnBelt(mu_k=1.4), 1.0, sections=sections, method=method, progress=False)
    slips = [mode for mode in ["slip+", *run.events.target] if mode in ("slip+", "slip-")]
    assert len(run.sections["v_r"].t) == sum(a != b for a, b in pairwise(slips)) > 0


@ONCE
def test_a_function_that_is_zero_but_for_rounding_is_never_crossed():
    """w and v have the same rate, so that w - v stays zero."""
    w = sp.Symbol("w", real=True)
    force = -X - X**3 - V / 7
    twin = fl.HybridAutomaton((X, V, w), (fl.Mode("on", (V, force, force / 3 + 2 * force / 3)),), {}, 1)
    sections = {"zero": V - w, "product": (V - w) * X, "x": X}
    run = fl.solve(twin, 60.0, x0=[1.0, 0.3, 0.3], sections=sections, progress=False)
    assert [len(run.sections[name].t) for name in ("zero", "product")] == [0, 0]
    assert len(run.sections["x"].t) > 10
