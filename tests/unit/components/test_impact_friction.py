"""Friction in the impact: a closed form without the moving load, and the cone of impulses."""

import numpy as np
import pytest
import sympy

import frictionlab as fl
from frictionlab.components.impact import clip


@pytest.mark.parametrize(
    ("stopping", "found"), [(0.3, 0.3), (-0.3, -0.3), (2.0, 0.5), (-2.0, -0.5), (0.5, 0.5)]
)
def test_the_impulse_within_the_cone(stopping, found):
    assert clip(stopping, -0.5, 0.5) == pytest.approx(found, abs=1e-16)
    x = sympy.Symbol("x", real=True)
    assert clip(x, -0.5, 0.5).subs(x, stopping) == pytest.approx(found, abs=1e-16)


def landing(e, mu_i, speed):
    """A free slider falls on a free belt: no springs, no preload; the velocities before and after."""
    model = fl.SliderOnBelt(
        k1=0, k3=0, k4=0, k5=0, k6=0, c1=0, c2=0, c4=0, c5=0, c6=0, F=0, M=2.0, m=3.0, mu_k=0.0, mu_s=0.0,
        v=0.5, impact=fl.FrictionalImpact(e=e, mu_i=mu_i), geometry=fl.FixedLoad(),
    )  # fmt: skip
    start = np.array([0.0, 0.1, 0.0, 0.0, speed, -1.0, 0.2, 0.3])
    run = fl.simulate(model, 0.1, x0=start, progress=False)
    assert run.events.source[0] == "separation"
    return run.events.before[0], run.events.state[0]


def kinetic(z):
    return (2.0 * (z[4] ** 2 + z[5] ** 2) + 3.0 * (z[6] ** 2 + z[7] ** 2)) / 2


@pytest.mark.parametrize("e", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("mu_i", [0.0, 0.1, 0.9])
@pytest.mark.parametrize("speed", [-1.5, 0.4, 2.0])
def test_a_free_landing_in_closed_form(e, mu_i, speed):
    before, after = landing(e, mu_i, speed)
    reduced = 1.0 / (1 / 2.0 + 1 / 3.0)
    normal = (1 + e) * 1.3 * reduced
    v_r = 0.5 - (speed - 0.2)
    tangential = np.clip(v_r * reduced, -mu_i * normal, mu_i * normal)
    jump = np.array([tangential / 2, normal / 2, -tangential / 3, -normal / 3])
    assert after[4:] - before[4:] == pytest.approx(jump, abs=1e-13)
    belt = -0.5 * tangential  # the work of what drives the belt's surface, v_r being that of its material
    assert kinetic(after) <= kinetic(before) - belt + 1e-12


def test_the_gap_opens_at_newtons_rate_with_the_moving_load():
    """Newton's law holds for the gap rate after the tangential impulse, which leaves y1, y2, phi alone."""
    model = fl.SliderOnBelt(mu_k=1.4, impact=fl.FrictionalImpact(e=0.6, mu_i=0.4))
    run = fl.simulate(model, 1.0, progress=False)
    landings = run.events.source == "separation"
    q, v = np.split(np.stack([run.events.before[landings], run.events.state[landings]]), 2, axis=-1)

    def rate(q, v):
        """Rate of the penetration -y1 + y2 - phi (x1 - x2)."""
        return -v[:, 1] + v[:, 3] - v[:, 4] * (q[:, 0] - q[:, 2]) - q[:, 4] * (v[:, 0] - v[:, 2])

    assert landings.sum() > 20
    rubbed = np.column_stack([v[1, :, 0], v[0, :, 1], v[1, :, 2], v[0, :, 3], v[0, :, 4]])
    assert rate(q[1], v[1]) == pytest.approx(-0.6 * rate(q[0], rubbed), rel=1e-9, abs=1e-9)


def test_the_equations_show_both_impulses():
    found = fl.SliderOnBelt(impact=fl.FrictionalImpact(e=0.5, mu_i=0.3)).equations("impact")
    assert "p_T" in repr(found)
    assert r"\mu_{\mathrm{i}}" in found.latex()
