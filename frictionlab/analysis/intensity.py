"""The intensity of a steady motion, L_s of Eq. (20)."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import sympy
from numpy.typing import NDArray

from frictionlab.automaton import HybridAutomaton
from frictionlab.hybrid.solve import solve
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.stability import equilibrium

Array = NDArray[np.float64]
SQUARE = "square"
SAMPLES = 100_001  # of runs of methods that integrate nothing beside the states


def resting_point(model: Any) -> Array | None:
    """Coordinates (n,) of the sliding equilibrium; None where there is none."""
    try:
        return equilibrium(model).q
    except ValueError:
        return None


def with_resting_point(automaton: HybridAutomaton, point: Array) -> HybridAutomaton:
    """The automaton with the equilibrium (n,) as parameters beside its own.

    As numbers in the integrand they would make a new program for every value of a parameter.
    """
    resting = {_resting(x): float(e) for x, e in zip(automaton.states, point)}
    return replace(automaton, parameters={**automaton.parameters, **resting})


def squared_distance(automaton: HybridAutomaton) -> dict[str, Any]:
    """The integrand of Eq. (20), sum of (x_i - x_e,i)^2 over the coordinates, as a quadrature."""
    pairs = [(x, _resting(x)) for x in automaton.states if _resting(x) in automaton.parameters]
    return {SQUARE: sum(((x - e) ** 2 for x, e in pairs), sympy.S.Zero)}


def _resting(state: sympy.Symbol) -> sympy.Symbol:
    return sympy.Symbol(f"{state.name} at rest")


def intensity(run: Trajectory, period: float) -> float:
    """L_s, Eq. (20): the mean over the last period of a run, or over all of it where `period` is NaN.

    Runs of the Taylor method integrate along their polynomials, given the integral over all of the run as
    the quadrature `SQUARE`.  NaN where there is no equilibrium.
    """
    point = resting_point(run.source)
    if point is None:
        return float("nan")
    if SQUARE not in run.quadratures:
        return _sampled(run, point, period)
    if np.isnan(period):
        return run.quadratures[SQUARE] / run.raw.t
    start, square = run(run.raw.t - period), squared_distance(run.automaton)
    again = solve(run.automaton, period, x0=start, quadratures=square, progress=False)
    return again.quadratures[SQUARE] / period


def _sampled(run: Trajectory, point: Array, period: float) -> float:
    span = run.raw.t if np.isnan(period) else run.raw.t // period * period
    states = run(np.linspace(run.raw.t - span, run.raw.t, SAMPLES))[:, : len(point)]
    return float(((states - point) ** 2).mean(axis=0).sum())
