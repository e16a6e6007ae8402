"""Fits of synthetic measurements: the truth is recovered through stick and impacts, and errors are right."""

from datetime import UTC, datetime, timedelta
from functools import partial
from importlib import import_module
from itertools import pairwise
from zoneinfo import ZoneInfo

import numpy as np
import pytest
import sympy as sp
from scipy.optimize import least_squares

import frictionlab as fl
from frictionlab.analysis.fitting.plausibility import check_times
from frictionlab.analysis.fitting.predictions import Segments, motion_misfit
from tests.helpers.automata import V, X
from tests.helpers.cases import slow_but

fit_module = import_module("frictionlab.analysis.fitting.fit")
TRUTH = fl.MassOnBelt(k=1.3, mu_s=0.9, mu_k=0.45, c=0.03)
FIRST = fl.MassOnBelt(c=0.05)
NAMES = ["k", "mu_s", "mu_k", "c"]
ERROR = 0.005
LAST = 60.0  # s, of the longest records


def record(model, t_end, count, *, error=ERROR, seed=1, x0="rest", state="x"):
    """A state with noise, at even times."""
    t = np.linspace(t_end / count, t_end, count)
    run = fl.simulate(model, t_end, x0=x0, progress=False)
    clean = run(t)[:, run.names.index(state)]
    noise = np.random.default_rng(seed).normal(0.0, error, count)
    return fl.TimeRecord(t, {state: clean + noise}, error=error), run


def fit_by_differences(model, data, names, x0="rest"):
    """The usual way: one run, whose derivatives scipy takes by differences; values and reduced chi-square."""

    def missed(values):
        try:
            run = fl.simulate(
                model.replace(**dict(zip(names, map(float, values)))), LAST, x0=x0, progress=False
            )
        except ValueError:  # mu_s below mu_k
            return np.full(len(data.t), 1e6)
        return (run(data.t)[:, run.names.index("x")] - data.values["x"]) / data.error["x"]

    first = np.array([model.parameters[name] for name in names])
    found = least_squares(missed, first, x_scale=first, max_nfev=60, bounds=(1e-6, np.inf))
    return dict(zip(names, found.x)), 2 * found.cost / (len(data.t) - len(names))


@pytest.mark.slow
def test_the_truth_is_recovered_through_stick_where_single_shooting_fails():
    data, run = record(TRUTH, 60.0, 300)
    assert (run.events.target == "stick").sum() >= 5
    alone = fl.fit(FIRST, data, NAMES, segments=1)
    assert alone.chi_square > 100
    assert abs(alone["k"] - TRUTH.k) > 0.1
    values, chi_square = fit_by_differences(FIRST, data, NAMES)
    assert chi_square > 100
    assert abs(values["k"] - TRUTH.k) > 0.1
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


@pytest.mark.slow
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


@pytest.mark.slow
def test_the_truth_is_recovered_through_impacts_where_the_usual_ways_fail():
    truth = fl.ImpactOscillator(Omega=2.8, e=0.6, d=0.05, c=0.02)
    start = {"x": -0.3, "x'": 0.2}
    data, run = record(truth, 30.0, 300, error=2e-3, x0=start)
    assert (run.events.guard == "impact").sum() >= 10
    first, names = truth.replace(e=0.8, c=0.1), ["e", "c"]
    assert fit_by_differences(first, data, names, start)[1] > 100
    assert fl.fit(first, data, names, x0=start, segments=1).chi_square > 100
    found = fl.fit(first, data, names, x0=start, segments=12)
    assert 0.7 < found.chi_square < 1.3
    assert (np.abs(found.values - [0.6, 0.02]) < 4 * found.errors).all()


def test_event_times_alone_determine_friction():
    run = fl.simulate(TRUTH, 40.0, progress=False)
    onsets = run.events.t[run.events.target == "stick"]
    found = fl.fit(
        TRUTH.replace(mu_s=0.95, k=1.25), fl.EventTimes(onsets, "stick", 1e-3), ["k", "mu_s"], segments=1
    )
    assert (found["k"], found["mu_s"]) == (pytest.approx(1.3, rel=1e-7), pytest.approx(0.9, rel=1e-7))


AT = 20.0 + np.arange(256) * (40.0 / 256)  # past the first turns


def lines_of(model, error, *, seed=1, frequencies=None, window="rectangular"):
    """Amplitudes of a noisy record at the frequency of the limit cycle and its multiples."""
    run = fl.simulate(model, LAST, progress=False)
    noise = np.random.default_rng(seed).normal(0.0, error, len(AT))
    record = fl.TimeRecord(AT, {"x": run(AT)[:, 0] + noise}, error=error)
    own = np.arange(4, 28) / 40.0 if frequencies is None else frequencies
    return fl.SpectrumRecord.from_record(record, own, window)


