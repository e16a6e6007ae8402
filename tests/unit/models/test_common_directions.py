"""Contacts that rub along one direction, or along more directions than a body can move in, share its load."""

from math import atan, cos, pi, sin
from typing import ClassVar

import numpy as np
import pytest
from scipy.optimize import linprog

import frictionlab as fl
from frictionlab.components import functions
from frictionlab.components.friction import FrictionLaw
from frictionlab.models import MechanicalModel, Mechanics
from frictionlab.models.mechanical.mechanics import Friction, Stop


class Rubbed(MechanicalModel):
    """Base of the models below: one friction law, and forces that change with the phase."""

    friction: FrictionLaw = fl.Coulomb(mu_k=0.5, mu_s=1.0)
    coordinates: ClassVar = ("x",)


@fl.model
class Pads(Rubbed):
    """A mass on a spring under a force F sin(0.3 t), on pads that press with `N` and rub `ways` times x."""

    N: tuple = (1.0, 1.0)
    ways: tuple = (1, 1)
    F: float = fl.parameter(2.4, unit="N", symbol="F", meaning="force", range=(0.0, 10.0))
    v: float = fl.parameter(0.1, unit="m/s", symbol="v", meaning="speed", range=(0.0, 1.0))
    w: float = fl.parameter(0.1, unit="m/s", symbol="w", meaning="speed of the last belt", range=(0.0, 1.0))
    friction: FrictionLaw = fl.Coulomb(mu_k=0.5, mu_s=1.0)

    def mechanics(self, q, v):
        speeds = (*(self.v for _ in self.N[1:]), self.w)
        contacts = (
            Friction(way * (speed - v.x), N, self.friction)
            for N, way, speed in zip(self.N, self.ways, speeds, strict=True)
        )
        return Mechanics(
            kinetic=v.x**2 / 2,
            potential=q.x**2 / 2,
            contacts=tuple(contacts),
            loads={"x": self.F * functions.sin(q.phase)},
            frequency=0.3,
        )


@pytest.mark.parametrize(
    ("N", "ways"),
    [((1.0, 1.0), (1, 1)), ((0.3, 1.7), (1, -1)), ((1.7, 0.3), (-2, 1)), ((0.2,) * 10, (1, -1) * 5)],
    ids=["halves", "reverse", "geared", "ten"],
)
def test_a_pad_in_parts_is_the_pad(N, ways):
    """The load is shared, whatever the parts, their directions and their sequence."""
    whole = Pads(N=(sum(n * abs(way) for n, way in zip(N, ways, strict=True)),), ways=(1,))
    parts = Pads(N=N, ways=ways)
    one, many = (fl.simulate(model, 60.0, x0=[0.0, 0.0, 0.0]) for model in (whole, parts))
    assert {"stick", "slip+", "slip-"} <= {*one.mode}
    signs = {1: {}, -1: {"slip+": "slip-", "slip-": "slip+"}}
    for name in ("source", "target"):
        expected = [
            " | ".join(signs[np.sign(way)].get(mode, mode) for way in ways)
            for mode in getattr(one.events, name)
        ]
        assert getattr(many.events, name).tolist() == expected
    np.testing.assert_allclose(many.events.t, one.events.t, rtol=1e-13)
    np.testing.assert_allclose(many.final_state, one.final_state, rtol=1e-12, atol=1e-13)
    if len(N) > 2:  # of 3^10 modes
        assert len(parts.automaton().modes.derived) < 10
        return
    t = np.linspace(0.0, 60.0, 500)
    sticks = one.modes_at(t) == "stick"
    forces = [many.output(f"friction_force_{i}", t)[sticks] / n for i, n in enumerate(N, 1)]
    np.testing.assert_allclose(forces[1], np.sign(ways[0] * ways[1]) * forces[0], rtol=1e-12, atol=1e-12)


def test_belts_of_one_speed_under_two_names():
    """They hold together where the speeds are equal, and not at all where they differ."""
    whole, parts = Pads(N=(2.0,), ways=(1,)), Pads()
    runs = [fl.simulate(model, 60.0, x0=[0.0, 0.0, 0.0]) for model in (whole, parts)]
    assert "stick | stick" in runs[1].mode
    np.testing.assert_allclose(runs[1].final_state, runs[0].final_state, rtol=1e-12, atol=1e-13)
    apart = fl.simulate(parts.replace(w=0.12), 60.0, x0=[0.0, 0.0, 0.0])
    assert "stick | stick" not in apart.mode
    assert {"stick | slip+", "slip- | stick"} & {*apart.mode}


