"""Derivatives of orbits and folds by all parameters, against closed forms and Richardson differences."""

from functools import cache
from itertools import pairwise

import numpy as np
import pytest
import sympy

import frictionlab as fl

LEVELS = 4  # of Richardson's extrapolation, each with half the step
STICK_SLIP = fl.MassOnBelt(c=0.05)
SLIDER = fl.SliderOnBelt(mu_k=1.4).without("geometry")
TILTING = fl.SliderOnBelt(mu_k=1.4, impact=fl.PlasticImpact("full"))
IMPACTS = fl.ImpactOscillator(Omega=2.8, e=0.6, d=0.05, c=0.02)


@cache
def orbit_of(model):
    if model in (IMPACTS, TILTING):
        return fl.periodic_orbit(model, fl.simulate(model, 200.0, progress=False))
    return fl.periodic_orbit(model, fl.steady_state(model, transient=60.0, window=60.0, progress=False))


def richardson(quantity, model, name, levels=LEVELS):
    """The derivative by a parameter: central differences, extrapolated to a step of zero."""
    value = model.parameters[name]
    step = 2e-3 * (abs(value) or 1.0)
    rows = []
    for level in range(levels):
        high, low = (quantity(model.replace(**{name: value + s * step / 2**level})) for s in (1, -1))
        rows.append((high - low) / (2 * step / 2**level))
    for power in range(1, levels):
        rows = [(4**power * b - a) / (4**power - 1) for a, b in pairwise(rows)]
    return rows[0]


CASES = [
    (model, make)
    for model, names in ((STICK_SLIP, "x"), (SLIDER, "x1 y1"), (TILTING, "x1 phi"), (IMPACTS, "x"))
    for make in (fl.OrbitPeriod, fl.OrbitIntensity, *((fl.OrbitAmplitude, name) for name in names.split()))
    if not (model is IMPACTS and make is fl.OrbitIntensity)  # it has no equilibrium to measure from
]


def name_of_case(case):
    return type(case).__name__ if isinstance(case, fl.Model) else getattr(case, "__name__", str(case))


@pytest.mark.slow  # closed forms of stick-slip, of a forced orbit and of a fold are below
@pytest.mark.parametrize(("model", "make"), CASES, ids=name_of_case)
def test_every_derivative_is_that_of_differences(model, make):
    kind, *names = make if isinstance(make, tuple) else (make,)
    quantity = kind(*names, near=orbit_of(model))
    found = fl.sensitivity(model, quantity)
    assert found.value == pytest.approx(quantity(model), rel=1e-12)
    assert {*found.parameters} == {*model.parameters} - {"chatter"}
    largest = np.abs(found.normalised).max()
    assert largest > 0
    for name in found.parameters:
        size = abs(model.parameters[name]) or 1.0
        floor = 1e-8 * largest * abs(found.value) / size  # what rounding leaves of differences
        assert found[name] == pytest.approx(richardson(quantity, model, name), rel=1e-6, abs=floor), name


def test_stick_slip_has_its_closed_form():
    """T = 2 a/v + (2 pi - 2 atan(a w/v))/w, X = sqrt(a^2 + v^2/w^2); a = (mu_s - mu_k) N/k, w^2 = k/m."""
    m, k, N, v, mu_k, mu_s = symbols = sympy.symbols("m k N v mu_k mu_s")
    a, w = (mu_s - mu_k) * N / k, sympy.sqrt(k / m)
    forms = {
        fl.OrbitPeriod(): 2 * a / v + (2 * sympy.pi - 2 * sympy.atan(a * w / v)) / w,
        fl.OrbitAmplitude("x"): sympy.sqrt(a**2 + v**2 / w**2),
    }
    model = fl.MassOnBelt()
    at = {symbol: model.parameters[symbol.name] for symbol in symbols}
    for quantity, form in forms.items():
        found = fl.sensitivity(model, quantity)
        assert found.value == pytest.approx(float(form.subs(at)), rel=1e-11)
        for symbol in symbols:
            assert found[symbol.name] == pytest.approx(
                float(sympy.diff(form, symbol).subs(at)), rel=1e-9, abs=1e-9
            )


