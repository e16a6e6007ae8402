"""Chaos and grazing of systems with impacts: exponents known exactly, or found without the package."""

import numpy as np
import pytest
import sympy as sp

import frictionlab as fl
from tests.helpers.automata import V, X, automaton
from tests.helpers.impact_map import Oscillator, exponents, growth
from tests.helpers.known_motions import logistic

C, S = sp.symbols("c s")
RATIO, RESTITUTION = 2.8, 0.8


def impact_oscillator(drawn, **parameters):
    """x'' + 2 zeta x' + x = f cos(omega t), x < sigma, where an impact leaves e of the speed.

    cos and sin are states; `drawn` is by how much they are drawn to the unit circle.
    """
    omega, sigma, e, zeta, f = sp.symbols("omega sigma e zeta f")
    pull = drawn * (1 - C**2 - S**2)
    stop = fl.Event("stop", sigma - X, ("free",), fl.Reset({X: sigma, V: -e * V}))
    flow = (V, f * C - X - 2 * zeta * V, -omega * S + pull * C, omega * C + pull * S)
    return automaton(fl.Mode("free", flow, (stop,)), states=(X, V, C, S), **parameters)


def test_a_ball_that_doubles_its_errors_has_the_exponent_ln_2():
    """It leaves the floor with 4 u (1 - u), u its speed at the impact.

    The logistic map's exponent is ln 2 an impact (Ott, Chaos in Dynamical Systems, 2002), and as the mean
    of u is 1/2 a flight of 2 u takes a second in the mean.
    """
    found = fl.lyapunov(logistic(4.0), [0.3, 0.1], transient=50.0, t_end=4000.0, progress=False)
    assert found.exponents[0] == pytest.approx(np.log(2), abs=4 * found.standard_errors[0])
    assert found.exponents[1] == pytest.approx(0.0, abs=4 * found.standard_errors[1])
    assert found.standard_errors[0] < 0.01
    assert found.chaotic


def test_a_ball_on_a_shaking_table_has_chirikovs_exponent():
    """Far above the table its height does not matter (Holmes, J. Sound and Vibration 84 (1982) 173-189): with
    g = 1 an impact adds w sin(phase) to the speed u, and the phase goes on by 2 u.  That is the standard map
    with K = 2 w, whose exponent is ln(K/2) an impact (Chirikov, Physics Reports 52 (1979) 263-379), within
    0.3 % at K = 20.
    """
    speed, impacts, kick = 1e6, 8000, 10.0
    y, v, phase = sp.symbols("y v phase")
    impact = fl.Event("impact", y, ("flight",), fl.Reset({v: -v + kick * sp.sin(phase)}, {y: 1}))
    ball = fl.HybridAutomaton(
        (y, v, phase), (fl.Mode("flight", (v, -sp.S.One, sp.S.One), (impact,)),), {}, coordinates=1
    )
    t_end = 2 * speed * impacts  # the speed stays within a thousandth of its first value
    found = fl.lyapunov(ball, [0.0, speed, 0.5], transient=100 * speed, t_end=t_end, progress=False)
    each, error = (values[0] * 2 * speed for values in (found.exponents, found.standard_errors))
    assert each == pytest.approx(np.log(10), abs=4 * error + 0.003 * np.log(10))
    assert error < 0.01 * np.log(10)
    assert found.exponents.sum() * 2 * speed == pytest.approx(0.0, abs=1e-6)  # no loss: areas are kept


def by_hand(impacts, **parameters):
    """Both exponents and their standard errors, from impact to impact."""
    growths, times, _ = growth(Oscillator(Omega=RATIO, e=RESTITUTION, **parameters), 0.0, -1.0, impacts)
    parts = exponents(growths[100:], times[100:])
    return parts.mean(axis=0), parts.std(axis=0, ddof=1) / np.sqrt(len(parts))


def test_a_chaotic_impact_oscillator():
    """Against the same by hand; each impact shrinks areas by e^2, to which the exponents add up."""
    scene = impact_oscillator(0, omega=RATIO, sigma=0.0, e=RESTITUTION, zeta=0.0, f=1.0)
    start, t_end, blocks = [-1.0, 0.0, 1.0, 0.0], 2000.0, 20
    found = fl.lyapunov(scene, start, transient=200.0, t_end=t_end, progress=False)
    exact, errors = by_hand(2000)
    assert found.chaotic
    assert found.standard_errors[0] < 0.02
    assert found.exponents[0] == pytest.approx(
        exact[0], abs=4 * np.hypot(errors[0], found.standard_errors[0])
    )
    assert found.exponents[1:3] == pytest.approx([0.0, 0.0], abs=1e-3)  # of the clock: its phase, its radius
    state, impacts = fl.solve(scene, 200.0, x0=start, progress=False).final_state, []
    for _ in range(blocks + 1):
        run = fl.solve(scene, t_end / blocks, x0=state, progress=False)
        state = run.final_state
        impacts.append(len(run.events))
    shrinking = 2 * np.log(RESTITUTION) * sum(impacts[1:]) / t_end
    assert found.exponents.sum() == pytest.approx(shrinking, abs=1e-9)


