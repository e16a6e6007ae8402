"""The cost of each nonlinearity, and the costs that arise once; many eigenvalue problems against a loop.

The eight scenes with and without nonlinearities: size of the tape and wall time; their first call in a
fresh process; native code for each mode, compiled and loaded; what a process takes from its start on.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from itertools import compress, product
from statistics import median
from types import MappingProxyType
from typing import Any

import numpy as np

from frictionlab.analysis.simulate import simulate
from frictionlab.bench.harness import FULL_GAP_RATE_SLIDER, interleaved_medians, warm_up
from frictionlab.hybrid import compilation
from frictionlab.hybrid.codegen.native_cache import NativeCode
from frictionlab.hybrid.methods.taylor import Taylor
from frictionlab.hybrid.tape.packing import program_of
from frictionlab.hybrid.tape.program import Program
from frictionlab.models import SliderOnBelt
from frictionlab.presentation import markdown_table
from frictionlab.stability import eigenvalues, root_locus, stability_changes

NONLINEARITIES = ("cubic", "nonsmooth", "geometry")
COMBINATIONS = tuple(tuple(compress(NONLINEARITIES, choice)) for choice in product((0, 1), repeat=3))

FRESH_PROCESS = """\
import time
begin = time.perf_counter()
import frictionlab as fl
imported = time.perf_counter()
model = fl.SliderOnBelt(mu_k=1.4, impact=fl.PlasticImpact("full")).without(*{without})
fl.simulate(model, 1.0, progress=False)
print(imported - begin, time.perf_counter() - imported)
"""


@dataclass(frozen=True)
class NonlinearityCost:
    """One of the eight scenes: the nonlinearities left out, and its costs; operations summed over modes."""

    without: tuple[str, ...]
    states: int
    modes: int
    guards: int
    products: int
    operations: int
    nanoseconds: float  # wall time per simulated second


def nonlinearity_costs(t_end: float = 20.0, repeats: int = 5) -> list[NonlinearityCost]:
    """The eight scenes with nonlinearities left out: size of the tape, and wall time."""
    models = [FULL_GAP_RATE_SLIDER.without(*names) for names in COMBINATIONS]
    for model in models:
        warm_up(model.automaton(), Taylor())
    runs = [partial(simulate, model, t_end, progress=False) for model in models]
    seconds = interleaved_medians(runs, repeats)
    return [_cost_of(n, m, s / t_end) for n, m, s in zip(COMBINATIONS, models, seconds, strict=True)]


def _cost_of(left_out: tuple[str, ...], model: Any, seconds: float) -> NonlinearityCost:
    cost = program_of(model.automaton())[0].cost()
    products = sum(mode["product"] + mode["square"] + mode["quotient"] for mode in cost.values())
    operations = products + sum(mode["affine"] for mode in cost.values())
    guards, states = sum(mode["guards"] for mode in cost.values()), next(iter(cost.values()))["states"]
    return NonlinearityCost(left_out, states, len(cost), guards, products, operations, 1e9 * seconds)


def nonlinearity_table(rows: Sequence[NonlinearityCost], first: Sequence[float], imported: float) -> str:
    """The eight scenes as Markdown, with the time of their first call and of the import, in s."""
    head = "without | states | modes | guards | products | operations | ns per simulated second | first call"
    lines = [
        f"{', '.join(row.without) or '-'} | {row.states} | {row.modes} | {row.guards} | {row.products} "
        f"| {row.operations} | {float(f'{row.nanoseconds:.3g}'):,.0f} | {seconds:.2f} s"
        for row, seconds in zip(rows, first, strict=True)
    ]
    return markdown_table(head, [*lines, f"`import frictionlab` | | | | | | | {imported:.3f} s"])


@dataclass(frozen=True)
class StartTimes:
    """Fresh processes, warm caches: `import frictionlab`, then each scene's first simulated second, in s."""

    imported: float
    first: tuple[float, ...]


@dataclass(frozen=True)
class NativeCodeTime:
    """A mode's machine code: compiling it, and loading it from the cache in a later process, in s."""

    mode: str
    operations: int
    compiled: float
    loaded: float


