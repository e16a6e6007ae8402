"""A model's mechanism in motion.

    parts           where each part of a model's `Mechanism` is in every frame, as shapes and numbers, and as
                    matplotlib's artists, moved from frame to frame
    animate         `fl.animate`: a film of the mechanism with the phase plane beside it

A run and its model's mechanism become a picture, and a picture becomes artists.  The front end of
`frictionlab.pages` draws mechanisms in the browser, with ``drawing.js``.
"""
