"""Derivatives by all parameters, against closed forms and Richardson differences."""

from itertools import pairwise

import numpy as np
import pytest
import sympy

import frictionlab as fl

ONSET = fl.CriticalValue("mu_k", (0.0, 4.0))
SLIDER = fl.SliderOnBelt(mu_k=1.4)
COUPLED = fl.ModeCoupling(c=0.1)
RIGID = fl.SliderOnRigidBelt()
LEVELS = 3  # of Richardson's extrapolation, each with half the step


def richardson(quantity, model, names):
    """Derivatives by parameters: central differences, extrapolated to a step of zero; all models at once."""
    values = model.parameters
    steps = {name: 2e-3 * (abs(values[name]) or 1.0) for name in names}
    offsets = np.array([side / 2**level for level in range(LEVELS) for side in (1, -1)])
    columns = {name: np.full((len(names), len(offsets)), values[name]) for name in names}
    for i, name in enumerate(names):
        columns[name][i] += steps[name] * offsets
    # the critical parameter itself is none of those that are given
    given = {name: column.ravel() for name, column in columns.items() if name != fixed_of(quantity)}
    found = quantity.values(model, given).reshape(len(names), LEVELS, 2)
    rows = list((-np.diff(found)[..., 0] / (2 * np.outer([*steps.values()], 0.5 ** np.arange(LEVELS)))).T)
    for power in range(1, LEVELS):
        rows = [(4**power * b - a) / (4**power - 1) for a, b in pairwise(rows)]
    return dict(zip(names, rows[0], strict=True))


def fixed_of(quantity):
    """The parameter whose critical value is asked for, if any."""
    return getattr(quantity, "parameter", None)


CASES = [
    (model, quantity)
    for model in (SLIDER, COUPLED, RIGID)
    for quantity in (ONSET, fl.CriticalFrequency("mu_k", (0, 4)), fl.GrowthRate(), fl.ModeFrequency(1))
] + [
    (SLIDER, fl.EquilibriumCoordinate("x1")),
    (SLIDER, fl.EquilibriumCoordinate("phi")),
    (RIGID, fl.EquilibriumCoordinate(RIGID.coordinates[0])),
    (SLIDER, fl.GrowthRate(2)),
    (fl.SliderOnBelt(k_nl=1e7, F=800.0), ONSET),
    (fl.SliderOnBelt(contact=fl.HertzContact()), ONSET),
]


# Seconds each; the block of mode coupling has derivatives of the same quantities.
LONG = {(model, quantity) for model in (SLIDER, RIGID) for _, quantity in CASES[:2]} | {*CASES[-2:]}


@pytest.mark.parametrize(
    ("model", "quantity"),
    [pytest.param(*case, marks=pytest.mark.slow if case in LONG else ()) for case in CASES],
    ids=lambda x: type(x).__name__,
)
def test_every_derivative_is_that_of_differences(model, quantity):
    found = fl.sensitivity(model, quantity)
    assert found.value == pytest.approx(quantity(model), rel=1e-12)
    largest = np.abs(found.normalised).max()
    assert largest > 0
    differences = richardson(quantity, model, found.parameters)
    for name, difference in differences.items():
        size = abs(model.parameters[name]) or 1.0
        # Differences are known to rounding of the quantity over their step, some 1e-7 of the largest here.
        floor = 1e-7 * largest * abs(found.value) / size
        assert found[name] == pytest.approx(difference, rel=1e-6, abs=floor), name


def test_the_onset_of_mode_coupling_has_hoffmanns_derivatives():
    """mu_c = (k12^2 + ((k11 - k22)/2)^2) / (k12 k3); undamped, so that two eigenvalues coalesce there."""
    model = fl.ModeCoupling(c=0.0)
    k1, k2, k3, a1, a2 = symbols = sympy.symbols("k1 k2 k3 a1 a2")
    k11 = k1 * sympy.cos(a1) ** 2 + k2 * sympy.cos(a2) ** 2
    k12 = k1 * sympy.sin(a1) * sympy.cos(a1) + k2 * sympy.sin(a2) * sympy.cos(a2)
    k22 = k1 * sympy.sin(a1) ** 2 + k2 * sympy.sin(a2) ** 2 + k3
    critical = (k12**2 + ((k11 - k22) / 2) ** 2) / (k12 * k3)
    values = {s: model.parameters[s.name] for s in symbols}
    assert float(critical.subs(values)) == pytest.approx(model.critical_friction, rel=1e-13)
    found = fl.sensitivity(model, ONSET)
    for s in symbols:
        assert found[s.name] == pytest.approx(float(sympy.diff(critical, s).subs(values)), rel=1e-6)
    assert np.isnan(found["c"])  # damping of one mode moves the onset at once
    assert found["m"] == pytest.approx(0.0, abs=1e-6)


