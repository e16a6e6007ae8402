"""The study of step sizes: under Eq. (13) each fixed step has a motion of its own."""

import numpy as np
import pytest

import frictionlab as fl
from frictionlab.paper import report, scenes, step_sizes
from frictionlab.paper.scenes import Setting

STEPS = (5e-4, 2e-4)


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    """Two values of mu_k, short windows."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(step_sizes, "MU_K", np.array([0.2, 1.4]))
        patch.setattr(step_sizes, "STUDY_TIMES", scenes.Times(30.0, 10.0))
        yield step_sizes.step_study_with(Setting(progress=False), STEPS)


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


def test_the_picture(study):
    figure = study.plot()
    above, other, below, _ = figure.axes
    assert [above.get_title(), other.get_title()] == list(step_sizes.IMPACT_LAW_NAMES.values())
    assert above.get_yscale() == "log"
    assert below.get_ylabel().endswith("(Hz)")
    assert len(above.lines) == 3
    drawn = above.lines[-1].get_ydata()
    assert np.isnan(drawn[0])
    assert drawn[1] == study.of("paper")[-1].intensity[1]


def test_the_page(study):
    text = report.step_size_page(study, "images/x.png")
    assert "![Intensity and strongest frequency against mu_k](images/x.png)" in text
    assert "| every event located | Eq. (13) as printed | periodic | 0.0137" in text
    assert text.count("| fixed step 0.0002 s |") == 2
    assert "nan" not in text


def test_public_name_and_bad_steps():
    assert fl.paper.step_study is step_sizes.step_study
    with pytest.raises(ValueError, match="step must be a finite number, above 0, got -1"):
        fl.paper.step_study([-1.0])
