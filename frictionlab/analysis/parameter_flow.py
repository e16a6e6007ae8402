"""Derivatives of a run by the parameters: its tangent flow, with a small change of each parameter as a state.

A parameter p of size s becomes p + s e, with a state e that is and stays zero.  Only first order matters:
every coefficient N(p) of the equations is replaced by N + sum of s_k e_k dN/dp_k, so that flows, guards,
resets and constraints keep their form, and the saltation matrices hold how events depend on parameters.
The run is that of the model itself, to the last bit; only the tangent vectors are integrated anew.

A power u^p whose exponent depends on a parameter becomes u^p (1 + log(u) dp).  At u = 0, where a contact with
a force penetration^p begins, log(u) is not finite while u^p log(u) is zero.  There the tapes without this
term are used: at an event with u = 0, and in the first step from it, for which the run takes the power as
constant.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
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
    SaltationError,
    TangentScratch,
    carry_steps,
    constraint_gradients,
    linearise_mode,
)
from frictionlab.models.symbols import derivatives
from frictionlab.tape.packing import program_of

Array = NDArray[np.float64]
INNER = "chatter"  # a setting of the solver, not a parameter of the motion


class ParameterFlow(NamedTuple):
    """Derivatives of a run's end: by its initial state (n,), and by P parameters for a given start."""

    state: Array  # (n, n)
    parameters: Array  # (n, P)
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
        Whether changes of the start may violate the constraints of the first mode.  If not, and the mode has
        some (stick), each change is corrected by the least that keeps them.

    Raises
    ------
    ValueError
        Where the derivative does not exist or is not known; see :func:`frictionlab.tangent_flow`.
    """
    check_taylor_run(run)
    n, q, count = len(run.names), len(integrands), len(names)
    varied = _varied_run(run, tuple(names), tuple(integrands))
    *_, end = _carry(varied, _first_frame(varied, n, q, count, free))
    by_parameters = end[: n + q, n:] / _scales(run.automaton, names)
    return ParameterFlow(end[:n, :n], by_parameters[:n], end[n : n + q, :n], by_parameters[n:])


class SampledFlow(NamedTuple):
    """States of a run at some times and the times of its events, with derivatives.

    Derivatives are by the n states at the start, then by the P parameters.
    """

    states: Array  # (m, n)
    slopes: Array  # (m, n, n + P)
    events: Array  # (E,)
    event_slopes: Array  # (E, n + P)
    end: Array  # (n, n + P)


def sampled_flow(run: Trajectory, names: Sequence[str], times: Array, free: bool = False) -> SampledFlow:
    """Derivatives of a run's states at ascending times, of the times of its events, and of its end.

    At the time of an event the state's derivatives are those before it; `free` as for :func:`parameter_flow`.

    Raises
    ------
    ValueError
        As :func:`parameter_flow`.
    """
    n, count = len(run.names), len(names)
    varied = _varied_run(run, tuple(names), ())
    frame = _first_frame(varied, n, 0, count, free)
    scales = np.concatenate([np.ones(n), _scales(run.automaton, names)])
    states = run(np.asarray(times, dtype=float)) if len(times) else np.zeros((0, n))
    plain = None if varied.plain is None else _split_steps(varied.plain, times, states)
    split = _VariedRun(_split_steps(varied.run, times, states), plain)
    samples, moved, end = (part / scales for part in _carry(split, frame, times))
    return SampledFlow(states, samples[:, :n], run.raw.event_times, moved, end[:n])


def _split_steps(run: Trajectory, times: Array, states: Array) -> Trajectory:
    """The run, its steps split at the given times, so that tangent vectors can be sampled there."""
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


def _carry(
    varied: _VariedRun, frame: Array, times: Sequence[float] | Array = ()
) -> tuple[Array, Array, Array]:
    """Tangent vectors at times, derivatives of the events' times, and tangent vectors at the end."""
    raw, width = varied.run.raw, frame.shape[1]
    rows = np.ascontiguousarray(frame.T)
    carry = _carrier_of_steps(varied, rows)
    starts = raw.step_times[:, 0]
    samples, moved = np.zeros((len(times), *frame.shape)), np.zeros((len(raw.event_times), width))
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
            moved[i] = _event_time_slopes(varied, i, rows)
            rows[...] = rows @ saltation.T
        else:
            samples[i] = rows.T
    carry(slice(first, len(starts)))
    return samples, moved, rows.T.copy()


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
    """A run with changes of parameters as states, and one without changes in exponents, if there are any."""

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


