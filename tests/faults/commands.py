"""Long commands that `kills` ends; each takes the path of its file."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from typing import Any

import frictionlab as fl
from frictionlab.cli.command import main as frictionlab

SLIDER = fl.SliderOnBelt().without("geometry")
VALUES = [0.5 + 0.05 * i for i in range(16)]
SHORT: dict[str, Any] = {"transient": 10.0, "window": 5.0, "progress": False}
QUICK: dict[str, Any] = {"workers": 2, "progress": False}
TASK_TIME = 0.05  # s, of a task that only waits


def slow(model: Any) -> dict[str, float]:
    """Any function, slow enough to be cut off."""
    time.sleep(TASK_TIME)
    return {"mu_k": model.mu_k, "third": model.mu_k / 3}


def sweep(path: str) -> None:
    fl.sweep(SLIDER, slow, {"mu_k": VALUES, "F": [100.0, 150.0]}, resume=path, **QUICK)


def processes(path: str) -> None:
    with ProcessPoolExecutor(2) as pool:
        fl.sweep(SLIDER, slow, {"mu_k": VALUES}, executor=pool, resume=path, progress=False)


def bifurcation(path: str) -> None:
    fl.bifurcation(SLIDER, "mu_k", VALUES, resume=path, workers=2, **SHORT)


def bifurcation_on(path: str) -> None:
    """Each value from the end of the one before."""
    fl.bifurcation(SLIDER, "mu_k", VALUES, "continue", resume=path, workers=1, **SHORT)


def basins(path: str) -> None:
    grid = ("x1'", VALUES[:8]), ("y1'", VALUES[:4])
    fl.basins(SLIDER.replace(mu_k=1.4), *grid, workers=2, resume=path, **SHORT)


def basin_stability(path: str) -> None:
    ranges = {"x1'": (0.0, 0.5), "y1'": (0.0, 0.1)}
    fl.basin_stability(SLIDER.replace(mu_k=1.4), ranges, 24, workers=2, resume=path, **SHORT)


def ablation(path: str) -> None:
    fl.ablation(fl.SliderOnBelt(mu_k=1.4), slow, resume=path, **QUICK)


def figure(path: str) -> None:
    """A figure of the paper, its sweeps kept in a folder."""
    options = ["--quick", "--workers", "2", "--resume", path, "-o", f"{path}.png"]
    if code := frictionlab(["figure", "15", *options]):
        sys.exit(code)


def run(path: str) -> None:
    """A run of a megabyte, saved."""
    if code := frictionlab(["run", "-q", "--t-end", "10", "--save", path]):
        sys.exit(code)


COMMANDS: dict[str, Callable[[str], None]] = {
    "sweep": sweep,
    "processes": processes,
    "bifurcation": bifurcation,
    "bifurcation-on": bifurcation_on,
    "basins": basins,
    "basin-stability": basin_stability,
    "ablation": ablation,
    "run": run,
    "figure": figure,
}
