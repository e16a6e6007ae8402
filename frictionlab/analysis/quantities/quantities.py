"""Quantities of a model, numbers with exact gradients; those of an equilibrium; and `fl.sensitivity`.

The quantities of an equilibrium are its coordinates and the growth rates and frequencies of its eigenvalues.
`fl.sensitivity` tells how much each parameter changes a quantity.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from frictionlab.models.model import MovingSystem, automaton_of, values_of
from frictionlab.presentation import Drawable, dataframe, in_units_of, state_unit, text_table
from frictionlab.stability.equilibrium_points.equilibria import equilibrium_problem
from frictionlab.stability.equilibrium_problem import ComplexArray, EquilibriumProblem, check_bounds
from frictionlab.stability.flow import EquilibriumDerivatives
from frictionlab.stability.state_matrices import eigenpair
from frictionlab.validation import abbreviate, check_choice, check_field, check_key, check_limits, check_text

if TYPE_CHECKING:
    from frictionlab.models.model import ModelOrAutomaton

Array = NDArray[np.float64]
LISTED = 5  # parameters listed in the text of a result
DEFECTIVE_PRODUCT = 1e-6  # |l r| below which two eigenvalues coalesce: single ones have no derivative


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

    Called with a model it returns the number, or None where there is none.
    """

    @property
    @abstractmethod
    def label(self) -> str:
        """Name of the quantity, with its unit in SI."""

    def label_of(self, model: ModelOrAutomaton) -> str:
        """The label in the units of a structure."""
        return in_units_of(model, self.label) if self.label.endswith(")") else self.label

    @abstractmethod
    def gradient(self, model: ModelOrAutomaton) -> Gradient:
        """The number and its exact derivatives by all parameters.

        Raises
        ------
        ValueError
            Where there is no such number, or it has no derivative.
        """

    @abstractmethod
    def values(self, model: ModelOrAutomaton, changes: Mapping[str, Array]) -> Array:
        """The numbers (N,) for N values of each parameter in `changes`; NaN where there is none."""

    def __call__(self, model: ModelOrAutomaton) -> float | None:
        value = float(self.values(model, {})[0])
        return None if np.isnan(value) else value

    @property
    def __name__(self) -> str:
        """The name by which studies and their files know it."""
        return repr(self)


@dataclass(frozen=True)
class WithinBounds(Quantity):
    """A quantity that is looked for between two values of a parameter."""

    parameter: str
    bounds: tuple[float, float]

    def __post_init__(self) -> None:
        check_text("parameter", self.parameter, "name a parameter")
        object.__setattr__(self, "bounds", check_limits("bounds", self.bounds, "give (low, high)"))

    def problem(self, model: ModelOrAutomaton) -> tuple[EquilibriumProblem, tuple[float, float]]:
        """The equilibrium of a model as the parameter varies, and the bounds, if it can have these."""
        bounds = check_bounds(model, self.parameter, self.bounds)
        return equilibrium_problem(model, within={self.parameter: bounds}), bounds


@dataclass(frozen=True)
class EquilibriumCoordinate(Quantity):
    """A coordinate of the equilibrium, m or rad; Eq. (18).

    Parameters
    ----------
    name : str
        As "x1".

    Examples
    --------
    >>> import frictionlab as fl
    >>> fl.EquilibriumCoordinate("x")(fl.MassOnBelt(mu_k=0.5, mu_s=1.0))  # mu_k N / k
    0.5
    """

    name: str

    def __post_init__(self) -> None:
        check_text("name", self.name, "name a coordinate")

    @property
    def label(self) -> str:
        return f"{self.name} at equilibrium ({state_unit(self.name)})"

    def values(self, model: ModelOrAutomaton, changes: Mapping[str, Array]) -> Array:
        problem = equilibrium_problem(model)
        return problem.states(changes)[self._index(problem)]

    def gradient(self, model: ModelOrAutomaton) -> Gradient:
        problem = equilibrium_problem(model)
        at = derivatives_at(problem)
        i = self._index(problem)
        return gradient_of(problem, float(at.x[i]), at.state()[i])

    def _index(self, problem: EquilibriumProblem) -> int:
        check_choice("name", self.name, problem.names, "name one of them")
        return problem.names.index(self.name)


