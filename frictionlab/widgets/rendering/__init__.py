"""From Drawings to PNGs, fast enough to follow a slider.

    picture       one figure for all panels; each is cut out and sent as a PNG; texts are kept as pixels
    tile          axes of one panel, drawn where labels or limits change, and curves over them

A Drawing gives a tile's lines their data; the tile paints on the picture's canvas; the picture encodes
the tile's pixels. `clickable.js` is the browser's part of a picture that reports clicks.
"""
