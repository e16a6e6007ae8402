"""The picture of an explorer: one figure for good, its panels as images that wrap on a narrow screen."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import ipywidgets
import numpy as np
from PIL import Image

from frictionlab.plotting.figure import RunFigure

from .clickable import ClickablePicture
from .drawing import Drawing
from .lettering import LetteringCanvas
from .png import png
from .tile import Tile

Panel = Callable[[Any], Drawing]
WIDTH, HEIGHT, DPI = 4.4, 3.0, 100  # inches of a panel: two beside the controls on a screen of 1280 pixels
COLUMNS = 2


class Picture:
    """A figure with one tile for each panel, and a widget that shows them.

    Parameters
    ----------
    panels : mapping of str to Panel
        By the name that becomes a CSS class, ``fl-panel-<name>``.
    """

    def __init__(self, panels: dict[str, Panel]) -> None:
        self.panels = panels
        columns = min(COLUMNS, len(panels))
        rows = -(-len(panels) // columns)
        self.figure = RunFigure(figsize=(columns * WIDTH, rows * HEIGHT), dpi=DPI)
        self.canvas = LetteringCanvas(self.figure)
        self.canvas.draw()
        places = [(i % columns, rows - 1 - i // columns) for i in range(len(panels))]
        size = 1 / columns, 1 / rows
        self.tiles = {
            name: Tile(self.figure, (x * size[0], y * size[1], *size)) for name, (x, y) in zip(panels, places)
        }
        self.images = {name: _image(name, panel) for name, panel in panels.items()}
        layout = ipywidgets.Layout(flex_flow="row wrap", flex=f"1 1 {WIDTH * DPI:.0f}px", min_width="0")
        self.widget = ipywidgets.Box(list(self.images.values()), layout=layout)
        self.widget.add_class("fl-picture")

    def draw(self, result: Any) -> tuple[int, int] | None:
        """Show a result in all panels; where one fails none is changed.

        Returns how much is done, and of how much, where a panel is not done yet.
        """
        drawings = [panel(result) for panel in self.panels.values()]
        for tile, drawing in zip(self.tiles.values(), drawings):
            tile.show(drawing)
        self.paint(self.panels)
        return next((drawing.progress for drawing in drawings if drawing.progress), None)

    def keep(self) -> None:
        """Leave the curves behind in grey."""
        for tile in self.tiles.values():
            tile.keep()

    def forget(self) -> None:
        """Take the grey curves away, and show that."""
        for tile in self.tiles.values():
            tile.forget()

    def paint(self, names: Sequence[str] | dict[str, Panel]) -> None:
        """Draw tiles, and send their pixels."""
        for name in names:
            self.tiles[name].paint(self.canvas)
        pixels = Image.fromarray(np.asarray(self.canvas.buffer_rgba()))
        for name in names:
            tile = self.tiles[name]
            self.images[name].value = png(pixels.crop(_box(tile, pixels.height)), tile.colours)


def _image(name: str, panel: Any) -> Any:
    """The widget of a panel; one that can be clicked where the panel makes something of it."""
    image = ClickablePicture(hint=panel.hint) if hasattr(panel, "pick") else ipywidgets.Image(format="png")
    image.layout = ipywidgets.Layout(width=f"{WIDTH * DPI:.0f}px", max_width="100%", margin="0")
    image.layout.object_fit = "contain"
    return image.add_class("fl-panel").add_class(f"fl-panel-{name}")


def _box(tile: Tile, height: int) -> tuple[int, int, int, int]:
    (x0, y0), (x1, y1) = np.rint(tile.box.get_points()).astype(int).tolist()
    return x0, height - y1, x1, height - y0  # an image's first row is the top one