@fl.model
class Cart(Rubbed):
    """A cart with four locked wheels on a road whose slope, the phase, grows by 0.1 rad/s."""

    friction: FrictionLaw = fl.Coulomb(mu_k=0.3, mu_s=0.6)

    def mechanics(self, q, v):
        weight = 9.81 * functions.cos(q.phase)
        wheels = (Friction(-v.x, share * weight, self.friction) for share in (0.1, 0.2, 0.3, 0.4))
        return Mechanics(
            kinetic=v.x**2 / 2,
            contacts=tuple(wheels),
            loads={"x": 9.81 * functions.sin(q.phase)},
            frequency=0.1,
        )


def test_a_cart_begins_to_slide_at_the_slope_of_static_friction():
    run = fl.simulate(Cart(), 10.0, x0=[0.0, 0.0, 0.0])
    begin, end = atan(0.6), 1.0
    assert run.events.target.tolist() == ["slip- | slip- | slip- | slip-"]
    assert run.events.t[0] * 0.1 == pytest.approx(begin, rel=1e-14)
    speed = 98.1 * (cos(begin) - cos(end) - 0.3 * (sin(end) - sin(begin)))
    assert run.final_state[1] == pytest.approx(speed, rel=1e-12)


ARMS, PRESSES = (-0.7, 0.2, 1.0), (1.0, 1.5, 0.7)


@fl.model
class Board(Rubbed):
    """A board on three pads beside each other, which can shift and turn; its load grows from zero."""

    angle: float = fl.parameter(1.0, unit="rad", symbol="a", meaning="of force and moment", range=(0.0, 7.0))
    friction: FrictionLaw = fl.Coulomb(mu_k=0.4, mu_s=1.0)
    coordinates = ("x", "turn")

    def mechanics(self, q, v):
        pads = (Friction(-v.x - a * v.turn, N, self.friction) for a, N in zip(ARMS, PRESSES, strict=True))
        loads = {"x": functions.cos(self.angle), "turn": functions.sin(self.angle)}
        return Mechanics(
            kinetic=(v.x**2 + 0.3 * v.turn**2) / 2,
            contacts=tuple(pads),
            loads={name: 4.0 * q.phase * load for name, load in loads.items()},
            frequency=1e-3,
        )


@pytest.mark.parametrize("angle", np.linspace(0.1, 2 * pi, 9))
def test_more_contacts_than_freedoms_hold_as_much_as_they_can(angle):
    """Limit analysis: the largest load for which forces within the limits exist, by linear programming."""
    columns = [[1.0, 1.0, 1.0, -4 * cos(angle)], [*ARMS, -4 * sin(angle)]]
    bounds = [*((-N, N) for N in PRESSES), (0, None)]
    most = -linprog([0, 0, 0, -1], A_eq=columns, b_eq=[0, 0], bounds=bounds).fun
    run = fl.simulate(Board(angle=float(angle)), 1000 * most + 1.0, x0=np.zeros(5))
    assert run.status.ok
    assert run.events.t[-1] * 1e-3 == pytest.approx(most, rel=1e-12)
    np.testing.assert_allclose(run.events.state[-1][:4], 0.0, atol=1e-9)
    assert np.abs(run.final_state[2:4]).max() > 0.1


@fl.model
class BlockAtStop(Rubbed):
    """A block that 1 - phase newtons press against a stop; friction holds it beside the stop."""

    friction: FrictionLaw = fl.Coulomb(mu_k=0.4, mu_s=0.8)

    def mechanics(self, q, v):
        return Mechanics(
            kinetic=v.x**2 / 2,
            contacts=(Friction(-v.x, 1.0, self.friction), Stop(-q.x, fl.RestitutionImpact(e=0.5))),
            loads={"x": 2.0 * (1.0 - q.phase)},
            frequency=0.1,
        )


def test_beside_a_stop_friction_holds_up_to_its_static_limit():
    run = fl.simulate(BlockAtStop(), 15.0, x0=[0.0, 0.0, 0.0])
    assert run.events.target.tolist() == ["stick | flight", "slip+ | flight"]
    assert 2.0 * (1.0 - 0.1 * run.events.t) == pytest.approx([0.8, -0.8], rel=1e-12)
