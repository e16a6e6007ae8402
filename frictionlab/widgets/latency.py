"""How long a step of a slider takes, from the new value to new PNG bytes, and its simulation's share."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median
from typing import Any

from .explorer import explore
from .result import Result

FOUR = ("response", "phase", "forces", "spectrum")


@dataclass(frozen=True)
class Latency:
    """Medians over steps of a slider, in seconds: all of a step, its simulation, and drawings of axes."""

    seconds: float
    simulation: float
    backgrounds: int
    steps: int

    @property
    def share(self) -> float:
        """Simulation as a share of the whole."""
        return self.simulation / self.seconds


def measure(
    model: Any = None,
    parameter: str = "F",
    values: Sequence[float] = tuple(range(200, 260, 2)),
    panels: Sequence[str] = FOUR,
) -> Latency:
    """Move a slider over `values` and time each step; the first one is not counted.

    Parameters
    ----------
    model : SliderOnBelt or None
    parameter : str
    values : sequence of float
    panels : sequence of str

    Returns
    -------
    Latency
    """
    explorer = explore(model, panels)
    control, tiles = explorer.controls[parameter], explorer.picture.tiles.values()
    control.value = values[0]
    drawn, spent = sum(tile.redrawn for tile in tiles), []
    for value in values[1:]:
        begin = time.perf_counter()
        control.value = value
        spent.append((time.perf_counter() - begin, _simulation(explorer.result)))
    whole, simulation = (median(column) for column in zip(*spent, strict=True))
    backgrounds = sum(tile.redrawn for tile in tiles) - drawn
    explorer.close()
    return Latency(whole, simulation, backgrounds, len(spent))


def _simulation(result: Result) -> float:
    return float(result.run.stats["wall_time"]) if result.ran else 0.0
