"""Friction in the plane: stops where closed forms say, and what an integration that shares no code gives."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import frictionlab as fl
from tests.reference.phases import until_events


@fl.model
class Puck(fl.MechanicalModel):
    """A puck on a plane that is inclined by alpha; x is downhill."""

    m: float = 2.0
    g: float = 9.81
    alpha: float = 0.0
    friction: fl.FrictionLaw = fl.Coulomb(mu_k=0.3, mu_s=0.4)
    coordinates = ("x", "y")

    def mechanics(self, q, v):
        weight = self.m * self.g
        rubbing = fl.Friction((-v.x, -v.y), weight * fl.functions.cos(self.alpha), self.friction)
        return fl.Mechanics(
            self.m * (v.x**2 + v.y**2) / 2,
            -weight * fl.functions.sin(self.alpha) * q.x,
            contacts=(rubbing,),
        )


@fl.model
class Coupled(fl.MechanicalModel):
    """A mass on springs, of which one is oblique, on a belt that runs obliquely, with a pull across."""

    m: float = 1.0
    v: float = 0.2
    w: float = 0.0
    f: float = 0.1
    scale: float = 1.0  # of mass and force
    friction: fl.FrictionLaw = fl.Coulomb(mu_k=0.5, mu_s=1.0)
    coordinates = ("x", "y")

    def mechanics(self, q, v):
        one, springs = self.scale, 1.5 * q.x**2 + q.y**2 + 0.4 * q.x * q.y
        rubbing = fl.Friction((self.v - v.x, self.w - v.y), one, self.friction)
        energy, loads = one * self.m * (v.x**2 + v.y**2) / 2, {"y": one * self.f}
        return fl.Mechanics(energy, one * springs, contacts=(rubbing,), loads=loads)


@fl.model
class Braked(Coupled):
    """The same on a belt that brakes."""

    def mechanics(self, q, v):
        belt = fl.ramp(q.t, start=1.0, end=0.0, duration=8.0)
        energy = (v.x**2 + v.y**2) / 2
        rubbing = fl.Friction((belt - v.x, -v.y), 1.0, self.friction)
        return fl.Mechanics(energy, 2.0 * q.x**2 + 4.5 * q.y**2, contacts=(rubbing,))


@fl.model
class Stacked(fl.MechanicalModel):
    """A block on a board that slides freely."""

    m: float = 1.0
    M: float = 3.0
    g: float = 9.81
    friction: fl.FrictionLaw = fl.Coulomb(mu_k=0.2, mu_s=0.2)
    coordinates = ("x1", "y1", "x2", "y2")

    def mechanics(self, q, v):
        rubbing = fl.Friction((v.x2 - v.x1, v.y2 - v.y1), self.m * self.g, self.friction)
        block, board = self.m * (v.x1**2 + v.y1**2), self.M * (v.x2**2 + v.y2**2)
        return fl.Mechanics((block + board) / 2, contacts=(rubbing,))


@fl.model
class Hopper(fl.MechanicalModel):
    """A body that slides, and hops, on an elastic ground."""

    k: float = 200.0
    friction: fl.FrictionLaw = fl.Coulomb(mu_k=0.3, mu_s=0.3)
    impact: fl.ImpactLaw = fl.RestitutionImpact()
    coordinates = ("x", "y", "z")

    def mechanics(self, q, v):
        rubbing = fl.Friction((-v.x, -v.y), lambda d: self.k * d, self.friction, penetration=-q.z)
        return fl.Mechanics((v.x**2 + v.y**2 + v.z**2) / 2, 9.81 * q.z, v.z**2, contacts=(rubbing,))


def test_a_puck_stops_on_a_straight_line_where_its_energy_is_used_up():
    run = fl.simulate(Puck(), 3.0, x0=[0.0, 0.0, 3.0, 4.0], progress=False)
    deceleration = 0.3 * 9.81
    assert run.events.t[0] == pytest.approx(5.0 / deceleration, rel=1e-14)
    way = 25.0 / (2 * deceleration)
    assert run.final_state == pytest.approx([0.6 * way, 0.8 * way, 0.0, 0.0], rel=1e-14)
    assert run.time_in_mode["slip"] < 1.7 < run.time_in_mode["slip"] + run.time_in_mode["stick"]
    assert fl.energy_audit(run).error < 1e-13


@pytest.mark.parametrize("time", [1.0, 1e-9, 1e-6, 1e-3, 1e6])
@pytest.mark.parametrize(("kappa", "ratio"), [(1.05, 1.0), (1.3, 1.0), (4.0, 2.0)])
def test_on_an_inclined_plane_a_puck_stops_where_the_hodograph_says(kappa, ratio, time):
    alpha, s, g = 0.25, 2.0 / time, 9.81 / time**2
    mu = kappa * math.tan(alpha)
    model = Puck(alpha=alpha, mu_k=mu, mu_s=ratio * mu, g=g)
    run = fl.simulate(model, 20.0 * time, x0=[0.0, 0.0, 0.0, s], progress=False)
    f = g * math.sin(alpha)
    x = s**2 / (4 * f) * (1 / (2 * kappa - 2) - 1 / (2 * kappa + 2))
    y = s**2 / (2 * f) * (1 / (2 * kappa - 1) + 1 / (2 * kappa + 1))
    t = s / (2 * f) * (1 / (kappa - 1) + 1 / (kappa + 1))
    assert run.events.target.tolist() == ["stick"]
    assert run.final_state == pytest.approx([x, y, 0.0, 0.0], rel=1e-13)
    assert run.events.t[0] == pytest.approx(t, rel=2e-14)
    assert run.stats["steps"] < 300
    assert max(run.defect.values()) < 1e-13


class Heun(fl.OneStepMethod):
    """A method whose steps are Python's."""

    name = "heun"

    def take_step(self, rates, z, h):
        """Trapezoidal rule."""
        first = rates(z)
        return z + h / 2 * (first + rates(z + h * first))


