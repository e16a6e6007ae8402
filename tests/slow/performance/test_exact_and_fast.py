"""The page for students: the event is missed, the bars are the rows; nothing looks at a clock."""

import re

import pytest

import page_figures
import pages
import single_costs
import work_precision
from compared_methods import METHODS
from frictionlab.hybrid.solve import solve
from reference_scenes import ReferenceScene, scenes


@pytest.fixture(scope="module")
def landing():
    return page_figures.missed_event()


@pytest.fixture(scope="module")
def rows():
    """Scene B for 0.2 s, by frictionlab and RK4."""
    scene = scenes()["B"]
    end = solve(scene.automaton, 0.2, x0=scene.x0, progress=False).final_state
    short = ReferenceScene("B", "", scene.automaton, scene.x0, 0.2, lambda: end)
    ways = [way for way in METHODS if way.family in page_figures.PICTURE_FAMILIES[:2]]
    return work_precision.measure(short, ways, repeats=1)


@pytest.fixture(scope="module")
def switched():
    return single_costs.nonlinearity_costs(t_end=0.1, repeats=1)


def test_the_landing_is_missed(landing):
    """The first hop begins and ends between two looks of the longer step; the others see it."""
    fixed, shorter, *located = landing.results
    looks = fixed.ends[0][fixed.ends[0] > 1e-9]
    assert landing.hop < looks[0] < landing.hop + 2e-5
    assert fixed.landings == 0
    assert [course.landings for course in (shorter, *located)] == [4, 4, 4]
    assert fixed.height.min() < -1e-5
    assert located[-1].height.min() > -1e-12


def test_a_missed_event_is_not_a_small_error(landing):
    """From the method's own error to a share of the motion, for good; located events keep the error."""
    fixed, shorter, *located = landing.results
    before, later = page_figures.TIMES_OF_ERRORS < -1e-4, page_figures.TIMES_OF_ERRORS > 6e-3
    for course in (fixed, shorter):
        assert course.error[later].min() > 1e3 * course.error[before].max()
        assert course.error[later].min() > 0.01 * landing.size
    assert fixed.error[before].min() > 1e3 * shorter.error[before].max()
    assert fixed.moments[1] > 1e3 * fixed.moments[0]
    for course, size in zip(located, (1e-6 * landing.size, 1e-12), strict=True):
        assert course.error.max() < size


def test_the_page_and_its_pictures(tmp_path, rows, switched):
    text = pages.write_exact_and_fast(tmp_path, rows).read_text(encoding="utf-8")
    pages.draw_switches(tmp_path, switched)
    assert text.startswith("# Exact and fast")
    assert "{" not in text
    pictures = re.findall(r"\]\((images/.*?)\)", text)
    assert len(pictures) == 3
    assert all((tmp_path / name).stat().st_size > 10_000 for name in pictures)


@pytest.mark.parametrize("snippet", re.findall(r"```python\n(.*?)```", pages.STUDENTS_TEXT, re.DOTALL))
def test_the_snippets_run(snippet, capsys):
    exec(snippet, {})
    assert capsys.readouterr().out
