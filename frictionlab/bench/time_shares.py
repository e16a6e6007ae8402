"""Where the time of a run goes, next to the floor that the processor sets.

Jets and the states at the ends of steps are computed once more, apart, as dense output does; Python's share
is the time of a run that is as good as over when it begins.  What is left of a scene without events is the
choice of step lengths and the record; so much a step is taken for them in the others, whose events, guards
included, have the rest.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, partial
from statistics import median

import numpy as np

from frictionlab.bench.harness import BenchScene, interleaved_medians, scenes, warm_up
from frictionlab.hybrid.codegen.native_cache import native_code
from frictionlab.hybrid.kernels.run_state import StepData, jet_columns
from frictionlab.hybrid.kernels.taylor_steps import sample_states
from frictionlab.hybrid.methods.taylor import Taylor
from frictionlab.hybrid.solve import solve
from frictionlab.hybrid.tape.functions import AFFINE, PRODUCT, QUOTIENT, RATE, SQUARE
from frictionlab.hybrid.tape.tape import Tape
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.presentation import markdown_table

MEASURED = ("C", "A", "B")  # first the one without events
AT_ONCE_OVER = 1e-9  # s: length of a run that is as good as over when it begins
MATRIX_SIZE = 400
MATRIX_PRODUCTS = 20


@dataclass(frozen=True)
class TimeShares:
    """Seconds of one run, and those in which the processor could do the operations of its jets."""

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
        """What is neither of these: step lengths, records, guards, events."""
        return self.total - self.python - self.jets - self.ends


def time_shares(names: Sequence[str] = MEASURED, repeats: int = 25) -> list[TimeShares]:
    """The shares of some scenes."""
    return [_shares(scenes()[name], repeats) for name in names]


def _shares(scene: BenchScene, repeats: int) -> TimeShares:
    method = Taylor()
    warm_up(scene.automaton, method)
    begin = partial(solve, scene.automaton, x0=scene.x0, method=method, progress=False)
    run = begin(scene.t_end)
    ways = [partial(begin, scene.t_end), partial(begin, AT_ONCE_OVER)]
    ways += [_sampling(run, method.degree, count) for count in (0, 1, 2)]
    total, python, none, once, twice = interleaved_medians(ways, repeats)
    jets, ends = (once - none) - (twice - once), twice - once
    operations = operations_of_jets(run, method.degree)
    counts = len(run.raw.step_modes), len(run.events)
    return TimeShares(scene.name, *counts, total, python, jets, ends, operations / operations_a_second())


def _sampling(run: Trajectory, order: int, count: int) -> Callable[[], None]:
    """The states at `count` instants of every step."""
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
    """Multiplications and additions that one core does in a product of matrices."""
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
