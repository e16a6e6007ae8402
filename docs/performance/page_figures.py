"""Pictures of the pages: error against run time on every scene, and the three pictures of
docs/exact-and-fast.md, whose labels stand beside the data; and the data of one of these, a landing that a
fixed step misses.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Patch

from frictionlab.analysis.simulate import simulate
from frictionlab.hybrid.methods.base import Method
from frictionlab.hybrid.methods.one_step import RK4
from frictionlab.hybrid.methods.taylor import Taylor
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.models import SliderOnBelt
from frictionlab.plotting import RunFigure
from frictionlab.plotting.appearance import (
    BLACK,
    BLUE,
    DASHED,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    SKY,
    VERMILLION,
    YELLOW,
)
from reference_scenes import scenes
from single_costs import NONLINEARITIES, NonlinearityCost
from tables import markdown_table
from work_precision import WorkPrecisionRow

MISSED_EVENT_MODEL = SliderOnBelt(mu_k=1.4)  # Eq. (13) as printed: short hops after each landing
T_END = 0.14  # s
TIMES_NEAR_LANDING = np.linspace(-0.1e-3, 0.78e-3, 2001)  # s after the first landing
TIMES_OF_ERRORS = np.linspace(-10e-3, 40e-3, 1000)  # s after it; none is at the landing itself
TABLE_TIMES = (-1e-3, 1e-3, 30e-3)
REFERENCE = Taylor(order=34, chatter=1e-9)
COMPARED_METHODS: tuple[tuple[str, Method], ...] = (
    ("fixed step 0.2 ms", RK4(step=2e-4)),
    ("fixed step 0.02 ms", RK4(step=2e-5)),
    ("every event located, tol 1e-6", Taylor(tol=1e-6)),
    ("every event located, tol 1e-15", Taylor()),
)

FAMILY_STYLES = {
    "frictionlab": (VERMILLION, "o"),
    "frictionlab, interpreted": (VERMILLION, "x"),
    "RK4": (BLACK, "s"),
    "scipy DOP853": (BLUE, "^"),
    "scipy RK45": (SKY, "v"),
    "scipy LSODA": (GREEN, "D"),
    "scipy Radau": (SKY, "d"),
    "heyoka": (ORANGE, "X"),
    "heyoka, fast_math": (ORANGE, "P"),
    "CVODE Adams": (PURPLE, "<"),
    "CVODE BDF": (YELLOW, ">"),
    "PathSim RKDP87": (BLACK, "P"),
    "diffrax Dopri8": (GREEN, "p"),
    "model made smooth": (GREY, "*"),
}
ERROR_FLOOR = 1e-16  # errors that are zero are drawn here
PICTURE_SCENE = "B"
PICTURE_FAMILIES = "frictionlab", "RK4", "scipy RK45"
RK4_ORDER = 4  # of RK4
METHOD_COLOURS = dict(
    zip([name for name, _ in COMPARED_METHODS], (VERMILLION, ORANGE, BLUE, BLACK), strict=True)
)


@dataclass(frozen=True, eq=False)
class MethodResult:
    """The hops after the first landing as one method computes them; times count from the landing.

    Parameters
    ----------
    name : str
    height : array
        Height of the slider over the belt in m at the times TIMES_NEAR_LANDING.
    ends : array
        Ends of its steps within TIMES_NEAR_LANDING in s, and the heights there in m: two rows.
    error : array
        Largest error of a state at the times TIMES_OF_ERRORS.
    moments : tuple of float
        The same at TABLE_TIMES.
    landings : int
        Landings within TIMES_NEAR_LANDING, without the first.
    """

    name: str
    height: np.ndarray
    ends: np.ndarray
    error: np.ndarray
    moments: tuple[float, ...]
    landings: int


@dataclass(frozen=True, eq=False)
class MissedEvent:
    """Time (s) of the first landing, length (s) of the first hop, largest state of the motion, results."""

    landing: float
    hop: float
    size: float
    results: tuple[MethodResult, ...]


def missed_event(methods: Sequence[tuple[str, Method]] = COMPARED_METHODS) -> MissedEvent:
    """Run the methods and compare them with one of higher order."""
    exact = simulate(MISSED_EVENT_MODEL, T_END, method=REFERENCE, progress=False)
    landing, next_landing = exact.events.t[exact.events.source == "separation"][:2].tolist()
    results = tuple(_method_result(name, method, exact, landing) for name, method in methods)
    size = float(np.abs(exact(landing + TIMES_OF_ERRORS)).max())
    return MissedEvent(landing, next_landing - landing, size, results)


def _method_result(name: str, method: Method, exact: Trajectory, landing: float) -> MethodResult:
    run = simulate(MISSED_EVENT_MODEL, T_END, method=method, progress=False)

    def error(times: np.ndarray) -> np.ndarray:
        return np.abs(run(landing + times) - exact(landing + times)).max(axis=1)

    landings = run.events.t[run.events.source == "separation"]
    ends, landings = (times - landing for times in (run.raw.step_times[:, 0], landings))
    # Every method finds the first landing, earlier or later by its own error.
    later = (landings > 1e-6) & (landings < TIMES_NEAR_LANDING[-1])
    ends = ends[(ends > TIMES_NEAR_LANDING[0]) & (ends < TIMES_NEAR_LANDING[-1])]
    return MethodResult(
        name,
        -run.output("penetration", landing + TIMES_NEAR_LANDING),
        np.array([ends, -run.output("penetration", landing + ends)]),
        error(TIMES_OF_ERRORS),
        tuple(error(np.array(TABLE_TIMES)).tolist()),
        int(later.sum()),
    )


def missed_event_table(landing: MissedEvent) -> str:
    """The errors of the methods around the landing, as Markdown."""
    times = " | ".join(f"error {1e3 * abs(t):g} ms {'before' if t < 0 else 'after'}" for t in TABLE_TIMES)
    errors = [" | ".join(f"{error:.0e}" for error in course.moments) for course in landing.results]
    lines = (f"{c.name} | {error} | {c.landings}" for c, error in zip(landing.results, errors, strict=True))
    return markdown_table(f"method | {times} | landings seen in the upper panel", lines)


def draw_work_precision(rows: Sequence[WorkPrecisionRow]) -> RunFigure:
    """The picture of all scenes that the rows hold."""
    names = list(dict.fromkeys(row.scene for row in rows))
    picture = RunFigure(figsize=(11.0, 3.4 * -(-len(names) // 2) + 0.8), layout="constrained")
    panels = picture.subplots(-(-len(names) // 2), 2, squeeze=False).ravel()
    for ax, name in zip(panels, names):
        _draw_scene(ax, name, [row for row in rows if row.scene == name and row.error is not None])
    for ax in panels[len(names) :]:
        ax.set_axis_off()
    for ax in panels[: len(names)]:
        ax.set(xlabel="processor time (s)", ylabel="largest error of a state")
    handles = {h.get_label(): h for ax in panels for h in ax.get_legend_handles_labels()[0]}
    picture.legend(handles=list(handles.values()), loc="outside lower center", ncols=5, frameon=False)
    return picture


def _draw_scene(ax: Axes, name: str, rows: Sequence[WorkPrecisionRow]) -> None:
    for family, (colour, marker) in FAMILY_STYLES.items():
        here = sorted(
            (row.seconds or 0.0, max(row.error or 0.0, ERROR_FLOOR)) for row in rows if row.family == family
        )
        if here:
            ax.loglog(*zip(*here, strict=True), color=colour, marker=marker, label=family, linewidth=1.0)
    ax.set_title(f"{name}: {scenes()[name].text}", fontsize=10.0)
    ax.grid(alpha=0.3)


def cost(rows: Sequence[WorkPrecisionRow]) -> RunFigure:
    """Error against processor time on one scene, with the slope of RK4's order."""
    picture = RunFigure(figsize=(8.0, 5.2), layout="constrained")
    ax = picture.subplots()
    for family in PICTURE_FAMILIES:
        here = [
            row
            for row in rows
            if row.scene == PICTURE_SCENE and row.family == family and row.error is not None
        ]
        if here:
            _draw_family(ax, family, here)
    ax.set(
        xscale="log", yscale="log", xlabel="processor time (s)", ylabel="largest error of a state (SI units)"
    )
    ax.margins(0.2, 0.12)
    ax.grid(alpha=0.3)
    arrow = {"arrowstyle": "-|>", "color": GREY, "linewidth": 2.0}
    ax.annotate("", (0.82, 0.06), (0.94, 0.22), xycoords="axes fraction", arrowprops=arrow)
    ax.text(0.96, 0.23, "better", transform=ax.transAxes, color="#666666", ha="right", fontsize=11.0)
    return picture


