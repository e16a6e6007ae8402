"""Exported pages within those of the site, and what stands there without a solver for browsers."""

import subprocess
import sys
from pathlib import Path

import pytest

from frictionlab.compilation.manifest import lacking_objects
from frictionlab.compilation.targets import WEB

pytest.importorskip("sphinx", reason="the site is built by sphinx")
pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[3]
PAGE = """# A page

```{live-page}
:model: MassOnBelt(friction=Stribeck(v_s=0.1), c=0.1)
:set: t_end=5
:picture: picture.png

A mass on a belt
```
"""
CONF = "import sys\nsys.path.insert(0, {path!r})\nextensions = ['myst_nb', 'live_pages']\n{more}\n"
WITHOUT = "from frictionlab.compilation import manifest\nmanifest.FOLDERS = ()"


def built(folder, more=""):
    pytest.importorskip("myst_nb", reason="the site is written for it")
    (folder / "conf.py").write_text(CONF.format(path=str(ROOT / "docs" / "_extensions"), more=more))
    (folder / "index.md").write_text(PAGE)
    picture = (ROOT / "docs" / "images" / "first-run.png").read_bytes()
    (folder / "picture.png").write_bytes(picture)
    command = [sys.executable, "-m", "sphinx", "-W", "-b", "html", str(folder), str(folder / "site")]
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, timeout=300)
    assert done.returncode == 0, done.stderr
    return done.stdout, (folder / "site" / "index.html").read_text(encoding="utf-8")


def test_without_a_solver_the_picture_is_there_and_no_warning(tmp_path):
    said, page = built(tmp_path, WITHOUT)
    assert said.count("live pages are left out") == 1
    assert "<iframe" not in page
    assert 'alt="A mass on a belt" src="_images/picture.png"' in page
    assert not (tmp_path / "site" / "live").exists()


def test_with_a_solver_the_page_is_embedded_and_can_be_downloaded(tmp_path):
    if lacking_objects([WEB.file]):
        pytest.skip("the kernels have not been compiled for browsers")
    said, page = built(tmp_path)
    assert "left out" not in said
    (made,) = (tmp_path / "site" / "live").iterdir()
    assert f'src="live/{made.name}#t_end=5"' in page
    assert f'download="{made.name}"' in page
    assert 'title="MassOnBelt: exact solver, in your browser"' in page
    assert "<img" not in page
    assert 1e5 < made.stat().st_size < 1e6
