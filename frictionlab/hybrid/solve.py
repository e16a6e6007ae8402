"""`fl.solve`: run any hybrid automaton, by a method or the name of one."""

from __future__ import annotations

import logging
import time
import warnings
from collections.abc import Mapping, Sequence
from contextlib import suppress
from functools import cache, lru_cache
from math import isfinite
from typing import Any, NamedTuple

import numpy as np

from frictionlab.automaton import HybridAutomaton
from frictionlab.automaton.modes_on_demand import check_mode_name
from frictionlab.compilation.decorators import needs_compilation
from frictionlab.hybrid.chatter_limit import with_chatter_limit
from frictionlab.hybrid.methods.base import Method
from frictionlab.hybrid.methods.one_step import RK4
from frictionlab.hybrid.methods.scipy_methods import INTEGRATORS, Scipy
from frictionlab.hybrid.methods.taylor import Taylor
from frictionlab.hybrid.problem import Problem, Sampling, Status
from frictionlab.hybrid.real_powers import cut_where_undefined, undefined_start
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.hybrid.variational.tangent_jets import start_on_constraints
from frictionlab.interruption import Progress, interruption
from frictionlab.presentation import BACKWARDS, PHASE
from frictionlab.tape.arguments import (
    check_automaton,
    check_section_or_quadrature,
    read_expression,
)
from frictionlab.tape.formulas import Formulas, formulas_of, kept_formulas
from frictionlab.tape.packing import program_of
from frictionlab.tape.program import Numbers, Program, Section
from frictionlab.validation import (
    abbreviate,
    check_flag,
    check_mapping,
    check_number,
    check_t_end,
    did_you_mean,
    did_you_mean_or_known,
    explains_keywords,
    float_array,
)

TURN = 2.0 * np.pi  # after which the phase of a load begins anew
PHASE_ROUNDING = 64 * np.finfo(float).eps * TURN  # rad, by which it may begin below 0
NAMED_METHODS: dict[str, type[Method]] = {"taylor": Taylor, "rk4": RK4}
LOGGER = logging.getLogger(__name__)


def method_of(method: Any) -> Method:
    """The method itself, or the one of that name with its default settings; upper or lower case.

    Raises
    ------
    TypeError, ValueError
        Where it is a class, or there is no such method.
    """
    if isinstance(method, Method):
        return method
    named = _method_named(method.lower()) if isinstance(method, str) else None
    if named is not None:
        return named
    if isinstance(method, type) and issubclass(method, Method):
        name = method.__name__
        raise TypeError(f"method must be a frictionlab method, got the class {name}: write {name}()")
    known = [*NAMED_METHODS, *INTEGRATORS]
    names = ", ".join(map(repr, known))
    raise ValueError(
        f"method must be a frictionlab method or one of {names}, "
        f"got {abbreviate(method)}{did_you_mean(method, known)}"
    )


@cache
def _method_named(name: str) -> Method | None:
    """The method of a lower-case name, None where there is none; cached, as methods never change."""
    integrators = {each.lower(): each for each in INTEGRATORS}
    if name in integrators:
        return Scipy(integrators[name])
    return NAMED_METHODS[name]() if name in NAMED_METHODS else None


class RunOptions(NamedTuple):
    """Options of a run: the mode it starts in, what it records, whether it shows its progress, its model.

    The fields are arguments of :func:`solve`.
    """

    mode: str | None = None
    t_eval: Any = None
    sections: Mapping[str, Any] | None = None
    quadratures: Mapping[str, Any] | None = None
    progress: bool = True
    source: Any = None

    def check(self) -> None:
        """Raise unless the options are of the right kind."""
        if type(self.progress) is not bool:
            check_flag("progress", self.progress)
        source = self.source
        known = source is None or isinstance(source, HybridAutomaton) or hasattr(source, "automaton")
        if not known or isinstance(source, type):
            raise TypeError(
                f"source must be the model of the automaton, got {abbreviate(source)}: leave it out, or "
                "give the model itself"
            )
        if self.sections is not None:
            check_mapping("sections", self.sections, 'give each a name, such as {"top": (expression, -1)}')
        if self.quadratures is not None:
            check_mapping("quadratures", self.quadratures, 'give each a name, such as {"work": expression}')


