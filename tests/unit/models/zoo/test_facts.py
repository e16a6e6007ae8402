"""Each system of the zoo shows what is known of it: closed forms, and integrations that share no code."""

import math
from functools import partial
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve
from scipy.special import ellipk

import frictionlab as fl
from tests.helpers.cases import slow_but
from tests.reference.phases import until_events

pytestmark = pytest.mark.blas


def sorted_values(values):
    return sorted(values, key=lambda one: (round(one.real, 9), one.imag))


# --- oscillators on a belt


def test_a_mass_on_a_belt_that_does_not_vibrate_sticks_and_slips_with_the_period_of_the_arc():
    run = fl.simulate(fl.DitheredOscillator(w=0.0), 40.0, progress=False)
    stops = run.events.t[run.events.guard == "stop"]
    ratio = 0.4 / 0.3  # (mu_s - mu_k) N/(v sqrt(k m))
    assert np.diff(stops)[1:] == pytest.approx(2 * ratio + 2 * math.pi - 2 * math.atan(ratio), rel=1e-9)


@pytest.mark.slow  # 1 s: some 500 periods of the vibration
def test_vibration_across_lowers_the_mean_friction_by_an_elliptic_integral():
    model = fl.DitheredOscillator(w=1.0, Omega=40.0)
    orbit = fl.periodic_orbit(model, fl.simulate(model, 150.0, progress=False))
    x = orbit.trajectory(np.linspace(0.0, orbit.period, 1000, endpoint=False))[:, 0]
    r2 = (model.w / model.v) ** 2
    exact = 2 / (math.pi * math.sqrt(1 + r2)) * ellipk(r2 / (1 + r2)) * model.mu_k * model.N
    assert x.mean() * model.k == pytest.approx(exact, rel=1e-4)  # the mass follows a little, by 1/Omega^2


def test_popp_and_stelter_hopf_point():
    model = fl.PoppStelter(c=0.07, N=1.3, k=2.0)
    speed = model.v_s * (math.sqrt((model.mu_s - model.mu_k) * model.N / (model.c * model.v_s)) - 1)
    point = fl.hopf(model, "v", bounds=(0.2, 6.0))
    assert point.value == pytest.approx(speed, rel=1e-10)
    assert 2 * math.pi * point.frequency == pytest.approx(math.sqrt(2.0), rel=1e-10)


def test_friction_that_strengthens_has_stick_slip_up_to_a_fold_above_its_hopf_point():
    """Papangelo: v_H by the slope of the curve; stick-slip as by DOP853 at 0.65 m/s, and none at 1 m/s."""
    model = fl.WeakeningOscillator(N=1.3, mu_v=0.12, v_s=0.4)
    exact = 0.4 * math.log(0.5 * 1.3 / (0.12 * 1.3 + 0.1 * 0.4))
    assert fl.hopf(model, "v", bounds=(0.2, 1.5)).value == pytest.approx(exact, rel=1e-10)
    model = fl.WeakeningOscillator()
    orbit = fl.periodic_orbit(model, fl.simulate(model, 100.0, progress=False))
    assert orbit.stable
    stick = next(seconds for name, seconds in orbit.modes if name == "stick")

    def slips(_, state):
        x, v = state
        ratio = (0.65 - v) / 0.5
        return [v, 0.5 + 0.5 * math.exp(-ratio) + 0.1 * ratio - x - 0.1 * v]

    begins = [1.0 - 0.1 * 0.65, 0.65 - 1e-12]  # where the spring and the damper tear it off
    slid = solve_ivp(slips, (0.0, 20.0), begins, "DOP853", rtol=1e-12, atol=1e-13, events=until_sticks)
    (t,), ((x, _),) = slid.t_events[0][-1:], slid.y_events[0][-1:]
    assert stick == pytest.approx((begins[0] - x) / 0.65, rel=1e-6)
    assert orbit.period == pytest.approx(stick + t, rel=1e-6)
    fast = fl.simulate(model.replace(v=1.0), 300.0, x0={"x'": 1.0}, progress=False)
    assert np.ptp(fast(np.linspace(280.0, 300.0, 400))[:, 0]) < 1e-3


def until_sticks(t, state):
    """v_r = 0 again, a while after the mass was torn off."""
    return 0.65 - state[1] if t > 0.5 else 1.0


until_sticks.terminal, until_sticks.direction = True, -1.0