@pytest.mark.parametrize(
    ("method", "least"), [(fl.RK4(step=0.01), 1e-3), (Heun(step=0.01), 1e-3), ("DOP853", 1e-9)]
)
def test_all_methods_stop(method, least):
    mu = 1.3 * math.tan(0.25)
    about = Puck(alpha=0.25, mu_k=mu, mu_s=mu), 5.0
    run, exact = (
        fl.simulate(*about, x0=[0.0, 0.0, 0.0, 2.0], method=one, progress=False) for one in (method, "taylor")
    )
    assert run.events.target.tolist() == ["stick"]
    assert run.events.t == pytest.approx(exact.events.t, rel=least)
    assert run.final_state == pytest.approx(exact.final_state, rel=least)


def test_where_friction_just_holds_the_weight_half_of_the_speed_is_left():
    model = Puck(alpha=math.atan(0.3), mu_k=0.3, mu_s=0.3)
    run = fl.simulate(model, 30.0, x0=[0.0, 0.0, 0.0, 1.0], progress=False)
    assert run.final_state[2:] == pytest.approx([0.5, 0.0], abs=1e-13)


def test_a_puck_that_turns_round_goes_on_by_breakaway():
    model = Puck(alpha=0.5, mu_k=0.2, mu_s=0.3)  # too steep to rest
    run = fl.simulate(model, 3.0, x0=[0.0, 0.0, -2.0, 0.0], progress=False)
    up, down = (9.81 * (math.sin(0.5) + sign * 0.2 * math.cos(0.5)) for sign in (1, -1))
    assert run.events.source.tolist() == ["slip"]  # the force keeps its direction: breakaway lasts
    x = -2.0 / up + down * (3.0 - 2.0 / up) ** 2 / 2
    assert run.final_state[0] == pytest.approx(x, rel=1e-13)


def test_blocks_stop_on_each_other_and_keep_their_momentum():
    run = fl.simulate(Stacked(), 3.0, x0=[0, 0, 0, 0, 3.0, 4.0, 0, 0], progress=False)
    assert run.final_state[4:] == pytest.approx([0.75, 1.0, 0.75, 1.0], rel=1e-14)
    way = 25.0 / (2 * 0.2 * 9.81 * (1 + 1 / 3))  # over the board
    assert run.final_state[0] - run.final_state[2] == pytest.approx(0.6 * way, rel=1e-12)


