"""A model's mechanism in motion.

    parts           where each part of a model's `Mechanism` is in every frame, as shapes and numbers
    tilting_belt    the same of the slider on the tilting belt, Fig. 1 of the paper; it and its forces as
                    matplotlib artists, moved from frame to frame
    animate         `fl.animate`: the picture of a run in its frames, by one of these two, and the phase plane
                    beside it, as a film

A run and its model's mechanism become a picture, and a picture becomes artists.  `fl.watch`
(widgets/canvas.py) sends the same picture to the browser.
"""
