"""The textbook models against their closed forms."""

import numpy as np
import pytest
from scipy.optimize import brentq

import frictionlab as fl
from tests.helpers.assertions import assert_all, assert_same_times

PERIOD = 5 + 2 * np.pi - 2 * np.arctan(2.5)  # stick 2 a/v, slip 2 pi - 2 atan(a/v); a = 0.5, v = 0.2


def onsets_of(run, name="stick"):
    return run.events.t[run.events.target == name]


# --- mass on a belt


def test_stick_slip_has_its_period():
    assert abs(PERIOD - 8.902605407815) < 1e-12
    run = fl.simulate(fl.MassOnBelt(), 60.0, progress=False)
    onsets = onsets_of(run)
    assert len(onsets) > 5
    assert np.diff(onsets)[1:] == pytest.approx(PERIOD, abs=1e-12)  # the first is from rest
    orbit = fl.periodic_orbit(fl.MassOnBelt(), run)
    assert orbit.period == pytest.approx(PERIOD, abs=1e-12)
    assert dict(orbit.modes) == pytest.approx({"stick": 5.0, "slip+": PERIOD - 5}, abs=1e-12)


@pytest.mark.parametrize(("m", "k", "N", "v"), [(2.0, 3.0, 0.7, 0.1), (0.5, 40.0, 5.0, 1.3)])
def test_stick_slip_in_other_units(m, k, N, v):
    model = fl.MassOnBelt(m=m, k=k, N=N, v=v, mu_k=0.3, mu_s=0.9)
    a, w = 0.6 * N / k, np.sqrt(k / m)
    period = 2 * a / v + (2 * np.pi - 2 * np.arctan(a * w / v)) / w
    # From rest it would slide for ever; the belt takes it along until it slips.
    run = fl.simulate(model, 20 * period, x0=[0.0, v], progress=False)
    onsets = onsets_of(run)
    assert len(onsets) > 15
    assert np.diff(onsets)[1:] == pytest.approx(period, rel=1e-12)


def test_the_belt_may_run_the_other_way():
    there, back = (fl.simulate(fl.MassOnBelt(v=v), 20.0, progress=False) for v in (0.2, -0.2))
    assert_same_times(back.events.t, there.events.t, abs=1e-13)
    assert back.final_state == pytest.approx(-there.final_state, abs=1e-12)
    assert set(back.events.target) == {"stick", "slip-"}


WEAKENING = {"mu_k": 0.5, "mu_s": 1.0, "v_s": 0.4, "mu_v": 0.05}


@pytest.mark.parametrize(("m", "c", "k", "N"), [(1.0, 0.1, 1.0, 1.0), (2.0, 0.3, 5.0, 1.7)])
def test_the_hopf_point_of_weakening_and_strengthening_friction(m, c, k, N):
    """At c + N mu'(v) = 0; m x'' + ... = G(x') has Re(cubic) = G''' w^2/(4 m (1 + w^2)), and G''' > 0."""
    friction = fl.WeakeningStrengthening(**WEAKENING)
    model = fl.MassOnBelt(m=m, c=c, k=k, N=N, v=1.0, friction=friction)
    v_s, fall = friction.v_s, friction.mu_s - friction.mu_k
    critical = v_s * np.log(fall / (friction.mu_v + c * v_s / N))
    point = fl.hopf(model, "v", (0.05, 3.0))
    w = np.sqrt(k / m)
    assert point.value == pytest.approx(critical, rel=1e-10)
    assert point.frequency == pytest.approx(w / (2 * np.pi), rel=1e-10)
    assert point.criticality == "subcritical"
    third = N * fall / v_s**3 * np.exp(-critical / v_s)
    assert point.cubic.real == pytest.approx(third * w**2 / (4 * m * (1 + w**2)), rel=1e-9)
    # d(growth rate)/dv = -N mu''(v)/(2 m)
    assert point.crossing_speed == pytest.approx(
        -N * fall / v_s**2 * np.exp(-critical / v_s) / (2 * m), rel=1e-9
    )


def test_stick_slip_lives_beside_stable_sliding():
    """Above the Hopf point, as it is subcritical: from rest stick-slip, from near the equilibrium rest."""
    model = fl.MassOnBelt(c=0.1, friction=fl.WeakeningStrengthening(**WEAKENING))
    model = model.replace(v=1.02 * fl.hopf(model, "v", (0.05, 3.0)).value)
    assert fl.eigenvalues(model).stable
    kinds = [
        fl.steady_state(model, x0, transient=3000.0, window=1000.0, progress=False).kind
        for x0 in ([0.0, model.v], "near")
    ]
    assert kinds == ["periodic", "equilibrium"]


