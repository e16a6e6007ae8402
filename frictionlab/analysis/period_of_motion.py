"""The approximate period of a model or an automaton, as explorers and pages need one before any run."""

from __future__ import annotations

from dataclasses import replace
from math import pi
from typing import Any

import numpy as np

from frictionlab.automaton import HybridAutomaton
from frictionlab.hybrid.methods.taylor import Taylor
from frictionlab.hybrid.problem import Status
from frictionlab.hybrid.solve import RunOptions, run_automaton
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.models.model import ModelOrAutomaton, automaton_of
from frictionlab.stability import eigenvalues

from .initial_states import initial_state_of
from .motion_scales import SEEN, Array, mean_period, time_of_rest

STEPS = 400  # of the motion that is looked at: some fifty periods where nothing happens
FOREVER = 1e30  # s: the steps end it
PERIODS_UNTIL_REST = 10.0  # of a motion that comes to rest without turning: all of it is then shown
RESTED = 0.9  # share of the run by which a motion that comes to rest has done so
NO_PERIOD = 1.0  # in the automaton's unit of time, where nothing tells one, as in a steady drift


def with_period(automaton: HybridAutomaton, state: Array) -> HybridAutomaton:
    """The automaton with the period that it states, or with one found in its motion from a state (n,)."""
    if automaton.period is not None:
        return automaton
    return replace(automaton.derived(), period=_period_from(automaton, state))


def oscillation_period(source: ModelOrAutomaton, x0: Any = "rest") -> float:
    """Approximate period of oscillation (s) that is stated, or else found in the motion from `x0`."""
    if stated := getattr(source, "period", None):
        return float(stated)
    try:
        return _period_from(automaton_of(source), initial_state_of(source, x0))
    except (ValueError, ArithmeticError):  # no run from there, as where a law's rule does not hold
        return NO_PERIOD


def _period_from(automaton: HybridAutomaton, state: Array) -> float:
    options = RunOptions(progress=False)
    return _period_of_motion(run_automaton(automaton, FOREVER, state, Taylor(max_steps=STEPS), options))


def _period_of_motion(run: Trajectory) -> float:
    """The mean time (s) in which the fastest state goes up and down, at the end or in all; else a share of
    the time until rest, the period of the fastest eigenvalue, or the length of a run that ends by itself."""
    least = SEEN * np.ptp(run.states, axis=0)
    for begin in (len(run.t) // 2, 0):
        times, states = run.t[begin:], run.states[begin:]
        moving = states[:, np.ptp(states, axis=0) > least]
        shortest = min((mean_period(times, column) for column in moving.T), default=np.inf)
        if shortest < np.inf:
            return shortest
    rest = time_of_rest(run)
    if 0.0 < rest < RESTED * run.raw.t:
        return rest / PERIODS_UNTIL_REST
    try:
        fastest = float(np.abs(eigenvalues(run.automaton).values).max(initial=0.0))
    except (ValueError, ArithmeticError):  # no equilibrium, or no finite slopes there
        fastest = 0.0
    if fastest:
        return 2 * pi / fastest
    # A run of all steps has their length, which grows without bounds.
    length = 0.0 if run.raw.status is Status.STEP_CAP else float(run.raw.t)
    return length or NO_PERIOD