@pytest.mark.parametrize("omega", [0.5, 0.8, 1.7])
def test_a_mass_that_slides_on_an_excited_spring_is_linear(omega):
    model = fl.ExcitedBeltOscillator(Omega=omega, v=3.0, c=0.2)
    orbit = fl.periodic_orbit(model, fl.simulate(model, 120.0, progress=False))
    exact = model.u / math.hypot(1 - omega**2, 0.2 * omega)
    t = np.linspace(0.0, orbit.period, 4001)
    assert np.ptp(orbit.trajectory(t)[:, 0]) / 2 == pytest.approx(exact, rel=1e-6)


@pytest.mark.parametrize("masses", [2, 4])
def test_waves_of_a_ring_have_its_eigenvalues(masses):
    model = fl.OscillatorChain(masses=masses, v=0.7)
    slope = -(model.mu_s - model.mu_k) / model.v_s * math.exp(-model.v / model.v_s)
    exact = []
    for j in range(masses):
        stiffness = model.k + 4 * model.k_c * math.sin(math.pi * j / masses) ** 2
        exact += list(np.roots([model.m, model.c + model.N * slope, stiffness]))
    assert sorted_values(fl.eigenvalues(model).values) == pytest.approx(sorted_values(exact), abs=1e-7)


def test_a_ring_of_one_mass_is_drawn():
    """Its forces have no number."""
    assert "data:image" in fl.animate(fl.simulate(fl.OscillatorChain(masses=1), 1.0), fps=1).to_jshtml()


def test_both_layers_of_a_pad_have_the_eigenvalues_of_their_matrices():
    model = fl.DoubleLayerPad(m1=0.7, k2=1.4)
    slope = -(model.mu_s - model.mu_k) / model.v_s * math.exp(-model.v / model.v_s) * model.N
    between, damped = np.array([[1, -1], [-1, 1]]), model.c1 * np.array([[1, -1], [-1, 1]])
    K = model.k1 * between + np.diag([0.0, model.k2])
    C = damped + np.diag([slope, model.c2])
    M = np.diag([model.m1, model.m2])
    A = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
    found = fl.eigenvalues(model).values
    assert sorted_values(found) == pytest.approx(sorted_values(np.linalg.eigvals(A)), abs=1e-12)


@pytest.mark.parametrize("modules", slow_but([1], [1, 3]))
def test_waves_of_modules_have_two_freedoms(modules):
    model = fl.ModularChain(masses=modules, v=0.7)
    slope = -(model.mu_s - model.mu_k) / model.v_s * math.exp(-model.v / model.v_s) * model.N
    exact = []
    for j in range(modules):
        linked = model.k_w + 4 * model.k_c * math.sin(math.pi * j / modules) ** 2
        rub, other = [model.m, model.c + slope, model.k], [model.m_w, model.c, model.k + linked]
        exact += list(np.roots(np.polysub(np.polymul(rub, other), [model.k**2])))
    assert sorted_values(fl.eigenvalues(model).values) == pytest.approx(sorted_values(exact), abs=1e-7)


@pytest.mark.parametrize("seed", slow_but([1], [1, 7]))
def test_noise_shakes_a_mass_that_slides_as_a_linear_oscillator(seed):
    """Parseval's sum of the lines of the spectrum."""
    model = fl.NoisyOscillator(v=20.0, seed=seed)
    orbit = fl.periodic_orbit(model, fl.simulate(model, 400.0, progress=False))
    t = np.linspace(0.0, orbit.period, 4000, endpoint=False)
    w = 0.1 * np.arange(1, 21)
    exact = 0.3**2 / 20 * (1 / ((1 - w**2) ** 2 + (0.1 * w) ** 2)).sum()
    assert orbit.trajectory(t)[:, 0].var() == pytest.approx(exact, rel=1e-9)


# --- mode coupling


def test_hulten_modes_coalesce():
    model = fl.HultenOscillator(c1=0.0, c2=0.0, k1=2.3, m=1.4)
    (change,) = fl.stability_changes(model, "mu", bounds=(0.0, 1.0))
    assert change.value == pytest.approx(1.3 / (2 * math.sqrt(2.3)), rel=1e-9)
    assert 2 * math.pi * change.frequency == pytest.approx(math.sqrt(3.3 / 2.8), rel=1e-6)


