"""A model as people read it.

`equations` holds the equations of a mode, printed as text or LaTeX,
and derives them from an automaton's flow; `lagrange_equations` writes those of mechanical models with their
contact forces, and those of an impact, as the paper does.
"""
