"""`verify` is told wrong motions: all methods share the wrong automaton, or the run alone is wrong.

Each model states a mechanism; its automaton is the right one, or one with a fault that the package has had.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import mpmath
import numpy as np
import pytest
import sympy as sp

import frictionlab as fl
from frictionlab import Event, HybridAutomaton, Mode, Reset
from frictionlab.analysis.independent_method import IndependentMethod
from frictionlab.analysis.stated_conditions import broken_statement
from frictionlab.analysis.verify import RunSetup, verification_of
from frictionlab.hybrid.problem import Problem
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.models import Friction, MechanicalModel, Mechanics
from frictionlab.models.mechanical.mechanics import Stop
from frictionlab.models.symbols import symbol
from frictionlab.tape.packing import program_of
from tests.helpers.cases import slow_but

QUIET = {"progress": False}


@fl.model
class Faulty(MechanicalModel):
    """A model whose automaton may have a fault."""

    fault: str = ""

    def derive(self):
        """The automaton, each mode with the fault."""
        whole = super().derive()
        if not self.fault:
            return whole
        modes = tuple(FAULTS[self.fault](mode) for mode in whole.modes)
        return HybridAutomaton(whole.states, modes, {}, whole.coordinates)


def model(*coordinates, start):
    """Decorates a function of q and v that gives the mechanics: the model's class, with where it starts."""

    def made(mechanics):
        names = {
            "coordinates": coordinates,
            "mechanics": lambda self, q, v: mechanics(q, v),
            "__doc__": mechanics.__doc__,
            "__module__": __name__,
            "__qualname__": mechanics.__name__,
        }
        kind = type(mechanics.__name__, (Faulty,), names)
        return fl.model(kind), start

    return made


def sin(x):
    return fl.functions.sin(x)


def cos(x):
    return fl.functions.cos(x)


@model("x", "y", start={"x'": 1.0, "y": 1.0})
def corrugated(q, v):
    """A ball on corrugated ground."""
    ground = Stop(q.y - cos(20 * q.x) / 10, fl.RestitutionImpact(e=0.8))
    return Mechanics((v.x**2 + v.y**2) / 2, 9.81 * q.y, contacts=(ground,))


@model("x", start={"x": 1.0})
def washer(q, v):
    """A mass that changes with time, on a spring."""
    return Mechanics((1 + 0.3 * cos(q.phase)) * v.x**2 / 2, q.x**2 / 2, frequency=2.0)


@model("x", start={"x'": 1.0})
def crank(q, v):
    """A flywheel whose crank moves a slider that rubs a little: it stands still at each dead centre."""
    return Mechanics(v.x**2 / 2, contacts=(Friction(cos(q.x) * v.x, 1.0, fl.Coulomb(1e-3, 1e-3)),))


@model("x", start={})
def pads(q, v):
    """A block between two equal pads under a load that changes slowly."""
    pad = [Friction(-v.x, 1.0, fl.Coulomb(0.1, 0.4)) for _ in range(2)]
    return Mechanics(v.x**2 / 2, q.x**2 / 8, v.x**2 / 20, tuple(pad), {"x": sin(q.phase)}, frequency=0.2)


@model("a", "b", "c", start={"a'": 1.0, "a": -0.5})
def cradle(q, v):
    """Three balls, of which two touch."""
    stops = [Stop(one, fl.RestitutionImpact(e=1.0)) for one in (q.b - q.a, q.c - q.b)]
    return Mechanics((v.a**2 + v.b**2 + v.c**2) / 2, contacts=tuple(stops))


@model("x", start={"x": 1.0})
def clapper(q, v):
    """A mass on a spring that hits a stop."""
    return Mechanics(v.x**2 / 2, q.x**2 / 2, contacts=(Stop(q.x + 0.2, fl.RestitutionImpact(e=0.7)),))


@model("x", "y", start={"y": -1.0})
def damped(q, v):
    """A ball that falls on a belt with a damper."""
    contact = Friction(1 - v.x, 100 * q.y + 6 * v.y, fl.Coulomb(0.1, 0.2), penetration=q.y)
    return Mechanics((v.x**2 + v.y**2) / 2, -9.81 * q.y, contacts=(contact,))


