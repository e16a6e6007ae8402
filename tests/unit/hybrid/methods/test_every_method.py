"""What every method does alike: events, ends, caps, records; and methods of users are methods like others."""

from dataclasses import replace

import numpy as np
import pytest
import sympy as sp

import frictionlab as fl
from tests.helpers.cases import slow_but
from tests.helpers.laws import Undefined

X, V = sp.symbols("x v")
MODEL = fl.SliderOnBelt(mu_k=1.4).without("geometry")


class Heun(fl.OneStepMethod):
    """A user's method by its tableau."""

    name = "heun"
    tableau = fl.Tableau(stages=((), (1.0,)), weights=(0.5, 0.5))


class SlowHeun(fl.OneStepMethod):
    """The same by its steps."""

    name = "slow heun"

    def take_step(self, rates, z, h):
        first = rates(z)
        return z + h * (0.5 * (first + rates(z + h * first)))


class Simpson(fl.OneStepMethod):
    """Of order 3, with stages of several terms and weights over a divisor."""

    name = "simpson"
    tableau = fl.Tableau(stages=((), (0.5,), (-1.0, 2.0)), weights=(1.0, 4.0, 1.0), divisor=6.0)


ONE_STEP = [fl.RK4(step=1e-4), Heun(step=2.5e-5), SlowHeun(step=2.5e-5), Simpson(step=1e-4)]
METHODS = [fl.Taylor(), *ONE_STEP, *map(fl.Scipy, ("RK23", "RK45", "DOP853", "Radau", "BDF", "LSODA"))]
# Python functions are called a hundred thousand times in a run.
LONG = "slow heun", "RK23", "Radau", "BDF"
QUICK = [one for one in METHODS if getattr(one, "integrator", one.name) not in LONG]
every_method = pytest.mark.parametrize(
    "method", slow_but(QUICK, METHODS), ids=lambda m: getattr(m, "integrator", m.name)
)
every_one_step_method = pytest.mark.parametrize("method", ONE_STEP, ids=lambda m: m.name)


def ball():
    """A ball that rebounds with half its speed, from a height of 1 where g is 10."""
    bounce = fl.Reset({X: sp.S.Zero, V: -V / 2})
    flight = fl.Mode("flight", (V, sp.Integer(-10)), (fl.Event("floor", X, (), bounce),), (), {"height": X})
    return fl.HybridAutomaton((X, V), (flight,), {}, 1)


@every_method
def test_the_events_of_a_stick_slip_motion(method):
    exact = fl.simulate(MODEL, 0.15)
    run = fl.simulate(MODEL, 0.15, method=method)
    assert run.status is fl.Status.FINISHED
    assert run.t[-1] == 0.15
    assert len(exact.events) > 0
    assert run.events.target.tolist() == exact.events.target.tolist()
    error = 1e-5 if isinstance(method, fl.OneStepMethod) else 1e-6
    assert run.events.t == pytest.approx(exact.events.t, abs=error)
    assert run.final_state == pytest.approx(exact.final_state, abs=10 * error)


@every_method
def test_a_bouncing_ball(method):
    run = fl.solve(ball(), 1.2, x0=[1.0, 0.0], method=method)
    fall = np.sqrt(0.2)
    assert run.events.t == pytest.approx([fall, 2 * fall, 2.5 * fall], abs=1e-6)
    assert run.events.before[:, 1] == pytest.approx([-10 * fall, -5 * fall, -2.5 * fall], abs=1e-5)
    assert run.events.state[:, 1] == pytest.approx(-run.events.before[:, 1] / 2, abs=1e-15)


class Dropped(fl.MechanicalModel):
    """A ball falls by 1 m onto a floor below the origin; beside it rubs a body on a belt."""

    e: float = 0.0
    friction: fl.FrictionLaw | None = None
    coordinates = ("x", "y")

    def mechanics(self, q, v):
        stop = fl.Stop(q.y + 0.5, fl.RestitutionImpact(e=self.e))
        rubs = () if self.friction is None else (fl.Friction(0.3 - v.x, 1.0, self.friction),)
        kinetic, potential = (v.x**2 + v.y**2) / 2, 10 * q.y + 2 * q.x**2
        return fl.Mechanics(kinetic, potential, contacts=(stop, *rubs))


DROPPED = fl.model(Dropped)


