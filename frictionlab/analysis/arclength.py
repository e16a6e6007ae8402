"""Steps along a branch of closed orbits: a tangent predictor, and Newton's method on a plane normal to it.

The parameter is a state more, of zero rate, so that the tangent flow has the derivative by it, events
included.  Unknown are the state z, the period T and the parameter; u = (z/size, T/period, parameter/span).
Source: Seydel, Practical Bifurcation and Stability Analysis, 3rd ed., Springer 2010.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import sympy as sp

from frictionlab.automaton import HybridAutomaton, Mode
from frictionlab.hybrid.saltation import SaltationError
from frictionlab.hybrid.solve import solve
from frictionlab.hybrid.status import Status
from frictionlab.hybrid.tangent_flow import end_rates, tangent_flow

from .orbit_checks import check_orbit
from .recurrence import Array, sizes
from .returns import STILL, Guess, scales
from .shooting import ROUNDING, Shot

ITERATIONS = 12
TOLERANCE = 1e-9  # largest residual of an orbit, as a share of the motion's size
FAMILY = 1e-9  # least over largest singular value below which there are closed orbits in every neighbourhood
REACH = 0.01  # how far from its prediction, beyond the length of the step, an orbit may be found
CONTRACTION = 0.5  # a residual that shrinks less has reached rounding, or will not converge


class Point(NamedTuple):
    """A closed orbit on a branch.

    `state` (n + 1,) ends with the parameter; `scale` (n + 2,) is what u is measured by, the period last but
    one; `tangent` (n + 2,) is du/ds; `modes` are those that events lead to; `cost` counts iterations.
    """

    shot: Shot
    state: Array
    period: float
    scale: Array
    tangent: Array
    modes: tuple[str, ...]
    cost: int

    @property
    def value(self) -> float:
        """The parameter."""
        return float(self.state[-1])

    @property
    def monodromy(self) -> Array:
        """Derivative (n, n) of the state after a period by the state."""
        return self.shot.matrix[:-1, :-1]


def extended(automaton: HybridAutomaton, parameter: str) -> HybridAutomaton:
    """The automaton with a parameter as its last state, of zero rate."""
    symbol = next(s for s in automaton.parameters if s.name == parameter)
    others = {s: value for s, value in automaton.parameters.items() if s is not symbol}
    return HybridAutomaton(
        (*automaton.states, symbol),
        _constant(automaton.modes),
        others,
        automaton.coordinates,
    )


@lru_cache(maxsize=64)
def _constant(modes: tuple[Mode, ...]) -> tuple[Mode, ...]:
    """The modes with a state of zero rate after the others; remembered, as tapes are by the modes."""
    return tuple(replace(mode, flow=(*mode.flow, sp.S.Zero)) for mode in modes)


def first_point(automaton: HybridAutomaton, state: Array, period: float, span: float) -> Point:
    """The point of a closed orbit whose state ends with the parameter; its parameter grows along s."""
    shot = _shot(automaton, state, period, np.ones(len(state)))
    scale = _scale(automaton, shot, period, span)
    tangent = _null(shot, state, period, scale)
    return _centred(
        automaton,
        Point(
            shot, state, period, scale, tangent * (np.sign(tangent[-1]) or 1.0), cyclic(shot.run), ITERATIONS
        ),
    )


def reversed_point(point: Point) -> Point:
    """The same, to go the other way."""
    return point._replace(tangent=-point.tangent)


def stepped(automaton: HybridAutomaton, point: Point, step: float, value: float | None = None) -> Point:
    """The closed orbit about `step` further along the branch, or near there at a value of the parameter.

    Raises
    ------
    ValueError
        Where Newton's method finds none there.
    """
    scale, size = point.scale, np.append(point.scale[:-2], point.scale[-1])
    across, missed = point.tangent, np.inf
    aim = np.append(point.state[:-1], [point.period, point.value]) + step * point.tangent * scale
    if value is not None:
        aim[-1], across = value, np.eye(len(aim))[-1]
    start = aim
    for cost in range(ITERATIONS):
        state, period = np.append(start[:-2], start[-1]), float(start[-2])
        if not 0.0 < period < 2.0 * point.period:
            raise ValueError("the period leaves its range")
        shot = _shot(automaton, state, period, size)
        if shot.residual <= ROUNDING or (
            shot.residual < TOLERANCE and shot.residual > CONTRACTION * missed and cost
        ):
            break
        if cost > 2 and shot.residual > 2.0 * missed:
            raise ValueError("Newton's method diverges")
        missed = shot.residual
        start = start + scale * _correction(shot, period, scale, across, (start - aim) / scale)
        start[-1] = start[-1] if value is None else value
    if not shot.residual < TOLERANCE:
        raise ValueError(f"no closed orbit found: the residual is {shot.residual:.2g}")
    if np.linalg.norm((start - aim) / scale) > REACH + abs(step):
        raise ValueError("the closed orbit found is of another branch")
    check_orbit(shot, Guess(state, period, size))
    return _followed(automaton, point, shot, state, period, cost)


def _followed(
    automaton: HybridAutomaton, before: Point, shot: Shot, state: Array, period: float, cost: int
) -> Point:
    """The point of an orbit found: its tangent points on, its state is far from events."""
    scale = _scale(automaton, shot, period, float(before.scale[-1]))
    tangent = _null(shot, state, period, scale)
    ahead = float(tangent @ (before.tangent * before.scale / scale)) < 0.0
    tangent = -tangent if ahead else tangent
    return _centred(automaton, Point(shot, state, period, scale, tangent, cyclic(shot.run), cost))


def _shot(automaton: HybridAutomaton, state: Array, period: float, size: Array) -> Shot:
    run = solve(automaton, period, x0=state, progress=False)
    if run.status is Status.INTERRUPTED:
        raise KeyboardInterrupt
    if not run.status.ok:
        raise SaltationError(f"the motion ends after {run.raw.t:g} s: {run.status}")
    missed = float(np.abs((run.final_state - state) / size).max())
    return Shot(run, tangent_flow(run, progress=False).matrix, missed)


def _scale(automaton: HybridAutomaton, shot: Shot, period: float, span: float) -> Array:
    states = shot.run.states[:, :-1]
    found, values = scales(states, automaton.coordinates), np.abs(states).max(axis=0)
    still = sizes(states) < STILL * values  # a state that rests may change along the branch by what it is
    return np.append(np.where(still, np.maximum(found, values), found), [period, span])


def _rows(shot: Shot, period: float, scale: Array) -> Array:
    """Derivative (n + 1, n + 2) by u of what closes the orbit, and the direction of the flow at its start."""
    first, last = (rate[:-1] / scale[:-2] for rate in end_rates(shot.run))
    n, matrix = len(first), shot.matrix[:-1]
    by_state = matrix[:, :-1] * scale[:n] / scale[:n, None] - np.eye(n)
    by_value = matrix[:, -1] * scale[-1] / scale[:n]
    flow = np.append(first / np.linalg.norm(first), [0.0, 0.0])
    return np.vstack([np.column_stack([by_state, last * scale[-2], by_value]), flow])


def _null(shot: Shot, state: Array, period: float, scale: Array) -> Array:
    """The tangent du/ds, but for its sign; ValueError where there is more than one."""
    _, sizes, rows = np.linalg.svd(_rows(shot, period, scale))
    if sizes[-1] < FAMILY * sizes[0]:
        raise ValueError(
            "the orbit is one of a family at one value of the parameter: it has no single branch"
        )
    return rows[-1]


def _correction(shot: Shot, period: float, scale: Array, across: Array, off: Array) -> Array:
    """Newton's step for u: it closes the orbit, normal to the flow, and stays on the plane `across`."""
    missed = (shot.run.final_state - shot.run.raw.step_states[0])[:-1] / scale[:-2]
    matrix = np.vstack([_rows(shot, period, scale), across])
    left: Any = np.concatenate([missed, [0.0], [across @ off]])
    return np.linalg.lstsq(matrix, -left, rcond=1e-13)[0]