@dataclass(frozen=True)
class GrowthRate(Quantity):
    """A growth rate at the equilibrium, 1/s: the largest, or that of one mode.

    Parameters
    ----------
    mode : int or None
        Modes are counted from 0 by ascending frequency; None takes the largest growth rate, whose sign
        decides stability.

    Examples
    --------
    >>> import frictionlab as fl
    >>> fl.GrowthRate()(fl.SliderOnBelt(mu_k=2.0)) > 0
    True
    """

    mode: int | None = None

    def __post_init__(self) -> None:
        _check_mode(self)

    @property
    def label(self) -> str:
        which = "largest growth rate" if self.mode is None else f"growth rate of mode {self.mode}"
        return f"{which} (1/s)"

    def values(self, model: ModelOrAutomaton, changes: Mapping[str, Array]) -> Array:
        return _chosen(equilibrium_problem(model), self.mode, changes).real

    def gradient(self, model: ModelOrAutomaton) -> Gradient:
        problem = equilibrium_problem(model)
        value, slopes = _eigenvalue_gradient(problem, self.mode)
        return Gradient(value.real, {name: slope.real for name, slope in slopes.items()})


@dataclass(frozen=True)
class ModeFrequency(Quantity):
    """The frequency of a mode at the equilibrium, Hz.

    Parameters
    ----------
    mode : int or None
        Counted from 0 by ascending frequency, those of 0 Hz too; None takes the mode with the largest growth
        rate.

    Examples
    --------
    >>> import frictionlab as fl
    >>> round(fl.ModeFrequency(0)(fl.SliderOnBelt(mu_k=1.4)), 2)
    13.51
    """

    mode: int | None = None

    def __post_init__(self) -> None:
        _check_mode(self)

    @property
    def label(self) -> str:
        which = "of the least damped mode" if self.mode is None else f"of mode {self.mode}"
        return f"frequency {which} (Hz)"

    def values(self, model: ModelOrAutomaton, changes: Mapping[str, Array]) -> Array:
        return _chosen(equilibrium_problem(model), self.mode, changes).imag / (2 * np.pi)

    def gradient(self, model: ModelOrAutomaton) -> Gradient:
        problem = equilibrium_problem(model)
        value, slopes = _eigenvalue_gradient(problem, self.mode)
        frequencies = {name: slope.imag / (2 * np.pi) for name, slope in slopes.items()}
        return Gradient(value.imag / (2 * np.pi), frequencies)


def _check_mode(quantity: Any) -> None:
    if quantity.mode is not None:
        check_field(quantity, "mode", integer=True, least=0, cure="count from 0, by ascending frequency")


def gradient_of(problem: EquilibriumProblem, value: float, slopes: Any) -> Gradient:
    """A gradient from derivatives (P,) in the order of the flow's parameters."""
    return Gradient(value, dict(zip(problem.parameter_names, map(float, slopes), strict=True)))


def derivatives_at(problem: EquilibriumProblem, **changes: float) -> EquilibriumDerivatives:
    """The derivatives at the equilibrium that :func:`equilibrium_at` gives."""
    return EquilibriumDerivatives(problem.flow, *equilibrium_at(problem, **changes))


def equilibrium_at(problem: EquilibriumProblem, **changes: float) -> tuple[Array, tuple[float, ...]]:
    """A problem's equilibrium (m,) with some parameters changed, and the values of all.

    Raises
    ------
    ValueError
        Where there is none.
    """
    values, count = problem.at(changes)
    values = tuple(float(np.ravel(v)[0]) for v in values)
    x = problem.solve(values, count)[:, 0]
    if np.isnan(x).any():
        raise ValueError(
            f"{type(problem.model).__name__} must have an equilibrium in sliding, got none: change its "
            "parameters"
        )
    return x, values


def _chosen(problem: EquilibriumProblem, mode: int | None, changes: Mapping[str, Array]) -> Any:
    """One eigenvalue (N,) of each model, with Im >= 0."""
    return _of_mode(problem.spectra(changes), mode)


def _of_mode(spectra: ComplexArray, mode: int | None) -> ComplexArray:
    """The eigenvalue (N,) of a mode in each of N spectra (N, m), which are sorted by growth rate."""
    if mode is None:
        return spectra[:, 0].real + 1j * np.abs(spectra[:, 0].imag)
    count = (spectra.shape[1] + 1) // 2
    if mode >= count:
        raise ValueError(f"mode must be below {count}, the number of modes, got {mode}: count from 0")
    order = np.lexsort((spectra.imag, spectra.real, np.abs(spectra.imag)))
    pair = np.take_along_axis(spectra, order, axis=1)[:, min(2 * mode, spectra.shape[1] - 1)]
    return pair.real + 1j * np.abs(pair.imag)