def test_one_sided_damping_lowers_the_critical_friction():
    """Routh and Hurwitz: l^4 + a l^3 + b l^2 + d l + e has a pair on the axis at a b d = d^2 + a^2 e."""
    for c1, c2 in ((0.05, 0.05), (0.3, 0.01)):
        model = fl.HultenOscillator(c1=c1, c2=c2)
        k1, k2 = model.k1, model.k2
        a, b, d = c1 + c2, k1 + k2 + c1 * c2, c1 * k2 + c2 * k1
        e = (a * b * d - d**2) / a**2  # which is k1 k2 (1 + mu^2)
        exact = math.sqrt(e / (k1 * k2) - 1)
        assert fl.critical_value(model, "mu", bounds=(0.0, 1.0)) == pytest.approx(exact, rel=1e-9)
    assert exact < model.critical_friction


STRUT = {"theta": -0.7, "mu_k": 0.8, "mu_s": 1.0}  # it pulls away from the belt


@pytest.mark.parametrize("theta", [0.3, -0.7, 0.9])
def test_a_strut_presses_as_spurr_says(theta):
    model = fl.StrutPad(theta=theta)
    exact = model.F / (1 - model.mu_k * math.tan(theta))
    assert fl.equilibrium(model).normal_force == pytest.approx(exact, rel=1e-12)


def test_a_strut_jams_where_mu_tan_theta_is_one():
    jams = math.atan(1 / 0.6)
    assert len(fl.equilibria(fl.StrutPad(theta=0.999 * jams))) == 1
    with pytest.raises(ValueError, match="equilibrium"):
        fl.equilibrium(fl.StrutPad(theta=1.001 * jams))


@pytest.mark.parametrize("theta", [0.3, -0.7])
def test_a_pad_on_a_strut_has_the_eigenvalues_of_its_matrices(theta):
    model = fl.StrutPad(theta=theta, k_n=20.0, m=0.7)
    c, s = math.cos(theta), math.sin(theta)
    K = np.array([[model.k * c * c, -model.k * c * s, 0], [-model.k * c * s, model.k * s * s, 0], [0, 0, 0]])
    K[1:, 1:] += model.k_b * np.array([[1, -1], [-1, 1]])
    K[0, 1] -= model.mu_k * model.k_n
    K[1, 1] += model.k_n
    M = np.diag([model.m, model.m, model.m_b])
    A = np.block([[np.zeros((3, 3)), np.eye(3)], [-np.linalg.solve(M, K), -model.c * np.linalg.inv(M)]])
    found = fl.eigenvalues(model).values
    assert sorted_values(found) == pytest.approx(sorted_values(np.linalg.eigvals(A)), abs=1e-9)


def test_a_pad_that_sticks_slips_and_flies_is_that_of_another_integrator():
    model = fl.StrutPad(**STRUT)
    c, s = math.cos(model.theta), math.sin(model.theta)

    def free(z):
        x, y, w = z[:3]
        bar = model.k * (c * x - s * y)
        forces = -c * bar, s * bar + model.k_b * (w - y), model.k_b * (y - w) + model.F
        return np.array(forces) - model.c * z[3:]

    def rates(tangential, pressed):
        def of(t, z):
            a = free(z)
            if tangential is not None:
                a = a + np.array([tangential * model.k_n * z[1], 0.0, 0.0])
            else:
                a[0] = 0.0
            a[1] -= model.k_n * z[1] if pressed else 0.0
            return np.concatenate([z[3:], a])

        return of

    def breaks(t, z):
        return model.mu_s * model.k_n * z[1] - abs(free(z)[0])

    opens = (lambda t, z: z[1], "flight")
    phases = {
        "slip": (rates(model.mu_k, True), ((lambda t, z: model.v - z[3], "stick"), opens)),
        "stick": (rates(None, True), ((breaks, "slip"), opens)),
        "flight": (rates(0.0, False), ((lambda t, z: -z[1], "slip"),)),
    }
    start = [0.0, 0.5, 3.0, 0.0, 0.0, 0.0]
    z, events = until_events(phases, "slip", start, 12.0)
    run, seen = fl.simulate(model, 12.0, x0=start, progress=False), [phase for _, phase, _ in events]
    assert {*seen} == {"slip", "stick", "flight"}
    assert run.events.target.tolist() == [
        {"slip": "slip+", "flight": "separation"}.get(name, name) for name in seen
    ]
    assert run.final_state == pytest.approx(z, abs=1e-8)


