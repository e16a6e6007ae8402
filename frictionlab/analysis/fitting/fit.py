"""`fl.fit`: parameters from measurements, by multiple shooting with exact gradients through events."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from frictionlab.analysis.motion_scales import state_scales
from frictionlab.analysis.simulate import initial_state_of
from frictionlab.hybrid.solve import solve
from frictionlab.models.coercion import automaton_of, require_model
from frictionlab.stability.equilibrium_problem import check_parameter
from frictionlab.validation import check_choice, check_mapping, check_number

from .data import EventTimes, Frequencies, SpectrumRecord, TimeRecord, as_data
from .predictions import END_MARGIN, Misfit, Pieces, frequency_misfit, motion_misfit
from .result import Fit, covariance_of

Array = NDArray[np.float64]
WEIGHTS = (1.0, 30.0, 1000.0)  # of what pieces miss of each other, over the measurement's error
MAX_EVALUATIONS = 100
FIT_RTOL = 1e-12


def fit(
    model: Any,
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
    well (multiple shooting): a wrong parameter then shifts no later onset of stick or impact, as it does in a
    single run, whose squared error has many minima.  What the segments miss of each other is weighted more
    and more, and at the end one run has to fit all.  Derivatives are those of the tangent flow with saltation
    matrices, not differences.

    Parameters
    ----------
    model : Model
        Its values are where the search begins.
    data : TimeRecord, SpectrumRecord, EventTimes, Frequencies, or a sequence of them
    parameters : sequence of str
        Those to be fitted.
    x0 : "rest", "near", mapping or array_like
        The state at the time 0.
    unknown : sequence of str
        States whose value at the time 0 is fitted too; `x0` is the guess.
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
        For what is no model or no data.
    ValueError
        For an unknown parameter or state, or where the search finds no run through the data.

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
    task = _check(model, data, parameters, x0, unknown, segments, bounds)
    if not task.moving:
        return _result(task, _solve(task, None, task.first(), "one run"), None)
    unknowns, pieces = task.first(), _pieces(task, segments)
    if segments > 1:
        unknowns = np.concatenate([unknowns, (_guesses(task, pieces) / pieces.size).ravel()])
        for weight in WEIGHTS:
            pieces = replace(pieces, weight=weight * _inverse_error(task, pieces))
            unknowns = _solve(task, pieces, unknowns, "the segments").x
    single = replace(pieces, edges=pieces.edges[[0, -1]])
    count = len(task.names) + len(task.unknown)
    return _result(task, _solve(task, single, unknowns[:count], "one run"), single)


class _Task(NamedTuple):
    """What is fitted, checked."""

    model: Any
    data: tuple[Any, ...]
    names: tuple[str, ...]
    start: Array
    unknown: tuple[int, ...]
    bounds: Mapping[str, tuple[float, float]]

    @property
    def moving(self) -> bool:
        """Whether there are data of a motion."""
        return any(not isinstance(one, Frequencies) for one in self.data)

    @property
    def scales(self) -> Array:
        """Sizes (P,) of the parameters."""
        return np.array([abs(self.model.parameters[name]) or 1.0 for name in self.names])

    def first(self) -> Array:
        """Where the search begins: parameters by their sizes, then unknown states at the start."""
        values = np.array([self.model.parameters[name] for name in self.names]) / self.scales
        return np.concatenate([values, self.start[list(self.unknown)]])

    def at(self, unknowns: Array) -> Any:
        """The model with the parameters of some unknowns."""
        values = unknowns[: len(self.names)] * self.scales
        return self.model.replace(**dict(zip(self.names, map(float, values))))


def _check(
    model: Any, data: Any, parameters: Any, x0: Any, unknown: Any, segments: Any, bounds: Any
) -> _Task:
    require_model(model, cure="write fit(model, data, parameters), the model made")
    found, names = as_data(data), (parameters,) if isinstance(parameters, str) else tuple(parameters)
    if not names:
        raise ValueError("parameters must name one at least, got none: write fit(model, data, ['k1'])")
    for name in names:
        check_parameter(model, name, [])
    check_number("segments", segments, integer=True, least=1, cure="8 suits most records")
    check_mapping("bounds", bounds or {}, 'give limits by parameter, such as {"k1": (5e3, 2e4)}')
    states = tuple(map(str, automaton_of(model).states))
    of_states = (one for one in found if isinstance(one, (TimeRecord, SpectrumRecord)))
    for name in (*unknown, *(s for one in of_states for s in one.values)):
        check_choice("state", name, states, "name one of them")
    places = tuple(states.index(name) for name in unknown)
    return _Task(model, found, names, initial_state_of(model, x0), places, dict(bounds or {}))


def _pieces(task: _Task, segments: int) -> Pieces:
    """Even pieces of the time of the data, and the motion's size by the data where they tell."""
    last = max(float(one.t[-1]) for one in task.data if not isinstance(one, Frequencies))
    # Events that are measured have to happen within the run, though they come later at first.
    late = any(isinstance(one, EventTimes) for one in task.data)
    end = last * (1.0 + (0.05 if late else END_MARGIN))
    run = solve(automaton_of(task.model), end, x0=task.start, progress=False)
    size = state_scales(run.states, run.automaton.coordinates)
    for record in (one for one in task.data if isinstance(one, TimeRecord)):
        for name, column in record.values.items():
            i = run.names.index(name)
            size[i] = max(size[i], float(np.ptp(column)))
    return Pieces(np.linspace(0.0, end, segments + 1), task.unknown, task.start, size, 1.0)