def starts(repeats: int = 3) -> StartTimes:
    """The eight scenes of the switches, each in processes of its own; medians."""
    for without in COMBINATIONS:
        _time_fresh_process(without)  # warms the caches
    spent = [[_time_fresh_process(without) for without in COMBINATIONS] for _ in range(repeats)]
    imported = median(seconds for turn in spent for seconds, _ in turn)
    return StartTimes(
        imported, tuple(median(first for _, first in scene) for scene in zip(*spent, strict=True))
    )


def _time_fresh_process(without: tuple[str, ...]) -> tuple[float, float]:
    command = [sys.executable, "-c", FRESH_PROCESS.format(without=without)]
    printed = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    imported, first = map(float, printed.split())
    return imported, first


def native_code_times(repeats: int = 3) -> list[NativeCodeTime]:
    """Every mode of scene B, compiled into an empty cache and loaded from it; none without numba."""
    if not compilation.HAS_MACHINE_CODE:
        return []
    program = program_of(FULL_GAP_RATE_SLIDER.automaton())[0]
    _time_native_code(program, 0)  # LLVM itself is loaded here
    modes = range(len(program.modes))
    spent = [[_time_native_code(program, mode) for mode in modes] for _ in range(repeats)]
    columns = (zip(*column, strict=True) for column in zip(*spent, strict=True))
    rows = zip(program.modes, program.tapes, columns, strict=True)
    return [NativeCodeTime(name, len(tape.ops), *map(median, times)) for name, tape, times in rows]


def _time_native_code(program: Program, mode: int) -> tuple[float, float]:
    with _empty_cache():
        jets = NativeCode(program)
        begin = time.perf_counter()
        jets.compile(mode)
        done = time.perf_counter()
        NativeCode(program)  # finds the mode that is there
        return done - begin, time.perf_counter() - done


@contextmanager
def _empty_cache() -> Iterator[None]:
    before = compilation.CACHE_FOLDER
    with tempfile.TemporaryDirectory() as folder:
        compilation.CACHE_FOLDER = folder
        try:
            yield
        finally:
            compilation.CACHE_FOLDER = before


def native_table(rows: Sequence[NativeCodeTime]) -> str:
    """The modes as Markdown."""
    lines = (f"{r.mode} | {r.operations} | {1e3 * r.compiled:.0f} ms | {1e3 * r.loaded:.1f} ms" for r in rows)
    return markdown_table("mode of scene B | operations | compiled | from the cache", lines)


RESULT = """\
import frictionlab as fl
fl.simulate(fl.SliderOnBelt(mu_k=1.4), 20.0, progress=False).final_state
"""
PICTURE = """\
import sys
from frictionlab.cli.command import main
sys.argv[1:] = ["run", "--quiet", "-o", "picture.png"]
main()
"""
SLIDER = """\
import frictionlab as fl
fl.explore(fl.SliderOnBelt()).controls["mu_k"].value = 0.35
"""
FOUR_PANELS = """\
import numpy
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
figure = Figure((12.0, 7.0), layout="constrained")
FigureCanvasAgg(figure)
figure.subplots(2, 2)
figure.savefig("picture.png")
"""
# Statements of a process, those of its floor, and what these are.
STARTS: Mapping[str, tuple[str, str, str]] = MappingProxyType(
    {
        "`import frictionlab`": ("import frictionlab", "", "Python"),
        "the result of a run of 20 s": (RESULT, "import numpy, llvmlite.binding", "Python, numpy, LLVM"),
        "`frictionlab run -o picture.png`": (PICTURE, FOUR_PANELS, "Python, numpy, matplotlib, empty panels"),
        "an explorer, and a step of its slider": (
            SLIDER,
            "import ipywidgets" + 2 * f"\n{FOUR_PANELS}",
            "Python, ipywidgets, empty panels twice",
        ),
    }
)


@dataclass(frozen=True)
class Start:
    """From the start of a process to its end, in s: with an empty cache folder, later, and at the least."""

    name: str
    first: float
    later: float
    floor: float
    floor_name: str


