"""Powers of bases that come to zero tangentially, against closed forms: near such a point coefficients of
their series grow by the root of curvature/base, as the rate of the base is next to zero too."""

from math import gamma

import mpmath
import numpy as np
import pytest
import sympy as sp

import frictionlab as fl
from frictionlab import HybridAutomaton, Mode
from frictionlab.hybrid.kernels.jets import mode_jets
from frictionlab.tape.packing import program_of

T, U = sp.symbols("t u")
E, P = sp.symbols("e p")
ORDERS = [(1e-15, 26), (1e-16, 32)]


def power_of_time(base, **values):
    """t' = 1, u' = base^p."""
    numbers = {sp.Symbol(name): value for name, value in values.items()}
    return HybridAutomaton((T, U), (Mode("only", (sp.S.One, base**P)),), numbers, 0)


@pytest.mark.parametrize("exponent", [0.9, 1.5])
@pytest.mark.parametrize(("tol", "order"), ORDERS)
def test_a_rate_is_integrated_through_the_point_where_its_base_touches_zero(exponent, tol, order):
    """The integral of |t - 1|^(2 p) from 0 to 3 is (1 + 2^(2 p + 1)) / (2 p + 1)."""
    law = power_of_time((T - 1) ** 2, p=exponent)
    run = fl.solve(law, 3.0, x0=[0, 0], method=fl.Taylor(tol=tol, order=order), progress=False)
    assert run.status.ok
    exact = (1 + 2 ** (2 * exponent + 1)) / (2 * exponent + 1)
    assert run.final_state[1] == pytest.approx(exact, rel=1e-13)


@pytest.mark.parametrize("exponent", [0.1, 0.9, 1.5])
@pytest.mark.parametrize("least", [1e-12, 1e-20, 1e-30, 1e-60])
@pytest.mark.parametrize(("tol", "order"), ORDERS)
def test_a_rate_begins_where_its_base_is_next_to_zero_with_a_rate_of_zero(exponent, least, tol, order):
    """By mpmath, the integral of (e + t^2)^p from 0 to 1 is e^p F(1/2, -p; 3/2; -1/e)."""
    law = power_of_time(E + T**2, p=exponent, e=least)
    run = fl.solve(law, 1.0, x0=[0, 0], method=fl.Taylor(tol=tol, order=order), progress=False)
    assert run.status.ok
    with mpmath.workdps(60):
        e = mpmath.mpf(least)
        exact = e**exponent * mpmath.hyp2f1(0.5, -mpmath.mpf(exponent), 1.5, -1 / e)
    assert run.final_state[1] == pytest.approx(float(exact), rel=1e-13)


@pytest.mark.parametrize("order", [11, 26, 32, 60])
def test_coefficients_are_finite_whatever_the_base_and_its_curvature(order):
    """With series those of (e + t^2)^p: p (p - 1) ... (p - k + 1) / k! e^(p - k) for t^(2 k)."""
    for least in 10.0 ** -np.arange(4.0, 80.0, 7.0):
        program, numbers = program_of(power_of_time(E + T**2, p=0.9, e=least))
        jets = np.full((program.slots, 61), np.nan)
        mode_jets(program.code, numbers, 0, order, np.zeros(2), jets)
        row = jets[program.code.flow[0, 1], : order + 1]
        assert np.isfinite(row).all()
        if row[2] != 0.0:
            k = np.arange(order // 2 + 1)
            exact = [gamma(1.9) / gamma(1.9 - n) / gamma(n + 1) * least ** (0.9 - n) for n in k]
            assert row[::2] == pytest.approx(exact, rel=1e-11)


@pytest.mark.parametrize("method", [fl.Taylor(), fl.Taylor(tol=1e-16, order=32)])
def test_friction_by_a_power_of_the_normal_force_where_contact_begins_with_no_closing_rate(method):
    """A contact begins at 1.79069303 s with F_N = 7.5e-21 N and a rate of 1.7e-14 N/s."""
    model = fl.SliderOnBelt(friction=fl.PressureDependent(n=0.9))
    run = fl.simulate(model, 2.0, method=method, progress=False)
    other = fl.simulate(model, 2.0, method=fl.Taylor(tol=1e-13, order=30), progress=False)
    assert run.status.ok
    assert run.events.target.tolist() == other.events.target.tolist()
    np.testing.assert_allclose(run.final_state, other.final_state, atol=1e-7)
