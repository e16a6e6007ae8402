"""Equilibria and state matrices for arrays of parameters: those of one model after the other."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

import frictionlab as fl
from frictionlab.components import ContactLaw
from frictionlab.stability.equilibrium_points.equilibria import equilibrium_problem
from tests.helpers.cases import slow_but
from tests.helpers.laws import Saturating

S = fl.SliderOnBelt
DECAY = fl.ExponentialDecay(mu_k=0.3, mu_s=0.9, v_s=0.5)


@dataclass(frozen=True)
class Exponential(ContactLaw):
    """Leaves the range of floats within centimetres."""

    top: float = 10.0
    per: float = 5e3

    def force(self, gap):
        """An exponential function."""
        return self.top * (sympy.exp(self.per * gap) - 1)


def one_by_one(model, changes):
    """Equilibria (n, N) of single models; NaN where there is none, or no sliding."""
    columns = []
    for values in zip(*changes.values(), strict=True):
        single = model.replace(**dict(zip(changes, values, strict=True)))
        try:
            q = fl.equilibrium(single).q
        except ValueError as error:
            if not any(text in str(error) for text in ("F_N > 0", "the springs do not hold")):
                raise
            q = np.full(len(model.coordinates), np.nan)
        columns.append(q if single.v else np.full_like(q, np.nan))
    return np.array(columns).T


def compare(model, changes):
    """All at once against one by one; the number of equilibria."""
    expected = one_by_one(model, changes)
    x, matrices = equilibrium_problem(model).linearised(changes)
    n = len(expected)
    size = np.abs(expected).max(axis=0)
    assert np.array_equal(np.isnan(x[0]), np.isnan(expected[0]))
    np.testing.assert_allclose(x[:n] / size, expected / size, rtol=1e-9, atol=1e-11)
    assert not x[n:, ~np.isnan(expected[0])].any()
    assert np.array_equal(np.isnan(matrices).any(axis=(1, 2)), np.isnan(expected[0]))
    return int(np.isfinite(expected[0]).sum())


def grid(**axes):
    """Columns with all combinations of the values."""
    return dict(zip(axes, np.array(list(product(*axes.values()))).T, strict=True))


AXES = {
    "mu_k": st.one_of(st.just(0.0), st.floats(1e-6, 3)),
    "F": st.one_of(st.just(0.0), st.floats(-500, -1e-3), st.floats(1e-3, 5000)),
    "k_nl": st.one_of(st.just(0.0), st.floats(-2, 10).map(lambda e: 10.0**e)),
    "v": st.sampled_from([-2.0, -1e-3, 0.0, 1e-9, 1.0]),
    "k3": st.one_of(st.just(0.0), st.floats(3, 6).map(lambda e: 10.0**e)),
    "k5": st.floats(3, 6).map(lambda e: 10.0**e),
    "l1": st.floats(0.05, 0.4),
}


@pytest.mark.slow
@settings(max_examples=60)
@given(
    data=st.data(),
    names=st.lists(st.sampled_from(sorted(AXES)), min_size=1, max_size=2, unique=True),
    stiffness=st.lists(st.floats(3, 6).map(lambda e: 10.0**e), min_size=4, max_size=4),
    mu_k=AXES["mu_k"],
    F=st.sampled_from([-5.0, 0.0, 200.0, 3000.0]),
    v=st.sampled_from([-1.0, 1.0]),
    toggles=st.sampled_from([(), ("geometry",), ("nonsmooth",)]),
)
def test_random_scenes(data, names, stiffness, mu_k, F, v, toggles):
    values = dict(zip(["k1", "k2", "k4", "k6"], stiffness, strict=True))
    model = S(mu_k=mu_k, mu_s=4.0, F=F, v=v, **values).without(*toggles)
    axes = {name: data.draw(st.lists(AXES[name], min_size=2, max_size=4), name) for name in names}
    changes = grid(**axes)
    if "nonsmooth" in toggles and "v" in changes:  # without stick a belt at rest slides without friction
        changes["v"][changes["v"] == 0] = 1.0
    compare(model, changes)


LAWS = [
    {"contact": fl.HertzContact(k_h=1e5)},
    {"contact": fl.HertzContact(k_h=1e9)},
    {"contact": Saturating()},
    {"contact": Exponential()},
    {"friction": DECAY},
    {"contact": fl.HertzContact(k_h=1e5), "friction": DECAY},
]


@pytest.mark.parametrize("laws", slow_but(LAWS[-1:], LAWS))
@pytest.mark.parametrize("toggles", [pytest.param((), marks=pytest.mark.slow), ("geometry",)])
def test_own_laws(laws, toggles):
    model = S(mu_k=0.4, **laws).without(*toggles)
    assert compare(model, grid(F=[-50.0, 0.0, 3.0, 200.0, 1e3], v=[-1.0, 0.0, 0.5])) >= 6
    assert compare(model, grid(k3=[0.0, 1e3, 1e5], mu_k=[0.0, 0.3, 0.9])) >= 3


def test_several_equilibria():
    """One, three, one along each line: the one with the smallest gap is taken, which jumps where it ends."""
    model = S(mu_k=1.5, F=3000, k4=2e4, k5=2e3, k6=2e3, l1=0.05, l2=0.05)
    changes = {"F": np.linspace(100, 6000, 40)}
    numbers = [len(fl.equilibria(model.replace(F=F))) for F in changes["F"]]
    assert set(numbers) == {1, 3}
    assert compare(model, changes) == 40
    compare(model, grid(F=[2000.0, 3000.0, 4000.0], mu_k=np.linspace(0, 3, 9)))


@pytest.mark.slow
def test_a_contact_that_clamps_itself_without_preload():
    """Backwards friction pulls the slider in: there are equilibria with F_N > 0 at F = 0."""
    model = S(k1=1.5e3, k3=2e4, k4=1.4e3, F=0.0, v=-1.0, k_nl=1e6, k2=0.0, mu_s=4.0)
    assert compare(model, {"mu_k": np.linspace(0, 3, 13)}) > 0
    assert compare(model.replace(contact=Exponential(per=100.0)), {"mu_k": np.linspace(0, 3, 13)}) > 0


def test_loose_coordinates_are_no_hindrance_to_the_others():
    assert compare(S(), {"k4": np.array([0.0, 1e3, 0.0, 1e5])}) == 2
    assert compare(S(), grid(k3=[0.0, 1e3], k4=[0.0, 1e4], l1=[0.0, 0.2])) == 4
    assert compare(S(l2=0.0), {"l1": np.array([0.0, 0.1])}) == 1


def test_a_loose_coordinate_at_all_values_is_an_error():
    with pytest.raises(ValueError, match="the springs do not hold x2"):
        equilibrium_problem(S(k4=0)).linearised({"mu_k": np.linspace(0, 1, 5)})
    with pytest.raises(ValueError, match="the springs do not hold phi"):
        fl.root_locus(S(l1=0, l2=0), "mu_k", [0.1, 0.2])


def test_ten_thousand_with_and_without_a_spring_are_quick():
    """Not one by one: whichever has its own statics."""
    x, _ = equilibrium_problem(S()).linearised({"k3": np.tile([0.0, 6e3], 5000)})
    np.testing.assert_array_equal(x[:, ::2], np.repeat(x[:, :1], 5000, axis=1))
    np.testing.assert_allclose(x[:5, 0], fl.equilibrium(S(k3=0)).q, rtol=1e-12)
    np.testing.assert_allclose(x[:5, 1], fl.equilibrium(S()).q, rtol=1e-12)


OF_SLIP = [*product([{}, {"friction": DECAY}, {"contact": fl.HertzContact(k_h=1e5)}], [-0.7, 0.4])]


@pytest.mark.parametrize(("law", "v"), slow_but([OF_SLIP[i] for i in (0, 5)], OF_SLIP, several=True))
def test_state_matrices_against_the_complex_step(law, v):
    """The flow of the automaton's slip mode, which is derived on its own, along imaginary directions."""
    model = S(v=v, **law)
    changes = grid(mu_k=[0.0, 0.5, 0.8], F=[100.0, 700.0])
    x, matrices = equilibrium_problem(model).linearised(changes)
    automaton = model.automaton()
    mode = next(m for m in automaton.modes if m.name == ("slip+" if v > 0 else "slip-"))
    flow = sympy.lambdify([automaton.states, list(automaton.parameters)], mode.flow, modules="numpy")
    for state, matrix, values in zip(x.T, matrices, zip(*changes.values(), strict=True), strict=True):
        single = model.replace(**dict(zip(changes, values, strict=True)))
        numbers = list(single.automaton().parameters.values())
        steps = 1e-30j * np.eye(10)
        columns = [np.imag(np.array(flow(state + step, numbers), dtype=complex)) / 1e-30 for step in steps]
        np.testing.assert_allclose(matrix, np.array(columns).T, rtol=1e-11, atol=1e-8)
        np.testing.assert_allclose(flow(state, numbers), 0, atol=1e-8)


