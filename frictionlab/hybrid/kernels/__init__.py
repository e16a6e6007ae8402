"""The computations of a run, as functions of arrays that numba compiles once on a machine.

In the order of their imports:

``arithmetic``
    Quick logarithms, sums in vectors, calls of machine code.
``jets``
    Taylor coefficients of a mode's slots at a state, and majorants of their rounding errors.
``step_length``
    How long a step may be, from the last terms of the series; steps where the base of a power is nearly zero.
``remainder``
    A bound of what the series leaves out, by ranges on a complex disc.
``run_state``
    The arrays that a run carries along: where it stands, its clock, scratch arrays, the record of steps and
    events.
``event_location``
    The first zero of a mode's guards within a step; all roots of a polynomial on an interval.
``mode_selection``
    Resets, and the first admissible mode at a state, among listed modes or combinations of regimes, whose
    modes are derived on demand.
``event_handling``
    What is done at an event: record, reset, next mode, Zeno points.
``taylor_steps``
    One step, its section events, the loop of steps, and the dense output from the steps that were stored.

A step goes through ``jets`` at the state, ``step_length`` (with ``remainder`` where the last terms of the
series do not tell),
``event_location`` within it, section events, the state at its end; if there is an event,
``event_handling``, which resets the state and asks ``mode_selection`` for the next mode.
"""
