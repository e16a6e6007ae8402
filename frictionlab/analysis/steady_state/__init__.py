"""What a motion settles to.

`steady_state` runs a model through its transient and then window by window.  Each window, a `Trajectory`, is
classified (`classification`) by recurrence at a Poincare section (`poincare_sections`), or by slow decay.
Before that, the phase of a force is mapped to a circle.  A `SteadyState` holds the kind, the period, the
intensity, Eq. (20), and the window.
"""
