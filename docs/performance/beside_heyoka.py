"""Ours and heyoka at the same tolerance, in turns in one process: our share of the time of its faster way.

``python docs/performance/beside_heyoka.py`` prints the shares on this processor as JSON.
"""

from __future__ import annotations

import json
import math
import subprocess
import sys
from collections.abc import Sequence
from functools import partial
from statistics import median

from adapters import Heyoka
from frictionlab.hybrid.methods.base import Method
from frictionlab.hybrid.methods.taylor import Taylor
from frictionlab.hybrid.solve import solve
from processors import environment_without_avx512, vectors
from reference_scenes import ReferenceScene, scenes
from tables import markdown_table
from timing import least_times, times_in_turns, warm_up

TOLERANCES = (1e-15, 1e-9)
TURNS = 15
LEAST_TIME = 5e-3  # s of our processor time that is measured at once
Shares = dict[str, list[float]]  # of each scene, at each tolerance


def shares(turns: int = TURNS) -> Shares:
    """Our share of heyoka's time on each scene: the median over turns, beside the faster of its two ways."""
    return {name: [_share(scene, tol, turns) for tol in TOLERANCES] for name, scene in scenes().items()}


def _share(scene: ReferenceScene, tol: float, turns: int) -> float:
    warm_up(scene.automaton, Taylor(tol=tol))
    ways = Taylor(tol=tol), *(Heyoka(scene.automaton, tol, fast_math) for fast_math in (False, True))
    single = least_times([partial(_run, scene, ways[0], 1)], turns)[0]
    count = math.ceil(LEAST_TIME / single)
    ours, *theirs = times_in_turns([partial(_run, scene, way, count) for way in ways], turns)
    best = min(theirs, key=median)
    return median(own / other for own, other in zip(ours, best, strict=True))


def _run(scene: ReferenceScene, method: Method, count: int) -> None:
    """The same run so many times."""
    for _ in range(count):
        solve(scene.automaton, scene.t_end, x0=scene.x0, method=method, progress=False)


def shares_without_avx512() -> Shares | None:
    """The same by a process that does not see AVX-512; None where this processor has none."""
    if vectors() != "AVX-512":
        return None
    done = subprocess.run(
        [sys.executable, __file__], env=environment_without_avx512(), stdout=subprocess.PIPE, check=True
    )
    return json.loads(done.stdout)


def share_table(rows: Sequence[tuple[str, Shares]]) -> str:
    """A row for each processor; both tolerances in a column for each scene."""
    lines = [
        " | ".join([name, *(", ".join(f"{one:.2f}" for one in each) for each in measured.values())])
        for name, measured in rows
    ]
    return markdown_table(" | ".join(["vectors", *scenes()]), lines)


def measured_rows(turns: int) -> list[tuple[str, Shares]]:
    """The shares on this processor, and with AVX-512 hidden where it has that."""
    rows, hidden = [(vectors(), shares(turns))], shares_without_avx512()
    return rows if hidden is None else [*rows, ("AVX-512 hidden", hidden)]


if __name__ == "__main__":
    print(json.dumps(shares()))