def _eigenvalue_gradient(
    problem: EquilibriumProblem, mode: int | None
) -> tuple[complex, Mapping[str, complex]]:
    at = derivatives_at(problem)
    value = complex(_of_mode(problem.spectra({}), mode)[0])
    pair = eigenpair(at.matrix, value)
    if abs(pair.product) < DEFECTIVE_PRODUCT:
        raise ValueError(
            f"the eigenvalue must be simple to have derivatives, got two that coalesce at {value:.6g} 1/s: "
            "change a parameter a little"
        )
    slopes = at.bilinear(pair.left, pair.right) / pair.product
    further = problem.model.eigenvalue_derivatives(value) if isinstance(problem.model, MovingSystem) else {}
    return value, {**dict(zip(problem.parameter_names, map(complex, slopes), strict=True)), **further}


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
        Sorted by descending |normalised|.
    at : array (P,)
        Values of the parameters.
    derivatives : array (P,)
        d(quantity)/d(parameter), in their units; NaN where there is none, as for damping where undamped modes
        coalesce.
    """

    drawn_by = "plot_sensitivity"

    model: ModelOrAutomaton
    quantity: str
    value: float
    parameters: tuple[str, ...]
    at: Array
    derivatives: Array

    @property
    def normalised(self) -> Array:
        """p/Q dQ/dp (P,): percent of change of the quantity for a percent of the parameter.

        It is 0 for a parameter that is zero.  Where the quantity itself is zero, p dQ/dp is given instead.
        """
        return self.at * self.derivatives / (self.value or 1.0)

    def __getitem__(self, parameter: str) -> float:
        """d(quantity)/d(parameter)."""
        check_key("parameter", parameter, self.parameters)
        return float(self.derivatives[self.parameters.index(parameter)])

    @property
    def left_out(self) -> tuple[str, ...]:
        """Parameters by which no derivative is known, as of a structure those on which M depends: a motion
        has none by them."""
        return tuple(name for name in values_of(self.model) if name not in self.parameters)

    def __repr__(self) -> str:
        head = f"Sensitivity({self.quantity} = {self.value:.6g}), percent for a percent:"
        shares = sorted(zip(self.parameters, self.normalised), key=lambda row: -abs(np.nan_to_num(row[1])))
        rows = [f"  {name} {share:+.4g}" for name, share in shares[:LISTED]]
        more = len(shares) - LISTED
        rows += [f"  and {more} more"] if more > 0 else []
        rows += [f"  left out, without derivatives: {', '.join(self.left_out)}"] if self.left_out else []
        return text_table([head, *rows])

    def to_dataframe(self) -> Any:
        """One row for each parameter (needs the extra ``data``)."""
        columns = {"value": self.at, "derivative": self.derivatives, "normalised": self.normalised}
        return dataframe(columns, {"parameter": list(self.parameters)}, {})


def sensitivity(model: ModelOrAutomaton, quantity: Quantity) -> Sensitivity:
    """Exact derivatives of a quantity by all parameters of a model.

    No finite differences are used: the flow's formulas are differentiated, and linear systems give the
    derivatives of equilibria, eigenvalues and critical values,

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
        Where `quantity` is no :class:`Quantity`, or `model` is no model.
    ValueError
        Where the quantity does not exist, or has no derivative.

    Notes
    -----
    A. P. Seyranian and A. A. Mailybaev, "Multiparameter Stability Theory with Mechanical Applications", World
    Scientific, 2003, for simple eigenvalues and for two that coalesce.

    Examples
    --------
    >>> import frictionlab as fl
    >>> sensitivity = fl.sensitivity(fl.SliderOnBelt(), fl.CriticalValue("mu_k", (0, 4)))
    >>> sensitivity["F"] < 0  # a larger preload lowers the onset
    True
    """
    if not isinstance(quantity, Quantity):
        raise TypeError(
            f"quantity must be one such as fl.CriticalValue('mu_k', (0, 4)), got {abbreviate(quantity)}: "
            "its derivatives have to be known"
        )
    values = {**automaton_of(model).values, **values_of(model)}
    gradient = quantity.gradient(model)
    names = tuple(name for name in values if name in gradient.derivatives)
    at = np.array([values[name] for name in names], dtype=float)
    slopes = np.array([gradient.derivatives[name] for name in names], dtype=float)
    order = np.argsort(-np.abs(np.nan_to_num(at * slopes)), kind="stable")
    in_order = tuple(names[i] for i in order)
    return Sensitivity(model, quantity.label_of(model), gradient.value, in_order, at[order], slopes[order])
