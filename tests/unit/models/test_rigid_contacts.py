"""Rigid contacts with and without friction: closed forms, an integration by hand, and Moreau's scheme."""

import math
from contextlib import nullcontext
from functools import partial

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

import frictionlab as fl
from frictionlab.hybrid.solve import end_of, solve_from_end
from frictionlab.models.mechanical.contact_regimes import rubbing_impulse
from tests.reference.moreau import RigidSystem, time_steps
from tests.reference.phases import until_events

sin, cos = fl.functions.sin, fl.functions.cos


@fl.model
class Landing(fl.MechanicalModel):
    """A mass that falls on another one, which hangs on a spring."""

    m1: float = 1.0
    m2: float = 2.0
    k: float = 10.0
    coordinates = ("x1", "x2")

    def release(self):
        return {"x2": 0.5}

    def mechanics(self, q, v):
        return fl.Mechanics(
            kinetic=self.m1 * v.x1**2 / 2 + self.m2 * v.x2**2 / 2,
            potential=self.k * q.x1**2 / 2 + 10.0 * self.m2 * q.x2,
            contacts=(fl.Stop(q.x2 - q.x1, fl.PlasticImpact("full")),),
        )


def test_bodies_stay_together_while_one_presses_the_other():
    """F_N = m2 (g + x''), where both move together."""
    run = fl.simulate(Landing(), 2.0, progress=False)
    assert run.events.target.tolist() == ["contact"]
    together = run.t > run.events.t[0]
    acceleration = -(10.0 * run["x1"] + 20.0) / 3.0
    assert np.allclose(run["reaction"][together], (2.0 * (10.0 + acceleration))[together], rtol=1e-12)
    assert fl.energy_audit(run, progress=False).error < 1e-13


@fl.model
class Puck(fl.MechanicalModel):
    """A puck that falls on a belt and is held by a spring along it."""

    m: float = 1.0
    k: float = 20.0
    v: float = 0.5
    friction: fl.FrictionLaw = fl.Coulomb(mu_k=0.2, mu_s=0.4)
    impact: fl.ImpactLaw = fl.PlasticImpact("full")
    coordinates = ("x", "y")

    def release(self):
        return {"y": 0.05}

    def mechanics(self, q, v):
        rubbing = fl.Stop(q.y, self.impact, friction=self.friction, relative_velocity=self.v - v.x)
        return fl.Mechanics(
            kinetic=self.m * (v.x**2 + v.y**2) / 2,
            potential=self.k * q.x**2 / 2 + 10.0 * self.m * q.y,
            contacts=(rubbing,),
        )


def test_a_puck_falls_on_the_belt_and_slips():
    run = fl.simulate(Puck(), 0.2, progress=False)
    assert run.events.t.tolist() == pytest.approx([0.1], rel=1e-14)
    assert run.mode[-1] == "slip+"
    assert fl.energy_audit(run, progress=False).error < 1e-13


def test_a_puck_sticks_and_slips_as_the_closed_form_says():
    """The belt carries it from 2 x_k - x_s to x_s = mu_s m g/k; it slips on an arc about x_k = mu_k m g/k."""
    run = fl.simulate(Puck(), 6.0, x0={"y": 0.0, "x'": 0.5}, progress=False)
    static, kinetic, rate = 0.2, 0.1, math.sqrt(20.0)
    breaks = run.events.t[run.events.guard == "cone+"]
    assert breaks[0] == pytest.approx(static / 0.5, rel=1e-13)
    slips = (math.pi + 2 * math.atan(0.5 / (rate * (static - kinetic)))) / rate
    assert np.diff(breaks) == pytest.approx(slips + 2 * (static - kinetic) / 0.5, rel=1e-12)
    assert fl.energy_audit(run, progress=False).error < 1e-13


def test_a_model_with_a_rigid_contact_is_checked_and_verified():
    fl.testing.check_model(Puck(impact=fl.FrictionalImpact(e=0.5, mu_i=0.1)))
    assert "agree" in str(fl.verify(Puck(), 1.0, progress=False))
    equations = str(Puck().equations("slip-"))
    assert "F_T(t) = -mu_k*F_N(t)" in equations
    assert "v_r(t) < 0" in equations


