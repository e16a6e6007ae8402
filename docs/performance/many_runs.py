"""Many runs: side by side in lanes, on one core and on two, against one after another, Fig. 9's sweep by one
worker and by two, and basin stability, each run until it is on an attractor, against a regularised model.

The basins are those of the bistable oscillator x'' + 0.1 x' + x = -sgn(v_r) (1 + exp(-2 |v_r|))/2 with
v_r = x' - v_d, whose static friction is at most 1.  The regularised model has tanh(v_r/width) for the sign.
Initial states are random in -2 < x < 2, 0 < x' < 2.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from importlib.util import find_spec
from typing import Any

import numpy as np
import sympy as sp

from adapters import Heyoka
from external import compile_peer
from frictionlab.analysis.basins.basins import BasinStability, basin_stability
from frictionlab.analysis.ensemble import ensemble
from frictionlab.analysis.simulate import simulate
from frictionlab.analysis.steady_state.classification import MotionKind
from frictionlab.analysis.sweeps.sweep import Sweep, sweep
from frictionlab.automaton import Event, HybridAutomaton, Mode, Reset
from frictionlab.hybrid.methods.base import Method
from frictionlab.hybrid.methods.one_step import RK4
from frictionlab.hybrid.methods.taylor import Taylor
from frictionlab.hybrid.solve import solve
from frictionlab.models import Model, SliderOnBelt
from reference_scenes import FULL_GAP_RATE_SLIDER, STIFF_SLIDER
from tables import markdown_table
from timing import least_times, warm_up, warm_up_lanes

MU_K = np.round(np.arange(1, 61) * 0.05, 10)
SWEEP_STARTS = ("rest", "near")
HEYOKA_TOLERANCES = (1e-15, 1e-9)
FIXED_STEP_STRIDE = 10  # fixed steps and heyoka run one value in so many; their times are scaled up
BELT_SPEED = 1.5
EQUILIBRIUM_SHARE = 0.30713  # share of initial states that go to the equilibrium, known independently
RANGES = {"x": (-2.0, 2.0), "v": (0.0, 2.0)}
WIDTHS = (1.0, 1e-1, 1e-2)
T_END = 300.0  # of every run of the smooth model
REST_DISTANCE = 0.1  # distance from the equilibrium within which a run of the smooth model counts as settled
RTOL = 1e-6


@dataclass(frozen=True)
class EnsembleScene:
    """A scene: a model, the range of mu_k of its runs, and their length in s."""

    name: str
    model: SliderOnBelt
    mu_k: tuple[float, float]
    t_end: float


def _variant_of_b(name: str, *without: str) -> EnsembleScene:
    # With sliding only, the motion from rest grows without bounds where mu_k is above 1.
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
    """Times in s of `runs` runs of a scene: of the processor on one core, wall time on two."""

    scene: str
    runs: int
    one_by_one: float
    one_core: float
    two_cores: float


def ensemble_times(
    runs: Sequence[int] = (8, 16, 64), repeats: int = 5, share: float = 1.0
) -> list[EnsembleRow]:
    """Times of all scenes, for so many values of mu_k, from rest; runs have `share` of the scene's length."""
    return [
        _ensemble_row(scene, count, share * scene.t_end, repeats)
        for scene in ENSEMBLE_SCENES
        for count in runs
    ]


def _ensemble_row(scene: EnsembleScene, count: int, t_end: float, repeats: int) -> EnsembleRow:
    models = [scene.model.replace(mu_k=float(mu_k)) for mu_k in np.linspace(*scene.mu_k, count)]
    warm_up(scene.model.automaton(), Taylor())
    warm_up_lanes(scene.model.automaton(), Taylor())
    one, two = (partial(ensemble, models, t_end, workers=cores, progress=False) for cores in (1, 2))
    alone = least_times((partial(_one_by_one, models, t_end), one), repeats)
    return EnsembleRow(scene.name, count, *alone, *least_times((two,), repeats, time.perf_counter))


def _one_by_one(models: Sequence[Model], t_end: float) -> None:
    for model in models:
        simulate(model, t_end, progress=False)


