"""The picture of an explorer: one permanent figure, its panels as images that wrap on a narrow screen.

Images are PNGs with a palette made of the lines' colours, and texts are rendered once and then copied:
finding a palette from the pixels, or rendering a text, takes longer than drawing the curves.  Over panels
that respond to clicks the pointer shows it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import nullcontext
from functools import lru_cache
from importlib import resources
from io import BytesIO
from typing import TYPE_CHECKING, Any, NamedTuple

import anywidget
import numpy as np
import traitlets
from matplotlib.backends.backend_agg import FigureCanvasAgg, RendererAgg
from matplotlib.colors import to_hex, to_rgb
from matplotlib.font_manager import FontProperties
from numpy.typing import NDArray
from PIL import Image

from frictionlab.plotting.appearance import WHITE, background, ink_on, is_dark, style
from frictionlab.plotting.figure import Drawing, RunFigure

from .tile import Tile

if TYPE_CHECKING:
    from frictionlab.widgets.result import Result

RGB = tuple[float, float, float]

PALETTE_ENTRIES = 256  # of a palette
SHADES_PER_COLOUR = 16  # from a colour to the background: at the edges of lines pixels are mixtures of both

MAX_CACHED_TEXTS = 2048  # texts

Panel = Callable[[Any], Drawing]
PANEL_WIDTH, PANEL_HEIGHT, DPI = (
    4.4,
    3.0,
    100,
)  # inches of a panel: two beside the controls on a screen of 1280 pixels
PANEL_COLUMNS = 2
# A panel has whole pixels at all multiples of the step; drawing with more than MAX_DPI would take too long.
MIN_DPI, MAX_DPI, DPI_STEP = 60.0, 220.0, 5.0


def encode_png(pixels: Any, colours: Iterable[Any], paper: Any = WHITE) -> bytes:
    """The image in shades of these colours.

    Parameters
    ----------
    pixels : Image
        RGB or RGBA, without transparency.
    colours : iterable
        As matplotlib takes them; black, or white on a dark background, is always added.
    paper : colour
        The background.
    """
    palette = _palette(tuple(sorted({to_rgb(ink_on(paper)), *map(to_rgb, colours)})), to_rgb(paper))
    buffer = BytesIO()
    image = pixels.convert("RGB").quantize(palette=palette, dither=Image.Dither.NONE)
    image.save(buffer, "png", compress_level=1)
    return buffer.getvalue()


@lru_cache(16)
def _palette(colours: tuple[RGB, ...], paper: RGB) -> Any:
    """A palette image: each colour in equal steps towards the background."""
    shades = max(3, min(SHADES_PER_COLOUR, (PALETTE_ENTRIES - 1) // len(colours)))
    # The background comes once, at the end; the shade next to it is left out, to keep the two apart.
    share = np.linspace(1.0, 0.0, shades + 1)[:-2, None, None]
    mixed = paper - share * (np.array(paper) - np.array(colours))
    table = np.vstack([mixed.reshape(-1, 3)[: PALETTE_ENTRIES - 1], [paper]])
    image = Image.new("P", (1, 1))
    image.putpalette(np.rint(table * 255).astype(np.uint8).tobytes())
    return image


class PanelImage(anywidget.AnyWidget):
    """A panel's picture in the browser.

    Attributes
    ----------
    value : bytes
        PNG.
    alt : str
        What a screen reader says about it.
    hint : str
        What a click does; empty where it does nothing.
    """

    _esm = (
        resources.files("frictionlab.widgets.panels").joinpath("panel_image.js").read_text(encoding="utf-8")
    )
    value = traitlets.Bytes().tag(sync=True)
    alt = traitlets.Unicode().tag(sync=True)
    hint = traitlets.Unicode().tag(sync=True)  # the name tooltip makes views fail

    def on_click(self, clicked: Callable[[float, float], None]) -> None:
        """Register a function that is called with the position of a click, as shares of width (from the left)
        and height (from below)."""

        def heard(_: Any, content: dict[str, Any], __: Any) -> None:
            clicked(float(content["x"]), float(content["y"]))

        self.on_msg(heard)


class TextImage(NamedTuple):
    """Pixels (h, w, 4) of a text, bottom row first, and its lower left corner relative to its origin."""

    pixels: NDArray[np.uint8]
    left: int
    below: int


class TextCacheRenderer(RendererAgg):
    """The Agg renderer with every text rendered once, and copied to whole pixels."""

    def draw_text(
        self,
        gc: Any,
        x: float,
        y: float,
        s: str,
        prop: Any,
        angle: float,
        ismath: Any = False,
        mtext: Any = None,
    ) -> None:
        """Copy the text's pixels; its origin is at (x, y), y downwards."""
        look = tuple(gc.get_rgb()), gc.get_alpha()
        letters = text_image(s, prop.copy(), float(angle), bool(ismath), self.dpi, look)
        if letters is not None:
            left, below = round(x) + letters.left, self.height - round(y) + letters.below
            self.draw_image(gc, left, below, letters.pixels)


