"""Response time of an explorer to a step of a slider, and the share of the simulation."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from statistics import median
from types import MappingProxyType
from typing import Any

from frictionlab.models import SliderOnBelt
from frictionlab.presentation import markdown_table
from frictionlab.widgets.controls.model_controls import main_parameters
from frictionlab.widgets.explorer import Explorer, explore

LATENCY_PANELS = ("response", "phase", "forces", "spectrum")
STEPS_PER_SLIDER = 10  # steps of each slider
PAPER_MODEL = SliderOnBelt()
LATENCY_SCENES: Mapping[str, Any] = MappingProxyType(
    {
        "the paper's defaults": PAPER_MODEL,
        "chatter under Eq. (13), mu_k = 1.4": PAPER_MODEL.replace(mu_k=1.4),
        "all nonlinearities off": PAPER_MODEL.without("cubic", "nonsmooth", "geometry"),
    }
)


@dataclass(frozen=True)
class SliderStep:
    """A step of a slider: total seconds, seconds of the simulation, and the number of axes redrawn."""

    parameter: str
    seconds: float
    simulation: float
    axes: int


def latencies(
    model: Any,
    parameters: Sequence[str] | None = None,
    count: int = STEPS_PER_SLIDER,
    panels: Sequence[str] = LATENCY_PANELS,
) -> list[SliderStep]:
    """Move sliders step by step, as an arrow key does, and time each step.

    Each slider is moved once before, uncounted, and is back at the model's value when its turn comes.

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
    """Values at the next steps of a slider: up, or down where it would come to its end."""
    positions = slider.positions
    here = min(range(len(positions)), key=lambda i: abs(positions[i] - slider.value))
    up = positions[here + 1 : here + 1 + count]
    return list(up if len(up) == count else positions[here - count : here][::-1])


def _time_step(explorer: Explorer, name: str, value: float) -> SliderStep:
    axes, begin = _axes_drawn(explorer), time.perf_counter()
    explorer.controls[name].value = value
    seconds = time.perf_counter() - begin
    if explorer.error is not None:
        raise explorer.error
    simulation = float(explorer.run.stats["wall_time"]) if explorer.result.has_run else 0.0
    return SliderStep(name, seconds, simulation, _axes_drawn(explorer) - axes)


def _axes_drawn(explorer: Explorer) -> int:
    return sum(tile.redrawn for tile in explorer.picture.tiles.values())


def latency_table(measured: Mapping[str, Sequence[SliderStep]]) -> str:
    """A line of Markdown for each scene."""
    head = "scene | sliders | steps | median | worst | simulation, median | its share of all steps"
    return markdown_table(head, (f"{name} | {_table_row(steps)}" for name, steps in measured.items()))


def _table_row(steps: Sequence[SliderStep]) -> str:
    whole, simulation = [s.seconds for s in steps], [s.simulation for s in steps]
    times = f"{1e3 * median(whole):.0f} ms | {1e3 * max(whole):.0f} ms | {1e3 * median(simulation):.1f} ms"
    sliders = ", ".join(dict.fromkeys(step.parameter for step in steps))
    return f"{sliders} | {len(steps)} | {times} | {100 * sum(simulation) / sum(whole):.0f} %"
