"""Many runs of one structure at once, each with the results that it would have alone.

``arrays``
    `Batch`: the arrays of all runs, a row for each, and of the lanes, in which runs of one mode step side by
    side.
``lanes``
    The kernels: queues of runs for each mode, steps of a full set of lanes, events, and the steps that runs
    take alone.
``batch``
    `integrate_batch`, `advance_batch`: from problems to the ends of their runs (`BatchResult`).
"""
