"""What is paid once: the first call of a process, and native code for each mode."""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from statistics import median

from frictionlab.analysis.markdown import markdown
from frictionlab.hybrid import compiled
from frictionlab.hybrid.layout import Program
from frictionlab.hybrid.natives import Natives
from frictionlab.hybrid.program import program_of

from .switches import LEFT_OUT, SCENE

FRESH = """\
import time
begin = time.perf_counter()
import frictionlab as fl
imported = time.perf_counter()
model = fl.SliderOnBelt(mu_k=1.4, impact=fl.PlasticImpact("full")).without(*{without})
fl.simulate(model, 1.0, progress=False)
print(imported - begin, time.perf_counter() - imported)
"""


@dataclass(frozen=True)
class Starts:
    """Fresh processes, warm caches: `import frictionlab`, then each scene's first simulated second, in s."""

    imported: float
    first: tuple[float, ...]


@dataclass(frozen=True)
class Native:
    """A mode's machine code: compiling it, and loading it from the cache in a later process, in s."""

    mode: str
    operations: int
    compiled: float
    loaded: float


def starts(repeats: int = 3) -> Starts:
    """The eight scenes of the switches, each in processes of its own; medians."""
    for without in LEFT_OUT:
        _fresh(without)  # warms the caches
    spent = [[_fresh(without) for without in LEFT_OUT] for _ in range(repeats)]
    imported = median(seconds for turn in spent for seconds, _ in turn)
    return Starts(imported, tuple(median(first for _, first in scene) for scene in zip(*spent, strict=True)))


def _fresh(without: tuple[str, ...]) -> tuple[float, float]:
    command = [sys.executable, "-c", FRESH.format(without=without)]
    printed = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    imported, first = map(float, printed.split())
    return imported, first


def native_code(repeats: int = 3) -> list[Native]:
    """Every mode of scene B, compiled into an empty cache and loaded from it; none without numba."""
    if compiled.NUMBA is None:
        return []
    program = program_of(SCENE.automaton())[0]
    _native(program, 0)  # LLVM itself starts here
    modes = range(len(program.modes))
    spent = [[_native(program, mode) for mode in modes] for _ in range(repeats)]
    columns = (zip(*column, strict=True) for column in zip(*spent, strict=True))
    rows = zip(program.modes, program.tapes, columns, strict=True)
    return [Native(name, len(tape.ops), *map(median, times)) for name, tape, times in rows]


def _native(program: Program, mode: int) -> tuple[float, float]:
    with _empty_cache():
        jets = Natives(program)
        begin = time.perf_counter()
        jets.compile(mode)
        done = time.perf_counter()
        Natives(program)  # finds the mode that is there
        return done - begin, time.perf_counter() - done


@contextmanager
def _empty_cache() -> Iterator[None]:
    before = compiled.FOLDER
    with tempfile.TemporaryDirectory() as folder:
        compiled.FOLDER = folder
        try:
            yield
        finally:
            compiled.FOLDER = before


def native_table(rows: Sequence[Native]) -> str:
    """The modes as Markdown."""
    lines = (f"{r.mode} | {r.operations} | {1e3 * r.compiled:.0f} ms | {1e3 * r.loaded:.1f} ms" for r in rows)
    return markdown("mode of scene B | operations | compiled | from the cache", lines)
