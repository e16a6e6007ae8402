"""From sympy expressions to the arrays that the kernels run on.

Models compute their numbers with it, and the solver runs what it makes; it knows of neither.

``elementary``
    exp, log, sin, powers and the like, with the same bits on every machine.
``functions``
    The operations that a tape may hold, by their numbers, and the functions among them: for each its
    derivative, its value, its range on a disc.
``tape``
    `Tape`, operations on numbered slots, and `TapeBuilder`, which lowers expressions onto one; equal
    subexpressions share a slot.
``formulas``
    `Formulas`: expressions of states and parameters as functions of numbers, arrays and intervals, with their
    derivatives; a tape whose coefficients are numbers.
``intervals``
    `Interval`: bounds of a number, which take its place in formulas and in the operations of modes.
``undefined_parts``
    Which part of a formula has no real value at some values of the parameters.
``program``
    `Program`: the arrays of a whole automaton (`Code`), and `Numbers`, its coefficients for one set of
    values; a program as data that is kept for later processes, and back.
``packing``
    `program_of`: packs the tapes of all modes and resets, and remembers the result by structure.
``lowering``
    The tape of one mode, or of one reset, and what the kernels need to know of it; the numbers in tapes as
    functions of the parameters.
``structural_zeros``
    Which functions are zero by construction after an event.
``arguments``
    What the solver is given: one clear error for an automaton that is not well formed; expressions as text,
    such as "x1' - v", read without being evaluated as Python.
``automaton_data``
    An automaton as data for the file of a run, and back to the same tape; nothing in the file is evaluated.

An automaton's structure goes through `packing` once; new values of parameters cost one call of
`Program.numbers`.
"""
