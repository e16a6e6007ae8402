"""One panel of the picture: axes that are drawn once, and curves that are drawn over them at every step."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import NullFormatter
from matplotlib.transforms import Bbox

from frictionlab.plotting.palette import GREY

from .drawing import Curve, Drawing
from .limits import TICKS, Limits, extent, linear, logarithmic

SMALL, NOTE_SIZE = 8.0, 8.0
KEPT: dict[str, Any] = {"color": GREY, "linewidth": 1.0, "alpha": 0.5, "zorder": 1.5}
LEGEND: dict[str, Any] = {
    "loc": "lower center",
    "bbox_to_anchor": (0.5, 0.985),
    "frameon": False,
    "fontsize": 7.0,
    "columnspacing": 0.9,
    "handlelength": 1.0,
    "handletextpad": 0.4,
    "borderaxespad": 0.2,
}
MARGINS = 0.185, 0.165, 0.645, 0.70  # left, bottom, width, height, as shares of the tile


class Tile:
    """Axes in a rectangle of a figure (left, bottom, width, height, as shares of it), with their curves.

    Curves of the same label stay the same artist, so that a step of a slider makes none.  They are
    "animated": matplotlib leaves them out where it draws the axes, and what is then on the canvas is kept as
    the background until a label or a limit changes; the legend, which no limit changes, is kept before that.
    """

    def __init__(self, figure: Figure, place: tuple[float, float, float, float]) -> None:
        left, bottom, width, height = MARGINS
        x, y, w, h = place
        self.box = Bbox.from_bounds(x, y, w, h).transformed(figure.transFigure)
        self.ax = figure.add_axes((x + left * w, y + bottom * h, width * w, height * h))
        _style(self.ax)
        self.right: Axes | None = None
        self.lines: dict[str, Line2D] = {}
        self.kept: dict[str, Line2D] = {}
        self.strips: set[str] = set()
        self.note = self.ax.text(
            0.985, 0.975, "", transform=self.ax.transAxes, ha="right", va="top", fontsize=NOTE_SIZE
        )
        self.note.set(animated=True, bbox={"facecolor": "white", "alpha": 0.8, "linewidth": 0, "pad": 1.5})
        self.background: Any = None
        self.redrawn = 0  # backgrounds drawn so far
        self._blank: Any = None
        self._named: Any = None  # with the legend
        self._limits: dict[str, Limits | None] = {}
        self._looks: Any = None

    def show(self, drawing: Drawing) -> None:
        """Give the curves their data, and the axes limits and labels; draws nothing yet."""
        for label, curve in drawing.curves.items():
            self._line(label, curve).set_data(curve.x, curve.y)
        for label in self.lines.keys() - drawing.curves.keys():
            self.lines[label].set_data([], [])
        self.note.set_text(drawing.note)
        self._fit(drawing)
        shown = tuple(drawing.curves)
        looks = drawing.xlabel, drawing.ylabel, drawing.right, drawing.yscale, shown
        if looks != self._looks:
            self._looks, self._named, self.background = looks, None, None
            self._label(drawing)

    def paint(self, canvas: Any) -> None:
        """Draw on the canvas, axes and all only where they have changed."""
        renderer = canvas.get_renderer()
        if self.background is None:
            self._name(canvas, renderer)
            for ax in self._axes:
                ax.draw(renderer)
            self.background = canvas.copy_from_bbox(self.box)
            self.redrawn += 1
        else:
            canvas.restore_region(self.background)
        for line in sorted(self.lines.values(), key=Line2D.get_zorder):
            line.draw(renderer)
        self.note.draw(renderer)

    def _name(self, canvas: Any, renderer: Any) -> None:
        """An empty tile with its legend."""
        self._blank = self._blank or canvas.copy_from_bbox(self.box)
        canvas.restore_region(self._named or self._blank)
        if self._named is None:
            if legend := self.ax.get_legend():
                legend.draw(renderer)
            self._named = canvas.copy_from_bbox(self.box)

    def place(self, x: float, y: float) -> tuple[float, float] | None:
        """Data coordinates at shares of the tile's width and height; None outside the axes."""
        at = self.box.x0 + x * self.box.width, self.box.y0 + y * self.box.height
        if not self.ax.bbox.contains(*at):
            return None
        across, up = self.ax.transData.inverted().transform(at)
        return float(across), float(up)

    def keep(self) -> None:
        """Leave the curves as they are now behind, in grey."""
        for label, line in self.lines.items():
            if label not in self.strips:
                self._grey(label, line).set_data(*line.get_data())
        self.background = None

    def forget(self) -> None:
        """Take the grey curves away."""
        for line in self.kept.values():
            line.set_data([], [])
        self.background = None

    @property
    def colours(self) -> list[Any]:
        """All colours that lines are drawn in."""
        return [GREY, *(line.get_color() for line in self.lines.values())]

    def _grey(self, label: str, line: Line2D) -> Line2D:
        if label not in self.kept:
            ax = self.right if self.right is not None and line.axes is self.right else self.ax
            style = {"marker": line.get_marker(), "markersize": line.get_markersize()}
            solid = "none" if line.get_linestyle() == "None" else "-"
            options: dict[str, Any] = {**KEPT, **style, "linestyle": solid}
            self.kept[label] = ax.plot([], [], **options)[0]
        return self.kept[label]

    @property
    def _axes(self) -> list[Axes]:
        return [self.ax] if self.right is None else [self.ax, self.right]

    def _line(self, label: str, curve: Curve) -> Line2D:
        if label not in self.lines:
            ax = self._right() if curve.axis == "right" else self.ax
            style = {"linewidth": 1.2, **curve.style}
            if curve.axis == "strip":
                self.strips.add(label)
                style["transform"] = ax.get_xaxis_transform()
            self.lines[label] = ax.plot([], [], label=label, animated=True, **style)[0]
        return self.lines[label]

    def _right(self) -> Axes:
        if self.right is None:
            self.right = self.ax.twinx()
            _style(self.right)
            self.right.ticklabel_format(axis="y", scilimits=(-2, 4))  # the right margin is narrow
            self.right.spines[["left", "top", "bottom"]].set_visible(False)
        return self.right

    def _fit(self, drawing: Drawing) -> None:
        curves = drawing.curves.values()
        scale = logarithmic if drawing.yscale == "log" else linear
        x = extent([*(c.x for c in curves), *self._kept_data(self.ax, 0)])
        self._limit("x", self.ax, drawing.xlim or linear(self._limits.get("x"), x))
        for name, ax in ("left", self.ax), ("right", self.right):
            if ax is not None:
                y = extent([*(c.y for c in curves if c.axis == name), *self._kept_data(ax, 1)])
                fixed = drawing.ylim if name == "left" else None
                self._limit(name, ax, fixed or scale(self._limits.get(name), y))

    def _kept_data(self, ax: Axes, column: int) -> list[Any]:
        return [np.asarray(k.get_data()[column]) for k in self.kept.values() if k.axes is ax]

    def _limit(self, name: str, ax: Axes, limits: Limits) -> None:
        if limits != self._limits.get(name):
            self._limits[name], self.background = limits, None
            ax.set(**{"xlim" if name == "x" else "ylim": limits})

    def _label(self, drawing: Drawing) -> None:
        self.ax.set_xlabel(drawing.xlabel, fontsize=SMALL)
        self.ax.set_ylabel(drawing.ylabel, fontsize=SMALL)
        if self.ax.get_yscale() != drawing.yscale:
            self.ax.set_yscale(drawing.yscale)
            self.ax.yaxis.set_minor_formatter(NullFormatter())  # looks for texts where there are none
            self.ax.set_ylim(self._limits["left"])
        if self.right is not None:
            self.right.set_visible(bool(drawing.right))
            self.right.set_ylabel(drawing.right, fontsize=SMALL)
        self._legend(drawing.curves)

    def _legend(self, curves: Mapping[str, Curve]) -> None:
        handles = [self.lines[label] for label in curves if not label.startswith("_")]
        legend = self.ax.get_legend()
        if legend is not None:
            legend.remove()
        if handles:
            legend = self.ax.legend(handles=handles, ncols=len(handles), **LEGEND)
            legend.set_animated(True)
            for handle in filter(None, legend.legend_handles):
                handle.set_animated(False)  # else matplotlib leaves it out where it draws the background


def _style(ax: Axes) -> None:
    ax.tick_params(labelsize=SMALL)
    ax.locator_params(nbins=TICKS)  # a number takes as long to draw as a curve
    ax.ticklabel_format(axis="y", scilimits=(-3, 4), useOffset=False)
    ax.yaxis.labelpad = 2.0
    ax.yaxis.get_offset_text().set_fontsize(SMALL)
