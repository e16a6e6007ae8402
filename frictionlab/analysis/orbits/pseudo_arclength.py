"""Pseudo-arclength steps along a branch of periodic orbits: tangent predictor, corrector on a normal plane.

The parameter is an additional state of zero rate, so that the tangent flow also has the derivatives by it,
through events.  The corrector is Newton's method.  The unknowns are the state z, the period T and the
parameter; scaled, they are u = (z/size, T/period, parameter/span).  Source: Seydel, Practical Bifurcation and
Stability Analysis, 3rd ed., Springer 2010.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import sympy as sp

from frictionlab.analysis.motion_scales import Array
from frictionlab.analysis.orbits.periodic_orbit import (
    RESIDUAL_ROUNDING,
    OrbitGuess,
    ShootingResult,
    check_orbit,
    freest_stay,
    mode_to_state,
    run_one_period,
    scales_of_orbit,
)
from frictionlab.automaton import HybridAutomaton, Mode
from frictionlab.automaton.modes_on_demand import Combination, ModesOnDemand
from frictionlab.hybrid.solve import solve
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.hybrid.variational.tangent_flow import tangent_flow

MAX_CORRECTOR_ITERATIONS = 12
RESIDUAL_TOLERANCE = 1e-9  # largest residual of an orbit, as a share of the motion's size
# Least over largest singular value below which an orbit is one of a family at one value of the parameter.
FAMILY_SINGULAR_RATIO = 1e-9
# share of the largest singular value of the corrector's matrix: smaller ones are due to rounding
CORRECTOR_RCOND = 1e-13
# How far from its prediction, beyond the length of the step, an orbit may be found.
MAX_PREDICTION_ERROR = 0.01
SHORTEST_CHORD = 1e-6  # of a shorter one rounding turns the direction
MIN_CONTRACTION = 0.5  # a residual that shrinks less has reached rounding, or will not converge


class BranchPoint(NamedTuple):
    """A periodic orbit on a branch.

    `state` (n + 1,) ends with the parameter.  `scale` (n + 2,) divides the unknowns to give u, in which the
    period comes last but one; `tangent` (n + 2,) is du/ds.  `modes` are those entered at the events; `cost`
    counts iterations.  `mode` is that of the state, where it has constraints.
    """

    shot: ShootingResult
    state: Array
    period: float
    scale: Array
    tangent: Array
    modes: tuple[str, ...]
    cost: int
    alignment: float = 1.0
    mode: str | None = None

    @property
    def value(self) -> float:
        """The parameter."""
        return float(self.state[-1])

    @property
    def monodromy(self) -> Array:
        """Derivative (n, n) of the state after a period by the state."""
        return self.shot.matrix[:-1, :-1]


def with_parameter_as_state(automaton: HybridAutomaton, parameter: str) -> HybridAutomaton:
    """The automaton with a parameter as its last state, of zero rate."""
    symbol = next(s for s in automaton.parameters if s.name == parameter)
    others = {s: value for s, value in automaton.parameters.items() if s is not symbol}
    states, modes = (*automaton.states, symbol), _modes_with_constant(automaton.modes)
    return replace(automaton.derived(), states=states, modes=modes, parameters=others)


@lru_cache(maxsize=64)
def _modes_with_constant(modes: tuple[Mode, ...] | ModesOnDemand) -> tuple[Mode, ...] | ModesOnDemand:
    """The modes with an additional last state of zero rate; cached, as tapes are kept by their modes."""
    if not isinstance(modes, ModesOnDemand):
        return tuple(map(_with_constant, modes))

    def derive(combination: Combination) -> Mode:
        mode = modes.mode(combination)
        assert mode is not None  # it is allowed
        return _with_constant(mode)

    return ModesOnDemand(modes.parts, derive, modes.names, products=modes.products)


def _with_constant(mode: Mode) -> Mode:
    return replace(mode, flow=(*mode.flow, sp.S.Zero))


def first_point(
    automaton: HybridAutomaton, state: Array, period: float, span: float, mode: str | None
) -> BranchPoint:
    """The branch point of an orbit; `state` ends with the parameter, which grows along the tangent."""
    shot = run_one_period(automaton, OrbitGuess(state, period, np.ones(len(state)), mode, 1))
    scale = _point_scale(shot, period, span)
    tangent = _tangent(shot, state, period, scale)
    return _centre_in_stay(
        automaton,
        BranchPoint(
            shot,
            state,
            period,
            scale,
            tangent * (np.sign(tangent[-1]) or 1.0),
            cyclic_mode_sequence(shot.run),
            MAX_CORRECTOR_ITERATIONS,
            mode=mode,
        ),
    )


def reversed_point(point: BranchPoint) -> BranchPoint:
    """The same point with its tangent reversed."""
    return point._replace(tangent=-point.tangent)


def continuation_step(
    automaton: HybridAutomaton, point: BranchPoint, step: float, value: float | None = None
) -> BranchPoint:
    """The periodic orbit about `step` further along the branch, or that at a given `value` of the parameter.

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
    for cost in range(MAX_CORRECTOR_ITERATIONS):
        state, period = np.append(start[:-2], start[-1]), float(start[-2])
        if not 0.0 < period < 2.0 * point.period:
            raise ValueError("the period leaves its range")
        shot = run_one_period(automaton, OrbitGuess(state, period, size, point.mode, 1))
        if shot.residual <= RESIDUAL_ROUNDING or (
            shot.residual < RESIDUAL_TOLERANCE and shot.residual > MIN_CONTRACTION * missed and cost
        ):
            break
        if cost > 2 and shot.residual > 2.0 * missed:
            raise ValueError("Newton's method diverges")
        missed = shot.residual
        start = start + scale * _corrector_step(shot, period, scale, across, (start - aim) / scale)
        start[-1] = start[-1] if value is None else value
    if not shot.residual < RESIDUAL_TOLERANCE:
        raise ValueError(f"no periodic orbit found: the residual is {shot.residual:.2g}")
    if np.linalg.norm((start - aim) / scale) > MAX_PREDICTION_ERROR + abs(step):
        raise ValueError("the periodic orbit found is of another branch")
    check_orbit(shot, OrbitGuess(state, period, size))
    return _next_point(automaton, point, shot, shot.run.raw.step_states[0], period, cost)


