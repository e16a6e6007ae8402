"""`fl.verify`: good runs, chaotic ones, wrong ones, pile-ups; and the warning of a steady state."""

import math
import re
import sys
from dataclasses import replace

import numpy as np
import pytest
import sympy as sp

import frictionlab as fl
from frictionlab.analysis import run_conditions, stated_conditions
from frictionlab.analysis.run_comparison import ModeStays, first_event_difference
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.widgets.front_end import run_text
from tests.doors.generate import generate
from tests.doors.mechanism import model_of
from tests.helpers.automata import V, X, automaton
from tests.helpers.known_motions import logistic

A = fl.SliderOnBelt(mu_k=1.4).without("geometry")


@pytest.mark.slow
@pytest.mark.parametrize("row", tuple(fl.list_models()), ids=lambda row: row.call)
def test_runs_of_every_model_are_sound(row):
    names = {name: getattr(fl, name) for name in fl.__all__}
    found = fl.verify(eval(row.call, {"fl": fl, **names}), 3.0)
    assert found.ok, str(found)
    assert found.events_agree
    assert found.error < 1e-9  # what DOP853 at 1e-12 adds up in 3 s
    assert found.until == 3.0
    assert found.defect == found.run.defect


def test_a_good_run_in_a_sentence():
    found = fl.verify(A, 0.4, progress=False)
    assert found.independent_until == 0.4
    assert str(found).startswith("All three runs agree to ")
    assert str(found).endswith("of the motion's size over 0.4 s, with the same 18 events.")  # as by 40 digits
    assert len(found.run.events) == 18
    assert found.run.source == A


@pytest.mark.slow
def test_what_was_not_looked_at_is_said(monkeypatch):
    monkeypatch.setattr(run_conditions, "MOST_STEPS", 100)
    found = fl.verify(A, 1.0, progress=False)
    (some, all_) = map(int, re.search(r"were bounded in (\d+) of (\d+) steps", str(found)).groups())
    assert 50 <= some <= 100 < all_ == len(found.run.raw.step_modes)
    monkeypatch.setattr(stated_conditions, "MOST_COORDINATES", 1)
    said = str(fl.verify(A, 0.1, progress=False))
    assert said.endswith("Lagrange's equations were not compared: there are more than 1 coordinates.")


def test_the_independent_method_takes_a_bounded_number_of_steps_however_many_the_run_has(monkeypatch):
    monkeypatch.setattr(sys.modules[fl.verify.__module__], "INDEPENDENT_STEPS", 50)
    found = fl.verify(A, 0.4, progress=False)
    assert str(found).endswith(f"up to t = {found.independent_until:.4g} s, where it had taken 50 steps.")


def test_chaos_is_told_from_error():
    """Errors of the logistic ball double each second in the mean: a billionth is a thousandth after 20 s."""
    found = fl.verify(logistic(4.0), 60.0, x0=[0.3, 0.1], progress=False)
    assert found.ok
    assert found.until == pytest.approx(math.log2(1e6), abs=4)
    assert found.error < 1e-6
    assert "cannot be predicted" in str(found)
    assert found.independent_until < found.until  # errors of the independent method double as well
    assert "where errors of its size have grown too large" in str(found)


@pytest.mark.slow
def test_bumps_of_friction_that_are_small_beside_other_forces():
    """Each passes within a step of the independent method, which agrees to its tolerance all the same."""
    one = generate(11, 109)
    found = fl.verify(model_of(one), 10 * one.period, x0=one.x0, progress=False)
    assert found.ok
    assert found.error < 1e-9


@pytest.mark.parametrize(
    "method", [fl.RK4(step=5e-3), pytest.param(fl.Taylor(tol=1e-3), marks=pytest.mark.slow)]
)
def test_a_wrong_run_is_not_to_be_trusted(method):
    found = fl.verify(A, 0.5, method=method, progress=False)
    exact = fl.simulate(A, 0.5, progress=False)
    t = np.linspace(0.0, 0.5, 1000)
    assert np.abs(found.run(t) - exact(t)).max() > 1e-5  # m: it really is wrong
    assert not found.ok
    assert str(found).startswith("Do not trust this run: ")


@pytest.mark.slow
@pytest.mark.parametrize("method", ["RK45", fl.RK4(step=2e-4)])
def test_other_methods_that_do_well(method):
    found = fl.verify(A, 0.25, method=method, progress=False)
    assert found.ok
    assert 1e-12 < found.error < 1e-5


@pytest.mark.slow
def test_chatter_gives_no_false_alarm():
    found = fl.verify(fl.SliderOnBelt(mu_k=1.4), 5.0, progress=False)
    assert found.ok
    assert found.until == 5.0
    first = found.run.events.t[found.run.events.closed][0]
    assert 0.0 < found.independent_until < first
    assert "at a Zeno accumulation of events" in str(found)


