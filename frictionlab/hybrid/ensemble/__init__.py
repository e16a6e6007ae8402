"""Many runs of one structure at once, each with the numbers that it would have alone.

``lanes``
    `Batch`: the arrays of all runs, a row for each, and of the lanes, in which runs of one mode step side by
    side.  The kernels: queues of runs for each mode, steps of a full set of lanes, and what a single run
    needs besides.
``batch``
    `integrate_batch`, `advance_batch`: from problems to the ends of their runs (`BatchResult`).
"""
