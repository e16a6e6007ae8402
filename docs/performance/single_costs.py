"""What a run costs: each nonlinearity, what is done only once, and where the time of a run goes.

The eight scenes with and without nonlinearities: size of the tape and processor time; their first call in a
fresh process; native code for each mode, compiled and loaded; the time of a process from start to end.

`TimeShares` are compared with the floor that the processor sets.  Jets, and the states at the ends of steps,
are timed by computing them once more, separately, as dense output does.  Python's share is the time of a run
that is over almost as soon as it begins.  In a scene without events the rest is the choice of step lengths
and the record.  The same time per step is assumed for these in the other scenes, where what then remains is
due to events, guards included.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache, partial
from itertools import compress, product
from pathlib import Path
from statistics import median
from types import MappingProxyType

import numpy as np

from frictionlab.analysis.simulate import simulate
from frictionlab.compilation import machine_code
from frictionlab.hybrid.codegen.native_cache import NativeCode, native_code
from frictionlab.hybrid.kernels.run_state import StepData, jet_columns
from frictionlab.hybrid.kernels.taylor_steps import sample_states
from frictionlab.hybrid.methods.taylor import Taylor
from frictionlab.hybrid.solve import solve
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.models import Model
from frictionlab.tape.functions import AFFINE, PRODUCT, QUOTIENT, RATE, SQUARE
from frictionlab.tape.packing import program_of
from frictionlab.tape.program import Program
from frictionlab.tape.tape import Tape
from reference_scenes import FULL_GAP_RATE_SLIDER, ReferenceScene, scenes
from tables import markdown_table
from timing import least_times, warm_up

ROOT = Path(__file__).parents[2]
NONLINEARITIES = ("cubic", "nonsmooth", "geometry")
COMBINATIONS = tuple(tuple(compress(NONLINEARITIES, choice)) for choice in product((0, 1), repeat=3))
MEASURED = ("C", "A", "B")  # the one without events has to come first
AT_ONCE_OVER = 1e-9  # s: length of a run that is over almost as soon as it begins
MATRIX_SIZE = 400
MATRIX_PRODUCTS = 20

FRESH_PROCESS = """\
import time
begin = time.process_time()
import frictionlab as fl
imported = time.process_time()
model = fl.SliderOnBelt(mu_k=1.4, impact=fl.PlasticImpact("full")).without(*{without})
fl.simulate(model, 1.0, progress=False)
print(imported - begin, time.process_time() - imported)
"""

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
# Statements of a process, those of its floor, and what the floor consists of.
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
class NonlinearityCost:
    """One of the eight scenes: the nonlinearities left out, its costs; operations are summed over modes."""

    without: tuple[str, ...]
    states: int
    modes: int
    guards: int
    products: int
    operations: int
    nanoseconds: float  # processor time per simulated second


def nonlinearity_costs(t_end: float = 20.0, repeats: int = 5) -> list[NonlinearityCost]:
    """The eight scenes with nonlinearities left out: size of the tape, and processor time."""
    models = [FULL_GAP_RATE_SLIDER.without(*names) for names in COMBINATIONS]
    for model in models:
        warm_up(model.automaton(), Taylor())
    runs = [partial(simulate, model, t_end, progress=False) for model in models]
    seconds = least_times(runs, repeats)
    return [_cost_of(n, m, s / t_end) for n, m, s in zip(COMBINATIONS, models, seconds, strict=True)]


def _cost_of(left_out: tuple[str, ...], model: Model, seconds: float) -> NonlinearityCost:
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
    """Times (s) in fresh processes with warm caches: the import, and each scene's first simulated second."""

    imported: float
    first: tuple[float, ...]


@dataclass(frozen=True)
class NativeCodeTime:
    """A mode's native code: times (s) of compiling it, and of loading it from the cache later."""

    mode: str
    operations: int
    compiled: float
    loaded: float


def starts(repeats: int = 3) -> StartTimes:
    """Start times of the eight scenes, each in processes of its own; medians."""
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
    """Times to compile every mode of scene B into an empty cache and to load it; empty without numba."""
    if not machine_code.HAS_MACHINE_CODE:
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
        begin = time.process_time()
        jets.compile(mode)
        done = time.process_time()
        NativeCode(program)  # loads the mode from the cache
        return done - begin, time.process_time() - done