def test_a_pad_and_a_disc_have_the_eigenvalues_of_their_matrices():
    model = fl.PadOnDisc(mu_k=0.7)
    mu = model.mu_k

    def forces(z):
        x1, y1, x2, y2 = z
        force = 1.0 * (y1 - y2) + 5.0 * (y1 - y2) ** 3
        inclined = 0.5 * (x1 + y1)
        pad = -2.0 * x1 - inclined + mu * force, -y1 - inclined - force + 1.0
        return np.array([*pad, -2.0 * x2 - mu * force, -2.0 * y2 + force])

    at = fsolve(forces, np.zeros(4), xtol=1e-12)
    assert fl.equilibrium(model).q == pytest.approx(at, abs=1e-12)
    k = 1.0 + 15.0 * (at[1] - at[3]) ** 2
    K = np.diag([2.5, 1.5, 2.0, 2.0]) + 0.5 * np.array(np.eye(4)[[1, 0, 2, 3]] * [[1], [1], [0], [0]])
    K += k * np.array([[0, -mu, 0, mu], [0, 1, 0, -1], [0, mu, 0, -mu], [0, -1, 0, 1]])
    M = np.diag([1.0, 1.0, 2.0, 2.0])
    A = np.block([[np.zeros((4, 4)), np.eye(4)], [-np.linalg.solve(M, K), -0.05 * np.linalg.inv(M)]])
    found = fl.eigenvalues(model).values
    assert sorted_values(found) == pytest.approx(sorted_values(np.linalg.eigvals(A)), abs=1e-9)


def test_eigenvalues_do_not_tell_of_the_vibration_beside_steady_sliding():
    model = fl.PadOnDisc()
    assert fl.eigenvalues(model).stable
    point = fl.hopf(model, "mu_k", bounds=(0.5, 1.5))
    assert point.criticality == "subcritical"
    assert point.value > model.mu_k
    orbit = fl.periodic_orbit(model, fl.simulate(model, 600.0, progress=False))
    assert orbit.stable
    assert "separation" in dict(orbit.modes)


# --- rotating systems


def disc_matrix(model):
    G = 2 * model.J * model.Omega * np.array([[0, 1], [-1, 0]])
    K = np.diag([model.k_t + 2 * model.k * model.r**2, model.k_t])
    K[1, 0] = -model.mu * model.k * model.h * model.r
    A = np.zeros((4, 4))
    A[:2, 2:], A[2:, :2], A[2:, 2:] = np.eye(2), -K / model.J, -(G + model.d * np.eye(2)) / model.J
    return A


@pytest.mark.parametrize("speed", [2.0, 20.0])
def test_a_disc_wobbles_with_the_eigenvalues_of_its_matrices(speed):
    model = fl.WobblingDisc(Omega=speed)
    exact = sorted_values(np.linalg.eigvals(disc_matrix(model)))
    assert sorted_values(fl.eigenvalues(model).values) == pytest.approx(exact, rel=1e-9, abs=1e-7)


@pytest.mark.parametrize("mu", [0.01, 0.6])
def test_without_a_damper_a_disc_wobbles_at_every_friction(mu):
    assert not fl.eigenvalues(fl.WobblingDisc(d=0.0, mu=mu)).stable


def drill_matrix(model, speed):
    """Of the twist and both speeds."""
    fall = -(model.mu_s - model.mu_k) / model.v_s * math.exp(-speed / model.v_s) * model.T
    table = [-model.k, -model.d - model.c_m, model.d]
    bit = [model.k, model.d, -model.d - fall]
    return np.array([[0.0, 1.0, -1.0], np.array(table) / model.J, np.array(bit) / model.J_b])


def test_a_drill_string_turns_steadily_above_a_speed():
    model = fl.DrillString()
    point = fl.equilibrium(model.replace(Omega=12.0))
    torque = model.T * (0.5 + 0.5 * math.exp(-point.state[2] / 3.0))
    assert model.c_m * (12.0 - point.state[2]) == pytest.approx(torque, rel=1e-10)
    for Omega in (6.0, 12.0):
        slow = model.replace(Omega=Omega)
        exact = np.linalg.eigvals(drill_matrix(slow, fl.equilibrium(slow).state[2]))
        found = [one for one in fl.eigenvalues(slow).values if abs(one) > 1e-9]
        assert sorted_values(found) == pytest.approx(sorted_values(exact), abs=1e-9)


