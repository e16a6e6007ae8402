"""Checks of a model: what it says about itself, its equations, and a motion."""

from __future__ import annotations

from typing import Any

import numpy as np

from frictionlab.analysis.simulate import simulate
from frictionlab.components.parameter import parameters_of
from frictionlab.hybrid.program import program_of
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.models.model import Model
from frictionlab.models.namespace import about_all

from .text import check_parameters, check_text, refuse

SHORT = 0.02  # s, of the comparison with another integrator
METHOD, AGREES = "DOP853", 1e-7
CHANGE = 1.0 + 2.0**-20  # of a parameter's value


def check_model(model: Model, t_end: float = 1.0) -> Trajectory:
    """Check a model, with the laws that it is made of.

    Its parameters are described; its repr makes it again; every mode's equations print; a parameter's value
    changes no structure, so that a slider compiles nothing; a motion from rest keeps the rules of contact and
    friction, and agrees with that of another integrator.

    Parameters
    ----------
    model : Model
    t_end : float
        Length of the motion, s.

    Returns
    -------
    Trajectory
        The motion.

    Raises
    ------
    AssertionError
        With the rule that the model breaks, and what there is instead.
    """
    check_parameters(model, about_all(type(model), model.components))
    check_text(model)
    _check_equations(model)
    _check_structure(model)
    run = simulate(model, t_end, progress=False)
    check_run(model, run)
    _check_agreement(model, min(t_end, SHORT))
    return run


def check_run(model: Any, run: Trajectory) -> None:
    """Raise AssertionError unless a run came to its end and kept the rules of contact and friction."""
    from .motion import violations

    if not run.status.ok:
        refuse(model, f"a motion of {run.t[-1]:g} s must come to its end", run.status)
    if broken := violations(run):
        refuse(model, "a motion must keep the rules of contact and friction", broken)


def _check_equations(model: Any) -> None:
    for mode in model.automaton().names:
        try:
            found = model.equations(mode)
        except ValueError:  # the limit of many impacts is no mode of the model
            continue
        if not len(found) or "\\" not in found.latex() or not repr(found):
            refuse(model, f"equations({mode!r}) must print, also in LaTeX", found)


def _check_structure(model: Any) -> None:
    program = program_of(model.automaton())[0]
    for name, value in model.parameters.items():
        if not value or name not in {*parameters_of(type(model)), *_of_components(model)}:
            continue
        try:
            other = model.replace(**{name: value * CHANGE})
        except ValueError:  # a rule forbids it, mu_k above mu_s
            other = model.replace(**{name: value / CHANGE})
        if program_of(other.automaton())[0] is not program:
            refuse(model, f"the value of {name} must change numbers only", "another structure")


def _of_components(model: Any) -> set[str]:
    return {name for part in model.components.values() for name in parameters_of(type(part))}


def _check_agreement(model: Any, t_end: float) -> None:
    own = simulate(model, t_end, progress=False).final_state
    other = simulate(model, t_end, method=METHOD, progress=False).final_state
    error = np.abs(own - other).max() / (np.abs(own).max() or 1.0)
    if not error <= AGREES:
        refuse(model, f"its motion must be that of {METHOD} but for a share of {AGREES:g}", error)