@contextmanager
def _empty_cache() -> Iterator[None]:
    before = machine_code.CACHE_FOLDER
    with tempfile.TemporaryDirectory() as folder:
        machine_code.CACHE_FOLDER = folder
        try:
            yield
        finally:
            machine_code.CACHE_FOLDER = before


def native_table(rows: Sequence[NativeCodeTime]) -> str:
    """The modes as Markdown."""
    lines = (f"{r.mode} | {r.operations} | {1e3 * r.compiled:.0f} ms | {1e3 * r.loaded:.1f} ms" for r in rows)
    return markdown_table("mode of scene B | operations | compiled | from the cache", lines)


@dataclass(frozen=True)
class Start:
    """Times (s) from the start of a process to its end: with an empty cache folder and later, of the clone
    and of a wheel; and its floor."""

    name: str
    first: float
    later: float
    first_of_wheel: float
    later_of_wheel: float
    floor: float
    floor_name: str


def start_times(repeats: int = 5) -> list[Start]:
    """Each of `STARTS`; medians of interleaved processes."""
    with tempfile.TemporaryDirectory() as folder:
        install_wheel(folder)
        spent = [
            [_time_starts(code, floor, folder) for code, floor, _ in STARTS.values()]
            for _ in range(repeats + 1)
        ]
    del spent[0]  # the first turn leaves byte code behind, as an installation does
    rows = []
    for (name, (*_, floor_name)), turns in zip(STARTS.items(), zip(*spent, strict=True), strict=True):
        first, later, first_of_wheel, later_of_wheel, floor = map(median, zip(*turns, strict=True))
        rows.append(Start(name, first, later, first_of_wheel, later_of_wheel, floor, floor_name))
    return rows


def install_wheel(folder: str) -> None:
    """The package as a wheel carries it, with what is derived of the models, in a folder."""
    pip = [sys.executable, "-m", "pip", "--quiet"]
    environment = {**os.environ, "FRICTIONLAB_BUILD_STRUCTURES": "1"}
    with tempfile.TemporaryDirectory() as wheels:
        building = [*pip, "wheel", "--no-deps", "--wheel-dir", wheels, str(ROOT)]
        subprocess.run(building, check=True, env=environment)
        (wheel,) = Path(wheels).glob("*.whl")
        subprocess.run([*pip, "install", "--no-deps", "--target", folder, str(wheel)], check=True)


def _time_starts(code: str, floor: str, wheel: str) -> tuple[float, ...]:
    """Times of five processes: with an empty cache folder, and with what that one left in it, of the clone
    and of the wheel; and the floor."""
    spent = []
    for package in str(ROOT), wheel:
        with tempfile.TemporaryDirectory() as folder:
            spent += [_time_process(code, folder, package) for _ in range(2)]
    with tempfile.TemporaryDirectory() as folder:
        return *spent, _time_process(floor, folder, str(ROOT))


def _time_process(code: str, folder: str, package: str) -> float:
    cache = {"FRICTIONLAB_CACHE_DIR": os.path.join(folder, "cache"), "PYTHONPATH": package}
    environment = {**os.environ, **cache}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    command = [sys.executable, "-c", code]
    begin = time.perf_counter()
    subprocess.run(command, check=True, capture_output=True, env=environment, cwd=folder)
    return time.perf_counter() - begin


def start_table(rows: Sequence[Start]) -> str:
    """The starts as Markdown; later ones of a clone also as multiples of the floor."""
    lines = []
    for r in rows:
        times = r.first, r.later, r.first_of_wheel, r.later_of_wheel, r.floor
        seconds = " | ".join(f"{each:.2f} s" for each in times)
        lines.append(f"{r.name} | {seconds} | {r.later / r.floor:.2f} | {r.floor_name}")
    columns = "clone, first | clone, later | wheel, first | wheel, later | floor | x | the floor is"
    return markdown_table(f"to the end of | {columns}", lines)


@dataclass(frozen=True)
class TimeShares:
    """Times (s) in one run; `floor` is that in which the processor could do the operations of its jets."""

    scene: str
    steps: int
    events: int
    total: float
    python: float
    jets: float
    ends: float  # the states at the ends of the steps
    floor: float

    @property
    def left(self) -> float:
        """The rest: step lengths, records, guards, events."""
        return self.total - self.python - self.jets - self.ends


