"""No length, time or force in the solver has a unit of its own: the same motion in other units is the same.

A factor that is a power of two changes no rounding error, so that nothing but a quantity with a unit could
make a difference.
"""

import math

import numpy as np
import pytest
import sympy as sp

import frictionlab as fl
from frictionlab.analysis.motion_scales import amplitude_spectrum
from frictionlab.analysis.steady_state.poincare_sections import section_crossings

TIME_UNITS = (2.0**-20, 2.0**20)  # s, some microseconds and some weeks
PER_SECOND = ("c1", "c2", "c4", "c5", "c6", "v")
PER_SECOND_SQUARED = ("k1", "k2", "k3", "k4", "k5", "k6", "k_nl", "k_h", "F", "g")


def in_unit(model, unit):
    """The model with all numbers in a unit of time of so many seconds."""
    factors = dict.fromkeys(PER_SECOND, unit) | dict.fromkeys(PER_SECOND_SQUARED, unit**2)
    return model.replace(**{name: value * factors.get(name, 1.0) for name, value in model.parameters.items()})


def scaled(states, unit):
    """States in seconds, of numbers in another unit."""
    coordinates = states.shape[-1] // 2
    return np.concatenate([states[..., :coordinates], states[..., coordinates:] / unit], axis=-1)


@pytest.mark.parametrize("unit", TIME_UNITS)
@pytest.mark.parametrize("tol", [1e-6, 1e-15])
@pytest.mark.parametrize(
    ("model", "t_end", "chatter"),
    [
        (fl.BouncingBall(impact=fl.RestitutionImpact(0.8)), 5.0, 0.0),
        (fl.SliderOnBelt(mu_k=1.4, impact=fl.RestitutionImpact(0.5)), 1.0, 0.0),
        (fl.SliderOnBelt(mu_k=1.4, contact=fl.HertzContact()), 0.5, None),
        (fl.SliderOnBelt(mu_k=1.4), 0.5, None),
    ],
    ids=["ball", "restitution", "Hertz", "chatter"],
)
def test_a_motion_does_not_depend_on_the_unit_of_time(model, t_end, chatter, tol, unit):
    start = {"y": 1.0} if isinstance(model, fl.BouncingBall) else "rest"

    def run_of(model, t_end, chatter):
        method = fl.Taylor(tol=tol, chatter=chatter)
        return fl.simulate(model, t_end, x0=start, method=method, progress=False)

    usual, other = run_of(model, t_end, chatter), run_of(in_unit(model, unit), t_end / unit, chatter)
    assert other.events.target.tolist() == usual.events.target.tolist()
    # A power near zero has a series as far as its coefficients, in 1/s^k, are no numbers beyond the largest.
    rel = 1e-13 if tol < 1e-9 or "k_h" not in model.parameters else 0.1 * tol
    assert other.events.t * unit == pytest.approx(usual.events.t, rel=rel)
    assert scaled(other.final_state, unit) == pytest.approx(usual.final_state, rel=100 * rel, abs=rel)


def test_a_zeno_accumulation_ends_where_it_should_in_any_unit():
    """sqrt(2 h/g) (1 + e)/(1 - e), whatever the second is."""
    for unit in TIME_UNITS:
        run = fl.simulate(in_unit(fl.BouncingBall(), unit), 2.0 / unit, progress=False)
        expected = math.sqrt(2.0 / fl.BouncingBall().g) * 3.0
        assert run.events.t[-1] * unit == pytest.approx(expected, rel=1e-14)
        assert run.mode[-1] == "contact"


@pytest.mark.parametrize(("v", "tol"), [(0.2e-12, 1e-15), (0.2e-12, 1e-4), (0.2e-8, 1e-16)])
def test_stick_that_lasts_for_ages_ends_where_it_should(v, tol):
    """The belt carries the mass from 0 to mu_s N/k: powers of such times are no numbers."""
    model = fl.MassOnBelt(v=v, mu_s=1.0, c=0.0)
    run = fl.simulate(model, 1.5 / v, x0=[0.0, v], method=fl.Taylor(tol=tol, order=30), progress=False)
    assert run.events.t[0] * v == pytest.approx(1.0, rel=1e-14)
    assert run.events.target[:2].tolist() == ["slip+", "stick"]


def test_motions_of_ages_are_the_same_in_a_batch():
    unit = 2.0**-38
    usual, slow = fl.MassOnBelt(c=0.05), fl.MassOnBelt(c=0.05 * unit, k=unit**2, N=unit**2, v=0.2 * unit)
    states = np.array([[0.0, 0.2], [0.5, 0.0]])
    ends = [
        fl.ensemble([model] * 2, 20.0 / by, x0=states * [1.0, by], progress=False).states / [1.0, by]
        for model, by in ((usual, 1.0), (slow, unit))
    ]
    assert ends[1] == pytest.approx(ends[0], abs=1e-12)


def test_a_section_is_not_at_an_event_that_is_a_nanosecond_later():
    """Stick from 0 with 0.2 m/ns: x = 0.9 m after 4.5 ns, and its end after 5 ns."""
    model = fl.MassOnBelt(k=1e18, N=1e18, v=0.2e9, mu_s=1.0, c=0.0)
    run = fl.simulate(model, 6e-9, x0=[0.0, 0.2e9], progress=False)
    assert run.events.t[0] == pytest.approx(5e-9)
    assert section_crossings(run, ("x - 0.9", 1)).t[0] == pytest.approx(4.5e-9, rel=1e-12)


@pytest.mark.parametrize("unit", [1e-9, 1e9])
def test_spectra_and_orbits_of_an_automaton_have_its_own_times(unit):
    """A mass on a belt: its period is 5 + 2 pi - 2 arctan 2.5 units of time.  Spectra were of 0.1 s."""
    x, v = sp.symbols("x v")
    belt, pull = 0.2 / unit, -x / unit**2
    caught = fl.Event("caught", belt - v, ("stick",), fl.Reset({v: belt}))
    slip = fl.Mode("slip", (v, pull + 0.5 / unit**2), (caught,))
    pulled = fl.Event("pulled", 1 / unit**2 + pull, ("slip",))
    stick = fl.Mode("stick", (v, sp.S.Zero), (pulled,), (belt - v,))
    mass = fl.HybridAutomaton((x, v), (stick, slip), coordinates=1)
    period = (5 + 2 * math.pi - 2 * math.atan(2.5)) * unit
    orbit = fl.periodic_orbit(mass, [0.0, belt], t_max=30 * unit)
    assert orbit.period == pytest.approx(period, rel=1e-9)
    run = fl.solve(mass, 40 * period, x0=[0.0, belt], progress=False)
    lines = amplitude_spectrum(run)
    assert lines.peaks()[0][0] == pytest.approx(1 / period, rel=1e-3)


def test_a_limit_of_chatter_that_is_long_for_the_motion_is_told():
    model = fl.SliderOnBelt(mu_k=1.4)
    assert fl.simulate(model, 0.5, progress=False).warning is None
    fast = in_unit(model, 2.0**20)
    assert fl.simulate(fast, 0.5 * 2.0**-20, progress=False).warning is None
    with pytest.warns(RuntimeWarning, match="limit of chatter, which is not short") as told:
        run = fl.simulate(fast, 0.5 * 2.0**-20, method=fl.Taylor(chatter=1e-7), progress=False)
    assert told[0].filename == __file__
    assert "such as chatter=" in run.warning
