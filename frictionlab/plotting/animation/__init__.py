"""A model's mechanism in motion.

    parts           where each part of a model's `Mechanism` is in every frame, as shapes and numbers
    tilting_belt    the same of the slider on the tilting belt, Fig. 1 of the paper
    artists         matplotlib artists of the slider, its belt and its forces, moved from frame to frame
    animate         `fl.animate`: the picture of a run in its frames, by one of these two, and the phase plane
                    beside it, as a film

A run and its model's mechanism become a picture, and a picture becomes artists.  `fl.watch`
(widgets/canvas.py) sends the same picture to the browser.
"""