def ensemble_table(rows: Sequence[EnsembleRow]) -> str:
    """The rows as Markdown."""
    lines = (
        f"{r.scene} | {r.runs} | {1e3 * r.one_by_one:.3g} ms "
        f"| {1e3 * r.one_core:.3g} ms | {r.one_by_one / r.one_core:.2f} "
        f"| {1e3 * r.two_cores:.3g} ms | {r.one_by_one / r.two_cores:.2f}"
        for r in rows
    )
    return markdown_table("scene | runs | one after another | one core | ratio | two cores | ratio", lines)


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
    seconds = least_times(
        [partial(run_sweep, values, t_end, m, n) for _, m, values, n in ways], repeats, time.perf_counter
    )
    scaled = [s * len(MU_K) / len(values) for s, (_, _, values, _) in zip(seconds, ways, strict=True)]
    rows = [SweepRow(name, s, 2 * len(values)) for s, (name, _, values, _) in zip(scaled, ways, strict=True)]
    return rows + [_heyoka_sweep(some, t_end, tol) for tol in HEYOKA_TOLERANCES if find_spec("heyoka")]


def _heyoka_sweep(values: Any, t_end: float, tol: float) -> SweepRow:
    """The sweep by heyoka, one run after another; equations are compiled for each value beforehand."""
    models = [FULL_GAP_RATE_SLIDER.replace(mu_k=float(mu_k)) for mu_k in values]
    methods = [Heyoka(model.automaton(), tol) for model in models]
    for method in methods:
        method.prepare(np.zeros(len(method.automaton.states)))
    begin = time.perf_counter()
    for model, method in zip(models, methods, strict=True):
        for start in SWEEP_STARTS:
            _final_state(model, start, t_end, method)
    seconds = (time.perf_counter() - begin) * len(MU_K) / len(values)
    return SweepRow(f"heyoka, tol {tol:.0e}, one worker", seconds, len(SWEEP_STARTS) * len(values))


def run_sweep(values: Any, t_end: float, method: Method, workers: int) -> Sweep:
    study = partial(_final_state, t_end=t_end, method=method)
    return sweep(
        FULL_GAP_RATE_SLIDER, study, {"mu_k": values}, x0=SWEEP_STARTS, workers=workers, progress=False
    )


def _final_state(model: Model, start: str, t_end: float, method: Method) -> list[float]:
    return simulate(model, t_end, x0=start, method=method, progress=False).final_state.tolist()


def sweep_table(rows: Sequence[SweepRow]) -> str:
    """The rows as Markdown; times also as multiples of the first."""
    lines = (f"{r.name} | {r.seconds:.3g} s | {r.seconds / rows[0].seconds:.2g} | {r.runs}" for r in rows)
    return markdown_table("Fig. 9's sweep, 120 runs | wall time | x | runs timed", lines)


@dataclass(frozen=True)
class BasinRow:
    """A row of the table: method, wall time (s) of the timed runs, their number, the share that came to rest,
    wrong labels."""

    name: str
    seconds: float
    runs: int
    share: float
    wrong: int


def oscillator(belt: float) -> HybridAutomaton:
    """The oscillator's automaton; its third state is exp(-2 |v_r|), which is reset to 1 where v_r = 0."""
    x, v, w, v_d = sp.symbols("x v w v_d")

    def slip(name: str, sign: int, targets: tuple[str, ...]) -> Mode:
        acceleration = -v / 10 - x - sign * (1 + w) / 2
        event = Event("v_r", sign * (v - v_d), targets, Reset({v: v_d, w: sp.S.One}))
        return Mode(name, (v, acceleration, -2 * w * sign * acceleration), (event,))

    pull = x + v_d / 10
    ends = Event("cone+", 1 - pull, ("slip-",)), Event("cone-", 1 + pull, ("slip+",))
    stick = Mode("stick", (v, sp.S.Zero, sp.S.Zero), ends, (v - v_d,))
    modes = stick, slip("slip-", -1, ("stick", "slip+")), slip("slip+", 1, ("stick", "slip-"))
    return HybridAutomaton((x, v, w), modes, {v_d: belt}, coordinates=1)


def basin_times(samples: int = 10_000, some: int = 200, widths: Sequence[float] = WIDTHS) -> list[BasinRow]:
    """Times of our solver for all samples, of others and smooth models for the first `some`; one worker."""
    warm_up(oscillator(BELT_SPEED), Taylor())
    warm_up_lanes(oscillator(BELT_SPEED), Taylor())
    exact()
    begin = time.perf_counter()
    basins = exact(samples)
    seconds = time.perf_counter() - begin
    resting = np.take([a.kind == MotionKind.EQUILIBRIUM for a in basins.attractors], basins.labels)
    rows = [BasinRow("exact", seconds, samples, float(resting.mean()), 0)]
    starts, resting = basins.points[:some], resting[:some]
    rows += [_hybrid_row(*way, starts, resting) for way in _hybrid_methods()]
    return rows + [_smooth_row(width, starts, resting) for width in widths]


