"""How explorers and exported pages follow a slider: the response time of an explorer, with the share of the
simulation; the size of pages and the time from picture to picture, in an installed Chromium.
"""

from __future__ import annotations

import shutil
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from types import MappingProxyType
from typing import Any

from frictionlab.models import MassOnBelt, Model, SliderOnBelt
from frictionlab.pages import export
from frictionlab.pages.scene import main_parameters
from frictionlab.presentation import markdown_table
from frictionlab.widgets.explorer import Explorer, explore

LATENCY_PANELS = ("mechanism", "response", "phase", "forces", "spectrum")
STEPS_PER_SLIDER = 10  # steps of each slider
PAPER_MODEL = SliderOnBelt()
LATENCY_SCENES: Mapping[str, Any] = MappingProxyType(
    {
        "the paper's defaults": PAPER_MODEL,
        "chatter under Eq. (13), mu_k = 1.4": PAPER_MODEL.replace(mu_k=1.4),
        "all nonlinearities off": PAPER_MODEL.without("cubic", "nonsmooth", "geometry"),
    }
)

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
  const slider = explorer.root.querySelector(".fl-mu_k input[type=range]"), unseen = 20;
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
class SliderStep:
    """A step of a slider: total seconds, and seconds of the simulation."""

    parameter: str
    seconds: float
    simulation: float


def latencies(
    model: Model,
    parameters: Sequence[str] | None = None,
    count: int = STEPS_PER_SLIDER,
    panels: Sequence[str] = LATENCY_PANELS,
) -> list[SliderStep]:
    """Move sliders step by step, as an arrow key does, and time each step.

    All sliders are first moved through their steps without being timed; each is reset before its turn.

    Parameters
    ----------
    model : SliderOnBelt
    parameters : sequence of str or None
        Names of sliders; None takes those shown first.
    count : int
        Steps of each.
    panels : sequence of str

    Returns
    -------
    list of SliderStep
    """
    explorer, steps = explore(model, panels), []
    for warm in (True, False):
        for name in parameters or main_parameters(model):
            moved = [
                _time_step(explorer, name, value) for value in _slider_values(explorer.controls[name], count)
            ]
            steps += [] if warm else moved
            explorer.reset()
    explorer.close()
    return steps


def _slider_values(slider: Any, count: int) -> list[float]:
    """Values of some steps of a slider: upwards, or downwards where too few are left."""
    step = (slider.max - slider.min) / 300
    sign = 1 if slider.value + count * step <= slider.max else -1
    return [slider.value + sign * step * (i + 1) for i in range(count)]


def _time_step(explorer: Explorer, name: str, value: float) -> SliderStep:
    begin = time.perf_counter()
    explorer.controls[name].value = value
    seconds = time.perf_counter() - begin
    if explorer.error is not None:
        raise explorer.error
    simulation = float(explorer.run.stats["wall_time"]) if explorer.result.has_run else 0.0
    return SliderStep(name, seconds, simulation)


def latency_table(measured: Mapping[str, Sequence[SliderStep]]) -> str:
    """A line of Markdown for each scene."""
    head = "scene | sliders | steps | median | worst | simulation, median | its share of all steps"
    return markdown_table(head, (f"{name} | {_step_row(steps)}" for name, steps in measured.items()))


def _step_row(steps: Sequence[SliderStep]) -> str:
    whole, simulation = [s.seconds for s in steps], [s.simulation for s in steps]
    times = f"{1e3 * median(whole):.0f} ms | {1e3 * max(whole):.0f} ms | {1e3 * median(simulation):.1f} ms"
    sliders = ", ".join(dict.fromkeys(step.parameter for step in steps))
    return f"{sliders} | {len(steps)} | {times} | {100 * sum(simulation) / sum(whole):.0f} %"


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
