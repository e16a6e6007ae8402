"""How time and memory grow: with states, contacts, events, length of a run, values of an ensemble, workers.

Slopes are those of straight lines through the larger half of the points in logarithmic axes: 1 means that
time is proportional to size.  Each row of chains of blocks and of rods is measured in a process of its own,
as its memory is the largest that the process ever had: ``python -m frictionlab.bench.growth`` measures these
and prints them as Markdown.  So that pictures and other tools, which these processes do not need, take none
of their memory, they are imported where they are used.
"""

from __future__ import annotations

import json
import math
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from itertools import pairwise
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

import frictionlab as fl
from frictionlab.components.friction import FrictionLaw
from frictionlab.models import Friction, MechanicalModel, Mechanics, quadratic_form, with_signature
from frictionlab.presentation import markdown_table, three_digits
from frictionlab.validation import check_choice

if TYPE_CHECKING:
    from frictionlab.plotting import RunFigure

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
BYTES_PER_MEGABYTE = 1e6
BYTES_OF_UNIT = 1024  # of "kB" in /proc, and of `ru_maxrss` but for macOS, which counts bytes


@with_signature
@dataclass(frozen=True, init=False, repr=False)
class Chain(MechanicalModel):
    """Blocks in a row on one belt, each with a contact, a spring to the ground and one to the next block."""

    k: float = fl.parameter(1.0, unit="N/m", symbol="k", meaning="stiffness to the ground", range=(0.1, 10.0))
    kc: float = fl.parameter(1.2, unit="N/m", symbol="k_c", meaning="stiffness between", range=(0.1, 10.0))
    v: float = fl.parameter(0.2, unit="m/s", symbol="v", meaning="speed of the belt", range=(0.0, 10.0))
    friction: FrictionLaw = fl.Coulomb(mu_k=0.5, mu_s=1.0)
    roles: ClassVar[Any] = MappingProxyType({"friction": FrictionLaw})
    contacts: ClassVar[int]

    @property
    def coordinates(self) -> tuple[str, ...]:
        """The displacements x1, x2, ..."""
        return tuple(f"x{i + 1}" for i in range(self.contacts))

    def mechanics(self, q: Any, v: Any) -> Mechanics:
        """Masses of 1 kg, pressed on the belt by 1 N each."""
        x, u = ([getattr(at, name) for name in self.coordinates] for at in (q, v))
        springs = sum(self.k * one**2 for one in x)
        springs += sum(self.kc * (one - other) ** 2 for one, other in pairwise(x))
        return Mechanics(
            kinetic=sum(one**2 for one in u) / 2,
            potential=springs / 2,
            contacts=tuple(Friction(self.v - one, 1.0, self.friction) for one in u),
        )


def chain(contacts: int) -> Chain:
    """A chain of so many blocks."""
    return type("Chain", (Chain,), {"contacts": contacts})()


@with_signature
@dataclass(frozen=True, init=False, repr=False)
class Rod(MechanicalModel):
    """A rod of linear finite elements, clamped at one end; at the other it rubs on a belt along it."""

    E: float = fl.parameter(2.1e11, unit="N/m^2", symbol="E", meaning="Young's modulus", range=(1e10, 1e12))
    rho: float = fl.parameter(7850.0, unit="kg/m^3", symbol=r"\rho", meaning="density", range=(1e3, 1e4))
    c: float = fl.parameter(1e-8, unit="s", symbol="c", meaning="damping per stiffness", range=(0.0, 1e-5))
    N: float = fl.parameter(500.0, unit="N", symbol="N", meaning="normal force", range=(0.0, 1e4))
    v: float = fl.parameter(0.02, unit="m/s", symbol="v", meaning="speed of the belt", range=(0.0, 10.0))
    friction: FrictionLaw = fl.Coulomb(mu_k=0.3, mu_s=0.5)
    roles: ClassVar[Any] = MappingProxyType({"friction": FrictionLaw})
    elements: int = 10
    length: ClassVar[float] = 0.5  # m
    area: ClassVar[float] = 1e-4  # m^2

    @property
    def coordinates(self) -> tuple[str, ...]:
        """The displacements of all nodes but the clamped one."""
        return tuple(f"u{i + 1}" for i in range(self.elements))

    def mechanics(self, q: Any, v: Any) -> Mechanics:
        """The energies, from the matrices of a rod with unit mass and unit axial stiffness per length."""
        mass, stiffness = rod_matrices(self.elements, self.length / self.elements)
        x, u = ([getattr(at, name) for name in self.coordinates] for at in (q, v))
        return Mechanics(
            kinetic=self.rho * self.area * quadratic_form(mass, u) / 2,
            potential=self.E * self.area * quadratic_form(stiffness, x) / 2,
            dissipation=self.c * self.E * self.area * quadratic_form(stiffness, u) / 2,
            contacts=(Friction(self.v - u[-1], self.N, self.friction),),
        )


