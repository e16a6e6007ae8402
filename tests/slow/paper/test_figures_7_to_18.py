"""Figs 7 to 18: what they hold and how they are drawn, on tiny grids and short runs."""

import numpy as np
import pytest

import frictionlab as fl
from frictionlab.paper import scenes, step_sizes
from frictionlab.paper.results import STEADY
from frictionlab.paper.scenes import Setting, in_range, intervals_text, regime_changes

GRIDS = {
    "mu_k": (0.3, 1.4),
    "mu_k_near": (1.4,),
    "mu_k_stiff": (0.15, 2.5),
    "preloads": (100.0, 200.0),
}


@pytest.fixture
def tiny(monkeypatch):
    """Two values of each parameter, some seconds of motion."""
    for name, values in GRIDS.items():
        monkeypatch.setattr(scenes, name, lambda setting, values=values: np.array(values))
    monkeypatch.setattr(scenes, "mu_k_coarse", lambda setting, *further: np.array([0.3, 1.4]))
    for name in ("USUAL_TIMES", "FIXED_STEP_TIMES"):
        monkeypatch.setattr(scenes, name, scenes.Times(3.0, 2.0))
    monkeypatch.setattr(scenes, "STIFF_TIMES", scenes.Times(1.0, 1.0))
    monkeypatch.setattr(scenes, "CACHE", {})


PANELS = {7: 6, 8: 6, 9: 1, 10: 1, 11: 2, 12: 3, 13: 6, 14: 3, 15: 4, 16: 3, 17: 3, 18: 8}


@pytest.mark.parametrize("number", STEADY)
def test_a_figure_has_numbers_and_a_picture(number, tiny):
    found = fl.paper.figure(number, progress=False)
    lines = str(found).splitlines()
    assert lines[0].startswith(f"Fig. {number}: ")
    assert "exact solver" in lines[0]
    assert len(lines) == 1 + len(found.summary) > 1
    assert str(found).isascii()
    assert len(repr(found)) < 200
    picture = found.plot()
    picture.draw_without_rendering()
    assert len(picture.axes) == PANELS[number]
    assert picture.get_suptitle().startswith(f"Fig. {number}: ")
    assert found.how in picture.get_suptitle()
    unlabelled = [ax for ax in picture.axes if not ax.get_ylabel()]
    assert len(unlabelled) == (2 if number == 18 else 0)  # there the right ones share the axis of the left


@pytest.mark.parametrize("number", [9, 16, 18])
def test_algorithm_and_impact_law_reach_the_runs(number, tiny):
    by_paper = fl.paper.figure(number, progress=False, algorithm="paper")
    assert by_paper.how == "paper's algorithm, step 0.0002 s, Eq. (13)"
    with_full = fl.paper.figure(number, progress=False, impact="full gap rate")
    assert with_full.how == "exact solver, full gap rate"
    sweep = scenes.sweep_from_rest(1e4, Setting(algorithm="paper", progress=False))
    assert sweep.specification["method"] == fl.RK4(step=2e-4).describe()
    assert sweep.specification["tolerance"] == pytest.approx(0.1, abs=0.002)
    full = scenes.sweep_from_rest(1e4, Setting(impact="full gap rate", progress=False))
    assert full.model.impact == fl.PlasticImpact(penetration_rate="full")
    assert full.specification["tolerance"] == 1e-6


def test_figures_share_sweeps_and_keep_them_in_files(tiny, tmp_path):
    fl.paper.figure(9, progress=False, resume=tmp_path)
    (file,) = tmp_path.glob("*.jsonl")
    before = file.stat().st_mtime_ns
    fl.paper.figure(10, progress=False, resume=tmp_path)
    assert len(list(tmp_path.glob("*.jsonl"))) == 2
    assert file.stat().st_mtime_ns == before
    scenes.CACHE.clear()
    again = fl.paper.figure(9, progress=False, resume=tmp_path)
    assert again.data.sweeps[1e4, "rest"].kinds == fl.load_bifurcation(file).kinds


def test_a_sweep_that_was_cut_off_is_no_figure(tiny, monkeypatch):
    def cut_off(model, parameter, values, x0, **options):
        raise KeyboardInterrupt

    monkeypatch.setattr(scenes, "bifurcation", cut_off)
    with pytest.raises(KeyboardInterrupt):
        fl.paper.figure(9, progress=False)
    assert not scenes.CACHE


