"""Derivatives of a run by the parameters: its tangent flow, with the parameters as states of zero rate.

Flows, guards, resets and constraints keep their form, and the saltation matrices hold how events depend on
parameters.  The run is that of the model itself, to the last bit; only the tangent vectors are integrated
anew.

A power u^p whose exponent depends on a parameter becomes u^c (1 + log(u) (p - c)), where c is the value of p.
At u = 0, where a contact with a force penetration^p begins, log(u) is not finite while u^p log(u) is zero.
There the tapes without this term are used: at an event with u = 0, and in the first step from it, for which
the run takes the power as constant.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import sympy
from numpy.typing import NDArray

from frictionlab.automaton import Event, HybridAutomaton, Mode, Reset
from frictionlab.compilation.loaded_kernels import prepared_call
from frictionlab.hybrid.codegen.native_cache import interpreted_code
from frictionlab.hybrid.kernels.run_state import StepData, Truncation
from frictionlab.hybrid.methods.base import RECORD_CAPACITY
from frictionlab.hybrid.problem import Problem
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.hybrid.variational.tangent_flow import (
    carry_rows,
    check_taylor_run,
    event_saltation,
)
from frictionlab.hybrid.variational.tangent_jets import (
    Saltation,
    SaltationError,
    TangentScratch,
    carry_steps,
    constraint_gradients,
    linearise_mode,
)
from frictionlab.tape.packing import program_of

Array = NDArray[np.float64]
INNER = "chatter"  # a setting of the solver, not a parameter of the motion
STATES_OF_RUN = "step_states", "event_states", "point_states", "state"


class ParameterFlow(NamedTuple):
    """States of a run at some times and the times of its events, with derivatives.

    Derivatives are by the n states at the start, then by P parameters for a given start.  At the end those of
    q integrals follow those of the states.
    """

    states: Array  # (m, n)
    slopes: Array  # (m, n, n + P)
    events: Array  # (E,)
    event_slopes: Array  # (E, n + P)
    end: Array  # (n + q, n + P)


def varied_names(automaton: HybridAutomaton) -> tuple[str, ...]:
    """Names of the parameters by which runs of an automaton have derivatives."""
    return tuple(symbol.name for symbol in automaton.parameters if symbol.name != INNER)


def parameter_flow(
    run: Trajectory,
    names: Sequence[str],
    times: Any = (),
    integrands: Sequence[Any] = (),
    *,
    free: bool = False,
) -> ParameterFlow:
    """Derivatives of a run's states at some times, of the times of its events, and of its end.

    Parameters
    ----------
    run : Trajectory
        Made by method "taylor".
    names : sequence of str
        Of P parameters.
    times : array_like (m,)
        They ascend.  At the time of an event the state's derivatives are those before it.
    integrands : sequence of sympy.Expr
        q functions of the states and parameters, whose integrals along the run have derivatives too.
    free : bool
        Whether changes of the start may violate the constraints of the first mode.  If not, and the mode has
        some (stick), each change is corrected by the least that keeps them.

    Raises
    ------
    ValueError
        Where the derivative does not exist or is not known; see :func:`frictionlab.tangent_flow`.
    """
    check_taylor_run(run)
    n, q = len(run.names), len(integrands)
    varied = _varied_run(run, tuple(names), tuple(integrands))
    frame = _first_frame(varied, n, q, len(names), free)
    at = np.asarray(times, dtype=float)
    states = run(at) if len(at) else np.zeros((0, n))
    plain = None if varied.plain is None else _split_steps(varied.plain, at, states)
    split = _VariedRun(_split_steps(varied.run, at, states), plain)
    samples, event_slopes, end = _carry(split, frame, at)
    return ParameterFlow(states, samples[:, :n], run.raw.event_times, event_slopes, end[: n + q])


def _split_steps(run: Trajectory, times: Array, states: Array) -> Trajectory:
    """The run, its steps split at the given times, so that tangent vectors can be sampled there."""
    raw = run.raw
    starts, lengths = raw.step_times.T
    places = np.searchsorted(starts, times, side="right") - 1
    ends = starts + lengths
    inside = (places >= 0) & (times > starts[places]) & (times < ends[places]) if len(starts) else places > 0
    if not inside.any():
        return run
    at, cut = places[inside], times[inside]
    wide = _with_states(states[inside], raw.state[states.shape[1] :])
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


def _carry(
    varied: _VariedRun, frame: Array, times: Sequence[float] | Array = ()
) -> tuple[Array, Array, Array]:
    """Tangent vectors at times, derivatives of the events' times, and tangent vectors at the end."""
    raw, width = varied.run.raw, frame.shape[1]
    rows = np.ascontiguousarray(frame.T)
    carry = _carrier_of_steps(varied, rows)
    starts = raw.step_times[:, 0]
    samples, event_slopes = np.zeros((len(times), *frame.shape)), np.zeros((len(raw.event_times), width))
    marks = sorted(
        [*((t, 0, i) for i, t in enumerate(times)), *((t, 1, i) for i, t in enumerate(raw.event_times))]
    )
    first = 0
    for t, is_event, i in marks:
        last = int(np.searchsorted(starts, t))
        carry(slice(first, last))
        first = last
        if is_event:
            saltation = _saltation(varied, i)  # raises where an event has no derivative
            event_slopes[i] = _event_time_slopes(varied, i, rows)
            rows[...] = saltation.carried(rows)
        else:
            samples[i] = rows.T
    carry(slice(first, len(starts)))
    return samples, event_slopes, rows.T.copy()


