"""Stability of steady sliding: equilibria, eigenvalues, and how they change with the parameters."""

from __future__ import annotations

from .boundary import Boundary
from .changes import CriticalCurve, StabilityChange, critical_curve, critical_value, stability_changes
from .eigen import Eigenvalues, eigenvalues, jacobian
from .equilibria import Equilibrium, equilibria, equilibrium
from .hopf import HopfPoint, hopf
from .locus import RootLocus, root_locus
from .map import StabilityMap, stability_map

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