def test_an_automaton_and_a_law_of_ones_own():
    spring = automaton(fl.Mode("on", (V, -X - X**3 - sp.tanh(20 * V))))
    found = fl.verify(spring, 10.0, x0=[1.0, 0.0])
    assert found.ok
    assert str(found).endswith("over 10 s, without an event.")
    assert fl.verify(spring, 10.0).ok  # from rest, where nothing happens


@fl.model
class BlockOnFeet(fl.MechanicalModel):
    """A block on two feet that a spring draws: one more holds than there are freedoms."""

    a: float = 0.5
    k: float = 1.0
    friction: fl.FrictionLaw = fl.Coulomb(mu_k=0.3, mu_s=0.6)
    impact: fl.ImpactLaw = fl.FrictionalImpact(e=0.0, mu_i=0.3)
    coordinates = ("x", "y", "theta")

    def mechanics(self, q, v):
        lever = self.a * fl.functions.sin(q.theta)
        feet = tuple(
            fl.Stop(
                q.y + side * lever,
                self.impact,
                friction=self.friction,
                relative_velocity=side * lever * v.theta - v.x,
            )
            for side in (1, -1)
        )
        kinetic = (v.x**2 + v.y**2 + 0.1 * v.theta**2) / 2
        return fl.Mechanics(kinetic, 9.81 * q.y + self.k * (q.x - q.t) ** 2 / 2, contacts=feet)


@pytest.mark.parametrize("t_end", [4.0, 12.0])
def test_a_block_at_rest_on_two_feet_gives_no_false_alarm(t_end):
    found = fl.verify(BlockOnFeet(), t_end, progress=False)
    assert found.ok, str(found)
    begins = found.run.events.t[found.run.events.target == "slip- | slip-"]
    assert begins == pytest.approx([0.6 * 9.81] if t_end > 6.0 else [], rel=1e-12)  # mu_s m g/(k u)


@fl.model
class ShakenBlock(BlockOnFeet):
    """The block on ground that vibrates by 0.02 m."""

    def mechanics(self, q, v):
        about, ground = super().mechanics(q, v), 0.02 * fl.functions.sin(q.phase)
        feet = tuple(replace(foot, distance=foot.distance - ground) for foot in about.contacts)
        return replace(about, contacts=feet, frequency=10.0)


@pytest.mark.parametrize("x0", ["rest", {"y": 0.3, "theta": 0.27, "x'": -0.7}], ids=str)
def test_it_is_no_difference_which_of_two_feet_holds_a_block(x0):
    found = fl.verify(ShakenBlock(k=0.0, e=0.5), 2.0, x0=x0, progress=False)
    assert found.ok, str(found)
    assert found.events_agree


@fl.model
class TwoLaws(fl.MechanicalModel):
    """Two masses on a belt, held by an element of Jenkins' and by Dahl's bristles."""

    v: float = 1.0
    N: float = 10.0
    coordinates = ("x", "y")
    period = 4.0

    def mechanics(self, q, v):
        held = self.N + 2 * fl.functions.sin(q.x)
        return fl.Mechanics(
            (v.x**2 + v.y**2) / 2,
            q.x**2 + (q.x - q.y) ** 2 / 2,
            contacts=(
                fl.Friction(self.v - v.x, held, fl.Jenkins(mu_k=0.4, k_t=30.0)),
                fl.Friction(self.v - v.y, self.N, fl.Dahl(mu_k=0.3, sigma_0=1e4)),
            ),
        )


def test_directions_of_slow_slip_are_told_apart_in_the_independent_run_too():
    found = fl.verify(TwoLaws(), 0.35, x0={"x'": -0.3, "y'": 1 - 1e-5}, progress=False)
    assert found.ok, str(found)
    assert {"slip+ | slip+", "slip+ | slip-"} <= {*found.run.events.target}


def test_events_of_a_mass_that_rounding_errors_alone_move_do_not_count():
    resting = fl.MassOnBelt(friction=fl.LuGre(), v=0.0)
    found = fl.verify(resting, 6.0, x0={"x": -0.1}, progress=False)
    assert found.ok, str(found)
    assert 3.0 < found.independent_until < 4.5  # the decay of the bristles' vibration to a share of 1e-8
    assert str(found).endswith("from where on nothing moves.")


@fl.model
class RotorInStator(fl.MechanicalModel):
    """A rotor that rubs along a stator: its v_r is 0/0 in the centre."""

    Omega: float = 115.0
    friction: fl.FrictionLaw = fl.Coulomb(mu_k=0.12, mu_s=0.12)
    interface = fl.SlidingSeparation()
    coordinates = ("x", "y")

    def mechanics(self, q, v):
        r = fl.functions.sqrt(q.x**2 + q.y**2)
        v_r = 0.02 * self.Omega + (q.x * v.y - q.y * v.x) / r
        rim = fl.Friction(v_r, lambda d: 2e5 * d, self.friction, penetration=r - 3e-4)
        springs, dampers = 1e4 * (q.x**2 + q.y**2) / 2, 15.0 * (v.x**2 + v.y**2) / 2
        return fl.Mechanics((v.x**2 + v.y**2) / 2, springs, dampers, contacts=(rim,))


