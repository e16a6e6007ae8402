"""The runs that are compared: all models, all laws, functions and switches, at a tight and a loose tolerance.

Initial states and parameters are numbers that are written here, so that nothing comes from statics.
"""

from __future__ import annotations

import hashlib
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
import sympy as sp

import frictionlab as fl

TIGHT, LOOSE = fl.Taylor(tol=1e-15), fl.Taylor(tol=1e-6)
SWITCHES = ("cubic", "nonsmooth", "geometry")
BELT = fl.SliderOnBelt(mu_k=1.4)
PUSHED = {"x1": 2e-4, "y1": -3e-4, "x1'": 0.01, "y2'": -0.2}  # of the slider on the belt
LAWS = {
    "full gap rate": BELT.replace(impact=fl.PlasticImpact("full")),
    "restitution": BELT.replace(impact=fl.RestitutionImpact(e=0.5)),
    "frictional impact": BELT.replace(impact=fl.FrictionalImpact(e=0.3)),
    "linear contact": BELT.replace(contact=fl.LinearContact(k2=5e3)),
    "Hertz contact": BELT.replace(contact=fl.HertzContact()),
    "polynomial contact": BELT.replace(contact=fl.PolynomialContact()),
    "exponential decay": BELT.replace(friction=fl.ExponentialDecay()),
    "Stribeck friction": BELT.replace(friction=fl.Stribeck()),
    "weakening": BELT.replace(friction=fl.WeakeningStrengthening()),
    "pressure": BELT.replace(friction=fl.PressureDependent()),
    "fixed load": BELT.replace(geometry=fl.FixedLoad()),
    "normal load": BELT.replace(geometry=fl.MovingLoad(direction="normal")),
    "stick and slip": BELT.replace(interface=fl.StickSlip()),
    "sliding": BELT.replace(interface=fl.SlidingSeparation()),
}
MODELS = {
    "MassOnBelt": (fl.MassOnBelt(), {"x": 0.05}, 12.0),
    "MassOnBelt Stribeck": (fl.MassOnBelt(friction=fl.Stribeck(mu_k=0.5, mu_s=1.0), c=0.1), {"x": 0.3}, 12.0),
    "MassOnBelt weakening": (
        fl.MassOnBelt(friction=fl.WeakeningStrengthening(mu_k=0.5, mu_s=1.0), c=0.1, v=1.0),
        {"x": 2.0},
        12.0,
    ),
    "ModeCoupling": (fl.ModeCoupling(), {}, 12.0),
    "SliderOnRigidBelt": (fl.SliderOnRigidBelt(), {}, 0.1),
    "DenHartog": (fl.DenHartog(), {"x": 0.1}, 12.0),
    "FreeCoulomb": (fl.FreeCoulomb(), {"x": 7.3}, 12.0),
    "BouncingBall": (fl.BouncingBall(), {"y": 1.0}, 1.5),
    "ImpactOscillator": (fl.ImpactOscillator(), {"x": -0.2}, 5.0),
    "TwoBlocks": (fl.TwoBlocks(), {"x1": 0.1}, 6.0),
}
BRIEF = ("restitution", "MassOnBelt Stribeck", "BouncingBall", "every function")  # quick as plain Python too


@dataclass(frozen=True)
class Case:
    """A run by its name."""

    name: str
    model: Any
    x0: Any
    t_end: float
    method: Any
    brief: bool

    def run(self) -> Any:
        """Its trajectory."""
        solver = fl.simulate if isinstance(self.model, fl.Model) else fl.solve
        return solver(self.model, self.t_end, x0=self.x0, method=self.method, progress=False)


def every_function() -> Any:
    """An automaton with all functions of states, and of parameters."""
    x, y, a, b = sp.symbols("x y a b")
    t = x * y / 4
    of_states = sp.tanh(3 * x) - sp.atan(y) + sp.sin(5 * t) * sp.cos(x) - sp.sinh(t) / sp.cosh(y)
    more = sp.asinh(x) + sp.log(2 + y**2) / 5 + sp.tan(t) - x * (1 + y**2) ** a + sp.exp(-(x**2))
    of_parameters = (
        sp.exp(-b) * sp.sin(9 * b) + sp.sqrt(a) * sp.log(b) - sp.acos(a) + sp.atanh(a) * sp.cosh(b) ** -3
    )
    flow = (y, -4 * x - y / 10 + of_states / 3 + of_parameters / 7)
    back = (y, -9 * x - y / 20 + more / 5 - b**a)
    left = x + more / 9
    guard, other = fl.Event("left", left, ("back",)), fl.Event("right", -left, ("there",))
    modes = fl.Mode("there", flow, (guard,)), fl.Mode("back", back, (other,))
    return fl.HybridAutomaton((x, y), modes, {a: 0.3, b: 1.7}, 1)


def cases() -> Iterator[Case]:
    """All runs."""
    for how, method in ("tight", TIGHT), ("loose", LOOSE):
        for count in range(len(SWITCHES) + 1):
            for off in combinations(SWITCHES, count):
                model, name = BELT.without(*off), " ".join(("belt without", *off)) if off else "belt"
                yield _case(name, how, model, PUSHED, 0.15, method)
        for name, model in LAWS.items():
            yield _case(name, how, model, PUSHED, 0.15, method)
        for name, (model, x0, t_end) in MODELS.items():
            yield _case(name, how, model, x0, t_end, method)
        yield _case("every function", how, every_function(), [0.4, 0.3], 4.0, method)
    yield _case("belt", "RK4", BELT, PUSHED, 0.05, fl.RK4(step=1e-3))


def _case(name: str, how: str, model: Any, x0: Any, t_end: float, method: Any) -> Case:
    return Case(f"{name}, {how}", model, x0, t_end, method, name in BRIEF)


def digest_of(run: Any) -> str:
    """The events (time, guard, modes, state) and the final state of a run, to the last bit; -0.0 is 0.0."""
    digest = hashlib.sha256(str(run.status).encode())
    events = run.events
    for t, guard, source, target, state in zip(
        events.t, events.guard, events.source, events.target, events.state, strict=True
    ):
        digest.update(f"{guard} {source} {target}".encode() + _bytes([t, *state]))
    digest.update(_bytes(run.final_state))
    return digest.hexdigest()


def _bytes(numbers: Any) -> bytes:
    values = np.asarray(numbers, dtype=float) + 0.0
    return struct.pack(f"<{values.size}d", *values)
