"""How exported pages follow a slider: their size, and the time from picture to picture in an installed
Chromium.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from types import MappingProxyType
from typing import Any

from frictionlab.models import MassOnBelt, SliderOnBelt
from frictionlab.pages import export
from tables import markdown_table

CHROMIUM = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
SCREEN = {"width": 1280, "height": 900}
# A model, and the range in which the slider of mu_k is moved.
PAGE_SCENES: Mapping[str, tuple[Any, float, float]] = MappingProxyType(
    {
        "slider on a belt, no events": (SliderOnBelt(), 0.2, 0.36),
        "slider on a belt, chatter": (SliderOnBelt(), 1.0, 1.4),
        "mass on a belt": (MassOnBelt(), 0.3, 0.6),
    }
)
# Every frame has a new value, far from the last; the first frames, while the browser compiles, do not count.
DRAG = """async ([count, low, high]) => {
  const slider = explorer.root.querySelector("[data-name=mu_k] input[type=range]"), unseen = 20;
  const frames = [], solved = [];
  const places = explorer.controls.find(({ name }) => name === "mu_k").positions;
  let last = null;
  for (let i = 0; i < count + unseen; i++) {
    slider.value = nearest(places, low + (high - low) * (7 * i % count) / count);
    slider.oninput();
    const now = await new Promise(requestAnimationFrame);
    if (i >= unseen) { frames.push(now - last); solved.push(explorer.result.milliseconds); }
    last = now;
  }
  return [frames, solved];
}"""


@dataclass(frozen=True)
class PageFrames:
    """Bytes of a page; milliseconds from picture to picture while a slider moves, and those of the solver."""

    bytes: int
    frames: tuple[float, ...]
    solved: tuple[float, ...]


def page_frames(count: int) -> dict[str, PageFrames]:
    """Drag the slider of mu_k so many frames on every scene.

    Raises
    ------
    SolverNotBuiltError
        Where the solver has not been compiled for browsers.
    FileNotFoundError, ModuleNotFoundError
        Without Chromium or playwright.
    """
    with TemporaryDirectory() as folder, _browser() as browser:
        return {
            name: _measured(browser, export.export_page(model, Path(folder) / "page.html"), count, *ends)
            for name, (model, *ends) in PAGE_SCENES.items()
        }


def _measured(browser: Any, path: Path, count: int, low: float, high: float) -> PageFrames:
    page = browser.new_page(viewport=SCREEN)
    page.goto(path.as_uri())
    page.wait_for_selector("body[data-ready]")
    frames, solved = page.evaluate(DRAG, [count, low, high])
    page.close()
    return PageFrames(path.stat().st_size, tuple(frames), tuple(solved))


@contextmanager
def _browser() -> Iterator[Any]:
    from playwright.sync_api import sync_playwright

    path = next(filter(None, map(shutil.which, CHROMIUM)), None)
    if path is None:
        raise FileNotFoundError(f"a browser draws this, and none is installed: {', '.join(CHROMIUM)}")
    with sync_playwright() as play:
        browser = play.chromium.launch(executable_path=path, args=["--no-sandbox"])
        yield browser
        browser.close()


def page_table(measured: Mapping[str, PageFrames]) -> str:
    """A line of Markdown for each scene."""
    head = "scene | page | drags | from picture to picture, median | a tenth takes more than | solver, median"
    return markdown_table(head, (f"{name} | {_page_row(one)}" for name, one in measured.items()))


def _page_row(one: PageFrames) -> str:
    slow = sorted(one.frames)[9 * len(one.frames) // 10]
    times = f"{median(one.frames):.0f} ms | {slow:.0f} ms | {median(one.solved):.1f} ms"
    return f"{one.bytes / 1e6:.2f} MB | {len(one.frames)} | {times}"