def _next_point(
    automaton: HybridAutomaton,
    before: BranchPoint,
    shot: ShootingResult,
    state: Array,
    period: float,
    cost: int,
) -> BranchPoint:
    """The branch point of an orbit found, its tangent pointing forwards, its state moved away from events."""
    scale = _point_scale(shot, period, float(before.scale[-1]))
    tangent = _tangent(shot, state, period, scale)
    ahead = float(tangent @ (before.tangent * before.scale / scale)) < 0.0
    tangent = -tangent if ahead else tangent
    chord = np.append(state[:-1], [period, state[-1]])
    chord = (chord - np.append(before.state[:-1], [before.period, before.value])) / scale
    size = float(np.linalg.norm(chord))
    alignment = abs(float(tangent @ chord)) / size if size > SHORTEST_CHORD else 1.0
    modes = cyclic_mode_sequence(shot.run)
    return _centre_in_stay(
        automaton, BranchPoint(shot, state, period, scale, tangent, modes, cost, alignment, before.mode)
    )


def _point_scale(shot: ShootingResult, period: float, span: float) -> Array:
    return np.append(scales_of_orbit(shot.run, shot.missed)[:-1], [period, span])


def _corrector_rows(shot: ShootingResult, period: float, scale: Array) -> Array:
    """Derivative (n + 1, n + 2) of the orbit's residual by u, and the direction of the flow at its start."""
    first, last = (rate[:-1] / scale[:-2] for rate in shot.end_rates)
    n, matrix = len(first), shot.matrix[:-1]
    by_state = matrix[:, :-1] * scale[:n] / scale[:n, None] - np.eye(n)
    by_value = matrix[:, -1] * scale[-1] / scale[:n]
    flow = np.append(first / np.linalg.norm(first), [0.0, 0.0])
    return np.vstack([np.column_stack([by_state, last * scale[-2], by_value]), flow])


def _tangent(shot: ShootingResult, state: Array, period: float, scale: Array) -> Array:
    """The tangent du/ds, but for its sign; ValueError where there is more than one."""
    _, sizes, rows = np.linalg.svd(_corrector_rows(shot, period, scale))
    if sizes[-1] < FAMILY_SINGULAR_RATIO * sizes[0]:
        raise ValueError(
            "the orbit is one of a family at one value of the parameter: it has no single branch"
        )
    return rows[-1]


def _corrector_step(shot: ShootingResult, period: float, scale: Array, across: Array, off: Array) -> Array:
    """Newton's step for u: normal to the flow, it closes the orbit on the plane with the normal `across`."""
    missed = shot.missed[:-1] / scale[:-2]
    matrix = np.vstack([_corrector_rows(shot, period, scale), across])
    left: Any = np.concatenate([missed, [0.0], [across @ off]])
    return np.linalg.lstsq(matrix, -left, rcond=CORRECTOR_RCOND)[0]


def _centre_in_stay(automaton: HybridAutomaton, point: BranchPoint) -> BranchPoint:
    """The point with its state moved along the orbit to the middle of the longest stay in a mode with the
    fewest constraints."""
    run, tangent, scale = point.shot.run, point.tangent, point.scale
    if not len(run.events):
        return point
    t, period = run.events.t, run.raw.t
    lengths = np.diff(np.append(t, t[0] + period))
    i = freest_stay(automaton, run.events.target.tolist(), lengths)
    middle = float((t[i] + 0.5 * lengths[i]) % period)
    mode = mode_to_state(run, middle)
    if not middle > 0.0:
        return point
    part = solve(automaton, middle, x0=point.state, mode=point.mode, progress=False)
    physical = np.append(tangent[:-2], tangent[-1]) * np.append(scale[:-2], scale[-1])
    closing = point.shot.closing  # a shift along which nothing changes is no part of the tangent
    carried = (closing.matrix(tangent_flow(part, progress=False).matrix) @ physical)[:-1] / scale[:-2]
    flow = closing.end_rates(part)[1][:-1] / scale[:-2]
    carried -= flow * (flow @ carried) / (flow @ flow)
    turned = np.append(carried, tangent[-2:])
    return point._replace(state=part.final_state, tangent=turned / np.linalg.norm(turned), mode=mode)


def cyclic_mode_sequence(run: Trajectory) -> tuple[str, ...]:
    """The modes entered at the events of a periodic orbit, rotated so that the first in the alphabet comes
    first."""
    names = tuple(run.events.target.tolist())
    return min((names[i:] + names[:i] for i in range(len(names))), default=())
