"""`fl.fit`: parameters from measurements, by multiple shooting with exact gradients through events.

A `Fit` also tells how uncertain the parameters are, and which of them cannot be told apart.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from frictionlab.analysis.fitting.data import (
    EventTimes,
    Frequencies,
    SpectrumRecord,
    TimeRecord,
    as_data,
    check_data,
    of_kind,
)
from frictionlab.analysis.fitting.plausibility import check_times, doubts_about
from frictionlab.analysis.fitting.predictions import (
    FitProblem,
    Misfit,
    Segments,
    check_frequencies,
    even_segments,
    first_run,
    first_states,
    frequency_misfit,
    inverse_error,
    motion_misfit,
    run_for,
)
from frictionlab.analysis.initial_states import initial_state_of
from frictionlab.hybrid.solve import with_phase_in_turn
from frictionlab.models.model import (
    ModelOrAutomaton,
    automaton_of,
    check_parameter_name,
    check_varied,
    require_model_or_automaton,
    values_of,
)
from frictionlab.presentation import Drawable, dataframe, text_table
from frictionlab.validation import (
    abbreviate,
    check_choice,
    check_key,
    check_mapping,
    check_number,
    check_sequence,
    float_array,
)

Array = NDArray[np.float64]
MAX_SEGMENTS = 10_000  # of a fit, each with an initial state of its own
STRONG_CORRELATION = 0.95  # above it two parameters are named as hard to tell apart
MAX_CHI_SQUARE = 10.0  # reduced: above it the model does not fit, even if errors are three times as large
RANK_RTOL = 1e-8  # the data do not determine directions of smaller relative singular values
NULL_SHARE = 1e-4  # a parameter with a larger share in such a direction is part of it
WEIGHTS = (1.0, 30.0, 1000.0)  # of the mismatch between pieces, relative to the measurement's error
MAX_EVALUATIONS = 100
FIT_RTOL = 1e-12


@dataclass(frozen=True, eq=False)
class Fit(Drawable):
    """A model fitted to measurements.

    Parameters
    ----------
    model : Model or HybridAutomaton
        With the fitted values.
    parameters : tuple of str
        The fitted parameters, then the fitted states at the start, such as "x1 at 0".
    values : array (P,)
    covariance : array (P, P)
        Its diagonal is inf for parameters that the data do not determine.
    residuals : array (N,)
        (predicted - measured) / error.
    times : array (N,)
        Of the measurements, s; NaN for frequencies and spectra.
    rank : int
        Number of combinations of parameters that the data determine.
    undetermined : tuple of tuple of str
        For each combination that the data do not determine, the parameters in it.
    message : str
        Why the search ended.
    """

    drawn_by = "plot_fit"

    model: ModelOrAutomaton
    parameters: tuple[str, ...]
    values: Array
    covariance: Array
    residuals: Array
    times: Array
    rank: int
    undetermined: tuple[tuple[str, ...], ...]
    message: str

    def __repr__(self) -> str:
        rows = [
            f"  {name} = {v:.6g} ± {e:.2g}" for name, v, e in zip(self.parameters, self.values, self.errors)
        ]
        rows += [f"  {self.warning}"] if self.warning else []
        return text_table([f"Fit({len(self.residuals)} numbers, reduced chi² {self.chi_square:.3g}):", *rows])

    def __getitem__(self, parameter: str) -> float:
        """The fitted value of a parameter."""
        check_key("parameter", parameter, self.parameters)
        return float(self.values[self.parameters.index(parameter)])

    @property
    def errors(self) -> Array:
        """Standard errors (P,); inf for what the data do not determine."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def degrees_of_freedom(self) -> int:
        """Number of measured values less number of determined combinations of parameters."""
        return len(self.residuals) - self.rank

    @property
    def chi_square(self) -> float:
        """Sum of squared residuals over degrees of freedom: near 1 where model and errors are right."""
        return float(self.residuals @ self.residuals) / max(self.degrees_of_freedom, 1)

    @property
    def warning(self) -> str | None:
        """A warning where the model misses the data by far more than their errors; else None."""
        if not self.chi_square > MAX_CHI_SQUARE:
            return None
        return (
            f"the model misses the data by {np.sqrt(self.chi_square):.3g} times their errors: "
            "model, x0, units or errors are wrong"
        )

    @property
    def correlation(self) -> Array:
        """Correlations (P, P) of the parameters; NaN for what the data do not determine."""
        errors = np.where(np.isfinite(self.errors) & (self.errors > 0), self.errors, np.nan)
        return self.covariance / np.outer(errors, errors)

    @property
    def correlated(self) -> tuple[tuple[str, str, float], ...]:
        """Pairs of parameters that are hard to tell apart, and their correlation."""
        correlation, names = self.correlation, self.parameters
        pairs = [
            (i, j) for j in range(len(names)) for i in range(j) if abs(correlation[i, j]) > STRONG_CORRELATION
        ]
        return tuple((names[i], names[j], float(correlation[i, j])) for i, j in pairs)

    def interval(self, parameter: str, level: float = 0.95) -> tuple[float, float]:
        """The confidence interval of a parameter, from the errors of the measurements.

        Parameters
        ----------
        parameter : str
        level : float
            Share of such intervals that contain the true value.
        """
        from scipy.special import ndtri

        check_number("level", level, above=0.0, below=1.0, cure="0.95 is usual")
        value = self[parameter]
        half = float(ndtri(0.5 + 0.5 * level)) * float(self.errors[self.parameters.index(parameter)])
        return value - half, value + half

    def summary(self) -> str:
        """The fit in words: values, intervals, and what the data do not tell."""
        ends = {name: self.interval(name) for name in self.parameters}
        rows = [f"{name} = {self[name]:.6g}, 95 % from {a:.6g} to {b:.6g}" for name, (a, b) in ends.items()]
        rows += [f"not determined: a combination of {', '.join(names)}" for names in self.undetermined]
        rows += [f"hard to tell apart: {a} and {b}, correlation {r:+.4f}" for a, b, r in self.correlated]
        freedom = f"{self.degrees_of_freedom} degrees of freedom"
        rows += [f"reduced chi² {self.chi_square:.4g}, {freedom}"]
        return "\n".join(rows if self.warning is None else [*rows, self.warning])

    def to_dataframe(self) -> Any:
        """One row for each parameter (needs the extra ``data``)."""
        columns = {"value": self.values, "error": self.errors}
        return dataframe(columns, {"parameter": list(self.parameters)}, {})


