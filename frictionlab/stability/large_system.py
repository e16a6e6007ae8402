"""`LargeSystem`: what has so many freedoms that its stability is found by methods of its own.

`fl.equilibrium` and `fl.eigenvalues` linearise models by dense matrices of all states.  They hand a
large system its own question; the results are of the same classes.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Generic, TypeVar

if TYPE_CHECKING:
    from frictionlab.stability.eigenproblems.eigenvalues import Eigenvalues
    from frictionlab.stability.equilibrium_points.equilibria import Equilibrium


E = TypeVar("E", bound="Eigenvalues")


class LargeSystem(ABC, Generic[E]):
    """Base of systems that answer the questions of `frictionlab.stability` themselves."""

    @abstractmethod
    def find_equilibrium(self) -> Equilibrium:
        """See :func:`frictionlab.equilibrium`."""

    @abstractmethod
    def find_eigenvalues(self) -> E:
        """See :func:`frictionlab.eigenvalues`."""