def time_shares(names: Sequence[str] = MEASURED, repeats: int = 25) -> list[TimeShares]:
    """Where the time of a run goes, for some scenes."""
    return [_shares(scenes()[name], repeats) for name in names]


def _shares(scene: ReferenceScene, repeats: int) -> TimeShares:
    method = Taylor()
    warm_up(scene.automaton, method)
    begin = partial(solve, scene.automaton, x0=scene.x0, method=method, progress=False)
    run = begin(scene.t_end)
    ways = [partial(begin, scene.t_end), partial(begin, AT_ONCE_OVER)]
    ways += [_sampling(run, run.samples.order, count) for count in (0, 1, 2)]
    total, python, none, once, twice = least_times(ways, repeats)
    jets, ends = (once - none) - (twice - once), twice - once
    operations = operations_of_jets(run, run.samples.order)
    counts = len(run.raw.step_modes), len(run.events)
    return TimeShares(scene.name, *counts, total, python, jets, ends, operations / operations_a_second())


def _sampling(run: Trajectory, order: int, count: int) -> Callable[[], None]:
    """A call that computes the states at `count` instants of every step."""
    raw, program = run.raw, run.problem.program
    steps = np.repeat(np.arange(len(raw.step_modes)), count)
    times, out = raw.step_times[steps].sum(axis=1), np.empty((len(steps), raw.state.size))
    stored, J = (
        StepData(raw.step_times, raw.step_modes, raw.step_states),
        np.zeros((program.slots, jet_columns(order))),
    )
    return partial(
        sample_states, native_code(program).code, run.problem.numbers, order, stored, steps, times, out, J
    )


def operations_of_jets(run: Trajectory, order: int) -> float:
    """Multiplications and additions in the jets of all steps of a run."""
    visits = np.bincount(run.raw.step_modes, minlength=len(run.problem.program.tapes))
    each = [operations_of_tape(tape, order) for tape in run.problem.program.tapes]
    return float(visits @ np.array(each, dtype=float))


def operations_of_tape(tape: Tape, order: int) -> int:
    """Multiplications and additions in the jets of one tape up to an order."""
    orders = np.arange(order + 1)
    total = tape.inputs * order  # rates divided by the order
    for kind, a, b in tape.ops:
        if kind == AFFINE:
            total += 2 * (b - a) * (order + 1)
        elif kind == SQUARE:
            total += int((orders + 2).sum())
        elif kind == RATE:
            total += order
        else:
            total += int((2 * orders + 1).sum()) * (1 if kind in (PRODUCT, QUOTIENT) else 2)
    return total


@cache
def operations_a_second() -> float:
    """Multiplications and additions that one core does in a second, in products of matrices."""
    factor = np.random.default_rng(0).normal(size=(MATRIX_SIZE, MATRIX_SIZE))
    rates = []
    for _ in range(MATRIX_PRODUCTS):
        begin = time.process_time()  # of all threads
        np.matmul(factor, factor)
        rates.append(2 * MATRIX_SIZE**3 / max(time.process_time() - begin, 1e-9))
    return median(rates)


def time_share_table(rows: Sequence[TimeShares]) -> str:
    """The shares as Markdown; the first row must be of a scene without events."""
    a_step = rows[0].left / rows[0].steps
    cells = []
    for row in rows:
        length = a_step * row.steps
        shares = [row.jets, row.ends, length, row.left - length, row.python]
        parts = " | ".join(f"{1e6 * each:.0f} us ({100 * each / row.total:.0f} %)" for each in shares)
        an_event = f"{1e6 * (row.left - length) / row.events:.2f} us" if row.events else "-"
        floor = f"{1e6 * row.floor:.0f} us | {row.jets / row.floor:.1f}"
        cells.append(f"{row.scene} | {1e6 * row.total:.0f} us | {parts} | {an_event} | {floor}")
    heads = (
        "scene | whole run | jets | states at the ends | step lengths, record | guards, events | Python "
        "| an event | floor of the jets | jets / floor"
    )
    return markdown_table(heads, cells)
