"""Figs 2 to 6 of the paper: the numbers, and the pictures of them."""

from functools import cache

import numpy as np
import pytest

import frictionlab as fl
from frictionlab.paper.results import EVERY_FIGURE
from tests.helpers.cases import slow_but

CRITICAL = {0.0: 1.51752661, 1e4: 1.51378354, 1e7: 0.58293736}  # at F = 200 N, by k_nl


NOTCHED = fl.SliderOnBelt(k_nl=1e7)  # of the curve of fig. 4 with a notch


@cache
def figure(number):
    return fl.paper.figure(number)


def at_200(curve):
    (value,) = curve.values[curve.at == 200.0]
    return value


def test_there_are_figures_2_to_18():
    assert sorted(EVERY_FIGURE) == list(range(2, 19))


@pytest.mark.parametrize("number", [1, 19, 2.5, "2", None, [2]])
def test_other_numbers_are_refused_with_those_there_are(number):
    with pytest.raises(ValueError, match=r"must be one of 2, 3, .*, 17, 18, got"):
        fl.paper.figure(number)


@pytest.mark.slow  # the changes of these figures tell as much
@pytest.mark.parametrize(("number", "preload"), [(2, 100.0), (3, 1000.0)])
def test_figs_2_and_3_show_a_pair_whose_frequencies_meet(number, preload):
    data = figure(number).data
    assert data.preload == preload
    assert list(data.loci) == [0.0, 1e4, 1e7]
    for k_nl, locus in data.loci.items():
        assert (locus.model.F, locus.model.k_nl) == (preload, k_nl)
        a, b = data.pairs[k_nl]
        apart = np.abs(locus.frequencies[:, a] - locus.frequencies[:, b])
        assert apart[0] > 0.2
        assert apart[-1] < 0.01
        growth = locus.growth_rates[:, [a, b]]
        assert growth[0].max() < 0 < growth[-1].max()
        assert np.argmax(locus.growth_rates[-1]) in (a, b)


@pytest.mark.parametrize("number", slow_but([3], [2, 3]))
def test_changes_of_figs_2_and_3_are_where_the_eigenvalues_say(number):
    data = figure(number).data
    assert list(data.changes) == list(data.loci) == [0.0, 1e4, 1e7]
    for k_nl, changes in data.changes.items():
        locus = data.loci[k_nl]
        assert changes
        assert changes[0].value == fl.critical_value(locus.model, "mu_k", (0.0, 3.0))
        counts = np.zeros(len(locus.at), dtype=int)
        for change in changes:
            counts[locus.at > change.value] = change.unstable[1]
        assert np.array_equal(counts, locus.unstable)


@pytest.mark.slow  # test_paper_values has these values, test_stability_changes curves
def test_fig_4_at_the_usual_preload():
    curves = figure(4).data.curves
    assert list(curves) == list(CRITICAL)
    for k_nl, value in CRITICAL.items():
        assert at_200(curves[k_nl]) == pytest.approx(value, abs=1e-7)


@pytest.mark.slow  # as that of fig. 4
def test_fig_5_at_the_usual_preload():
    curves = figure(5).data.curves
    assert at_200(curves["with GN"]) == pytest.approx(1.51378354, abs=1e-7)
    assert at_200(curves["without GN"]) == pytest.approx(1.97391014, abs=1e-7)


@pytest.mark.slow
@pytest.mark.parametrize("number", [4, 5])
def test_figs_4_and_5_have_no_gap_and_cover_the_preloads_of_figs_2_and_3(number):
    curves = figure(number).data.curves
    assert curves
    for curve in curves.values():
        assert len(curve.at) > 1
        assert np.isfinite(curve.values).all()
        assert (np.diff(curve.at) > 0).all()
        assert curve.at[0] < 1.0
        assert curve.at[-1] == 1000.0


def test_the_notch_in_fig_4_is_a_second_window_of_instability():
    for preload, mu_k, stable in [(170.0, 0.15, True), (170.0, 0.2, False), (170.0, 0.4, True)]:
        assert fl.eigenvalues(NOTCHED.replace(F=preload, mu_k=mu_k)).stable == stable
    for preload in (150.0, 195.0):
        assert fl.eigenvalues(NOTCHED.replace(F=preload, mu_k=0.2)).stable


@pytest.mark.slow
def test_the_curve_of_fig_4_has_the_notch():
    curve = figure(4).data.curves[1e7]
    assert curve.model.replace(mu_k=NOTCHED.mu_k) == NOTCHED
    jumps = np.flatnonzero(np.abs(np.diff(curve.values)) > 0.3)
    assert len(jumps) == 2
    assert (np.diff(curve.at)[jumps] < 0.5).all()
    inside = curve.values[jumps[0] + 1 : jumps[1] + 1]
    assert ((inside > 0.15) & (inside < 0.25)).all()


def test_fig_6():
    data = figure(6).data
    changes = {name: [c.value for c in found] for name, found in data.changes.items()}
    assert changes["with GN"] == pytest.approx([0.69, 1.19, 2.09], abs=0.005)
    assert changes["without GN"] == pytest.approx([1.87], abs=0.005)
    assert [c.unstable[1] for c in data.changes["with GN"]] == [1, 2, 1]
    assert [c.unstable for c in data.changes["without GN"]] == [(0, 1)]
    assert [len(pairs) for pairs in data.pairs.values()] == [2, 1]
    assert sorted(np.ravel(data.pairs["with GN"])) == [0, 1, 2, 3]
    assert data.loci["with GN"].unstable.max() == 2
    assert data.loci["without GN"].unstable.max() == 1


def test_the_panels_of_one_figure_use_the_locus():
    data = figure(3).data
    drawn = [line.get_ydata() for line in figure(3).plot().axes[0].lines]
    for k_nl, locus in data.loci.items():
        for mode in data.pairs[k_nl]:
            assert any(np.array_equal(locus.frequencies[:, mode], y) for y in drawn)


@pytest.mark.slow
def test_a_curve_that_is_given_out_again_cannot_be_changed():
    again = fl.paper.figure(5).data.curves["with GN"]
    with pytest.raises(ValueError, match="read-only"):
        again.values[0] = 0.0