def test_a_forced_orbit_has_the_period_of_its_force():
    found = fl.sensitivity(IMPACTS, fl.OrbitPeriod(near=orbit_of(IMPACTS)))
    turns = round(orbit_of(IMPACTS).period * IMPACTS.Omega / (2 * np.pi))
    assert found["Omega"] == pytest.approx(-turns * 2 * np.pi / IMPACTS.Omega**2, rel=1e-9)
    assert found["e"] == pytest.approx(0.0, abs=1e-9)


def test_a_fold_has_its_closed_form():
    """x' = p - a^2 + b x^2 has an equilibrium up to p = a^2."""
    x, p, a, b = sympy.symbols("x p a b")
    modes = (fl.Mode("flow", (p - a**2 + b * x**2,)),)
    automaton = fl.HybridAutomaton((x,), modes, {p: 0.5, a: 1.5, b: 2.0})
    found = fl.sensitivity(automaton, fl.FoldValue("p", (0.5, 4.0)))
    assert found.value == pytest.approx(2.25, rel=1e-9)
    assert (found["a"], found["b"], found["p"]) == (
        pytest.approx(3.0, rel=1e-6),
        pytest.approx(0, abs=1e-6),
        0,
    )


SNAPPING = fl.PolynomialContact(a1=5e3, a2=-1.5e5)  # its force has a maximum
FOLDS = {
    "tilting": (
        fl.SliderOnBelt(mu_k=1.5, F=3000, k4=2e4, k5=2e3, k6=2e3, l1=0.05, l2=0.05),
        fl.FoldValue("F", (100.0, 6000.0)),
    ),
    "snapping": (fl.SliderOnBelt(contact=SNAPPING), fl.FoldValue("F", (1.0, 200.0))),
    "on a rigid belt": (fl.SliderOnRigidBelt(F=20.0, contact=SNAPPING), fl.FoldValue("F", (1.0, 200.0))),
}


@pytest.mark.slow
@pytest.mark.parametrize("case", FOLDS)
def test_every_derivative_of_a_fold_is_that_of_differences(case):
    model, quantity = FOLDS[case]
    found = fl.sensitivity(model, quantity)
    beside = (len(fl.equilibria(model.replace(F=found.value * (1 + side * 1e-7)))) for side in (-1, 1))
    assert abs(np.subtract(*beside)) == 2  # two equilibria meet
    assert np.abs(found.normalised).max() > 0.1
    for name in found.parameters:
        size = abs(model.parameters[name]) or 1.0
        floor = 1e-7 * np.abs(found.normalised).max() * found.value / size
        difference = 0.0 if name == "F" else richardson(quantity, model, name, levels=3)
        assert found[name] == pytest.approx(difference, rel=1e-6, abs=floor), name


def test_what_has_no_derivative_is_refused():
    with pytest.raises(ValueError, match="must settle to a periodic orbit"):
        fl.sensitivity(
            fl.SliderOnBelt(mu_k=0.3), fl.OrbitPeriod(options=fl.SteadyStateOptions(transient=5.0))
        )
    with pytest.raises(ValueError, match="name must be one of"):
        fl.sensitivity(STICK_SLIP, fl.OrbitAmplitude("y"))
    undamped = fl.MassOnBelt()  # inside the cycle lie oscillations without stick
    inner = fl.periodic_orbit(undamped, [0.55, 0.0], period=2 * np.pi)
    with pytest.raises(ValueError, match="one of a family"):
        fl.sensitivity(undamped, fl.OrbitPeriod(near=inner))
    with pytest.raises(ValueError, match="must end in a fold"):
        fl.sensitivity(STICK_SLIP, fl.FoldValue("mu_k", (0.1, 0.9)))
