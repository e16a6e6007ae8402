"""What a motion settles to.

`steady_state` runs a model through its transient and then window by window.  Each window, a `Trajectory`, is
classified (`classification`) by recurrence at a Poincare section (`poincare_sections`), or by slow decay;
states that are the phase of a force are mapped to a circle first.  Kind, period, intensity, Eq. (20), and the
window come together in a `SteadyState`.
"""