def test_stribecks_slope_is_a_damper():
    model = fl.MassOnBelt(c=0.1, v=0.3, friction=fl.Stribeck(mu_k=0.5, mu_s=1.0, v_s=0.5, mu_v=0.02))
    slope = -2 * 0.5 * 0.3 / 0.5**2 * np.exp(-((0.3 / 0.5) ** 2)) + 0.02
    found, exact = fl.eigenvalues(model).values, np.roots([1.0, 0.1 + slope, 1.0])
    assert np.sort_complex(found) == pytest.approx(np.sort_complex(exact), rel=1e-12)
    curve = 0.5 + 0.5 * np.exp(-((0.3 / 0.5) ** 2)) + 0.02 * 0.3
    assert fl.equilibrium(model).q[0] == pytest.approx(curve, rel=1e-13)


# --- a free oscillator


def test_free_coulomb_turns_where_it_should_and_stops_for_ever():
    run = fl.simulate(fl.FreeCoulomb(), 1000.0, progress=False)
    assert run.events.t == pytest.approx(np.pi * np.arange(1, 6), abs=1e-12)
    assert run.events.state[:, 0] == pytest.approx([-8.3, 6.3, -4.3, 2.3, -0.3], abs=1e-12)
    assert run.events.target.tolist() == ["slip-", "slip+", "slip-", "slip+", "stick"] or (
        run.events.target.tolist() == ["slip+", "slip-", "slip+", "slip-", "stick"]
    )
    assert run.final_state == pytest.approx([-0.3, 0.0], abs=1e-12)
    assert run.final_state[1] == 0.0


# --- Den Hartog

HARTOG = {(0.8, 0.3): 2.626104875723, (1.3, 0.4): 1.200900612358, (0.7, 0.5): 1.744253936249}


@pytest.mark.parametrize(("ratio", "friction"), HARTOG)
def test_den_hartogs_amplitude(ratio, friction):
    model = fl.DenHartog(Omega=ratio, N=friction)
    orbit = fl.periodic_orbit(model, fl.simulate(model, 100.0, progress=False))
    amplitude, period = HARTOG[ratio, friction], 2 * np.pi / ratio
    response, damping = 1 / (1 - ratio**2), np.sin(np.pi / ratio) / (ratio * (1 + np.cos(np.pi / ratio)))
    assert amplitude == pytest.approx(np.sqrt(response**2 - (friction * damping) ** 2), abs=1e-12)
    events = orbit.trajectory.events
    turns = events.state[events.guard == "v_r", 0]
    assert orbit.period == pytest.approx(period, abs=1e-12)
    assert np.sort(turns) == pytest.approx([-amplitude, amplitude], abs=1e-12)
    assert orbit.stable


def test_a_force_below_the_limit_moves_nothing():
    run = fl.simulate(fl.DenHartog(N=1.01), 100.0, progress=False)
    assert not run.states[:, :2].any()
    assert set(run.mode) == {"stick"}


# --- Hoffmann


@pytest.mark.parametrize("changes", [{}, {"k1": 2.0, "k3": 1.0, "a1": 0.7}, {"m": 3.0, "k2": 0.2}])
def test_mode_coupling_sets_in_at_hoffmanns_coefficient(changes):
    model = fl.ModeCoupling(c=0.0, **changes)
    k11, k12, k22 = model.stiffnesses
    critical = (k12**2 + ((k11 - k22) / 2) ** 2) / (k12 * model.k3)
    (change,) = fl.stability_changes(model, "mu_k", (0.0, 4.0))
    assert change.value == pytest.approx(critical, rel=1e-9)
    assert change.frequency == pytest.approx(np.sqrt((k11 + k22) / (2 * model.m)) / (2 * np.pi), rel=1e-6)
    assert model.critical_friction == pytest.approx(critical, rel=1e-15)
    at = fl.eigenvalues(model.replace(mu_k=0.5 * critical, mu_s=4.0)).values
    roots = np.roots([1.0, k11 + k22, k11 * k22 - k12 * (k12 - 0.5 * critical * model.k3)])
    squares = np.sqrt(-np.roots([model.m**2, model.m * (k11 + k22), np.prod(roots)]).real)
    assert np.unique(np.abs(at.imag).round(9)) == pytest.approx(np.sort(squares), abs=1e-8)


def test_at_its_critical_friction_the_frequencies_are_one():
    model = fl.ModeCoupling(c=0.0)
    model = model.replace(mu_k=model.critical_friction)
    frequencies = np.abs(fl.eigenvalues(model).values.imag)
    assert frequencies == pytest.approx(model.critical_frequency, rel=1e-7)  # a double root