def test_steady_sliding_is_damped_across_the_slip():
    model = Coupled(w=-0.3, friction=fl.ExponentialDecay(mu_k=0.5, mu_s=1.0, v_s=0.3))
    speed = math.hypot(0.2, 0.3)
    e = np.array([0.2, -0.3]) / speed
    mu, slope = 0.5 + 0.5 * math.exp(-speed / 0.3), -0.5 / 0.3 * math.exp(-speed / 0.3)
    K = np.array([[3.0, 0.4], [0.4, 2.0]])
    found = fl.equilibrium(model)
    assert found.q == pytest.approx(np.linalg.solve(K, mu * e + [0.0, 0.1]), abs=1e-13)
    damping = mu / speed * (np.eye(2) - np.outer(e, e)) + slope * np.outer(e, e)
    exact = np.linalg.eigvals(np.block([[np.zeros((2, 2)), np.eye(2)], [-K, -damping]]))
    key = lambda one: (round(one.real, 9), one.imag)  # noqa: E731  the order of eigenvalues
    assert sorted(fl.eigenvalues(model).values, key=key) == pytest.approx(sorted(exact, key=key), abs=1e-12)


def stick_slip_by_dop853(x, t_end, belt=0.2, mu_k=0.5, mu_s=1.0, least=1e-8):
    """Motion of `Coupled` in stick at first; slip begins and ends at a least speed."""
    K = np.array([[3.0, 0.4], [0.4, 2.0]])
    hold = lambda z: K @ z[:2] - [0.0, 0.1]  # noqa: E731  the force that holds

    def slip(t, z):
        v = np.array([belt - z[2], -z[3]])
        return np.concatenate([z[2:], mu_k * v / np.hypot(*v) - hold(z)])

    def stops(t, z):
        return np.hypot(belt - z[2], z[3]) - least / 2

    def breaks(t, z):
        return mu_s - np.hypot(*hold(z))

    def loose(t, z):
        return "slip", [*z[:2], *([belt, 0.0] - least * hold(z) / np.hypot(*hold(z)))]

    phases = {
        "stick": (lambda t, z: [belt, 0.0, 0.0, 0.0], ((breaks, loose),)),
        "slip": (slip, ((stops, lambda t, z: ("stick", [*z[:2], belt, 0.0])),)),
    }
    z, events = until_events(phases, "stick", [*x, belt, 0.0], t_end, atol=1e-14)
    return z, [t for t, *_ in events]


@pytest.mark.parametrize("time", [1e-9, 1e-6, 1e-3, 1e3, 1e6])
def test_slip_begins_alike_in_other_units_of_time(time):
    laws, x0 = {"mu_k": 1.0, "mu_s": 1.0}, [0.0, 0.5, 0.2, 0.0]
    one = fl.simulate(Coupled(**laws), 1.0, x0=x0, progress=False)
    model = Coupled(m=time**2, v=0.2 / time, **laws)
    run = fl.simulate(model, time, x0=[0.0, 0.5, 0.2 / time, 0.0], progress=False)
    assert run.events.source.tolist() == ["stick", "breakaway"]
    assert run.stats["steps"] < 300
    assert run.final_state[:2] == pytest.approx(one.final_state[:2], rel=1e-13)
    assert run.final_state[2:] * time == pytest.approx(one.final_state[2:], rel=1e-12)


@pytest.mark.parametrize("unit", [1e-6, 1e6])
def test_slip_begins_alike_in_other_units_of_force(unit):
    states = []
    for scale in (1.0, unit):
        model = Coupled(scale=scale, mu_k=1.0, mu_s=1.0)
        run = fl.simulate(model, 1.0, x0=[0.0, 0.5, 0.2, 0.0], progress=False)
        assert run.events.source.tolist() == ["stick", "breakaway"]
        states.append([*run.events.t, *run.final_state])
    assert states[1] == pytest.approx(states[0], rel=1e-12)


@fl.model
class Turning(fl.MechanicalModel):
    """A charge in a magnetic field, which turns its velocity, with hardly any friction."""

    friction: fl.FrictionLaw = fl.Coulomb(mu_k=1e-3, mu_s=1e-3)
    coordinates = ("x", "y")

    def mechanics(self, q, v):
        rubbing, loads = fl.Friction((-v.x, -v.y), 1.0, self.friction), {"x": -v.y, "y": v.x}
        return fl.Mechanics((v.x**2 + v.y**2) / 2, contacts=(rubbing,), loads=loads)


