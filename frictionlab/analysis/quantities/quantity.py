"""What a quantity of a model is: a number, its exact gradient, and its values for many models at once."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Gradient:
    """A quantity and its derivatives.

    Parameters
    ----------
    value : float
    derivatives : mapping of str to float
        By parameter, in units of the quantity over those of the parameter.
    """

    value: float
    derivatives: Mapping[str, float]


class Quantity(ABC):
    """A number that a model determines.

    Called with a model it gives the number; None where there is none.
    """

    @property
    @abstractmethod
    def label(self) -> str:
        """What it is, with its unit."""

    @abstractmethod
    def gradient(self, model: Any) -> Gradient:
        """The number and its exact derivatives by all parameters.

        Raises
        ------
        ValueError
            Where there is no such number, or it has no derivative.
        """

    @abstractmethod
    def values(self, model: Any, changes: Mapping[str, Array]) -> Array:
        """The numbers (N,) for N values of some parameters; NaN where there is none."""

    def __call__(self, model: Any) -> float | None:
        value = float(self.values(model, {})[0])
        return None if np.isnan(value) else value

    @property
    def __name__(self) -> str:
        """What studies and their files call it."""
        return repr(self)