def test_amplitudes_of_a_record_are_those_of_its_transform():
    t = np.arange(128) / 16.0
    values = np.random.default_rng(5).normal(size=len(t)) + 3.0
    record = fl.TimeRecord(t, {"x": values}, error=0.1)
    found = fl.SpectrumRecord.from_record(record, np.arange(1, 60) / 8.0)
    assert found.values["x"] == pytest.approx(2 / 128 * np.abs(np.fft.rfft(values))[1:60], rel=1e-10)
    hann = fl.SpectrumRecord.from_record(record, np.arange(1, 60) / 8.0, "hann")
    window = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(128) / 128)
    apart = (values - np.average(values, weights=window)) * window
    assert hann.values["x"] == pytest.approx(2 / window.sum() * np.abs(np.fft.rfft(apart))[1:60], rel=1e-10)
    # of noise alone the mean square of a line is twice the square of its error
    noise = np.random.default_rng(6).normal(0.0, 0.1, (400, len(t)))
    for window in ("rectangular", "hann"):
        lines = [
            fl.SpectrumRecord.from_record(fl.TimeRecord(t, {"x": n}, error=0.1), [2.0, 3.5], window)
            for n in noise
        ]
        square = np.mean([line.values["x"] ** 2 for line in lines])
        assert square == pytest.approx(2 * lines[0].error["x"] ** 2, rel=0.12)


@pytest.mark.parametrize("segments", slow_but([1], [1, 5]))
def test_a_spectrum_determines_friction_and_spring(segments):
    data = lines_of(TRUTH, 0.01)
    run = fl.simulate(TRUTH, LAST, progress=False)
    assert (run.events.target == "stick").sum() >= 5
    found = fl.fit(TRUTH.replace(k=1.303, mu_s=0.88), data, ["k", "mu_s"], segments=segments)
    assert 0.4 < found.chi_square < 1.7
    assert (np.abs(found.values - [1.3, 0.9]) < 4 * found.errors).all()
    assert (found.errors < [0.01, 0.05]).all()
    assert np.isnan(found.times).all()


@pytest.mark.slow
@pytest.mark.parametrize("window", ["rectangular", "hann"])
def test_spectra_have_exact_gradients(window):
    """Residuals and their derivatives by parameters and all states at the seams, by Richardson."""
    model, names = TRUTH, ("k", "mu_s", "c")
    lines = lines_of(model, 0.01, window=window)
    strong = lines.frequencies[lines.values["x"] > 0.02]  # |a| has a kink at zero
    assert len(strong) >= 5
    data = (lines_of(model, 0.01, frequencies=strong, window=window),)
    edges = np.array([0.0, 17.0, 33.3, LAST])
    run = fl.simulate(model, LAST, progress=False)
    starts = run(edges[:-1])
    starts[1:] += 1e-3  # seams that are open
    pieces = Segments(edges, (0,), starts[0], np.ones(2), 1.0)
    exact = motion_misfit(model, names, data, pieces, starts)
    assert exact.slopes.shape == (data[0].count + 4, 3 + 1 + 4)

    def residuals(unknowns):
        other = model.replace(**dict(zip(names, map(float, unknowns[:3]))))
        moved = starts.copy()
        moved[0, 0] = unknowns[3]
        moved[1:] = unknowns[4:].reshape(2, 2)
        return motion_misfit(other, names, data, pieces, moved).values

    here = np.concatenate([[model.parameters[n] for n in names], starts[0, :1], starts[1:].ravel()])
    for i in range(len(here)):
        rows = []
        for level in range(3):
            step = 1e-4 / 2**level * (np.arange(len(here)) == i)
            rows.append((residuals(here + step) - residuals(here - step)) / (2 * step[i]))
        for power in (1, 2):
            rows = [(4**power * b - a) / (4**power - 1) for a, b in pairwise(rows)]
        assert exact.slopes[:, i] == pytest.approx(rows[0], abs=1e-6 * np.abs(rows[0]).max()), i


@pytest.mark.slow
def test_a_spectrum_and_a_record_are_fitted_together():
    data, _ = record(TRUTH, 20.0, 50)
    found = fl.fit(TRUTH.replace(k=1.31), [data, lines_of(TRUTH, 0.01)], ["k", "mu_k"], segments=2)
    assert found.residuals.shape == (50 + 24,)
    assert np.isfinite(found.times[:50]).all()
    assert (np.abs(found.values - [1.3, 0.45]) < 4 * found.errors).all()


