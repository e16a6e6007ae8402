"""Run time against error, on logarithmic axes: a panel for each scene, a line for each family of methods."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes

from frictionlab.plotting import RunFigure
from frictionlab.plotting.palette import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, VERMILLION, YELLOW

from .harness import Row
from .scenes import scenes

STYLES = {
    "frictionlab": (VERMILLION, "o"),
    "frictionlab, interpreted": (VERMILLION, "x"),
    "RK4": (BLACK, "s"),
    "scipy DOP853": (BLUE, "^"),
    "scipy RK45": (SKY, "v"),
    "scipy LSODA": (GREEN, "D"),
    "scipy Radau": (SKY, "d"),
    "heyoka": (ORANGE, "X"),
    "CVODE Adams": (PURPLE, "<"),
    "CVODE BDF": (YELLOW, ">"),
    "PathSim RKDP87": (BLACK, "P"),
    "diffrax Dopri8": (GREEN, "p"),
    "regularised": (GREY, "*"),
}
FLOOR = 1e-16  # errors that are zero are drawn here


def draw(rows: Sequence[Row]) -> RunFigure:
    """The picture of all scenes that the rows hold."""
    names = list(dict.fromkeys(row.scene for row in rows))
    picture = RunFigure(figsize=(11.0, 3.4 * -(-len(names) // 2) + 0.8), layout="constrained")
    panels = picture.subplots(-(-len(names) // 2), 2, squeeze=False).ravel()
    for ax, name in zip(panels, names):
        _panel(ax, name, [row for row in rows if row.scene == name and row.error is not None])
    for ax in panels[len(names) :]:
        ax.set_axis_off()
    for ax in panels[: len(names)]:
        ax.set(xlabel="wall time (s)", ylabel="largest error of a state")
    handles = {h.get_label(): h for ax in panels for h in ax.get_legend_handles_labels()[0]}
    picture.legend(handles=list(handles.values()), loc="outside lower center", ncols=5, frameon=False)
    return picture


def _panel(ax: Axes, name: str, rows: Sequence[Row]) -> None:
    for family, (colour, marker) in STYLES.items():
        here = sorted(
            (row.seconds or 0.0, max(row.error or 0.0, FLOOR)) for row in rows if row.family == family
        )
        if here:
            ax.loglog(*zip(*here, strict=True), color=colour, marker=marker, label=family, linewidth=1.0)
    ax.set_title(f"{name}: {scenes()[name].text}", fontsize=10.0)
    ax.grid(alpha=0.3)
