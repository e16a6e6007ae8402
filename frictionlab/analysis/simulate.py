"""`fl.simulate`: run a model from an initial state."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from frictionlab.analysis.initial_states import initial_state_of
from frictionlab.automaton import HybridAutomaton
from frictionlab.hybrid.methods.base import Method
from frictionlab.hybrid.solve import RunOptions, method_of, run_automaton, with_warning
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.models.model import ModelOrAutomaton, require_model_or_automaton
from frictionlab.validation import explains_keywords


@explains_keywords
def simulate(
    model: ModelOrAutomaton,
    t_end: float,
    *,
    x0: Any = "rest",
    mode: str | None = None,
    method: str | Method = "taylor",
    t_eval: Any = None,
    sections: Mapping[str, Any] | None = None,
    quadratures: Mapping[str, Any] | None = None,
    progress: bool = True,
) -> Trajectory:
    """Run a model or an automaton from 0 to `t_end`.

    Parameters
    ----------
    model : Model, Structure or HybridAutomaton
        SliderOnBelt, another of :func:`frictionlab.list_models`, or your own; a structure given by its
        matrices; or an automaton, as :func:`frictionlab.solve` runs it.
    t_end : float
        End time in seconds, positive.
    x0 : "rest", "near", mapping or array_like (2n,)
        "rest": all states zero, but for those that `Model.release` gives.  "near": the sliding
        equilibrium with its coordinates displaced by one percent, velocities zero, further states as at the
        equilibrium.  Where that leaves a growing mode at rest, or all coordinates are zero, the state is
        displaced along the least stable mode: by one percent of the size at which this mode's motion meets
        an event or is no longer linear; by 0.01 in its largest state if it always is.  A mapping such as
        ``{"x1": 0.1, "x1'": -0.2}`` gives some states; the others are as at rest.  An array holds
        coordinates, then velocities; further states of a model, such as the phase of a force, are zero where
        they are left out.  ``run.final_state`` goes on from another run's end.
    mode : str or None
        See :func:`frictionlab.solve`; with hysteresis a run goes on in ``run.mode[-1]``.
    method : "taylor", "rk4", the name of a scipy method such as "dop853", Taylor(...), RK4(...), Scipy(...)
        "taylor" is exact to rounding; RK4 is the paper's algorithm.
    t_eval : array_like or None
        Ascending times of the samples, one at least; None samples every step.
    sections, quadratures : mapping or None
        See :func:`frictionlab.solve`.
    progress : bool
        Show a progress bar on runs of more than a second.

    Returns
    -------
    Trajectory
        Also if the run ended early: see ``run.status``.

    Warns
    -----
    RuntimeWarning
        Where some steps are far less exact than the tolerance: see ``run.warning``.

    Raises
    ------
    TypeError
        Where `model` is no model.
    ValueError
        For bad arguments, or ``x0="near"`` where there is no equilibrium; before any work is done.
    KeyboardInterrupt
        After ctrl-C; :func:`partial_result` then returns the run as far as it went.

    Examples
    --------
    >>> import frictionlab as fl
    >>> run = fl.simulate(fl.SliderOnBelt(mu_k=1.4), 0.05)
    >>> run.events.target.tolist()
    ['stick']
    """
    known = require_model_or_automaton(model, "write simulate(model, t_end)")
    automaton, source = (known, None) if isinstance(known, HybridAutomaton) else (known.automaton(), known)
    solver, options = method_of(method), RunOptions(mode, t_eval, sections, quadratures, progress, source)
    start = initial_state_of(known, x0, automaton)
    return with_warning(run_automaton(automaton, t_end, start, solver, options))
