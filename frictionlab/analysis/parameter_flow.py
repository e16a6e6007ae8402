"""How a run depends on the parameters: its tangent flow with a small change of each parameter as a state.

A parameter p becomes p + s e with a state e that is zero and stays so, s its size.  Only first order matters:
every coefficient N(p) of the equations is replaced by N + sum of s_k e_k dN/dp_k, so that flows, guards,
resets and constraints keep their form, and the saltation matrices hold what an event owes to the parameters.
The run is that of the model itself, to the last bit; nothing is integrated again but the tangent vectors.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import sympy
from numpy.typing import NDArray

from frictionlab.automaton import Event, HybridAutomaton, Mode, Reset
from frictionlab.hybrid.problem import Problem
from frictionlab.hybrid.tape.packing import program_of
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.hybrid.variational.tangent_flow import (
    carry_frame,
    carry_rows,
    check_taylor_run,
    event_saltation,
)
from frictionlab.hybrid.variational.tangent_jets import carry_steps, constraint_gradients, linearise_mode
from frictionlab.models.symbols import derivatives

Array = NDArray[np.float64]
INNER = "chatter"  # a number of the solver, no parameter of the motion


class ParameterFlow(NamedTuple):
    """Derivatives of a run's end: by the state (n,) at its start, and by P parameters for a given start."""

    state: Array  # (n, n)
    parameters: Array  # (n, P); NaN where an exponent depends on the parameter
    integrals_by_state: Array  # (q, n)
    integrals_by_parameters: Array  # (q, P)


def varied_names(automaton: HybridAutomaton) -> tuple[str, ...]:
    """Names of the parameters by which runs of an automaton have derivatives."""
    return tuple(symbol.name for symbol in automaton.parameters if symbol.name != INNER)


def parameter_flow(
    run: Trajectory, names: Sequence[str], integrands: Sequence[Any] = (), free: bool = False
) -> ParameterFlow:
    """Derivatives of the end of a run, and of integrals along it.

    Parameters
    ----------
    run : Trajectory
        Made by method "taylor".
    names : sequence of str
        Of P parameters.
    integrands : sequence of sympy.Expr
        q functions of the states and parameters.
    free : bool
        Whether the start is taken to keep no constraint: else, in a mode that has some (stick), the start
        moves by the least that keeps them.

    Raises
    ------
    ValueError
        Where the derivative does not exist or is not known; see :func:`frictionlab.tangent_flow`.
    """
    check_taylor_run(run)
    n, q, count = len(run.names), len(integrands), len(names)
    varied, unknown = _varied_run(run, tuple(names), tuple(integrands))
    frame = np.zeros((n + q + count, n + count))
    frame[:n, :n], frame[n + q :, n:] = np.eye(n), np.eye(count)
    if len(run.raw.step_modes) and not free:
        _keep_constraints(varied, frame, n)
    end, _ = carry_frame(varied, frame, False)
    scales = _scales(run.automaton, names)
    by_parameters = end[: n + q, n:] / scales
    by_parameters[:, unknown] = np.nan
    return ParameterFlow(end[:n, :n], by_parameters[:n], end[n : n + q, :n], by_parameters[n:])


class SampledFlow(NamedTuple):
    """States of a run at some times and the times of its events, with derivatives.

    Directions are the n states at the start, then the P parameters.
    """

    states: Array  # (m, n)
    slopes: Array  # (m, n, n + P)
    events: Array  # (E,)
    event_slopes: Array  # (E, n + P)
    end: Array  # (n, n + P)


def sampled_flow(run: Trajectory, names: Sequence[str], times: Array) -> SampledFlow:
    """Derivatives of a run's states at ascending times, of the times of its events, and of its end.

    Raises
    ------
    ValueError
        As :func:`parameter_flow`.
    """
    n, count = len(run.names), len(names)
    varied, unknown = _varied_run(run, tuple(names), ())
    frame = np.zeros((n + count, n + count))
    frame[:n, :n], frame[n:, n:] = np.eye(n), np.eye(count)
    if len(run.raw.step_modes):
        _keep_constraints(varied, frame, n)
    scales = np.concatenate([np.ones(n), _scales(run.automaton, names)])
    states = run(np.asarray(times, dtype=float)) if len(times) else np.zeros((0, n))
    found = _sample(_split_steps(varied, times, states), frame, times)
    samples, moved, end = (part / scales for part in found)
    for part in (samples, moved, end):
        part[..., n:][..., unknown] = np.nan
    return SampledFlow(states, samples[:, :n], run.raw.event_times, moved, end[:n])