def covariance_of(slopes: Array, names: tuple[str, ...], scales: Array) -> tuple[Array, int, tuple[Any, ...]]:
    """Covariance (P, P), rank and undetermined combinations, of derivatives (N, P) of residuals."""
    normalised = slopes * scales
    # All directions are needed where there are fewer residuals than parameters, never all of the residuals'.
    _, sizes, directions = np.linalg.svd(normalised, full_matrices=len(normalised) < len(names))
    sizes = np.concatenate([sizes, np.zeros(len(directions) - len(sizes))])
    significant = sizes > RANK_RTOL * sizes[0] if sizes[0] > 0 else np.zeros(len(sizes), dtype=bool)
    determined = directions[significant] / sizes[significant, None]
    covariance = determined.T @ determined * np.outer(scales, scales)
    lost = np.abs(directions[~significant])
    part = (lost > NULL_SHARE).any(axis=0)
    covariance[part, part] = np.inf
    undetermined = tuple(tuple(name for name, share in zip(names, row) if share > NULL_SHARE) for row in lost)
    return covariance, int(significant.sum()), undetermined


def fit(
    model: ModelOrAutomaton,
    data: Any,
    parameters: Sequence[str],
    *,
    x0: Any = "rest",
    unknown: Sequence[str] = (),
    segments: int = 8,
    bounds: Mapping[str, tuple[float, float]] | None = None,
) -> Fit:
    """Parameters of a model from measurements, by least squares.

    The time of the measurements is cut into segments that start at states of their own, which are unknowns as
    well (multiple shooting).  A wrong parameter then does not shift all later onsets of stick and impacts, as
    in a single run, whose squared error has many minima.  The mismatch between segments is weighted more and
    more, and at the end one run has to fit all data.  Derivatives are those of the tangent flow with
    saltation matrices, not finite differences, but for motions that have no derivative.

    Parameters
    ----------
    model : Model or HybridAutomaton
        The search begins at its parameters.
    data : TimeRecord, SpectrumRecord, EventTimes, Frequencies, or a sequence of them
    parameters : sequence of str
        Those to be fitted.
    x0 : "rest", "near", mapping or array_like
        The state at the time 0.
    unknown : sequence of str
        States whose value at the time 0 is fitted too, beginning from that in `x0`.
    segments : int
        Number of pieces; 1 is single shooting.
    bounds : mapping of str to (float, float)
        Limits of parameters.

    Returns
    -------
    Fit

    Raises
    ------
    TypeError
        Where `model` is no model, or `data` are no measurements.
    ValueError
        For an unknown parameter, state or mode, bounds without the model's own value between, or a name given
        twice; where the motion moves up and down many times between two times of a record, as where these are
        milliseconds read as seconds; where a run with which a search begins ends before the data do.

    Warns
    -----
    RuntimeWarning
        Before the search begins, where a record looks like one in other units, or one that begins later than
        the motion.  What to think of the result is told by its ``warning``.

    Notes
    -----
    H. G. Bock, "Recent advances in parameter identification techniques for ODE", 1983.

    Examples
    --------
    >>> import frictionlab as fl, numpy as np
    >>> truth = fl.MassOnBelt(k=1.2)
    >>> t = np.linspace(0.1, 10.0, 40)
    >>> record = fl.TimeRecord(t, {"x": fl.simulate(truth, 10.0)(t)[:, 0]}, error=1e-3)
    >>> round(fl.fit(fl.MassOnBelt(), record, ["k"])["k"], 6)
    1.2
    """
    segments = check_number("segments", segments, integer=True, least=1, most=MAX_SEGMENTS, cure="8 is usual")
    problem = _check(model, data, parameters, x0, unknown, bounds)
    if not problem.moving:
        return _result(problem, _solve(problem, None, problem.first(), "one run"), None)
    check_times(problem.data, partial(run_for, problem))
    run = first_run(problem)
    if not run.status.ok:
        raise ValueError(
            f"the model's run must reach the end of the data at {run.problem.t_end:g} s, got one that ends "
            f"at {run.raw.t:g} s ({run.status}): begin with other values or x0, or give times in s"
        )
    for doubt in doubts_about(problem.data, run, problem.model):
        warnings.warn(doubt, RuntimeWarning, 2)
    unknowns, pieces = problem.first(), even_segments(problem, run, segments)
    if segments > 1:
        unknowns = np.concatenate([unknowns, (first_states(problem, run, pieces) / pieces.size).ravel()])
        for weight in WEIGHTS:
            pieces = replace(pieces, weight=weight * inverse_error(problem, pieces))
            unknowns = _solve(problem, pieces, unknowns, "the segments").x
    single = replace(pieces, edges=pieces.edges[[0, -1]])
    count = len(problem.names) + len(problem.unknown)
    return _result(problem, _solve(problem, single, unknowns[:count], "one run"), single)