def _guesses(task: _Task, pieces: Pieces) -> Array:
    """States (S - 1, n) at the start of the later pieces: measured, or else those of the model as it is."""
    run = solve(automaton_of(task.model), float(pieces.edges[-1]), x0=task.start, progress=False)
    found, n = run(pieces.edges[1:-1]).copy(), run.automaton.coordinates
    for record in (one for one in task.data if isinstance(one, TimeRecord)):
        measured = {run.names.index(name): column for name, column in record.values.items()}
        for i, column in measured.items():
            found[:, i] = np.interp(pieces.edges[1:-1], record.t, column)
            if i < n and i + n not in measured and len(record.t) > 2:
                found[:, i + n] = np.interp(pieces.edges[1:-1], record.t, np.gradient(column, record.t))
    return found


def _inverse_error(task: _Task, pieces: Pieces) -> float:
    """Size of the motion over the measurement's error."""
    names = tuple(map(str, automaton_of(task.model).states))
    shares = [
        one.error[name] / pieces.size[names.index(name)]
        for one in task.data
        if isinstance(one, (TimeRecord, SpectrumRecord))
        for name in one.values
    ] or [1e-3]
    return 1.0 / float(np.median(shares))


class _Solution(NamedTuple):
    """Unknowns (u,), residuals with their derivatives there, and why the search ended."""

    x: Array
    misfit: Misfit
    message: str


def _solve(task: _Task, pieces: Pieces | None, first: Array, what: str) -> _Solution:
    """Least squares from a start.

    Raises
    ------
    ValueError
        Where there is no run at the start.
    """
    evaluate = _misfit_function(task, pieces)
    begin = evaluate(first)
    if not np.isfinite(begin.values).all():
        raise ValueError(
            f"{what} must reach the end of the data where the search begins, got a run that ends early: "
            "change the model's values or x0"
        )
    low, high = np.full(len(first), -np.inf), np.full(len(first), np.inf)
    for i, name in enumerate(task.names):
        if name in task.bounds:
            low[i], high[i] = np.asarray(task.bounds[name], dtype=float) / task.scales[i]
    derivatives: Any = lambda x: evaluate(x).slopes  # noqa: E731 - scipy's types allow a text only
    found: Any = least_squares(
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
    return _Solution(found.x, evaluate(found.x), str(found.message))


def _misfit_function(task: _Task, pieces: Pieces | None) -> Callable[[Array], Misfit]:
    """Residuals and derivatives at unknowns (u,); the last are remembered, as the solver asks for each."""
    known: list[tuple[bytes, Misfit]] = []

    def evaluate(x: Array) -> Misfit:
        key = x.tobytes()
        if not known or known[0][0] != key:
            known[:] = [(key, _misfit(task, pieces, x))]
        return known[0][1]

    return evaluate


def _misfit(task: _Task, pieces: Pieces | None, x: Array) -> Misfit:
    try:
        model = task.at(x)
        parts = [frequency_misfit(model, task.names, task.data, len(x))]
        if pieces is not None:
            starts = _starts(task, pieces, x)
            parts.append(motion_misfit(model, task.names, task.data, pieces, starts))
    except ValueError:  # a value that breaks its rule, a run that ends early: the solver takes a shorter step
        count = sum(one.count for one in task.data)
        count += 0 if pieces is None else (pieces.count - 1) * len(pieces.size)
        return Misfit(np.full(count, np.inf), np.zeros((count, len(x))))
    values, slopes = (np.concatenate(both) for both in zip(*parts))
    scales = np.ones(len(x))
    scales[: len(task.names)] = task.scales
    if pieces is not None:
        later = len(task.names) + len(task.unknown)
        scales[later:] = np.tile(pieces.size, pieces.count - 1)
    return Misfit(values, slopes * scales)


def _starts(task: _Task, pieces: Pieces, x: Array) -> Array:
    """States (S, n) at the start of all pieces."""
    count = len(task.names)
    start = task.start.copy()
    start[list(task.unknown)] = x[count : count + len(task.unknown)]
    later = x[count + len(task.unknown) :].reshape(-1, len(start)) * pieces.size
    return np.vstack([start, later])


def _result(task: _Task, found: _Solution, pieces: Pieces | None) -> Fit:
    states = tuple(map(str, automaton_of(task.model).states))
    names = (*task.names, *(f"{states[i]} at 0" for i in task.unknown))
    sizes = np.ones(len(task.unknown)) if pieces is None else pieces.size[list(task.unknown)]
    scales = np.concatenate([task.scales, sizes])
    values = found.x.copy()
    values[: len(task.names)] *= task.scales
    slopes = found.misfit.slopes.copy()
    slopes[:, : len(task.names)] /= task.scales
    covariance, rank, undetermined = covariance_of(slopes, names, scales)
    times = [np.full(one.count, np.nan) for one in task.data if isinstance(one, Frequencies)]
    times += [np.tile(one.t, len(one.values)) for one in task.data if isinstance(one, TimeRecord)]
    times += [one.t for one in task.data if isinstance(one, EventTimes)]
    times += [np.full(one.count, np.nan) for one in task.data if isinstance(one, SpectrumRecord)]
    return Fit(
        model=task.at(found.x),
        parameters=names,
        values=values,
        covariance=covariance,
        residuals=found.misfit.values,
        times=np.concatenate(times),
        rank=rank,
        undetermined=undetermined,
        message=found.message,
    )