def test_falling_friction_is_negative_damping():
    """d F_T/d v_r = -(mu_s - mu_k)/v_s exp(-v/v_s) F_N acts between x1 and x2 like a damper."""
    model = S(friction=DECAY, v=0.2)
    speeds = np.array([0.05, 0.2, 1.0, -0.2])
    x, matrices = equilibrium_problem(model).linearised({"v": speeds})
    _, plain = equilibrium_problem(
        model.replace(friction=fl.ExponentialDecay(mu_k=0.3, mu_s=0.3, v_s=1e9))
    ).linearised({"v": speeds})
    p = model.parameters
    gap = x[3] - (x[0] - x[2]) * x[4] - x[1]
    normal = p["k2"] * gap + p["k_nl"] * gap**3
    damper = -(p["mu_s"] - p["mu_k"]) / p["v_s"] * np.exp(-np.abs(speeds) / p["v_s"]) * normal
    expected = np.zeros((4, 5, 5))
    for i, row in ((0, 1.0), (2, -1.0)):
        expected[:, i, 0], expected[:, i, 2] = -row * damper / p["M"], row * damper / p["M"]
    np.testing.assert_allclose(matrices[:, 5:, 5:] - plain[:, 5:, 5:], expected, rtol=1e-9, atol=1e-9)
    assert fl.eigenvalues(model.replace(v=0.05)).growth_rates.max() > 0
    assert fl.eigenvalues(model.replace(v=5.0)).stable