@pytest.mark.parametrize("method", [fl.Taylor(), fl.RK4(step=1e-3), Heun(step=1e-3), fl.Scipy()])
@pytest.mark.parametrize("e", [0.0, 0.5])
def test_a_ball_comes_to_rest(method, e):
    """RK4 left the floor again and again, for as long as the rounding error of the distance hid it."""
    run = fl.simulate(DROPPED(e=e), 2.0, x0=[0.0, 0.5, 0.0, 0.0], method=method, progress=False)
    assert run.status.ok
    assert run.events.t[-1] == pytest.approx(np.sqrt(0.2) * (1 + 2 * e / (1 - e)), abs=1e-6)
    assert run.final_state[[1, 3]] == pytest.approx([-0.5, 0.0], abs=1e-15)


@fl.model
class Box(fl.MechanicalModel):
    """A box that falls on two corners: each impact turns it onto the other."""

    e: float = 0.5
    coordinates = ("y", "angle")

    def mechanics(self, q, v):
        law, height = fl.RestitutionImpact(e=self.e), q.y + 0.5
        stops = fl.Stop(height - q.angle, law), fl.Stop(height + q.angle, law)
        return fl.Mechanics((v.y**2 + v.angle**2 / 3) / 2, 10 * q.y, contacts=stops)


@pytest.mark.parametrize(
    "method", [fl.RK4(step=1e-3), *(fl.Scipy(name) for name in ("DOP853", "RK45", "LSODA"))]
)
@pytest.mark.parametrize("e", [0.0, 0.5])
def test_a_box_comes_to_rest_on_two_corners(method, e):
    """scipy's methods bounced for as long as the rounding error of the distance hid the accumulation."""
    exact, run = (
        fl.simulate(Box(e=e), 4.0, x0=[1.0, 0.1, 0.0, 0.0], method=one, progress=False)
        for one in (fl.Taylor(), replace(method, max_events=5000))
    )
    assert run.status is fl.Status.FINISHED
    assert run.final_state == pytest.approx([-0.5, 0.0, 0.0, 0.0], abs=1e-15)
    assert run.events.t[-1] == pytest.approx(exact.events.t[-1], abs=1e-6)


@pytest.mark.parametrize("e", [0.0, 0.5])
def test_a_ball_comes_to_rest_beside_elements_that_stick(e):
    """There modes are derived on demand."""
    model = DROPPED(e=e, friction=fl.Iwan(mu_k=0.4, k_t=30.0))
    exact, run = (
        fl.simulate(model, 4.0, x0=[0.2, 0.5, 0.0, 0.0], method=method, progress=False)
        for method in (fl.Taylor(), fl.RK4(step=1e-3))
    )
    assert run.status.ok
    assert run.final_state == pytest.approx(exact.final_state, abs=1e-9)


@fl.model
class BouncingPad(fl.MechanicalModel):
    """A pad that falls on a belt, with an impact of e = 0.7 before its spring takes over."""

    contact: fl.ContactLaw = fl.LinearContact(k2=400.0)
    friction: fl.FrictionLaw = fl.Coulomb(mu_k=0.3, mu_s=0.45)
    coordinates = ("x", "y")

    def mechanics(self, q, v):
        force, law = self.contact.force(-q.y), fl.FrictionalImpact(e=0.7, mu_i=0.2)
        pad = fl.Friction(0.3 - v.x, force, self.friction, penetration=-q.y, impact=law)
        potential = q.x**2 + 6 * q.y + (q.x - 0.3 * q.y) ** 2 / 2
        return fl.Mechanics((v.x**2 + 1.3 * v.y**2) / 2, potential, contacts=(pad,))


@pytest.mark.parametrize(
    ("contact", "friction"),
    [
        (fl.LinearContact(k2=400.0), fl.Coulomb(mu_k=0.3, mu_s=0.45)),
        (fl.LinearContact(k2=400.0), fl.Iwan(mu_k=0.4, k_t=40.0)),
        (fl.HertzContact(k_h=400.0), fl.Iwan(mu_k=0.4, k_t=40.0)),
    ],
)
def test_rk4_passes_over_flights_shorter_than_a_step(contact, friction):
    """Its rule for re-contact, the paper's, is of first order; the same steps by series are nearly exact.

    Iwan's states are at their limits, which are zero, where the pad lands.
    """

    class BySeries(fl.OneStepMethod):
        name, tableau = "by series", fl.RK4.tableau

    model, x0 = BouncingPad(contact=contact, friction=friction), [-0.2, 0.15, 0.5, -1.2]

    def end(method):
        run = fl.simulate(model, 3.0, x0=x0, method=method, progress=False)
        assert run.status.ok
        return run.final_state

    exact = end(fl.Taylor())
    methods = BySeries(step=1e-4), fl.RK4(step=4e-4), fl.RK4(step=2.5e-5)
    least, coarse, fine = (np.abs(end(method) - exact).max() for method in methods)
    assert 1e3 * least < fine < coarse / 8