def test_frequencies_determine_springs():
    truth = fl.SliderOnBelt(mu_k=1.0, k1=1.2e4, k4=0.9e4)
    data = fl.Frequencies({mode: fl.ModeFrequency(mode)(truth) for mode in range(4)}, error=0.01)
    found = fl.fit(fl.SliderOnBelt(mu_k=1.0), data, ["k1", "k4"])
    assert (found["k1"], found["k4"]) == (pytest.approx(1.2e4, rel=1e-7), pytest.approx(0.9e4, rel=1e-7))
    assert np.isnan(found.times).all()


def test_modes_of_0_hz_are_counted_and_have_no_frequency():
    """A mass of 1 kg beside a filter: mode 0 is the filter, and mode 1 has sqrt(k)/(2 pi) Hz."""
    k, z = sp.Symbol("k"), sp.Symbol("z")
    filtered = fl.HybridAutomaton((X, V, z), (fl.Mode("on", (V, -k * X, X - z)),), {k: 3.0}, 1)
    assert fl.fit(filtered, fl.Frequencies({1: 1 / np.pi}), ["k"])["k"] == pytest.approx(4.0, rel=1e-9)
    with pytest.raises(ValueError, match=r"got mode 0 of 0 Hz.*count from the first that vibrates, 1"):
        fl.fit(filtered, fl.Frequencies({0: 1 / np.pi}), ["k"])
    with pytest.raises(ValueError, match=r"mode must be below 2, the number of modes, got 2"):
        fl.fit(filtered, fl.Frequencies({2: 1 / np.pi}), ["k"])


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


@pytest.mark.slow
def test_intervals_by_spectra_hold_the_truth_as_often_as_they_say():
    """Of 50 spectra 95 percent, within three standard deviations of the binomial distribution."""
    inside = np.zeros(2)
    strong = lines_of(TRUTH, 1e-9)
    kept = strong.frequencies[strong.values["x"] > 0.01]  # lines that are not all noise
    assert len(kept) >= 5
    for seed in range(50):
        data = lines_of(TRUTH, 0.01, seed=seed, frequencies=kept)
        found = fl.fit(TRUTH, data, ["k", "mu_s"], segments=1)
        bounds = np.array([found.interval(name) for name in ("k", "mu_s")])
        inside += (bounds[:, 0] <= [1.3, 0.9]) & (bounds[:, 1] >= [1.3, 0.9])
    assert (np.abs(inside - 47.5) < 3 * np.sqrt(50 * 0.95 * 0.05)).all(), inside


SECONDS = np.array([0.0, 0.1, 0.25, 3661.5])


@pytest.fixture
def pd():
    """Imported by tests that need it, not by every process that collects them: that takes a second."""
    import pandas

    return pandas


def stamps_of(zone):
    """Python's time stamps about the end of summer time in Berlin, when clocks are set back by an hour."""
    first = datetime(2026, 10, 25, 0, 30, tzinfo=UTC).astimezone(zone)
    return [(first.astimezone(UTC) + timedelta(seconds=s)).astimezone(zone) for s in SECONDS]


@pytest.mark.parametrize("unit", ["ms", "us", "ns"])
@pytest.mark.parametrize(
    "of",
    [
        lambda pd, steps: steps,
        lambda pd, steps: list(steps),
        lambda pd, steps: [timedelta(seconds=s) for s in SECONDS],
        lambda pd, steps: np.datetime64("2026-01-01T12:00:00") + steps,
        lambda pd, steps: pd.to_timedelta(steps),
        lambda pd, steps: pd.Series(pd.to_timedelta(steps)),
        lambda pd, steps: pd.Timestamp("2026-01-01") + pd.to_timedelta(steps),
        lambda pd, steps: pd.Timestamp("2026-10-25", tz="Europe/Berlin") + pd.to_timedelta(steps),
        lambda pd, steps: list(pd.Timestamp("2026-01-01") + pd.to_timedelta(steps)),
        lambda pd, steps: stamps_of(None),
        lambda pd, steps: stamps_of(ZoneInfo("Europe/Berlin")),
    ],
)
def test_time_stamps_and_differences_are_seconds(of, unit, pd):
    steps = np.round(SECONDS * 1000).astype("timedelta64[ms]").astype(f"timedelta64[{unit}]")
    record = fl.TimeRecord(of(pd, steps), {"x": [1.0, 2.0, 3.0, 4.0]})
    np.testing.assert_allclose(record.t, SECONDS, rtol=1e-15)
    lines = fl.SpectrumRecord.from_record(record, [0.1])
    assert lines.start is record.start


