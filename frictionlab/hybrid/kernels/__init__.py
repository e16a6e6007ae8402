"""The computations of a run, as functions of arrays that numba compiles once on a machine.

In the order of their imports:

``arithmetic``
    Quick logarithms, sums in vectors, calls of machine code.
``jets``
    Taylor coefficients of a mode's slots at a state, and majorants of their rounding errors.
``event_location``
    The first zero of a mode's guards within a step; all roots of a polynomial on an interval.
``run_state``
    The arrays that a run carries along: where it stands, its clock, scratch arrays, the record of steps and
    events.
``step_length``
    How long a step may be, from the last terms of the series; steps near the zero of a base.
``remainder``
    A bound of what the series leaves out, by ranges on a complex disc.
``power_onset``
    Steps in which powers count as constant, as their bases are zero.
``mode_selection``
    Resets, and the first admissible mode at a state, among listed modes or among combinations of regimes,
    whose modes are derived on demand.
``impacts``
    Impacts at one instant: which comes first, which act together, and which closes a Zeno accumulation.
``event_handling``
    What is done at an event: record, reset, next mode.
``taylor_steps``
    One step, its section events, the loop of steps, and the dense output from the steps that were stored.

A step computes the ``jets`` at the state.  ``step_length`` gives its length, with ``remainder`` if the last
terms of the series do not tell.  ``event_location`` looks for an event in it.  Then the state moves to the
end.  If there is an event, ``event_handling`` resets the state and asks ``mode_selection`` for the next mode.
"""
