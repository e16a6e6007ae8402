"""Figures without pyplot, which show themselves in a notebook, with legends where they cover no data; and the
content of a panel as data.

A plotting function that is given no axes draws into a new `RunFigure`.  `AnimatedFigure` keeps the image of
the parts that do not move, for animations of many frames.  A panel of an explorer is a function that takes a
result and returns a `Drawing`.  It makes no artists, so that it does not depend on how a picture is updated,
and the same curves can be checked in a test or kept for comparison::

    def penetration(result):
        t = result.times()
        u = result.run.output("penetration", t)
        return Drawing("time (s)", "penetration (m)", {"penetration": Curve(t, u)})

    fl.explore(panels=("response", penetration))
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from io import BytesIO
from os import PathLike
from pathlib import Path
from textwrap import fill
from typing import Any, Literal, NamedTuple, TypeVar

import matplotlib
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure, FigureBase
from matplotlib.font_manager import FontProperties
from matplotlib.image import imsave
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from frictionlab.file_writing import write_file
from frictionlab.plotting.appearance import PANEL_SIZE, crowding, figure_size, font_size, in_print
from frictionlab.validation import (
    abbreviate,
    check_choice,
    check_limits,
    check_mapping,
    check_number,
    check_pair,
    check_path,
    check_text,
    did_you_mean,
)

Array = NDArray[np.float64]
A = TypeVar("A", bound=Artist)
POINTS_PER_INCH = 72.0
BESIDE = 1.0, 0.5  # where the middle of the left side of a legend is, in widths and heights of its panel
MOST_LISTED = 12  # entries of a legend beside a panel
LETTER_WIDTH, HANDLE_WIDTH = 0.5, 4.8  # of an entry of a legend, in sizes of its letters


class Curve(NamedTuple):
    """A line of a panel.

    Parameters
    ----------
    x, y : array_like (N,)
        NaN breaks the line.
    style : mapping
        Keywords of matplotlib's Line2D; a curve keeps those with which it is first drawn.
    axis : "left", "right" or "strip"
        The axis of y; on "strip" 0 is the bottom of the panel and 1 its top.
    """

    x: Any
    y: Any
    style: Mapping[str, Any] = {}
    axis: Literal["left", "right", "strip"] = "left"


@dataclass(frozen=True)
class Drawing:
    """A panel's content.

    Parameters
    ----------
    xlabel, ylabel : str
        With units.
    curves : mapping of str to Curve
        By the label in the legend; one that begins with an underscore is not listed there.
    right : str
        Label of the axis on the right, for the curves that belong to it.
    yscale : "linear" or "log"
    note : str
        A few words in the corner, without mathematics; they may change with every step of a slider.
    xlim, ylim : (float, float) or None
        None follows the curves.
    progress : (int, int) or None
        Parts done and their total, where the panel is to be called again until all are done.
    """

    xlabel: str
    ylabel: str
    curves: Mapping[str, Curve] = field(default_factory=dict)
    right: str = ""
    yscale: Literal["linear", "log"] = "linear"
    note: str = ""
    xlim: tuple[float, float] | None = None
    ylim: tuple[float, float] | None = None
    progress: tuple[int, int] | None = None

    def __post_init__(self) -> None:
        for name in ("xlabel", "ylabel", "right", "note"):
            check_text(name, getattr(self, name), "write what the panel shows")
        check_choice("yscale", self.yscale, ("linear", "log"))
        check_mapping("curves", self.curves, "give each curve its label, such as {'x1': fl.Curve(t, x)}")
        for label, curve in self.curves.items():
            _check_curve(label, curve)
        for name in ("xlim", "ylim"):
            if (limits := getattr(self, name)) is not None:
                check_limits(name, limits, "give (low, high), or leave it out to follow the curves")
        if self.progress is not None:
            done, total = check_pair("progress", self.progress, "parts done and their total", "give (3, 10)")
            check_number("progress[0]", done, integer=True, least=0)
            check_number("progress[1]", total, integer=True, least=0)


def _shape(values: Any) -> tuple[int, ...]:
    try:
        return np.shape(values)
    except ValueError:  # of rows of different lengths
        return (len(values), 0)


def _check_curve(label: str, curve: Any) -> None:
    which, cure = f"curves[{abbreviate(label)}]", "write fl.Curve(x, y)"
    if not isinstance(curve, Curve):
        raise TypeError(f"{which} must be a Curve, got {abbreviate(curve)}: {cure}")
    shapes = _shape(curve.x), _shape(curve.y)
    if len(shapes[0]) != 1 or shapes[0] != shapes[1]:
        raise ValueError(
            f"{which} must have as many x as y, got the shapes {shapes[0]} and {shapes[1]}: {cure}"
        )
    check_choice(f"the axis of {which}", curve.axis, ("left", "right", "strip"))
    check_mapping(
        f"the style of {which}",
        curve.style,
        "give keywords of Line2D, as {'color': 'red'}",
    )


class RunFigure(Figure):
    """A matplotlib figure that a notebook displays whether or not pyplot was imported there."""

    def add_subplot(self, *args: Any, **options: Any) -> Any:
        """Axes as :meth:`matplotlib.figure.Figure.add_subplot` makes them, of the class `RunAxes`."""
        if options.keys().isdisjoint(("axes_class", "projection", "polar")):
            options["axes_class"] = RunAxes
        return super().add_subplot(*args, **options)

    def savefig(self, fname: Any, **options: Any) -> None:
        """Write a file or to a stream; see :meth:`matplotlib.figure.Figure.savefig`."""
        self._free_the_lines()
        if isinstance(fname, (str, PathLike)) and options.get("format") is None and Path(fname).suffix:
            suffixes = [f".{kind}" for kind in self.canvas.get_supported_filetypes()]
            check_path("fname", fname, suffixes)
        with write_file(fname) as beside:
            super().savefig(beside, **options)

    def _repr_png_(self) -> bytes:
        # IPython knows how to display a Figure only once pyplot has set up its inline backend.
        buffer = BytesIO()
        self.savefig(buffer, format="png")
        return buffer.getvalue()

    def _free_the_lines(self) -> None:
        """Move legends that nobody has placed beside their panels, where they cover a line."""
        unplaced = [ax for ax in self.axes if isinstance(ax, RunAxes) and ax.legend_is_unplaced]
        if unplaced:
            self.draw_without_rendering()  # by which matplotlib finds the best place within the panel
        for ax in unplaced:
            if legend := ax.covering_legend():
                legend.set_loc("center left")
                legend.set_bbox_to_anchor(BESIDE, ax.transAxes)


class RunAxes(Axes):
    """Axes that a notebook displays as their figure; their legend covers no line unless it is placed so."""

    legend_is_unplaced = False

    def legend(self, *args: Any, **options: Any) -> Any:
        """A legend, as :meth:`matplotlib.axes.Axes.legend` makes it."""
        self.legend_is_unplaced = options.keys().isdisjoint(("loc", "bbox_to_anchor"))
        return super().legend(*args, **options)

    def covering_legend(self) -> Legend | None:
        """The legend, if a line or a marker of one is behind it."""
        legend = self.get_legend()
        if legend is None:
            return None
        box = legend.get_window_extent()
        for line in self.lines:
            path = line.get_transform().transform_path(line.get_path())
            drawn = line.get_linestyle() not in ("None", "none", "", " ")
            if path.intersects_bbox(box, filled=False) if drawn else box.count_contains(path.vertices):
                return legend
        return None

    def _repr_png_(self) -> bytes | None:
        figure = self.get_figure(root=True)
        return figure._repr_png_() if isinstance(figure, RunFigure) else None


def new_figure(width: float, height: float) -> RunFigure:
    """A figure of this size in inches, in the present style."""
    return RunFigure(figsize=figure_size(width, height), layout="constrained")


def axes_or_new(ax: Axes | None, size: tuple[float, float] = PANEL_SIZE) -> Axes:
    """The axes given, or those of a new figure of a size in inches, found as ``artist.axes.figure``."""
    if ax is None:
        return new_figure(*size).add_subplot(axes_class=RunAxes)
    if not isinstance(ax, Axes):
        raise TypeError(f"ax must be axes of matplotlib, got {abbreviate(ax)}: leave it out for a new figure")
    return ax


def check_figure(figure: Any) -> None:
    """Raise TypeError unless it is a figure of matplotlib, a part of one, or None."""
    if figure is not None and not isinstance(figure, FigureBase):
        raise TypeError(
            f"figure must be one of matplotlib, got {abbreviate(figure)}: leave it out for a new one"
        )


def legend_beside(ax: Axes, handles: list[Any] | None = None) -> None:
    """A legend of everything labelled in `ax`, or of `handles`, to the right of it; each label once."""
    handles = ax.get_legend_handles_labels()[0] if handles is None else handles
    if handles:
        place: dict[str, Any] = {"loc": "center left", "bbox_to_anchor": BESIDE}
        once = {str(each.get_label()): each for each in handles}
        ax.legend(handles=first_handles(list(once.values())), frameon=False, fontsize=font_size(9.0), **place)


def first_handles(handles: list[Any]) -> list[Any]:
    """The first entries of a legend, and how many more there are: sixty would cover the panels."""
    if len(handles) <= MOST_LISTED:
        return handles
    more = Line2D([], [], linestyle="none", label=f"and {len(handles) - MOST_LISTED} more")
    return [*handles[:MOST_LISTED], more]


def legend_below(figure: Figure, handles: Sequence[Any], size: float | None = None) -> None:
    """A legend below the panels, with letters of a size in points: in one row, or in as many as it needs."""
    points = FontProperties(size=size or matplotlib.rcParams["legend.fontsize"]).get_size_in_points()
    widths = [LETTER_WIDTH * len(str(each.get_label())) + HANDLE_WIDTH for each in handles] or [1.0]
    room = POINTS_PER_INCH * figure.get_size_inches()[0] / points
    columns = len(widths) if sum(widths) <= room else max(1, int(room / max(widths)))
    place: dict[str, Any] = {"loc": "outside lower center", "ncols": columns}
    figure.legend(handles=[*handles], frameon=False, fontsize=size, **place)


def restyle(artists: list[A], properties: Mapping[str, Any]) -> list[A]:
    """The artists, with properties of matplotlib such as ``color`` and ``linewidth``, also in the legend.

    Raises
    ------
    TypeError
        For a property that none of them has; they are then taken out of the picture.
    """
    for name in properties:
        if not any(hasattr(artist, f"set_{name}") for artist in artists or [Line2D]):
            for artist in artists:
                artist.remove()
            known = [each[4:] for each in dir(Line2D) if each.startswith("set_")]
            raise TypeError(
                f"lines have no property {abbreviate(name)}{did_you_mean(name, known)}: give color, "
                "linewidth, linestyle, marker, alpha or another of matplotlib's Line2D"
            )
    for artist in artists:
        artist.set(**{name: value for name, value in properties.items() if hasattr(artist, f"set_{name}")})
    if properties:
        _restyle_legends(artists, properties)
    return artists


def _restyle_legends(artists: Sequence[Artist], properties: Mapping[str, Any]) -> None:
    """Give the entries of lines in legends the properties of the lines, but for their data and labels."""
    labels = {artist.get_label() for artist in artists}
    legends = [ax.get_legend() for ax in {artist.axes for artist in artists if artist.axes is not None}]
    for legend in filter(None, legends):
        for handle, text in zip(legend.get_lines(), legend.get_texts()):
            if text.get_text() in labels:
                handle.set(**{name: properties[name] for name in properties if name != "label"})


def add_missing_legend(figure: Any) -> None:
    """Add a legend of all axes to the right of a figure that has none and labels several things."""
    if figure.legends or any(ax.get_legend() for ax in figure.axes):
        return
    labelled: dict[str, Any] = {}
    for ax in figure.axes:
        for handle, label in zip(*ax.get_legend_handles_labels(), strict=True):
            labelled.setdefault(label, handle)
    if len(labelled) > 1:
        handles = list(labelled.values())
        figure.legend(handles=handles, loc="outside right center", frameon=False, fontsize=font_size(9.0))


def set_title(ax: Axes, text: str, **options: Any) -> None:
    """A title above a panel; none in print, where the caption says it."""
    if not in_print():
        ax.set_title(text, **options)


def set_long_title(ax: Axes, text: str) -> None:
    """A title that fills the width of a figure, smaller where letters are large."""
    if not in_print():
        title = ax.set_title(text)
        title.set_fontsize(float(title.get_fontsize()) / crowding())


def wrap_label(text: str, length: int) -> str:
    """The label; where letters are large, broken into lines of ``length / crowding()`` letters."""
    return text if crowding() == 1.0 else fill(text, round(length / crowding()), break_long_words=False)


class AnimatedFigure(RunFigure):
    """A figure that keeps the image of its fixed parts: drawing them again in every frame would take far
    longer."""

    moving_artists: Sequence[Artist] = ()
    _still: tuple[Any, Any] = (None, None)

    def savefig(self, fname: Any, *, transparent: bool | None = None, **options: Any) -> None:
        """Write a file; PNG and raw pixels, which writers of animations use, come from the kept image."""
        kind = options.get("format")
        if (
            not self.moving_artists
            or kind not in ("png", "rgba")
            or transparent
            or options.get("bbox_inches")
        ):
            return super().savefig(fname, transparent=transparent, **options)
        dpi = options.get("dpi", "figure")
        pixels = self.pixels(self.dpi if dpi == "figure" else dpi)
        if kind == "rgba":
            return fname.write(pixels.tobytes())
        with write_file(fname) as beside:
            imsave(beside, pixels, format="png")

    def pixels(self, dpi: float) -> np.ndarray:
        """The picture as (height, width, 4) bytes."""
        before, usual = self.canvas, self.dpi
        canvas = FigureCanvasAgg(self)
        self.dpi = dpi
        try:
            return self._drawn(canvas)
        finally:
            self.dpi = usual
            self.set_canvas(before)

    def _drawn(self, canvas: FigureCanvasAgg) -> np.ndarray:
        renderer, size = canvas.get_renderer(), canvas.get_width_height()
        if self._still[0] != size:
            self._show_moving(False)
            self.draw(renderer)
            self._show_moving(True)
            self._still = size, renderer.copy_from_bbox(self.bbox)
        renderer.restore_region(self._still[1])
        for artist in sorted(self.moving_artists, key=lambda artist: artist.get_zorder()):
            artist.draw(renderer)
        return np.array(canvas.buffer_rgba())

    def _show_moving(self, visible: bool) -> None:
        for artist in self.moving_artists:
            artist.set_visible(visible)