def test_equal_damping_of_both_modes_shifts_every_growth_rate():
    """c along both axes: the eigenvalues are those without it, of s^2 + (c/m) s."""
    free, damped = (fl.eigenvalues(fl.ModeCoupling(c=c, mu_k=0.8)).values for c in (0.0, 0.2))
    exact = np.concatenate([np.roots([1.0, 0.2, -(s**2)]) for s in free[free.imag > 0]])
    apart = np.abs(damped[:, None] - exact[None, :])
    assert max(apart.min(axis=0).max(), apart.min(axis=1).max()) < 1e-12


# --- a slider on a rigid belt


def stiffnesses(model):
    """k11, k12, k22 without the contact."""
    along, slope = np.cos(model.a), np.sin(model.a)
    return model.k1 + model.k3 * along**2, model.k3 * slope * along, model.k3 * slope**2


def preloads(model):
    """The preloads between which an undamped slider flutters, from the contact stiffnesses there."""
    k11, k12, k22 = stiffnesses(model)
    softening = k11 - k22 + 2 * model.mu_k * k12
    half = np.sqrt(softening**2 - (k11 - k22) ** 2 - 4 * k12**2)
    y = np.sqrt((softening + np.array([-half, half]) - model.contact.k2) / (3 * model.contact.k_nl))
    normal_force = model.contact.force(y)
    x = (model.mu_k * normal_force - k12 * y) / k11
    return k12 * x + k22 * y + normal_force


@pytest.mark.parametrize(
    "changes",
    [
        {"mu_k": 0.7, "a": 0.6},
        {},
        {"m": 3.0, "k3": 9e3, "k_nl": 4e8},
    ],
)
@pytest.mark.slow
def test_a_harder_pressure_sets_flutter_in_and_ends_it(changes):
    model = fl.SliderOnRigidBelt(c=0.0, **changes)
    exact = preloads(model)
    changes = fl.stability_changes(model, "F", (1.0, 1.5 * exact[1]))
    assert [change.value for change in changes] == pytest.approx(exact, rel=1e-9)
    there = 0.9 * exact[0], exact.mean(), 1.1 * exact[1]
    soft, between, hard = (fl.eigenvalues(model.replace(F=F)).growth_rates.max() for F in there)
    assert between > 1.0
    assert max(abs(soft), abs(hard)) < 1e-9


def test_flight_over_the_belt_is_linear():
    """Lifted off and let go, it comes back where the sum of two modes says."""
    model = fl.SliderOnRigidBelt(c=0.0, F=30.0)
    k11, k12, k22 = stiffnesses(model)
    squares, shapes = np.linalg.eigh(np.array([[k11, k12], [k12, k22]]) / model.m)
    rest = np.linalg.solve([[k11, k12], [k12, k22]], [0.0, model.F])
    start, rate = np.array([0.01, -0.002]), np.array([0.2, -0.7])
    along, across, w = shapes.T @ (start - rest), shapes.T @ rate, np.sqrt(squares)

    def place(t):
        return rest + shapes @ (along * np.cos(w * t) + across / w * np.sin(w * t))

    run = fl.simulate(model, 0.1, x0=[*start, *rate], progress=False)
    assert (run.mode[0], run.events.source[0], run.events.guard[0]) == ("separation", "separation", "gap")
    landing = brentq(lambda t: place(t)[1], 1e-3, run.events.t[0] + 1e-3, xtol=1e-15)
    assert run.events.t[0] == pytest.approx(landing, abs=1e-13)
    assert run.events.state[0, :2] == pytest.approx(place(landing), abs=1e-13)


def test_a_fluttering_slider_leaves_the_belt_and_comes_back():
    run = fl.simulate(fl.SliderOnRigidBelt(), 2.0, x0="near", progress=False)
    assert {"stick", "slip+", "separation"} <= set(run.events.target)
    assert_all(run.normal_force[run.mode != "separation"] > -1e-9)
    assert_all(run.penetration[run.mode == "separation"] < 1e-12)


# --- impacts


@pytest.mark.parametrize(("e", "h"), [(0.5, 1.0), (0.8, 2.5), (0.1, 0.3)])
def test_a_ball_comes_to_rest_in_a_finite_time(e, h):
    model = fl.BouncingBall(e=e, h=h)
    fall = np.sqrt(2 * h / model.g)
    end = fall * (1 + e) / (1 - e)
    run = fl.simulate(model, 2 * end, progress=False)
    bounces = fall + 2 * fall * np.cumsum(e ** np.arange(1, 11))
    assert run.events.t[0] == pytest.approx(fall, rel=1e-15)
    assert run.events.t[1:11] == pytest.approx(bounces, rel=1e-12)
    assert run.events.t[-1] == pytest.approx(end, rel=1e-10)
    assert run.mode[-1] == "contact"
    assert run.final_state.tolist() == [0.0, 0.0]


