"""The model's equations against the paper's, typed here by hand from Liu & Ouyang (2020)."""

from __future__ import annotations

import pytest
import sympy
from sympy import Abs, Derivative, Function, Rational, sign

from frictionlab.components import PlasticImpact, RestitutionImpact, SlidingOnly, StickSlip
from frictionlab.models import SliderOnBelt

t, t_s = sympy.symbols("t t_s", real=True)
NAMES = "M m J c1 c2 c4 c5 c6 k1 k2 k3 k4 k5 k6 k_nl l1 l2 v F mu_k mu_s"
M, m, J, c1, c2, c4, c5, c6, k1, k2, k3, k4, k5, k6, k_nl, l1, l2, v, F, mu_k, mu_s = sympy.symbols(
    NAMES, real=True
)
x1, y1, x2, y2, phi, F_N, F_T, v_r = (
    Function(name, real=True)(t) for name in "x1 y1 x2 y2 phi F_N F_T v_r".split()
)
HALF = Rational(1, 2)


def d(f, order=1):
    """Time derivative."""
    return Derivative(f, (t, order))


EQ_1 = [
    (M * d(x1, 2) + c1 * d(x1) + k1 * x1 + HALF * k3 * x1 - HALF * k3 * y1, F_T),
    (M * d(y1, 2) + c2 * d(y1) - HALF * k3 * x1 + HALF * k3 * y1 + F, F_N),
    (m * d(x2, 2) + c4 * d(x2) + k4 * x2, -F_T),
    (
        m * d(y2, 2)
        + c5 * (d(y2) + l1 * d(phi))
        + k5 * (y2 + l1 * phi)
        + c6 * (d(y2) - l2 * d(phi))
        + k6 * (y2 - l2 * phi),
        -F_N,
    ),
    (
        J * d(phi, 2)
        + c5 * (d(y2) + l1 * d(phi)) * l1
        + k5 * (y2 + l1 * phi) * l1
        - c6 * (d(y2) - l2 * d(phi)) * l2
        - k6 * (y2 - l2 * phi) * l2,
        F_N * (x1 - x2),
    ),
]
GAP = y2 - (x1 - x2) * phi - y1
EQ_2 = k2 * GAP + k_nl * GAP**3
EQ_3 = sign(v_r) * mu_k * F_N
EQ_5 = [
    (d(x2), d(x1) - v),
    (d(x2, 2), d(x1, 2)),
    (x2, x1 - x1.subs(t, t_s) - v * (t - t_s) + x2.subs(t, t_s)),
]
EQ_6 = (
    M * d(x1, 2) + m * d(x2, 2) + c1 * d(x1) + c4 * d(x2) + (k1 + HALF * k3) * x1 - HALF * k3 * y1 + k4 * x2
)
EQ_7 = (
    (M + m) * d(x1, 2) + (c1 + c4) * d(x1) + (k1 + HALF * k3 + k4) * x1 - HALF * k3 * y1,
    c4 * v + k4 * (x1.subs(t, t_s) + v * (t - t_s) - x2.subs(t, t_s)),
)
MODES = ["slip", "slip+", "slip-", "stick", "separation"]


def same(left, right):
    """Whether two expressions agree term by term."""
    return sympy.expand(left - right) == 0


@pytest.mark.parametrize("mode", MODES)
def test_equation_1(mode):
    motion = SliderOnBelt().equations(mode).motion
    assert len(motion) == 5
    for mine, (left, right) in zip(motion, EQ_1, strict=True):
        assert same(mine.lhs, left)
        assert same(mine.rhs, right)


@pytest.mark.parametrize("mode", ["slip", "slip+", "slip-", "stick"])
def test_equation_2(mode):
    normal = SliderOnBelt().equations(mode).forces[0]
    assert normal.lhs == F_N
    assert same(normal.rhs, EQ_2)


@pytest.mark.parametrize(("mode", "value"), [("slip", EQ_3), ("slip+", mu_k * F_N), ("slip-", -mu_k * F_N)])
def test_equation_3(mode, value):
    equations = SliderOnBelt().equations(mode)
    assert equations.forces[1].lhs == F_T
    assert same(equations.forces[1].rhs, value)
    (definition,) = equations.definitions
    assert definition.lhs == v_r
    assert same(definition.rhs, v + d(x2) - d(x1))


def test_equation_4():
    model = SliderOnBelt()
    assert model.equations("slip").conditions == (sympy.Ne(v_r, 0), F_N > 0)
    assert model.equations("slip+").conditions == (v_r > 0, F_N > 0)
    assert model.equations("slip-").conditions == (v_r < 0, F_N > 0)


def test_equation_5():
    constraint = SliderOnBelt().equations("stick").constraint
    for mine, (left, right) in zip(constraint, EQ_5, strict=True):
        assert mine.lhs == left
        assert same(mine.rhs, right)