@model("x", start={})
def unloaded(q, v):
    """A block whose normal force comes to zero."""
    pressing = 1 + 0.5 * q.x
    return Mechanics(v.x**2 / 2, q.x**2 / 20, 0, (Friction(-1 - v.x, pressing, fl.Coulomb(0.6, 0.7)),), {})


@model("x", start={})
def sliding(q, v):
    """A block on a belt, sliding only."""
    rub = Friction(0.5 - v.x, 1.0, fl.Coulomb(0.3, 0.5), interface=fl.SlidingOnly())
    return Mechanics(v.x**2 / 2, q.x**2 / 2, contacts=(rub,))


@model("x", start={})
def block(q, v):
    """A block on a belt."""
    return Mechanics(v.x**2 / 2, q.x**2 / 2, contacts=(Friction(0.5 - v.x, 1.0, fl.Coulomb(0.3, 0.6)),))


@model("x", "y", start={"x'": 1.0, "y'": 0.5})
def puck(q, v):
    """A puck on an inclined plane."""
    rub = Friction((-v.x, -v.y), 1.0, fl.Coulomb(0.3, 0.4))
    return Mechanics((v.x**2 + v.y**2) / 2, -q.x / 10, contacts=(rub,))


def with_flow(mode, name, rate):
    """The mode with another rate, as a function of the old one, of a coordinate's velocity."""
    velocities = 1 if len(mode.flow) < 4 else 2
    place = velocities + "xy".index(name)
    return replace(mode, flow=(*mode.flow[:place], rate(mode.flow[place]), *mode.flow[place + 1 :]))


def with_events(mode, change):
    """The mode with changed events; without those that become None."""
    events = (change(event) for event in mode.events)
    return replace(mode, events=tuple(event for event in events if event is not None))


x, y, phase, x_rate = map(symbol, ("x", "y", "phase", "x'"))


def deleted(event):
    """The event that deletes the whole velocity where v_r comes to zero."""
    if not event.name.startswith("v_r"):
        return event
    return replace(event, reset=Reset({x_rate: sp.S.Zero}), targets=("stick",))


def early(event):
    """The event that ends stick at the limit of one pad of two."""
    return replace(event, function=event.function - 0.4) if event.name.startswith("cone") else event


def weak(event):
    """The event that ends stick at two thirds of the limit."""
    return replace(event, function=event.function - 0.2) if event.name.startswith("cone") else event


def abrupt(event):
    """The event at which slip ends before v_r is zero."""
    return replace(event, function=event.function - 0.1) if event.name == "stop" else event


def closing(event):
    """The event with the plastic reset."""
    return event if event.accumulation is None else replace(event, reset=event.accumulation)


def creeping(mode):
    """Stick in which the block accelerates."""
    if mode.name != "stick":
        return mode
    return replace(with_flow(mode, "x", lambda a: a + sp.Rational(1, 100)), constraints=())


FAULTS = {
    "flat": lambda mode: with_events(mode, lambda e: replace(e, function=y) if e.name == "impact" else e),
    "no impact": lambda mode: with_events(mode, lambda e: None if e.name == "impact" else e),
    "no phase": lambda mode: with_flow(mode, "x", lambda a: -x / (1 + 0.3 * sp.cos(phase))),
    "dead": lambda mode: with_events(mode, deleted),
    "early": lambda mode: with_events(mode, early),
    "weak": lambda mode: with_events(mode, weak),
    "abrupt": lambda mode: with_events(mode, abrupt),
    "plastic": lambda mode: with_events(mode, closing),
    "pulls": lambda mode: with_events(mode, lambda e: None if e.name == "F_N" else e),
    "frictionless": lambda mode: with_flow(mode, "x", lambda a: -x),
    "drives": lambda mode: with_flow(mode, "x", lambda a: -2 * x - a) if "slip" in mode.name else mode,
    "creeps": creeping,
}


