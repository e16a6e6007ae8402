"""PNG with a palette that is known beforehand: to look for one takes longer than to draw the curves."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache
from io import BytesIO
from typing import Any

import numpy as np
from matplotlib.colors import to_rgb
from PIL import Image

ENTRIES = 256  # of a palette
SHADES = 16  # of a colour, to white; where lines end the pixels are mixtures with the background


def png(pixels: Any, colours: Iterable[Any]) -> bytes:
    """The image in shades of these colours.

    Parameters
    ----------
    pixels : Image
        RGB or RGBA, without transparency.
    colours : iterable
        As matplotlib takes them; black is always there.
    """
    palette = _palette(tuple(sorted({to_rgb("black"), *map(to_rgb, colours)})))
    buffer = BytesIO()
    image = pixels.convert("RGB").quantize(palette=palette, dither=Image.Dither.NONE)
    image.save(buffer, "png", compress_level=1)
    return buffer.getvalue()


@lru_cache(16)
def _palette(colours: tuple[tuple[float, float, float], ...]) -> Any:
    """Each colour in equal steps to white."""
    shades = max(3, min(SHADES, (ENTRIES - 1) // len(colours)))
    # White comes once, at the end, and no shade is so near to it that the one would be taken for the other.
    share = np.linspace(1.0, 0.0, shades + 1)[:-2, None, None]
    mixed = 1.0 - share * (1.0 - np.array(colours))
    table = np.vstack([mixed.reshape(-1, 3)[: ENTRIES - 1], [[1.0, 1.0, 1.0]]])
    image = Image.new("P", (1, 1))
    image.putpalette(np.rint(table * 255).astype(np.uint8).tobytes())
    return image