@every_method
def test_the_record_has_no_gaps(method):
    run = fl.simulate(MODEL, 0.15, method=method)
    starts, lengths = run.raw.step_times.T
    assert starts + lengths == pytest.approx([*starts[1:], 0.15], abs=1e-15)
    assert np.isin(run.events.t, np.append(starts, 0.15)).all()


@every_method
def test_dense_output_is_that_of_the_state(method):
    run = fl.simulate(MODEL, 0.15, method=method)
    starts = run.raw.step_times[1:-1:7, 0]
    inside = starts[~np.isin(starts, run.events.t)]
    before = run(np.nextafter(inside, 0.0))  # in the step that ends there
    assert before == pytest.approx(run(inside), abs=1e-6)


@every_method
def test_the_caps_end_a_run(method):
    settings = {name: value for name, value in vars(method).items() if not name.startswith("max_")}
    few_steps, few_events = type(method)(**settings, max_steps=5), type(method)(**settings, max_events=1)
    assert fl.simulate(MODEL, 5.0, method=few_steps).status is fl.Status.STEP_CAP
    run = fl.simulate(MODEL, 5.0, method=few_events)
    assert run.status is fl.Status.EVENT_CAP
    assert len(run.events) == 1


@every_method
def test_a_motion_without_end_in_the_numbers_is_not_finite(method):
    explosion = fl.HybridAutomaton((X,), (fl.Mode("up", (sp.exp(X),)),))
    run = fl.solve(explosion, 2.0, x0=[0.0], method=method)  # x is infinite at t = 1
    assert run.status in (fl.Status.NOT_FINITE, fl.Status.STALLED)


@every_method
@pytest.mark.parametrize("limit", [0.0, 1.5])
def test_a_law_that_is_no_number_ends_the_run(method, limit):
    """At a relative speed of 2; nothing of it is in the result."""
    model = fl.MassOnBelt(friction=Undefined(mu_k=0.3, mu_s=0.5, limit=limit), v=1.0)
    run = fl.simulate(model, 20.0, x0=[0.5, -1.0], method=method)
    assert run.status is fl.Status.NOT_FINITE
    assert run.final_state.tolist() == [0.5, -1.0]


@every_method
def test_a_run_is_saved_with_the_methods_settings(method, tmp_path):
    run = fl.simulate(MODEL, 0.05, method=method)
    again = fl.load(run.save(tmp_path / "run.npz"))
    assert again.final_state.tolist() == run.final_state.tolist()
    assert again.description == run.description


@every_one_step_method
def test_the_error_falls_with_the_order_of_the_method(method):
    order = {"rk4": 4, "simpson": 3}.get(method.name, 2)
    pendulum = fl.HybridAutomaton((X, V), (fl.Mode("only", (V, -sp.sin(X))),), {}, 1)
    exact = fl.solve(pendulum, 2.0, x0=[1.0, 0.0]).final_state
    errors = [
        np.abs(fl.solve(pendulum, 2.0, x0=[1.0, 0.0], method=type(method)(step=h)).final_state - exact).max()
        for h in (0.05, 0.025)
    ]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.2)


@every_one_step_method
def test_steps_end_on_the_grid_and_at_events(method):
    run = fl.simulate(MODEL, 0.15, method=method)
    cells = round(0.15 / method.step)
    grid = np.arange(cells) * method.step
    starts = run.raw.step_times[:, 0]
    off_grid = starts[~np.isin(starts, grid)]
    assert off_grid.tolist() == run.events.t.tolist()
    assert run.stats["steps"] == cells + len(run.events)


def test_a_tableau_and_its_steps_are_one_method():
    one, other = (fl.simulate(MODEL, 0.15, method=method(step=1e-4)) for method in (Heun, SlowHeun))
    np.testing.assert_array_equal(one.events.t, other.events.t)
    np.testing.assert_array_equal(one.final_state, other.final_state)


@pytest.mark.parametrize("stages", [((),), ((0.5,), (1.0,)), ((), (0.5, 0.5))])
def test_a_tableau_that_is_not_explicit_is_refused(stages):
    class Wrong(fl.OneStepMethod):
        name = "wrong"
        tableau = fl.Tableau(stages=stages, weights=(0.5, 0.5))

    with pytest.raises(ValueError, match="a row for each weight"):
        Wrong()
