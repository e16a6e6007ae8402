"""Equilibria of models and automata.

`equilibria` has the public functions, and makes the `EquilibriumProblem` on which the other packages of
stability work, for many parameter values at once (`followed_equilibria`).  The equilibria of an automaton are
zeros of the flow of each mode (`steady_modes`), found by Newton's method from many starts (`newton`),
polished and told apart.  For models with one contact `static_equations` reduces the static equations to one
equation in the penetration; where that is a polynomial, all its real roots are found (`real_roots`).
"""