def test_a_bit_that_stops_has_the_period_of_another_integrator():
    """Slip by DOP853; in stick the bit rests until the shaft's torque is the static one."""
    model = fl.DrillString()
    orbit = fl.periodic_orbit(model, fl.steady_state(model, transient=300.0, window=60.0, progress=False))

    def rates(t, z, sticks):
        twist, table, bit = z
        shaft = model.k * twist + model.d * (table - bit)
        rubbing = model.T * (0.5 + 0.5 * math.exp(-bit / 3.0))
        turned = [
            (model.c_m * (model.Omega - table) - shaft) / model.J,
            0.0 if sticks else (shaft - rubbing) / model.J_b,
        ]
        return [table - bit, *turned]

    def loose(t, z):
        return model.T - model.k * z[0] - model.d * z[1]

    phases = {
        "stick": (partial(rates, sticks=True), ((loose, "slip"),)),
        "slip": (partial(rates, sticks=False), ((lambda t, z: z[2], lambda t, z: ("stick", [*z[:2], 0.0])),)),
    }
    _, events = until_events(phases, "stick", [0.5, 2.0, 0.0], 300.0, atol=1e-12)
    period = events[-1][0] - events[-3][0]
    assert orbit.period == pytest.approx(period, rel=1e-9)


def test_a_pendulum_on_a_shaft_hangs_aside():
    model = fl.FroudePendulum(v_s=0.2)
    mu = model.mu_k + (model.mu_s - model.mu_k) * math.exp(-((model.r * model.Omega / 0.2) ** 2))
    aside = math.asin(mu * model.N * model.r / (model.m * model.g * model.l))
    assert fl.equilibrium(model).q[0] == pytest.approx(aside, rel=1e-12)


# --- dynamic friction


def test_lugre_has_the_eigenvalues_of_its_jacobian():
    model = fl.LuGreOscillator(sigma_0=50.0, sigma_1=3.0, v_s=0.2, sigma_2=0.1)
    v, s0, s1, s2 = model.v, 50.0, 3.0, 0.1
    decay = 0.5 * math.exp(-((v / 0.2) ** 2))
    mu, slope = 1.0 + decay, -decay * 2 * v / 0.2**2
    z = mu / s0
    z_z, z_v = -s0 * v / mu, 1 - s0 * z / mu + s0 * v * z / mu**2 * slope  # of z' by z and by v_r
    A = [[0, 1, 0], [-model.k, -(s1 * z_v + s2), s0 + s1 * z_z], [0, -z_v, z_z]]
    found = sorted_values(fl.eigenvalues(model).values)
    assert found == pytest.approx(sorted_values(np.linalg.eigvals(A)), abs=1e-10)


def test_lugre_stick_slip_is_that_of_another_integrator():
    model = fl.LuGreOscillator(sigma_0=1e3, sigma_1=1e3**0.5, v_s=1e-2)

    def rates(t, state):
        x, u, z = state
        v_r = model.v - u
        mu = 1.0 + 0.5 * math.exp(-((v_r / 1e-2) ** 2))
        bristle = v_r - 1e3 * abs(v_r) / mu * z
        return [u, 1e3 * z + 1e3**0.5 * bristle + 0.4 * v_r - 2.0 * x, bristle]

    end = solve_ivp(rates, (0.0, 12.0), [0.0, 0.1, 0.0], "LSODA", rtol=1e-11, atol=1e-13).y[:, -1]
    run = fl.simulate(model, 12.0, x0=[0.0, 0.1], progress=False)
    assert run.final_state == pytest.approx(end, abs=1e-6)


@pytest.mark.parametrize(("speed", "c"), [(0.01, 0.0), (0.1, 0.0), (0.5, 0.0), (0.1, 0.2)])
def test_rate_and_state_has_the_critical_stiffness_of_rice_and_ruina(speed, c):
    """With a damper by Routh and Hurwitz: a N grows, and (b - a) N falls, by c v."""
    model = fl.SpringSlider(v=speed, v_0=0.05, N=1.3, mu_0=1.0, c=c)
    rises, falls = 0.05 * 1.3 + c * speed, 0.03 * 1.3 - c * speed
    exact = falls / 0.1 * (1 + speed**2 / (rises * 0.1))
    assert model.critical_stiffness == pytest.approx(exact, rel=1e-12)
    bounds = (0.5 * model.critical_stiffness, 2 * model.critical_stiffness)
    (change,) = fl.stability_changes(model, "k", bounds=bounds)
    assert change.value == pytest.approx(model.critical_stiffness, rel=1e-9)