@cache
def verified(right, start):
    """What is said of a model without a fault, of which several may have one."""
    return str(fl.verify(right, 12.0, x0=dict(start) or "rest", **QUIET))


@pytest.mark.parametrize(
    ("made", "fault", "words"),
    [
        pytest.param(
            corrugated, "flat", "velocities jump where no contact is closed", marks=pytest.mark.slow
        ),
        (clapper, "no impact", "bodies overlap in flight at contact 1"),
        (washer, "no phase", "Lagrange's equation of 'x' is not kept"),
        (crank, "dead", "the reset of event 'v_r' takes away"),
        (pads, "early", "leaves stick, though static friction holds it"),
        (puck, "abrupt", "velocities jump where no contact is closed"),
        (cradle, "plastic", "an elastic impact takes the energy"),
        (clapper, "plastic", "an impact of contact 1 is not that of its law"),
        (damped, "pulls", "the normal force pulls at contact 1"),
        (unloaded, "pulls", "the normal force pulls at contact 1"),
        (sliding, "frictionless", "Lagrange's equation of 'x' is not kept"),
        (block, "drives", "Lagrange's equation of 'x' is not kept"),
        (block, "creeps", "v_r is not zero in stick at contact 1"),
    ],
    ids=lambda one: one if isinstance(one, str) else one[0].__name__,
)
def test_motions_that_the_statement_forbids(made, fault, words):
    kind, start = made
    assert verified(kind(), tuple(start.items())).startswith(("All three runs", "The runs")), "right"
    found = fl.verify(kind(fault=fault), 12.0, x0=start or "rest", **QUIET)
    assert not found.ok
    assert words in str(found)


def test_stick_that_is_left_too_early_for_an_instant_of_another_slip():
    run = fl.simulate(block[0](fault="weak"), 6.0, x0={"x'": 0.5}, **QUIET)
    raw, slip = run.raw, {name: run.mode_names.index(name) for name in ("slip+", "slip-")}
    leaves, ends = 0, list(run.problem.program.guard_modes).index(slip["slip-"])
    raw = raw._replace(
        event_times=raw.event_times[[0, 0]],
        event_states=raw.event_states[[0, 0]],
        event_codes=np.array([[leaves, slip["slip-"], 0], [ends, slip["slip+"], 0]]),
    )
    about = {"description": run.description, "source": run.source}
    twice = Trajectory(run.automaton, run.problem, raw, run.samples, **about)
    assert twice.events.target.tolist() == ["slip-", "slip+"]
    assert "leaves stick, though static friction" in broken_statement(twice)


X, U, W = sp.symbols("x u w")
FIFTH = sp.Rational(1, 5)


def as_run_of(law, run, raw=None):
    """A run, as if it were one of another automaton with the same modes."""
    problem = Problem(*program_of(law), run.problem.x0, run.problem.t_end)
    return Trajectory(law, problem, raw or run.raw, run.samples, description=run.description)


def judged(law, run):
    """The verdict on a run of a law."""
    return verification_of(run, RunSetup(law, run.problem.x0, run.raw.t, False), fl.Taylor())


def walk(guard, rate=FIFTH):
    """x' = 1/5 up to where a guard is zero."""
    return HybridAutomaton(
        (X,), (Mode("go", (rate,), (Event("peak", guard, ("end",)),)), Mode("end", (0 * X,)))
    )


@pytest.mark.parametrize("t_end", [10.0, 1e6])
def test_an_event_of_8_ms_that_a_run_steps_over(t_end):
    guard = sp.Rational(1, 2) - sp.exp(-((1000 * (X - sp.Rational(2, 5))) ** 2))
    blind = fl.solve(walk(sp.S.One), t_end, x0=[0.0], **QUIET)
    found = judged(walk(guard), as_run_of(walk(guard), blind))
    assert not found.ok
    first = 2.0 - 5e-3 * np.sqrt(np.log(2.0))
    assert f"event 'peak' of mode 'go' is missed: at t = {first:.6g} s" in str(found)


