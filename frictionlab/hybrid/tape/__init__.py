"""From sympy expressions to the arrays that the kernels run on.

``operations``
    The operations that a tape may hold, by their numbers.
``functions``
    The functions among them: for each its derivative, its value, its range on a disc.
``tape``
    `Tape`, operations on numbered slots, and `TapeBuilder`, which lowers expressions onto one; equal
    subexpressions
    share a slot.
``expression_text``
    Expressions given as text, read without being evaluated as Python.
``program``
    `Program`: the arrays of a whole automaton (`Code`), and `Numbers`, its coefficients for one set of
    values.
``packing``
    `program_of`: lowers every mode and reset of an automaton, packs the tapes, and remembers the result by
    structure.
    Also which functions are zero by construction after an event.
``expression_text``
    Expressions that are given as text, such as "x1' - v".
``automaton_checks``
    One clear error for an automaton that is not well formed.
``automaton_data``
    An automaton as data for the file of a run, and back to the same tape; nothing in the file is evaluated.

An automaton's structure goes through `packing` once; new values of parameters cost one call of
`Program.numbers`.
"""