def test_equilibria_in_rigid_contact_are_all_known():
    (point,) = known = fl.equilibria(Puck())
    assert known.complete
    assert point.q == pytest.approx([0.1, 0.0], rel=1e-14)
    assert (point.normal_force, point.friction_force) == pytest.approx((10.0, 2.0), rel=1e-14)


@fl.model
class Rod(fl.MechanicalModel):
    """A rod that falls over, with its lower end on a rough floor."""

    m: float = 1.0
    l: float = 0.5
    friction: fl.FrictionLaw = fl.Coulomb(mu_k=0.3, mu_s=0.3)
    coordinates = ("x", "y", "theta")

    def release(self):
        return {"y": 0.5 * math.sin(1.0), "theta": 1.0}

    def mechanics(self, q, v):
        end = fl.Stop(
            q.y - self.l * sin(q.theta),
            fl.FrictionalImpact(e=0.0, mu_i=0.3),
            friction=self.friction,
            relative_velocity=-v.x - self.l * sin(q.theta) * v.theta,
        )
        return fl.Mechanics(
            kinetic=self.m * (v.x**2 + v.y**2) / 2 + self.m * self.l**2 * v.theta**2 / 6,
            potential=9.81 * self.m * q.y,
            contacts=(end,),
        )


def rates_of_rod(mu, m=1.0, l=0.5, g=9.81):
    """Newton's and Euler's equations of a rod whose end is pressed by N and rubbed by mu N."""

    def rates(t, z):
        th, (vx, vy, w) = z[2], z[3:]
        arm = (-l * math.cos(th) + l * math.sin(th) * mu) / (m * l * l / 3)  # angular acceleration per N
        pressed = (g - l * math.sin(th) * w * w) / (1 / m - l * math.cos(th) * arm)
        return [vx, vy, w, mu * pressed / m, pressed / m - g, arm * pressed]

    return rates