def test_the_map_from_impact_to_impact():
    """Its Jacobian against differences; it shrinks v dt dv, a volume of the flow, by e^2 exp(-c t/m)."""
    oscillator = Oscillator(m=1.5, c=0.1, k=2.0, d=0.2, F=1.2, Omega=3.1, e=0.7)
    (t, v), h = (0.3, -0.9), 1e-5
    differences = [
        np.subtract(oscillator.impact(t + dt, v + dv)[:2], oscillator.impact(t - dt, v - dv)[:2]) / (2 * h)
        for dt, dv in ((h, 0.0), (0.0, h))
    ]
    np.testing.assert_allclose(oscillator.impact(t, v)[2], np.transpose(differences), atol=1e-8)
    growths, times, speeds = growth(oscillator, t, v, 200)
    shrinking = 200 * np.log(0.7**2) - 0.1 / 1.5 * (times[-1] - times[0]) + np.log(speeds[0] / speeds[-1])
    assert growths.sum() == pytest.approx(shrinking, abs=1e-10)


def test_both_exponents_of_the_chaotic_impact_oscillator():
    """Against 20,000 impacts of the exact map, within the scatter of both.

    The divergence of the flow is -c/m, and an impact shrinks volumes by e^2, the determinant of its saltation
    matrix: it turns v to -e v, and displacements across the stop by as much.  The phase neither grows nor
    shrinks.  So the exponents add up to -c/m + 2 ln(e) N/t, with N impacts in a time t.
    """
    c, start, t_end, blocks = 0.05, [-1.0, 0.0, 0.0], 10_000.0, 20
    model = fl.ImpactOscillator(c=c, d=0.0, Omega=RATIO, impact=fl.RestitutionImpact(e=RESTITUTION))
    found = fl.lyapunov(model, start, transient=0.0, t_end=t_end, blocks=blocks, progress=False)
    exact, errors = by_hand(20_100, c=c)
    assert found.chaotic
    assert (found.standard_errors < 0.01).all()
    assert (errors < 0.004).all()
    assert (
        np.abs(found.exponents[[0, 2]] - exact) < 3 * np.hypot(errors, found.standard_errors[[0, 2]])
    ).all()
    assert found.exponents[1] == pytest.approx(0.0, abs=1e-3)
    impacts, state = [], start
    for _ in range(blocks + 1):  # the first is for the tangent vectors to find their directions
        run = fl.simulate(model, t_end / blocks, x0=state, progress=False)
        state = run.final_state
        impacts.append((run.events.before[:, 1] > run.events.state[:, 1]).sum())
    shrinking = -c / model.m + 2 * np.log(RESTITUTION) * sum(impacts[1:]) / t_end
    assert sum(impacts[1:]) > 4000
    assert np.array_equal(state, found.final_state)
    assert found.exponents.sum() == pytest.approx(shrinking, abs=1e-10)


@pytest.mark.parametrize("ratio", [0.8, 1.3])
def test_the_free_motion_of_an_impact_oscillator_grazes_where_its_amplitude_is_the_gap(ratio):
    """f/sqrt((1 - r^2)^2 + (2 zeta r)^2) = sigma."""
    zeta, sigma = 0.1, 1.0
    scene = impact_oscillator(1, omega=ratio, sigma=sigma, e=0.8, zeta=zeta, f=0.2)
    run = fl.solve(scene, 200.0, x0=[0.0, 0.0, 1.0, 0.0], progress=False)
    branch = fl.continue_orbit(fl.periodic_orbit(scene, run), "f", (0.05, 3.0), progress=False)
    assert branch.ends == ("bound", "grazing")
    (grazing,) = branch.special
    assert grazing.value == pytest.approx(sigma * np.hypot(1 - ratio**2, 2 * zeta * ratio), abs=1e-9)
    times = np.linspace(0.0, grazing.orbit.period, 2001)
    assert grazing.orbit.trajectory(times)[:, 0].max() == pytest.approx(sigma, abs=1e-5)
    assert branch.stable.all()


def test_chaos_needs_both_the_moving_load_and_the_non_smooth_behaviours():
    """At mu_k = 2.5, under Eq. (13): without either the motion from rest is periodic, or has no end."""

    def kind(model):
        return {"kind": str(fl.steady_state(model, transient=250.0, window=50.0, progress=False).kind)}

    model = fl.SliderOnBelt(mu_k=2.5)
    found = fl.ablation(model, kind, ["nonsmooth", "geometry"], progress=False)
    assert found[()]["kind"] == "non-periodic"
    assert found.leave_one_out("kind = non-periodic") == {"without nonsmooth": -1.0, "without geometry": -1.0}
    assert found["geometry"]["kind"] == "periodic"
    effects = found.effects("kind = non-periodic")
    assert effects["nonsmooth x geometry"] == 1.0
