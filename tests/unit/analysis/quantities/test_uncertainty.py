"""Distributions of quantities, against closed forms."""

import numpy as np
import pytest
from scipy import stats

import frictionlab as fl

QUIET = {"progress": False}
SLIDER = fl.SliderOnBelt(mu_k=1.4)
COUPLED = fl.ModeCoupling(c=0.0)
A, B = 7.0, 0.1  # of Ishigami's function
AROUND_TEN = stats.uniform(10.0 - np.pi, 2 * np.pi)  # parameters are positive


def ishigami(model):
    x, y, z = model.M - 10.0, model.m - 10.0, model.J - 10.0
    return np.sin(x) + A * np.sin(y) ** 2 + B * z**4 * np.sin(x)


def product(model):
    return model.k1 * model.k2


def test_indices_of_a_product():
    """With variances (s m)^2 of factors of mean m: s1^2 and s2^2 alone, s1^2 s2^2 together."""
    ranges = {"k1": stats.uniform(0.4, 1.2), "k2": stats.uniform(0.6, 0.8)}
    found = fl.sobol_indices(COUPLED, product, ranges, n=512, **QUIET)
    first, second = 0.6**2 / 3, 0.4**2 / 3
    variance = first + second + first * second
    alone, with_others = np.array([first, second]), np.array([first, second]) + first * second
    assert found.first_order == pytest.approx(alone / variance, abs=0.02)
    assert found.total_order == pytest.approx(with_others / variance, abs=0.02)
    assert (found.first_errors < 0.1).all()
    assert (found.total_errors < 0.05).all()


@pytest.mark.slow
def test_ishigamis_indices():
    ranges = dict.fromkeys(("M", "m", "J"), AROUND_TEN)
    found = fl.sobol_indices(SLIDER, ishigami, ranges, n=2048, **QUIET)
    first = (1 + B * np.pi**4 / 5) ** 2 / 2
    second = A**2 / 8
    both = B**2 * np.pi**8 * (1 / 18 - 1 / 50)
    variance = first + second + both
    assert found.first_order == pytest.approx(np.array([first, second, 0.0]) / variance, abs=0.03)
    assert found.total_order == pytest.approx(np.array([first + both, second, both]) / variance, abs=0.03)
    assert (found.total_errors < 0.05).all()


@pytest.mark.slow
def test_indices_of_the_onset_of_mode_coupling_are_those_of_its_closed_form():
    """By Gauss-Legendre quadrature of mu_c in k1, k2 and k3: V[E(mu_c | p)] and V[E(mu_c | all but p)]."""
    names, half = ("k1", "k2", "k3"), 0.1
    onset = fl.CriticalValue("mu_k", (0.0, 4.0))
    ranges = {n: stats.uniform(v * (1 - half), 2 * half * v) for n in names for v in (COUPLED.parameters[n],)}
    found = fl.sobol_indices(COUPLED, onset, ranges, n=256, **QUIET)
    nodes, weights = np.polynomial.legendre.leggauss(8)
    weights = weights / 2
    at = np.array(
        [
            COUPLED.replace(
                **{n: COUPLED.parameters[n] * (1 + half * x) for n, x in zip(names, (a, b, c))}
            ).critical_friction
            for a in nodes
            for b in nodes
            for c in nodes
        ]
    ).reshape(8, 8, 8)
    every = np.einsum("i,j,k->ijk", weights, weights, weights)
    mean = (every * at).sum()
    variance = (every * (at - mean) ** 2).sum()
    for i in range(3):
        others = tuple(j for j in range(3) if j != i)
        pair = np.outer(weights, weights)
        alone = np.tensordot(at, pair, (others, (0, 1)))
        without = np.tensordot(at, weights, ((i,), (0,)))
        first = (weights * (alone - mean) ** 2).sum() / variance
        total = 1.0 - (pair * (without - mean) ** 2).sum() / variance
        assert abs(found.first_order[i] - first) < max(4 * found.first_errors[i], 0.01)
        assert abs(found.total_order[i] - total) < max(4 * found.total_errors[i], 0.01)
    assert (found.first_errors < 0.1).all()


