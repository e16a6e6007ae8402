"""The intensity of a steady motion, L_s of Eq. (20)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.stability import equilibrium

from .simulate import simulate

Array = NDArray[np.float64]
SAMPLES = 100_001


def resting_point(model: Any) -> Array | None:
    """Coordinates (n,) of the sliding equilibrium; None where there is none."""
    try:
        return equilibrium(model).q
    except ValueError:
        return None


def intensity(run: Trajectory, start: Array | None, period: float) -> float:
    """L_s, Eq. (20): the mean over a period from the state `start`, or over the whole run where that is None.

    Runs of the Taylor method integrate along their polynomials.
    """
    model, point = run.source, resting_point(run.source)
    if point is None:
        return float("nan")
    method = run.description["method"]["name"]
    if method != "taylor":
        span = run.raw.t // period * period if start is not None else run.raw.t
        states = run(np.linspace(run.raw.t - span, run.raw.t, SAMPLES))[:, : len(point)]
        return float(((states - point) ** 2).mean(axis=0).sum())
    states = run.automaton.states[: len(point)]
    square = sum((x - float(e)) ** 2 for x, e in zip(states, point, strict=True))
    begin = run(0.0) if start is None else start
    length = run.raw.t if start is None else period
    again = simulate(model, length, x0=begin, quadratures={"square": square}, progress=False)
    return again.quadratures["square"] / length