def _check(
    model: ModelOrAutomaton, data: Any, parameters: Any, x0: Any, unknown: Any, bounds: Any
) -> FitProblem:
    require_model_or_automaton(model, "write fit(model, data, parameters), the model made")
    records, names = as_data(data), _names("parameters", parameters)
    if not names:
        raise ValueError("parameters must name one at least, got none: write fit(model, data, ['k1'])")
    for name in names:
        check_parameter_name(model, name)
    limits = _check_bounds(model, names, {} if bounds is None else bounds)
    states = automaton_of(model).state_names
    check_data(records, automaton_of(model))
    check_frequencies(model, records)
    unknown = _names("unknown", unknown)
    for name in unknown:
        check_choice("state", name, states, "name one of them")
    _check_distinct("parameters", names)
    _check_distinct("unknown", unknown)
    places = tuple(states.index(name) for name in unknown)
    problem = FitProblem(model, records, names, initial_state_of(model, x0), places, limits)
    for name in names if problem.moving else ():
        check_varied(model, name)
    return problem


def _names(what: str, names: Any) -> tuple[str, ...]:
    """One name or several."""
    return (names,) if isinstance(names, str) else check_sequence(what, names, "give names in a list")


def _check_distinct(what: str, names: tuple[str, ...]) -> None:
    if len({*names}) < len(names):
        raise ValueError(f"{what} must name each one once, got {names}: leave out the repeated ones")


def _check_bounds(
    model: ModelOrAutomaton, names: tuple[str, ...], bounds: Any
) -> dict[str, tuple[float, float]]:
    cure = 'give limits by parameter, such as {"k1": (5e3, 2e4)}'
    check_mapping("bounds", bounds, cure)
    limits: dict[str, tuple[float, float]] = {}
    for name, pair in bounds.items():
        if name not in names:
            raise ValueError(
                f"bounds must be of parameters that are fitted, got one of {abbreviate(name)}: name it there"
            )
        low_high = float_array(f"bounds[{abbreviate(name)}]", pair, cure)
        start = values_of(model)[name]
        if low_high.shape != (2,) or not low_high[0] <= start <= low_high[1] or low_high[0] == low_high[1]:
            raise ValueError(
                f"bounds[{abbreviate(name)}] must be (low, high) with the model's {start:g} between, where "
                f"the search begins, got {abbreviate(pair)}: widen them or begin at another value"
            )
        limits[name] = float(low_high[0]), float(low_high[1])
    return limits


class _Solution(NamedTuple):
    """Unknowns (u,), residuals with their derivatives there, and why the search ended."""

    x: Array
    misfit: Misfit
    message: str


