"""What a model predicts for measurements, piece by piece, with exact derivatives through events."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionlab.analysis.motion_scales import state_scales
from frictionlab.analysis.orbits.closing import but_for_turns
from frictionlab.analysis.parameter_flow import ParameterFlow, parameter_flow
from frictionlab.analysis.quantities.quantities import ModeFrequency
from frictionlab.hybrid.solve import end_of, solve, try_from_end, with_warning
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.models.model import ModelOrAutomaton, automaton_of, values_of
from frictionlab.stability import eigenvalues

from .data import EventTimes, Frequencies, SpectrumRecord, TimeRecord, line_weights, of_kind

Array = NDArray[np.float64]
DIFFERENCE_SHARE = 1e-6  # of a state or parameter: step of finite differences, where no derivative exists
END_MARGIN = 1e-6  # share by which runs are longer than the last measured time, so that it lies inside


class Misfit(NamedTuple):
    """Numbers that should be zero, and their derivatives by the unknowns."""

    values: Array  # (m,)
    slopes: Array  # (m, u)


@dataclass(frozen=True)
class Segments:
    """How the time of the measurements is cut.

    Parameters
    ----------
    edges : array (S + 1,)
        Ends of the pieces, s; the first is 0.
    unknown : tuple of int
        The states whose values at the time 0 are not known.
    start : array (n,)
        The state at the time 0; for unknown states a guess.
    size : array (n,)
        Size of the motion in each state.
    weight : float
        Weight of the mismatch between pieces, which is in units of `size`.
    """

    edges: Array
    unknown: tuple[int, ...]
    start: Array
    size: Array
    weight: float

    @property
    def count(self) -> int:
        """Number of pieces."""
        return len(self.edges) - 1


class FitProblem(NamedTuple):
    """The checked arguments of a fit."""

    model: ModelOrAutomaton
    data: tuple[Any, ...]
    names: tuple[str, ...]
    start: Array
    unknown: tuple[int, ...]
    bounds: Mapping[str, tuple[float, float]]

    @property
    def moving(self) -> bool:
        """Whether some data are of a motion, not only of its equilibrium."""
        return any(not isinstance(one, Frequencies) for one in self.data)

    @property
    def scales(self) -> Array:
        """Sizes (P,) of the parameters."""
        return np.array([abs(values_of(self.model)[name]) or 1.0 for name in self.names])

    def first(self) -> Array:
        """The unknowns where the search begins: parameters over their sizes, then unknown initial states."""
        values = np.array([values_of(self.model)[name] for name in self.names]) / self.scales
        return np.concatenate([values, self.start[list(self.unknown)]])

    def at(self, unknowns: Array) -> Any:
        """The model with the parameters that are among some unknowns."""
        values = unknowns[: len(self.names)] * self.scales
        return self.model.replace(**dict(zip(self.names, map(float, values))))


def first_run(problem: FitProblem) -> Trajectory:
    """The model's motion where the search begins, a little longer than the data."""
    last = max(float(one.t[-1]) for one in problem.data if not isinstance(one, Frequencies))
    # Measured events have to happen within the run, even if they come later with the first parameters.
    margin = 0.05 if of_kind(problem.data, EventTimes) else END_MARGIN
    return run_for(problem, last * (1.0 + margin))


def run_for(problem: FitProblem, end: float) -> Trajectory:
    """The model's motion where the search begins, up to a time, s."""
    return solve(automaton_of(problem.model), end, x0=problem.start, progress=False)


def even_segments(problem: FitProblem, run: Trajectory, segments: int) -> Segments:
    """The time of the data in even pieces, and the motion's size, from a run and from time records."""
    end = run.problem.t_end
    size = state_scales(run.states, run.automaton.coordinates)
    for record in of_kind(problem.data, TimeRecord):
        for name, column in record.values.items():
            i = run.names.index(name)
            size[i] = max(size[i], float(np.ptp(column)))
    return Segments(np.linspace(0.0, end, segments + 1), problem.unknown, problem.start, size, 1.0)


def first_states(problem: FitProblem, run: Trajectory, pieces: Segments) -> Array:
    """States (S - 1, n) at the start of the later pieces: from time records, else from a run of the model."""
    states, n = run(pieces.edges[1:-1]).copy(), run.automaton.coordinates
    for record in of_kind(problem.data, TimeRecord):
        measured = {run.names.index(name): column for name, column in record.values.items()}
        for i, column in measured.items():
            states[:, i] = np.interp(pieces.edges[1:-1], record.t, column)
            if i < n and i + n not in measured and len(record.t) > 2:
                states[:, i + n] = np.interp(pieces.edges[1:-1], record.t, np.gradient(column, record.t))
    return states


