"""Chatter: the limit of ever shorter flights against walking through them, and against a closed form."""

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import trapezoid
from scipy.optimize import brentq

import frictionlab as fl
from frictionlab.automaton import Event, HybridAutomaton, Mode, Reset
from frictionlab.components import functions
from frictionlab.models import Friction, Mechanics

MATERIAL = fl.SliderOnBelt(mu_k=1.4)
STIFF = fl.SliderOnBelt(mu_k=1.0, F=800.0, k_nl=1e7, k4=5e6, k5=5e6, k6=5e6)

# The limit is exact in these motions, however long the flights that it replaces.
CRUDE = pytest.mark.filterwarnings("ignore:do not trust this run. flights below:RuntimeWarning")


def run_of(model, t_end, chatter):
    run = fl.simulate(model, t_end, method=fl.Taylor(chatter=chatter), progress=False)
    assert run.status is fl.Status.FINISHED
    return run


@pytest.mark.slow  # the next test has a walk that is shorter
def test_the_limit_is_what_the_walk_comes_to():
    """329,000 flights, down to what the clock resolves, against none."""
    walked, limit = run_of(STIFF, 0.0795, 0.0), run_of(STIFF, 0.0795, 1e-7)
    assert (len(walked.events), len(limit.events)) == (pytest.approx(329_000, rel=0.01), 15)
    times = np.array([0.069, 0.0691, 0.069115, 0.06911568])
    apart = np.abs(walked(times) - limit(times))
    assert apart[:, :5].max() < 1e-14
    # In flight the velocities are those of the limit up to the rate at which the slider leaves.
    rate = (limit(times)[:, 5] - limit(times)[:, 7]) * limit(times)[:, 4]
    assert (apart[:, 5:].max(axis=1) < rate + 1e-9).all()


def test_what_the_limit_leaves_out_goes_with_the_square_of_the_flights_length():
    """So a run with ten times the limit bounds the error: a 99th of the difference, state by state."""
    exact = run_of(MATERIAL, 2.0, 1e-7).final_state
    ends = [run_of(MATERIAL, 2.0, chatter).final_state for chatter in (1e-4, 1e-5, 1e-6)]
    errors = [np.abs(end - exact).max() for end in ends]
    assert errors[0] < 1e-4
    assert errors[1] < errors[0] / 30
    for coarse, fine, error in zip(ends, ends[1:], errors[1:]):
        assert error < np.abs(coarse - fine).max() / 99


def test_what_holds_in_chatter():
    run = run_of(MATERIAL, 2.0, 1e-5)
    t = np.linspace(0.0, 2.0, 20_001)
    entered = np.flatnonzero(run.events.target == "chatter")
    here = np.any([(t > run.events.t[i]) & (t < run.events.t[i + 1]) for i in entered], axis=0)
    assert here.sum() > 20
    x1, y1, x2, y2, phi, dx1, dy1, dx2, dy2, dphi = run(t[here]).T
    gap, gap_rate = y2 - (x1 - x2) * phi - y1, dy2 - (x1 - x2) * dphi - (dx1 - dx2) * phi - dy1
    assert np.abs(gap).max() < 1e-15
    assert np.abs(gap_rate).max() < 1e-12
    assert ((dx1 - dx2) * phi > 0).all()
    assert (run.output("normal_force", t[here]) > 0).all()
    assert (run.output("friction_force", t[here]) == 0).all()


def test_the_limits_normal_force_is_the_mean_of_the_impulses():
    """Over a stretch of the walk: sum of the impulses M dy1' over time."""
    walked, limit = run_of(MATERIAL, 0.5, 0.0), run_of(MATERIAL, 0.5, 1e-5)
    entered = np.flatnonzero(limit.events.target == "chatter")[0]
    begin, end = limit.events.t[entered], limit.events.t[entered + 1]
    i = np.flatnonzero((walked.events.t > begin - 1e-9) & (walked.events.t < end))
    impulses = (walked.events.state[i, 6] - walked.events.before[i, 6]) * MATERIAL.M
    t = np.linspace(begin, end, 2001)[1:-1]
    # The limit begins in the midst of an impact: with rate zero, half way between landing and leaving.
    force = trapezoid(limit.output("normal_force", t), t)
    assert impulses.sum() - impulses[0] / 2 == pytest.approx(force, rel=2e-3)


@pytest.mark.parametrize(
    "model",
    [
        MATERIAL.replace(impact=fl.PlasticImpact("full")),
        MATERIAL.replace(impact=fl.RestitutionImpact(e=0.5)),
        MATERIAL.replace(impact=fl.RestitutionImpact(e=1.0)),
        MATERIAL.without("geometry"),
        MATERIAL.without("nonsmooth"),
    ],
    ids=["full gap rate", "restitution", "elastic", "without geometry", "sliding only"],
)
def test_scenes_whose_impacts_do_not_throw_off_have_no_chatter(model):
    assert "chatter" not in model.automaton().names


def test_nobody_starts_in_chatter_and_no_fixed_step_enters_it():
    assert run_of(MATERIAL, 0.1, 1e-3).mode[0] == "slip+"
    run = fl.simulate(MATERIAL, 1.0, method=fl.RK4(step=1e-4), progress=False)
    assert "chatter" not in run.events.target