def _event_time_slopes(varied: _VariedRun, i: int, rows: Array) -> Array:
    """Derivatives of the time of an event, from the guard that stays zero."""
    for run in (one for one in varied if one is not None):
        program, guard = run.problem.program, int(run.raw.event_codes[i, 0])
        mode, before = int(program.guard_modes[guard]), run.raw.event_states[i, 0]
        slot = program.code.function_slots[guard]
        at = linearise_mode(program, run.problem.numbers, mode, before)
        slopes = -(rows @ at.gradients[slot]) / at.jets[slot, 1]
        if np.isfinite(slopes).all():
            break
    return slopes


def _first_frame(varied: _VariedRun, n: int, q: int, count: int, free: bool) -> Array:
    """Tangent vectors as columns: each of n states, then each of `count` parameters; q integrals are zero.

    Unless `free`, the states are corrected by the least that keeps the constraints of the first mode.
    """
    frame, run = np.zeros((n + q + count, n + count)), varied.run
    frame[:n, :n], frame[n + q :, n:] = np.eye(n), np.eye(count)
    if free or not len(run.raw.step_modes):
        return frame
    program, mode, z = run.problem.program, int(run.raw.step_modes[0]), run.raw.step_states[0]
    fixed = constraint_gradients(program, mode, linearise_mode(program, run.problem.numbers, mode, z))
    if len(fixed):
        frame[:n] -= np.linalg.pinv(fixed[:, :n]) @ (fixed @ frame)
    return frame


class _VariedRun(NamedTuple):
    """A run with parameters as states, and the one whose exponents do not vary, if they have any."""

    run: Trajectory
    plain: Trajectory | None


def _carrier_of_steps(varied: _VariedRun, rows: Array) -> Callable[[slice], None]:
    """A function that propagates the rows, tangent vectors, along steps without an event, in slices short
    enough for ctrl-C."""
    carry = _carrier(varied.run, rows)
    plain = None if varied.plain is None else _carrier(varied.plain, rows)

    def carry_steps_of(part: slice) -> None:
        if plain is None:
            for first in range(part.start, part.stop, RECORD_CAPACITY):
                carry(slice(first, min(first + RECORD_CAPACITY, part.stop)))
            return
        for i in range(part.start, part.stop):
            try:
                carry(slice(i, i + 1))
            except SaltationError:
                plain(slice(i, i + 1))

    return carry_steps_of


def _carrier(run: Trajectory, rows: Array) -> Callable[[slice], None]:
    """`carry_rows` with the same rows again and again; where it fails they are as before.

    A fit asks for the tangent vectors at each measured time, so that a call takes one step or two: what does
    not change is handed to the kernel once.
    """
    problem, raw, order = run.problem, run.raw, run.samples.order
    J = np.zeros((problem.program.slots, order + 1))
    scratch = TangentScratch(J, np.zeros((*J.shape, len(rows))))
    steps = StepData(*map(np.ascontiguousarray, (raw.step_times, raw.step_modes, raw.step_states)))
    truncation, code = Truncation(order, run.description["method"]["tol"]), interpreted_code(problem.program)
    arguments = code, problem.numbers, truncation, steps, raw.state.copy(), rows, scratch
    call = prepared_call(carry_steps, arguments, 3)

    def carry(part: slice) -> None:
        if part.start >= part.stop:
            return
        before = rows.copy()
        with np.errstate(all="ignore"):
            failed = call(StepData(steps.times[part], steps.modes[part], steps.states[part]))
        if failed >= 0 or not np.isfinite(rows).all():
            rows[...] = before
            try:
                carry_rows(carry_steps, run, part, rows)  # which says what is wrong
            finally:
                rows[...] = before

    return carry


def _saltation(varied: _VariedRun, i: int) -> Saltation:
    """Saltation of an event."""
    if varied.plain is None:
        return event_saltation(varied.run, i)
    try:
        saltation = event_saltation(varied.run, i)
    except SaltationError:
        return event_saltation(varied.plain, i)
    return saltation if np.isfinite(saltation.matrix).all() else event_saltation(varied.plain, i)


