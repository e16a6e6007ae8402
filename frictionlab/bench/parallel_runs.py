"""Many runs: side by side in lanes against one after another, and Fig. 9's sweep by one worker and by two."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from frictionlab.analysis.ensemble import ensemble
from frictionlab.analysis.simulate import simulate
from frictionlab.analysis.sweeps.sweep import Sweep, sweep
from frictionlab.hybrid.methods.base import Method
from frictionlab.hybrid.methods.one_step import RK4
from frictionlab.hybrid.methods.taylor import Taylor
from frictionlab.presentation import markdown_table

from .harness import interleaved_medians, warm_up, warm_up_lanes
from .scenes import FULL_GAP_RATE_SLIDER, STIFF_SLIDER

MU_K = np.round(np.arange(1, 61) * 0.05, 10)
SWEEP_STARTS = ("rest", "near")
FIXED_STEP_STRIDE = 10  # the method of fixed steps runs one value in so many; its time is scaled up


@dataclass(frozen=True)
class EnsembleScene:
    """A scene, the values of mu_k between which its runs lie, and their length in s."""

    name: str
    model: Any
    mu_k: tuple[float, float]
    t_end: float


def _variant_of_b(name: str, *without: str) -> EnsembleScene:
    # Sliding only, the motion from rest grows without bounds where mu_k is above 1.
    return EnsembleScene(name, FULL_GAP_RATE_SLIDER.without(*without), (0.2, 1.0), 20.0)


ENSEMBLE_SCENES = (
    EnsembleScene("C", STIFF_SLIDER, (2.0, 2.5), 1.0),
    _variant_of_b("B, sliding only", "nonsmooth"),
    _variant_of_b("B, sliding only, without the moving load", "nonsmooth", "geometry"),
    _variant_of_b("B without the moving load", "geometry"),
    _variant_of_b("B"),
)


@dataclass(frozen=True)
class EnsembleRow:
    """Wall times in s of `runs` runs of a scene."""

    scene: str
    runs: int
    one_by_one: float
    side_by_side: float


def ensemble_times(
    runs: Sequence[int] = (8, 16, 64), repeats: int = 5, share: float = 1.0
) -> list[EnsembleRow]:
    """Values of mu_k, from rest; `share` of each scene's length."""
    return [
        _ensemble_row(scene, count, share * scene.t_end, repeats)
        for scene in ENSEMBLE_SCENES
        for count in runs
    ]


def _ensemble_row(scene: EnsembleScene, count: int, t_end: float, repeats: int) -> EnsembleRow:
    models = [scene.model.replace(mu_k=float(mu_k)) for mu_k in np.linspace(*scene.mu_k, count)]
    warm_up(scene.model.automaton(), Taylor())
    warm_up_lanes(scene.model.automaton(), Taylor())
    ways = partial(_one_by_one, models, t_end), partial(ensemble, models, t_end, progress=False)
    return EnsembleRow(scene.name, count, *interleaved_medians(ways, repeats))


def _one_by_one(models: Sequence[Any], t_end: float) -> None:
    for model in models:
        simulate(model, t_end, progress=False)


def ensemble_table(rows: Sequence[EnsembleRow]) -> str:
    """The rows as Markdown."""
    lines = (
        f"{r.scene} | {r.runs} | {1e3 * r.one_by_one:.3g} ms "
        f"| {1e3 * r.side_by_side:.3g} ms | {r.one_by_one / r.side_by_side:.2f}"
        for r in rows
    )
    return markdown_table("scene | runs | one after another | side by side | ratio", lines)


@dataclass(frozen=True)
class SweepRow:
    """A row of the table: method, wall time of the whole sweep (s), number of timed runs."""

    name: str
    seconds: float
    runs: int


def sweep_times(t_end: float = 300.0, repeats: int = 3) -> list[SweepRow]:
    """Fig. 9: 60 values of mu_k, from rest and from near the equilibrium; moving load, full gap rate."""
    some = MU_K[FIXED_STEP_STRIDE // 2 :: FIXED_STEP_STRIDE]
    ways: tuple[tuple[str, Method, Any, int], ...] = (
        ("exact, one worker", Taylor(), MU_K, 1),
        ("exact, two workers", Taylor(), MU_K, 2),
        ("fixed step 1e-4 s, one worker", RK4(step=1e-4), some, 1),
        ("exact, one worker, the same values", Taylor(), some, 1),
    )
    seconds = interleaved_medians(
        [partial(run_sweep, values, t_end, m, n) for _, m, values, n in ways], repeats
    )
    scaled = [s * len(MU_K) / len(values) for s, (_, _, values, _) in zip(seconds, ways, strict=True)]
    return [SweepRow(name, s, 2 * len(values)) for s, (name, _, values, _) in zip(scaled, ways, strict=True)]


def run_sweep(values: Any, t_end: float, method: Method, workers: int) -> Sweep:
    study = partial(_final_state, t_end=t_end, method=method)
    return sweep(
        FULL_GAP_RATE_SLIDER, study, {"mu_k": values}, x0=SWEEP_STARTS, workers=workers, progress=False
    )


def _final_state(model: Any, start: str, t_end: float, method: Method) -> list[float]:
    return simulate(model, t_end, x0=start, method=method, progress=False).final_state.tolist()


def sweep_table(rows: Sequence[SweepRow]) -> str:
    """The rows as Markdown; times also as multiples of the first."""
    lines = (f"{r.name} | {r.seconds:.3g} s | {r.seconds / rows[0].seconds:.2g} | {r.runs}" for r in rows)
    return markdown_table("Fig. 9's sweep, 120 runs | wall time | x | runs timed", lines)
