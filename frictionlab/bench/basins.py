"""Basin stability of an automaton, each run until it is on an attractor, against a regularised model.

The bistable oscillator x'' + 0.1 x' + x = -sgn(v_r) (1 + exp(-2 |v_r|))/2 with v_r = x' - v_d sticks up to 1;
regularised it has tanh(v_r/width) for the sign.  Random initial states in -2 < x < 2, 0 < x' < 2.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy as sp

from frictionlab.analysis.basins.basins import BasinStability, basin_stability
from frictionlab.analysis.steady_state.classification import MotionKind
from frictionlab.automaton import Event, HybridAutomaton, Mode, Reset
from frictionlab.hybrid.methods.taylor import Taylor
from frictionlab.presentation import markdown_table

from .harness import warm_up, warm_up_lanes
from .peers.external import compile_peer

BELT_SPEED, EQUILIBRIUM_SHARE = (
    1.5,
    0.30713,
)  # share of the initial states that go to the equilibrium, known independently
RANGES = {"x": (-2.0, 2.0), "v": (0.0, 2.0)}
WIDTHS = (1.0, 1e-1, 1e-2)
T_END = 300.0  # of every run of the smooth model
REST_DISTANCE = 0.1  # distance from the equilibrium within which a run of the smooth model counts as settled
RTOL = 1e-6


@dataclass(frozen=True)
class BasinRow:
    """A row of the table: method, wall time (s) of the timed runs, their number, the share found, wrong
    labels."""

    name: str
    seconds: float
    runs: int
    share: float
    wrong: int


def oscillator(belt: float) -> HybridAutomaton:
    """The automaton; a third state follows exp(-2 |v_r|), and is set to 1 where v_r = 0."""
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
    """The automaton for all samples, the smooth models for the first of them; one worker each."""
    warm_up(oscillator(BELT_SPEED), Taylor())
    warm_up_lanes(oscillator(BELT_SPEED), Taylor())
    exact()
    begin = time.perf_counter()
    found = exact(samples)
    seconds = time.perf_counter() - begin
    resting = np.take([a.kind == MotionKind.EQUILIBRIUM for a in found.attractors], found.labels)
    rows = [BasinRow("exact", seconds, samples, float(resting.mean()), 0)]
    return rows + [_smooth_row(width, found.points[:some], resting[:some]) for width in widths]


def exact(samples: int = 500) -> BasinStability:
    """Basin stability of the automaton."""

    def complete(z: Any) -> list[float]:
        return [z[0], z[1], float(np.exp(-2.0 * abs(z[1] - BELT_SPEED)))]

    options: dict[str, Any] = {"x0": complete, "transient": 1000.0, "workers": 1, "progress": False}
    return basin_stability(oscillator(BELT_SPEED), RANGES, samples, **options)


def _smooth_row(width: float, starts: np.ndarray, resting: np.ndarray) -> BasinRow:
    flow, at = smooth_flow(width), (1.0 + np.exp(-2.0 * BELT_SPEED)) / 2.0
    ends = [_final_state(flow, starts[0], 1.0)]  # compiles
    begin = time.perf_counter()
    ends = np.array([_final_state(flow, start, T_END) for start in starts])
    seconds = time.perf_counter() - begin
    found = np.hypot(ends[:, 0] - at, ends[:, 1]) < REST_DISTANCE
    wrong = int((found != resting).sum())
    return BasinRow(f"tanh, width {width:g}, LSODA", seconds, len(starts), float(found.mean()), wrong)


def smooth_flow(width: float) -> Callable[..., Any]:
    """Right-hand side of the smooth model, compiled where there is numba."""

    def kernel(x: float, v: float) -> tuple[float, float]:
        v_r = v - BELT_SPEED
        return v, -0.1 * v - x - np.tanh(v_r / width) * (0.5 + 0.5 * np.exp(-2.0 * np.abs(v_r)))

    compiled = compile_peer(kernel)
    return lambda t, z: compiled(z[0], z[1])


def _final_state(flow: Callable[..., Any], start: np.ndarray, t_end: float) -> np.ndarray:
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
