"""Equilibria of models and automata.

An equilibrium is a zero of the flow of a mode.  For models with one contact there is a shorter way: one
equation in the penetration.

``equilibria``
    `fl.equilibria`, `fl.equilibrium`; the `EquilibriumProblem` on which the other packages of stability work.
``steady_modes``
    The modes in which equilibria are searched for, as functions.
``newton``
    All zeros of a flow: Newton's method from boxes or from many starts; polished and told apart.
``root_boxes``
    Boxes that hold all zeros, by bounds of the flow in each box.
``static_equations``, ``real_roots``
    The one equation in the penetration; all its real roots if it is a polynomial.
``followed_equilibria``
    The same equilibrium at many parameter values at once.
"""