def test_time_differences_need_not_begin_at_zero_and_stamps_of_one_start():
    later = (SECONDS + 5.0) * np.timedelta64(1000, "ms")
    assert fl.EventTimes(later, "stick").t == pytest.approx(SECONDS + 5.0)
    first = np.datetime64("2026-01-01T12:00:00")
    with pytest.raises(ValueError, match="t must be times from the start of the motion, got time stamps"):
        fl.EventTimes(first + later, "stick")
    one, other = (fl.TimeRecord(first + shift + later, {"x": SECONDS}) for shift in (0, 1))
    with pytest.raises(
        ValueError, match=r"same time stamp, got 2026-01-01T12:00:05.* and 2026-01-01T12:00:06"
    ):
        fl.fit(FIRST, [one, other], ["k"])


@pytest.mark.parametrize(
    ("t", "values", "message"),
    [
        (SECONDS, np.ma.masked_equal([1.0, 2.0, 9.0, 3.0], 9.0), r"values\['x'\] .* got nan at index 2"),
        (SECONDS, np.ma.masked_equal([1, 2, 9, 3], 9), r"values\['x'\] .* got nan at index 2"),
        (SECONDS, np.arange(4).astype("timedelta64[ms]"), r"values\['x'\] must hold numbers, .*timedelta64"),
        (np.ma.masked_equal(SECONDS, 0.25), np.ones(4), "got a missing one at index 2: leave it out"),
        ([0.0, 0.1, np.nan, 0.3], np.ones(4), "got a missing one at index 2: leave it out"),
        (np.array([0, 1, "NaT", 3], "timedelta64[s]"), np.ones(4), "got a missing one at index 2"),
        (np.array(["2026-01-01", "NaT"], "datetime64[s]"), np.ones(2), "got a missing one at index 1"),
        (["2026-01-01", "2026-01-02"], np.ones(2), "t must hold numbers.*time differences or time stamps"),
    ],
)
def test_missing_values_are_refused_by_name(t, values, message):
    with pytest.raises(ValueError, match=message):
        fl.TimeRecord(t, {"x": values})


def test_values_whose_index_has_the_times_in_another_order_are_refused(pd):
    t = pd.Series([0.0, 0.1, 0.2], index=["a", "b", "c"])
    values = pd.Series([1.0, 2.0, 3.0], index=t)
    for given in (list(t), pd.Index(t), values.index):
        assert fl.TimeRecord(given, {"x": values}).count == 3
        with pytest.raises(ValueError, match=r"values\['x'\] must be in the order of t.*\.loc\[t\.index\]"):
            fl.TimeRecord(given, {"x": values[::-1]})
    assert fl.TimeRecord(t, {"x": values}).count == 3
    assert fl.TimeRecord(t, {"x": values.set_axis([1, 2, 3])}).count == 3
    with pytest.raises(ValueError, match="must be in the order of t"):
        fl.TimeRecord(t, {"x": values.set_axis(["c", "b", "a"])})


@pytest.mark.parametrize("of", [lambda table: table, lambda table: table.to_records(index=False)])
def test_a_table_has_values_in_its_columns(pd, of):
    """The table of a motion in closed form, x = cos 2t, at times that are not equidistant."""
    t = pd.Index([0.0, 0.3, 1.0, 1.1, 2.5, 4.0], name="t")
    table = pd.DataFrame({"x": np.cos(2 * t), "x'": -2 * np.sin(2 * t)}, index=t)
    free = fl.MassOnBelt(m=1.0, k=3.9, c=0.0, N=0.0)
    found = fl.fit(free, fl.TimeRecord(table.index, of(table), error=0.01), ["k"], x0=[1.0, 0.0], segments=1)
    np.testing.assert_allclose(found.model.k, 4.0, rtol=1e-9)


def test_a_missing_value_of_pandas_is_refused_by_name(pd):
    values = pd.Series([1, 2, pd.NA, 3], dtype="Float64")
    with pytest.raises(ValueError, match=r"values\['x'\] .* at index 2"):
        fl.TimeRecord(SECONDS, {"x": values})


