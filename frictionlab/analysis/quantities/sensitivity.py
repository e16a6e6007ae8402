"""What a quantity of a model is, a number with its exact gradient, and `fl.sensitivity`: how much each
parameter moves it.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionlab.models.model import automaton_of
from frictionlab.presentation import Drawable, dataframe, text_table

Array = NDArray[np.float64]
BLOCK = 2500  # points that one task takes at once


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


LISTED = 5  # parameters in the text of a result


def evaluation_tasks(
    model: Any, quantity: Callable[[Any], Any], names: Sequence[str], values: Array
) -> tuple[list[tuple[Any, ...]], list[str]]:
    """Tasks of :func:`evaluate` for some values (N, d) of parameters, and names for them."""
    size = BLOCK if isinstance(quantity, Quantity) else 1
    starts = range(0, len(values), size)
    tasks = [(model, quantity, tuple(names), values[i : i + size]) for i in starts]
    return tasks, [f"the point {i}" if size == 1 else f"one of the points from {i} on" for i in starts]


def evaluate(
    model: Any, quantity: Callable[[Any], Any], names: tuple[str, ...], values: Array
) -> list[float | None]:
    """A quantity (N,) at values (N, d) of some parameters; None where there is none."""
    if isinstance(quantity, Quantity):
        found = quantity.values(model, dict(zip(names, values.T)))
        return [None if np.isnan(number) else float(number) for number in found]
    numbers = (quantity(model.replace(**dict(zip(names, map(float, point))))) for point in values)
    return [None if number is None or np.isnan(number) else float(number) for number in numbers]


@dataclass(frozen=True, eq=False)
class Sensitivity(Drawable):
    """Derivatives of a quantity by all parameters, the most influential first.

    Parameters
    ----------
    model : Model or HybridAutomaton
    quantity : str
        Its label.
    value : float
    parameters : tuple of str
        By descending |normalised|.
    at : array (P,)
        Values of the parameters.
    derivatives : array (P,)
        d(quantity)/d(parameter), in their units; NaN where there is none, as by damping where undamped modes
        coalesce.
    """

    drawn_by = "plot_sensitivity"

    model: Any
    quantity: str
    value: float
    parameters: tuple[str, ...]
    at: Array
    derivatives: Array

    @property
    def normalised(self) -> Array:
        """p/Q dQ/dp (P,): percent of change of the quantity for a percent of the parameter.

        0 for a parameter that is zero; where the quantity itself is zero p dQ/dp.
        """
        return self.at * self.derivatives / (self.value or 1.0)

    def __getitem__(self, parameter: str) -> float:
        """d(quantity)/d(parameter)."""
        if parameter not in self.parameters:
            raise KeyError(f"no parameter {parameter!r}: name one of {', '.join(self.parameters)}")
        return float(self.derivatives[self.parameters.index(parameter)])

    def __repr__(self) -> str:
        head = f"Sensitivity({self.quantity} = {self.value:.6g}), percent for a percent:"
        shares = sorted(zip(self.parameters, self.normalised), key=lambda row: -abs(np.nan_to_num(row[1])))
        rows = [f"  {name} {share:+.4g}" for name, share in shares[:LISTED]]
        more = len(shares) - LISTED
        return text_table([head, *rows, *([f"  and {more} more"] if more > 0 else [])])

    def to_dataframe(self) -> Any:
        """One row for each parameter (needs the extra ``data``)."""
        columns = {"value": self.at, "derivative": self.derivatives, "normalised": self.normalised}
        return dataframe(columns, {"parameter": list(self.parameters)}, {})


def sensitivity(model: Any, quantity: Quantity) -> Sensitivity:
    """Exact derivatives of a quantity by all parameters of a model.

    No differences are taken: the equations are differentiated by sympy, and linear systems give how
    equilibria, eigenvalues and critical values follow,

        dx/dp = -A^-1 f_p,    d(lambda)/dp = l (f_xp + f_xx dx/dp) r / l r,
        d(mu_c)/dp = -Re d(lambda)/dp / Re d(lambda)/d(mu).

    The cost hardly depends on the number of parameters.

    Parameters
    ----------
    model : Model or HybridAutomaton
    quantity : Quantity
        :class:`CriticalValue`, :class:`CriticalFrequency`, :class:`FoldValue`, :class:`GrowthRate`,
        :class:`ModeFrequency` or :class:`EquilibriumCoordinate`; of a periodic orbit :class:`OrbitPeriod`,
        :class:`OrbitAmplitude` or :class:`OrbitIntensity`.

    Returns
    -------
    Sensitivity

    Raises
    ------
    TypeError
        For what is no quantity or no model.
    ValueError
        Where the quantity does not exist, or has no derivative.

    Notes
    -----
    A. P. Seyranian and A. A. Mailybaev, "Multiparameter Stability Theory with Mechanical Applications", World
    Scientific, 2003, for simple eigenvalues and for two that coalesce.

    Examples
    --------
    >>> import frictionlab as fl
    >>> found = fl.sensitivity(fl.SliderOnBelt(), fl.CriticalValue("mu_k", (0, 4)))
    >>> found["F"] < 0  # a larger preload lowers the onset
    True
    """
    if not isinstance(quantity, Quantity):
        raise TypeError(
            f"quantity must be one such as fl.CriticalValue('mu_k', (0, 4)), got {quantity!r}: "
            "its derivatives have to be known"
        )
    known = {symbol.name: value for symbol, value in automaton_of(model).parameters.items()}
    found = quantity.gradient(model)
    names = tuple(name for name in known if name in found.derivatives)
    at = np.array([known[name] for name in names], dtype=float)
    slopes = np.array([found.derivatives[name] for name in names], dtype=float)
    order = np.argsort(-np.abs(np.nan_to_num(at * slopes)), kind="stable")
    chosen = tuple(names[i] for i in order)
    return Sensitivity(model, quantity.label, found.value, chosen, at[order], slopes[order])
