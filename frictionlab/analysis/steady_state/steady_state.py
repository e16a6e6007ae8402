"""`fl.steady_state`: run a model until transients have died away, and classify the motion that is left."""

from __future__ import annotations

from typing import Any, Unpack

from frictionlab.analysis.options import SteadyStateKeywords, SteadyStateOptions, merge_keywords
from frictionlab.analysis.simulate import initial_state_of
from frictionlab.analysis.steady_state.result import (
    equilibrium_coordinates,
    squared_distance,
    with_equilibrium_parameters,
)
from frictionlab.hybrid.solve import solve
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.models.coercion import automaton_of

from .poincare_sections import Section, section_function, sections_to_record
from .result import SteadyState, steady_state_of_window


def steady_state(
    model: Any,
    x0: Any = "rest",
    *,
    options: SteadyStateOptions | None = None,
    progress: bool = True,
    **keywords: Unpack[SteadyStateKeywords],
) -> SteadyState:
    """Run a model until transients have died away, and classify the motion that is left.

    A motion is periodic where the whole state at a section returns within `tolerance` of the motion's size
    for the second half of the window, or within a thousandth and ever more closely. It is at an equilibrium
    where there are no more events and the remaining motion decays and is less than a thousandth of the
    coordinates, or where friction holds it through a whole period of a force. It is not settled yet where it
    is neither, but approaches one of them, repeats within a thousandth and no better, drifts in one
    direction, doubles or halves its size, or has a part that decays or grows, however slowly; or where the
    window has less than 24 crossings of the section.

    Parameters
    ----------
    model : Model or HybridAutomaton
    x0 : "rest", "near" or array_like (2n,)
        Of an automaton "rest" (all states zero) or an array.
    options : SteadyStateOptions or None
        The transient, the window, the section and so on; None takes the usual ones.
    progress : bool
    **keywords
        Fields of :class:`SteadyStateOptions`, in the place of those of `options`: ``transient=60.0``.

    Returns
    -------
    SteadyState

    Raises
    ------
    TypeError
        For what is no model, or an unknown keyword.
    ValueError
        For other bad arguments; like the former before any work is done.
    KeyboardInterrupt
        After ctrl-C; :func:`partial_result` is then the run that was stopped, in the transient or the window.

    Examples
    --------
    >>> import frictionlab as fl
    >>> fl.steady_state(fl.SliderOnBelt(mu_k=1.4).without("geometry"), transient=60, window=10)
    SteadyState(periodic, period 0.0905161 s, 1 onset of stick in it, L_s 0.0011701)
    """
    (chosen,) = merge_keywords("steady_state", keywords, unused="rtol", options=(SteadyStateOptions, options))
    check_section(model, chosen.section)
    return find_steady_state(model, initial_state_of(model, x0), chosen, progress)


def check_section(model: Any, section: Section | None) -> None:
    """Raise unless a motion of the model can have the section."""
    automaton = automaton_of(model)
    if section is not None:
        section_function(automaton, section)


def find_steady_state(model: Any, x0: Any, options: SteadyStateOptions, progress: bool) -> SteadyState:
    """The steady state from an initial state (n,); arguments as of :func:`steady_state`, all checked."""
    start, passed, t_max = x0, 0.0, options.t_max
    if options.transient > 0:
        run = _run_transient(model, start, options, progress)
        if not run.status.ok:
            return steady_state_of_window(model, run, options.section, options.tolerance, passed=0.0)
        start, passed = run.final_state, options.transient
    while True:
        run = _run_window(model, start, options, progress)
        found = steady_state_of_window(model, run, options.section, options.tolerance, passed=passed)
        passed += options.window
        if found.settled or t_max is None or passed + options.window > t_max or not run.status.ok:
            return found
        start = run.final_state


def _run_transient(model: Any, x0: Any, chosen: SteadyStateOptions, progress: bool) -> Trajectory:
    options: dict[str, Any] = {"method": chosen.solver, "progress": progress, "source": model}
    return solve(automaton_of(model), chosen.transient, x0=x0, **options)


def _run_window(model: Any, x0: Any, chosen: SteadyStateOptions, progress: bool) -> Trajectory:
    """A run with the section and the integrand of L_s along it, where the method can record them."""
    method = chosen.solver
    options: dict[str, Any] = {"method": method, "progress": progress, "source": model}
    automaton, point = automaton_of(model), equilibrium_coordinates(model)
    if method.riders:
        options["sections"] = sections_to_record(automaton, chosen.section)
    if method.riders and point is not None:
        automaton = with_equilibrium_parameters(automaton, point)
        options["quadratures"] = squared_distance(automaton)
    return solve(automaton, chosen.window, x0=x0, **options)