def test_a_rod_that_falls_over_agrees_with_newton_and_euler():
    model = Rod()
    run = fl.simulate(model, 0.45, progress=False)
    assert run.events.guard.tolist() == ["v_r"]
    turn = run.events.t[0]
    z = np.array([0.0, 0.5 * math.sin(1.0), 1.0, 0.0, 0.0, 0.0])
    for mu, begin, end in ((0.3, 0.0, turn), (-0.3, turn, 0.45)):
        z = solve_ivp(rates_of_rod(mu), (begin, end), z, method="DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
        assert np.abs(run(end) - z).max() < 1e-11
    assert np.abs(run["distance"]).max() < 1e-14


def test_slip_begins_only_where_its_forces_exist():
    """Painleve's paradox: m W_N^T M^-1 (W_N + mu W_T) = 1 + 3 cos (cos - mu sin) is positive, for mu = 3."""

    def softness(theta):
        return 1 + 3 * math.cos(theta) * (math.cos(theta) - 3 * math.sin(theta))

    border, ends = brentq(softness, 1.4, 1.55), {}
    for side in (-1, 1):
        theta = border + 1e-6 * side
        start = {"theta": theta, "x'": -8.0, "y": 0.5 * math.sin(theta), "y'": 0.0, "theta'": 0.0}
        paradox = pytest.warns(
            RuntimeWarning, match=r"Painleve's paradox in mode 'slip\+': 'wedge', .* is negative"
        )
        with paradox if side < 0 else nullcontext():
            ends[side] = fl.simulate(Rod(mu_k=3.0, mu_s=3.0), 1e-6, x0=start, progress=False)
    assert (ends[1].status.ok, ends[1].mode[-1], ends[1].warning) == (True, "slip+", None)
    assert not ends[-1].status.ok


def test_a_rod_that_slides_into_the_paradox_says_so():
    """It ends where 1 + 3 cos (cos - mu sin) = 0, at mu = 1.6; the reaction grows beyond bounds (jamming)."""
    start = {"theta": 0.6, "x'": -8.0, "y": 0.5 * math.sin(0.6), "y'": 0.0, "theta'": 0.0}
    with pytest.warns(RuntimeWarning, match=r"Painleve's paradox in mode 'slip\+': 'wedge', .* is zero"):
        run = fl.simulate(Rod(mu_k=1.6, mu_s=1.6), 0.4, x0=start, progress=False)
    theta = brentq(lambda x: 1 + 3 * math.cos(x) * (math.cos(x) - 1.6 * math.sin(x)), 0.6, 1.0)
    assert run["theta"][-1] == pytest.approx(theta, rel=1e-6)


def test_a_start_behind_a_stop_names_it_and_its_distance():
    with pytest.warns(RuntimeWarning, match="at 0 s with x0 behind a stop: 'distance' is -0.01: start where"):
        assert not fl.simulate(Puck(), 1.0, x0={"y": -0.01}, progress=False).status.ok
    with pytest.warns(RuntimeWarning, match="'distance_2' is -0.21"):
        fl.simulate(Sledge(), 1.0, x0={"y": 0.09, "theta": -1.0}, progress=False)


def test_an_event_of_ones_own_may_be_called_wedge():
    x, v = sp.symbols("x v")
    mode = fl.Mode("on", (v, sp.Integer(-1)), (fl.Event("wedge", x, ()),))
    run = fl.solve(fl.HybridAutomaton((x, v), (mode,), coordinates=1), 3.0, x0=[-1.0, 0.0], progress=False)
    assert (run.status.ok, run.warning) == (False, None)


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"friction": fl.Coulomb()}, "both friction and relative_velocity or neither"),
        ({"friction": fl.LuGre()}, "must have no states"),
    ],
)
def test_friction_of_a_stop_needs_a_velocity_and_no_states(more, words):
    @fl.model
    class Wrong(fl.MechanicalModel):
        m: float = 1.0
        coordinates = ("x", "y")

        def mechanics(self, q, v):
            speed = {"relative_velocity": -v.x} if "states" in words else {}
            stop = fl.Stop(q.y, fl.PlasticImpact("full"), **more, **speed)
            return fl.Mechanics(kinetic=self.m * (v.x**2 + v.y**2) / 2, contacts=(stop,))

    with pytest.raises(ValueError, match=words):
        fl.simulate(Wrong(), 1.0, progress=False)


@fl.model
class RockingBlock(fl.MechanicalModel):
    """Housner's block on a rough floor; it turns about one corner, then about the other."""

    m: float = 1.0
    b: float = 0.2
    h: float = 1.0
    friction: fl.FrictionLaw = fl.Coulomb(mu_k=0.8, mu_s=1.0)
    coordinates = ("x", "y", "theta")

    def release(self):
        return {"theta": 0.1, "y": self.h * math.cos(0.1) + self.b * math.sin(0.1)}

    def corner(self, q, v, side):
        height = q.y - self.h * cos(q.theta) - side * self.b * sin(q.theta)
        along = v.x - (side * self.b * sin(q.theta) + self.h * cos(q.theta)) * v.theta
        law = fl.FrictionalImpact(e=0.0, mu_i=1.0)
        return fl.Stop(height, law, friction=self.friction, relative_velocity=-along)

    def mechanics(self, q, v):
        turning = self.m * (self.b**2 + self.h**2) / 3 * v.theta**2 / 2
        return fl.Mechanics(
            kinetic=self.m * (v.x**2 + v.y**2) / 2 + turning,
            potential=9.81 * self.m * q.y,
            contacts=(self.corner(q, v, -1), self.corner(q, v, 1)),
        )