def test_slip_that_only_turns_within_a_step_goes_on():
    method = fl.Scipy("RK45", rtol=1e-3, atol=0.3)
    run = fl.simulate(Turning(), 20.0, x0=[0, 0, 1.0, 0], method=method, progress=False)
    assert max(run.raw.step_times[:, 1]) > 1.6  # more than a quarter of a turn
    assert not len(run.events)


@fl.model
class Disc(fl.MechanicalModel):
    """A puck on a disc that turns, on a spring to its centre."""

    turn: float = 1.0
    friction: fl.FrictionLaw = fl.Coulomb(mu_k=0.3, mu_s=0.3)
    coordinates = ("x", "y")

    def mechanics(self, q, v):
        rubbing = fl.Friction((-self.turn * q.y - v.x, self.turn * q.x - v.y), 1.0, self.friction)
        return fl.Mechanics((v.x**2 + v.y**2) / 2, 0.05 * (q.x**2 + q.y**2), contacts=(rubbing,))


@pytest.mark.parametrize(
    ("law", "decay"),
    [
        (fl.Coulomb(mu_k=0.3, mu_s=0.3), 0.0),
        (fl.Coulomb(mu_k=0.3, mu_s=0.4), 0.0),
        (fl.ExponentialDecay(mu_k=0.3, mu_s=0.4, v_s=0.2), 0.1),
    ],
)
def test_a_puck_comes_to_rest_on_a_disc_that_turns_as_by_dop853(law, decay):
    def slip(t, z):
        v = np.array([-z[1] - z[2], z[0] - z[3]])
        mu = 0.3 + decay * math.exp(-np.hypot(*v) / 0.2)
        return np.concatenate([z[2:], mu * v / np.hypot(*v) - 0.1 * z[:2]])

    def stops(t, z):
        return np.hypot(-z[1] - z[2], z[0] - z[3]) - 1e-9

    stops.terminal, start = True, [0.2, 0.0, 0.0, -0.2]
    other = solve_ivp(slip, (0.0, 5.0), start, "DOP853", events=stops, rtol=1e-13, atol=1e-15)
    run = fl.simulate(Disc(friction=law), 5.0, x0=start, progress=False)
    assert run.events.target[0] == "stick"
    assert run.events.t[0] == pytest.approx(other.t[-1], abs=2e-8)  # it slips on for 1e-9 m/s
    assert run.events.state[0] == pytest.approx(other.y[:, -1], abs=1e-8)


@pytest.mark.slow  # 0.5 s: the integration beside it is one of scipy's
def test_stick_slip_is_that_of_an_integration_with_a_least_speed():
    run = fl.simulate(Coupled(), 12.0, x0=[0.0, 0.5, 0.2, 0.0], progress=False)
    state, instants = stick_slip_by_dop853([0.0, 0.5], 12.0)
    some = np.isin(run.events.source, ["stick", "slip"])
    assert len(instants) > 4
    assert run.events.t[some] == pytest.approx(instants, abs=1e-6)
    assert run.final_state == pytest.approx(state, abs=1e-6)


@pytest.mark.parametrize(
    "law",
    [
        fl.Coulomb(mu_k=0.5, mu_s=1.0),
        pytest.param(fl.FrictionCurve(), marks=pytest.mark.slow),  # one more derivation
        pytest.param(fl.Stribeck(mu_k=0.5, mu_s=1.0, v_s=0.3), marks=pytest.mark.slow),  # 4,000 short steps
    ],
)
def test_stick_slip_keeps_its_energy(law):
    run = fl.simulate(Coupled(friction=law), 15.0, x0=[0.0, 0.5, 0.2, 0.0], progress=False)
    assert {"stick", "breakaway"} <= {name.split(" ")[0] for name in run.events.source}
    assert fl.energy_audit(run, progress=False).error < 1e-12


