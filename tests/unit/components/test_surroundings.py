"""What a class of one's own uses beside its fields may change, as in the cells of a notebook."""

from __future__ import annotations

import pytest

import frictionlab as fl
from frictionlab.models.model import data_of

GRAVITY = 9.0


def weight(m):
    return m * GRAVITY


def falling(per_mass):
    @fl.model
    class Ball(fl.MechanicalModel):
        m: float = 1.0
        coordinates = ("y",)
        upwards = 0.0

        def mechanics(self, q, v):
            up = self.m * (per_mass + self.upwards)
            return fl.Mechanics(self.m * v.y**2 / 2, weight(self.m) * q.y, loads={"y": up})

    return Ball


def fallen(kind):
    return -2 * fl.simulate(kind(), 1.0, x0=[0.0, 0.0], progress=False).final_state[0]


def test_numbers_and_methods_that_change_give_new_equations(monkeypatch):
    ball, other = falling(0.0), falling(1.0)
    assert [fallen(ball), fallen(other)] == pytest.approx([9.0, 8.0])
    kept = ball()
    assert kept.structure_key == ball(m=2.0).structure_key
    monkeypatch.setitem(globals(), "GRAVITY", 4.0)
    assert [fallen(ball), fallen(other)] == pytest.approx([4.0, 3.0])
    assert fallen(lambda: kept) == pytest.approx(9.0)  # a model never changes
    monkeypatch.setitem(globals(), "weight", lambda m: 2 * m * GRAVITY)
    assert fallen(ball) == pytest.approx(8.0)
    ball.upwards = 3.0
    assert fallen(ball) == pytest.approx(5.0)
    ball.mechanics = lambda self, q, v: fl.Mechanics(self.m * v.y**2 / 2, self.m * q.y)
    assert fallen(ball) == pytest.approx(1.0)


def test_a_digest_of_equations_leaves_modes_to_runs():
    """Their order in results would depend on it, and differ in another process."""

    @fl.model
    class Pads(fl.MechanicalModel):
        friction: fl.FrictionLaw = fl.Coulomb(mu_k=0.3, mu_s=0.5)
        coordinates = ("x", "y")

        def mechanics(self, q, v):
            pads = tuple(fl.Friction(0.3 - velocity, 1.0, self.friction) for velocity in (v.x, v.y))
            return fl.Mechanics((v.x**2 + v.y**2) / 2, q.x**2 + q.y**2 - q.x * q.y, contacts=pads)

    assert data_of(Pads())["equations"] == data_of(Pads(mu_k=0.2))["equations"]
    assert Pads().automaton().modes.derived == ()