@pytest.mark.parametrize(
    ("model", "limits"),
    [
        (fl.JenkinsOscillator(), [0.3 / fl.JenkinsOscillator().k_t]),
        (fl.BoltedJoint(k_t=1.3, mu_k=0.25), 0.25 / 1.3 * np.array([1, 3, 5]) / 3),
    ],
    ids=["Jenkins", "Iwan"],
)
def test_elements_take_the_energy_of_their_loops(model, limits):
    """At the amplitude X each takes 4 k d (X - d), where d is the deflection at which it slips."""
    orbit = fl.periodic_orbit(model, fl.simulate(model, 400.0, progress=False))
    run = fl.simulate(model, orbit.period, x0=orbit.state, sections={"turn": "x'"}, progress=False)
    X = np.ptp(run.sections["turn"].state[:, 0]) / 2
    taken = -fl.energy_audit(run, progress=False).works["friction"][-1]
    loops = 4 * model.k_t / len(limits) * np.sum(limits * np.maximum(X - np.array(limits), 0))
    assert taken == pytest.approx(loops, rel=1e-9)


# --- impacts


def test_a_ball_strikes_its_table_at_the_phase_of_the_closed_form():
    model = fl.BallOnTable(e=0.55, A=1.1, h=12.0)
    orbit = fl.periodic_orbit(model, fl.simulate(model, 400.0, progress=False))
    strike = orbit.trajectory.events
    exact = math.acos(math.pi * 0.45 / (1.55 * 1.1))
    phases = [state[2] for state, guard in zip(strike.state, strike.guard, strict=True) if "impact" in guard]
    assert phases == pytest.approx([exact], abs=1e-9)


def test_bounces_of_one_period_double_where_the_closed_form_says():
    e = 0.6
    model = fl.BallOnTable(e=e)
    orbit = fl.periodic_orbit(model, fl.simulate(model, 400.0, progress=False))
    a = -model.A * math.sin(model.impact_phase)  # of the table at the impact, over g
    trace = 1 + e**2 + (1 + e) ** 2 * a
    assert sorted_values(orbit.multipliers) == pytest.approx(
        sorted_values([1.0, *np.roots([1.0, -trace, e**2])]), abs=1e-8
    )
    doubled = math.hypot(math.pi * (1 - e) / (1 + e), 2 * (1 + e**2) / (1 + e) ** 2)
    for share, stable in ((0.999, True), (1.001, False)):
        near = model.replace(A=share * doubled)
        guess = fl.periodic_orbit(near, orbit.state)
        assert guess.stable == stable


def test_a_block_rocks_as_housner_says():
    model = fl.RockingBlock(e=0.9)
    p, share = math.sqrt(0.75 * model.g / model.R), model.theta_0 / model.alpha
    quarters = [math.acosh(1 / (1 - share)) / p]
    for n in range(1, 5):
        turn = 1 - math.sqrt(1 - 0.9 ** (2 * n) * (1 - (1 - share) ** 2))
        quarters += 2 * [math.acosh(1 / (1 - turn)) / p]
    run = fl.simulate(model, 3.0, progress=False)
    assert run.events.t[:5] == pytest.approx(np.cumsum(quarters)[::2], rel=1e-11)
    assert fl.eigenvalues(model).values == pytest.approx([-p, p], rel=1e-12)


def test_a_gear_rattles_from_flank_to_flank():
    """u from (b - pi u/Omega)^2 + (2 u (1 - e)/((1 + e) Omega))^2 = 4 A^2."""
    model = fl.RattlingGear()
    share = 2 * (1 - model.e) / (1 + model.e)
    u = max(np.roots([math.pi**2 + share**2, -2 * math.pi * model.b, model.b**2 - 4 * model.A**2]))
    phase = math.atan2(-share * u / 2, (model.b - math.pi * u) / 2) % (2 * math.pi)
    start = [math.cos(phase) + 1e-12, u, phase]
    orbit = fl.periodic_orbit(model, start)
    assert orbit.period == pytest.approx(2 * math.pi, rel=1e-12)
    assert np.abs(orbit.trajectory.v).max() == pytest.approx(u, rel=1e-9)


@pytest.mark.parametrize("e", [1.0, 0.7])
@pytest.mark.parametrize("balls", [2, 3, 4])
def test_the_last_ball_of_a_cradle_flies(balls, e):
    model = fl.NewtonsCradle(balls=balls, e=e)
    run = fl.simulate(model, 0.3 * model.period, progress=False)
    assert run.events.t[0] == pytest.approx(model.period / 4, rel=1e-12)
    speed = model.a * math.sqrt(model.g / model.l) * ((1 + e) / 2) ** (balls - 1)
    at = run.t > 0.26 * model.period
    reached = np.hypot(run.q[at, -1], run.v[at, -1])  # of a ball on its string, for g = l
    assert reached == pytest.approx(np.full(at.sum(), speed), rel=1e-9)