@pytest.mark.slow
def test_a_block_rocks_as_housner_says():
    """The first impact by a quadrature; each leaves 1 - 1.5 sin(alpha)^2 of the rate, tan(alpha) = b/h.

    G. W. Housner, The behavior of inverted pendulum structures during earthquakes, 1963.
    """
    run = fl.simulate(RockingBlock(), 4.0, progress=False)
    alpha, p2 = math.atan(0.2), 3 * 9.81 / (4 * math.hypot(0.2, 1.0))

    def slowness(u):  # theta = theta_0 - u^2 removes the singular start
        theta = 0.1 - u * u
        return 2 * u / math.sqrt(2 * p2 * (math.cos(alpha - 0.1) - math.cos(alpha - theta)))

    falls = quad(slowness, 0.0, math.sqrt(0.1), epsabs=1e-12, epsrel=1e-12)[0]
    assert run.events.t[0] == pytest.approx(falls, rel=1e-9)
    ratios = run.events.state[:, 5] / run.events.before[:, 5]
    assert ratios == pytest.approx(1 - 1.5 * math.sin(alpha) ** 2, rel=1e-13)
    assert fl.energy_audit(run, progress=False).error < 1e-13


@fl.model
class ThrownRod(fl.MechanicalModel):
    """A rod of half the length 1, one end of which strikes a rough floor."""

    impact: fl.ImpactLaw = fl.FrictionalImpact(e=0.5, mu_i=0.8)
    coordinates = ("x", "y", "theta")

    def mechanics(self, q, v):
        rough, along = fl.Coulomb(mu_k=0.5, mu_s=0.5), v.x + sin(q.theta) * v.theta
        end = fl.Stop(q.y - sin(q.theta), self.impact, friction=rough, relative_velocity=-along)
        return fl.Mechanics(kinetic=(v.x**2 + v.y**2) / 2 + v.theta**2 / 6, contacts=(end,))


@fl.model
class RodOnSpring(ThrownRod):
    """The floor gives way."""

    def mechanics(self, q, v):
        rough, along, depth = fl.Coulomb(mu_k=0.5, mu_s=0.5), v.x + sin(q.theta) * v.theta, sin(q.theta) - q.y
        end = fl.Friction(-along, 50.0 * depth, rough, penetration=depth, impact=self.impact)
        return fl.Mechanics(kinetic=(v.x**2 + v.y**2) / 2 + v.theta**2 / 6, contacts=(end,))


@pytest.mark.parametrize("model", [ThrownRod, RodOnSpring])
@pytest.mark.parametrize("mu", [0.0, 0.2, 0.8, 2.0])
@pytest.mark.parametrize("e", [0.0, 0.5, 1.0])
def test_impulses_of_a_rod_that_strikes_a_floor(e, mu, model):
    """Newton's law, a push within the cone, and no energy gained: Kane's paradox."""
    for seed in range(5):
        rng = np.random.default_rng(seed)
        theta, (x, y, turning) = rng.uniform(0.1, 1.5), rng.standard_normal(3)
        toward = -np.sign(y - math.cos(theta) * turning)
        start = [0.0, math.sin(theta) + 1e-9, theta, *(toward * np.array([x, y, turning]))]
        run = fl.simulate(model(impact=fl.FrictionalImpact(e=e, mu_i=mu)), 1e-3, x0=start, progress=False)
        before, after = run.events.before[0], run.events.state[0]
        opening = [z[4] - math.cos(z[2]) * z[5] for z in (before, after)]
        assert opening[1] == pytest.approx(-e * opening[0], abs=1e-12)
        p_T, p_N, _ = after[3:] - before[3:]
        assert abs(p_T) <= mu * p_N + 1e-12
        energies = [z[3] ** 2 + z[4] ** 2 + z[5] ** 2 / 3 for z in (before, after)]
        assert energies[1] <= energies[0] + 1e-12


@pytest.mark.parametrize("mu", [0.0, 0.8])
def test_a_puck_that_falls_without_sliding_is_not_rubbed(mu):
    """Both v_r and the friction cone may be zero."""
    run = fl.simulate(Puck(v=0.0, impact=fl.FrictionalImpact(e=0.5, mu_i=mu)), 0.5, progress=False)
    assert run.status.ok
    assert not run["x"].any()
    assert run.events.state[0, 3] == pytest.approx(-0.5 * run.events.before[0, 3])