def test_an_oscillator_has_its_closed_forms():
    model = fl.MassOnBelt(c=0.05, mu_k=0.5, mu_s=1.0)
    rate = fl.sensitivity(model, fl.GrowthRate())  # -c/2m
    assert rate["c"] == pytest.approx(-0.5 / model.m, rel=1e-12)
    assert rate["m"] == pytest.approx(model.c / (2 * model.m**2), rel=1e-12)
    place = fl.sensitivity(model, fl.EquilibriumCoordinate("x"))  # mu_k N / k
    assert place["mu_k"] == pytest.approx(model.N / model.k, rel=1e-12)
    assert place.normalised[place.parameters.index("k")] == pytest.approx(-1.0, rel=1e-12)


def automaton_of_rates(states, rates, parameters):
    return fl.HybridAutomaton(tuple(states), (fl.Mode("flow", tuple(rates)),), parameters)


def test_divergence_has_a_derivative():
    """x' = (p - a^2) x loses stability at p = a^2."""
    x, p, a = sympy.symbols("x p a", real=True)
    automaton = automaton_of_rates([x], [(p - a**2) * x], {p: 0.5, a: 1.5})
    found = fl.sensitivity(automaton, fl.CriticalValue("p", (0.0, 4.0)))
    assert found.value == pytest.approx(2.25)
    assert (found["a"], found["p"]) == (pytest.approx(3.0, rel=1e-9), 0.0)


def test_where_the_equilibrium_ends_there_is_no_loss():
    """x' = p - a + x^2 has an equilibrium up to p = a."""
    x, p, a = sympy.symbols("x p a", real=True)
    automaton = automaton_of_rates([x], [p - a + x**2], {p: 0.5, a: 1.0})
    with pytest.raises(ValueError, match="stability must be lost or regained"):
        fl.sensitivity(automaton, fl.CriticalValue("p", (0.0, 2.0)))


def test_a_quantity_is_a_study():
    found = fl.ablation(SLIDER, ONSET, ["geometry"], progress=False)
    assert found["geometry"] == fl.critical_value(SLIDER.without("geometry"), "mu_k", (0.0, 4.0))
    assert fl.sweep(SLIDER, fl.GrowthRate(), {"F": [100.0, 200.0]}, progress=False).to_array().shape == (2,)


def test_what_has_no_derivative_is_refused():
    with pytest.raises(TypeError, match="quantity must be one such as"):
        fl.sensitivity(SLIDER, fl.critical_value)
    with pytest.raises(ValueError, match="stability must be lost or regained within the bounds"):
        fl.sensitivity(SLIDER, fl.CriticalValue("mu_k", (0.0, 0.5)))
    with pytest.raises(ValueError, match="name must be one of"):
        fl.sensitivity(SLIDER, fl.EquilibriumCoordinate("x9"))
    with pytest.raises(ValueError, match="mode must be below 5"):
        fl.GrowthRate(7)(SLIDER)
    with pytest.raises(ValueError, match="flutter of damped modes"):
        fl.sensitivity(fl.ModeCoupling(c=0.0), fl.CriticalFrequency("mu_k", (0, 4)))
    model = fl.ModeCoupling(c=0.0)
    with pytest.raises(ValueError, match="eigenvalue must be simple"):
        fl.sensitivity(model.replace(mu_k=model.critical_friction), fl.ModeFrequency(0))
    with pytest.raises(KeyError, match="no parameter 'mu'"):
        _ = fl.sensitivity(SLIDER, fl.GrowthRate())["mu"]