FRAMES = ["cone+_2", "off_2", "impact_3", "impact_1", "impact_3", "off_3", "impact_2", "v_r_2"]


def test_a_woodpecker_pecks_as_its_paper_prints():
    """R. I. Leine, C. Glocker, D. H. van Campen, Proc. ASME DETC 2001, VIB-21608.

    Fig. 7: the jammed sleeve slips, leaves the pole, strikes it above, the beak strikes, the sleeve strikes
    above and slides, leaves, strikes below and slides, jams.  The lowest angle of the bird is -0.53 rad.  It
    prints 0.1452 s; here the period is 0.1460 s, and Moreau's scheme agrees (`test_rigid_contacts`).
    """
    model = fl.Woodpecker()
    orbit = fl.periodic_orbit(model, fl.simulate(model, 3.0, progress=False))
    guards = orbit.trajectory.events.guard.tolist()
    guards = guards[guards.index(FRAMES[0]) :] + guards[: guards.index(FRAMES[0])]
    assert [one for one, before in pairwise([*guards, ""]) if one != before] == FRAMES
    assert orbit.trajectory(np.linspace(0.0, orbit.period, 2001))[:, 2].min() == pytest.approx(
        -0.53, abs=5e-3
    )
    assert orbit.period == pytest.approx(0.1452, rel=6e-3)
    assert orbit.stable


def test_a_woodpecker_hangs_and_rings_as_its_paper_prints():
    """It hangs at phi_S = -0.2216 where mu is 0.285 or more; free of the pole it rings at 72.91 Hz."""
    for mu, hangs in ((0.286, True), (0.284, False)):
        model, at = fl.Woodpecker(mu_k=mu, mu_s=mu), -0.0006 / 0.0058
        run = fl.simulate(model, 0.01, x0=[0.0, at, at - 0.1182, 0.0, 0.0, 0.0], progress=False)
        assert (abs(run["y"][-1]) < 1e-9) == hangs
    ring = fl.simulate(fl.Woodpecker(), 1 / (4 * 72.91), x0=[0.0, 0.03, 0.0, 0.0, 0.0, 0.0], progress=False)
    assert not len(ring.events)
    assert abs(ring["phi_M"][-1] - ring["phi_S"][-1]) < 1e-5  # after a quarter of the period


# --- what depends on time, and structures in modes


def test_a_belt_that_brakes_makes_the_motion_of_another_integrator():
    model = fl.BrakedOscillator(v=1.0, t_b=60.0)
    v, fall = model.v, (model.mu_s - model.mu_k) * model.N

    def belt(t):
        return v * (1 - t / 60.0)

    def slip(t, z):
        v_r = belt(t) - z[1]
        return [z[1], model.mu_k * model.N + fall / (1 + v_r / model.v_s) - model.c * z[1] - model.k * z[0]]

    def stick(t, z):
        return [z[1], -v / 60.0]

    def torn(t, z):
        held = model.k * z[0] + model.c * z[1] - model.m * v / 60.0
        return model.mu_s * model.N - held

    phases = {
        "slip": (slip, ((lambda t, z: belt(t) - z[1], "stick"),)),
        "stick": (stick, ((torn, "slip"),)),
    }
    exact, _ = until_events(phases, "slip", [0.9, 0.0], 58.0)
    run = fl.simulate(model, 58.0, x0=[0.9, 0.0], progress=False)
    assert sum("stick" in name for name in run.events.target) > 3
    assert run.final_state[:2] == pytest.approx(exact, abs=1e-8)


def test_a_brake_loses_its_stability_where_time_is_frozen():
    model = fl.BrakedOscillator()
    critical = model.v_s * (math.sqrt((model.mu_s - model.mu_k) * model.N / (model.c * model.v_s)) - 1)
    when = model.t_b * (1 - critical / model.v)
    locus = fl.root_locus(model, "t", [when - 0.01, when + 0.01])
    assert locus.values[0].real.max() < 0 < locus.values[1].real.max()