@pytest.mark.parametrize(
    ("model", "t_end", "x0"),
    [
        # 3 s: a verification takes three runs, one of them scipy's
        pytest.param(Coupled(), 10.0, [0.0, 0.5, 0.2, 0.0], marks=pytest.mark.slow),
        (Braked(), 6.0, [0.3, 0.2, 0.1, 0.2]),  # rates near the stop are rounding alone
        (fl.DitheredOscillator(), 1.0, "rest"),  # v_r turns back, and does not stop
    ],
)
def test_slip_that_stops_or_turns_is_verified(model, t_end, x0):
    found = fl.verify(model, t_end, x0=x0, progress=False)
    assert found.ok
    assert ("Rates were not compared in" in str(found)) == ("stop" in found.run.events.guard)


def test_a_periodic_orbit_with_stick_in_the_plane_has_multipliers():
    model = Coupled()
    orbit = fl.periodic_orbit(model, fl.simulate(model, 40.0, x0=[0.0, 0.5, 0.2, 0.0], progress=False))
    assert [name for name, _ in orbit.modes] == ["stick", "breakaway", "slip"]
    assert sorted(abs(orbit.multipliers))[-2:] == pytest.approx([0.2379, 1.0], abs=1e-4)


def test_a_body_hops_and_comes_to_rest():
    model = Hopper()
    run = fl.simulate(model, 8.0, x0=[0.0, 0.0, 0.5, 1.0, -0.7, 0.0], progress=False)
    assert {"separation", "slip"} <= {*run.mode}
    assert run.mode[-1] == "stick"
    assert run.final_state[3:5] == pytest.approx([0.0, 0.0], abs=0.0)
    way = run.final_state[:2]
    assert way[1] / way[0] == pytest.approx(-0.7, rel=1e-9)
    fl.testing.check_model(model)


def test_equations_have_both_components():
    text = str(Coupled().equations("slip"))
    assert "F_Ta(t) = mu_k*F_N(t)*v_ra(t)/sqrt(v_ra(t)**2 + v_rb(t)**2)" in text
    assert "sqrt(F_Ta(t)**2 + F_Tb(t)**2) <= mu_s*F_N(t)" in str(Coupled().equations("stick"))


def with_contacts(*contacts, interface=None):
    """A model of two coordinates with contacts of v and the law."""

    @fl.model
    class Refused(fl.MechanicalModel):
        """A model that is refused."""

        friction: fl.FrictionLaw = fl.Coulomb()
        coordinates = ("x", "y")

        def mechanics(self, q, v):
            made = tuple(contact(q, v, self.friction) for contact in contacts)
            return fl.Mechanics((v.x**2 + v.y**2) / 2, contacts=made)

    return Refused() if interface is None else Refused(interface=interface)


PLANE = lambda q, v, law: fl.Friction((1.0 - v.x, -v.y), 1.0, law)  # noqa: E731  a contact of a test


@pytest.mark.parametrize(
    ("contacts", "words"),
    [
        ([lambda q, v, law: fl.Friction((v.x, v.y, v.x), 1.0, law)], "must have two components, got 3"),
        ([lambda q, v, law: fl.Friction((v.x, 2 * v.x), 1.0, law)], "two independent components"),
        ([lambda q, v, law: fl.Friction((v.x, v.y), 1.0, fl.LuGre())], "must have no states, got LuGre"),
        (
            [
                lambda q, v, law: fl.Friction(
                    (v.x, 1 + v.y), lambda d: d, law, penetration=q.y, impact=fl.FrictionalImpact()
                )
            ],
            "must have no friction, got FrictionalImpact",
        ),
        (
            [
                lambda q, v, law: fl.Stop(
                    q.x, fl.PlasticImpact("full"), friction=law, relative_velocity=(v.x, v.y)
                )
            ],
            "of a Stop of Refused must be one expression, got 2",
        ),
        ([PLANE, lambda q, v, law: fl.Friction(-v.x, 1.0, law)], "must be the only one with friction along"),
    ],
)
def test_what_is_not_of_the_plane_is_refused(contacts, words):
    with pytest.raises(ValueError, match=words):
        with_contacts(*contacts).automaton()


def test_sliding_in_one_direction_is_refused():
    with pytest.raises(ValueError, match="must have stick, got SlidingOnly"):
        with_contacts(PLANE, interface=fl.SlidingOnly()).automaton()
    assert "nonsmooth" not in Coupled().nonlinearities


