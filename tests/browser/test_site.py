"""The built documentation on screens of three widths: nothing is wider than the screen, but what scrolls.

The environment variable FRICTIONLAB_SITE names the folder of the site, as in `.ci/site`.
"""

import os
from pathlib import Path

import pytest

pytestmark = pytest.mark.browser

SITE = os.environ.get("FRICTIONLAB_SITE")
WIDTHS = (390, 1280, 1920)
WITH_EQUATIONS = "theory/derivation", "theory/stability", "course/01-first-run", "course/02-why-brakes-squeal"
# What reaches beyond the window, unless something around it scrolls or cuts it off on purpose.
TOO_WIDE = """() => {
  const width = document.documentElement.clientWidth, found = [];
  const scrolls = (e) => ["auto", "scroll"].includes(getComputedStyle(e).overflowX);
  const hides = (e) => ["hidden", "clip"].includes(getComputedStyle(e).overflowX);
  for (const e of document.querySelectorAll(".bd-article-container *")) {
    const box = e.getBoundingClientRect();
    if (!(box.width > 0 && box.right > width + 1)) continue;
    let around = e.parentElement;
    while (around && !scrolls(around) && !hides(around)) around = around.parentElement;
    if (!around || around === document.body || around === document.documentElement) {
      found.push(`${e.tagName}.${e.className} to ${Math.round(box.right)}: ${e.textContent.slice(0, 40)}`);
    }
  }
  return document.documentElement.scrollWidth > width + 1 || found.length
    ? [`page ${document.documentElement.scrollWidth} of ${width}`, ...found.slice(0, 5)] : [];
}"""


def pages():
    """All pages but those of source code, and one of each dozen of the reference's, which are alike.

    What Sphinx keeps for the next build, and templates, are no pages.
    """
    if SITE is None:
        return []
    others = {"_modules", "_static", ".doctrees"}
    found = sorted(path for path in Path(SITE).rglob("*.html") if others.isdisjoint(path.parts))
    names = [path for path in found if "generated" in path.parts]
    return [path for path in found if path not in set(names)] + names[::12]


@pytest.mark.skipif(SITE is None, reason="FRICTIONLAB_SITE names no built site")
def test_nothing_on_any_page_is_wider_than_the_screen(browser):
    page = browser.new_page()
    page.route(lambda url: not url.startswith(("file:", "data:", "blob:")), lambda route: route.abort())
    found = {}
    for path in pages():
        page.goto(path.as_uri(), wait_until="load")
        for width in WIDTHS:  # a page is loaded once, and turned as a tablet is
            page.set_viewport_size({"width": width, "height": 900})
            page.wait_for_timeout(50)
            if wide := page.evaluate(TOO_WIDE):
                found[f"{path.relative_to(SITE)} on {width}"] = wide
    page.close()
    assert not found, "\n".join(f"{name}: {wide}" for name, wide in found.items())


@pytest.mark.skipif(SITE is None, reason="FRICTIONLAB_SITE names no built site")
def test_equations_fit_into_the_text_of_wide_screens(browser):
    page = browser.new_page(viewport={"width": 1280, "height": 900})
    seen = 0
    for name in WITH_EQUATIONS:
        page.goto((Path(SITE) / f"{name}.html").as_uri(), wait_until="load")
        page.evaluate("document.fonts.ready.then(() => true)")  # for which fit_equations.js waits
        boxes = page.evaluate(
            "[...document.querySelectorAll('div.math')].map(e => [e.scrollWidth, e.clientWidth])"
        )
        seen += len(boxes)
        assert all(needed <= there + 1 for needed, there in boxes), name
    page.close()
    assert seen > 20
