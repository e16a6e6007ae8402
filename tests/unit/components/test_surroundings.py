"""What a class of one's own uses beside its fields may change, as in the cells of a notebook."""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property, partial
from types import SimpleNamespace

import numpy as np
import pytest

import frictionlab as fl
from frictionlab.components.surroundings import surroundings_of
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


@dataclass(frozen=True)
class Dry(fl.FrictionLaw):
    def _times(factor):
        return lambda self, normal_force, *speed: factor * GRAVITY * normal_force

    kinetic, static_limit = _times(0.02), _times(0.03)


@fl.model
class Slider(fl.MechanicalModel):
    m: float = 1.0
    friction: fl.FrictionLaw = Dry()
    coordinates = ("x",)

    def mechanics(self, q, v):
        return fl.Mechanics(self.m * v.x**2 / 2, contacts=(fl.Friction(1.0 - v.x, self.m, self.friction),))


def accelerated():
    return fl.simulate(Slider(), 1.0, x0=[0.0, 0.0], progress=False).final_state[1]


def test_a_law_that_changes_gives_new_equations(monkeypatch):
    assert accelerated() == pytest.approx(0.18)
    structure = fl.Structure(
        [[1.0]], [[1.0]], contacts=fl.SlidingContacts([[1.0]], N=1.0, v=1.0, friction=Dry())
    )
    data = data_of(structure)
    assert data == data_of(structure)
    monkeypatch.setitem(globals(), "GRAVITY", 4.0)
    assert accelerated() == pytest.approx(0.08)
    assert data_of(structure) != data


def test_a_model_first_derived_after_a_change_refuses(monkeypatch):
    ball = falling(2.0)
    before = ball()
    assert before.structure_key.surroundings
    monkeypatch.setitem(globals(), "GRAVITY", 4.0)
    with pytest.raises(ValueError, match="that have changed: make the model anew"):
        fallen(lambda: before)
    monkeypatch.undo()
    assert fallen(ball) == pytest.approx(7.0)


HOLDERS = {
    "second of one code": lambda n: {"one": _returns(2), "other": _returns(n)},
    "cached property": lambda n: {"one": cached_property(_returns(n))},
    "partial": lambda n: {"one": partial(max, n)},
    "wrapper of another module": lambda n: {"one": contextmanager(_returns(n))},
    "set": lambda n: {"one": frozenset({n})},
    "array": lambda n: {"one": np.full(3, n)},
}


def _returns(n):
    return lambda self: n


@pytest.mark.parametrize("held", HOLDERS.values(), ids=HOLDERS)
def test_a_number_is_found_where_it_is_held(held):
    digests = [surroundings_of(type("Own", (), held(n))) for n in (2, 3, 3)]
    assert digests[0] != digests[1] == digests[2]


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


class Spring:
    """An object that computes its stiffness, and holds itself."""

    def __init__(self, n):
        self.n, self.whole = n, self

    @property
    def k(self):
        return self.whole.n


class Record(dict):
    __getattr__ = dict.__getitem__


@dataclass(slots=True)
class Slots:
    k: float


OBJECTS = {
    "namespace": lambda n: SimpleNamespace(k=n),
    "property": Spring,
    "dictionary": lambda n: Record(k=n),
    "slots": Slots,
    "class": lambda n: type("Values", (), {"k": n, "__module__": __name__}),
    "inner object": lambda n: SimpleNamespace(k=SimpleNamespace(k=n)),
    "law": lambda n: fl.LinearContact(k2=n),
    "series": lambda n: pytest.importorskip("pandas").Series({"k": n, "of": "steel"}),
}


@pytest.mark.parametrize("make", OBJECTS.values(), ids=OBJECTS)
def test_a_number_is_found_in_an_object_that_a_method_names(make):
    def digest(n):
        held = make(n)
        return surroundings_of(type("Own", (), {"one": lambda self: held.k}))

    digests = [digest(n) for n in (2, 3, 3)]
    assert digests[0] != digests[1] == digests[2]


def test_an_object_that_changes_gives_new_equations():
    values = SimpleNamespace(weight=9.0)
    ball = falling_by(values)
    assert fallen(ball) == pytest.approx(9.0)
    values.weight = 4.0
    assert fallen(ball) == pytest.approx(4.0)


def falling_by(values):
    @fl.model
    class Ball(fl.MechanicalModel):
        m: float = 1.0
        coordinates = ("y",)

        def mechanics(self, q, v):
            return fl.Mechanics(self.m * v.y**2 / 2, self.m * values.weight * q.y)

    return Ball