@fl.model
class ThrownPast(fl.MechanicalModel):
    """A body that a force brings back; v_r passes zero at a distance of eps.  Beside it a spring vibrates."""

    eps: float = 0.01
    k: float = 1.0
    coordinates = ("x", "y", "z")

    def mechanics(self, q, v):
        smooth = fl.Friction((-v.x, self.eps - v.y), 0.0, fl.Coulomb(mu_k=1.0, mu_s=1.0))
        kinetic = (v.x**2 + v.y**2 + v.z**2) / 2
        return fl.Mechanics(kinetic, self.k * q.z**2 / 2 - q.x, contacts=(smooth,))


@pytest.mark.parametrize(("eps", "k"), [(0.01, 1.0), (2e-5, 1e4), (1e-7, 1.0)])
@pytest.mark.parametrize(
    ("method", "error"), [("taylor", 1e-12), ("DOP853", 1e-12), ("rk4", 1e-9), ("LSODA", 1e-9)]
)
def test_a_relative_velocity_that_passes_near_zero_does_not_stop(method, error, eps, k):
    """x = t^2/2 - t throughout; the runs of `verify` agree."""
    model, x0 = ThrownPast(eps=eps, k=k), {"x'": -1.0, "z": 1.0}
    run = fl.simulate(model, 3.0, x0=x0, method=method, progress=False)
    assert not len(run.events)
    assert run.final_state[[0, 1, 3]] == pytest.approx([1.5, 0.0, 2.0], abs=error)
    assert fl.verify(model, 3.0, x0=x0, progress=False).ok


@fl.model
class OnBelt(fl.MechanicalModel):
    """A body under a constant force on a belt at 1 m/s, which would hold it if it ever stopped."""

    fx: float = 1.0
    fy: float = 0.0
    friction: fl.FrictionLaw = fl.Coulomb(mu_k=0.3, mu_s=5.0)
    coordinates = ("x", "y")

    def mechanics(self, q, v):
        rubs = fl.Friction((1.0 - v.x, -v.y), 1.0, self.friction)
        potential = -self.fx * q.x - self.fy * q.y
        return fl.Mechanics((v.x**2 + v.y**2) / 2, potential, contacts=(rubs,))


@pytest.mark.parametrize("eps", [1e-3, 1e-5, 1e-7, 1e-9])
@pytest.mark.parametrize("method", ["taylor", "rk4", "DOP853", "LSODA"])
def test_a_pass_under_friction_turns_and_does_not_stop(method, eps):
    """The speed is least, eps, where the force has the friction's size along v_r; integrated from there, both
    ways, by scipy alone."""
    along, across = np.array([0.6, 0.8]), np.array([-0.8, 0.6])
    force = 0.3 * along + 1.2 * across

    def rates(_, z):
        u = z[2:]
        return np.concatenate([u, force - 0.3 * u / np.hypot(*u)])

    least, settings = [0.0, 0.0, *(eps * along)], {"method": "DOP853", "rtol": 3e-14, "atol": 1e-14 * eps}
    start, end = (solve_ivp(rates, (0.0, t), least, **settings).y[:, -1] for t in (-0.99993, 1.0))
    belt, model = np.array([1.99993, 0.0, 1.0, 0.0]), OnBelt(fx=force[0], fy=force[1])
    run = fl.simulate(model, 1.99993, x0=start + belt * [0, 0, 1, 0], method=method, progress=False)
    assert not len(run.events)
    assert run.final_state == pytest.approx(end + belt, abs=1e-6)


@pytest.mark.parametrize("method", [fl.RK4(step=1e-3, max_steps=100_000), fl.Scipy("LSODA")])
@pytest.mark.parametrize("share", [0.0, 0.9, 0.99])
def test_a_stop_against_a_force_that_nearly_holds(method, share):
    """v_r turns into the force the faster the nearer this is to the friction's: a stiff direction."""
    model = OnBelt(fx=0.3 * share, fy=0.0)
    exact, run = (
        fl.simulate(model, 60.0, x0=[0.0, 0.0, 1.1, 0.1], method=one, progress=False)
        for one in (fl.Taylor(), method)
    )
    assert run.events.target.tolist() == exact.events.target.tolist() == ["stick"]
    assert run.events.t == pytest.approx(exact.events.t, abs=1e-4)