def _varied_run(run: Trajectory, names: tuple[str, ...], integrands: tuple[Any, ...]) -> _VariedRun:
    """A run as one of the automaton with parameters, and integrals, as further states."""
    automaton = run.automaton
    symbols = {symbol.name: symbol for symbol in automaton.parameters}
    free = tuple(symbols[name] for name in names)
    modes = tuple(automaton.mode(name) for name in run.mode_names)
    integrals = tuple(sympy.Symbol(f"integral {i}") for i in range(len(integrands)))
    held = {_held(symbol): automaton.parameters[symbol] for symbol in free}
    numbers = {symbol: value for symbol, value in automaton.parameters.items() if symbol not in free} | held
    states = (*automaton.states, *integrals, *free)
    start = np.concatenate([np.zeros(len(integrands)), [automaton.values[name] for name in names]])
    raw = run.raw._replace(**{name: _with_states(getattr(run.raw, name), start) for name in STATES_OF_RUN})

    def with_exponents(vary: bool) -> Trajectory:
        wider = _with_rates(modes, automaton.states, integrands, free, vary)
        of = replace(automaton.derived(), states=states, modes=wider, parameters=numbers)
        problem = Problem(*program_of(of), np.append(run.problem.x0, start), run.problem.t_end)
        return Trajectory(of, problem, raw, run.samples, description=run.description)

    plain = with_exponents(vary=False) if _in_exponents(modes, free) else None
    return _VariedRun(with_exponents(vary=True), plain)


def _with_states(array: Array, more: Array) -> Array:
    """An array (..., n) with the same further states everywhere."""
    return np.concatenate([array, np.broadcast_to(more, (*array.shape[:-1], len(more)))], axis=-1)


def _held(symbol: Any) -> Any:
    """The value of a parameter, which does not vary."""
    return sympy.Symbol(f"{symbol.name} held", positive=symbol.is_positive, real=symbol.is_real)


@lru_cache(maxsize=64)
def _with_rates(
    modes: tuple[Mode, ...],
    states: tuple[Any, ...],
    integrands: tuple[Any, ...],
    free: tuple[Any, ...],
    vary: bool,
) -> tuple[Mode, ...]:
    """Modes with the rates of integrals and parameters.

    Functions of parameters alone, which kernels need not know, vary to first order; exponents do, or not at
    all.
    """
    mode_names, more = {mode.name for mode in modes}, (*integrands, *(sympy.S.Zero for _ in free))
    held = {symbol: _held(symbol) for symbol in free}

    def power(base: Any, exponent: Any) -> Any:
        value = exponent.xreplace(held)
        return base**value * (1 + sympy.log(base) * (exponent - value) if vary and exponent != value else 1)

    def is_number(expr: Any) -> bool:
        return expr.is_Function and expr.free_symbols.isdisjoint(states)

    def linear(number: Any) -> Any:
        # A function that jumps, as the sign of the belt's speed, has no derivative there, zero elsewhere.
        slopes = {p: number.diff(p).replace(sympy.DiracDelta, lambda *_: 0) for p in free}
        changes = (slope.xreplace(held) * (p - held[p]) for p, slope in slopes.items())
        return sympy.Add(number.xreplace(held), *changes)

    def varied(expression: Any) -> Any:
        expr = sympy.sympify(expression, strict=True).replace(sympy.Pow, power)
        return expr.replace(is_number, linear)

    def varied_reset(reset: Reset) -> Reset:
        jump = {state: varied(value) for state, value in reset.jump.items()}
        return Reset(jump, {varied(function): order for function, order in reset.vanishing.items()})

    def varied_event(event: Event) -> Event:
        closing = None if event.accumulation is None else varied_reset(event.accumulation)
        targets = tuple(name for name in event.targets if name in mode_names)
        return Event(event.name, varied(event.function), targets, varied_reset(event.reset), closing)

    return tuple(
        replace(
            mode,
            flow=tuple(map(varied, (*mode.flow, *more))),
            events=tuple(map(varied_event, mode.events)),
            constraints=tuple(map(varied, mode.constraints)),
            outputs={},
        )
        for mode in modes
    )


@lru_cache(maxsize=64)
def _in_exponents(modes: tuple[Mode, ...], free: tuple[Any, ...]) -> bool:
    """Whether an exponent in a flow depends on one of the parameters."""
    rates = (sympy.sympify(rate, strict=True) for mode in modes for rate in mode.flow)
    powers = (power for rate in rates for power in rate.atoms(sympy.Pow))
    return any(not power.exp.free_symbols.isdisjoint(free) for power in powers)