def _draw_family(ax: Axes, family: str, rows: Sequence[WorkPrecisionRow]) -> None:
    colour, marker = FAMILY_STYLES[family]
    points = np.array([(row.seconds, max(row.error or 0.0, ERROR_FLOOR)) for row in rows])
    ax.plot(*points.T, color=colour, marker=marker, linewidth=1.5)
    place: dict[str, Any] = {"textcoords": "offset points", "color": colour}
    for row, point in zip(rows, points, strict=True):
        ax.annotate(
            row.method.split(", ")[-1], point, (-9, 0), ha="right", va="center", fontsize=8.5, **place
        )
    top = points[points[:, 1].argmax()]
    ax.annotate(family, top, (0, 10), ha="center", fontsize=12.0, weight="bold", **place)
    if family == "RK4":
        _draw_slope(ax, points)


def _draw_slope(ax: Axes, points: np.ndarray) -> None:
    """A line of RK4's order beside its points."""
    x, y = np.exp(np.log(points).mean(axis=0)) * np.array([2.5, 1.0])
    ends = 2.5 * points[[0, -1], 0]
    ax.plot(ends, y * (ends / x) ** -RK4_ORDER, color=GREY, linestyle=DASHED, linewidth=1.2, zorder=1.0)
    text = f"order {RK4_ORDER}: ten times the work,\na ten-thousandth of the error"
    low = ends[0] ** 0.3 * ends[1] ** 0.7  # below scipy's points
    place = low, y * (low / x) ** -RK4_ORDER
    ax.annotate(text, place, (10, 2), textcoords="offset points", color="#666666", fontsize=9.0)


