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


@pytest.mark.parametrize("mu_i", [0.4, 2.0])
def test_newtons_rate_coulombs_cone_and_no_energy_of_friction_with_the_moving_load(mu_i):
    """Here the impulse of friction changes the gap rate, and W_N is not the gradient of the gap."""
    model = fl.SliderOnBelt(mu_k=1.4, impact=fl.FrictionalImpact(e=0.6, mu_i=mu_i))
    run = fl.simulate(model, 1.0, progress=False)
    landings = run.events.source == "separation"
    q, w = np.split(run.events.before[landings], 2, axis=1)
    v, p = run.events.state[landings, 5:], model.parameters
    masses = np.array([p["M"], p["M"], p["m"], p["m"], p["J"]])
    gap = np.column_stack([q[:, 4], 0 * q[:, 4] + 1, -q[:, 4], 0 * q[:, 4] - 1, q[:, 0] - q[:, 2]])
    normal, tangent = gap * [0, 1, 0, 1, 1], np.array([1, 0, -1, 0, 0])
    assert landings.sum() > 20
    assert (gap * v).sum(1) == pytest.approx(-0.6 * (gap * w).sum(1), abs=1e-9)
    jump, p_T = masses * (v - w), masses[0] * (v - w)[:, 0]
    assert jump == pytest.approx(jump[:, 1:2] * normal + p_T[:, None] * tangent, abs=1e-9)
    assert (np.abs(p_T) <= mu_i * jump[:, 1] + 1e-12).all()
    alone = -1.6 * (gap * w).sum(1) / (gap * normal / masses).sum(1)  # the impulse without friction
    pushed = w + alone[:, None] * normal / masses
    work = (masses * (v**2 - pushed**2)).sum(1) / 2 - p["v"] * p_T  # less that of the belt's drive
    assert (work <= 1e-12).all()
    assert work.min() < -1e-3


@fl.model
class LeaningBlock(fl.MechanicalModel):
    """Masses couple x and y, and F_N acts along another direction than the gap's gradient."""

    impact: fl.ImpactLaw = fl.PlasticImpact()
    coordinates = ("x", "y")

    def mechanics(self, q, v):
        rough, kinetic = fl.Coulomb(mu_k=0.2, mu_s=0.2), v.x**2 + v.x * v.y + v.y**2
        foot = fl.Friction(v.x, 9.0 * -q.y, rough, penetration=-q.y, normal=(0.4, 1.0), impact=self.impact)
        return fl.Mechanics(kinetic, contacts=(foot,))


@pytest.mark.parametrize("mu_i", [0.0, 0.3])
@pytest.mark.parametrize("e", [0.0, 0.5, 1.0])
def test_newtons_rate_where_masses_tell_the_normal_from_the_gradient_of_the_gap(e, mu_i):
    start = [0.0, 1e-6, 0.3, -1.0]
    run = fl.simulate(LeaningBlock(impact=fl.FrictionalImpact(e, mu_i)), 1e-5, x0=start, progress=False)
    assert run.events.state[0, 3] == pytest.approx(e, abs=1e-14)
    run = fl.simulate(LeaningBlock(impact=fl.PlasticImpact("material")), 1e-5, x0=start, progress=False)
    assert run.events.state[0, 2:] @ [0.4, 1.0] == pytest.approx(0.0, abs=1e-14)


def test_the_equations_show_both_impulses():
    found = fl.SliderOnBelt(impact=fl.FrictionalImpact(e=0.5, mu_i=0.3)).equations("impact")
    assert "p_T" in repr(found)
    assert r"\mu_{\mathrm{i}}" in found.latex()