def rod_matrices(elements: int, h: float) -> tuple[np.ndarray, np.ndarray]:
    """Consistent mass and stiffness, (elements, elements), of elements of the length `h`."""
    mass, stiffness = np.zeros((2, elements + 1, elements + 1))
    for i in range(elements):
        mass[i : i + 2, i : i + 2] += np.array([[2.0, 1.0], [1.0, 2.0]]) * h / 6
        stiffness[i : i + 2, i : i + 2] += np.array([[1.0, -1.0], [-1.0, 1.0]]) / h
    return mass[1:, 1:], stiffness[1:, 1:]


def rod(states: int) -> Rod:
    """A rod of so many states."""
    return Rod(elements=states // 2)


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


SCENES: dict[str, Any] = {"chain": (chain, CHAIN_SECONDS), "rod": (rod, ROD_SECONDS)}


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


def measure_apart(scene: str, size: int) -> GrowthRow | str:
    """Measure one scene in a process of its own; returns a text that says what went wrong if that fails."""
    command = [sys.executable, "-m", "frictionlab.bench.growth", scene, str(size)]
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
class Growth:
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


def growths(largest: float = np.inf) -> list[Growth]:
    """All measurements of growth; of events, length and values only sizes up to `largest`."""
    return [
        _of_apart("states of a rod", "rod", STATES, lambda row: row.run / row.steps, "s a step"),
        _of_apart("contacts of a chain", "chain", CONTACTS, lambda row: row.derivation + row.run, "s"),
        _in_this_process("events", "events of a run", _limited(EVENTS, largest), _run_with_events),
        _in_this_process("length", "simulated seconds", _limited(LENGTHS, largest), _run_of_length),
        _in_this_process("values", "values of an ensemble", _limited(VALUES, largest), _sweep),
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
    known = memory if np.isfinite(memory).all() else ()
    return Growth(name, f"{name} ({unit})", tuple(there), tuple(map(seconds, there.values())), known)


def _in_this_process(
    name: str, of: str, sizes: Sequence[float], run: Callable[[Any], tuple[float, float]]
) -> Growth:
    run(sizes[0])  # to warm up
    seconds, megabytes = zip(*(run(size) for size in sizes), strict=True)
    return Growth(name, of, tuple(sizes), seconds, megabytes if any(megabytes) else ())


def _run_with_events(count: int) -> tuple[float, float]:
    """A mass that sticks and slips: two events in a period."""
    from frictionlab.bench.harness import COULOMB_PERIOD, scenes

    scene, method = scenes()["Coulomb"], fl.Taylor(max_events=10**8, max_steps=10**8)
    return _timed_run(scene, count / 2 * COULOMB_PERIOD, method)


def _run_of_length(t_end: float) -> tuple[float, float]:
    """The slider without nonlinearities."""
    from frictionlab.bench.harness import scenes

    return _timed_run(scenes()["linear"], t_end, fl.Taylor(max_steps=10**8))


def _timed_run(scene: Any, t_end: float, method: Any) -> tuple[float, float]:
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
    from frictionlab.bench.harness import FULL_GAP_RATE_SLIDER

    values = np.linspace(0.2, 1.0, RUNS_OF_WORKERS)
    begin = time.perf_counter()
    fl.sweep(FULL_GAP_RATE_SLIDER, _final_displacement, {"mu_k": values}, workers=workers, progress=False)
    return time.perf_counter() - begin, 0.0


def _final_displacement(model: Any) -> float:
    return float(fl.simulate(model, 20.0, progress=False).final_state[0])


def draw_growths(rows: Sequence[Growth]) -> RunFigure:
    """A panel for each, with its slope."""
    from frictionlab.plotting import RunFigure

    picture = RunFigure(figsize=(12.0, 7.0), layout="constrained")
    for ax, row in zip(picture.subplots(2, 3).ravel(), rows, strict=True):
        _draw(ax, row)
    return picture


def _draw(ax: Any, row: Growth) -> None:
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


def _show_decades(ax: Any, values: Sequence[float]) -> None:
    """Extend the axis of values to whole decades."""
    from matplotlib.ticker import NullFormatter

    low, high = np.log10(min(values)), np.log10(max(values))
    ax.set_ylim(10.0 ** np.floor(low), 10.0 ** np.ceil(high))
    ax.yaxis.set_minor_formatter(NullFormatter())


def growth_table(rows: Sequence[Growth]) -> str:
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
    print(contact_table([(scene, n, measure_apart(scene, n)) for scene, n in sizes]))


if __name__ == "__main__":
    main(sys.argv[1:])
