"""Time of Fig. 9's sweep, exact against a fixed step, one worker against two: part of `frictionlab bench`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from frictionlab.analysis.markdown import markdown
from frictionlab.analysis.simulate import simulate
from frictionlab.analysis.sweep import Sweep, sweep
from frictionlab.hybrid.methods import Method
from frictionlab.hybrid.rk4 import RK4
from frictionlab.hybrid.taylor import Taylor

from .switches import SCENE, interleaved

MU_K = np.round(np.arange(1, 61) * 0.05, 10)
STARTS = ("rest", "near")
SPARSE = 10  # a fixed step runs one value in so many, and is scaled up


@dataclass(frozen=True)
class Row:
    """How, wall time of the whole sweep in s, runs that were timed."""

    name: str
    seconds: float
    runs: int


def sweeps(t_end: float = 300.0, repeats: int = 3) -> list[Row]:
    """Fig. 9: 60 values of mu_k, from rest and from near the equilibrium; moving load, full gap rate."""
    some = MU_K[SPARSE // 2 :: SPARSE]
    ways: tuple[tuple[str, Method, Any, int], ...] = (
        ("exact, one worker", Taylor(), MU_K, 1),
        ("exact, two workers", Taylor(), MU_K, 2),
        ("fixed step 1e-4 s, one worker", RK4(step=1e-4), some, 1),
        ("exact, one worker, the same values", Taylor(), some, 1),
    )
    seconds = interleaved([partial(_sweep, values, t_end, m, n) for _, m, values, n in ways], repeats)
    scaled = [s * len(MU_K) / len(values) for s, (_, _, values, _) in zip(seconds, ways, strict=True)]
    return [Row(name, s, 2 * len(values)) for s, (name, _, values, _) in zip(scaled, ways, strict=True)]


def _sweep(values: Any, t_end: float, method: Method, workers: int) -> Sweep:
    study = partial(_end, t_end=t_end, method=method)
    return sweep(study, SCENE, {"mu_k": values}, x0=STARTS, workers=workers, progress=False)


def _end(model: Any, start: str, t_end: float, method: Method) -> list[float]:
    return simulate(model, t_end, x0=start, method=method, progress=False).final_state.tolist()


def table(rows: Sequence[Row]) -> str:
    """The rows as Markdown; times also as multiples of the first."""
    lines = (f"{r.name} | {r.seconds:.3g} s | {r.seconds / rows[0].seconds:.2g} | {r.runs}" for r in rows)
    return markdown("Fig. 9's sweep, 120 runs | wall time | x | runs timed", lines)
