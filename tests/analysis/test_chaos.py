"""Chaos and grazing of systems with impacts: exponents known exactly, or found without the package."""

import numpy as np
import pytest
import sympy as sp
from scipy.optimize import brentq

import frictionlab as fl
from tests.analysis.test_continuation import logistic
from tests.hybrid.textbook import V, X, automaton

C, S = sp.symbols("c s")
RATIO, RESTITUTION = 2.8, 0.8
STEP = 0.02


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


def free(t, start, x, v):
    """x'' + x = cos(RATIO t) from (x, v) at `start`, in closed form: x and x' at `t`."""
    gain = 1 / (1 - RATIO**2)
    a, b = x - gain * np.cos(RATIO * start), v + gain * RATIO * np.sin(RATIO * start)
    c, s = np.cos(t - start), np.sin(t - start)
    position = a * c + b * s + gain * np.cos(RATIO * t)
    return position, -a * s + b * c - gain * RATIO * np.sin(RATIO * t)


def next_impact(t, x, v):
    """Time of the next impact at x = 0, by steps in time and bisection."""
    grid = t + STEP * np.arange(1, 2000)
    i = np.flatnonzero(free(grid, t, x, v)[0] >= 0)[0]
    return brentq(lambda s: free(s, t, x, v)[0], grid[i] - (STEP if i else 0.5 * STEP), grid[i], xtol=1e-14)


def exponents_by_hand(impacts, blocks=20):
    """Both exponents and the standard error of the first.

    Rotations between impacts, where x = 0; the saltation matrix of an impact is [[-e, 0], [(1 + e) a/v, -e]]
    with speed v and acceleration a just before it (Leine & Nijmeijer 2004).
    """
    t, x, v, frame, growths, times = 0.0, -1.0, 0.0, np.eye(2), [], []
    for _ in range(impacts):
        after = next_impact(t, x, v)
        _, speed = free(after, t, x, v)
        c, s = np.cos(after - t), np.sin(after - t)
        force = np.cos(RATIO * after)
        jump = np.array([[-RESTITUTION, 0.0], [(1 + RESTITUTION) * force / speed, -RESTITUTION]])
        frame, r = np.linalg.qr(jump @ [[c, s], [-s, c]] @ frame)
        growths.append(np.log(np.abs(np.diag(r))))
        times.append(after - t)
        t, x, v = after, 0.0, -RESTITUTION * speed
    parts = [
        g.sum(axis=0) / d.sum() for g, d in zip(*(np.array_split(a[100:], blocks) for a in (growths, times)))
    ]
    return np.mean(parts, axis=0), np.std(parts, axis=0, ddof=1)[0] / np.sqrt(blocks)


def test_a_chaotic_impact_oscillator():
    """Against the same by hand; each impact shrinks areas by e^2, to which the exponents add up."""
    scene = impact_oscillator(0, omega=RATIO, sigma=0.0, e=RESTITUTION, zeta=0.0, f=1.0)
    start, t_end, blocks = [-1.0, 0.0, 1.0, 0.0], 2000.0, 20
    found = fl.lyapunov(scene, start, transient=200.0, t_end=t_end, progress=False)
    exact, error = exponents_by_hand(2000)
    assert found.chaotic
    assert found.standard_errors[0] < 0.02
    assert found.exponents[0] == pytest.approx(exact[0], abs=4 * np.hypot(error, found.standard_errors[0]))
    assert found.exponents[1:3] == pytest.approx([0.0, 0.0], abs=1e-3)  # of the clock: its phase, its radius
    state, impacts = fl.solve(scene, 200.0, x0=start, progress=False).final_state, []
    for _ in range(blocks + 1):
        run = fl.solve(scene, t_end / blocks, x0=state, progress=False)
        state = run.final_state
        impacts.append(len(run.events))
    shrinking = 2 * np.log(RESTITUTION) * sum(impacts[1:]) / t_end
    assert found.exponents.sum() == pytest.approx(shrinking, abs=1e-9)


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