@pytest.mark.parametrize(
    ("mu", "impulse", "share", "stopping", "p_T"),
    [
        (0.0, 1.0, 0.0, 0.0, 0.0),
        (0.5, 0.0, 0.3, 1.0, 0.0),
        (2.0, 0.0, 1.0, 1.0, 0.0),
        (2.0, 1e-20, 1.0, 1.0, 1.0),
    ],
)
def test_impulses_of_friction_at_the_tip_of_the_cone(mu, impulse, share, stopping, p_T):
    """Without a push there is no friction; with mu times the share above 1 any push allows all of it."""
    symbols = sp.symbols("mu impulse share stopping")
    formula = sp.lambdify(symbols, rubbing_impulse(*symbols, symbols[-1]), cse=False)
    assert formula(mu, impulse, share, stopping) == pytest.approx(p_T, rel=1e-12, abs=0.0)


@fl.model
class Follower(fl.MechanicalModel):
    """A follower on a rigid cam, with friction in its guide."""

    Omega: float = 10.0
    friction: fl.FrictionLaw = fl.Coulomb(mu_k=0.3, mu_s=0.3)
    coordinates = ("y",)

    def release(self):
        return {"y": 0.05}

    def mechanics(self, q, v):
        cam = fl.Stop(q.y - 0.05 * fl.functions.cos(q.phase), fl.PlasticImpact())
        guide = fl.Friction(-v.y, 10.0, self.friction)
        spring = 50.0 * q.y**2 + 30.0 * q.y
        return fl.Mechanics(v.y**2 / 2, spring, contacts=(cam, guide), frequency=self.Omega)


def test_the_phase_tells_when_a_follower_on_a_cam_turns():
    """Friction turns at dead centres, at one with the phase, where all neighbours on the cam meet both."""
    model = Follower()
    run = fl.simulate(model, 10.0, progress=False)
    assert sorted(np.abs(fl.periodic_orbit(model, run).multipliers)) == pytest.approx([0.0, 0.0, 1.0])
    exponents = fl.lyapunov(model, transient=2.0, t_end=10.0, blocks=4, progress=False).exponents
    assert exponents == pytest.approx([0.0, -np.inf, -np.inf], abs=1e-3)


def woodpecker_by_moreau(t_end, h):
    m_M, J_M, m_S, J_S, c, g = 0.0003, 5e-9, 0.0045, 7e-7, 0.0056, 9.81
    arm = np.array([1.0, 0.01, 0.015])
    weights = np.array([m_M * g, 0.0, 0.0]) + m_S * g * arm
    return time_steps(
        RigidSystem(
            masses=np.diag([m_M, J_M, J_S]) + m_S * np.outer(arm, arm),
            forces=lambda q: np.array([0.0, -1.0, 1.0]) * c * (q[1] - q[2]) - weights,
            gaps=lambda q: np.array([0.0024 - 0.02 * q[2], 0.0006 + 0.0058 * q[1], 0.0006 - 0.0058 * q[1]]),
            normals=np.array([[0, 0, -0.02], [0, 0.0058, 0], [0, -0.0058, 0]]),
            tangents=np.array([[1, 0.01, -0.0051], [1, 0.0031, 0], [1, 0.0031, 0]]),
            restitution=np.array([0.5, 0.0, 0.0]),
            friction=0.3,
        ),
        np.array([0.0, -0.0006 / 0.0058, -0.2788]),
        np.array([-0.3411, 0.0, -7.4583]),
        t_end,
        h,
    )


@pytest.mark.slow
def test_a_woodpecker_pecks_as_moreaus_scheme_says():
    """The sleeve jams, slips free, turns over, the beak hits the pole, the sleeve turns back and jams."""
    run = fl.simulate(fl.Woodpecker(), 0.3, progress=False)
    impacts = [guard for guard in run.events.guard[run.events.t > 0.01] if guard.startswith("impact")]
    assert impacts[:5] == ["impact_3", "impact_1", "impact_3", "impact_2", "impact_2"]
    steps = woodpecker_by_moreau(0.14, 2e-5)
    errors = np.abs(run(steps[:, 0])[:, :3] - steps[:, 1:4]).max(axis=0)
    assert (errors < [3e-5, 1e-3, 2e-3]).all()  # of motions of 0.017 m, 0.2 and 0.6
    settled = fl.steady_state(fl.Woodpecker(), transient=3.0, window=1.5, progress=False)
    orbit = fl.periodic_orbit(fl.Woodpecker(), settled)
    assert orbit.period == pytest.approx(settled.period, rel=1e-5)
    assert np.abs(orbit.multipliers[1:]).max() < 1
    along = orbit.trajectory(np.linspace(0.0, orbit.period, 100_000, endpoint=False))
    near = along[np.argmin(np.abs(along[:, 2] + 0.2788) + (np.abs(along[:, 4]) > 1e-9))]
    # Glocker (1995) begins there, as the sleeve slips: y' = -0.3411 m/s, phi_S' = -7.4583 rad/s
    assert near[[3, 5]] == pytest.approx([-0.3411, -7.4583], rel=5e-3)