class TextCacheCanvas(FigureCanvasAgg):
    """A canvas for one figure that never changes its size."""

    def get_renderer(self) -> TextCacheRenderer:
        """The one renderer of this canvas."""
        if not hasattr(self, "renderer"):
            self.renderer = TextCacheRenderer(*self.figure.bbox.size, self.figure.dpi)
        return self.renderer


@lru_cache(MAX_CACHED_TEXTS)
def text_image(
    text: str, prop: FontProperties, angle: float, ismath: bool, dpi: float, look: Any
) -> TextImage | None:
    """The image of a text; None where it has no visible pixels."""
    plain = RendererAgg(1, 1, dpi)
    width, height, descent = plain.get_text_width_height_descent(text, prop, ismath)
    reach = int(np.ceil(np.hypot(width, height + descent))) + 4  # at any angle
    sheet = RendererAgg(2 * reach, 2 * reach, dpi)
    gc = sheet.new_gc()
    colour, alpha = look
    gc.set_foreground(colour, isRGBA=True)
    gc.set_alpha(alpha)
    sheet.draw_text(gc, reach, reach, text, prop, angle, ismath)
    pixels = np.asarray(sheet.buffer_rgba())
    rows, columns = (np.flatnonzero(pixels[..., 3].any(axis=axis)) for axis in (1, 0))
    if not len(rows):
        return None
    top, bottom, left = rows[0], rows[-1] + 1, columns[0]
    cut = pixels[top:bottom, left : columns[-1] + 1]
    return TextImage(cut[::-1].copy(), int(left) - reach, reach - int(bottom))


