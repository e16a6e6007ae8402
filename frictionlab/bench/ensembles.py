"""Many runs of one structure, side by side in lanes against one after another, on one core."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from frictionlab.analysis.ensemble import ensemble
from frictionlab.analysis.markdown import markdown
from frictionlab.analysis.simulate import simulate
from frictionlab.hybrid.taylor import Taylor

from .ready import make_lanes_ready, make_ready
from .switches import SCENE, interleaved

MU_K = (0.2, 1.0)  # sliding only, what starts from rest goes beyond all bounds where it is larger
LEFT_OUT = (("nonsmooth",), ("nonsmooth", "geometry"), ("geometry",), ())


@dataclass(frozen=True)
class Row:
    """Wall times in s of `runs` runs; the scene is B without what is named."""

    without: tuple[str, ...]
    runs: int
    one_by_one: float
    side_by_side: float


def ensembles(t_end: float = 20.0, runs: Sequence[int] = (8, 16, 64), repeats: int = 5) -> list[Row]:
    """Values of mu_k from 0.2 to 1, from rest."""
    return [_row(names, count, t_end, repeats) for names in LEFT_OUT for count in runs]


def _row(without: tuple[str, ...], count: int, t_end: float, repeats: int) -> Row:
    scene = SCENE.without(*without)
    models = [scene.replace(mu_k=float(mu_k)) for mu_k in np.linspace(*MU_K, count)]
    make_ready(scene.automaton(), Taylor())
    make_lanes_ready(scene.automaton(), Taylor())
    ways = partial(_one_by_one, models, t_end), partial(ensemble, models, t_end, progress=False)
    return Row(without, count, *interleaved(ways, repeats))


def _one_by_one(models: Sequence[Any], t_end: float) -> None:
    for model in models:
        simulate(model, t_end, progress=False)


def table(rows: Sequence[Row]) -> str:
    """The rows as Markdown."""
    lines = (
        f"{', '.join(r.without) or '-'} | {r.runs} | {1e3 * r.one_by_one:.3g} ms "
        f"| {1e3 * r.side_by_side:.3g} ms | {r.one_by_one / r.side_by_side:.2f}"
        for r in rows
    )
    return markdown("scene B without | runs | one after another | side by side | ratio", lines)