def _split_steps(run: Trajectory, times: Array, states: Array) -> Trajectory:
    """The run with a step that begins at each of some times, so that tangent vectors can be seen there."""
    raw = run.raw
    starts, lengths = raw.step_times.T
    places = np.searchsorted(starts, times, side="right") - 1
    ends = starts + lengths
    inside = (places >= 0) & (times > starts[places]) & (times < ends[places]) if len(starts) else places > 0
    at, cut = places[inside], times[inside]
    wide = _with_zeros(states[inside], raw.step_states.shape[1] - states.shape[1])
    order = np.argsort(np.concatenate([starts, cut]), kind="stable")
    begin = np.concatenate([starts, cut])[order]
    until = np.concatenate([ends, ends[at]])[order]
    until[:-1] = np.minimum(until[:-1], begin[1:])
    split = raw._replace(
        step_times=np.column_stack([begin, until - begin]),
        step_modes=np.concatenate([raw.step_modes, raw.step_modes[at]])[order],
        step_states=np.concatenate([raw.step_states, wide])[order],
    )
    return Trajectory(run.automaton, run.problem, split, run.samples, description=run.description)


def _sample(run: Trajectory, frame: Array, times: Array) -> tuple[Array, Array, Array]:
    """Tangent vectors at times, derivatives of the events' times, and tangent vectors at the end."""
    raw, width = run.raw, frame.shape[1]
    rows = np.ascontiguousarray(frame.T)
    starts = raw.step_times[:, 0]
    samples, moved = np.zeros((len(times), *frame.shape)), np.zeros((len(raw.event_times), width))
    marks = sorted(
        [*((t, 1, i) for i, t in enumerate(times)), *((t, 0, i) for i, t in enumerate(raw.event_times))]
    )
    first = 0
    for t, is_sample, i in marks:
        last = int(np.searchsorted(starts, t))
        if last > first:
            carry_rows(carry_steps, run, slice(first, last), rows)
            first = last
        if is_sample:
            samples[i] = rows.T
        else:
            moved[i] = _event_time_slopes(run, i, rows)
            rows = np.ascontiguousarray(rows @ event_saltation(run, i).T)
    if len(starts) > first:
        carry_rows(carry_steps, run, slice(first, len(starts)), rows)
    return samples, moved, rows.T.copy()


def _event_time_slopes(run: Trajectory, i: int, rows: Array) -> Array:
    """How the time of an event moves: the guard stays zero."""
    program, guard = run.problem.program, int(run.raw.event_codes[i, 0])
    mode, before = int(program.guard_modes[guard]), run.raw.event_states[i, 0]
    at, slot = linearise_mode(program, run.problem.numbers, mode, before), program.code.function_slots[guard]
    return -(rows @ at.gradients[slot]) / at.jets[slot, 1]


def _keep_constraints(run: Trajectory, frame: Array, n: int) -> None:
    """Move the states of each direction by the least that keeps the constraints of the first mode."""
    program, mode, z = run.problem.program, int(run.raw.step_modes[0]), run.raw.step_states[0]
    fixed = constraint_gradients(program, mode, linearise_mode(program, run.problem.numbers, mode, z))
    if len(fixed):
        frame[:n] -= np.linalg.pinv(fixed[:, :n]) @ (fixed @ frame)


def _scales(automaton: HybridAutomaton, names: Sequence[str]) -> Array:
    known = {symbol.name: float(value) for symbol, value in automaton.parameters.items()}
    return np.array([abs(known[name]) or 1.0 for name in names])


