"""Every script of the gallery draws its picture."""

import runpy
from pathlib import Path

import pytest
from matplotlib.figure import Figure

SCRIPTS = sorted((Path(__file__).parents[3] / "docs" / "gallery").glob("*.py"))


@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: path.stem)
def test_script_draws(path, tmp_path):
    left = runpy.run_path(str(path))
    assert isinstance(left["figure"], Figure)
    left["figure"].savefig(tmp_path / "picture.png")
    assert (tmp_path / "picture.png").stat().st_size > 5000