def test_a_ball_without_loss_bounces_for_ever():
    run = fl.simulate(fl.BouncingBall(e=1.0), 500.0, progress=False)
    assert len(run.events) > 500
    assert np.diff(run.events.t) == pytest.approx(2 * np.sqrt(2 / 9.81), rel=1e-12)


def shaw_and_holmes(Omega, e, d, n=1):
    """Phase p and speed V just after the impact of the motion with one impact in n periods; m = k = F = 1."""
    A, T = 1 / (1 - Omega**2), 2 * np.pi * n / Omega

    def missing(V):
        cos = (d + V * (1 + e) / (2 * e * np.tan(T / 2))) / A
        return cos**2 + (V * (1 - e) / (2 * e * A * Omega)) ** 2 - 1

    V = brentq(missing, 1e-9, 50.0, xtol=1e-15)
    cos, sin = (d + V * (1 + e) / (2 * e * np.tan(T / 2))) / A, -V * (1 - e) / (2 * e * A * Omega)
    return np.arctan2(sin, cos) % (2 * np.pi), V, T


@pytest.mark.parametrize(("Omega", "e", "d"), [(2.5, 0.8, 0.0), (2.8, 0.6, 0.05), (2.2, 0.9, 0.0)])
def test_one_impact_in_a_period_of_the_force(Omega, e, d):
    """The phase and the speed after the impact, from linear motion between two of them."""
    model = fl.ImpactOscillator(Omega=Omega, e=e, d=d)
    phase, V, T = shaw_and_holmes(Omega, e, d)
    guess = fl.simulate(model, 0.5 * T, x0=[d, -V, phase], progress=False).final_state
    orbit = fl.periodic_orbit(model, guess, period=T)
    events = orbit.trajectory.events
    (after,) = events.state[events.guard == "impact"]
    assert orbit.period == pytest.approx(T, rel=1e-12)
    assert after == pytest.approx([d, -V, phase], abs=1e-10)


def test_pressed_by_a_force_the_mass_stays_at_the_stop():
    """At a low frequency its bounces accumulate, and it lies there until the force lets go: k d = F cos p."""
    model = fl.ImpactOscillator(Omega=0.05, d=0.3, e=0.4)
    run = fl.simulate(model, 60.0, progress=False)
    (leaves,) = run.events.state[run.events.source == "contact"][:1]
    assert leaves[:2].tolist() == [0.3, 0.0]
    assert np.cos(leaves[2]) == pytest.approx(0.3, abs=1e-12)
    assert run.stats["accumulations"] >= 1


# --- two blocks


def test_alike_two_blocks_move_as_one():
    run = fl.simulate(fl.TwoBlocks(), 80.0, progress=False)
    assert np.diff(onsets_of(run, "stick | stick"))[1:] == pytest.approx(PERIOD, abs=1e-11)
    apart = np.abs(run["x1"] - run["x2"])  # rounding, which grows as one slips or sticks before the other
    assert apart[run.t < 40.0].max() < 2e-13
    assert apart.max() < 1e-10


def test_two_blocks_slide_with_two_frequencies():
    values = np.abs(fl.eigenvalues(fl.TwoBlocks(m1=2.0, m2=2.0, k1=3.0, k2=3.0, k12=0.9)).values.imag)
    exact = np.sqrt([3.0 / 2, 3.0 / 2, (3 + 1.8) / 2, (3 + 1.8) / 2])
    assert np.sort(values) == pytest.approx(np.sort(exact), rel=1e-12)


def test_one_block_slides_on_while_the_other_sticks():
    """The second held fast, the first oscillates about (N1 mu_k + k12 x2)/(k1 + k12) until it turns."""
    model = fl.TwoBlocks(v=0.0, N2=100.0, k1=2.0, k12=1.5)
    run = fl.simulate(model, 2.0, x0=[1.0, 0.1, -0.5, 0.0], progress=False)
    w, middle = np.sqrt(3.5), (0.5 + 1.5 * 0.1) / 3.5
    first = run.t < run.events.t[0]
    exact = middle + (1 - middle) * np.cos(w * run.t) - 0.5 / w * np.sin(w * run.t)
    assert run.mode[0] == "slip+ | stick"
    assert np.tan(w * run.events.t[0]) == pytest.approx(-0.5 / w / (1 - middle), abs=1e-12)
    assert run["x1"][first] == pytest.approx(exact[first], abs=1e-14)
    assert (run["x2"] == 0.1).all()
