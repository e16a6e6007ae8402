"""Motions that turn for ever, or whose place grows, recur modulo that."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

import frictionlab as fl
from frictionlab.models import Friction, Mechanics
from tests.helpers.automata import V, X, automaton
from tests.helpers.known_motions import settled

W, Y, CLOCK = sp.symbols("w y clock")


def only(flow, states, coordinates=1):
    return automaton(fl.Mode("only", tuple(map(sp.sympify, flow))), states=states, coordinates=coordinates)


def test_a_pendulum_that_turns_for_ever():
    """x'' = 2 - sin x - x'/5: its period is the time of one turn, here by DOP853."""
    found = settled(only((V, 2 - sp.sin(X) - V / 5), (X, V)), [0.0, 3.0], transient=200.0, window=60.0)

    def turned(t, z):
        return z[0] - 2 * np.pi * 200

    turned.terminal = True
    far = solve_ivp(
        lambda t, z: [z[1], 2 - np.sin(z[0]) - z[1] / 5],
        (0, 1e3), [0.0, 3.0], "DOP853", rtol=1e-12, atol=1e-12,
        events=[turned, lambda t, z: z[0] - 2 * np.pi * 199],
    )  # fmt: skip
    period = far.t_events[0][0] - far.t_events[1][0]
    assert found.kind == "periodic"
    assert found.period == pytest.approx(period, rel=1e-8)
    assert found.drift == pytest.approx({"x": 2 * np.pi / period}, rel=1e-2)
    assert "x drifts by" in repr(found)


def test_a_turn_without_coordinates_has_its_closed_form():
    """x' = 2 - sin x turns in 2 pi/sqrt(3)."""
    found = settled(only((2 - sp.sin(X),), (X,), 0), [0.0], transient=20.0, window=60.0)
    assert (found.kind, found.period) == ("periodic", pytest.approx(2 * np.pi / 3**0.5, rel=1e-10))


@pytest.mark.parametrize("transient", [30.0, 400.0])
def test_a_disc_that_turns_evenly_is_at_an_equilibrium(transient):
    found = settled(only((V, 2 - V / 5), (X, V)), [0.0, 3.0], transient=transient, window=60.0)
    assert found.kind == "equilibrium"
    assert found.drift == pytest.approx({"x": 10.0}, rel=1e-2)


@fl.model
class Dragged(fl.MechanicalModel):
    """A block on the ground that a carriage of constant speed drags by a spring."""

    m: float = fl.parameter(1.0, unit="kg", symbol="m", meaning="mass", range=(0.1, 10.0))
    k: float = fl.parameter(4.0, unit="N/m", symbol="k", meaning="stiffness", range=(0.1, 100.0))
    friction: fl.FrictionLaw = fl.Coulomb(mu_k=0.3, mu_s=0.5)
    coordinates = ("x", "s")
    period = 5.0

    def mechanics(self, q, v):
        """The load keeps the carriage's speed."""
        pull = self.k * (q.s - q.x)
        return Mechanics(
            self.m * v.x**2 / 2 + v.s**2 / 2,
            self.k * (q.s - q.x) ** 2 / 2,
            contacts=(Friction(-v.x, 1.0, self.friction),),
            loads={"s": pull},
        )


@pytest.mark.parametrize("speed", [0.05, 0.2])
def test_a_block_that_is_dragged_along(speed):
    """Beside the carriage it circles about the place of kinetic friction, and sticks for the rest."""
    model = Dragged()
    found = settled(model, {"s'": speed}, transient=50.0 / speed**0.5, window=30.0 / speed)
    omega, half = 2.0, (0.5 - 0.3) / model.k
    period = (2 * np.pi - 2 * np.arctan(half * omega / speed)) / omega + 2 * half / speed
    assert (found.kind, found.onsets_per_period) == ("periodic", 1)
    assert found.period == pytest.approx(period, rel=1e-9)
    assert found.drift == pytest.approx(dict.fromkeys(("x", "s"), speed), rel=0.1)