def _solve(problem: FitProblem, pieces: Segments | None, first: Array, what: str) -> _Solution:
    """Least squares from a start.

    Raises
    ------
    ValueError
        Where there is no run at the start.
    """
    evaluate = _misfit_function(problem, pieces)
    begin = evaluate(first)
    if not np.isfinite(begin.values).all():
        single = ", or write segments=1, as where a rigid contact stays closed" if "segments" in what else ""
        raise ValueError(
            f"{what} must reach the end of the data where the search begins, and have derivatives, got a run "
            f"that ends early or has none: change the model's values or x0{single}"
        )
    low, high = np.full(len(first), -np.inf), np.full(len(first), np.inf)
    for i, name in enumerate(problem.names):
        if name in problem.bounds:
            low[i], high[i] = np.asarray(problem.bounds[name], dtype=float) / problem.scales[i]
    derivatives: Any = lambda x: evaluate(x).slopes  # noqa: E731 - scipy's types allow a text only
    solution: Any = least_squares(
        lambda x: evaluate(x).values,
        first,
        jac=derivatives,
        bounds=(low, high),
        method="trf",
        xtol=FIT_RTOL,
        ftol=FIT_RTOL,
        gtol=FIT_RTOL,
        max_nfev=MAX_EVALUATIONS,
    )
    return _Solution(solution.x, evaluate(solution.x), str(solution.message))


def _misfit_function(problem: FitProblem, pieces: Segments | None) -> Callable[[Array], Misfit]:
    """Residuals and derivatives at unknowns (u,); the last are kept, as the solver asks for each in turn."""
    last: list[tuple[bytes, Misfit]] = []

    def evaluate(x: Array) -> Misfit:
        key = x.tobytes()
        if not last or last[0][0] != key:
            last[:] = [(key, _misfit(problem, pieces, x))]
        return last[0][1]

    return evaluate


def _misfit(problem: FitProblem, pieces: Segments | None, x: Array) -> Misfit:
    try:
        model = problem.at(x)
        parts = [frequency_misfit(model, problem.names, problem.data, len(x))]
        if pieces is not None:
            starts = _starts(problem, pieces, x)
            parts.append(motion_misfit(model, problem.names, problem.data, pieces, starts))
    except ValueError:  # a value that breaks its rule, a run that ends early: the solver takes a shorter step
        count = sum(one.count for one in problem.data)
        count += 0 if pieces is None else (pieces.count - 1) * len(pieces.size)
        return Misfit(np.full(count, np.inf), np.zeros((count, len(x))))
    values, slopes = (np.concatenate(both) for both in zip(*parts))
    scales = np.ones(len(x))
    scales[: len(problem.names)] = problem.scales
    if pieces is not None:
        later = len(problem.names) + len(problem.unknown)
        scales[later:] = np.tile(pieces.size, pieces.count - 1)
    return Misfit(values, slopes * scales)


def _starts(problem: FitProblem, pieces: Segments, x: Array) -> Array:
    """States (S, n) at the start of all pieces."""
    count = len(problem.names)
    start = problem.start.copy()
    start[list(problem.unknown)] = x[count : count + len(problem.unknown)]
    later = x[count + len(problem.unknown) :].reshape(-1, len(start)) * pieces.size
    return with_phase_in_turn(automaton_of(problem.model), np.vstack([start, later]))


def _result(problem: FitProblem, solution: _Solution, pieces: Segments | None) -> Fit:
    states = automaton_of(problem.model).state_names
    names = (*problem.names, *(f"{states[i]} at 0" for i in problem.unknown))
    sizes = np.ones(len(problem.unknown)) if pieces is None else pieces.size[list(problem.unknown)]
    scales = np.concatenate([problem.scales, sizes])
    values = solution.x.copy()
    values[: len(problem.names)] *= problem.scales
    if pieces is not None:
        values[len(problem.names) :] = _starts(problem, pieces, solution.x)[0, list(problem.unknown)]
    slopes = solution.misfit.slopes.copy()
    slopes[:, : len(problem.names)] /= problem.scales
    covariance, rank, undetermined = covariance_of(slopes, names, scales)
    times = [np.full(one.count, np.nan) for one in of_kind(problem.data, Frequencies)]
    times += [np.tile(one.t, len(one.values)) for one in of_kind(problem.data, TimeRecord)]
    times += [one.t for one in of_kind(problem.data, EventTimes)]
    times += [np.full(one.count, np.nan) for one in of_kind(problem.data, SpectrumRecord)]
    return Fit(
        model=problem.at(solution.x),
        parameters=names,
        values=values,
        covariance=covariance,
        residuals=solution.misfit.values,
        times=np.concatenate(times),
        rank=rank,
        undetermined=undetermined,
        message=solution.message,
    )
