"""Panels of the explorers: functions of a Result that return a Drawing.

    standard       panels that `fl.explore(panels=...)` knows by name; critical values
    bifurcation    a bifurcation diagram that is refined in the range shown, computed in parts

A panel may have controls of its own (`controls`), define the effect of a click (`pick`), and request to be
called again (`progress`).
"""
