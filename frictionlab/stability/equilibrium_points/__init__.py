"""Equilibria of models and automata.

An equilibrium is a zero of the flow of a mode.  For models with one contact there is a shorter way: one
equation in the penetration.

``equilibria``
    `fl.equilibria`, `fl.equilibrium`; the `EquilibriumProblem` on which the other packages of stability work.
``sliding``
    Models with one contact: the static equations, the equation in the penetration, and its roots.
``steady_modes``
    All others: the modes in which equilibria are searched for, as functions.
``steady_rates``
    The rates of a mode whose zeros these are: cyclic coordinates turn, closed rigid contacts hold distances.
``newton``
    All zeros of a flow by Newton's method, and a zero followed to other values of the parameters.
``root_boxes``
    Boxes that hold all zeros, by bounds of the flow in each box.
"""