def draw_missed_event(landing: MissedEvent) -> RunFigure:
    """The hops after the first landing, by a fixed step and exactly; the errors before and after."""
    picture = RunFigure(figsize=(8.0, 7.6), layout="constrained")
    above, below = picture.subplots(2, 1, height_ratios=(1.0, 1.25))
    _draw_hops(above, landing.results[0], landing.results[-1], landing.hop)
    for course in landing.results:
        below.semilogy(1e3 * TIMES_OF_ERRORS, course.error, color=METHOD_COLOURS[course.name], linewidth=1.5)
    _draw_names(below, landing)
    below.set(xlabel="time since the first landing (ms)", ylabel="largest error of a state (SI units)")
    below.set(xlim=(1e3 * TIMES_OF_ERRORS[0], 1e3 * TIMES_OF_ERRORS[-1]), ylim=(1e-17, 1e2))
    return picture


def _draw_hops(ax: Axes, fixed: MethodResult, exact: MethodResult, hop: float) -> None:
    ax.axhspan(-6.0, 0.0, color=SKY, alpha=0.25, linewidth=0.0)
    ax.plot(1e3 * TIMES_NEAR_LANDING, 1e6 * fixed.height, color=METHOD_COLOURS[fixed.name], linewidth=1.6)
    ax.plot(1e3 * TIMES_NEAR_LANDING, 1e6 * exact.height, color=BLACK, linestyle=DASHED, linewidth=1.4)
    ends, heights = fixed.ends * np.array([[1e3], [1e6]])
    ax.plot(ends, heights, "o", color=METHOD_COLOURS[fixed.name], markersize=8.0)
    look = int(np.argmax(ends > 1e3 * hop))
    arrow = {"arrowstyle": "->", "color": METHOD_COLOURS[fixed.name]}
    text = "A step ends (dot) just after the second landing:\nthe slider is on the belt, so nothing is done."
    ax.annotate(
        text, (ends[look], heights[look]), (0.22, 2.2), arrowprops=arrow, color=VERMILLION, fontsize=9.0
    )
    ax.text(0.77, 1.05, "every event located", ha="right", fontsize=9.0)
    ax.text(0.77, -0.35, "belt", color=BLUE, ha="right", va="top", fontsize=9.0)
    ax.text(0.31, -3.2, f"{fixed.name}: into the belt", color=VERMILLION, fontsize=9.0)
    ax.set(xlabel="time since the first landing (ms)", ylabel="height over the belt (µm)")
    ax.set(xlim=(1e3 * TIMES_NEAR_LANDING[0], 1e3 * TIMES_NEAR_LANDING[-1]), ylim=(-5.0, 3.4))


