"""Panels of the explorers: functions of a Result that return a Drawing.

    standard       panels that `fl.explore(panels=...)` knows by name; critical values
    bifurcation    a bifurcation diagram that is refined where one looks, computed in parts

A panel may bring controls of its own (`controls`), say what a click does (`pick`), and ask to be called
again (`progress`).
"""
