"""How time and memory of a run grow: with states, contacts, events, its length, values of a sweep, workers.

Slopes are those of straight lines through the larger half of the points in logarithmic axes: 1 is a time in
proportion.  Rods and chains are measured in processes of their own (`many_contacts`).
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.ticker import NullFormatter

import frictionlab as fl
from frictionlab.bench.harness import COULOMB_PERIOD, FULL_GAP_RATE_SLIDER, scenes
from frictionlab.bench.many_contacts import GrowthRow, measure_apart
from frictionlab.plotting import RunFigure
from frictionlab.plotting.style import BLUE, GREY, VERMILLION
from frictionlab.presentation import markdown_table

STATES, CONTACTS = (10, 20, 50, 100, 200), (2, 4, 6, 8, 10)
EVENTS = tuple(10**n for n in range(2, 8))
LENGTHS = tuple(10.0**n for n in range(6))  # s
VALUES = tuple(10**n for n in range(6))
WORKERS = (1, 2)
RUNS_OF_WORKERS = 64
BYTES_PER_MEGABYTE = 1e6


@dataclass(frozen=True)
class Growth:
    """Seconds, and where it is known megabytes, for some sizes."""

    name: str
    of: str  # what the size is
    sizes: tuple[float, ...]
    seconds: tuple[float, ...]
    megabytes: tuple[float, ...] = ()

    def slope(self, values: Sequence[float]) -> float:
        """Slope in logarithmic axes, through the larger half of the sizes."""
        half = min(len(self.sizes) // 2, len(self.sizes) - 2)
        return float(np.polyfit(np.log(self.sizes[half:]), np.log(values[half:]), 1)[0])


def growths(largest: float = np.inf) -> list[Growth]:
    """All of them; of the sizes up to `largest`."""
    return [
        _of_apart("states of a rod", "rod", STATES, lambda row: row.run / row.steps, "s a step"),
        _of_apart("contacts of a chain", "chain", CONTACTS, lambda row: row.derivation + row.run, "s"),
        _in_this_process("events", "events of a run", _limited(EVENTS, largest), _run_with_events),
        _in_this_process("length", "simulated seconds", _limited(LENGTHS, largest), _run_of_length),
        _in_this_process("values", "values of a sweep", _limited(VALUES, largest), _sweep),
        _in_this_process("workers", "workers", WORKERS, _run_with_workers),
    ]


def _limited(sizes: Sequence[float], largest: float) -> tuple[float, ...]:
    return tuple(size for size in sizes if size <= largest)


def _of_apart(
    name: str, scene: str, sizes: Sequence[int], seconds: Callable[[GrowthRow], float], unit: str
) -> Growth:
    rows = {size: measure_apart(scene, size) for size in sizes}
    there = {size: row for size, row in rows.items() if isinstance(row, GrowthRow)}
    memory = tuple(row.memory for row in there.values())
    return Growth(name, f"{name} ({unit})", tuple(there), tuple(map(seconds, there.values())), memory)


def _in_this_process(
    name: str, of: str, sizes: Sequence[float], run: Callable[[Any], tuple[float, float]]
) -> Growth:
    run(sizes[0])  # to warm up
    seconds, megabytes = zip(*(run(size) for size in sizes), strict=True)
    return Growth(name, of, tuple(sizes), seconds, megabytes if any(megabytes) else ())


def _run_with_events(count: int) -> tuple[float, float]:
    """A mass that sticks and slips: two events in a period."""
    scene, method = scenes()["Coulomb"], fl.Taylor(max_events=10**8, max_steps=10**8)
    return _timed_run(scene, count / 2 * COULOMB_PERIOD, method)


def _run_of_length(t_end: float) -> tuple[float, float]:
    """The slider without nonlinearities."""
    return _timed_run(scenes()["linear"], t_end, fl.Taylor(max_steps=10**8))


def _timed_run(scene: Any, t_end: float, method: Any) -> tuple[float, float]:
    begin = time.perf_counter()
    run = fl.solve(scene.automaton, t_end, x0=scene.x0, method=method, progress=False)
    seconds = time.perf_counter() - begin
    stored = sum(array.nbytes for array in run.raw if isinstance(array, np.ndarray))
    return seconds, stored / BYTES_PER_MEGABYTE


def _sweep(count: int) -> tuple[float, float]:
    """Final amplitude of a mass on a belt for values of its friction."""
    models = [fl.MassOnBelt(mu_k=float(mu)) for mu in np.linspace(0.1, 0.3, count)]
    begin = time.perf_counter()
    fl.ensemble(models, 10.0, progress=False)
    return time.perf_counter() - begin, 0.0


def _run_with_workers(workers: int) -> tuple[float, float]:
    """Many runs of scene B, by `fl.sweep`."""
    values = np.linspace(0.2, 1.0, RUNS_OF_WORKERS)
    begin = time.perf_counter()
    fl.sweep(FULL_GAP_RATE_SLIDER, _final_displacement, {"mu_k": values}, workers=workers, progress=False)
    return time.perf_counter() - begin, 0.0


def _final_displacement(model: Any) -> float:
    return float(fl.simulate(model, 20.0, progress=False).final_state[0])


def draw_growths(rows: Sequence[Growth]) -> RunFigure:
    """A panel for each, with its slope."""
    picture = RunFigure(figsize=(12.0, 7.0), layout="constrained")
    for ax, row in zip(picture.subplots(2, 3).ravel(), rows, strict=True):
        _draw(ax, row)
    return picture


def _draw(ax: Any, row: Growth) -> None:
    ax.loglog(row.sizes, row.seconds, "o-", color=BLUE, label=f"time, slope {row.slope(row.seconds):.2f}")
    ax.set(xlabel=row.of, ylabel="wall time (s)")
    if row.megabytes:
        beside, text = ax.twinx(), f"memory, slope {row.slope(row.megabytes):.2f}"
        beside.loglog(row.sizes, row.megabytes, "s--", color=VERMILLION)
        beside.set_ylabel("memory (MB)", color=VERMILLION)
        ax.plot([], [], "s--", color=VERMILLION, label=text)
        _show_decades(beside, row.megabytes)
    _show_decades(ax, row.seconds)
    ax.set_xticks(row.sizes, [f"{size:g}" if size < 1e4 else f"{size:.0e}" for size in row.sizes])
    ax.xaxis.set_minor_formatter(NullFormatter())
    ax.grid(alpha=0.3, color=GREY)
    ax.legend(loc="lower left", bbox_to_anchor=(-0.05, 1.0), ncols=2, frameon=False, fontsize=8.5)


def _show_decades(ax: Any, values: Sequence[float]) -> None:
    """Whole decades on the axis of values."""
    low, high = np.log10(min(values)), np.log10(max(values))
    ax.set_ylim(10.0 ** np.floor(low), 10.0 ** np.ceil(high))
    ax.yaxis.set_minor_formatter(NullFormatter())


def growth_table(rows: Sequence[Growth]) -> str:
    """The ends of each, and its slopes, as Markdown."""
    lines = []
    for row in rows:
        memory = [f"{row.megabytes[0]:.3g} to {row.megabytes[-1]:.3g} MB"] if row.megabytes else ["-"]
        memory += [f"{row.slope(row.megabytes):.2f}" if row.megabytes else "-"]
        seconds = f"{row.seconds[0]:.2g} to {row.seconds[-1]:.2g} s | {row.slope(row.seconds):.2f}"
        lines.append(f"{row.of} | {row.sizes[0]:g} to {row.sizes[-1]:g} | {seconds} | {' | '.join(memory)}")
    return markdown_table("size | from, to | time | slope | memory | slope", lines)
