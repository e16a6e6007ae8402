"""A model's mechanism in motion.

    parts           where each part of a model's `Mechanism` is in every frame, as shapes and numbers
    tilting_belt    the same for the slider on the tilting belt, Fig. 1 of the paper; mechanism and forces as
                    matplotlib artists, moved from frame to frame
    animate         `fl.animate`: a film of the mechanism, drawn by one of these two, with the phase plane
                    beside it

A run and its model's mechanism become a picture, and a picture becomes artists.  The front end of
`frictionlab.pages` draws mechanisms in the browser, with ``drawing.js``.
"""