@fl.model
class SliderOnRail(fl.MechanicalModel):
    """A slider on a rigid rail, inclined by the slope b to the coordinates, that a belt drags along."""

    m: float = 1.0
    k: float = 100.0
    kc: float = 30.0
    c: float = 0.1
    P: float = 20.0
    v0: float = 0.5
    b: float = 0.3
    friction: fl.FrictionLaw = fl.Stribeck(mu_k=0.3, mu_s=0.5)
    coordinates = ("x", "y")

    def mechanics(self, q, v):
        springs = self.k * q.x**2 / 2 + self.kc * (q.x - q.y) ** 2 / 2 + self.P * q.y
        rail = fl.Stop(
            q.y - self.b * q.x, fl.PlasticImpact(), friction=self.friction, relative_velocity=self.v0 - v.x
        )
        kinetic, damped = self.m * (v.x**2 + v.y**2) / 2, self.c * v.x**2 / 2
        return fl.Mechanics(kinetic, springs, damped, contacts=(rail,))


def rate_in_minimal_coordinates(model, x, v):
    """Acceleration along x and normal force: m (x'', b x'') = f + N (-b, 1) + mu N (1, 0), by hand."""
    law, v_r = model.friction, model.v0 - v
    mu = law.mu_k + (law.mu_s - law.mu_k) * np.exp(-((v_r / law.v_s) ** 2))
    pull = model.kc * (x - model.b * x)
    matrix = [[model.m, model.b - mu], [model.m * model.b, -1.0]]
    return np.linalg.solve(matrix, [-model.k * x - pull - model.c * v, pull - model.P])


def test_rounding_along_a_rail_does_not_end_a_run_that_starts_there():
    model = SliderOnRail()
    run = fl.simulate(model, 30.0)
    places = run(np.linspace(10.0, 30.0, 41))
    assert np.abs(places[:, 1] - model.b * places[:, 0]).max() > 0.0  # off the rail by rounding
    for place in places:
        assert fl.simulate(model, 0.01, x0=place).status.ok
    slip = run.events.target.tolist().index("slip+", 20)
    start = run.events.state[slip]
    span = 0.3 * (run.events.t[slip + 1] - run.events.t[slip])
    other = solve_ivp(
        lambda t, y: [y[1], rate_in_minimal_coordinates(model, *y)[0]],
        (0.0, span),
        start[[0, 2]] - [0.0, 1e-12],
        method="DOP853",
        rtol=1e-12,
        atol=1e-13,
    )
    assert np.allclose(run(run.events.t[slip] + span)[[0, 2]], other.y[:, -1], rtol=0.0, atol=1e-10)


@pytest.mark.slow
def test_a_run_along_a_rail_is_verified_by_neighbours_on_it():
    found = fl.verify(SliderOnRail(), 3.0, x0="near", progress=False)
    assert (found.ok, found.until, found.events_agree) == (True, 3.0, True)


def test_an_orbit_along_a_rail_closes_without_a_flight():
    model = SliderOnRail()
    orbit = fl.periodic_orbit(model, fl.simulate(model, 30.0, progress=False))
    assert [name for name, _ in orbit.modes] in (["stick", "slip+"], ["slip+", "stick"])
    assert orbit.stable
    settled = fl.steady_state(model, transient=30.0, window=10.0, progress=False)
    assert abs(settled.period - orbit.period) < 1e-6 * orbit.period