def _draw_names(ax: Axes, landing: MissedEvent) -> None:
    """Each line's name where it has room: the fixed steps before the landing, the others after it."""
    ax.axhline(landing.size, color=GREY, linestyle=DASHED, linewidth=1.2)
    ax.text(-9.5, 1.6 * landing.size, "size of the motion", color="#666666", fontsize=9.0)
    early, late = 1e3 * TIMES_OF_ERRORS[[0, -1]] + np.array([0.5, -0.5])
    for course in landing.results:
        style: dict[str, Any] = {"color": METHOD_COLOURS[course.name], "fontsize": 9.0}
        if course.name.startswith("fixed"):
            ax.text(early, course.error[0] / 2.5, course.name, va="top", **style)
        else:
            ax.text(late, 3.0 * course.error[-1], course.name, ha="right", va="bottom", **style)


def draw_nonlinearity_costs(rows: Sequence[NonlinearityCost]) -> RunFigure:
    """Processor time of the eight scenes, the cheapest at the bottom, and how much there is to compute."""
    picture = RunFigure(figsize=(9.5, 4.8), layout="constrained")
    ax = picture.subplots()
    ordered = sorted(rows, key=lambda row: row.nanoseconds)
    microseconds = np.array([1e-3 * row.nanoseconds for row in ordered])
    names = np.array([_switched_on_text(row) for row in ordered])
    drawn = ax.barh(names, microseconds, color=[_colour(row) for row in ordered], alpha=0.85)
    ax.bar_label(drawn, [_tape_size_text(row) for row in ordered], padding=5, fontsize=9.0)
    ax.set(xlabel="processor time per simulated second (µs)", xlim=(0.0, 2.0 * microseconds[-1]))
    ax.spines[["top", "right"]].set_visible(False)
    kinds = {"with stick, slip and lift-off": VERMILLION, "sliding only: no events": BLUE}
    handles = [Patch(color=colour, alpha=0.85, label=kind) for kind, colour in kinds.items()]
    ax.legend(handles=handles, loc="lower right", frameon=False, fontsize=9.0)
    return picture


def _switched_on_text(row: NonlinearityCost) -> str:
    return " + ".join(name for name in NONLINEARITIES if name not in row.without) or "none: a linear system"


def _colour(row: NonlinearityCost) -> str:
    return BLUE if "nonsmooth" in row.without else VERMILLION


def _tape_size_text(row: NonlinearityCost) -> str:
    return f"{row.operations} operations, {row.products} products, {row.guards} guards, {row.states} states"