def inverse_error(problem: FitProblem, pieces: Segments) -> float:
    """Size of the motion over the measurement's error, the median over all measured states."""
    names = automaton_of(problem.model).state_names
    shares = [
        one.error[name] / pieces.size[names.index(name)]
        for one in problem.data
        if isinstance(one, (TimeRecord, SpectrumRecord))
        for name in one.values
    ] or [1e-3]
    return 1.0 / float(np.median(shares))


def motion_misfit(
    model: ModelOrAutomaton, names: tuple[str, ...], data: Sequence[Any], pieces: Segments, starts: Array
) -> Misfit:
    """Residuals of records, event times and spectra, over their errors, and the mismatch between pieces.

    Unknowns are the P parameters, the unknown states at the time 0, then the states (S - 1, n) at the start
    of the other pieces.  `starts` (S, n) are the states at the start of all pieces.

    Raises
    ------
    ValueError
        Where a run ends early.
    """
    n, count, first = len(pieces.size), len(names), len(pieces.unknown)
    unknowns = count + first + n * (pieces.count - 1)
    rows: list[Array] = []
    slopes: list[Array] = []

    def add(values: Array, by_state: Array, by_parameters: Array, piece: int) -> None:
        block = np.zeros((len(values), unknowns))
        block[:, :count] = by_parameters
        states, columns = _columns_of(piece, pieces, count)
        block[:, columns] = by_state[:, states]
        rows.append(values)
        slopes.append(block)

    moments, samples, mode = [], [], None
    for piece in range(pieces.count):
        low, high = pieces.edges[piece : piece + 2]
        times = _times_within(data, low, high, piece == pieces.count - 1)
        run = _run(model, starts[piece], high - low, mode)
        _, mode = end_of(run)  # the next piece goes on in it
        flow = _flow(model, run, names, times - low)
        moments += [(low, run, flow, piece)]
        samples += [(times, flow, _columns_of(piece, pieces, count))]
        for record in of_kind(data, TimeRecord):
            here = np.flatnonzero(np.isin(times, record.t))
            there = np.searchsorted(record.t, times[here])
            for name, column in record.values.items():
                i, error = run.names.index(name), record.error[name]
                block = flow.slopes[here, i] / error
                add((flow.states[here, i] - column[there]) / error, block[:, :n], block[:, n:], piece)
        if piece < pieces.count - 1:
            missed = but_for_turns(run, run.final_state, starts[piece + 1]) / pieces.size * pieces.weight
            block = flow.end / pieces.size[:, None] * pieces.weight
            add(missed, block[:, :n], block[:, n:], piece)
            place = count + first + n * piece
            slopes[-1][np.arange(n), place + np.arange(n)] -= pieces.weight / pieces.size
    for one in of_kind(data, EventTimes):
        _add_event_times(one, moments, n, add)
    for one in of_kind(data, SpectrumRecord):
        misfit = _spectrum_misfit(one, samples, moments[0][1].names, unknowns)
        rows.append(misfit.values)
        slopes.append(misfit.slopes)
    return Misfit(np.concatenate(rows), np.concatenate(slopes))


def _columns_of(piece: int, pieces: Segments, count: int) -> tuple[list[int], slice]:
    """Which states at the start of a piece are unknown, and their places among the unknowns."""
    n, first = len(pieces.size), len(pieces.unknown)
    if piece == 0:
        return list(pieces.unknown), slice(count, count + first)
    place = count + first + n * (piece - 1)
    return list(range(n)), slice(place, place + n)


def _spectrum_misfit(
    one: SpectrumRecord, samples: Sequence[Any], names: tuple[str, ...], unknowns: int
) -> Misfit:
    """Residuals of amplitudes, which are sums over all pieces; their derivatives d|a| = Re(a* da)/|a|."""
    weights, n = line_weights(one.t, one.frequencies, one.window), len(names)
    rows, slopes = [], []
    for name, measured in one.values.items():
        i = names.index(name)
        sums: Any = np.zeros(len(one.frequencies), dtype=complex)
        moves: Any = np.zeros((len(sums), unknowns), dtype=complex)
        for times, flow, (states, columns) in samples:
            here = np.flatnonzero(np.isin(times, one.t))
            part = weights[:, np.searchsorted(one.t, times[here])]
            sums += part @ flow.states[here, i]
            by_unknowns = part @ flow.slopes[here, i]
            moves[:, : by_unknowns.shape[1] - n] += by_unknowns[:, n:]
            moves[:, columns] += by_unknowns[:, states]
        size = np.abs(sums)
        turned = sums.conj() / np.where(size > 0.0, size, 1.0)
        rows.append((size - measured) / one.error[name])
        slopes.append((turned[:, None] * moves).real / one.error[name])
    return Misfit(np.concatenate(rows), np.concatenate(slopes))