@explains_keywords
def solve(
    automaton: HybridAutomaton,
    t_end: float,
    *,
    x0: Any,
    mode: str | None = None,
    method: str | Method = "taylor",
    t_eval: Any = None,
    sections: Mapping[str, Any] | None = None,
    quadratures: Mapping[str, Any] | None = None,
    progress: bool = True,
    source: Any = None,
) -> Trajectory:
    """Run an automaton from 0 to `t_end`.

    Parameters
    ----------
    automaton : HybridAutomaton
    t_end : float
        End time in seconds, positive.
    x0 : array_like or mapping
        Initial values of all states; or of some by name, ``{"x1": 0.1}``, the others zero.  The phase of a
        load may be outside of a turn, which stands for that within it.
    mode : str or None
        Mode to start in; None takes the first admissible one, as after every event.
    method : "taylor", "rk4", the name of a scipy method, Taylor, RK4, Scipy
        Names may be in upper or lower case.
    t_eval : array_like or None
        Ascending times of the samples, one at least; None samples every step.
    sections : mapping of name to expression or (expression, direction)
        Zero crossings to record; they change no mode.  Each expression is a sympy expression of the states
        and parameters, a text such as "x1' - v" (x1' is the rate of x1), or the name of an output.
        The direction is +1 for rising, -1 for falling, 0 for both.  Only method "taylor" takes `sections`
        and `quadratures`.
    quadratures : mapping of name to expression
        Functions to be integrated over the run.  Step lengths take their accuracy into account too.
    progress : bool
        Show a progress bar on runs of more than a second.
    source : Model or None
        The model that the automaton comes from, kept as ``run.source``; saved runs store its ``to_dict()``.

    Returns
    -------
    Trajectory
        Also where the run ended early: see ``run.status``.

    Warns
    -----
    RuntimeWarning
        Where some steps are far less exact than the tolerance: see ``run.warning``.

    Raises
    ------
    TypeError
        Where `automaton` is no HybridAutomaton, or a keyword is unknown.
    ValueError
        For other bad arguments.  Both are raised before any step is taken.
    KeyboardInterrupt
        After ctrl-C; :func:`partial_result` then returns the run as far as it went.
    """
    options = RunOptions(mode, t_eval, sections, quadratures, progress, source)
    check_automaton(automaton)
    start = with_phase_in_turn(automaton, state_from_x0(automaton, x0))
    return with_warning(run_automaton(automaton, t_end, start, method_of(method), options))


def end_of(run: Trajectory) -> tuple[np.ndarray, str | None]:
    """The last state (n,) of a run, and its mode; None where the run has ended early."""
    return run.final_state, run.mode_names[run.raw.mode] if run.status.ok else None


def solve_from_end(
    automaton: HybridAutomaton, t_end: float, state: np.ndarray, mode: str | None, **options: Any
) -> Trajectory:
    """As :func:`solve`, from the state (n,) and the mode in which another run ended.

    The mode belongs to what a motion depends on: with hysteresis several are admissible at one state.  Where
    the run ended at an event, rounding may have put its state just behind; then the mode is chosen anew.
    """
    return with_warning(try_from_end(automaton, t_end, state, mode, **options))


def try_from_end(
    automaton: HybridAutomaton,
    t_end: float,
    state: np.ndarray,
    mode: str | None,
    method: str | Method = "taylor",
    **options: Any,
) -> Trajectory:
    """As :func:`solve_from_end`, without a warning: where a search tries values, some runs end early."""
    check_automaton(automaton)
    start, solver = with_phase_in_turn(automaton, state_from_x0(automaton, state)), method_of(method)
    if mode is not None:
        with suppress(ValueError):
            return run_automaton(automaton, t_end, start, solver, RunOptions(mode, **options))
    return run_automaton(automaton, t_end, start, solver, RunOptions(**options))


def with_warning(run: Trajectory) -> Trajectory:
    """The run itself; warns where its steps are less exact than the tolerance asks for."""
    if run.warning is not None:
        warnings.warn(f"do not trust this run: {run.warning}", RuntimeWarning, stacklevel=4)
    return run