def _varied_run(
    run: Trajectory, names: tuple[str, ...], integrands: tuple[Any, ...]
) -> tuple[Trajectory, list[bool]]:
    """The run of the automaton with changes of parameters as states; which of these are in exponents."""
    automaton = run.automaton
    modes = tuple(automaton.mode(name) for name in run.mode_names)
    symbols = {symbol.name: symbol for symbol in automaton.parameters}
    chosen = tuple(symbols[name] for name in names)
    varied = _varied_modes(automaton.states, modes, chosen, integrands)
    numbers = dict(zip(map(_scale, chosen), _scales(automaton, names)))
    states = (*automaton.states, *varied.integrals, *map(_change, chosen))
    wider = HybridAutomaton(states, varied.modes, {**automaton.parameters, **numbers}, automaton.coordinates)
    more = len(states) - len(automaton.states)
    problem = Problem(*program_of(wider), np.append(run.problem.x0, np.zeros(more)), run.problem.t_end)
    raw = run.raw._replace(
        **{
            name: _with_zeros(getattr(run.raw, name), more)
            for name in ("step_states", "event_states", "point_states", "state")
        }
    )
    wide = Trajectory(wider, problem, raw, run.samples, description=run.description)
    return wide, [symbol in varied.exponents for symbol in chosen]


def _with_zeros(array: Array, more: int) -> Array:
    return np.concatenate([array, np.zeros((*array.shape[:-1], more))], axis=-1)


def _change(symbol: Any) -> Any:
    return sympy.Symbol(f"change of {symbol.name}")


def _scale(symbol: Any) -> Any:
    return sympy.Symbol(f"scale of {symbol.name}")


class _VariedModes(NamedTuple):
    modes: tuple[Mode, ...]
    integrals: tuple[Any, ...]
    exponents: frozenset[Any]


@lru_cache(maxsize=64)
def _varied_modes(
    states: tuple[Any, ...], modes: tuple[Mode, ...], chosen: tuple[Any, ...], integrands: tuple[Any, ...]
) -> _VariedModes:
    vary = _Variation(states, chosen)
    integrals = tuple(sympy.Symbol(f"integral {i}") for i in range(len(integrands)))
    rates, still = tuple(map(vary, integrands)), (sympy.S.Zero,) * len(chosen)
    known = {mode.name for mode in modes}

    def varied_reset(reset: Reset) -> Reset:
        jump = {state: vary(value) for state, value in reset.jump.items()}
        return Reset(jump, {vary(function): order for function, order in reset.vanishing.items()})

    def varied_event(event: Event) -> Event:
        closing = None if event.accumulation is None else varied_reset(event.accumulation)
        targets = tuple(name for name in event.targets if name in known)
        return Event(event.name, vary(event.function), targets, varied_reset(event.reset), closing)

    found = tuple(
        Mode(
            mode.name,
            (*map(vary, mode.flow), *rates, *still),
            tuple(map(varied_event, mode.events)),
            tuple(map(vary, mode.constraints)),
            {},
            mode.limit,
        )
        for mode in modes
    )
    return _VariedModes(found, integrals, frozenset(vary.exponents))


class _Variation:
    """Puts changes of the parameters into expressions, to first order."""

    def __init__(self, states: tuple[Any, ...], chosen: tuple[Any, ...]) -> None:
        self._states, self._chosen = frozenset(states), frozenset(chosen)
        self._known: dict[Any, Any] = {}
        self.exponents: set[Any] = set()  # parameters on which an exponent depends

    def __call__(self, expression: Any) -> Any:
        expr = sympy.sympify(expression, strict=True)
        if expr not in self._known:
            self._known[expr] = self._varied(expr)
        return self._known[expr]

    def _varied(self, expr: Any) -> Any:
        here = expr.free_symbols
        if here.isdisjoint(self._chosen):
            return expr
        if here.isdisjoint(self._states):
            return expr + self._linear(expr)
        if expr.is_Add or expr.is_Mul:
            alone = [a for a in expr.args if a.free_symbols.isdisjoint(self._states)]
            rest = [self(a) for a in expr.args if not a.free_symbols.isdisjoint(self._states)]
            return expr.func(self(expr.func(*alone)), *rest)
        if expr.is_Pow:
            self.exponents |= expr.exp.free_symbols & self._chosen
            return sympy.Pow(self(expr.base), expr.exp)
        return expr.func(*map(self, expr.args))

    def _linear(self, number: Any) -> Any:
        slopes = derivatives(number, self._chosen)
        # A jump, as of the sign of the belt's speed, has no derivative where it happens, and elsewhere zero.
        smooth = {p: d.replace(sympy.DiracDelta, lambda *_: 0) for p, d in slopes.items()}
        return sympy.Add(*(_scale(p) * slope * _change(p) for p, slope in smooth.items()))
