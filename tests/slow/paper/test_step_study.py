"""The study of step sizes: under Eq. (13) each fixed step has a motion of its own."""

import numpy as np
import pytest

from frictionlab.paper import scenes, step_sizes
from frictionlab.paper.scenes import Setting

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