class Picture:
    """A figure with one tile for each panel, and a widget that shows them.

    Parameters
    ----------
    panels : mapping of str to Panel
        By the name that becomes a CSS class, ``fl-panel-<name>``.

    Attributes
    ----------
    dpi : float
        Pixels per inch; a panel is `PANEL_WIDTH` inches wide.
    dark : bool
        Whether it is drawn on a dark background.
    """

    def __init__(self, panels: dict[str, Panel]) -> None:
        self.panels, self.dpi, self._own_dark = panels, DPI, is_dark()
        self.dark = self._own_dark
        self.shown: dict[str, Drawing] = {}
        self.kept: dict[str, Drawing] = {}
        self.images = {name: _panel_image(name, panel) for name, panel in panels.items()}
        self._make_tiles()

    def set_look(self, pixels: float, dark: bool) -> None:
        """Draw everything anew for panels of so many pixels, on a dark or light page.

        A picture that was made in a dark style stays dark.
        """
        dark = dark or self._own_dark
        dpi = min(max(pixels / PANEL_WIDTH // DPI_STEP * DPI_STEP, MIN_DPI), MAX_DPI)
        if (dpi, dark) == (self.dpi, self.dark):
            return
        self.dpi, self.dark = dpi, dark
        self._make_tiles()
        _keep(self.kept, self.tiles)
        self._show(self.shown)

    def draw(self, result: Result, goes_on: bool = False) -> tuple[int, int] | None:
        """Show a result in all panels; if one fails, none is changed.

        `goes_on` says that the result is the one already shown: then only panels that are not complete, or
        have controls, are called.

        Returns the parts done and their total where a panel is not complete.
        """
        names = [name for name in self.panels if not goes_on or self._may_change(name)]
        self.shown |= {name: self.panels[name](result) for name in names}
        self._show(names)
        return next((drawing.progress for drawing in self.shown.values() if drawing.progress), None)

    def freeze(self) -> None:
        """Keep the present curves and show them dotted."""
        self.kept = dict(self.shown)
        _keep(self.kept, self.tiles)
        self.paint(self.panels)

    def figure_to_print(self) -> RunFigure:
        """What is shown, as a separate figure for any resolution; dark only if made in a dark style, whatever
        the page."""
        figure, _, tiles = _make_tiles(self.panels, self.dpi, self._own_dark)
        _keep(self.kept, tiles)
        for name, drawing in self.shown.items():
            tiles[name].show(drawing)
        FigureCanvasAgg(figure)  # renders texts instead of copying pixels
        return figure

    def unfreeze(self) -> None:
        """Remove the curves that were kept, and show the picture without them."""
        self.kept = {}
        for tile in self.tiles.values():
            tile.forget()
        self._show(self.shown)

    def paint(self, names: Iterable[str]) -> None:
        """Draw tiles and send their images."""
        names = list(names)
        for name in names:
            self.tiles[name].paint(self.canvas)
        pixels = Image.fromarray(np.asarray(self.canvas.buffer_rgba()))
        for name in names:
            tile = self.tiles[name]
            part = pixels.crop(_pixel_box(tile, pixels.height))
            self.images[name].value = encode_png(part, tile.colours, background(tile.ax))

    def _make_tiles(self) -> None:
        self.figure, self.canvas, self.tiles = _make_tiles(self.panels, self.dpi, self.dark)

    def _may_change(self, name: str) -> bool:
        return bool(self.shown[name].progress) or hasattr(self.panels[name], "controls")

    def _show(self, names: Iterable[str]) -> None:
        for name in names:
            self.tiles[name].show(self.shown[name])
            self.images[name].alt = _description(name, self.shown[name])
        if self.shown:
            self.paint(names)


def _make_tiles(
    panels: Iterable[str], dpi: float, dark: bool
) -> tuple[RunFigure, TextCacheCanvas, dict[str, Tile]]:
    """A figure with an empty tile for each panel, on a dark or light page."""
    names = list(panels)
    columns = max(1, min(PANEL_COLUMNS, len(names)))
    rows = max(1, -(-len(names) // columns))
    places = [(i % columns, rows - 1 - i // columns) for i in range(len(names))]
    size = 1 / columns, 1 / rows
    with theme(dark):
        figure = RunFigure(figsize=(columns * PANEL_WIDTH, rows * PANEL_HEIGHT), dpi=dpi)
        canvas = TextCacheCanvas(figure)
        canvas.draw()
        tiles = {name: Tile(figure, (x * size[0], y * size[1], *size)) for name, (x, y) in zip(names, places)}
    return figure, canvas, tiles


def _keep(drawings: dict[str, Drawing], tiles: dict[str, Tile]) -> None:
    for name, drawing in drawings.items():
        tiles[name].keep(drawing)


def theme(dark: bool) -> Any:
    """A context with colours for a dark page, if the page is dark and the user's background is white."""
    return style("dark") if dark and background() == to_hex(WHITE) else nullcontext()


def _description(name: str, drawing: Drawing) -> str:
    """A panel in words: its name, its axes, its note."""
    axes = f"{drawing.ylabel} against {drawing.xlabel}"
    return ": ".join(filter(None, [name, axes.replace("$", ""), drawing.note.replace("\n", ", ")]))


def _panel_image(name: str, panel: Any) -> PanelImage:
    """The widget of a panel; it can be clicked if the panel has `pick`."""
    image = PanelImage(hint=panel.hint if hasattr(panel, "pick") else "")
    return image.add_class("fl-panel").add_class(f"fl-panel-{name}")


def _pixel_box(tile: Tile, height: int) -> tuple[int, int, int, int]:
    (x0, y0), (x1, y1) = np.rint(tile.box.get_points()).astype(int).tolist()
    return x0, height - y1, x1, height - y0  # an image's first row is the top one
