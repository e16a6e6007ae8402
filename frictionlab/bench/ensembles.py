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
from .scenes import STIFF
from .switches import SCENE, interleaved


@dataclass(frozen=True)
class Ensemble:
    """A scene, the values of mu_k between which its runs lie, and their length in s."""

    name: str
    model: Any
    mu_k: tuple[float, float]
    t_end: float


def _of_b(name: str, *without: str) -> Ensemble:
    # Sliding only, what starts from rest goes beyond all bounds where mu_k is larger than 1.
    return Ensemble(name, SCENE.without(*without), (0.2, 1.0), 20.0)


SCENES = (
    Ensemble("C", STIFF, (2.0, 2.5), 1.0),
    _of_b("B, sliding only", "nonsmooth"),
    _of_b("B, sliding only, without the moving load", "nonsmooth", "geometry"),
    _of_b("B without the moving load", "geometry"),
    _of_b("B"),
)


@dataclass(frozen=True)
class Row:
    """Wall times in s of `runs` runs of a scene."""

    scene: str
    runs: int
    one_by_one: float
    side_by_side: float


def ensembles(runs: Sequence[int] = (8, 16, 64), repeats: int = 5, share: float = 1.0) -> list[Row]:
    """Values of mu_k, from rest; `share` of each scene's length."""
    return [_row(scene, count, share * scene.t_end, repeats) for scene in SCENES for count in runs]


def _row(scene: Ensemble, count: int, t_end: float, repeats: int) -> Row:
    models = [scene.model.replace(mu_k=float(mu_k)) for mu_k in np.linspace(*scene.mu_k, count)]
    make_ready(scene.model.automaton(), Taylor())
    make_lanes_ready(scene.model.automaton(), Taylor())
    ways = partial(_one_by_one, models, t_end), partial(ensemble, models, t_end, progress=False)
    return Row(scene.name, count, *interleaved(ways, repeats))


def _one_by_one(models: Sequence[Any], t_end: float) -> None:
    for model in models:
        simulate(model, t_end, progress=False)


def table(rows: Sequence[Row]) -> str:
    """The rows as Markdown."""
    lines = (
        f"{r.scene} | {r.runs} | {1e3 * r.one_by_one:.3g} ms "
        f"| {1e3 * r.side_by_side:.3g} ms | {r.one_by_one / r.side_by_side:.2f}"
        for r in rows
    )
    return markdown("scene | runs | one after another | side by side | ratio", lines)
