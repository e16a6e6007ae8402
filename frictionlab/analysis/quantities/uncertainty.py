"""`fl.uncertainty` and `fl.sobol_indices`: a quantity of a model whose parameters are not known exactly.

Sobol points fill the unit cube evenly.  Each of eight groups of them is scrambled independently, so that the
scatter of the groups gives a standard error, which a single sequence does not.  A. B. Owen, "Scrambled net
variance for integrals of smooth functions", Annals of Statistics 25, 1997.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Unpack

import numpy as np
from numpy.typing import NDArray

from frictionlab.analysis.options import Execution, ExecutionKeywords, settings_of
from frictionlab.analysis.quantities.quantities import Quantity
from frictionlab.analysis.sweeps.function_name import function_name, own_name
from frictionlab.analysis.sweeps.journal import Journal
from frictionlab.analysis.sweeps.sweep import check_function
from frictionlab.models.model import (
    ModelOrAutomaton,
    check_parameter_name,
    data_of,
    require_model_or_automaton,
)
from frictionlab.presentation import Drawable, dataframe, text_table
from frictionlab.stability.equilibrium_problem import check_masses_of, check_parameter
from frictionlab.validation import abbreviate, check_mapping, check_number, explains_keywords, seed_of

Array = NDArray[np.float64]
GROUPS = 8
BLOCK = 2500  # points that one study computes together
MOST = 1 << 30  # points, of which no more are distinct


def check_distributions(model: ModelOrAutomaton, distributions: Any) -> dict[str, Any]:
    """Distributions by parameter, each with a quantile function.

    Raises
    ------
    TypeError
        Where `distributions` is no mapping, or one of them has no `ppf`.
    """
    cure = 'give each a frozen one of scipy.stats, such as {"mu_k": scipy.stats.norm(0.4, 0.05)}'
    check_mapping("distributions", distributions, cure)
    if not distributions:
        raise ValueError(f"distributions must hold one parameter at least, got none: {cure}")
    for name, distribution in distributions.items():
        check_parameter_name(model, name)
        if not callable(getattr(distribution, "ppf", None)):
            raise TypeError(
                f"distributions[{abbreviate(name)}] must have a quantile function ppf, "
                f"got {abbreviate(distribution)}: {cure}"
            )
    return dict(distributions)


def sobol_points(dimensions: int, count: int, seed: int) -> Array:
    """Scrambled points (count, dimensions) of the open unit cube; `count` has to be a power of two."""
    from scipy.stats import qmc

    return qmc.Sobol(dimensions, rng=np.random.default_rng(seed)).random(count)


def quantiles(model: ModelOrAutomaton, distributions: Mapping[str, Any], points: Array) -> Array:
    """The values of parameters (N, d) at points (N, d) of the unit cube.

    Raises
    ------
    ValueError
        For a value that breaks the parameter's rule.
    """
    columns = [d.ppf(column) for d, column in zip(distributions.values(), points.T, strict=True)]
    for name, column in zip(distributions, columns):
        try:
            check_parameter(model, name, ends := [float(column.min()), float(column.max())])
            check_masses_of(model, {name: ends})
        except ValueError as error:
            raise ValueError(
                f"distributions[{abbreviate(name)}] must keep to the parameter's rule: {error}; "
                "or cut the distribution off"
            ) from error
    return np.stack(columns, axis=1)


class Estimate(NamedTuple):
    """A number with its standard error."""

    value: float
    error: float

    def __str__(self) -> str:
        return f"{self.value:.4g} ± {self.error:.2g}"


@dataclass(frozen=True, eq=False)
class Uncertainty(Drawable):
    """The distribution of a quantity.

    Parameters
    ----------
    model : Model or HybridAutomaton
    quantity : str
    parameters : tuple of str
    points : array (N, d)
        Values of the parameters.
    values : array (N,)
        The quantity; NaN where there is none, as where stability is never lost.
    groups : int
        Number of independent groups, stored one after the other, whose scatter gives the standard errors.
    """

    drawn_by = "plot_uncertainty"

    model: ModelOrAutomaton
    quantity: str
    parameters: tuple[str, ...]
    points: Array
    values: Array
    groups: int

    def __repr__(self) -> str:
        low, middle, high = (self.quantile(q) for q in (0.025, 0.5, 0.975))
        none = int(np.isnan(self.values).sum())
        lines = [
            f"Uncertainty({self.quantity}, {len(self.values)} points of {len(self.parameters)} parameters"
            f"{f', {none} without' if none else ''}):",
            f"  mean {self.mean}, median {middle:.4g}, 95 % from {low:.4g} to {high:.4g}",
        ]
        return text_table(lines)

    @property
    def mean(self) -> Estimate:
        """Mean of the values that exist."""
        return self._estimate(np.nanmean)

    @property
    def standard_deviation(self) -> Estimate:
        """Standard deviation of the values that exist."""
        return self._estimate(lambda values: float(np.nanstd(values)))

    def probability(self, *, below: float | None = None, above: float | None = None) -> Estimate:
        """Probability that the quantity is below or above a number; where it does not exist it is neither.

        The probability of instability is that of a positive growth rate, ``probability(above=0)``, or of a
        critical value below the parameter's actual value, ``probability(below=mu_k)``.

        Parameters
        ----------
        below, above : float or None
            At least one of them; with both, the probability of values between `above` and `below`.
        """
        if below is None and above is None:
            raise ValueError("below or above must be given, got neither: write probability(above=0.0)")
        cure = "give a value of the quantity, or leave it out"
        low = -np.inf if above is None else check_number("above", above, cure=cure)
        high = np.inf if below is None else check_number("below", below, cure=cure)
        return self._estimate(lambda values: float(((values > low) & (values < high)).mean()))

    def quantile(self, share: float) -> float:
        """The number below which the quantity is with this probability; inf if it too often does not exist.

        Of a critical value ``quantile(0.05)`` is the one at which 95 percent of the systems are stable.

        Parameters
        ----------
        share : float
            From 0 to 1.
        """
        check_number("share", share, least=0.0, most=1.0, cure="0.05 is the lowest of twenty")
        return float(np.quantile(np.where(np.isnan(self.values), np.inf, self.values), share, method="lower"))

    def to_dataframe(self) -> Any:
        """One row for each point, with the parameters and the quantity (needs the extra ``data``)."""
        columns = {**dict(zip(self.parameters, self.points.T)), self.quantity: self.values}
        return dataframe(columns, {"point": np.arange(len(self.values))}, {})

    def _estimate(self, statistic: Callable[[Array], Any]) -> Estimate:
        parts = [part for part in self.values.reshape(self.groups, -1) if not np.isnan(part).all()]
        each = np.array([statistic(part) for part in parts])
        error = each.std(ddof=1) / np.sqrt(len(each)) if len(each) > 1 else np.nan
        return Estimate(float(statistic(self.values)), float(error))


@explains_keywords
def uncertainty(
    model: ModelOrAutomaton,
    quantity: Quantity | Callable[[Any], Any],
    distributions: Mapping[str, Any],
    *,
    n: int = 1024,
    rng: int | np.random.Generator | None = 0,
    **keywords: Unpack[ExecutionKeywords],
) -> Uncertainty:
    """The distribution of a quantity when parameters have distributions.

    It is evaluated at scrambled Sobol points in eight independent groups, whose scatter gives the standard
    errors.  Quantities of linear stability are fast: ten thousand critical values take seconds.

    Parameters
    ----------
    model : Model or HybridAutomaton
    quantity : Quantity or callable
        Such as :class:`CriticalValue`; or a function of a model that returns a number, or None where there is
        none.
    distributions : mapping of str to distribution
        Frozen distributions of ``scipy.stats``; the parameters are independent.
    n : int
        Number of points, a power of two, 16 at least.
    rng : int, Generator or None
        Seed of the random numbers, a generator that draws one, or None for others each time.  A file of
        `resume` wants an integer.
    **keywords
        As for :func:`sweep`: ``workers=2``.

    Returns
    -------
    Uncertainty

    Raises
    ------
    TypeError
        Where an argument is no model, function or distribution, or a keyword is unknown.
    ValueError
        For an unknown parameter, values that break its rule, or an `n` that is no power of two.
    OSError, RuntimeError, KeyboardInterrupt
        As :func:`sweep`.

    Examples
    --------
    >>> import frictionlab as fl
    >>> from scipy import stats
    >>> friction = {"mu_k": stats.norm(1.5, 0.1), "F": stats.uniform(150, 100)}
    >>> uncertainty = fl.uncertainty(fl.SliderOnBelt(), fl.GrowthRate(), friction, n=256, progress=False)
    >>> 0 < uncertainty.probability(above=0).value < 1
    True
    """
    study = _check_study(model, quantity, distributions, n, rng, least=2 * GROUPS)
    n, seed = study.n, study.seed
    seeds = range(seed * GROUPS, (seed + 1) * GROUPS)
    points = np.concatenate([sobol_points(len(study.distributions), n // GROUPS, s) for s in seeds])
    (how,) = settings_of("uncertainty", keywords, Execution)
    values = quantiles(model, study.distributions, points)
    numbers = _evaluated(study, values, how, "uncertainty")
    return Uncertainty(model, study.label, tuple(study.distributions), values, numbers, GROUPS)


@dataclass(frozen=True, eq=False)
class SobolIndices(Drawable):
    """Shares of the variance of a quantity that are due to each parameter.

    Parameters
    ----------
    model : Model or HybridAutomaton
    quantity : str
    parameters : tuple of str
    first_order : array (d,)
        By the parameter alone.
    total_order : array (d,)
        With all its interactions.
    first_errors, total_errors : array (d,)
        Standard errors, by bootstrap.
    """

    drawn_by = "plot_sobol_indices"

    model: ModelOrAutomaton
    quantity: str
    parameters: tuple[str, ...]
    first_order: Array
    total_order: Array
    first_errors: Array
    total_errors: Array

    def __repr__(self) -> str:
        order = np.argsort(-np.nan_to_num(self.total_order), kind="stable")
        rows = [
            f"  {self.parameters[i]}: {self.first_order[i]:.3f} ± {self.first_errors[i]:.2g} alone, "
            f"{self.total_order[i]:.3f} ± {self.total_errors[i]:.2g} in all"
            for i in order
        ]
        return text_table([f"SobolIndices({self.quantity}):", *rows], most=6)

    def to_dataframe(self) -> Any:
        """One row for each parameter (needs the extra ``data``)."""
        names = ("first_order", "first_errors", "total_order", "total_errors")
        columns = {name: getattr(self, name) for name in names}
        return dataframe(columns, {"parameter": list(self.parameters)}, {})


@explains_keywords
def sobol_indices(
    model: ModelOrAutomaton,
    quantity: Quantity | Callable[[Any], Any],
    distributions: Mapping[str, Any],
    *,
    n: int = 1024,
    rng: int | np.random.Generator | None = 0,
    **keywords: Unpack[ExecutionKeywords],
) -> SobolIndices:
    """How much each parameter's uncertainty matters: variance-based sensitivity indices.

    .. math:: S_i = \\frac{V[E[Q | p_i]]}{V[Q]}, \\qquad S_{Ti} = 1 - \\frac{V[E[Q | p_{\\sim i}]]}{V[Q]}

    They are computed by :func:`scipy.stats.sobol_indices` with the estimators of Saltelli et al., Computer
    Physics Communications 181, 2010.

    Parameters
    ----------
    model, quantity, distributions, rng, **keywords
        As for :func:`uncertainty`.
    n : int
        A power of two; the quantity is computed n (d + 2) times for d parameters.

    Returns
    -------
    SobolIndices

    Raises
    ------
    ValueError, TypeError, OSError, RuntimeError, KeyboardInterrupt
        As :func:`uncertainty`; ValueError also where the quantity does not exist at some points.

    Examples
    --------
    >>> import frictionlab as fl
    >>> from scipy import stats
    >>> loads = {"F": stats.uniform(150, 100), "k2": stats.uniform(4e3, 2e3)}
    >>> height = fl.EquilibriumCoordinate("y1")
    >>> indices = fl.sobol_indices(fl.SliderOnBelt(), height, loads, n=64, progress=False)
    >>> indices.parameters[indices.total_order.argmax()]
    'F'
    """
    study = _check_study(model, quantity, distributions, n, rng, least=8)
    (how,) = settings_of("sobol_indices", keywords, Execution)
    d = len(study.distributions)
    both = sobol_points(2 * d, study.n, study.seed)
    a, b = both[:, :d], both[:, d:]
    mixed = [np.where(np.arange(d) == i, b, a) for i in range(d)]
    values = quantiles(model, study.distributions, np.concatenate([a, b, *mixed]))
    numbers = _evaluated(study, values, how, "Sobol indices")
    if np.isnan(numbers).any():
        none = np.isnan(numbers).mean()
        raise ValueError(
            f"{study.label} must exist at all points to have indices, got none at {none:.1%} of them: "
            "narrow the distributions, or ask for another quantity"
        )
    first, total, first_errors, total_errors = _indices(numbers.reshape(d + 2, n), study.seed)
    names = tuple(study.distributions)
    return SobolIndices(model, study.label, names, first, total, first_errors, total_errors)


def _indices(numbers: Array, seed: int) -> tuple[Array, Array, Array, Array]:
    """Indices of first and total order and their errors, from values (d + 2, n) at A, B and mixed points."""
    from scipy.stats import sobol_indices as indices_of

    d, n = len(numbers) - 2, numbers.shape[1]
    mixed = numbers[2:] if d > 1 else numbers[[2, 2]]  # scipy 1.15 to 1.17 fail with a single parameter
    parts: Any = {"f_A": numbers[:1], "f_B": numbers[1:2], "f_AB": mixed[:, None, :]}
    result = indices_of(func=parts, n=n, rng=np.random.default_rng(seed))
    spread = result.bootstrap(n_resamples=200)
    orders = result.first_order, result.total_order
    errors = spread.first_order.standard_error, spread.total_order.standard_error
    first, total, *both = (np.asarray(x, dtype=float).ravel()[:d] for x in (*orders, *errors))
    return first, total, both[0], both[1]


class _Study(NamedTuple):
    """The checked arguments of a computation."""

    model: ModelOrAutomaton
    quantity: Any
    distributions: dict[str, Any]
    label: str
    n: int
    seed: int


def _check_study(
    model: ModelOrAutomaton, quantity: Any, distributions: Any, n: Any, rng: Any, least: int
) -> _Study:
    require_model_or_automaton(model, "write uncertainty(model, quantity, distributions), the model made")
    check_function("quantity", quantity, 'give one such as fl.CriticalValue("mu_k", (0, 4))')
    n = check_number("n", n, integer=True, least=least, most=MOST, cure="give a power of two such as 1024")
    if n & (n - 1):
        raise ValueError(f"n must be a power of two, got {n}: give {1 << (n.bit_length() - 1)} or its double")
    label = quantity.label_of(model) if isinstance(quantity, Quantity) else own_name(quantity)
    return _Study(model, quantity, check_distributions(model, distributions), label, n, seed_of(rng))


def _evaluated(study: _Study, values: Array, how: Execution, title: str) -> Array:
    """The quantity (N,) at values (N, d), by tasks that can be resumed; NaN where there is none."""
    tasks, names = _evaluation_tasks(study.model, study.quantity, tuple(study.distributions), values)
    specification: dict[str, Any] = {}
    if how.resume is not None:
        specification = {"quantity": function_name(study.quantity), "model": data_of(study.model)}
        specification |= {"parameters": list(study.distributions), "points": values.tolist()}
    with Journal(specification, how.resume) as journal:
        journal.run_tasks(evaluate, tasks, names.__getitem__, how, title)
        numbers = [journal.results.get(i, [None] * len(block[3])) for i, block in enumerate(tasks)]
        flat = np.array([np.nan if v is None else v for block in numbers for v in block], dtype=float)
        return journal.finish(flat, len(tasks))


def _evaluation_tasks(
    model: ModelOrAutomaton, quantity: Callable[[Any], Any], names: Sequence[str], values: Array
) -> tuple[list[tuple[Any, ...]], list[str]]:
    """Tasks of :func:`evaluate` for some values (N, d) of parameters, and names for them."""
    size = BLOCK if isinstance(quantity, Quantity) else 1
    starts = range(0, len(values), size)
    tasks = [(model, quantity, tuple(names), values[i : i + size]) for i in starts]
    return tasks, [f"the point {i}" if size == 1 else f"one of the points from {i} on" for i in starts]


def evaluate(
    model: ModelOrAutomaton, quantity: Callable[[Any], Any], names: tuple[str, ...], values: Array
) -> list[float | None]:
    """A quantity (N,) at values (N, d) of some parameters; None where there is none."""
    if isinstance(quantity, Quantity):
        at_once = quantity.values(model, dict(zip(names, values.T)))
        return [None if np.isnan(number) else float(number) for number in at_once]
    numbers = (quantity(model.replace(**dict(zip(names, map(float, point))))) for point in values)
    return [None if number is None or np.isnan(number) else float(number) for number in numbers]
