"""`fl.optimum`: the least or largest value of a quantity under bounds and constraints, by exact gradients."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from frictionlab.analysis.quantities.quantities import Gradient, Quantity
from frictionlab.models.model import (
    ModelOrAutomaton,
    check_parameter_name,
    check_varied,
    require_model_or_automaton,
    values_of,
)
from frictionlab.presentation import Drawable, text_table
from frictionlab.stability.equilibrium_problem import check_bounds, check_masses_of
from frictionlab.validation import (
    abbreviate,
    check_choice,
    check_key,
    check_mapping,
    check_number,
    check_sequence,
    check_text,
)

Array = NDArray[np.float64]
MAX_STEPS = 200
STEP_TOL = 1e-12
ACTIVE_RTOL = 1e-6  # a constraint or bound holds with equality if met within this share of its size
LIMIT_CURE = "give (quantity, low, high)"


@dataclass(frozen=True)
class ParameterValue(Quantity):
    """A parameter itself, to be minimised, maximised or kept within limits.

    Parameters
    ----------
    name : str

    Examples
    --------
    >>> import frictionlab as fl
    >>> fl.ParameterValue("k1")(fl.SliderOnBelt())
    10000.0
    """

    name: str

    def __post_init__(self) -> None:
        check_text("name", self.name, "name a parameter")

    @property
    def label(self) -> str:
        return self.name

    def values(self, model: ModelOrAutomaton, changes: Mapping[str, Any]) -> Array:
        check_parameter_name(model, self.name)
        return np.atleast_1d(np.asarray(changes.get(self.name, values_of(model)[self.name]), dtype=float))

    def gradient(self, model: ModelOrAutomaton) -> Gradient:
        check_parameter_name(model, self.name)
        return Gradient(float(values_of(model)[self.name]), {self.name: 1.0})


class Limit(NamedTuple):
    """A constraint: a quantity has to stay between two numbers."""

    quantity: Quantity
    low: float = -np.inf
    high: float = np.inf


@dataclass(frozen=True, eq=False)
class Optimum(Drawable):
    """The least or largest value of a quantity, and where it is taken.

    Parameters
    ----------
    model : Model or HybridAutomaton
        With the best values of the parameters.
    quantity : str
    value : float
    parameters : tuple of str
    at : array (P,)
        Their best values.
    first : array (P,)
        Their values where the search began.
    bounds : array (P, 2)
    active : tuple of str
        Bounds and constraints that hold with equality: without them the value could be better.
    evaluations : int
        How often the search asked for the quantity.
    message : str
    """

    drawn_by = "plot_optimum"

    model: ModelOrAutomaton
    quantity: str
    value: float
    parameters: tuple[str, ...]
    at: Array
    first: Array
    bounds: Array
    active: tuple[str, ...]
    evaluations: int
    message: str

    def __getitem__(self, parameter: str) -> float:
        """The best value of a parameter."""
        check_key("parameter", parameter, self.parameters)
        return float(self.at[self.parameters.index(parameter)])

    def __repr__(self) -> str:
        rows = [f"  {name} = {value:.6g}" for name, value in zip(self.parameters, self.at)]
        held = f"  held by {', '.join(self.active)}" if self.active else "  no bound or constraint is active"
        return text_table([f"Optimum({self.quantity} = {self.value:.6g}):", *rows, held])


def optimum(
    model: ModelOrAutomaton,
    quantity: Quantity,
    bounds: Mapping[str, tuple[float, float]],
    constraints: Sequence[tuple[Any, ...]] = (),
    *,
    goal: str = "least",
) -> Optimum:
    """The least or largest value of a quantity over parameters within bounds, from the model's values on.

    Sequential quadratic programming (SLSQP) with the exact gradients of :func:`sensitivity`, in parameters
    scaled by their bounds.  The result is a local optimum: begin at other values to look for better ones.

    Parameters
    ----------
    model : Model or HybridAutomaton
        Where the search begins.
    quantity : Quantity
        One with derivatives, such as :class:`GrowthRate`, :class:`CriticalValue`, :class:`OrbitAmplitude`, or
        :class:`ParameterValue`.
    bounds : mapping of str to (float, float)
        The parameters that may change, and their limits.
    constraints : sequence of (Quantity, low, high)
        Quantities that have to stay between two numbers; -inf or inf leaves a side open.
    goal : "least" or "largest"

    Returns
    -------
    Optimum

    Raises
    ------
    TypeError
        Where `model` is no model, or a quantity is no :class:`Quantity`.
    ValueError
        For bad bounds; where a quantity does not exist or has no derivative; where the search finds no values
        that satisfy the constraints.

    Examples
    --------
    The least damping that keeps coupled modes quiet:

    >>> import frictionlab as fl
    >>> quiet, damping = (fl.GrowthRate(), -float("inf"), 0.0), fl.ParameterValue("c")
    >>> best = fl.optimum(fl.ModeCoupling(mu_k=0.53, c=0.4), damping, {"c": (0.01, 1.0)}, [quiet])
    >>> best.active
    ('largest growth rate (1/s)',)
    """
    problem = _check(model, quantity, bounds, constraints, goal)
    sign = 1.0 if goal == "least" else -1.0
    size = abs(problem.gradient(quantity, problem.first)[0]) or 1.0
    sizes = [_size(problem, limit) for limit in problem.limits]
    rows = [
        {"type": "ineq", "fun": problem.margin(limit, side, s), "jac": problem.margin_slopes(limit, side, s)}
        for limit, s in zip(problem.limits, sizes)
        for side in (-1.0, 1.0)
        if np.isfinite(limit.low if side < 0 else limit.high)
    ]
    minimum: Any = minimize(
        lambda u: sign * problem.gradient(quantity, u)[0] / size,
        problem.first,
        jac=lambda u: sign * problem.gradient(quantity, u)[1] / size,
        bounds=[(0.0, 1.0)] * len(problem.names),
        constraints=rows,
        method="SLSQP",
        options={"maxiter": MAX_STEPS, "ftol": STEP_TOL},
    )
    u = np.clip(minimum.x, 0.0, 1.0)
    if rows and min(row["fun"](u) for row in rows) < -ACTIVE_RTOL:
        raise ValueError(
            f"the constraints must be met somewhere within the bounds, got none near by ({minimum.message}): "
            "begin at values that keep to them, or widen the bounds"
        )
    return Optimum(
        model=problem.at(u),
        quantity=quantity.label_of(problem.model),
        value=float(problem.gradient(quantity, u)[0]),
        parameters=problem.names,
        at=problem.values(u),
        first=problem.values(problem.first),
        bounds=np.column_stack([problem.low, problem.high]),
        active=_active(problem, u, sizes),
        evaluations=int(minimum.nfev),
        message=str(minimum.message),
    )


class _ScaledProblem:
    """An optimisation problem in scaled parameters u (P,), 0 at their lower and 1 at their upper bounds."""

    def __init__(self, model: ModelOrAutomaton, bounds: Mapping[str, Any], limits: Sequence[Limit]) -> None:
        self.model, self.names, self.limits = model, tuple(bounds), tuple(limits)
        for name in self.names:
            check_varied(model, name)
        self.low, self.high = np.array([*bounds.values()], dtype=float).T
        here = np.array([values_of(model)[name] for name in self.names], dtype=float)
        self.first = np.clip((here - self.low) / (self.high - self.low), 0.0, 1.0)
        self._known: dict[Any, tuple[float, Array]] = {}

    def values(self, u: Array) -> Array:
        """The values (P,) of the parameters at u."""
        return self.low + u * (self.high - self.low)

    def at(self, u: Array) -> Any:
        """The model with these values."""
        return self.model.replace(**dict(zip(self.names, map(float, self.values(u)))))

    def gradient(self, quantity: Quantity, u: Array) -> tuple[float, Array]:
        """A quantity and its derivatives (P,) by u; cached, as the search asks for each several times."""
        key = (id(quantity), np.clip(u, 0.0, 1.0).tobytes())
        if key not in self._known:
            gradient = quantity.gradient(self.at(np.clip(u, 0.0, 1.0)))
            slopes = np.array([gradient.derivatives.get(name, 0.0) for name in self.names])
            self._known[key] = gradient.value, slopes * (self.high - self.low)
        return self._known[key]

    def margin(self, limit: Limit, side: float, size: float) -> Any:
        """A function of u: how far a quantity is inside one of its limits, divided by `size`."""
        end = limit.low if side < 0 else limit.high
        return lambda u: side * (end - self.gradient(limit.quantity, u)[0]) / size

    def margin_slopes(self, limit: Limit, side: float, size: float) -> Any:
        """A function of u: the derivatives (P,) of that margin."""
        return lambda u: -side * self.gradient(limit.quantity, u)[1] / size


def _check(
    model: ModelOrAutomaton, quantity: Any, bounds: Any, constraints: Any, goal: Any
) -> _ScaledProblem:
    require_model_or_automaton(model, "write optimum(model, quantity, bounds), the model made")
    check_choice("goal", goal, ("least", "largest"), "say which")
    check_mapping("bounds", bounds, 'give limits by parameter, such as {"c1": (0.0, 10.0)}')
    if not bounds:
        raise ValueError("bounds must hold one parameter at least, got none: name those that may change")
    ranges = {name: check_bounds(model, name, ends) for name, ends in bounds.items()}
    check_masses_of(model, ranges)
    limits = [_limit(one) for one in check_sequence("constraints", constraints, LIMIT_CURE)]
    for one in (quantity, *(limit.quantity for limit in limits)):
        if not isinstance(one, Quantity):
            raise TypeError(
                f"quantity must be one such as fl.GrowthRate(), "
                f"got {abbreviate(one)}: its derivatives have to be known"
            )
    return _ScaledProblem(model, ranges, limits)


def _limit(given: Any) -> Limit:
    """A constraint: a quantity and its limits, of which the upper one, or both, may be left out."""
    parts = check_sequence("a constraint", given, LIMIT_CURE)
    if not 1 <= len(parts) <= 3:
        raise ValueError(f"a constraint must have one to three parts, got {abbreviate(given)}: {LIMIT_CURE}")
    limit = Limit(*parts)
    for end in limit[1:]:
        if not (isinstance(end, float) and np.isinf(end)):
            check_number("a limit of a constraint", end, cure=LIMIT_CURE)
    return limit


def _size(problem: _ScaledProblem, limit: Limit) -> float:
    """The scale of a constraint: the largest of its limits, and of its value and slopes at the start."""
    value, slopes = problem.gradient(limit.quantity, problem.first)
    ends = [abs(end) for end in (limit.low, limit.high) if np.isfinite(end)]
    return max(abs(value), np.abs(slopes).max(), *ends) or 1.0


def _active(problem: _ScaledProblem, u: Array, sizes: Sequence[float]) -> tuple[str, ...]:
    active = [
        f"{name} {'at least' if v < 0.5 else 'at most'} {end:g}"
        for name, v, end in zip(problem.names, u, np.where(u < 0.5, problem.low, problem.high))
        if min(v, 1.0 - v) < ACTIVE_RTOL
    ]
    for limit, size in zip(problem.limits, sizes):
        value = problem.gradient(limit.quantity, u)[0]
        if min(abs(value - limit.low), abs(value - limit.high)) < ACTIVE_RTOL * size:
            active.append(limit.quantity.label_of(problem.model))
    return tuple(active)
