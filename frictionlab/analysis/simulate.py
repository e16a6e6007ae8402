"""`fl.simulate`: run a model from an initial state ("rest", "near", an array); `fl.load`: read a file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from frictionlab.automaton import HybridAutomaton
from frictionlab.hybrid.methods.base import Method
from frictionlab.hybrid.run_file import automaton_in_file, trajectory_from_file
from frictionlab.hybrid.solve import RunOptions, method_of, run_automaton, state_from_mapping
from frictionlab.hybrid.storage import StoredRun, read_run_file
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.models import Model
from frictionlab.models.model import automaton_of, require_model
from frictionlab.models.symbols import automaton_from_structure_data
from frictionlab.stability import equilibrium
from frictionlab.validation import abbreviate, check_choice, float_array, plain_number

NEAR_EQUILIBRIUM_FACTOR = 1.01  # "near": the equilibrium displaced by one percent


def model_initial_state(model: Any, x0: Any, automaton: Any = None) -> Any:
    """The state that a name stands for; of a mapping the states it leaves out are as at rest, of an array
    zero.

    Give the model's automaton where it is at hand, to save its assembly.
    """
    if not isinstance(model, Model):  # an automaton, whose start is an array or by name
        return x0
    automaton = model.automaton() if automaton is None else automaton
    if isinstance(x0, Mapping):
        return state_from_mapping(automaton, x0, model_initial_state(model, "rest", automaton))
    n, names = len(model.coordinates), list(automaton.state_names)
    if not isinstance(x0, str):
        return np.append(x0, np.zeros(len(names) - 2 * n)) if np.shape(x0) == (2 * n,) else x0
    check_choice("x0", x0, ("rest", "near"), "or give numbers, one for each state")
    start = np.zeros(len(names))
    if x0 == "near":
        start[:n] = NEAR_EQUILIBRIUM_FACTOR * equilibrium(model).q
        return start
    for name, value in model.release().items():
        start[names.index(name)] = value
    return start


def named_state(x0: Any) -> Any:
    """An initial state as data that JSON can hold; names stay names."""
    if isinstance(x0, Mapping):
        return {name: plain_number(value) for name, value in x0.items()}
    return x0 if isinstance(x0, str) else np.asarray(x0, dtype=float).tolist()


def initial_state_of(model: Any, x0: Any) -> np.ndarray:
    """The initial state (n,) that :func:`simulate` would begin with; raises for one that it refuses."""
    return validate_initial_state(model, x0, automaton_of(model))


def validate_initial_state(model: Any, x0: Any, automaton: HybridAutomaton) -> np.ndarray:
    """The initial state of a model, or of an automaton, that :func:`simulate` would take; else ValueError."""
    names, size = ", ".join(automaton.state_names), len(automaton.state_names)
    rule = f"a finite number for each of the states {names}"
    start = float_array("x0", resolve_initial_state(model, x0, automaton), f"give {rule}")
    if start.shape != (size,) or not np.isfinite(start).all():
        raise ValueError(f"x0 must hold {rule}, got {abbreviate(x0)}: give {size} numbers, in this order")
    return start


def resolve_initial_state(model: Any, x0: Any, automaton: HybridAutomaton | None = None) -> Any:
    """The state (2n,) that a name stands for, of a model or an automaton."""
    if isinstance(model, HybridAutomaton) and isinstance(x0, Mapping):
        return state_from_mapping(model, x0, np.zeros(len(model.state_names)))
    if isinstance(model, HybridAutomaton) and isinstance(x0, str):
        check_choice("x0", x0, ("rest",), "or give numbers, one for each state")
        return np.zeros(len(model.states))
    return model_initial_state(model, x0, automaton)


def simulate(
    model: Any,
    t_end: float,
    *,
    x0: Any = "rest",
    method: str | Method = "taylor",
    t_eval: Any = None,
    sections: Mapping[str, Any] | None = None,
    quadratures: Mapping[str, Any] | None = None,
    progress: bool = True,
) -> Trajectory:
    """Run a model from 0 to `t_end`.

    Parameters
    ----------
    model : Model
        SliderOnBelt, another of :func:`frictionlab.list_models`, or your own.
    t_end : float
        End time in seconds, positive.
    x0 : "rest", "near", mapping or array_like (2n,)
        "rest": coordinates and velocities zero, or where the model says it is released.  "near": the sliding
        equilibrium with its coordinates displaced by one percent, velocities zero.  A mapping such as
        ``{"x1": 0.1, "x1'": -0.2}`` gives some states; the others are as at rest.  An array holds
        coordinates, then velocities; further states of a model, such as the phase of a force, are zero where
        they are left out.
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
        Also where the run ended early: see ``run.status``.

    Raises
    ------
    TypeError
        Where `model` is no model.
    ValueError
        For bad arguments, or ``x0="near"`` where there is no equilibrium; before any work is done.
    KeyboardInterrupt
        After ctrl-C; :func:`partial_result` is then the run up to there.

    Examples
    --------
    >>> import frictionlab as fl
    >>> run = fl.simulate(fl.SliderOnBelt(mu_k=1.4), 0.05)
    >>> run.events.target.tolist()
    ['stick']
    """
    cure = (
        "use fl.solve for an automaton"
        if isinstance(model, HybridAutomaton)
        else "write simulate(model, t_end)"
    )
    model = require_model(model, cure=cure)
    chosen = method_of(method)
    options = RunOptions(None, t_eval, sections, quadratures, progress, model)
    automaton = model.automaton()
    start = model_initial_state(model, x0, automaton)
    return run_automaton(automaton, t_end, start, chosen, options)


def load(path: str | Path, model: Any = None) -> Trajectory:
    """A run that :meth:`Trajectory.save` wrote.

    Parameters
    ----------
    path : path
    model : model or automaton, optional
        The model or automaton of the run; by default that in the file.  Needed for laws and models of your
        own that are not defined in this session.  It must be the same as that of the run.

    Raises
    ------
    OSError
        Where there is no such file, or it cannot be read.
    ValueError
        Where the file is no saved run, is damaged, or its model cannot be made or is another than that given.
    """
    stored = read_run_file(path)
    if model is None and "model" in stored.description:
        model = _model_in_file(stored)
    if model is None:
        automaton = automaton_in_file(stored, automaton_from_structure_data)
    else:
        automaton = automaton_of(model)
    return trajectory_from_file(stored, automaton, model if isinstance(model, Model) else None)


def _model_in_file(stored: StoredRun) -> Model:
    try:
        return Model.from_dict(stored.description["model"])
    except (ValueError, TypeError, RecursionError) as error:
        raise ValueError(f"{stored.path} holds a run of a model that cannot be made: {error}") from error