@fl.model
class Sledge(fl.MechanicalModel):
    """A body that slides on two feet, with Stribeck's friction on a belt, and a spring."""

    m: float = 1.0
    J: float = 0.02
    k: float = 50.0
    friction: fl.FrictionLaw = fl.Stribeck(mu_s=0.4, mu_k=0.2, v_s=0.1)
    coordinates = ("x", "y", "theta")

    def mechanics(self, q, v):
        kinetic = (self.m * (v.x**2 + v.y**2) + self.J * v.theta**2) / 2
        law, v_r = fl.FrictionalImpact(e=0.0, mu_i=0.2), 0.3 - v.x - 0.2 * v.theta
        gaps = (q.y - 0.3 * q.theta, q.y + 0.3 * q.theta)
        feet = tuple(fl.Stop(gap, law, friction=self.friction, relative_velocity=v_r) for gap in gaps)
        springs = self.k * q.x**2 / 2 + 9.81 * self.m * q.y
        return fl.Mechanics(kinetic, springs, 0.1 * v.x**2, contacts=feet)


def test_a_body_on_two_feet_goes_on_where_its_height_is_rounding():
    model = Sledge()
    run = fl.simulate(model, 2.7, progress=False)
    for t in (0.5, 1.0, 1.3, 2.0):
        rest = solve_from_end(run.automaton, 2.7 - t, run(t), str(run.modes_at(t)), progress=False)
        assert np.abs(rest.final_state - run.final_state).max() < 1e-14
        assert fl.simulate(model, 2.7 - t, x0=run(t), progress=False).status.ok
    block = fl.MassOnBelt(m=1.0, k=50.0, c=0.2, N=9.81, v=0.3, friction=model.friction)
    settled, of_block = (
        fl.steady_state(one, x0={"x": 0.01}, transient=20.0, window=10.0, progress=False)
        for one in (model, block)
    )
    assert settled.kind == of_block.kind == "periodic"
    assert settled.period == pytest.approx(of_block.period, rel=1e-9)
    assert run.violation < 1e-6  # of heights that are 1e-14 m, all of it rounding


@fl.model
class DrivenSledge(fl.MechanicalModel):
    """A body on two feet that a force moves to and fro on the ground."""

    m: float = 1.0
    k: float = 50.0
    c: float = 1.0
    Omega: float = 4.0
    F: float = 5.0
    friction: fl.FrictionLaw = fl.Coulomb(mu_s=0.3, mu_k=0.3)
    coordinates = ("x", "y", "theta")

    def mechanics(self, q, v):
        kinetic = (self.m * (v.x**2 + v.y**2) + 0.1 * v.theta**2) / 2
        law, v_r = fl.FrictionalImpact(e=0.0, mu_i=0.3), -v.x - 0.1 * v.theta
        gaps = (q.y - 0.5 * q.theta, q.y + 0.5 * q.theta)
        feet = tuple(fl.Stop(gap, law, friction=self.friction, relative_velocity=v_r) for gap in gaps)
        load = {"x": self.F * fl.functions.cos(q.phase)}
        springs, dampers = self.k * q.x**2 / 2 + 9.81 * self.m * q.y, self.c * v.x**2 / 2
        return fl.Mechanics(kinetic, springs, dampers, loads=load, contacts=feet, frequency=self.Omega)


@pytest.mark.parametrize("start", [{"x": 0.0}, {"x": 0.3}, {"y": 0.1, "theta": 0.05}])
@pytest.mark.parametrize("F", [0.0, 2.0])
def test_a_body_on_two_feet_rests_under_a_load_that_friction_holds(F, start):
    """0.3 m g = 2.94 N holds 2 N, by either foot; a body 1 mm above the ground falls."""
    model = DrivenSledge(F=F, k=0.0)
    settled = fl.steady_state(model, start, transient=20.0, window=20.0, progress=False)
    assert settled.kind == "equilibrium"
    exponents = fl.lyapunov(model, start, transient=20.0, t_end=20.0, blocks=2, progress=False).exponents
    assert exponents[:2] == pytest.approx([0.0, 0.0], abs=1e-3)
    assert (exponents[2:] == -np.inf).all()
    run = settled.trajectory
    state, mode = end_of(run)
    assert np.abs(state - run.raw.state).max() < 1e-11
    further = fl.simulate(model, 20.0, x0=run.final_state, progress=False)
    assert further.status.ok
    assert np.abs(further["x"] - run["x"][-1]).max() < 1e-11
    falls = solve_from_end(run.automaton, 0.02, state + 1e-3 * np.eye(7)[1], mode, progress=False)
    assert falls.events.t[0] == pytest.approx(math.sqrt(2 * 1e-3 / 9.81), rel=1e-6)