def test_equations_6_and_7_follow_by_eliminating_the_belt():
    equations = SliderOnBelt().equations("stick")
    total = equations.motion[0].lhs + equations.motion[2].lhs
    assert same(equations.motion[0].rhs + equations.motion[2].rhs, 0)
    assert same(total, EQ_6)
    velocity, acceleration, position = equations.constraint
    eliminated = total.subs(acceleration.lhs, acceleration.rhs).subs(velocity.lhs, velocity.rhs)
    eliminated = eliminated.subs(x2, position.rhs)
    assert same(eliminated, EQ_7[0] - EQ_7[1])


def test_the_sticking_force_satisfies_equations_1_and_5():
    equations = SliderOnBelt().equations("stick")
    force = equations.forces[1].rhs
    slider = (force - EQ_1[0][0] + M * d(x1, 2)) / M
    belt = (-force - EQ_1[2][0] + m * d(x2, 2)) / m
    assert sympy.simplify(slider - belt) == 0


def test_equation_8():
    assert SliderOnBelt().equations("stick").conditions == (Abs(F_T) <= mu_s * F_N, F_N > 0)


def test_equation_9_and_no_contact_forces_in_flight():
    equations = SliderOnBelt().equations("separation")
    (condition,) = equations.conditions
    assert condition.rel_op == "<"
    assert same(condition.lhs - condition.rhs, GAP)
    assert [(e.lhs, e.rhs) for e in equations.forces] == [(F_N, 0), (F_T, 0)]


p, X1, X2 = sympy.symbols("p x1 x2", real=True)
Y1B, Y2B, PHIB = sympy.symbols("y1'- y2'- phi'-", real=True)
Y1A, Y2A, PHIA = sympy.symbols("y1'+ y2'+ phi'+", real=True)
RATE = Y2B - Y1B - (X1 - X2) * PHIB
DENOMINATOR = 1 / M + 1 / m + (X1 - X2) ** 2 / J
EQ_10_TO_12 = [(Y1A - Y1B, p / M), (Y2A - Y2B, -p / m), (PHIA - PHIB, p * (X1 - X2) / J)]
EQ_13 = Y1A - (Y2A - (X1 - X2) * PHIA)
EQ_14 = RATE / DENOMINATOR
EQ_15 = Y1B + RATE / (M * DENOMINATOR)
EQ_16 = Y2B - RATE / (m * DENOMINATOR)  # erratum E2: the paper prints two more terms, - y1' - (x1 - x2) phi'
EQ_17 = PHIB + (X1 - X2) * RATE / (J * DENOMINATOR)


def test_equations_10_to_17_with_erratum_e2():
    jump = SliderOnBelt().equations("impact").impact
    paper = [*EQ_10_TO_12, (-EQ_13, 0), (p, EQ_14), (Y1A, EQ_15), (Y2A, EQ_16), (PHIA, EQ_17)]
    assert len(jump) == len(paper)
    for mine, (left, right) in zip(jump, paper, strict=True):
        assert same(mine.lhs, left)
        assert sympy.simplify(mine.rhs - right) == 0


def test_equations_15_to_17_satisfy_equation_13():
    jump = SliderOnBelt().equations("impact").impact
    after = {e.lhs: e.rhs for e in jump[-3:]}
    assert sympy.simplify(EQ_13.subs(after)) == 0
    as_printed = EQ_13.subs(after | {Y2A: EQ_16 - Y1B - (X1 - X2) * PHIB})
    assert sympy.simplify(as_printed) != 0


def test_the_impact_law_is_the_models():
    x1r, x2r, phi_r = sympy.symbols("x1'- x2'- phi", real=True)
    full = SliderOnBelt(impact=PlasticImpact("full")).equations("impact").impact
    impulse = next(e.rhs for e in full if e.lhs == p)
    assert sympy.simplify(impulse - (RATE - phi_r * (x1r - x2r)) / DENOMINATOR) == 0
    e = sympy.Symbol("e", real=True)
    bouncing = SliderOnBelt(impact=RestitutionImpact(0.5)).without("geometry").equations("impact").impact
    law = bouncing[2]
    assert same(law.lhs, Y2A - Y1A)
    assert same(law.rhs, -e * (Y2B - Y1B))


def test_without_geometry_phi_is_gone():
    equations = SliderOnBelt().without("geometry").equations("slip+")
    assert len(equations.motion) == 4
    for mine, (left, right) in zip(equations.motion, EQ_1[:4], strict=True):
        assert same(mine.lhs, left.subs(phi, 0).doit())
        assert same(mine.rhs, right)
    assert same(equations.forces[0].rhs, EQ_2.subs(phi, 0))


def test_sliding_only_keeps_the_sign_of_the_belts_speed():
    equations = SliderOnBelt(interface=SlidingOnly()).equations("slip")
    assert same(equations.forces[1].rhs, sign(v) * mu_k * F_N)
    assert equations.conditions == ()


def test_bilateral_contact_has_no_condition_on_the_normal_force():
    model = SliderOnBelt(interface=StickSlip())
    assert model.equations("slip").conditions == (sympy.Ne(v_r, 0),)
    with pytest.raises(
        ValueError, match="mode must be one of 'stick', 'slip\\+', 'slip-', 'slip', got 'impact'"
    ):
        model.equations("impact")