def run_automaton(
    automaton: HybridAutomaton, t_end: Any, state: np.ndarray, method: Method, options: RunOptions
) -> Trajectory:
    """Run an automaton by a method, as :func:`solve` says, from a checked state and without a warning."""
    options.check()
    t_end = float(check_t_end(t_end))
    times = None if options.t_eval is None else _times(options.t_eval, t_end)
    recording = _records(automaton, options) if options.sections or options.quadratures else None
    if recording is not None and not method.records_sections:
        raise ValueError(
            f"sections and quadratures need method='taylor', got {abbreviate(method)}: change the method"
        )
    chatter = method.chatter_limit(automaton)
    automaton = with_chatter_limit(automaton, chatter)
    # Such a run numbers modes as they are derived, a kept program in the automaton's order.
    if recording is not None and automaton.on_demand:
        automaton = automaton.derived()
    if options.mode is not None:
        check_mode_name(options.mode, automaton.names)
    start = state if recording is None else np.concatenate([state, np.zeros(len(recording.quadratures))])
    problem = problem_of(automaton, start, t_end, options.mode, recording, chatter)
    if problem.mode is not None:
        onto = start_on_constraints(problem.program, problem.numbers, problem.mode, problem.x0)
        problem = problem._replace(x0=onto)
    order, begin = method.order_of(problem.program), time.perf_counter()
    compiles = options.progress and needs_compilation(method.entry)
    with Progress(t_end, options.progress, compiles) as bar:
        raw = method.integrate(problem, order, bar)
    wall_time = time.perf_counter() - begin
    counts = len(raw.step_modes), len(raw.event_times)
    LOGGER.debug("run to %g s: %d steps, %d events, %.3g s, %r", raw.t, *counts, wall_time, raw.status)
    if recording is not None or automaton.on_demand:  # the result has no integrals, and all modes derived
        own = problem_of(automaton, start, t_end, options.mode, recording).program
        problem = problem_of(automaton, state, t_end, options.mode)
        raw = raw.renumbered(own, problem.program)
    if problem.program.has_powers:
        raw = cut_where_undefined(problem, raw)
    ended_at_start = raw.status is Status.NOT_FINITE and not len(raw.step_modes)
    if ended_at_start and (words := undefined_start(automaton, problem, raw.mode)):
        raise ValueError(f"x0 {words}")
    sections, quadratures = (), None
    if recording is not None:
        integrals = raw.state[len(state) :].tolist()
        sections, quadratures = tuple(recording.sections), dict(zip(recording.quadratures, integrals))
        raw = raw.cut(len(state))
    run = Trajectory(
        automaton,
        problem,
        raw,
        Sampling(order, method.parts, times, sections),
        quadratures=quadratures,
        description={"method": method.describe(), "t_end": t_end},
        source=options.source,
        wall_time=wall_time,
    )
    if bar.stopped:
        raise interruption(f"the run was stopped at {run.raw.t:g} of {t_end:g} s", run)
    return run


def by_names(x0: Any) -> Any:
    """An initial state with the names of states as labels, such as a pandas Series, as a mapping; anything
    else as it is."""
    labels = getattr(x0, "index", None)
    if labels is None or callable(labels) or not all(isinstance(label, str) for label in labels):
        return x0
    return dict(zip(labels, x0.tolist(), strict=True)) if hasattr(x0, "tolist") else x0


def state_from_mapping(automaton: HybridAutomaton, given: Mapping[str, Any], rest: Any) -> np.ndarray:
    """The state with the values `given` by name; the other states have those of `rest`."""
    check_mapping("x0", given, "give states by their names")
    state, names = np.array(rest, dtype=float), list(automaton.state_names)
    for name, value in given.items():
        if name not in names:
            raise ValueError(f"x0 has no state {abbreviate(name)}{did_you_mean_or_known(name, names)}")
        state[names.index(name)] = check_number(f"x0[{abbreviate(name)}]", value, cure="give one in SI units")
    return state


def with_phase_in_turn(automaton: HybridAutomaton, states: np.ndarray) -> np.ndarray:
    """States (..., n) whose phase, if an event begins it anew after a turn, is within that turn.

    Raises
    ------
    ValueError
        Where it runs backwards: below 0 no event begins it anew, and laws in pieces of it do not repeat.
    """
    if PHASE not in automaton.state_names:
        return states
    i = automaton.state_names.index(PHASE)
    beyond = (states[..., i] < -PHASE_ROUNDING) | (states[..., i] > TURN)
    slowest = float(np.min(_rates_of_phase(automaton, i, states), initial=0.0))
    if not (slowest < 0.0 or beyond.any()) or not _begins_anew(automaton, i):
        return states
    if slowest < 0.0:
        raise ValueError(_words_on_rate(automaton, i, slowest))
    states = states.copy()
    states[..., i] = np.where(beyond, states[..., i] % TURN, states[..., i])
    return states


def _rates_of_phase(automaton: HybridAutomaton, i: int, states: np.ndarray) -> Any:
    """The rates of the state number `i`, a phase, in the first mode: those of models are the same in all."""

    def derive() -> Formulas:
        return _formula_of_rate(automaton.modes[0].flow[i], automaton.states, tuple(automaton.parameters))

    formula = kept_formulas(automaton.derivations, "rate of the phase", derive)
    return formula.along_run(*np.moveaxis(states, -1, 0), *automaton.values.values())[0]


@lru_cache(maxsize=64)
def _formula_of_rate(rate: Any, states: tuple, parameters: tuple) -> Formulas:
    return formulas_of([*states, *parameters], [rate])


def _words_on_rate(automaton: HybridAutomaton, i: int, rate: float) -> str:
    inputs = getattr(automaton.modes[0].flow[i], "free_symbols", ())
    values = [
        f"{symbol.name} = {value:g}" for symbol, value in automaton.parameters.items() if symbol in inputs
    ]
    at = " at " * bool(values) + ", ".join(values)
    return BACKWARDS.format(rate=f"{rate:g}", at=at)