@pytest.mark.parametrize("rate", [1, 1 + V + X**2])
def test_a_state_that_only_grows_beside_an_oscillation(rate):
    """Of van der Pol's, by DOP853 from one crossing to the next."""
    flow = (V, -X - (X**2 - 1) * V / 10)
    found = settled(only((*flow, rate), (X, V, CLOCK)), [0.0, 1.0, 0.0], transient=300.0, window=60.0)
    alone = settled(only(flow, (X, V)), [0.0, 1.0], transient=300.0, window=60.0)
    assert (found.kind, alone.kind) == ("periodic", "periodic")
    assert found.period == pytest.approx(alone.period, rel=1e-12)
    assert found.period == pytest.approx(2 * np.pi * (1 + 0.1**2 / 16), rel=1e-5)  # Lindstedt and Poincare


def test_two_bodies_that_turn_together_against_gravity():
    """Only a turn of both leaves the spring between them and their weights as they are."""
    pull = 3 * (X - Y)
    flow = (V, W, 2 - sp.sin(X) - V / 5 - pull, 2 - sp.sin(Y) - W / 5 + pull)
    one = settled(only((V, 2 - sp.sin(X) - V / 5), (X, V)), [0.0, 3.0], transient=200.0, window=60.0)
    both = settled(only(flow, (X, Y, V, W), 2), [0.0, 0.0, 3.0, 3.0], transient=200.0, window=60.0)
    assert (both.kind, both.period) == ("periodic", pytest.approx(one.period, rel=1e-9))


def test_states_that_turn_in_a_ratio_are_periodic():
    """V = 2 (1 - cos x) + 5 (y - x/3)^2 turns x while y moves by a third of it; the period by DOP853."""
    pull = 10 * (Y - X / 3)
    flow = (V, W, 4 - 2 * sp.sin(X) + pull / 3 - V / 2, -pull - 3 * W / 5)
    found = settled(only(flow, (X, Y, V, W), 2), [0.0, 0.0, 7.0, 2.0], transient=60.0, window=40.0)

    def rates(t, z):
        x, y, v, w = z
        pull = 10 * (y - x / 3)
        return [v, w, 4 - 2 * np.sin(x) + pull / 3 - v / 2, -pull - 3 * w / 5]

    turns = [lambda t, z, k=k: z[0] - 2 * np.pi * k for k in (60, 61)]
    turns[1].terminal = True
    far = solve_ivp(rates, (0, 1e3), [0.0, 0.0, 7.0, 2.0], "DOP853", rtol=1e-12, atol=1e-12, events=turns)
    period = far.t_events[1][0] - far.t_events[0][0]
    assert (found.kind, found.period) == ("periodic", pytest.approx(period, rel=1e-8))
    assert found.drift["x"] == pytest.approx(3 * found.drift["y"], rel=1e-2)


def test_a_growth_on_which_the_motion_depends_is_named():
    flow = (V, -X * (1 + CLOCK / 1000) - (X**2 - 1) * V / 10, 1)
    found = settled(only(flow, (X, V, CLOCK)), [0.0, 1.0, 0.0], transient=100.0, window=60.0)
    assert found.kind == "not settled yet"
    assert found.drift == pytest.approx({"clock": 1.0})
    assert "clock drifts by 1/s" in repr(found)


@pytest.mark.slow
def test_drifts_that_differ_in_place_alone_are_one_attractor():
    """x'' = 1/2 - g sin x - x'/10 turns with x' = 5 where g = 0; with g = 1 it may rest at arcsin 1/2."""
    grid = {"x": ("x", np.linspace(-1.0, 1.0, 3)), "y": ("v", np.linspace(-1.0, 6.0, 3))}
    times = {"transient": 100.0, "window": 60.0, "progress": False}
    (turning,) = fl.basins(only((V, sp.Rational(1, 2) - V / 10), (X, V)), **grid, **times).attractors
    assert turning.name == "equilibrium with drift"
    assert turning.state[1] == pytest.approx(5.0, rel=1e-9)
    fates = fl.basins(only((V, sp.Rational(1, 2) - sp.sin(X) - V / 10), (X, V)), **grid, **times)
    kinds = {each.kind: each for each in fates.attractors}
    assert len(fates.attractors) == 2
    assert kinds["equilibrium"].state == pytest.approx([np.pi / 6, 0.0], abs=1e-7)
    assert kinds["periodic"].name.endswith("with drift")
