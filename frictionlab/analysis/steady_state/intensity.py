"""The intensity L_s of a steady motion, Eq. (20): mean squared distance from the sliding equilibrium."""

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
SQUARED_DISTANCE = "square"
INTENSITY_SAMPLES = 100_001  # samples of a run whose method integrates no quadratures


def equilibrium_coordinates(model: Any) -> Array | None:
    """Coordinates (n,) of the sliding equilibrium; None where there is none."""
    try:
        return equilibrium(model).q
    except ValueError:
        return None


def with_equilibrium_parameters(automaton: HybridAutomaton, point: Array) -> HybridAutomaton:
    """The automaton with the equilibrium (n,) as additional parameters.

    As numbers in the integrand they would need a new program for every value of a parameter.
    """
    resting = {_equilibrium_symbol(x): float(e) for x, e in zip(automaton.states, point)}
    return replace(automaton, parameters={**automaton.parameters, **resting})


def squared_distance(automaton: HybridAutomaton) -> dict[str, Any]:
    """The integrand of Eq. (20), sum of (x_i - x_e,i)^2 over the coordinates, as a quadrature."""
    pairs = [
        (x, _equilibrium_symbol(x))
        for x in automaton.states
        if _equilibrium_symbol(x) in automaton.parameters
    ]
    return {SQUARED_DISTANCE: sum(((x - e) ** 2 for x, e in pairs), sympy.S.Zero)}


def _equilibrium_symbol(state: sympy.Symbol) -> sympy.Symbol:
    return sympy.Symbol(f"{state.name} at rest")


def intensity(run: Trajectory, period: float) -> float:
    """L_s, Eq. (20): the mean over the last period of a run, or over all of it where `period` is NaN.

    Runs of the Taylor method carry the integral as the quadrature `SQUARED_DISTANCE`.  NaN where there is no
    equilibrium.
    """
    point = equilibrium_coordinates(run.source)
    if point is None:
        return float("nan")
    if SQUARED_DISTANCE not in run.quadratures:
        return _intensity_of_samples(run, point, period)
    if np.isnan(period):
        return run.quadratures[SQUARED_DISTANCE] / run.raw.t
    start, square = run(run.raw.t - period), squared_distance(run.automaton)
    again = solve(run.automaton, period, x0=start, quadratures=square, progress=False)
    return again.quadratures[SQUARED_DISTANCE] / period


def _intensity_of_samples(run: Trajectory, point: Array, period: float) -> float:
    span = run.raw.t if np.isnan(period) else run.raw.t // period * period
    states = run(np.linspace(run.raw.t - span, run.raw.t, INTENSITY_SAMPLES))[:, : len(point)]
    return float(((states - point) ** 2).mean(axis=0).sum())