def _centred(automaton: HybridAutomaton, point: Point) -> Point:
    """The point with its state moved on to the middle of the longest stay without constraints."""
    run, tangent, scale = point.shot.run, point.tangent, point.scale
    middle = _middle(automaton, run)
    if not middle > 0.0:
        return point
    part = solve(automaton, middle, x0=point.state, progress=False)
    physical = np.append(tangent[:-2], tangent[-1]) * np.append(scale[:-2], scale[-1])
    carried = (tangent_flow(part, progress=False).matrix @ physical)[:-1] / scale[:-2]
    flow = end_rates(part)[1][:-1] / scale[:-2]
    carried -= flow * (flow @ carried) / (flow @ flow)
    moved = np.append(carried, tangent[-2:])
    return point._replace(state=part.final_state, tangent=moved / np.linalg.norm(moved))


def _middle(automaton: HybridAutomaton, run: Any) -> float:
    """Time of the middle of the longest stay in a mode without constraints; 0 where there are no events."""
    t, period = run.events.t, run.raw.t
    if not len(t):
        return 0.0
    free = [mode.name for mode in automaton.modes if not mode.constraints]
    lengths = np.where(np.isin(run.events.target, free), np.diff(np.append(t, t[0] + period)), 0.0)
    i = int(np.argmax(lengths))
    return float((t[i] + 0.5 * lengths[i]) % period)


def cyclic(run: Any) -> tuple[str, ...]:
    """The modes that the events of a closed orbit lead to, begun where that is first in the alphabet."""
    names = tuple(run.events.target.tolist())
    return min((names[i:] + names[:i] for i in range(len(names))), default=())
