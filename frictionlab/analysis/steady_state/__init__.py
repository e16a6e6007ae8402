"""What a motion settles to.

`steady_state` runs a model through its transient and then window by window.  Each window, a `Trajectory`, is
classified (`classification`) by recurrence at a Poincare section (`poincare_sections`, `recurrence`), or by
slow decay (`decay`); states that are the phase of a force are mapped to a circle first (`forcing_phase`).
`result` puts kind (`motion_kind`), period, intensity (`intensity`, Eq. (20)) and the window together in a
`SteadyState`.
"""