def test_grids_hold_what_the_text_names():
    full, quick = Setting(), Setting(quick=True)
    fine = scenes.mu_k(full)
    assert len(fine) == 60
    assert {0.05, 0.4, 0.9, 1.3, 1.8, 3.0} <= set(fine)
    assert {0.05, 0.1, 0.75, 1.3, 2.9} <= set(scenes.mu_k_coarse(full, *scenes.MU_K_NAMED_IN_TEXT))
    assert {0.05, 0.1, 0.15, 0.2} <= set(scenes.mu_k_stiff(full))
    assert {0.38, 0.05, 0.01} <= set(scenes.mu_k_coarse(full, *scenes.MU_K_SMALL))
    for grid in scenes.mu_k, scenes.mu_k_near, scenes.mu_k_stiff, scenes.preloads:
        assert set(grid(quick)) <= set(grid(full)) or grid is scenes.mu_k_near
        assert len(grid(quick)) < len(grid(full))
    assert set(scenes.mu_k_near(quick)) <= set(scenes.mu_k(quick))
    assert set(scenes.mu_k_near(full)) <= set(scenes.mu_k_coarse(full))


class Found:
    """A sweep as far as the words go."""

    def __init__(self, kinds, onsets=None):
        self.kinds = tuple(kinds)
        self.values = np.arange(1, len(kinds) + 1) / 10
        self.onsets = np.zeros(len(kinds)) if onsets is None else np.array(onsets)


def test_stretches_in_words():
    assert intervals_text(Found(["equilibrium"] * 2 + ["periodic"])) == "equilibrium 0.1 to 0.2, periodic 0.3"
    mixed = intervals_text(Found(["periodic", "non-periodic"] * 4))
    assert mixed == "periodic at 4 of 8 values (0.1 to 0.7), non-periodic at 4 of 8 values (0.2 to 0.8)"


def test_changes_of_regime_leave_out_what_has_not_settled():
    kinds = ["equilibrium", "periodic", "not settled yet", "periodic", "periodic", "non-periodic"]
    assert regime_changes(Found(kinds, [0, 1, 0, 1, 2, 0])) == 3


def test_ranges_of_values():
    found = Found(["periodic"] * 4)
    assert in_range(found, 0.2, 0.4).tolist() == [False, True, True, True]
    assert in_range(found, 0.2, np.inf).tolist() == [False, True, True, True]
    assert in_range(found, 0.2, 0.4, open_end=True).tolist() == [False, True, True, False]


STEPS = (5e-4, 2e-4)


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    """Two values of mu_k, short windows."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(step_sizes, "MU_K", np.array([0.2, 1.4]))
        patch.setattr(step_sizes, "STUDY_TIMES", scenes.Times(30.0, 10.0))
        yield step_sizes.step_study(Setting(progress=False), STEPS)


def test_series_in_order(study):
    assert [s.label for s in study.of("paper")] == [
        "fixed step 0.0005 s",
        "fixed step 0.0002 s",
        "every event located",
    ]
    assert len(study.series) == 6
    assert (study.of("full gap rate")[-1].step, study.of("full gap rate")[-1].impact) == (
        None,
        "full gap rate",
    )


def test_the_exact_series_is_the_issue_of_events(study):
    """claims.md, E5: three onsets at 3.56 Hz and L_s 0.0138 as printed; 0.00122 with the full rate."""
    printed, full = study.of("paper")[-1], study.of("full gap rate")[-1]
    assert printed.intensity[1] == pytest.approx(0.0138, rel=0.01)
    assert full.intensity[1] == pytest.approx(0.00122, rel=0.01)
    assert full.strongest[1] == pytest.approx(11.05, abs=0.05)
    assert np.isnan(printed.strongest[0])
    assert printed.kinds == ("equilibrium", "periodic")


def test_errors_are_large_only_where_flights_are_shorter_than_a_step(study):
    printed, full = study.errors("paper"), study.errors("full gap rate")
    assert set(printed) == set(full) == set(STEPS)
    assert printed[2e-4].max() > 1.0
    assert full[2e-4].max() < 0.1
