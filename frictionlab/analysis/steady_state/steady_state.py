"""`fl.steady_state`: run a model until transients have died away, and classify the motion that is left."""

from __future__ import annotations

from typing import Any

from frictionlab.analysis.initial_states import check_initial_state, resolve_initial_state
from frictionlab.hybrid.methods.base import Method
from frictionlab.hybrid.methods.method_registry import method_of
from frictionlab.hybrid.solve import solve
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.models.coercion import automaton_of
from frictionlab.validation import check_number

from .intensity import equilibrium_coordinates, squared_distance, with_equilibrium_parameters
from .poincare_sections import Section, section_function, sections_to_record
from .result import SteadyState, steady_state_of_window


def steady_state(
    model: Any,
    x0: Any = "rest",
    *,
    transient: float = 200.0,
    window: float = 100.0,
    t_max: float | None = None,
    method: str | Method = "taylor",
    section: Section | None = None,
    tolerance: float = 1e-6,
    progress: bool = True,
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
    transient, window : float
        Seconds that are discarded, and that are classified.
    t_max : float or None
        Go on, window by window, until the motion has settled or so many seconds have passed; None classifies
        one window only.
    method : "taylor", Taylor, RK4, ...
    section : None, "stick", str or (str, int)
        The Poincare section of recurrence: transitions from slip to stick, or where an expression of the
        states (or an output, "penetration") passes zero.  None takes the first where there are such
        transitions, else ("x1'", -1).
    tolerance : float
    progress : bool

    Returns
    -------
    SteadyState

    Raises
    ------
    ValueError
        For bad arguments, before any work is done.

    Examples
    --------
    >>> import frictionlab as fl
    >>> fl.steady_state(fl.SliderOnBelt(mu_k=1.4).without("geometry"), transient=60, window=10)
    SteadyState(periodic, period 0.0905161 s, 1 onset of stick in it, L_s 0.0011701)
    """
    chosen = method_of(method)
    check_steady_state_arguments(model, x0, transient, window, t_max, section, tolerance)
    start, passed = resolve_initial_state(model, x0), 0.0
    if transient > 0:
        run = _run_transient(model, transient, start, chosen, progress)
        if not run.status.ok:
            return steady_state_of_window(model, run, section, tolerance, passed=0.0)
        start, passed = run.final_state, transient
    while True:
        run = _run_window(model, window, start, chosen, progress, section)
        found = steady_state_of_window(model, run, section, tolerance, passed=passed)
        passed += window
        if found.settled or t_max is None or passed + window > t_max or not run.status.ok:
            return found
        start = run.final_state


def check_steady_state_arguments(
    model: Any,
    x0: Any,
    transient: float,
    window: float,
    t_max: float | None,
    section: Section | None,
    tolerance: float,
) -> None:
    """Raise for bad arguments of :func:`steady_state`."""
    check_number("window", window, above=0.0, cure="give the seconds to look at")
    check_number("transient", transient, least=0.0, cure="give the seconds to throw away")
    check_number("tolerance", tolerance, above=0.0, cure="1e-6 suits the exact solver")
    if t_max is not None:
        check_number("t_max", t_max, above=0.0, cure="give the most seconds to go on for")
    automaton = automaton_of(model)
    if section is not None:
        section_function(automaton, section)
    check_initial_state(model, x0)


def _run_transient(model: Any, t_end: float, x0: Any, method: Method, progress: bool) -> Trajectory:
    return solve(automaton_of(model), t_end, x0=x0, method=method, progress=progress, source=model)


def _run_window(
    model: Any, t_end: float, x0: Any, method: Method, progress: bool, section: Section | None
) -> Trajectory:
    """A run with the section and the integrand of L_s along it, where the method can record them."""
    options: dict[str, Any] = {"method": method, "progress": progress, "source": model}
    automaton, point = automaton_of(model), equilibrium_coordinates(model)
    if method.riders:
        options["sections"] = sections_to_record(automaton, section)
    if method.riders and point is not None:
        automaton = with_equilibrium_parameters(automaton, point)
        options["quadratures"] = squared_distance(automaton)
    return solve(automaton, t_end, x0=x0, **options)
