"""The panels of explorers.

    standard         panels by name, which the front end draws, and functions of one's own
    critical_value   critical values of a parameter over another, computed in parts
    bifurcation      a bifurcation diagram that is refined in the range shown, computed in parts

A panel of one's own is a function of a `Result` that returns a `Drawing`, or of a run and matplotlib's axes.
A panel may have controls of its own (`controls`), name the parameters that a click into it sets (`pick`), and
ask to be called again (`progress` of its Drawing).
"""
