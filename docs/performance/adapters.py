"""Adapters of other tools: scipy's solve_ivp, CVODE and PathSim, which call back functions of a mode; heyoka
and diffrax, which compile each mode.

scipy as users call it: compiled right-hand side, a call for each stay in a mode, terminal events.  CVODE
(Hindmarsh et al. 2005) with its root finding, through scikit-sundae.  PathSim: block diagrams in
Python; each mode is an ODE block with its zero crossings.

heyoka (Biscani & Izzo 2021): Taylor series of high order, with event detection.  diffrax (Kidger 2021):
each mode's integration up to its first event is compiled once, by JAX.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from importlib import import_module
from typing import Any, ClassVar, NamedTuple

import numpy as np
import sympy

from external import CompiledMode, ExternalMethod, RestartedMethod
from frictionlab.automaton import Mode
from frictionlab.tape.functions import AFFINE, OPERATION_NAMES, POWER, PRODUCT, QUOTIENT, RATE, SQUARE
from frictionlab.tape.lowering import lower_mode
from frictionlab.tape.tape import Tape

IMPLICIT = ("Radau", "BDF", "LSODA")

BITE = 1e-7  # s: the first step of heyoka in a mode; a tenth of the shortest stay that is no chatter
EVALUATIONS_PER_STEP = 13  # evaluations in a step of RKDP87, to cap the steps
EVENT_TOLERANCE = 1e-12  # of time (s) and of a guard: smaller ones use up all iterations of the search


@dataclass(frozen=True)
class SolveIvp(ExternalMethod):
    """scipy.integrate.solve_ivp; the implicit methods are given the exact Jacobian.

    Parameters
    ----------
    integrator : str
        RK45, DOP853, LSODA, Radau ...
    rtol, atol : float
    """

    name: ClassVar[str] = "solve_ivp"

    integrator: str = "DOP853"
    rtol: float = 1e-10
    atol: float = 1e-13

    def prepare(self, z: np.ndarray) -> None:
        super().prepare(z)
        for functions in self.modes if self.integrator in IMPLICIT else ():
            functions.jacobian(z, np.empty(z.size**2))  # LSODA asks for it only where it is stiff

    def to_event(
        self, mode: int, z: np.ndarray, t: float, t_end: float
    ) -> tuple[float, np.ndarray, int, int]:
        from scipy.integrate import solve_ivp

        functions = self.modes[mode]
        events = [_event(functions, i) for i in range(functions.count)]

        def rates(time: float, y: np.ndarray) -> np.ndarray:
            out = np.empty_like(y)
            functions.rates(y, out)
            return out

        def jacobian(time: float, y: np.ndarray) -> np.ndarray:
            out = np.empty(y.size**2)
            functions.jacobian(np.ascontiguousarray(y), out)
            return out.reshape(y.size, y.size)

        options: dict[str, Any] = {"method": self.integrator, "rtol": self.rtol, "atol": self.atol}
        if self.integrator in IMPLICIT:
            options["jac"] = jacobian
        solution = solve_ivp(rates, (t, t_end), z, events=events, **options)
        hit = [i for i in range(functions.count) if len(solution.t_events[i])]
        guard = hit[0] if hit else -1
        return float(solution.t[-1]), solution.y[:, -1].copy(), guard, len(solution.t) - 1


def _event(functions: CompiledMode, i: int) -> Callable[[float, np.ndarray], float]:
    values = np.empty(functions.count)

    def event(time: float, y: np.ndarray) -> float:
        functions.guards(np.ascontiguousarray(y), values)
        return float(values[i])

    # solve_ivp reads these two from the function; the type checker knows no attributes of functions
    event.terminal, event.direction = True, -1  # type: ignore[attr-defined]  # scipy reads them
    return event


@dataclass(frozen=True)
class Cvode(ExternalMethod):
    """SUNDIALS' multistep methods.

    Parameters
    ----------
    formula : "Adams" or "BDF"
    rtol, atol : float
    """

    name: ClassVar[str] = "cvode"

    formula: str = "Adams"
    rtol: float = 1e-11
    atol: float = 1e-14

    def to_event(
        self, mode: int, z: np.ndarray, t: float, t_end: float
    ) -> tuple[float, np.ndarray, int, int]:
        functions = self.modes[mode]
        options: dict[str, Any] = {"method": self.formula, "rtol": self.rtol, "atol": self.atol}
        if functions.count:
            options |= {"eventsfn": _events(functions), "num_events": functions.count}
        solver = import_module("sksundae.cvode").CVODE(
            lambda time, y, out: functions.rates(y, out), max_num_steps=10**7, **options
        )
        solution = solver.solve(np.array([t, t_end]), z)
        steps = len(solution.t) - 1  # given only two times, it returns all of its own steps
        if solution.i_events is None or not len(solution.i_events):
            return float(solution.t[-1]), np.array(solution.y[-1]), -1, steps
        guard = int(np.flatnonzero(solution.i_events[-1])[0])
        return float(solution.t_events[-1]), np.array(solution.y_events[-1]), guard, steps


def _events(functions: CompiledMode) -> Any:
    def events(time: float, y: np.ndarray, out: np.ndarray) -> None:
        functions.guards(y, out)

    # sksundae reads these two from the function; the type checker knows no attributes of functions
    both = [True] * functions.count, [-1] * functions.count
    events.terminal, events.direction = both  # type: ignore[attr-defined]  # as above
    return events


@dataclass(frozen=True)
class PathSim(RestartedMethod):
    """A simulation for each mode, built once.

    Parameters
    ----------
    solver : str
        RKDP87, RKV65, RKDP54, ...
    rtol, atol : float
    located : float
        An event counts as located where its guard is no larger than this.
    """

    name: ClassVar[str] = "pathsim"

    solver: str = "RKDP87"
    rtol: float = 1e-10
    atol: float = 1e-13
    located: float = 1e-10

    @cached_property
    def diagrams(self) -> list[_Diagram]:
        """The diagrams of all modes."""
        return [_Diagram(self, functions) for functions in self.modes]

    def flow(self, mode: int, z: np.ndarray, length: float) -> tuple[float, np.ndarray, int, int]:
        return self.diagrams[mode].run(z, length, self.max_steps - self.steps)


class _Diagram:
    """One ODE block, and for each guard an event that stops the simulation; each run starts at time zero."""

    def __init__(self, settings: PathSim, functions: CompiledMode) -> None:
        pathsim: Any = import_module("pathsim")
        self.functions, self.values = functions, np.empty(functions.count)
        self.halt: type[Exception] = pathsim.StopSimulation
        self.block = pathsim.blocks.ODE(self._rates, np.zeros(len(settings.automaton.states)))
        crossing = pathsim.events.ZeroCrossingDown
        self.simulation = pathsim.Simulation(
            [self.block],
            events=[
                crossing(self._guard(i), self._stop(i), settings.located) for i in range(functions.count)
            ],
            Solver=getattr(pathsim.solvers, settings.solver),
            log=False,
            tolerance_lte_rel=settings.rtol,
            tolerance_lte_abs=settings.atol,
        )

    def run(self, z: np.ndarray, length: float, most: int) -> tuple[float, np.ndarray, int, int]:
        """Integrate from `z` up to an event or the end: time passed, state, guard or -1, steps."""
        self.event: tuple[float, np.ndarray, int] | None = None
        self.left = EVALUATIONS_PER_STEP * most
        self.block.initial_value = z
        self.simulation.dt = None  # PathSim then estimates the first step
        self.simulation.reset()
        steps = self.simulation.run(length)["successful_steps"]
        end = self.event or (float(self.simulation.time), self.block.engine.state.copy(), -1)
        return *end, steps if self.left >= 0 else most

    def _rates(self, z: np.ndarray, u: np.ndarray, t: float) -> np.ndarray:
        self.left -= 1
        if self.left < 0:
            raise self.halt("step cap")
        out = np.empty_like(z)
        self.functions.rates(z, out)
        return out

    def _guard(self, i: int) -> Callable[[float], float]:
        def value(t: float) -> float:
            self.functions.guards(self.block.engine.state, self.values)
            return float(self.values[i])

        return value

    def _stop(self, i: int) -> Callable[[float], None]:
        def stop(t: float) -> None:
            # Kept at once: PathSim takes the step back if a later event of it is still to be located.
            self.event = self.event or (float(t), self.block.engine.state.copy(), i)
            self.simulation.stop()

        return stop


@dataclass(frozen=True)
class Heyoka(ExternalMethod):
    """heyoka's adaptive Taylor integrator.

    Parameters
    ----------
    tol : float
    fast_math : bool
        Whether its compiler may change the order of operations.
    """

    name: ClassVar[str] = "heyoka"

    tol: float = 1e-15
    fast_math: bool = False

    @cached_property
    def flows(self) -> list[_HeyokaFlow]:
        """One for each mode."""
        automaton, values = self.automaton, self.values
        return [
            _heyoka_flow(mode, automaton.states, values, self.tol, self.fast_math) for mode in automaton.modes
        ]

    def to_event(
        self, mode: int, z: np.ndarray, t: float, t_end: float
    ) -> tuple[float, np.ndarray, int, int]:
        flow = self.flows[mode]
        integrator, steps = flow.integrator, 0
        if flow.start is not None:
            # If an event function is zero at the start of a step, heyoka does not find its next zero, so a
            # short first step is taken without events.
            start = flow.start
            start.time, flow.start_state[:] = t, z
            start.step(min(BITE, t_end - t))
            t, z, steps = start.time, flow.start_state, 1
            integrator.reset_cooldowns()
        integrator.time, flow.state[:] = t, z
        outcome, _, _, more, *_ = integrator.propagate_until(t_end)
        code = int(outcome)
        # A terminal event i that stops the integration gives the outcome -i - 1.
        guard = -code - 1 if -1000 < code < 0 else -1
        return integrator.time, flow.state, guard, steps + more


class _HeyokaFlow(NamedTuple):
    """A mode's integrator, one without events for the first step (None if the mode has none), and views of
    their states."""

    integrator: Any
    state: np.ndarray
    start: Any
    start_state: np.ndarray


@lru_cache(maxsize=64)
def _heyoka_flow(
    mode: Mode, states: tuple[Any, ...], values: tuple[Any, ...], tol: float, fast_math: bool
) -> _HeyokaFlow:
    """heyoka's integrators of a mode; the parameter values are compiled in as constants."""
    hy: Any = import_module("heyoka")
    lowered = lower_mode(mode, states, (), ())
    slots = _heyoka_slots(lowered.tape, dict(values), hy)
    system = [(slots[i], slots[rate]) for i, rate in enumerate(lowered.flow)]
    # A guard is positive while its mode lasts.
    falls = hy.event_direction.negative
    events = [hy.t_event(slots[guard], direction=falls) for guard in lowered.guards]
    options: dict[str, Any] = {"tol": tol, "compact_mode": False, "fast_math": fast_math}
    whole = hy.taylor_adaptive(system, [0.0] * len(states), t_events=events, **options)
    start = hy.taylor_adaptive(system, [0.0] * len(states), **options) if events else whole
    return _HeyokaFlow(whole, whole.state, start if events else None, start.state)


