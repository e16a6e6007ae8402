"""Schematics of models on the site: every model of the package has one, on its page too."""

import re
import sys
from pathlib import Path

import pytest

import frictionlab as fl

pytest.importorskip("sphinx", reason="the site is built by sphinx")
pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[3]
PAGES = [path for path in sorted((ROOT / "docs" / "models").glob("*.md")) if path.stem != "index"]
MODELS = sorted({row.call.partition("(")[0] for row in fl.list_models("classics")})


@pytest.fixture(scope="module")
def extension():
    """The module of the site's sources, which is no package."""
    sys.path.insert(0, str(ROOT / "docs" / "_extensions"))
    try:
        import schematics

        yield schematics
    finally:
        sys.path.remove(str(ROOT / "docs" / "_extensions"))


@pytest.mark.parametrize("name", MODELS)
def test_a_schematic_has_the_parts_of_the_model(name, tmp_path, extension):
    path = tmp_path / "new" / f"{name}.svg"
    extension.draw(f"{name}()", path)
    picture = path.read_text(encoding="utf-8")
    assert picture.count("<path") > 2  # at least a wall and a body
    assert extension.BODY.lower() in picture
    assert "nan" not in picture
    before = path.stat().st_mtime_ns
    extension.draw(f"{name}()", path)  # as it is there, it is not drawn again
    assert path.stat().st_mtime_ns == before


def test_the_pages_of_the_zoo_have_a_schematic_of_every_system():
    pages = (ROOT / "docs" / "zoo").glob("*.md")
    text = "\n".join(page.read_text() for page in pages)
    shown = re.findall(r"^```\{schematic\} (\w+)\(\)$", text, flags=re.MULTILINE)
    zoo = {row.call.partition("(")[0] for row in fl.list_models() if row.topic != "classics"}
    assert sorted(shown) == sorted(zoo)


def test_every_page_of_a_model_has_its_schematic():
    shown = [
        re.findall(r"^```\{schematic\} (\w+)\(\)$", page.read_text(), flags=re.MULTILINE) for page in PAGES
    ]
    assert all(len(names) == 1 for names in shown)
    assert sorted(names[0] for names in shown) == MODELS