def test_friction_along_a_rim_gives_no_false_alarm():
    start = [1e-4, -2e-4, 0.04, 0.02]
    run = fl.simulate(RotorInStator(), 0.02, x0=start, progress=False)
    assert run.time_in_mode["slip"] > 0.0
    assert fl.verify(RotorInStator(), 0.02, x0=start, progress=False).ok


def test_a_run_that_ends_early_says_so():
    found = fl.verify(fl.MassOnBelt(), 50.0, method=fl.Taylor(max_steps=10), progress=False)
    assert found.until == found.run.raw.t < 50.0
    assert "There the run ended: step cap" in str(found)


def test_an_impact_counts_where_series_of_the_independent_method_diverge():
    """The force is steep at the start, within a step of DOP853."""
    t = sp.Symbol("t", real=True)
    flow = V, -1 - sp.sqrt(t + sp.Float(1e-6)) / 10, sp.S.One
    bounce = fl.Event("gap", X, ("fly",), fl.Reset({V: -V / 2}, {X: 1}))
    ball = automaton(fl.Mode("fly", flow, (bounce,)), states=(X, V, t))
    found = fl.verify(ball, 2.5, x0=[1.0, 0.0, 0.0], progress=False)
    assert found.ok
    assert found.events_agree
    assert len(found.run.events) == 1


def test_two_missing_events_are_noticed_though_all_others_look_alike():
    """Slip, stick, slip, stick by turns: without a pair in the middle the modes are still those."""
    t = np.arange(1.0, 9.0)
    modes = np.array(["stick", "slip"] * 4)
    closed = np.zeros(8, dtype=bool)
    all_ = ModeStays(t, t, modes, closed)
    kept = np.array([0, 1, 2, 5, 6, 7])
    fewer = ModeStays(t[kept], t[kept], modes[[0, 1, 2, 3, 4, 5]], closed[kept])
    assert first_event_difference(all_, fewer, 10.0, 1e-3) == 4.0
    assert first_event_difference(all_, all_, 10.0, 1e-3) == math.inf


def with_longer_steps(run):
    """The run as if each four of its steps had been one: its series do not reach so far."""
    raw = run.raw
    starts = raw.step_times[::4, 0]
    times = np.column_stack([starts, np.diff(starts, append=raw.t)])
    raw = raw._replace(step_times=times, step_modes=raw.step_modes[::4], step_states=raw.step_states[::4])
    return Trajectory(run.automaton, run.problem, raw, run.samples, description=run.description)


def test_steps_beyond_the_reach_of_a_series_are_warned_of():
    sharp = automaton(fl.Mode("on", (V, -X - 0.1 * V - sp.tanh((X - 0.5) * 100))))
    run = fl.solve(sharp, 5.0, x0=[2.0, 0.0], progress=False)
    assert run.warning is None
    assert "steps in mode 'on' are wrong by up to" in str(with_longer_steps(run).warning)


def test_a_steady_state_carries_the_warning():
    state = fl.steady_state(A, transient=1.0, window=2.0, progress=False)
    assert state.warning is None
    sharp = automaton(fl.Mode("on", (V, -X - 0.1 * V - sp.tanh((X - 0.5) * 100))))
    state = fl.steady_state(sharp, [2.0, 0.0], transient=0.0, window=5.0, progress=False)
    assert state.warning is None
    bad = replace(state, trajectory=with_longer_steps(state.trajectory))
    assert bad.warning == bad.trajectory.warning
    assert bad.warning is not None


def test_an_explorer_and_a_bifurcation_pass_it_on():
    sharp = automaton(fl.Mode("on", (V, -X - 0.1 * V - sp.tanh((X - 0.5) * 100))))
    run = fl.solve(sharp, 5.0, x0=[2.0, 0.0], progress=False)
    assert run_text(run).startswith("The end was reached")
    said = run_text(with_longer_steps(run))
    assert said.startswith("Do not trust this picture: steps in mode")
    settings = {"transient": 1.0, "window": 1.0, "progress": False}
    found = fl.bifurcation(A, "mu_k", [0.2, 1.4], **settings)
    assert found.warnings == (None, None)
    results = {**found.results, 1: {**found.results[1], "warning": "steps are wrong"}}
    assert replace(found, results=results).warnings == (None, "steps are wrong")


@pytest.mark.parametrize("scale", [{"v": 2e9}, {"m": 1e9, "k": 2.0}])
def test_rest_at_an_equilibrium_is_trusted_whatever_its_scales(scale):
    """A belt far faster than the mass is displaced; a mass so slow that 1e-9 m/s would lead elsewhere."""
    model = fl.MassOnBelt(**scale)
    verified = fl.verify(model, 1e5, x0=[*fl.equilibrium(model).q, 0.0], progress=False)
    assert verified.ok, verified.verdict
    assert verified.until == 1e5
