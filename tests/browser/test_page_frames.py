"""The benchmark of exported pages, with a browser of its own."""

import pytest

from frictionlab.bench.response_times import PAGE_SCENES, page_frames, page_table
from frictionlab.pages.export import SolverNotBuiltError

pytestmark = pytest.mark.browser


def test_a_slider_is_dragged_on_every_scene():
    pytest.importorskip("playwright", reason="playwright drives the browser; it is not installed")
    try:
        found = page_frames(3)
    except (SolverNotBuiltError, FileNotFoundError) as error:  # neither solver nor browser
        pytest.skip(str(error))
    assert found.keys() == PAGE_SCENES.keys()
    for one in found.values():
        assert 1e5 < one.bytes < 1e6
        assert len(one.frames) == len(one.solved) == 3
        assert min(one.solved) > 0
    assert page_table(found).count("MB | 3 |") == 3