def start_times(repeats: int = 5) -> list[Start]:
    """Each of `STARTS`; medians of interleaved processes."""
    spent = [[_time_starts(code, floor) for code, floor, _ in STARTS.values()] for _ in range(repeats + 1)]
    del spent[0]  # a turn that has left byte code, as an installation does
    found = []
    for (name, (*_, floor_name)), turns in zip(STARTS.items(), zip(*spent, strict=True), strict=True):
        first, later, floor = map(median, zip(*turns, strict=True))
        found.append(Start(name, first, later, floor, floor_name))
    return found


def _time_starts(code: str, floor: str) -> tuple[float, float, float]:
    """Three processes: with an empty cache folder, with what that has left, and the floor."""
    with tempfile.TemporaryDirectory() as folder:
        first, later, least = (_time_process(each, folder) for each in (code, code, floor))
        return first, later, least


def _time_process(code: str, folder: str) -> float:
    environment = {**os.environ, "FRICTIONLAB_CACHE_DIR": os.path.join(folder, "cache")}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    command = [sys.executable, "-c", code]
    begin = time.perf_counter()
    subprocess.run(command, check=True, capture_output=True, env=environment, cwd=folder)
    return time.perf_counter() - begin


def start_table(rows: Sequence[Start]) -> str:
    """The starts as Markdown; later ones also as multiples of the floor."""
    times = (f"{r.first:.2f} s | {r.later:.2f} s | {r.floor:.2f} s | {r.later / r.floor:.2f}" for r in rows)
    lines = (f"{r.name} | {text} | {r.floor_name}" for r, text in zip(rows, times, strict=True))
    return markdown_table("to the end of | first process | a later one | floor | x | the floor is", lines)


LOOP_STRIDE = 20  # the loop solves one problem in so many and is scaled up
EIGENPROBLEM_MODEL = SliderOnBelt()

# step of finite differences, as a share of the motion's range in each state


@dataclass(frozen=True)
class EigenproblemRow:
    """A row of the table: task, wall time (s), largest difference of an eigenvalue from those of the loop
    (1/s)."""

    name: str
    seconds: float
    difference: float


def eigenproblem_times(count: int = 10_000, repeats: int = 3) -> list[EigenproblemRow]:
    """Equilibrium and eigenvalues for `count` values of mu_k: tracked all at once, and in a loop."""
    values = np.linspace(0.0, 3.0, count)
    some = values[::LOOP_STRIDE]
    at_once, loop, changes = interleaved_medians(
        [
            lambda: root_locus(EIGENPROBLEM_MODEL, "mu_k", values),
            lambda: _eigenvalues_in_loop(some),
            _find_changes,
        ],
        repeats,
    )
    scale = count / len(some)
    return [
        EigenproblemRow(f"{count} values, modes tracked (root_locus)", at_once, _largest_difference(some)),
        EigenproblemRow(f"{count} values, one after another (eigenvalues)", loop * scale, 0.0),
        EigenproblemRow("every stability change from mu_k 0 to 3 (stability_changes)", changes, 0.0),
    ]


def _eigenvalues_in_loop(values: Any) -> list[Any]:
    return [eigenvalues(EIGENPROBLEM_MODEL.replace(mu_k=float(value))).values for value in values]


def _find_changes() -> Any:
    return stability_changes(EIGENPROBLEM_MODEL, "mu_k", (0.0, 3.0))


def _largest_difference(values: Any) -> float:
    tracked = np.sort_complex(root_locus(EIGENPROBLEM_MODEL, "mu_k", values).values)
    upper = np.array([np.sort_complex(one[one.imag > 0]) for one in _eigenvalues_in_loop(values)])
    return float(np.abs(tracked - upper).max())


def eigenproblem_table(rows: list[EigenproblemRow]) -> str:
    """The rows as Markdown; times also as multiples of the first."""
    lines = (
        f"{r.name} | {r.seconds:.3g} s | {r.seconds / rows[0].seconds:.2g} | {r.difference:.0e}" for r in rows
    )
    return markdown_table("eigenvalue problems | wall time | x | difference, 1/s", lines)
