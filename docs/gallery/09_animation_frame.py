"""A frame of the animation.

`fl.animate` shows slider, springs and tilting belt in slow motion, coloured by mode, with the contact
forces as arrows and the phase plane beside. In a notebook it plays; `fl.animate(run).save("run.gif")`
writes a film.
"""

import frictionlab as fl
from frictionlab.plotting import RunFigure

run = fl.simulate(fl.SliderOnBelt(mu_k=1.4), 10.0)

figure = RunFigure(figsize=(11, 5.6), layout="constrained")
film = fl.animate(run, window=0.1, fps=2, figure=figure)
film._draw_frame(0)
film._draw_was_started = True  # one frame is wanted: matplotlib need not warn that the film is not shown
