"""`frictionlab reproduce`: what it writes, says and returns."""

import numpy as np
import pytest

from frictionlab.cli import command
from frictionlab.paper import report
from frictionlab.paper.scenes import IMPACTS
from frictionlab.paper.step_sizes import StepSeries, StepStudy

MADE_UP = StepStudy(
    np.array([0.4, 1.4]),
    tuple(
        StepSeries(step, impact, ("equilibrium", "periodic"), np.array([0.0, 0.01]), np.array([np.nan, 3.5]))
        for impact in IMPACTS
        for step in (2e-4, None)
    ),
)


@pytest.fixture
def small(monkeypatch):
    """Two claims, one figure of linear stability, and a study of step sizes made up."""
    monkeypatch.setattr(report, "EVERY_CLAIM", ("C1", "C8"))
    monkeypatch.setattr(report, "figure_variants", lambda: iter([(6, "exact")]))
    monkeypatch.setattr(report, "step_study", lambda setting: MADE_UP)


@pytest.mark.slow
def test_a_page_with_claims_and_pictures(tmp_path, capsys, small):
    assert command.main(["reproduce", "--quick", "-o", str(tmp_path / "docs"), "-q"]) == 0
    out, err = capsys.readouterr()
    page, image = tmp_path / "docs" / "reproduction.md", "images/reproduction/fig06.png"
    assert out == f"Page in {page}\n"
    assert err == ""
    text = page.read_text(encoding="utf-8")
    assert "frictionlab reproduce` --quick" in text.replace("\n", " ")
    assert "2 claims: reproduced 2." in text
    assert '<summary><b>C8</b> <span class="verdict verdict-reproduced">✔ reproduced</span> Fig. 6: ' in text
    assert f"![Fig. 6]({image})" in text
    picture = page.parent / image
    assert picture.read_bytes()[:4] == b"\x89PNG"
    assert 5_000 < picture.stat().st_size < 150_000
    steps = (tmp_path / "docs" / "step-size.md").read_text()
    assert "| 0.0002 | 0, 0 | 0, 0 |" in steps
    assert (page.parent / "images/reproduction/step-size.png").exists()


def test_every_figure_in_every_way_that_makes_a_difference():
    pairs = list(report.figure_variants())
    assert len(pairs) == len(set(pairs)) == 5 + 2 * 2 + 10 * 3
    assert {n for n, _ in pairs} == set(range(2, 19))
    assert [way for n, way in pairs if n == 13] == ["exact", "paper-algorithm"]


def test_ctrl_c_is_told_by_the_exit_status(tmp_path, capsys, small, monkeypatch):
    def interrupted(*arguments):
        raise KeyboardInterrupt

    monkeypatch.setattr(report, "check", interrupted)
    assert command.main(["reproduce", "-o", str(tmp_path), "-q"]) == 130
    assert capsys.readouterr().err == "frictionlab: stopped by ctrl-C\n"
