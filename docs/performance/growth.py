"""How time and memory grow: with states, contacts, events, length of a run, values of an ensemble, workers.

Slopes are those of straight lines through the larger half of the points in logarithmic axes: 1 means that
time is proportional to size.  Each row of chains of blocks and of rods is measured in a process of its own,
as its memory is the largest that the process ever had: ``python docs/performance/growth.py`` measures these
and prints them as Markdown.  Pictures and other tools are imported where they are used: these processes do
not need them, and would count their memory.
"""

from __future__ import annotations

import json
import math
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import frictionlab as fl
from chain_and_rod import chain, rod
from frictionlab.validation import check_choice
from tables import markdown_table, three_digits

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from frictionlab.hybrid.methods.base import Method
    from frictionlab.plotting import RunFigure
    from reference_scenes import ReferenceScene

CHAIN_CONTACTS = (2, 4, 6, 7, 8, 10, 20, 30)
ROD_STATES = (20, 50, 100, 200)
CHAIN_SECONDS = 20.0  # length of a run of a chain, in which it sticks and slips
ROD_SECONDS = 0.005  # length of a run of a rod: a dozen periods of its first mode
LONGEST = 600.0  # s: a process that takes longer is ended
STATES, CONTACTS = (10, 20, 50, 100, 200), (2, 4, 6, 8, 10)
EVENTS = tuple(10**n for n in range(2, 8))
LENGTHS = tuple(10.0**n for n in range(6))  # s
VALUES = tuple(10**n for n in range(6))
WORKERS = (1, 2)
RUNS_OF_WORKERS = 64
REPEATS, SHORT = 9, 0.5  # how often runs of less than so many seconds are measured again
BYTES_PER_MEGABYTE = 1e6
BYTES_OF_UNIT = 1024  # of "kB" in /proc, and of `ru_maxrss` but for macOS, which counts bytes
SCENES: dict[str, Any] = {"chain": (chain, CHAIN_SECONDS), "rod": (rod, ROD_SECONDS)}


@dataclass(frozen=True)
class GrowthRow:
    """Processor times (s), the largest memory (MB), and counts of the run."""

    scene: str
    size: int
    derivation: float
    run: float
    equilibrium: float
    eigenvalues: float
    memory: float
    steps: int
    events: int
    modes: int


def measure_growth(scene: str, size: int) -> GrowthRow:
    """Measure one scene in this process."""
    make, t_end = SCENES[scene]
    fl.simulate(fl.TwoBlocks(), 1.0, progress=False)  # compiles the kernels
    fl.equilibrium(fl.MassOnBelt())
    model, times = make(size), [time.process_time()]
    automaton = model.automaton()
    times.append(time.process_time())
    x0 = np.zeros(len(automaton.states))
    if scene == "chain":
        x0[:size] = np.sin(1.0 + np.arange(size))
    run = fl.simulate(model, t_end, x0=x0, progress=False)
    times.append(time.process_time())
    fl.equilibrium(model)
    times.append(time.process_time())
    fl.eigenvalues(model)
    times.append(time.process_time())
    memory = largest_memory()
    visited = len({*run.mode, *run.events.target})
    derivation, ran, rested, linearised = np.diff(times).tolist()
    events, steps = len(run.events), int(run.stats["steps"])
    return GrowthRow(scene, size, derivation, ran, rested, linearised, memory, steps, events, visited)


def largest_memory() -> float:
    """The largest memory that this process ever had, MB; nan where the system does not tell, as Windows."""
    status = Path("/proc/self/status")
    if status.exists():  # resource would also count the parent process, of which this one began as a copy
        (line,) = (line for line in status.read_text().splitlines() if line.startswith("VmHWM:"))
        return int(line.split()[1]) * BYTES_OF_UNIT / BYTES_PER_MEGABYTE
    try:
        import resource
    except ImportError:
        return math.nan
    unit = 1 if sys.platform == "darwin" else BYTES_OF_UNIT
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / BYTES_PER_MEGABYTE


def measure_in_own_process(scene: str, size: int) -> GrowthRow | str:
    """Measure one scene in a process of its own; returns a text that says what went wrong if that fails."""
    command = [sys.executable, __file__, scene, str(size)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=LONGEST, check=False)
    except subprocess.TimeoutExpired:
        return f"more than {LONGEST:g} s"
    if done.returncode:
        return (done.stderr.strip().splitlines() or [f"ended by signal {-done.returncode}"])[-1]
    return GrowthRow(**json.loads(done.stdout))


