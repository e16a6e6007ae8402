"""`fl.solve`: run any hybrid automaton."""

from __future__ import annotations

import time
from collections.abc import Mapping
from contextlib import suppress
from typing import Any

import numpy as np

from frictionlab.automaton import HybridAutomaton, Mode
from frictionlab.hybrid.compilation import needs_compilation
from frictionlab.hybrid.methods.base import Method
from frictionlab.hybrid.methods.method_registry import method_of
from frictionlab.hybrid.problem import ModeNotDerived, Problem
from frictionlab.hybrid.progress import Progress
from frictionlab.hybrid.tape.automaton_checks import check_automaton, check_section_or_quadrature
from frictionlab.hybrid.tape.packing import program_of
from frictionlab.hybrid.tape.program import Section
from frictionlab.hybrid.trajectory import Sampling, Trajectory
from frictionlab.interruption import interruption
from frictionlab.validation import abbreviate, check_choice, check_mapping, check_number, float_array


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
    x0 : array_like
        Initial values of all states.
    mode : str or None
        Mode to start in; None takes the first admissible one, by the rule that follows every event.
    method : "taylor", Taylor, RK4, Scipy, or the name of a scipy method
    t_eval : array_like or None
        Ascending times of the samples, one at least; None samples every step.
    sections : mapping of name to expression or (expression, direction)
        Zero crossings to record; they change no mode.  An expression of the states, or an output's name;
        direction +1 rising, -1 falling, 0 both.  Method "taylor" only, like `quadratures`.
    quadratures : mapping of name to expression
        Functions to be integrated over the run.  Step lengths take their accuracy into account too.
    progress : bool
        Show a progress bar on runs of more than a second.
    source : object
        The model that the automaton is of, kept as ``run.source``; saved runs hold it by its ``to_dict()``.

    Returns
    -------
    Trajectory
        Also where the run ended early: see ``run.status``.

    Raises
    ------
    TypeError
        For what is no automaton.
    ValueError
        For other bad arguments; like the former before any work is done.
    KeyboardInterrupt
        After ctrl-C; :func:`partial_result` is then the run up to there.
    """
    check_automaton(automaton)
    chosen = method_of(method)
    check_number("t_end", t_end, above=0.0, cure="give the length of the run in seconds")
    state, times = _states(automaton, x0), _times(t_eval, t_end)
    asked = _sections(sections), _quadratures(quadratures)
    for name, function in [
        *((name, section.function) for name, section in asked[0].items()),
        *asked[1].items(),
    ]:
        check_section_or_quadrature(name, function, automaton)
    if any(asked) and not chosen.riders:
        raise ValueError(f"sections and quadratures need method='taylor', got {method!r}: change the method")
    automaton = with_chatter_limit(automaton, chosen.limits[1])
    modes, number = automaton.known_modes, _mode(automaton, mode)
    with_integrals = np.concatenate([state, np.zeros(len(asked[1]))])
    program, numbers = program_of(automaton, *asked, modes=modes)
    raw, begin = None, time.perf_counter()
    with Progress(t_end, progress, needs_compilation(chosen.entry)) as bar:
        while raw is None:
            try:
                raw = bar.call(
                    chosen.integrate, Problem(program, numbers, with_integrals, float(t_end), number)
                )
            except ModeNotDerived as missing:
                # Run again from the start: each mode is missing only once in a process, mostly early in a
                # run.
                modes = _with_mode(automaton, missing.mode)
                program, numbers = program_of(automaton, *asked, modes=modes)
    wall_time = time.perf_counter() - begin
    integrals = dict(zip(asked[1], raw.state[len(state) :].tolist(), strict=True))
    problem = Problem(*program_of(automaton, modes=modes), state, float(t_end), number)
    run = Trajectory(
        automaton,
        problem,
        raw.cut(len(state)),
        Sampling(chosen.degree, chosen.parts, times, tuple(asked[0])),
        quadratures=integrals,
        description=_description(chosen, t_end, source),
        source=source,
        wall_time=wall_time,
    )
    if bar.stopped:
        raise interruption(f"the run was stopped at {run.raw.t:g} of {t_end:g} s", run)
    return run


def _description(method: Method, t_end: float, source: Any) -> dict[str, Any]:
    """What is said of a run beside its arrays, as data that JSON can hold."""
    about = {"method": method.describe(), "t_end": float(t_end)}
    with suppress(TypeError):  # a model with a field that JSON cannot hold; a saved run holds its automaton
        return about | ({"model": source.to_dict()} if hasattr(source, "to_dict") else {})
    return about


def with_chatter_limit(automaton: HybridAutomaton, limit: float) -> HybridAutomaton:
    """The automaton with a method's dwell time of chatter (s), if it has that parameter."""
    names = [symbol.name for symbol in automaton.parameters]
    return automaton.replace(chatter=limit) if "chatter" in names else automaton


def _states(automaton: HybridAutomaton, x0: Any) -> np.ndarray:
    try:
        state = np.array(x0, dtype=float)
    except (TypeError, ValueError) as error:
        raise _bad_state(automaton, "must hold numbers for the states {}", abbreviate(x0)) from error
    if state.shape != (len(automaton.states),):
        got = f"{abbreviate(x0)} of shape {state.shape}"
        raise _bad_state(automaton, "must hold one number per state {}", got)
    if not np.isfinite(state).all():
        raise _bad_state(automaton, "must be finite in all states {}", str(state.tolist()))
    return state


def _bad_state(automaton: HybridAutomaton, rule: str, got: str) -> ValueError:
    names = ", ".join(map(str, automaton.states))
    cure = f"give {len(automaton.states)} numbers, in this order"
    return ValueError(f"x0 {rule.format(f'({names})')}, got {got}: {cure}")


def _times(t_eval: Any, t_end: float) -> np.ndarray | None:
    if t_eval is None:
        return None
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


def _sections(sections: Any) -> dict[str, Section]:
    check_mapping("sections", sections or {}, 'give each a name, such as {"top": (expression, -1)}')
    return {name: _section(name, asked) for name, asked in (sections or {}).items()}


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


def _quadratures(quadratures: Any) -> dict[str, Any]:
    check_mapping("quadratures", quadratures or {}, 'give each a name, such as {"work": expression}')
    return dict(quadratures or {})


def _mode(automaton: HybridAutomaton, mode: str | None) -> int | None:
    if mode is None:
        return None
    check_choice("mode", mode, automaton.names)
    return automaton.names.index(mode)


def _with_mode(automaton: HybridAutomaton, number: int) -> tuple[Mode, ...]:
    """The modes known after one more is derived."""
    _ = automaton.modes[number]
    return automaton.known_modes