def test_a_layer_of_friction_that_a_run_steps_over():
    """x = t passes the layer of 1e-4 in one step; so small an error is in no comparison of runs."""
    force = sp.Rational(3, 10) * (X * 10**4) ** sp.Rational(9, 10) * sp.exp(-X * 10**4)
    blind = fl.solve(walk(1 + X, sp.S.One), 1.0, x0=[0.0], **QUIET)
    law = walk(1 + X, 1 - force)
    assert judged(law, fl.solve(law, 1.0, x0=[0.0], **QUIET)).ok
    found = judged(law, as_run_of(law, blind))
    assert found.error < 1e-4
    assert "a step in mode 'go' does not keep the rate of 'x'" in str(found)


def test_vector_friction_that_goes_on_past_the_stop():
    """A unit mass slides with 1 m/s against a deceleration of 1/2 m/s^2, and stops after 2 s."""
    size = sp.sqrt(U**2 + W**2)
    stop = Event("stop", U**2 + W**2 - sp.Rational(1, 10**12), ("rest",), Reset({U: sp.S.Zero, W: sp.S.Zero}))
    slide = Mode("slide", (-U / size / 2, -W / size / 2), (stop,))
    law = HybridAutomaton((U, W), (slide, Mode("rest", (0 * U, 0 * U))))
    run = fl.solve(law, 1.0, x0=[0.6, 0.8], **QUIET)
    assert judged(law, run).ok
    raw = run.raw._replace(
        step_times=np.array([[0.0, 2.29]]),
        step_modes=run.raw.step_modes[:1],
        step_states=run.raw.step_states[:1],
    )
    raw = raw._replace(t=2.29, state=np.array([0.6, 0.8]) * (1 - 2.29 / 2))
    found = judged(law, as_run_of(law, run, raw))
    assert not found.ok
    assert "a step in mode 'slide' does not keep the rate of 'w'" in str(found)


@pytest.mark.parametrize("t_end", [3.0, 1e6])
def test_the_independent_method_finds_its_own_events(t_end):
    """A guard that is below zero for 1 ms; the zero is that of 1 - x = 0.9 exp(-(1000 (x - 0.4))^2)."""
    guard = 1 - X - sp.Rational(9, 10) * sp.exp(-((1000 * (X - sp.Rational(2, 5))) ** 2))
    method = IndependentMethod("DOP853", 1e-12, 1e-14)
    run = fl.solve(walk(guard), t_end, x0=[0.0], method=method, **QUIET)
    exact = float(sp.nsolve(guard, X, (0.39935, 0.3994), solver="bisect")) * 5
    assert run.events.t == pytest.approx([exact], abs=1e-12)


def test_the_independent_method_finds_all_of_many_events():
    """sin(100 pi q) with q = t: each 1/100 s."""
    wave = sp.sin(100 * sp.pi * X)
    modes = [
        Mode(one, (sp.S.One,), (Event("turn", f, (two,)),))
        for one, f, two in (("+", wave, "-"), ("-", -wave, "+"))
    ]
    run = fl.solve(HybridAutomaton((X,), tuple(modes)), 1.005, x0=[1e-3], method=IndependentMethod(), **QUIET)
    assert run.events.t == pytest.approx(np.arange(1, 101) / 100 - 1e-3, abs=1e-12)


@pytest.mark.parametrize("height", slow_but([0.01], [0.9, 0.01]))
def test_the_independent_method_passes_over_no_layer(height):
    """x' = 1 - p(x), p = height exp(-(10^4 (x - 1))^2), is late by the integral of p/(1 - p)."""
    layer = height * sp.exp(-((10**4 * (X - 1)) ** 2))
    method = IndependentMethod("DOP853", 1e-12, 1e-13)
    run = fl.solve(walk(2 - X, 1 - layer), 9.0, x0=[0.0], method=method, **QUIET)

    def lost(s):
        part = height * mpmath.exp(-(s**2))
        return part / (1 - part)

    with mpmath.workdps(30):
        late = mpmath.quad(lost, [-9, -3, 0, 3, 9])
    assert run.events.t == pytest.approx([2.0 + float(late) * 1e-4], abs=1e-10)
