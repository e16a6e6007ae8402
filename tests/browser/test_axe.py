"""axe-core finds no serious fault on lessons, formulas and the index of pages, nor on the site.

Those of the explorer are in test_explorer.py.
"""

import os
from pathlib import Path

import pytest

import frictionlab as fl
from frictionlab.pages.gallery import index_page, library_scenes
from tests.browser.screen import cut_off, faults
from tests.browser.test_page import exported, opened

pytestmark = [pytest.mark.browser, pytest.mark.slow]

SITE = Path(os.environ.get("FRICTIONLAB_SITE", Path(__file__).parents[2] / "docs/_build/html"))
PAGES = ("index.html", "getting-started.html", "models/slider-on-rigid-belt.html", "course/00-one-mass.html")


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_lessons_formulas_and_the_index_of_pages(browser, axe, tmp_path, theme):
    model = fl.MassOnBelt(friction=fl.FrictionCurve(), c=0.1)
    page = opened(browser, exported(model, tmp_path / "page.html"))
    page.evaluate("(name) => explorer.setTheme(name)", theme)
    page.get_by_label("μ(v) =").fill("0.3 + x")
    page.keyboard.press("Enter")
    page.evaluate("explorer.lesson.record([{ text: 'a step', control: 'v', changed: {} }])")
    assert faults(page, axe) == []
    page.get_by_role("button", name="finish").click()
    assert faults(page, axe) == []
    page.context.close()
    index = tmp_path / "index.html"
    index.write_text(
        index_page(library_scenes(), {"BouncingBall()": "too many modes"}, "../"), encoding="utf-8"
    )
    page = browser.new_context(color_scheme=theme).new_page()
    page.goto(index.as_uri())
    page.wait_for_selector("body[data-ready]")
    for width in (390, 1280, 1920):
        page.set_viewport_size({"width": width, "height": 900})
        assert cut_off(page, "#explorer") == []
    assert faults(page, axe) == []
    page.context.close()


@pytest.mark.parametrize("name", PAGES)
@pytest.mark.parametrize("theme", ["light", "dark"])
def test_the_site(browser, axe, name, theme):
    if not (SITE / name).is_file():
        pytest.skip(f"the site is not built (nox -s site): there is no {SITE / name}")
    page = browser.new_page(viewport={"width": 1280, "height": 800}, color_scheme=theme)
    page.goto((SITE / name).resolve().as_uri())
    page.wait_for_timeout(500)
    assert faults(page, axe) == []
    page.close()