@pytest.mark.parametrize(
    ("of", "kind", "message"),
    [
        (
            lambda t, x: (1e3 * t, x),
            ValueError,
            r"must follow the motion, got times 200 s apart .* give t in s \(is it in ms\?\)",
        ),
        (
            lambda t, x: (50.0 * t, x),
            RuntimeWarning,
            r"the times of a record are 10 s apart, .* t must be in s, is it in ms\?",
        ),
        (
            lambda t, x: (t, 1e3 * x),
            RuntimeWarning,
            r"x ranges over \d+ in a record and over 1\.\d* m .*: values must be in m",
        ),
        (
            lambda t, x: (t + 60.0, x),
            RuntimeWarning,
            r"a record begins at 60\.2 s, .*: subtract 60\.2 from t",
        ),
    ],
)
def test_other_units_and_another_start_are_told_before_the_search(of, kind, message, monkeypatch):
    data, _ = record(TRUTH, 20.0, 100)
    t, x = of(data.t, data.values["x"])
    monkeypatch.setattr(fit_module, "_solve", lambda *_: pytest.fail("the search has begun"))
    with pytest.raises(kind, match=message):
        fl.fit(FIRST, fl.TimeRecord(t, {"x": x}, error=ERROR), ["k"])


@pytest.mark.parametrize("segments", [1, 4])
def test_a_run_that_ends_before_the_data_says_why(segments):
    """x' = c x^2 with x(0) = 1 is infinite at 1/c."""
    c = sp.Symbol("c")
    escaping = fl.HybridAutomaton((X,), (fl.Mode("on", (c * X**2,)),), {c: 2.0})
    with pytest.raises(
        ValueError, match=r"end of the data at 0\.9\S* s, got one that ends at 0\.5 s \(.+\): begin"
    ):
        fl.fit(escaping, fl.TimeRecord([0.3, 0.9], {"x": [1.2, 9.0]}), ["c"], x0=[1.0], segments=segments)


def test_times_are_judged_by_what_the_record_measures():
    """A temperature every 20 s, beside a vibration of 1 Hz that takes twenty steps and more."""
    warm = sp.Symbol("warm", real=True)
    flow = (V, -((2 * sp.pi) ** 2) * X, (1 - warm) / 100)
    heated, t = fl.HybridAutomaton((X, V, warm), (fl.Mode("on", flow),), {}, 1), 20.0 * np.arange(40)
    motion = partial(fl.solve, heated, x0=[1.0, 0.0, 0.0], progress=False)
    check_times([fl.TimeRecord(t, {"warm": 1 - np.exp(-t / 100)})], motion)
    check_times([fl.TimeRecord(t, {"x": t})], partial(motion, method=fl.Taylor(max_steps=20)))
    with pytest.raises(ValueError, match="is it in ms"):
        check_times([fl.TimeRecord(t, {"x": t})], motion)


def test_what_does_not_fit_says_so():
    data, _ = record(TRUTH, 20.0, 80)
    shifted = fl.TimeRecord(data.t, {"x": data.values["x"] + 1.0}, error=1e-3)
    found = fl.fit(TRUTH, shifted, ["k"], segments=1)
    assert found.chi_square > 1e4
    assert f"misses the data by {np.sqrt(found.chi_square):.3g} times their errors" in found.warning
    assert found.warning in repr(found)
    assert found.warning in found.summary()
    assert fl.fit(TRUTH, data, ["k"], segments=1).warning is None


def test_a_phase_begins_anew_after_a_turn():
    """A search from 6.1 for the phase 0.4 stopped at a turn, and a run from beyond it ended at once."""
    model, turn, times = fl.ImpactOscillator(), 2 * np.pi, np.linspace(0.1, 9.0, 60)
    names = model.automaton().state_names
    one, other = (fl.simulate(model, 9.0, x0={"phase": p}, progress=False) for p in (0.4 + 2 * turn, 0.4))
    automaton, beyond = model.automaton(), {"phase": 0.4 + 2 * turn}
    of_automaton = fl.simulate(automaton, 9.0, x0=beyond), fl.solve(automaton, 9.0, x0=beyond, source=model)
    for each in (one, *of_automaton):
        np.testing.assert_allclose(each.final_state, other.final_state, atol=1e-9)
    x, phase = sp.symbols("x phase")  # one that never begins anew
    free = fl.HybridAutomaton((x, phase), (fl.Mode("on", (sp.cos(phase / 2), sp.S.One)),))
    assert fl.solve(free, 1.0, x0=[0.0, 7.0]).final_state == pytest.approx([2 * (np.sin(4) - np.sin(3.5)), 8])
    data = fl.TimeRecord(times, {names[0]: other(times)[:, 0]}, error=1e-3)
    found = fl.fit(model, data, ["k"], x0={"phase": 6.1}, unknown=["phase"], segments=4)
    assert found["phase at 0"] == pytest.approx(0.4, abs=1e-6)
    grid, quick = ("phase", [0.4, 0.4 + turn]), {"transient": 30.0, "window": 10.0, "progress": False}
    assert len({*fl.basins(model, grid, ("x", [-0.1]), **quick).labels.ravel()}) == 1
