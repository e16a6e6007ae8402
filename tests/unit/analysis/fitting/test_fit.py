"""Fits of synthetic measurements: the truth is recovered through stick and impacts, and errors are right."""

import numpy as np
import pytest

import frictionlab as fl
from frictionlab import plotting

TRUTH = fl.MassOnBelt(k=1.3, mu_s=0.9, mu_k=0.45, c=0.03)
FIRST = fl.MassOnBelt(c=0.05)
NAMES = ["k", "mu_s", "mu_k", "c"]
ERROR = 0.005


def record(model, t_end, count, *, error=ERROR, seed=1, x0="rest", state="x"):
    """A state with noise, at even times."""
    t = np.linspace(t_end / count, t_end, count)
    run = fl.simulate(model, t_end, x0=x0, progress=False)
    clean = run(t)[:, run.names.index(state)]
    noise = np.random.default_rng(seed).normal(0.0, error, count)
    return fl.TimeRecord(t, {state: clean + noise}, error=error), run


def test_the_truth_is_recovered_through_stick_where_single_shooting_fails():
    data, run = record(TRUTH, 60.0, 300)
    assert (run.events.target == "stick").sum() >= 5
    alone = fl.fit(FIRST, data, NAMES, segments=1)
    assert alone.chi_square > 100
    assert abs(alone["k"] - TRUTH.k) > 0.1
    found = fl.fit(FIRST, data, NAMES, segments=12)
    assert 0.7 < found.chi_square < 1.3
    for name in NAMES:
        i = found.parameters.index(name)
        assert abs(found[name] - TRUTH.parameters[name]) < 4 * found.errors[i], name
    assert [pair[:2] for pair in found.correlated] == [("mu_k", "c")]
    assert "hard to tell apart: mu_k and c" in found.summary()


def test_without_noise_the_truth_is_found_to_rounding():
    data, _ = record(TRUTH, 20.0, 50, error=1e-12)
    exact = fl.TimeRecord(data.t, data.values, error=1e-3)
    found = fl.fit(TRUTH.replace(k=1.25, mu_s=0.93), exact, ["k", "mu_s"], segments=4)
    assert (found["k"], found["mu_s"]) == (pytest.approx(1.3, rel=1e-8), pytest.approx(0.9, rel=1e-8))


def test_impacts_and_an_unknown_start():
    truth = fl.ImpactOscillator(Omega=2.8, e=0.6, d=0.05, c=0.02)
    start = {"x": -0.3, "x'": 0.2}
    data, run = record(truth, 12.0, 150, error=2e-3, x0=start)
    assert (run.events.guard == "impact").sum() >= 4
    guess = {"x": -0.25, "x'": 0.1}
    found = fl.fit(truth.replace(e=0.8, c=0.1), data, ["e", "c"], x0=guess, unknown=["x", "x'"], segments=6)
    assert found.parameters == ("e", "c", "x at 0", "x' at 0")
    assert 0.7 < found.chi_square < 1.3
    deviations = (found.values - [0.6, 0.02, -0.3, 0.2]) / found.errors
    assert np.abs(deviations).max() < 4


def test_event_times_alone_determine_friction():
    run = fl.simulate(TRUTH, 40.0, progress=False)
    onsets = run.events.t[run.events.target == "stick"]
    found = fl.fit(
        TRUTH.replace(mu_s=0.95, k=1.25), fl.EventTimes(onsets, "stick", 1e-3), ["k", "mu_s"], segments=1
    )
    assert (found["k"], found["mu_s"]) == (pytest.approx(1.3, rel=1e-7), pytest.approx(0.9, rel=1e-7))


def test_frequencies_determine_springs():
    truth = fl.SliderOnBelt(mu_k=1.0, k1=1.2e4, k4=0.9e4)
    data = fl.Frequencies({mode: fl.ModeFrequency(mode)(truth) for mode in range(4)}, error=0.01)
    found = fl.fit(fl.SliderOnBelt(mu_k=1.0), data, ["k1", "k4"])
    assert (found["k1"], found["k4"]) == (pytest.approx(1.2e4, rel=1e-7), pytest.approx(0.9e4, rel=1e-7))
    assert np.isnan(found.times).all()


def test_what_only_a_ratio_enters_is_not_determined():
    """m x'' + c x' + k x = N mu: all four may be doubled."""
    data, _ = record(TRUTH, 20.0, 80)
    found = fl.fit(TRUTH, data, ["m", "c", "k", "N"], segments=1)
    assert found.rank == 3
    assert {*found.undetermined[0]} == {"m", "c", "k", "N"}
    assert np.isinf(found.errors).all()
    assert "not determined" in found.summary()


@pytest.mark.slow
def test_intervals_hold_the_truth_as_often_as_they_say():
    """Of 200 records 95 percent, within three standard deviations of the binomial distribution."""
    names, t = ["k", "mu_s"], np.linspace(0.2, 20.0, 100)
    clean = fl.simulate(TRUTH, 20.0, progress=False)(t)[:, 0]
    inside = np.zeros(len(names))
    for seed in range(200):
        noise = np.random.default_rng(seed).normal(0.0, ERROR, len(t))
        data = fl.TimeRecord(t, {"x": clean + noise}, error=ERROR)
        found = fl.fit(TRUTH.replace(k=1.31), data, names, segments=1)
        bounds = np.array([found.interval(name) for name in names])
        truth = np.array([TRUTH.parameters[name] for name in names])
        inside += (bounds[:, 0] <= truth) & (truth <= bounds[:, 1])
    assert (np.abs(inside - 190) < 3 * np.sqrt(200 * 0.95 * 0.05)).all(), inside


def test_residuals_are_drawn():
    data, _ = record(TRUTH, 20.0, 80)
    found = fl.fit(TRUTH, data, ["k"], segments=1)
    points, *lines = plotting.plot_fit(found)
    assert points.get_ydata() == pytest.approx(found.residuals)
    assert len(lines) == 2
    assert found.to_dataframe().loc["k", "value"] == found["k"]


def test_bad_arguments_are_refused():
    data, _ = record(TRUTH, 2.0, 10)
    with pytest.raises(TypeError, match="data must be TimeRecord"):
        fl.fit(FIRST, [1.0, 2.0], ["k"])
    with pytest.raises(ValueError, match="ascending times"):
        fl.TimeRecord([1.0, 0.5], {"x": [0.0, 0.0]})
    with pytest.raises(ValueError, match="finite number for each of the 2 times"):
        fl.TimeRecord([0.5, 1.0], {"x": [0.0]})
    with pytest.raises(ValueError, match="name one at least"):
        fl.fit(FIRST, data, [])
    with pytest.raises(ValueError, match="state must be one of"):
        fl.fit(FIRST, data, ["k"], unknown=["y"])
    with pytest.raises(KeyError, match="no parameter 'c'"):
        _ = fl.fit(TRUTH, data, ["k"], segments=1)["c"]
