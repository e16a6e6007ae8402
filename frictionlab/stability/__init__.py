"""Stability of steady sliding: equilibria and eigenvalues."""

from __future__ import annotations

from .eigen import Eigenvalues, eigenvalues, jacobian
from .equilibria import Equilibrium, equilibria, equilibrium

__all__ = ["Eigenvalues", "Equilibrium", "eigenvalues", "equilibria", "equilibrium", "jacobian"]