def _begins_anew(automaton: HybridAutomaton, i: int) -> bool:
    """Whether an event takes a turn off the state number `i`."""
    phase: Any = automaton.states[i]
    jumps = (event.reset.jump.get(phase, phase) for event in automaton.modes[0].events)
    return any((phase - jump).is_number and float(phase - jump) == TURN for jump in jumps)


def state_from_x0(automaton: HybridAutomaton, x0: Any) -> np.ndarray:
    """The initial state (n,) that an array or a mapping stands for; raises unless it is finite."""
    names = automaton.state_names
    plain = type(x0) is np.ndarray and x0.shape == (len(names),) and x0.dtype == float
    if plain and all(map(isfinite, x0.tolist())):  # the quick case
        return x0.copy()
    x0 = by_names(x0)
    if isinstance(x0, Mapping):
        return state_from_mapping(automaton, x0, np.zeros(len(names)))
    rule = f"a finite number for each of the states {', '.join(names)}"
    cure = f"give {len(names)} numbers, in this order"
    state = float_array("x0", x0, f"give {rule}")
    if state.shape != (len(names),) or not np.isfinite(state).all():
        raise ValueError(f"x0 must hold {rule}, got {abbreviate(x0)}: {cure}")
    return state


def _times(t_eval: Any, t_end: float) -> np.ndarray:
    rule = f"ascending times within 0 and t_end ({t_end:g})"
    times = float_array("t_eval", t_eval, f"give {rule}")
    if times.ndim != 1 or not len(times):
        raise ValueError(
            f"t_eval must be an array of {rule}, one at least, got {abbreviate(t_eval)}: "
            "leave it out to have every step"
        )
    good = (np.diff(times, prepend=0.0) >= 0.0) & (times <= t_end)
    if not good.all():
        i = int(good.argmin())
        before = f" after {float(times[i - 1])!r}" if i else ""
        raise ValueError(
            f"t_eval must be {rule}, got t_eval[{i}] = {float(times[i])!r}{before}: sort or cut it"
        )
    return times


class Recording(NamedTuple):
    """What is recorded of a run besides its steps and events, as expressions of the automaton."""

    sections: dict[str, Section]
    quadratures: dict[str, Any]


def _records(automaton: HybridAutomaton, options: RunOptions) -> Recording:
    sections, quadratures = options.sections or {}, options.quadratures or {}

    def read(kind: str, name: str, function: Any) -> Any:
        expression = read_expression(automaton, function, f"{kind} {name!r}")
        check_section_or_quadrature(name, expression, automaton)
        return expression

    asked = {name: _section(name, each) for name, each in sections.items()}
    return Recording(
        {name: each._replace(function=read("section", name, each.function)) for name, each in asked.items()},
        {name: read("quadrature", name, function) for name, function in quadratures.items()},
    )


def _section(name: str, asked: Any) -> Section:
    function, direction, *more = asked if isinstance(asked, tuple) and len(asked) > 1 else (asked, 0)
    if more or isinstance(function, (tuple, list)):
        raise ValueError(
            f"section {name!r} must be an expression or a tuple (expression, direction), got "
            f"{abbreviate(asked)}: write such a tuple, as (x, -1)"
        )
    check_number(
        f"the direction of section {name!r}", direction, integer=True, least=-1, most=1, cure="0 takes both"
    )
    return Section(function, direction)


# An automaton never changes, so neither does its program.
_program_of = lru_cache(maxsize=64)(program_of)


def _combination_of(automaton: HybridAutomaton, mode: str) -> tuple[int, ...]:
    modes: Any = automaton.modes
    return modes.names.combination_of(mode)


def problem_of(
    automaton: HybridAutomaton,
    x0: np.ndarray,
    t_end: float,
    mode: str | None = None,
    recording: Recording | None = None,
    chatter: float = 0.0,
) -> Problem:
    """The automaton as a program that runs from `x0`, with sections and quadratures to record.

    Modes on demand are derived when the run comes to them.
    """
    if not automaton.on_demand:
        program, numbers = _program_of(automaton) if recording is None else program_of(automaton, *recording)
        number = None if mode is None else program.modes.index(mode)
        return Problem(program, numbers, x0, t_end, number, chatter=chatter)

    def derive(combinations: Sequence[tuple[int, ...]]) -> tuple[Program, Numbers]:
        for combination in combinations:
            modes: Any = automaton.modes  # not before one is asked for: it loads sympy
            modes.mode(combination)
        return program_of(automaton, *(recording or ()), complete=False, combinations=combinations)

    program, numbers = derive([] if mode is None else [_combination_of(automaton, mode)])
    number = None if mode is None else program.modes.index(mode)
    return Problem(program, numbers, x0, t_end, number, derive, chatter)