def _hybrid_methods() -> list[tuple[str, Method]]:
    """Other methods for the same automaton."""
    methods: list[tuple[str, Method]] = [("RK4, step 1e-3 s", RK4(step=1e-3))]
    if find_spec("heyoka"):
        methods += [
            (f"heyoka, tol {tol:.0e}", Heyoka(oscillator(BELT_SPEED), tol)) for tol in HEYOKA_TOLERANCES
        ]
    return methods


def _hybrid_row(name: str, method: Method, starts: np.ndarray, resting: np.ndarray) -> BasinRow:
    automaton = oscillator(BELT_SPEED)
    if isinstance(method, Heyoka):
        method.prepare(np.array(_complete(starts[0])))

    def end(start: np.ndarray, t_end: float) -> np.ndarray:
        return solve(automaton, t_end, x0=_complete(start), method=method, progress=False).final_state

    end(starts[0], 1.0)  # compiles
    begin = time.perf_counter()
    ends = np.array([end(start, T_END) for start in starts])
    return _basin_row(name, time.perf_counter() - begin, ends, resting)


def exact(samples: int = 500) -> BasinStability:
    """Basin stability of the automaton."""
    options: dict[str, Any] = {"x0": _complete, "transient": 1000.0, "workers": 1, "progress": False}
    return basin_stability(oscillator(BELT_SPEED), RANGES, samples, **options)


def _complete(z: Any) -> list[float]:
    """The state of the oscillator with its third component."""
    return [z[0], z[1], float(np.exp(-2.0 * abs(z[1] - BELT_SPEED)))]


def _basin_row(name: str, seconds: float, ends: np.ndarray, resting: np.ndarray) -> BasinRow:
    """A row of the table from the final states of its runs."""
    at = (1.0 + np.exp(-2.0 * BELT_SPEED)) / 2.0
    resting_now = np.hypot(ends[:, 0] - at, ends[:, 1]) < REST_DISTANCE
    return BasinRow(name, seconds, len(ends), float(resting_now.mean()), int((resting_now != resting).sum()))


def _smooth_row(width: float, starts: np.ndarray, resting: np.ndarray) -> BasinRow:
    flow = smooth_flow(width)
    ends = [_end_of_flow(flow, starts[0], 1.0)]  # compiles
    begin = time.perf_counter()
    ends = np.array([_end_of_flow(flow, start, T_END) for start in starts])
    return _basin_row(f"tanh, width {width:g}, LSODA", time.perf_counter() - begin, ends, resting)


def smooth_flow(width: float) -> Callable[..., Any]:
    """Right-hand side of the smooth model, compiled where there is numba."""

    def kernel(x: float, v: float) -> tuple[float, float]:
        v_r = v - BELT_SPEED
        return v, -0.1 * v - x - np.tanh(v_r / width) * (0.5 + 0.5 * np.exp(-2.0 * np.abs(v_r)))

    compiled = compile_peer(kernel)
    return lambda t, z: compiled(z[0], z[1])


def _end_of_flow(flow: Callable[..., Any], start: np.ndarray, t_end: float) -> np.ndarray:
    from scipy.integrate import solve_ivp

    return solve_ivp(flow, (0.0, t_end), start, method="LSODA", rtol=RTOL, atol=RTOL * 1e-2).y[:, -1]


def basin_table(rows: Sequence[BasinRow]) -> str:
    """The rows as Markdown: initial states per second, how many times slower, and the errors."""
    rates = [row.runs / row.seconds for row in rows]
    lines = (
        f"{r.name} | {r.runs} | {rate:,.0f} | {rates[0] / rate:.3g} | {r.share:.4f} "
        f"| {np.sqrt(EQUILIBRIUM_SHARE * (1 - EQUILIBRIUM_SHARE) / r.runs):.4f} | {r.wrong}"
        for r, rate in zip(rows, rates, strict=True)
    )
    head = "way | initial states | a second | x | share at rest | sampling error | labels that differ"
    return markdown_table(head, lines)