def test_a_bowed_string_is_that_of_another_integrator():
    model = fl.BowedString(modes=3)
    i = np.arange(1, 4)
    shape, d = np.sin(i * np.pi * model.beta), model.d * i**2

    def free(z):
        return -d * z[3:] - (i * np.pi) ** 2 * z[:3]

    def slip(t, z):
        v_r = model.v - shape @ z[3:]
        friction = (0.3 + 0.5 / (1 + v_r / model.v_s)) * model.N
        return np.concatenate([z[3:], free(z) + 2 / model.m * friction * shape])

    def held(z):
        return -(shape @ free(z)) * model.m / 2 / (shape @ shape)

    def stick(t, z):
        return np.concatenate([z[3:], free(z) + 2 / model.m * held(z) * shape])

    phases = {
        "slip": (slip, ((lambda t, z: model.v - shape @ z[3:], "stick"),)),
        "stick": (stick, ((lambda t, z: 0.8 * model.N - held(z), "slip"),)),
    }
    exact, _ = until_events(phases, "slip", np.zeros(6), 8.0)
    run = fl.simulate(model, 8.0, x0=np.zeros(6), progress=False)
    assert run.events.target.tolist().count("stick") > 2
    assert run.final_state == pytest.approx(exact, abs=1e-8)


@pytest.mark.parametrize("modes", [3, 6, 11])
def test_a_bowed_string_rests_under_its_bow_also_where_modes_have_a_node_there(modes):
    model, i = fl.BowedString(modes=modes), np.arange(1, modes + 1)
    friction = (0.3 + 0.5 / (1 + model.v / 0.1)) * model.N
    exact = 2 / model.m * friction * np.sin(i * np.pi * model.beta) / (i * np.pi) ** 2
    assert fl.equilibrium(model).q == pytest.approx(exact, rel=1e-12, abs=1e-15)


def test_a_mass_on_a_beam_moves_as_by_another_integrator():
    """With the convective terms of its acceleration, written by hand."""
    model = fl.MassOnBeam(d=0.4)
    i = np.arange(1, 4)
    a, half = i * np.pi * model.v, model.m_b / 2

    def rates(t, z):
        q, u = z[:3], z[3:]
        s, c = np.sin(a * t), np.cos(a * t)
        travel = 2 * (a * c) @ u - (a**2 * s) @ q
        M = half * np.eye(3) + model.m * np.outer(s, s)
        forces = -half * (0.4 * u + i**4 * model.w**2 * q) - model.m * s * (model.g + travel)
        return np.concatenate([u, np.linalg.solve(M, forces)])

    exact = solve_ivp(rates, (0.0, 0.6), np.zeros(6), "DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    run = fl.simulate(model, 0.6, progress=False)
    assert run.mode[-1] == "contact"
    assert run.final_state[[1, 2, 3, 5, 6, 7]] == pytest.approx(exact, abs=1e-8)


@pytest.mark.parametrize(("diameters", "theta"), [(3, 0.25), (2, 0.35)])
def test_pads_separate_and_couple_the_modes_of_a_disc(diameters, theta):
    model = fl.DiscAndPads(c=0.0, diameters=diameters, theta=theta, h=0.04)
    exact = 2 * 0.13 / (diameters * 0.04) * abs(1 / math.tan(2 * diameters * theta))
    assert fl.critical_value(model, "mu", bounds=(0.0, 3.0)) == pytest.approx(exact, rel=1e-9)


def test_a_motor_and_its_cart_are_those_of_another_integrator():
    """While the motor turns on, the cart's friction changes its sign with sin(a)."""
    model = fl.MotorAndCart(U=3.0)

    def rates(t, z):
        a, u, current = z
        s, c = math.sin(a), math.cos(a)
        friction = -model.r * abs(s) * model.mu_k * model.N
        forces = model.K * current - model.b * u - model.m * model.r**2 * s * c * u**2 + friction
        return [u, forces / (model.J + model.m * (model.r * s) ** 2), (3.0 - current - 0.3 * u) / 0.1]

    phases = {  # to each dead centre, where the right-hand side has a kink
        turn: (rates, ((lambda t, z, turn=turn: turn * math.pi - z[0], turn + 1),)) for turn in range(1, 9)
    }
    z, events = until_events(phases, 1, [0.3, 4.0, 1.0], 2.5)
    assert len(events) > 2
    run = fl.simulate(model, 2.5, x0={"alpha": 0.3, "alpha'": 4.0, "i": 1.0}, progress=False)
    assert run.final_state == pytest.approx(z, abs=1e-8)