def stiffness(model):
    """Of the module, so that other processes find it."""
    return model.k1 + model.k2


@pytest.mark.slow
def test_points_are_computed_on_dask():
    """Processes of a cluster: a function point by point, a quantity many at once; the same numbers."""
    distributed = pytest.importorskip("distributed", reason="the extra dask is not installed")
    ranges = {"k1": stats.uniform(0.9, 0.2), "k2": stats.uniform(0.9, 0.2)}
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        for quantity in (stiffness, fl.GrowthRate()):
            here = fl.uncertainty(COUPLED, quantity, ranges, n=32, **QUIET)
            there = fl.uncertainty(COUPLED, quantity, ranges, n=32, executor=client.get_executor(), **QUIET)
            assert np.array_equal(here.values, there.values)
        shares = fl.sobol_indices(COUPLED, stiffness, ranges, n=32, executor=client.get_executor(), **QUIET)
        assert shares.first_order == pytest.approx(
            fl.sobol_indices(COUPLED, stiffness, ranges, n=32, **QUIET).first_order, abs=0.0
        )


def test_ishigamis_mean_and_variance_are_within_their_errors():
    found = fl.uncertainty(SLIDER, ishigami, dict.fromkeys(("M", "m", "J"), AROUND_TEN), n=1024, **QUIET)
    variance = A**2 / 8 + B * np.pi**4 / 5 + B**2 * np.pi**8 / 18 + 0.5
    assert abs(found.mean.value - A / 2) < 4 * found.mean.error < 0.2
    spread = found.standard_deviation
    assert abs(spread.value - np.sqrt(variance)) < 4 * spread.error < 0.2


def test_onsets_of_mode_coupling_have_the_distribution_of_their_closed_form():
    """mu_c falls with k1 in this range: P(mu_c < t) = P(k1 > k1(t))."""
    stiffness = stats.uniform(0.9, 0.2)
    onset = fl.CriticalValue("mu_k", (0.0, 4.0))
    found = fl.uncertainty(COUPLED, onset, {"k1": stiffness}, n=64, **QUIET)
    exact = [COUPLED.replace(k1=k1).critical_friction for k1 in found.points[:, 0]]
    assert found.values == pytest.approx(exact, rel=1e-9)
    at = COUPLED.replace(k1=1.03).critical_friction
    estimate = found.probability(below=at)
    assert abs(estimate.value - stiffness.sf(1.03)) < 4 * estimate.error + 1 / 128
    assert found.quantile(0.05) == pytest.approx(COUPLED.replace(k1=1.09).critical_friction, rel=2e-3)


def test_the_error_of_a_probability_covers_a_run_ten_times_as_large():
    ranges = {"F": stats.uniform(150.0, 100.0), "mu_k": stats.norm(1.5, 0.1)}
    few = fl.uncertainty(SLIDER, fl.GrowthRate(), ranges, n=256, **QUIET).probability(above=0.0)
    many = fl.uncertainty(SLIDER, fl.GrowthRate(), ranges, n=4096, rng=7, **QUIET).probability(above=0.0)
    assert 0.3 < many.value < 0.6
    assert abs(few.value - many.value) < 4 * np.hypot(few.error, many.error)
    assert many.error < few.error


@pytest.mark.slow
def test_where_stability_is_never_lost_there_is_no_value():
    onset = fl.CriticalValue("mu_k", (0.0, 1.5))
    found = fl.uncertainty(SLIDER, onset, {"F": stats.uniform(150.0, 100.0)}, n=16, **QUIET)
    never = np.isnan(found.values)
    assert 0 < never.sum() < 16
    assert found.probability(below=1.5).value == pytest.approx(1 - never.mean())
    assert found.quantile(1.0) == np.inf
    assert f"{never.sum()} without" in repr(found)
    with pytest.raises(ValueError, match="must exist at all points to have indices"):
        fl.sobol_indices(SLIDER, onset, {"F": stats.uniform(150.0, 100.0)}, n=16, **QUIET)
