"""Figures of which many frames are written: what does not move is drawn once."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.animation import FuncAnimation
from matplotlib.artist import Artist
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.image import imsave

from .figure import RunFigure


class MovingFigure(RunFigure):
    """A figure that keeps the picture of its still parts: to draw all in every frame takes far longer."""

    moving: Sequence[Artist] = ()
    _still: tuple[Any, Any] = (None, None)

    def savefig(self, fname: Any, *, transparent: bool | None = None, **options: Any) -> None:
        """Write a file; from the kept picture where it is PNG or raw pixels, as writers of animations ask."""
        kind = options.get("format")
        if not self.moving or kind not in ("png", "rgba") or transparent or options.get("bbox_inches"):
            return super().savefig(fname, transparent=transparent, **options)
        dpi = options.get("dpi", "figure")
        pixels = self.pixels(self.dpi if dpi == "figure" else dpi)
        return imsave(fname, pixels, format="png") if kind == "png" else fname.write(pixels.tobytes())

    def pixels(self, dpi: float) -> np.ndarray:
        """The picture as (height, width, 4) bytes."""
        canvas, usual = self.canvas, self.dpi
        self.dpi = dpi
        try:
            return self._drawn(FigureCanvasAgg(self))
        finally:
            self.dpi = usual
            self.set_canvas(canvas)

    def _drawn(self, canvas: FigureCanvasAgg) -> np.ndarray:
        renderer, size = canvas.get_renderer(), canvas.get_width_height()
        if self._still[0] != size:
            self._show_moving(False)
            self.draw(renderer)
            self._show_moving(True)
            self._still = size, renderer.copy_from_bbox(self.bbox)
        renderer.restore_region(self._still[1])
        for artist in sorted(self.moving, key=lambda artist: artist.get_zorder()):
            artist.draw(renderer)
        return np.array(canvas.buffer_rgba())

    def _show_moving(self, visible: bool) -> None:
        for artist in self.moving:
            artist.set_visible(visible)


class RunAnimation(FuncAnimation):
    """An animation that shows itself in a notebook, with a bar while its frames are drawn."""

    def save(self, filename: Any, *args: Any, **options: Any) -> None:
        """Write a file; see :meth:`matplotlib.animation.Animation.save`."""
        if options.get("progress_callback") is not None:
            return super().save(filename, *args, **options)
        from tqdm.auto import tqdm

        with tqdm(leave=False, desc="animate", delay=1.0) as bar:

            def count(frame: int, total: int) -> None:
                bar.total = total
                bar.update()

            return super().save(filename, *args, **options | {"progress_callback": count})

    def _repr_html_(self) -> str:
        # The animation's own shows nothing unless a setting of matplotlib was changed.
        return self.to_jshtml()