def bouncing(slow=1.0, gravity=10.0):
    """A ball on a floor that throws it off at the rate s, where s' = -slow: flights of 2 s/g."""
    y, v, s, chatter = sp.symbols("y v s chatter", real=True)
    thrown = Reset({v: s}, {y: 1})
    caught = Reset({v: sp.Integer(0)}, {y: 2})
    flight = Mode("flight", (v, -gravity, -slow), (Event("floor", y, (), thrown, caught),))
    ends = (
        Event("s", s, ("rest",), Reset(vanishing={y: 2})),
        Event("long", chatter * gravity - s, ("flight",), thrown),
    )
    limit = Mode("limit", (v, sp.Integer(0), -slow), ends, (y, v), limit=True)
    rest = Mode("rest", (v, sp.Integer(0), -slow), (), (y, v))
    return HybridAutomaton((y, v, s), (rest, flight, limit), {chatter: 0.0}, 1)


@CRUDE
@pytest.mark.plain_python
def test_any_automaton_may_have_a_limit_mode():
    """The flights end where s = 0, at t = 0.5, in the limit exactly."""
    run = fl.solve(bouncing(), 1.0, x0=[0.0, 0.5, 0.5], method=fl.Taylor(chatter=0.02), progress=False)
    assert run.status is fl.Status.FINISHED
    assert run.events.target.tolist()[-2:] == ["limit", "rest"]
    assert run.events.t[-1] == pytest.approx(0.5, abs=1e-15)
    assert run.stats["accumulations"] == 1


@pytest.mark.plain_python
def test_flights_that_grow_leave_the_limit():
    run = fl.solve(
        bouncing(slow=-0.1), 1.0, x0=[0.0, 0.05, 0.05], method=fl.Taylor(chatter=0.011), progress=False
    )
    assert run.events.target.tolist()[1] == "limit"
    left = np.flatnonzero(run.events.source == "limit")
    assert len(left) == 1
    # Where 2 s/g is twice the limit of 0.011 s.
    assert run.events.state[left[0], 2] == pytest.approx(0.11, abs=1e-14)
    assert run.events.target[left[0]] == "flight"


@CRUDE
@pytest.mark.plain_python
def test_an_accumulation_can_end_the_run():
    method = fl.Taylor(chatter=0.02, accumulation="raise")
    run = fl.solve(bouncing(), 1.0, x0=[0.0, 0.5, 0.5], method=method, progress=False)
    assert run.status is fl.Status.ACCUMULATED
    assert 0.0 < run.t[-1] < 0.5


@pytest.mark.slow
@pytest.mark.parametrize("name", ["DOP853", "LSODA"])
def test_an_independent_integrator_sees_the_same_chatter(name):
    """scipy's methods share equations and resets, and neither the series nor the root finding."""
    exact = fl.simulate(MATERIAL, 1.0, method=fl.Taylor(chatter=1e-6), progress=False)
    other = fl.simulate(MATERIAL, 1.0, method=fl.Scipy(name, chatter=1e-6), progress=False)
    assert other.events.target.tolist() == exact.events.target.tolist()
    assert np.abs(other.events.t - exact.events.t).max() < 1e-6
    assert np.abs(other.final_state - exact.final_state).max() < 1e-7


@fl.model
class DrivenOnSlope(fl.MechanicalModel):
    """A mass that slides down a slope without friction, under harmonic forces; F_N has no part along x."""

    Omega: float = fl.parameter(40.0, unit="rad/s", symbol="O", meaning="frequency", range=(1.0, 100.0))
    friction: fl.FrictionLaw = fl.Coulomb(mu_k=0.0, mu_s=0.0)
    impact: fl.ImpactLaw = fl.PlasticImpact()
    coordinates = ("x", "y")

    def mechanics(self, q, v):
        depth = q.y + 0.1 * q.x
        contact = Friction(1.0 - v.x, lambda d: 1e4 * d, self.friction, depth, (0, -1), self.impact)
        return Mechanics(
            kinetic=(v.x**2 + v.y**2) / 2,
            contacts=(contact,),
            loads={"x": 3.0 + 20.0 * functions.cos(q.phase), "y": 50.0 + 20.0 * functions.cos(q.phase)},
            frequency=self.Omega,
        )


@CRUDE
def test_chatter_goes_on_through_the_periods_of_a_force():
    """x' = -1 + 3 t + (20/Omega) sin(Omega t) throughout, and chatter ends where it comes to zero."""

    def speed(t):
        return -1.0 + 3.0 * t + 0.5 * np.sin(40.0 * t)

    times = np.linspace(0.0, 0.4, 4001)
    end = brentq(speed, *times[np.argmax(speed(times) > 0) + np.array([-1, 0])])
    run = fl.simulate(
        DrivenOnSlope(), 0.4, x0={"y": -1e-12, "x'": -1.0}, method=fl.Taylor(chatter=1e-2), progress=False
    )
    assert run.status is fl.Status.FINISHED
    limit = (run.events.source == "chatter") & (run.events.t < end + 1e-6)  # it comes again later
    assert run.events.guard[limit].tolist() == ["period", "leaving rate"]
    assert run.events.t[limit] == pytest.approx([2 * np.pi / 40.0, end], abs=1e-12)
    inside = np.linspace(run.events.t[run.events.target == "chatter"][0] + 1e-9, end - 1e-9, 50)
    x, y, dx, _, phase = run(inside).T
    assert np.abs(dx - speed(inside)).max() < 1e-13
    assert np.abs(y + 0.1 * x).max() < 1e-13
    assert phase == pytest.approx(40.0 * inside % (2 * np.pi), abs=1e-12)
    # The force closes the gap with b = 50 + 20 c + 0.1 (3 + 20 c) with c = cos(phase), and a = 1.
    force = 50.3 + 22.0 * np.cos(40.0 * inside)
    assert run.output("normal_force", inside) == pytest.approx(force, abs=1e-10)
