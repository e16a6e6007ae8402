"""What motions settle to, against closed forms, dense samples and runs cut otherwise."""

import numpy as np
import pytest
import sympy as sp

import frictionlab as fl
from frictionlab.analysis.steady_state.steady_state import steady_state_of_window
from tests.helpers.automata import V, X, automaton, ball, coulomb, oscillator
from tests.helpers.known_motions import settled

MODEL = fl.SliderOnBelt()
FLAT = MODEL.without("geometry")
FULL = MODEL.replace(impact=fl.PlasticImpact(penetration_rate="full"))
LINEAR = MODEL.without("cubic", "nonsmooth", "geometry")
STIFF = MODEL.replace(F=800.0, k_nl=1e7, k4=5e6, k5=5e6, k6=5e6, mu_k=2.5)


def coulomb_cycle(v, static, kinetic):
    """Period and intensity of a unit mass on a unit spring: stick from x = 2 kinetic - static to static."""
    amplitude, drop = np.hypot(v, static - kinetic), static - kinetic
    sticks, slips = 2 * drop / v, 2 * (np.pi - np.arctan2(drop, v))
    # About x = kinetic: a ramp of height `drop` on either side, and a sine that starts at (drop, v).
    ramp = 2 * drop**3 / (3 * v)
    start = np.arctan2(drop, v)
    sine = amplitude**2 / 2 * (slips - (np.sin(2 * (start + slips)) - np.sin(2 * start)) / 2)
    return sticks, sticks + slips, (ramp + sine) / (sticks + slips)


@pytest.mark.parametrize(("v", "static", "kinetic"), [(0.2, 1.0, 0.5), (1.0, 2.0, 1.5)])
def test_a_mass_on_a_belt_sticks_once_in_the_period_of_the_closed_form(v, static, kinetic):
    sticks, period, intensity = coulomb_cycle(v, static, kinetic)
    found = settled(coulomb(v, static, kinetic), transient=30.0, window=60.0)
    assert (found.kind, found.onsets_per_period, found.settled) == ("periodic", 1, True)
    assert found.period == pytest.approx(period, rel=1e-12)
    assert found.intensity == pytest.approx(intensity, rel=1e-11)
    assert np.allclose(found.section.state, [2 * kinetic - static, v], atol=1e-12)
    long = settled(coulomb(v, static, kinetic), transient=30.0, window=200 * period)
    assert long.time_in_mode["stick"] == pytest.approx(sticks / period, rel=1e-9)
    assert sum(long.time_in_mode.values()) == pytest.approx(1.0, abs=1e-12)


def test_an_oscillator_has_half_its_squared_amplitude():
    found = settled(oscillator(), [0.3, 0.4], transient=0.0, window=100.0)
    assert (found.kind, found.onsets_per_period, found.transient) == ("periodic", 0, 0.0)
    assert found.period == pytest.approx(2 * np.pi, rel=1e-13)
    assert found.intensity == pytest.approx(0.125, rel=1e-13)


def test_two_incommensurate_oscillators_are_not_periodic_and_commensurate_ones_are():
    y, w = sp.symbols("y w")
    square = sp.Symbol("square")
    pair = fl.Mode("only", (V, w, -X, -square * y))

    def of(value):
        both = automaton(pair, states=(X, y, V, w), coordinates=2, square=value)
        return settled(both, [1.0, 0.5, 0.0, 0.3], transient=0.0, window=400.0)

    golden = of((0.5 + np.sqrt(1.25)) ** 2)
    assert golden.kind in ("non-periodic", "not settled yet")
    third = of((5 / 3) ** 2)
    assert (third.kind, third.period) == ("periodic", pytest.approx(6 * np.pi, rel=1e-12))


def test_a_ball_comes_to_rest():
    found = settled(ball(), [1.0, 0.0], transient=5.0, window=5.0)
    assert (found.kind, found.time_in_mode["rest"]) == ("equilibrium", 1.0)


def test_a_linear_scene_settles_to_its_equilibrium():
    found = settled(LINEAR, transient=300.0, window=50.0)
    assert (found.kind, found.time_in_mode) == ("equilibrium", {"slip": 1.0})
    assert found.intensity < 1e-12
    assert np.allclose(found.trajectory.final_state[:4], fl.equilibrium(LINEAR).q, rtol=1e-4)
    assert np.isnan(found.period)


def test_the_transient_tells_settling_from_settled():
    assert settled(LINEAR, transient=10.0, window=20.0).kind == "not settled yet"
    longer = settled(LINEAR, transient=10.0, window=20.0, t_max=500.0)
    assert longer.kind == "equilibrium"
    assert 100 < longer.transient < 400
    cut = settled(LINEAR, transient=10.0, window=20.0, t_max=80.0)
    assert (cut.kind, cut.transient) == ("not settled yet", 50.0)


def test_the_exact_equilibrium_is_one_though_unstable():
    model = LINEAR.replace(mu_k=2.5)
    start = np.append(fl.equilibrium(model).q, np.zeros(4))
    assert settled(model, start, transient=0.0, window=1.0).kind == "equilibrium"


@pytest.mark.parametrize("above", [1e-4, 1e-2, 0.5])
def test_growth_without_bound_is_no_motion_that_has_settled(above):
    model = LINEAR.replace(mu_k=fl.critical_value(LINEAR, "mu_k", (0.0, 3.0)) + above)
    assert fl.eigenvalues(model).growth_rates.max() > 0
    found = settled(model, "near", transient=5.0, window=20.0)
    assert (found.kind, found.settled) == ("not settled yet", False)


