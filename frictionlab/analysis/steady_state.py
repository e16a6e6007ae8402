"""`fl.steady_state`: what a motion settles to."""

from __future__ import annotations

from typing import Any

import numpy as np

from frictionlab.automaton import HybridAutomaton
from frictionlab.hybrid.choice import method_of
from frictionlab.hybrid.methods import Method
from frictionlab.hybrid.solve import solve
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.hybrid.validation import check_choice, check_number, float_array, shown
from frictionlab.models import Model
from frictionlab.stability.automata import automaton_of

from .intensity import resting_point, squared_distance, with_resting_point
from .kinds import ENDED, EQUILIBRIUM, NON_PERIODIC, PERIODIC, UNSETTLED
from .sections import Section, asked, recorded
from .simulate import initial_state
from .window import SteadyState, look

__all__ = [
    "ENDED",
    "EQUILIBRIUM",
    "NON_PERIODIC",
    "PERIODIC",
    "UNSETTLED",
    "SteadyState",
    "automaton_of",
    "check_steady",
    "steady_state",
]


def steady_state(
    model: Any,
    x0: Any = "rest",
    *,
    transient: float = 200.0,
    window: float = 100.0,
    longest: float | None = None,
    method: str | Method = "taylor",
    section: Section | None = None,
    tolerance: float = 1e-6,
    progress: bool = True,
) -> SteadyState:
    """Run a model until transients have died away, and tell what is left.

    A motion is periodic where the whole state at a section returns within `tolerance` of the motion's size
    for the second half of the window, or within a thousandth and ever more nearly.  It is at rest where
    nothing happens any more and what still moves dies away and is less than a thousandth of the
    coordinates, or where friction holds it while a force goes through its period.  It is not settled yet
    where it does neither, but nears one of them, or repeats within a thousandth and no better, or goes one
    way all along, or doubles or halves its size, or one of its modes fades or grows, however slowly; or
    where the window has less than 24 crossings of the section.

    Parameters
    ----------
    model : Model or HybridAutomaton
    x0 : "rest", "near" or array_like (2n,)
        Of an automaton "rest" (all states zero) or an array.
    transient, window : float
        Seconds that are thrown away, and that are looked at.
    longest : float or None
        Go on, window by window, until the motion has settled or so many seconds have passed; None looks at
        one window only.
    method : "taylor", Taylor, RK4, ...
    section : None, "stick", str or (str, int)
        Where recurrence is looked at: transitions from slip to stick, or where an expression of the states
        (or an output, "gap") passes zero.  None takes the first where there are such transitions, else
        ("x1'", -1).
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
    check_steady(model, x0, transient, window, longest, section, tolerance)
    start, passed = start_of(model, x0), 0.0
    if transient > 0:
        run = _transient(model, transient, start, chosen, progress)
        if not run.status.ok:
            return look(model, run, section, tolerance, passed=0.0)
        start, passed = run.final_state, transient
    while True:
        run = _window(model, window, start, chosen, progress, section)
        found = look(model, run, section, tolerance, passed=passed)
        passed += window
        if found.settled or longest is None or passed + window > longest or not run.status.ok:
            return found
        start = run.final_state


def check_steady(
    model: Any,
    x0: Any,
    transient: float,
    window: float,
    longest: float | None,
    section: Section | None,
    tolerance: float,
) -> None:
    """Raise for bad arguments of :func:`steady_state`."""
    check_number("window", window, above=0.0, cure="give the seconds to look at")
    check_number("transient", transient, least=0.0, cure="give the seconds to throw away")
    check_number("tolerance", tolerance, above=0.0, cure="1e-6 suits the exact solver")
    if longest is not None:
        check_number("longest", longest, above=0.0, cure="give the most seconds to go on for")
    automaton = automaton_of(model)
    if section is not None:
        asked(automaton, section)
    check_start(model, x0)


def check_start(model: Any, x0: Any) -> None:
    """Raise for an initial state that :func:`simulate` would not take."""
    checked_start(model, x0, automaton_of(model))


def checked_start(model: Any, x0: Any, automaton: HybridAutomaton) -> np.ndarray:
    """The initial state of a model, or of an automaton, that :func:`simulate` would take; else ValueError."""
    names, size = ", ".join(map(str, automaton.states)), len(automaton.states)
    rule = f"a finite number for each of the states {names}"
    start = float_array("x0", start_of(model, x0, automaton), f"give {rule}")
    if start.shape != (size,) or not np.isfinite(start).all():
        raise ValueError(f"x0 must hold {rule}, got {shown(x0)}: give {size} numbers, in this order")
    return start


def start_of(model: Any, x0: Any, automaton: HybridAutomaton | None = None) -> Any:
    """The state (2n,) that a name stands for, of a model or an automaton."""
    if isinstance(model, HybridAutomaton) and isinstance(x0, str):
        check_choice("x0", x0, ("rest",), "or give numbers, one for each state")
        return np.zeros(len(model.states))
    return initial_state(model, x0, automaton)


def _transient(model: Any, t_end: float, x0: Any, method: Method, progress: bool) -> Trajectory:
    return solve(automaton_of(model), t_end, x0=x0, method=method, progress=progress, source=model)


def _window(
    model: Any, t_end: float, x0: Any, method: Method, progress: bool, section: Section | None
) -> Trajectory:
    """A run with the section and the integrand of L_s along it, where the method can record them."""
    options: dict[str, Any] = {"method": method, "progress": progress, "source": model}
    automaton, point = automaton_of(model), resting_point(model)
    if method.riders:
        options["sections"] = recorded(automaton, section)
    if method.riders and point is not None:
        automaton = with_resting_point(automaton, point)
        options["quadratures"] = squared_distance(automaton)
    run = solve(automaton, t_end, x0=x0, **options)
    if isinstance(model, Model):
        run.description["model"] = model.to_dict()
    return run
