"""Stability of equilibria and of steady sliding: eigenvalues, and how they change with the parameters.

All analyses work on an `EquilibriumProblem`: equilibria and state matrices as functions of arrays of
parameters.

``flow``
    `Flow`: the rates of one mode with their exact derivatives by states and parameters.
``equilibrium_problem``
    `EquilibriumProblem`, on which all analyses work.
``state_matrices``
    Eigenvalues, vectors and growth rates of state matrices, and what of them is rounding.
``equilibrium_points``
    All equilibria of a model or an automaton; from one of them an `EquilibriumProblem`.
``eigenproblems``
    Eigenvalues and root loci.
``boundaries``
    Where stability changes along one parameter or in a plane of two, and the vibration that begins there
    (Hopf points).
"""

from __future__ import annotations

from frictionlab.lazy_names import homes_in_stub, loader_of_names

_HOME = homes_in_stub(__loader__, __path__[0])
__all__ = list(_HOME)  # pyright: ignore[reportUnsupportedDunderAll]  # it reads literals only
__getattr__ = loader_of_names(__name__, _HOME, globals())


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