def contact_table(rows: Sequence[tuple[str, int, GrowthRow | str]]) -> str:
    """The rows as Markdown."""
    heads = "scene | size | derivation | run | equilibrium | eigenvalues | memory | steps | events | modes"
    return markdown_table(heads, (f"{scene} | {size} | {_cells(row)}" for scene, size, row in rows))


def _cells(row: GrowthRow | str) -> str:
    if isinstance(row, str):
        return row + " | " * 7
    seconds = (f"{value:.2g} s" for value in (row.derivation, row.run, row.equilibrium, row.eigenvalues))
    return " | ".join([*seconds, f"{row.memory:.0f} MB", str(row.steps), str(row.events), str(row.modes)])


@dataclass(frozen=True)
class GrowthCurve:
    """Seconds, and megabytes where they are known, for some sizes."""

    name: str
    of: str  # what the size is
    sizes: tuple[float, ...]
    seconds: tuple[float, ...]
    megabytes: tuple[float, ...] = ()

    def slope(self, values: Sequence[float]) -> float:
        """Slope in logarithmic axes, through the larger half of the sizes."""
        half = min(len(self.sizes) // 2, len(self.sizes) - 2)
        return float(np.polyfit(np.log(self.sizes[half:]), np.log(values[half:]), 1)[0])


def growth_curves(largest: float = np.inf) -> list[GrowthCurve]:
    """All measurements of growth; of events, length and values only sizes up to `largest`."""
    return [
        _in_own_process("states of a rod", "rod", STATES, lambda row: row.run / row.steps, "s a step"),
        _in_own_process("contacts of a chain", "chain", CONTACTS, lambda row: row.derivation + row.run, "s"),
        _in_this_process("events", "events of a run", _limited(EVENTS, largest), _run_with_events),
        _in_this_process("length", "simulated seconds", _limited(LENGTHS, largest), _run_of_length),
        _in_this_process("values", "values of an ensemble", _limited(VALUES, largest), _sweep),
        _in_this_process("workers", "workers", WORKERS, _run_with_workers),
    ]


def _limited(sizes: Sequence[float], largest: float) -> tuple[float, ...]:
    return tuple(size for size in sizes if size <= largest)


def _in_own_process(
    name: str, scene: str, sizes: Sequence[int], seconds: Callable[[GrowthRow], float], unit: str
) -> GrowthCurve:
    rows = {size: measure_in_own_process(scene, size) for size in sizes}
    there = {size: row for size, row in rows.items() if isinstance(row, GrowthRow)}
    memory = tuple(row.memory for row in there.values())
    known = memory if np.isfinite(memory).all() else ()
    return GrowthCurve(name, f"{name} ({unit})", tuple(there), tuple(map(seconds, there.values())), known)


def _in_this_process(
    name: str, of: str, sizes: Sequence[float], run: Callable[[Any], tuple[float, float]]
) -> GrowthCurve:
    seconds, megabytes = zip(*(_quickest(run, size) for size in sizes), strict=True)
    return GrowthCurve(name, of, tuple(sizes), seconds, megabytes if any(megabytes) else ())


def _quickest(run: Callable[[Any], tuple[float, float]], size: float) -> tuple[float, float]:
    """The quickest of several short runs, as the first ones warm up; a long run is measured once."""
    seconds, megabytes = run(size)
    for _ in range(REPEATS if seconds < SHORT else 0):
        seconds = min(seconds, run(size)[0])
    return seconds, megabytes


def _run_with_events(count: int) -> tuple[float, float]:
    """A mass that sticks and slips: two events in a period."""
    from reference_scenes import COULOMB_PERIOD, scenes

    scene, method = scenes()["Coulomb"], fl.Taylor(max_events=10**8, max_steps=10**8)
    return _timed_run(scene, count / 2 * COULOMB_PERIOD, method)


def _run_of_length(t_end: float) -> tuple[float, float]:
    """The slider without nonlinearities."""
    from reference_scenes import scenes

    return _timed_run(scenes()["linear"], t_end, fl.Taylor(max_steps=10**8))


def _timed_run(scene: ReferenceScene, t_end: float, method: Method) -> tuple[float, float]:
    begin = time.perf_counter()
    run = fl.solve(scene.automaton, t_end, x0=scene.x0, method=method, progress=False)
    seconds = time.perf_counter() - begin
    stored = sum(array.nbytes for array in run.raw if isinstance(array, np.ndarray))
    return seconds, stored / BYTES_PER_MEGABYTE


def _sweep(count: int) -> tuple[float, float]:
    """Runs of 10 s of a mass on a belt, for so many values of its friction."""
    models = [fl.MassOnBelt(mu_k=float(mu)) for mu in np.linspace(0.1, 0.3, count)]
    begin = time.perf_counter()
    fl.ensemble(models, 10.0, progress=False)
    return time.perf_counter() - begin, 0.0


def _run_with_workers(workers: int) -> tuple[float, float]:
    """Many runs of scene B, by `fl.sweep`."""
    from reference_scenes import FULL_GAP_RATE_SLIDER

    values = np.linspace(0.2, 1.0, RUNS_OF_WORKERS)
    begin = time.perf_counter()
    fl.sweep(FULL_GAP_RATE_SLIDER, _final_displacement, {"mu_k": values}, workers=workers, progress=False)
    return time.perf_counter() - begin, 0.0


def _final_displacement(model: fl.Model) -> float:
    return float(fl.simulate(model, 20.0, progress=False).final_state[0])


def draw_growth_curves(rows: Sequence[GrowthCurve]) -> RunFigure:
    """A panel for each, with its slope."""
    from frictionlab.plotting import RunFigure

    picture = RunFigure(figsize=(12.0, 7.0), layout="constrained")
    for ax, row in zip(picture.subplots(2, 3).ravel(), rows, strict=True):
        _draw(ax, row)
    return picture


def _draw(ax: Axes, row: GrowthCurve) -> None:
    from matplotlib.ticker import NullFormatter

    from frictionlab.plotting.appearance import BLUE, GREY, VERMILLION

    ax.loglog(row.sizes, row.seconds, "o-", color=BLUE, label=f"time, slope {row.slope(row.seconds):.2f}")
    ax.set(xlabel=row.of, ylabel="wall time (s)")
    if row.megabytes:
        beside, text = ax.twinx(), f"memory, slope {row.slope(row.megabytes):.2f}"
        beside.loglog(row.sizes, row.megabytes, "s--", color=VERMILLION)
        beside.set_ylabel("memory (MB)", color=VERMILLION)
        ax.plot([], [], "s--", color=VERMILLION, label=text)
        _show_decades(beside, row.megabytes)
    _show_decades(ax, row.seconds)
    ax.set_xticks(
        row.sizes, [f"{size:g}" if size < 1e4 else f"$10^{{{np.log10(size):g}}}$" for size in row.sizes]
    )
    ax.xaxis.set_minor_formatter(NullFormatter())
    ax.grid(alpha=0.3, color=GREY)
    ax.legend(loc="lower left", bbox_to_anchor=(-0.05, 1.0), ncols=2, frameon=False, fontsize=8.5)


def _show_decades(ax: Axes, values: Sequence[float]) -> None:
    """Extend the axis of values to whole decades."""
    from matplotlib.ticker import NullFormatter

    low, high = np.log10(min(values)), np.log10(max(values))
    ax.set_ylim(10.0 ** np.floor(low), 10.0 ** np.ceil(high))
    ax.yaxis.set_minor_formatter(NullFormatter())


def growth_table(rows: Sequence[GrowthCurve]) -> str:
    """First and last value of each, and its slopes, as Markdown."""
    lines = []
    for row in rows:
        memory = "- | -"
        if row.megabytes:
            first, last = three_digits(row.megabytes[0]), three_digits(row.megabytes[-1])
            memory = f"{first} to {last} MB | {row.slope(row.megabytes):.2f}"
        seconds = f"{row.seconds[0]:.2g} to {row.seconds[-1]:.2g} s | {row.slope(row.seconds):.2f}"
        lines.append(f"{row.of} | {row.sizes[0]:.0f} to {row.sizes[-1]:.0f} | {seconds} | {memory}")
    return markdown_table("size | from, to | time | slope | memory | slope", lines)


def main(arguments: Sequence[str]) -> None:
    """Print one row as JSON, or all as Markdown."""
    if arguments:
        check_choice("scene", arguments[0], tuple(SCENES))
        print(json.dumps(asdict(measure_growth(arguments[0], int(arguments[1])))))
        return
    sizes = [*(("chain", n) for n in CHAIN_CONTACTS), *(("rod", n) for n in ROD_STATES)]
    print(contact_table([(scene, n, measure_in_own_process(scene, n)) for scene, n in sizes]))


if __name__ == "__main__":
    main(sys.argv[1:])