def _heyoka_slots(tape: Tape, values: dict[Any, float], hy: Any) -> list[Any]:
    """heyoka's expression of each slot of a tape.

    The operations are those of our own solver, what is common once: an expression of sympy in which the
    numbers are put is expanded, and takes heyoka a quarter more operations and half as much time again.
    """
    slots = [hy.expression(f"z{i}") for i in range(tape.inputs)]

    def number(expression: Any) -> float:
        return float(sympy.sympify(expression, strict=True).subs(values))

    for (kind, a, b), constant in zip(tape.ops, tape.constants, strict=True):
        if kind == AFFINE:
            scaled = [(number(factor), slots[slot]) for slot, factor in tape.terms[a:b]]
            parts = [part if factor == 1.0 else factor * part for factor, part in scaled]
            slots.append(hy.sum([hy.expression(number(constant)), *parts] if number(constant) else parts))
        elif kind in (PRODUCT, SQUARE):
            slots.append(slots[a] * slots[b])
        elif kind == QUOTIENT:
            slots.append(slots[a] / slots[b])
        elif kind == RATE:  # belongs to the next operation of our tape
            slots.append(None)
        elif kind == POWER:
            slots.append(hy.pow(slots[a], number(constant)))
        else:
            slots.append(getattr(hy, OPERATION_NAMES[kind])(slots[a]))
    return slots


