"""The panels of explorers: functions of a Result that return a Drawing, and what paints Drawings as PNGs.

    standard       panels that `fl.explore(panels=...)` knows by name; critical values
    bifurcation    a bifurcation diagram that is refined in the range shown, computed in parts
    picture        one figure for all panels; each is cut out and sent as a PNG; texts are kept as pixels
    tile           the axes of one panel, drawn anew only when labels or limits change, and curves over them

A panel may have controls of its own (`controls`), define the effect of a click (`pick`), and ask to be
called again (`progress` of its Drawing).  A Drawing gives a tile's lines their data; the tile paints on the
picture's canvas; the picture encodes the tile's pixels, and `panel_image.js` shows them in the browser.
"""
