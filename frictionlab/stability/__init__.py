"""Stability of steady sliding: equilibria, eigenvalues, and how they change with the parameters."""

from __future__ import annotations

from .changes import CriticalCurve, StabilityChange, critical_curve, critical_value, stability_changes
from .eigen import Eigenvalues, eigenvalues, jacobian
from .equilibria import Equilibrium, equilibria, equilibrium
from .locus import RootLocus, root_locus

__all__ = [
    "CriticalCurve",
    "Eigenvalues",
    "Equilibrium",
    "RootLocus",
    "StabilityChange",
    "critical_curve",
    "critical_value",
    "eigenvalues",
    "equilibria",
    "equilibrium",
    "jacobian",
    "root_locus",
    "stability_changes",
]
