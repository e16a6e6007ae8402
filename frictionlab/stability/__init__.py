"""Stability of equilibria and of steady sliding: eigenvalues, and how they change with the parameters.

All analyses work on an `EquilibriumProblem` (`equilibrium_problem`): equilibria and state matrices as
functions of arrays of parameters, with the linear algebra on stacks of matrices that all of them use.
`equilibrium_points` makes one of a model or an automaton, through the `Flow` of a mode (`flow`, with exact
derivatives by the parameters); `eigenproblems` gives eigenvalues and root loci; `boundaries` finds where
stability changes along one parameter or in a plane of two, and the vibration that begins there (Hopf points).
"""

from __future__ import annotations

from .boundaries.boundary_curves import Boundary
from .boundaries.hopf import HopfPoint, hopf
from .boundaries.stability_changes import (
    CriticalCurve,
    StabilityChange,
    critical_curve,
    critical_value,
    stability_changes,
)
from .boundaries.stability_map import StabilityMap, stability_map
from .eigenproblems.eigenvalues import Eigenvalues, eigenvalues, jacobian
from .eigenproblems.root_locus import RootLocus, root_locus
from .equilibrium_points.equilibria import Equilibrium, equilibria, equilibrium

__all__ = [
    "Boundary",
    "CriticalCurve",
    "Eigenvalues",
    "Equilibrium",
    "HopfPoint",
    "RootLocus",
    "StabilityChange",
    "StabilityMap",
    "critical_curve",
    "critical_value",
    "eigenvalues",
    "equilibria",
    "equilibrium",
    "hopf",
    "jacobian",
    "root_locus",
    "stability_changes",
    "stability_map",
]
