"""Equilibria of models and automata.

`equilibria` has the public functions, and makes the `EquilibriumProblem` on which the other packages of
stability work, for many parameter values at once (`followed_equilibria`).  Of an automaton: zeros of the flow
of each mode (`steady_modes`), by Newton's method from many starts (`newton`), polished and distinguished.  Of
models with one contact: `static_equations` reduces the static equations to one equation in the penetration,
whose roots (`real_roots`) are all found.
"""