def _add_event_times(one: EventTimes, moments: Sequence[Any], n: int, add: Any) -> None:
    """Residuals of the first events that enter a mode; missing events are put at the end of the run."""
    k = 0
    for low, run, flow, piece in moments:
        for i in np.flatnonzero(run.events.target == one.target)[: len(one.t) - k]:
            block = flow.event_slopes[i : i + 1] / one.error
            value = np.array([(low + flow.events[i] - one.t[k]) / one.error])
            add(value, block[:, :n], block[:, n:], piece)
            k += 1
    low, run, flow, piece = moments[-1]
    missing = (low + run.raw.t - one.t[k:]) / one.error
    add(missing, np.zeros((len(missing), n)), np.zeros((len(missing), flow.end.shape[1] - n)), piece)


def check_frequencies(model: ModelOrAutomaton, data: Sequence[Any]) -> None:
    """Raise ValueError unless the modes whose frequencies were measured vibrate where the search begins."""
    for mode in (mode for one in of_kind(data, Frequencies) for mode in one.values):
        if not ModeFrequency(mode)(model):
            values = eigenvalues(model).values
            first = (len(values) + 1) // 2 - int((values.imag > 0.0).sum())
            raise ValueError(
                f"the modes of Frequencies must vibrate where the search begins, got mode {mode} of 0 Hz, "
                f"overdamped, of a further state or a rotation: count from the first that vibrates, {first}"
            )


def frequency_misfit(
    model: ModelOrAutomaton, names: tuple[str, ...], data: Sequence[Any], unknowns: int
) -> Misfit:
    """Residuals of eigenfrequencies, over their errors."""
    rows, slopes = [], []
    for one in of_kind(data, Frequencies):
        for mode, measured in one.values.items():
            gradient = ModeFrequency(mode).gradient(model)
            rows.append((gradient.value - measured) / one.error)
            own = [gradient.derivatives.get(name, 0.0) / one.error for name in names]
            slopes.append(own + [0.0] * (unknowns - len(names)))
    return Misfit(np.array(rows), np.array(slopes).reshape(len(rows), unknowns))


def _times_within(data: Sequence[Any], low: float, high: float, last: bool) -> Array:
    every = [one.t for one in data if isinstance(one, (TimeRecord, SpectrumRecord))]
    times = np.unique(np.concatenate(every)) if every else np.zeros(0)
    return times[(times >= low) & ((times <= high) if last else (times < high))]


def _run(model: ModelOrAutomaton, start: Array, length: float, mode: str | None) -> Trajectory:
    run = try_from_end(automaton_of(model), length, start, mode, progress=False, source=model)
    if not run.status.ok:  # such as one of trial values behind a stop
        raise ValueError(f"a run of the fit ends early: {run.status}")
    return with_warning(run)


def _flow(model: ModelOrAutomaton, run: Trajectory, names: tuple[str, ...], times: Array) -> ParameterFlow:
    try:
        return parameter_flow(run, names, np.minimum(times, run.raw.t))
    except ValueError:  # grazing, two events at one instant: no derivative exists
        return _differences(model, run, names, times)


def _differences(
    model: ModelOrAutomaton, run: Trajectory, names: tuple[str, ...], times: Array
) -> ParameterFlow:
    """The derivatives by finite differences, for motions that have no derivative."""
    n, start = len(run.names), run.problem.x0
    times = np.minimum(times, run.raw.t)
    states, width = run(times) if len(times) else np.zeros((0, n)), n + len(names)
    slopes, end = np.zeros((len(times), n, width)), np.zeros((n, width))
    event_slopes = np.zeros((len(run.raw.event_times), width))
    size = np.maximum(np.abs(run.states).max(axis=0), np.finfo(float).tiny)
    mode = str(run.modes_at(0.0))
    for d in range(width):
        step = DIFFERENCE_SHARE * (size[d] if d < n else abs(values_of(model)[names[d - n]]) or 1.0)
        shift = step * (np.arange(n) == d)
        neighbour = model if d < n else model.replace(**{names[d - n]: values_of(model)[names[d - n]] + step})
        other = _run(neighbour, start + shift, run.raw.t, mode)
        if len(times):
            slopes[:, :, d] = (other(times) - states) / step
        end[:, d] = (other.final_state - run.final_state) / step
        if len(other.raw.event_times) == len(event_slopes):
            event_slopes[:, d] = (other.raw.event_times - run.raw.event_times) / step
    return ParameterFlow(states, slopes, run.raw.event_times, event_slopes, end)
