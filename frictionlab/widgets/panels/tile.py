"""One panel of the picture: axes that are drawn once, and curves that are drawn over them at every step.

The limits of the axes stay while a slider moves, as long as the data are inside them and fill them well
enough.  Only when limits or labels change are the axes drawn anew.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import NullFormatter
from matplotlib.transforms import Bbox

from frictionlab.analysis.motion_scales import ROUND_NUMBER_RTOL
from frictionlab.plotting.appearance import GREY, background, ink, legible
from frictionlab.plotting.figure import Curve, Drawing

Limits = tuple[float, float]
MIN_FILL = 0.35  # share of the axis that the data have to fill, or else the axis shrinks
LIMIT_MARGIN = 0.06
SMALLEST_RANGE = 1e-12  # in the units of the data: what is zero throughout is drawn as a line
MIN_RELATIVE_RANGE = 1e-3  # of the largest value: what varies less is drawn as the constant it is
ROUND_STEPS = (1.0, 2.0, 2.5, 5.0, 10.0)
TICK_COUNT = 5
DECADES = 5.0

FONT_SIZE, NOTE_SIZE = 9.0, 9.0
# Kept curves are dotted in their own colours; grey ones in the text's, as grey dots would hardly be seen.
FROZEN_STYLE: dict[str, Any] = {"linewidth": 1.6, "zorder": 3.2}
FROZEN_DOTS = (0, (1.0, 1.6))
LEGEND_STYLE: dict[str, Any] = {
    "loc": "lower center",
    "bbox_to_anchor": (0.5, 0.985),
    "frameon": False,
    "fontsize": 8.5,
    "columnspacing": 0.9,
    "handlelength": 1.0,
    "handletextpad": 0.4,
    "borderaxespad": 0.2,
}
SMALL_LEGEND = 6.5  # points
AXES_RECTANGLE = 0.205, 0.175, 0.615, 0.685  # left, bottom, width, height, as shares of the tile


def data_range(arrays: Iterable[Any]) -> Limits | None:
    """Smallest and largest finite number; None where there is none."""
    finite = [a[np.isfinite(a)] for a in (np.asarray(a, dtype=float).ravel() for a in arrays)]
    given = [a for a in finite if a.size]
    return (float(min(a.min() for a in given)), float(max(a.max() for a in given))) if given else None


def linear_limits(now: Limits | None, needed: Limits | None) -> Limits:
    """The present limits, if the data are inside and fill them well enough; else new round ones."""
    if needed is None:
        return now or (0.0, 1.0)
    low, high = _with_minimum_range(*needed)
    if now and now[0] <= needed[0] and needed[1] <= now[1] and high - low >= MIN_FILL * (now[1] - now[0]):
        return now
    margin = LIMIT_MARGIN * (high - low)
    step = _round_step((high - low + 2 * margin) / TICK_COUNT)
    return math.floor((low - margin) / step) * step, math.ceil((high + margin) / step) * step


def logarithmic_limits(now: Limits | None, needed: Limits | None) -> Limits:
    """Limits of a logarithmic axis: five decades below the largest value, in whole decades."""
    if needed is None or needed[1] <= 0:
        return now or (10.0**-DECADES, 1.0)
    top = math.log10(needed[1])
    if now and math.log10(now[1]) - 1.5 < top < math.log10(now[1]):
        return now
    high = math.floor(top) + 1.0
    return 10.0 ** (high - DECADES), 10.0**high


def _with_minimum_range(low: float, high: float) -> Limits:
    least = max(MIN_RELATIVE_RANGE * max(abs(low), abs(high)), SMALLEST_RANGE)
    missing = max(0.0, least - (high - low)) / 2
    return low - missing, high + missing


def _round_step(step: float) -> float:
    power = 10.0 ** math.floor(math.log10(step))
    return next(s for s in ROUND_STEPS if s * power >= step * (1 - ROUND_NUMBER_RTOL)) * power


class Tile:
    """Axes in a rectangle of a figure (left, bottom, width, height, as shares of it), with their curves.

    A curve is one artist as long as its label stays, so that a step of a slider makes no artists.  Curves are
    "animated": matplotlib leaves them out where it draws the axes.  What is then on the canvas is kept as the
    background until a label or a limit changes.  The image of the legend alone is kept too, as a change of
    limits leaves it as it is.
    """

    def __init__(self, figure: Figure, place: tuple[float, float, float, float]) -> None:
        left, bottom, width, height = AXES_RECTANGLE
        x, y, w, h = place
        self.box = Bbox.from_bounds(x, y, w, h).transformed(figure.transFigure)
        self.ax = figure.add_axes((x + left * w, y + bottom * h, width * w, height * h))
        _style_axes(self.ax)
        self.right: Axes | None = None
        self.lines: dict[str, Line2D] = {}
        self.frozen: dict[str, Line2D] = {}
        self.note = self.ax.text(
            0.985, 0.975, "", transform=self.ax.transAxes, ha="right", va="top", fontsize=NOTE_SIZE
        )
        self.note.set(
            animated=True, bbox={"facecolor": background(self.ax), "alpha": 0.8, "linewidth": 0, "pad": 1.5}
        )
        self.background: Any = None
        self.redrawn = 0  # backgrounds drawn so far
        self._blank: Any = None
        self._named: Any = None  # image of the tile with the legend alone
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
        """Draw on the canvas; the axes are drawn anew only if they have changed."""
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
        """Put the tile with nothing but its legend on the canvas."""
        self._blank = self._blank or canvas.copy_from_bbox(self.box)
        canvas.restore_region(self._named or self._blank)
        if self._named is None:
            if legend := self.ax.get_legend():
                legend.draw(renderer)
            self._named = canvas.copy_from_bbox(self.box)

    def data_coordinates(self, x: float, y: float) -> tuple[float, float] | None:
        """Data coordinates at shares of the tile's width and height; None outside the axes."""
        at = self.box.x0 + x * self.box.width, self.box.y0 + y * self.box.height
        if not self.ax.bbox.contains(*at):
            return None
        across, up = self.ax.transData.inverted().transform(at)
        return float(across), float(up)

    def keep(self, drawing: Drawing) -> None:
        """Keep the curves of a drawing, dotted."""
        for label, curve in drawing.curves.items():
            if curve.axis != "strip":
                self._dotted(label, self._line(label, curve)).set_data(curve.x, curve.y)
        self.background = None

    def forget(self) -> None:
        """Remove the curves that were kept."""
        for line in self.frozen.values():
            line.set_data([], [])
        self.background = None

    @property
    def colours(self) -> list[Any]:
        """All colours that lines are drawn in."""
        return [GREY, *(line.get_color() for line in self.lines.values())]

    def _dotted(self, label: str, line: Line2D) -> Line2D:
        if label not in self.frozen:
            ax = self.right if self.right is not None and line.axes is self.right else self.ax
            style = {"marker": line.get_marker(), "markersize": line.get_markersize()}
            dots = "none" if line.get_linestyle() == "None" else FROZEN_DOTS
            colour = ink(ax) if line.get_color() == legible(GREY, ax) else line.get_color()
            shown = {"color": colour, "markerfacecolor": "none"}
            options: dict[str, Any] = {**FROZEN_STYLE, **shown, **style, "linestyle": dots}
            self.frozen[label] = ax.plot([], [], **options)[0]
        return self.frozen[label]

    @property
    def _axes(self) -> list[Axes]:
        return [self.ax] if self.right is None else [self.ax, self.right]

    def _line(self, label: str, curve: Curve) -> Line2D:
        if label not in self.lines:
            ax = self._right() if curve.axis == "right" else self.ax
            style = {"linewidth": 1.2, **curve.style}
            if "color" in style:
                style["color"] = legible(style["color"], ax)
            if curve.axis == "strip":
                style["transform"] = ax.get_xaxis_transform()
            self.lines[label] = ax.plot([], [], label=label, animated=True, **style)[0]
        return self.lines[label]

    def _right(self) -> Axes:
        if self.right is None:
            self.right = self.ax.twinx()
            _style_axes(self.right)
            self.right.ticklabel_format(axis="y", scilimits=(-2, 4))  # the right margin is narrow
            self.right.spines[["left", "top", "bottom"]].set_visible(False)
        return self.right

    def _fit(self, drawing: Drawing) -> None:
        curves = drawing.curves.values()
        scale = logarithmic_limits if drawing.yscale == "log" else linear_limits
        x = data_range([*(c.x for c in curves), *self._kept_data(self.ax, 0)])
        self._limit("x", self.ax, drawing.xlim or linear_limits(self._limits.get("x"), x))
        for name, ax in ("left", self.ax), ("right", self.right):
            if ax is not None:
                y = data_range([*(c.y for c in curves if c.axis == name), *self._kept_data(ax, 1)])
                fixed = drawing.ylim if name == "left" else None
                self._limit(name, ax, fixed or scale(self._limits.get(name), y))

    def _kept_data(self, ax: Axes, column: int) -> list[Any]:
        return [np.asarray(k.get_data()[column]) for k in self.frozen.values() if k.axes is ax]

    def _limit(self, name: str, ax: Axes, limits: Limits) -> None:
        if limits != self._limits.get(name):
            self._limits[name], self.background = limits, None
            ax.set(**{"xlim" if name == "x" else "ylim": limits})

    def _label(self, drawing: Drawing) -> None:
        self.ax.set_xlabel(drawing.xlabel, fontsize=FONT_SIZE)
        self.ax.set_ylabel(drawing.ylabel, fontsize=FONT_SIZE)
        if self.ax.get_yscale() != drawing.yscale:
            self.ax.set_yscale(drawing.yscale)
            self.ax.yaxis.set_minor_formatter(NullFormatter())  # the usual one looks for labels in vain
            self.ax.set_ylim(self._limits["left"])
        if self.right is not None:
            self.right.set_visible(bool(drawing.right))
            self.right.set_ylabel(drawing.right, fontsize=FONT_SIZE)
        self._legend(drawing.curves)

    def _legend(self, curves: Mapping[str, Curve]) -> None:
        handles = [self.lines[label] for label in curves if not label.startswith("_")]
        legend = self.ax.get_legend()
        if legend is not None:
            legend.remove()
        if handles:
            legend = self._fitting_legend(handles)
            legend.set_animated(True)
            for handle in filter(None, legend.legend_handles):
                handle.set_animated(False)  # else matplotlib leaves it out of the background

    def _fitting_legend(self, handles: Sequence[Line2D]) -> Any:
        """A legend in as few rows as the tile's width allows, with smaller letters if these are too many."""
        renderer = self.ax.figure.canvas.get_renderer()  # pyright: ignore[reportAttributeAccessIssue]  # Agg's has one
        legend: Any = None
        for size in (LEGEND_STYLE["fontsize"], SMALL_LEGEND):
            for rows in range(1, len(handles) + 1):
                style = LEGEND_STYLE | {"fontsize": size, "ncols": -(-len(handles) // rows)}
                style["labelcolor"] = ink(self.ax)
                legend = self.ax.legend(handles=handles, **style)
                box = legend.get_window_extent(renderer)
                if box.y1 > self.box.y1:
                    break
                if box.x0 >= self.box.x0 and box.x1 <= self.box.x1:
                    return legend
        return legend


def _style_axes(ax: Axes) -> None:
    colour = ink(ax)  # not from the settings, which may have changed when the axis on the right is made
    ax.tick_params(labelsize=FONT_SIZE, color=colour, labelcolor=colour)
    ax.spines[:].set_color(colour)
    for axis in (ax.xaxis, ax.yaxis):
        axis.label.set_color(colour)
        axis.get_offset_text().set_color(colour)
    ax.locator_params(nbins=TICK_COUNT)  # few ticks: a number takes as long to draw as a curve
    ax.ticklabel_format(axis="y", scilimits=(-3, 4), useOffset=False)
    ax.yaxis.labelpad = 2.0
    ax.yaxis.get_offset_text().set_fontsize(FONT_SIZE)