@dataclass(frozen=True)
class Diffrax(RestartedMethod):
    """diffeqsolve with Dopri8, a PID controller and events located by bisection.

    Parameters
    ----------
    rtol, atol : float
    """

    name: ClassVar[str] = "diffrax"

    rtol: float = 1e-10
    atol: float = 1e-13

    @cached_property
    def solutions(self) -> list[Callable[..., Any]]:
        """The compiled integration of each mode."""
        automaton, values = self.automaton, self.values
        return [_compile_solution(mode, automaton.states, values, self.max_steps) for mode in automaton.modes]

    def flow(self, mode: int, z: np.ndarray, length: float) -> tuple[float, np.ndarray, int, int]:
        # Double precision is set here only: other users of JAX in the process may want single precision.
        with import_module("jax").enable_x64(True):
            t, y, guard, steps = self.solutions[mode](z, length, self.rtol, self.atol)
        return float(t), np.array(y), int(guard), int(steps)


@lru_cache(maxsize=64)
def _compile_solution(
    mode: Mode, states: tuple[Any, ...], values: tuple[Any, ...], max_steps: int
) -> Callable[..., Any]:
    """A function of start, length and tolerances, compiled once: time, state, guard and steps at the end."""
    jax, dx = import_module("jax"), import_module("diffrax")
    rates = _jax_function(states, mode.flow, values)
    guards = _jax_function(states, [event.function for event in mode.events], values) if mode.events else None
    term = dx.ODETerm(lambda t, y, args: rates(y))

    def solution(z: Any, length: Any, rtol: Any, atol: Any) -> Any:
        solved = dx.diffeqsolve(
            term,
            dx.Dopri8(),
            t0=0.0,
            t1=length,
            dt0=None,
            y0=z,
            args=guards(z) <= 0.0 if guards else None,
            stepsize_controller=dx.PIDController(rtol=rtol, atol=atol),
            event=_diffrax_event(guards) if guards else None,
            max_steps=max_steps,
            throw=False,
        )
        y = solved.ys[-1]
        guard = jax.numpy.where(solved.event_mask, guards(y).argmin(), -1) if guards else -1
        capped = solved.result == dx.RESULTS.max_steps_reached  # counts rejected steps too
        steps = jax.numpy.where(capped, max_steps, solved.stats["num_accepted_steps"])
        return solved.ts[-1], y, guard, steps

    return jax.jit(solution)


def _diffrax_event(guards: Callable[[Any], Any]) -> Any:
    """The event that the smallest guard falls through zero; at the start, guards that are zero do not count.

    It is one function for all guards: of several events in a step diffrax takes the first in the list, not in
    time, and bisection, the root finder that cannot miss, wants one function.
    """
    where: Any = import_module("jax.numpy").where

    def smallest(t: Any, y: Any, args: Any, **_: Any) -> Any:
        return where(args & (t <= 0.0), 1.0, guards(y)).min()

    bisection = import_module("optimistix").Bisection(rtol=0.0, atol=EVENT_TOLERANCE, flip=True)
    return import_module("diffrax").Event(smallest, bisection, direction=False)


def _jax_function(states: tuple[Any, ...], expressions: Sequence[Any], values: tuple[Any, ...]) -> Any:
    """The expressions as a function from an array of states to an array of values."""
    stack, numbers = import_module("jax.numpy").stack, dict(values)
    with_numbers = [sympy.sympify(e, strict=True).subs(numbers) for e in expressions]
    function = sympy.lambdify(states, with_numbers, modules="jax", cse=True)
    return lambda y: stack(function(*y))