def _saltation(varied: _VariedRun, i: int) -> Array:
    """Saltation matrix of an event."""
    if varied.plain is None:
        return event_saltation(varied.run, i)
    try:
        saltation = event_saltation(varied.run, i)
    except SaltationError:
        return event_saltation(varied.plain, i)
    return saltation if np.isfinite(saltation).all() else event_saltation(varied.plain, i)


def _scales(automaton: HybridAutomaton, names: Sequence[str]) -> Array:
    return np.array([abs(automaton.values[name]) or 1.0 for name in names], dtype=float)


def _varied_run(run: Trajectory, names: tuple[str, ...], integrands: tuple[Any, ...]) -> _VariedRun:
    """A run as one of the automaton with changes of parameters as states."""
    automaton = run.automaton
    modes = tuple(automaton.mode(name) for name in run.mode_names)
    symbols = {symbol.name: symbol for symbol in automaton.parameters}
    chosen = tuple(symbols[name] for name in names)
    of = automaton.states, modes, chosen, integrands
    varied = _varied_modes(*of, True)
    numbers = dict(zip(map(_scale, chosen), _scales(automaton, names)))
    states = (*automaton.states, *varied.integrals, *map(_change, chosen))
    more = len(states) - len(automaton.states)
    raw = run.raw._replace(
        **{
            name: _with_zeros(getattr(run.raw, name), more)
            for name in ("step_states", "event_states", "point_states", "state")
        }
    )

    def of_modes(those: tuple[Mode, ...]) -> Trajectory:
        numbered = {**automaton.parameters, **numbers}
        wider = HybridAutomaton(states, those, numbered, automaton.coordinates, automaton.cyclic)
        problem = Problem(*program_of(wider), np.append(run.problem.x0, np.zeros(more)), run.problem.t_end)
        return Trajectory(wider, problem, raw, run.samples, description=run.description)

    plain = of_modes(_varied_modes(*of, False).modes) if varied.in_exponents else None
    return _VariedRun(of_modes(varied.modes), plain)


def _with_zeros(array: Array, more: int) -> Array:
    return np.concatenate([array, np.zeros((*array.shape[:-1], more))], axis=-1)


def _change(symbol: Any) -> Any:
    return sympy.Symbol(f"change of {symbol.name}")


def _scale(symbol: Any) -> Any:
    return sympy.Symbol(f"scale of {symbol.name}")


class _VariedModes(NamedTuple):
    modes: tuple[Mode, ...]
    integrals: tuple[Any, ...]
    in_exponents: bool  # whether an exponent depends on a parameter


@lru_cache(maxsize=64)
def _varied_modes(
    states: tuple[Any, ...],
    modes: tuple[Mode, ...],
    chosen: tuple[Any, ...],
    integrands: tuple[Any, ...],
    exponents: bool,
) -> _VariedModes:
    vary = _Variation(states, chosen, exponents)
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

    varied = tuple(
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
    return _VariedModes(varied, integrals, vary.in_exponents)


class _Variation:
    """Puts changes of the parameters into expressions, to first order."""

    def __init__(self, states: tuple[Any, ...], chosen: tuple[Any, ...], exponents: bool) -> None:
        self._states, self._chosen, self._exponents = frozenset(states), frozenset(chosen), exponents
        self._known: dict[Any, Any] = {}
        self.in_exponents = False

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
            power = sympy.Pow(self(expr.base), expr.exp)
            if expr.exp.free_symbols.isdisjoint(self._chosen):
                return power
            self.in_exponents = True
            return power * (1 + sympy.log(expr.base) * self._linear(expr.exp)) if self._exponents else power
        return expr.func(*map(self, expr.args))

    def _linear(self, number: Any) -> Any:
        slopes = derivatives(number, self._chosen)
        # A function that jumps, as the sign of the belt's speed, has no derivative there, zero elsewhere.
        smooth = {p: d.replace(sympy.DiracDelta, lambda *_: 0) for p, d in slopes.items()}
        return sympy.Add(*(_scale(p) * slope * _change(p) for p, slope in smooth.items()))