def after_one_period(model, x, v, phase):
    """Of a block that slides and sticks: DOP853 from event to event."""
    start, limit = phase / model.Omega, 0.3 * 9.81

    def pull(t, x, v):
        return 5.0 * np.cos(model.Omega * t) - model.k * x - model.c * v

    def rates(t, z, sign):
        return [z[1], pull(t, *z) - limit * sign] if sign else [0.0, 0.0]

    def leaves(t, z, sign):
        return sign * z[1] if sign else limit - abs(pull(t, *z))

    def then(t, z, sign):
        force = pull(t, z[0], 0.0)
        return np.sign(force) if not sign or abs(force) > limit else 0.0, [z[0], 0.0]

    phases = {
        sign: (partial(rates, sign=sign), ((partial(leaves, sign=sign), partial(then, sign=sign)),))
        for sign in (-1.0, 0.0, 1.0)
    }
    z, _ = until_events(phases, np.sign(v), [x, v], start + 2 * np.pi / model.Omega, t=start, atol=1e-14)
    return z


def test_orbits_of_a_body_on_two_feet_are_those_of_a_block():
    """All neighbours meet the events of both feet, though more of them hold than there are freedoms."""
    model = DrivenSledge()
    orbit = fl.periodic_orbit(model, fl.simulate(model, 20.0, x0=np.zeros(6), progress=False))
    x, v, phase = orbit.state[[0, 3, 6]]
    assert after_one_period(model, x, v, phase) == pytest.approx([x, v], abs=1e-9)
    h, columns = 1e-5, []
    for dx, dv in ((h, 0.0), (0.0, h)):
        ahead, back = (after_one_period(model, x + s * dx, v + s * dv, phase) for s in (1, -1))
        columns.append(np.subtract(ahead, back) / (2 * h))
    other = sorted(np.abs(np.linalg.eigvals(np.transpose(columns))))
    assert other[0] < 1e-7 < 2e-3 < other[1]
    assert np.abs(orbit.multipliers[1]) == pytest.approx(other[1], rel=1e-4)
    assert np.abs(orbit.multipliers[2:]).max() < 1e-12
    period = orbit.period
    spectrum = fl.lyapunov(model, transient=20.0, t_end=10 * period, blocks=2, progress=False)
    assert spectrum.exponents[:2] == pytest.approx([0.0, np.log(other[1]) / period], abs=1e-3)
    branch = fl.continue_orbit(orbit, "Omega", (3.5, 4.5), max_points=40, progress=False)
    assert (branch.values[0], branch.values[-1]) == (3.5, 4.5)
    sledge, block = Sledge(), fl.MassOnBelt(m=1.0, k=50.0, c=0.2, N=9.81, v=0.3, friction=Sledge().friction)
    orbits = [
        fl.periodic_orbit(one, fl.simulate(one, 20.0, x0={"x": 0.01}, progress=False))
        for one in (sledge, block)
    ]
    assert orbits[0].stable
    assert orbits[0].period == pytest.approx(orbits[1].period, rel=1e-12)


def test_a_motion_that_leaves_its_constraints_does_not_go_on_in_its_mode():
    belt = fl.MassOnBelt(v=0.2)
    run = fl.simulate(belt, 2.0, x0={"x": 0.0, "x'": 0.2}, progress=False)
    assert run.modes_at(0.1) == "stick"
    faster = belt.replace(v=0.25)
    on = solve_from_end(faster.automaton(), 0.01, run(0.1), "stick", progress=False)
    assert on.mode[0] == "slip+"
