"""`LargeSystem`: what has so many freedoms that its stability is found by methods of its own.

`fl.eigenvalues`, `fl.root_locus` and the like linearise models by dense matrices of all states.  They hand a
large system its own question; the results are of the same classes.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any, Generic, TypeVar

if TYPE_CHECKING:
    from frictionlab.stability.boundaries.stability_changes import StabilityChange
    from frictionlab.stability.eigenproblems.eigenvalues import Eigenvalues
    from frictionlab.stability.eigenproblems.root_locus import RootLocus
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

    @abstractmethod
    def follow_modes(self, parameter: str, values: Any) -> RootLocus:
        """See :func:`frictionlab.root_locus`."""

    @abstractmethod
    def find_stability_changes(self, parameter: str, bounds: Any) -> tuple[StabilityChange, ...]:
        """See :func:`frictionlab.stability_changes`."""

    @abstractmethod
    def count_growing(self, parameter: str, value: float) -> int:
        """The number of modes that grow at a value of a parameter."""