def test_overflow_is_told_and_has_no_intensity():
    found = settled(LINEAR.replace(mu_k=2.5), transient=100.0, window=10.0)
    assert found.kind == "ended early"
    assert "overflowed" in repr(found)
    assert np.isnan(found.intensity)
    assert not found.settled
    assert np.array_equal(found.section.state, found.trajectory.final_state[None])
    stopped = settled(MODEL, transient=0.0, window=10.0, method=fl.Taylor(max_steps=50))
    assert "step cap" in repr(stopped)


def test_no_mode_to_start_in_is_told():
    ending = fl.Mode("only", (sp.Integer(-1),), (fl.Event("x", X),))
    found = settled(automaton(ending, states=(X,), coordinates=0), [1.0], transient=5.0, window=1.0)
    assert found.kind == "ended early"
    assert "no admissible mode" in repr(found)


def test_a_slider_that_leaves_for_good():
    found = settled(MODEL.replace(F=-5.0), transient=250.0, window=50.0)
    assert (found.kind, found.time_in_mode["separation"]) == ("equilibrium", 1.0)
    assert np.isnan(found.intensity)


def test_a_belt_at_rest_holds_the_slider():
    found = settled(MODEL.replace(v=0.0), transient=300.0, window=50.0)
    assert (found.kind, found.time_in_mode["stick"]) == ("equilibrium", 1.0)


@pytest.fixture(scope="module")
def cycle():
    return settled(FLAT.replace(mu_k=1.4), transient=150.0, window=50.0)


def test_the_cycle_from_rest(cycle):
    assert (cycle.kind, cycle.onsets_per_period) == ("periodic", 1)
    assert 1 / cycle.period == pytest.approx(11.048, abs=5e-4)
    assert cycle.intensity == pytest.approx(0.0011702, rel=1e-4)


def test_intensity_is_that_of_dense_samples(cycle):
    run, point = cycle.trajectory, fl.equilibrium(cycle.model).q
    count = 200_000
    times = run.raw.t - cycle.period + (np.arange(count) + 0.5) * (cycle.period / count)
    sampled = ((run(times)[:, :4] - point) ** 2).sum(axis=1).mean()
    assert cycle.intensity == pytest.approx(sampled, rel=1e-7)


def test_the_state_returns_after_a_period(cycle):
    run = cycle.trajectory
    apart = np.abs(run(run.raw.t) - run(run.raw.t - cycle.period))
    assert (apart < 1e-6 * np.ptp(run.states, axis=0)).all()


@pytest.mark.parametrize("section", ["stick", ("x1'", -1), ("x1 - x2", 1), ("penetration", -1), "1e-3*x1'"])
def test_period_and_intensity_do_not_depend_on_the_section(cycle, section):
    found = steady_state_of_window(cycle.model, cycle.trajectory, None, 1e-6, passed=0.0)
    other = settled(cycle.model, cycle.trajectory(0.0), transient=0.0, window=20.0, section=section)
    assert other.period == pytest.approx(found.period, rel=1e-9)
    assert other.intensity == pytest.approx(found.intensity, rel=1e-9)
    assert other.onsets_per_period == 1


def test_the_papers_algorithm_finds_the_same_cycle_to_its_step(cycle):
    found = settled(cycle.model, transient=60.0, window=10.0, method=fl.RK4(step=2e-4))
    assert (found.kind, found.onsets_per_period) == ("periodic", 1)
    assert found.period == pytest.approx(cycle.period, rel=1e-6)
    assert found.intensity == pytest.approx(cycle.intensity, rel=1e-4)


@pytest.mark.parametrize(("mu_k", "transient"), [(0.4, 200.0), (1.4, 120.0), (2.9, 80.0)])
def test_a_spiral_into_a_cycle_is_of_its_period_and_never_of_a_multiple(mu_k, transient):
    found = settled(FULL.replace(mu_k=mu_k), transient=transient, window=40.0)
    assert (found.kind, found.onsets_per_period) == ("periodic", 1)
    assert 1 / found.period == pytest.approx(11.05, abs=0.03)


def test_a_spiral_that_is_still_far_from_its_cycle_is_not_settled_yet():
    assert settled(FULL.replace(mu_k=1.4), transient=60.0, window=40.0).kind == "not settled yet"


@pytest.mark.slow
def test_three_onsets_in_a_period_are_not_one():
    found = settled(MODEL.replace(mu_k=1.4), transient=60.0, window=20.0)
    assert (found.kind, found.onsets_per_period) == ("periodic", 3)
    assert 1 / found.period == pytest.approx(3.56, abs=5e-3)
    assert found.intensity == pytest.approx(0.0138, abs=1e-4)


def test_sliding_only_settles_to_a_cycle_without_events():
    model = STIFF.without("nonsmooth", "geometry")
    assert settled(model, transient=20.0, window=10.0).kind == "not settled yet"
    found = settled(model, transient=250.0, window=50.0)
    assert (found.kind, found.onsets_per_period) == ("periodic", 0)
    assert len(found.trajectory.events) == 0
    turning = found.trajectory(found.section.t)
    assert np.allclose(turning[:, 4], 0.0, atol=1e-8)


def test_the_spectrum_shows_the_period(cycle):
    frequencies, heights = cycle.spectrum().peaks()
    assert frequencies[0] == pytest.approx(1 / cycle.period, abs=0.05 / 50.0)
    assert (np.diff(heights) <= 0).all()
    assert cycle.spectrum("y2").resolution == pytest.approx(1 / 50.0)
