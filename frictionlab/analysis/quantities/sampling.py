"""Points of a space of parameters with given distributions, in groups that are independent of each other.

Sobol points fill the unit cube evenly; each group is scrambled anew, so that the spread of the groups' means
is an error that can be trusted, which a single sequence does not give.  A. B. Owen, "Scrambled net variance
for integrals of smooth functions", Annals of Statistics 25, 1997.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionlab.analysis.quantities.sensitivity import Quantity
from frictionlab.stability.equilibrium_problem import check_parameter
from frictionlab.validation import check_mapping

Array = NDArray[np.float64]
BLOCK = 2500  # points that one task takes at once
GROUPS = 8


def check_distributions(model: Any, distributions: Any) -> dict[str, Any]:
    """Distributions by parameter, each with a quantile function.

    Raises
    ------
    TypeError
        For what is no mapping, or has no `ppf`.
    """
    cure = 'give each a frozen one of scipy.stats, such as {"mu_k": scipy.stats.norm(0.4, 0.05)}'
    check_mapping("distributions", distributions, cure)
    if not distributions:
        raise ValueError(f"distributions must hold one parameter at least, got none: {cure}")
    for name, distribution in distributions.items():
        check_parameter(model, name, [])
        if not callable(getattr(distribution, "ppf", None)):
            raise TypeError(
                f"distributions[{name!r}] must have a quantile function ppf, got {distribution!r}: {cure}"
            )
    return dict(distributions)


def sobol_points(dimensions: int, count: int, seed: int) -> Array:
    """Scrambled points (count, dimensions) of the open unit cube; their number has to be a power of two."""
    from scipy.stats import qmc

    return qmc.Sobol(dimensions, rng=np.random.default_rng(seed)).random(count)


def quantiles(model: Any, distributions: Mapping[str, Any], points: Array) -> Array:
    """The values of parameters (N, d) at points (N, d) of the unit cube.

    Raises
    ------
    ValueError
        For a value that breaks the parameter's rule.
    """
    columns = [d.ppf(column) for d, column in zip(distributions.values(), points.T, strict=True)]
    for name, column in zip(distributions, columns):
        try:
            check_parameter(model, name, [float(column.min()), float(column.max())])
        except ValueError as error:
            raise ValueError(
                f"distributions[{name!r}] must keep to the parameter's rule: {error}; "
                "or cut the distribution off"
            ) from error
    return np.stack(columns, axis=1)


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
