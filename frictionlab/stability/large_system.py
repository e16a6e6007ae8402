"""`LargeSystem`: what has so many freedoms that its stability is found by methods of its own.

`fl.eigenvalues`, `fl.root_locus` and the like linearise models by dense matrices of all states.  They hand a
large system its own question; the results are of the same classes.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Generic, Protocol, TypeVar

from frictionlab.models.model import MovingSystem

if TYPE_CHECKING:
    from frictionlab.stability.boundaries.stability_changes import StabilityChange
    from frictionlab.stability.eigenproblems.eigenvalues import Eigenvalues
    from frictionlab.stability.eigenproblems.root_locus import RootLocus
    from frictionlab.stability.equilibrium_points.equilibria import Equilibrium


class SpectraOf(Protocol):
    """Eigenvalues at values of parameters."""

    def spectra(self, changes: Mapping[str, Any], /) -> Any:
        """Eigenvalues (N, m), the largest growth rate first, at arrays (N,) of parameters."""
        ...


E = TypeVar("E", bound="Eigenvalues")


class LargeSystem(MovingSystem, ABC, Generic[E]):
    """Base of systems that answer the questions of `frictionlab.stability` themselves."""

    @abstractmethod
    def find_equilibrium(self) -> Equilibrium:
        """See :func:`frictionlab.equilibrium`."""

    @abstractmethod
    def find_eigenvalues(self) -> E:
        """See :func:`frictionlab.eigenvalues`."""

    @abstractmethod
    def find_root_locus(self, parameter: str, values: Any) -> RootLocus:
        """See :func:`frictionlab.root_locus`."""

    @abstractmethod
    def find_stability_changes(self, parameter: str, bounds: Any) -> tuple[StabilityChange, ...]:
        """See :func:`frictionlab.stability_changes`."""

    @abstractmethod
    def spectra_over(self, box: Mapping[str, tuple[float, float]]) -> SpectraOf:
        """The spectra within ranges of parameters, for :func:`frictionlab.stability_map`."""

    @abstractmethod
    def count_growing(self, parameter: str, value: float) -> int:
        """The number of modes that grow at a value of a parameter."""
