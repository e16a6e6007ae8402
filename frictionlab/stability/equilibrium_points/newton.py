"""Zeros of flows: Newton's method from many starts, and a homotopy to other values of the parameters."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from math import prod
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionlab.stability.equilibrium_points.root_boxes import RootBoxes, angles_of, root_boxes
from frictionlab.stability.flow import Flow
from frictionlab.stability.state_matrices import (
    MACHINE_EPSILON,
    eigenvalues_of_matrices,
    growth_rates,
    inverse_of,
)
from frictionlab.tape.intervals import Interval, interval

Array = NDArray[np.float64]
# Share of a state: candidates so close are one.  Two zeros that are nearer to each other than the root of the
# machine epsilon cannot be told apart: rounding moves each by more than that.
SAME_CANDIDATE_RTOL = 1e-9
MAX_UNCERTAINTY = 1e-6  # share of a state: what may be unknown of it
LAST_STEP_RTOL = 1e-9  # share of a state: a step so short is the last
TINY = np.finfo(float).tiny  # for the size of a state that is zero
SCALE_ROUNDING = 1e-14  # of a state's usual size: what is smaller is rounding
MAX_POLISH_STEPS = 64
POLISH_CONTRACTION = 0.9  # if a step is longer than this share of the last, it is rounding alone
NOISE_SAMPLES = 16  # states near a zero at which the rounding of the flow is seen
NUMBERS_AT_ONCE = 1_000_000  # entries of Jacobians: as many samples as have no more are evaluated together
NOISE_DISTANCE = 1e-8  # share of a state: how far they are from the zero
FINER_DISTANCES = 1e-11, 1e-14  # the same where the flow is not linear so far, such as a sine of many turns
TURNED_SHARE = 0.1  # of the Jacobian's change at the first distance: so much at the last is all of it
ORIGIN_DISTANCE = 1e4  # times rounding of the usual size: how far they are from a zero at the origin
POLE_DISTANCE, POLE_FACTOR = 1e-5, 16.0  # share of a state; near a pole rates are so many times those there
# Relative change of the Jacobian beyond which a change of the flow is more than linear and rounding.
NONLINEARITY_RTOL = 1e-3
SAME_ZERO_FACTOR = 16.0  # times the uncertainty of both: zeros so close are one

START_COUNT, SEARCH_STEPS = 192, 64  # starting points, and steps from each
START_DECADES = 15.0  # by which a state may differ from the linearised flow's zero
RESTART_ROUNDS = 8  # of new starts from the zeros found
RESTART_DECADES = (-9.0, 2.0)  # of the distances of these starts from the zeros
BOX_RTOL, BOX_ATOL = 1e-3, 1e-9  # shares of a state, and of its usual size: a zero so near is that of a box
CORRECTOR_STEPS = 40  # next to a fold each halves the distance; nearer than 2^-40 it is at the fold
# Over a corner a step on each side is enough, and a few more where the sides are not straight.
CORNER_STEPS = 6
SAFE_CHANGE, SAFE_CONTRACTION = 0.5, 0.25  # of the Jacobian within a step, and of the next step
ROUNDING_OF_OTHERS = 1e-12  # share of the largest state
# Of a step: at a round one alone what turns may be as at its start.
STEP_SHARES = np.array([[0.47], [1.0]])
SHORTEST_PART, MOST_PARTS = 2.0**-14, 256  # of the way to other values of the parameters
CORNER_RTOL = 1e-3  # share of a step over a corner of a law, to which the way back leads to its start

LEAST_STATES = 32  # below, whole matrices at all points take less than a tenth of a second
MOST_NONLINEAR_SHARE = 0.25  # of the states: with more, whole matrices cost about as much
REFERENCES_TRIED = 8  # points at which J_0 may be taken


def newton_step(flow: Flow, x: Array, values: Sequence[Any]) -> Array:
    """The step (m, N) towards a zero; NaN where the flow is not finite."""
    with np.errstate(all="ignore"):
        return _newton_step(flow.jacobian(x, values), flow.rhs(x, values))


def _newton_step(matrices: Array, rest: Array) -> Array:
    """The step (m, ..., N) of Jacobians (N, m, m) and rates (m, ..., N)."""
    columns = np.moveaxis(rest, -1, 0)
    right = columns.reshape(*columns.shape[:2], prod(columns.shape[2:]))  # of no points too
    usable = np.isfinite(matrices).all(axis=(1, 2)) & np.isfinite(right).all(axis=(1, 2))
    step = np.full_like(right, np.nan)
    step[usable] = -solve_matrices(matrices[usable], right[usable])
    return np.moveaxis(step.reshape(columns.shape), 0, -1)


def solve_matrices(matrices: Array, right: Array) -> Any:
    """Solutions (N, m, k); those of least length where a matrix is singular, as at a fold.

    Rows of a single entry, as those of x' = v, give their unknown at once.  So a velocity of zero is exactly
    zero.  An elimination of all rows leaves rounding in it, another on each processor.
    """
    filled: Any = matrices.any(axis=0)
    rows = np.flatnonzero(filled.sum(axis=1) == 1)
    columns = filled[rows].argmax(axis=1)
    regular = matrices[:, rows, columns].all(axis=0)
    rows, columns = rows[regular], columns[regular]
    if not rows.size or len({*columns.tolist()}) < rows.size:
        return _eliminate(matrices, right)
    solutions = np.empty_like(right)
    solutions[:, columns] = right[:, rows] / matrices[:, rows, columns, None]
    if rows.size < len(filled):
        left = np.ones((2, len(filled)), dtype=bool)
        left[0, rows], left[1, columns] = False, False
        other_rows, others = map(np.flatnonzero, left)
        rest = matrices[:, other_rows]
        known = rest[:, :, columns] @ solutions[:, columns]
        solutions[:, others] = solve_matrices(rest[:, :, others], right[:, other_rows] - known)
    return solutions


def _eliminate(matrices: Array, right: Array) -> Any:
    """Solutions of matrices without rows of a single entry.

    numpy does not tell which matrix of a stack is singular.  The sign of its determinant is zero then, by the
    same factors.  A LAPACK whose factors depend on the stack gets the matrices one by one.
    """
    try:
        return np.linalg.solve(matrices, right)
    except np.linalg.LinAlgError:
        if len(matrices) == 1:
            return np.linalg.pinv(matrices) @ right
    with np.errstate(all="ignore"):  # a matrix that is not finite has no sign
        singular = np.linalg.slogdet(matrices).sign == 0
    solutions = np.empty_like(right)
    solutions[singular] = np.linalg.pinv(matrices[singular]) @ right[singular]
    try:
        solutions[~singular] = np.linalg.solve(matrices[~singular], right[~singular])
    except np.linalg.LinAlgError:
        for i in np.flatnonzero(~singular):
            solutions[i : i + 1] = _eliminate(matrices[i : i + 1], right[i : i + 1])
    return solutions


@dataclass(frozen=True, eq=False)
class LowRankNewton:
    r"""Newton's steps at all points of a large system by one inverse matrix.

    Where few states enter nonlinearly, only their columns change from point to point: J(x) = J_0 + C(x) S,
    where S has the rows of the unit matrix that select them.  With the inverse of J_0, computed once, a step
    costs a product of that matrix and a vector, and the solution of one equation for each such state
    (Sherman, Morrison and Woodbury),

    .. math:: J^{-1} b = y - J_0^{-1} C (1 + S J_0^{-1} C)^{-1} S y, \qquad y = J_0^{-1} b

    instead of the elimination of a whole matrix.

    Parameters
    ----------
    flow : Flow
    values : sequence of float
        Of the parameters.
    inverse : (m, m) array
        Of the Jacobian at a point of reference.
    columns : (m, k) array
        The columns of that Jacobian that change.
    """

    flow: Flow
    values: Sequence[float]
    inverse: Array
    columns: Array

    def step(self, x: Array) -> Array:
        """The step (m, N) towards a zero; not finite where the flow is not."""
        nonlinear = self.flow.nonlinear
        with np.errstate(all="ignore"):
            plain = self.inverse @ self.flow.rhs(x, self.values)
            change = self.flow.nonlinear_columns(x, self.values) - self.columns
            effect = self.inverse @ change  # (N, m, k)
            small = np.eye(len(nonlinear)) + effect[:, nonlinear, :]
            usable: Any = np.isfinite(small).all(axis=(1, 2)) & np.isfinite(plain).all(axis=0)
            usable[usable] = np.linalg.det(small[usable]) != 0
            step = np.full_like(x, np.nan)
            parts = np.linalg.solve(small[usable], plain.T[usable][:, nonlinear, None])
            step[:, usable] = -plain[:, usable] + (effect[usable] @ parts)[..., 0].T
        return step


def low_rank_newton(flow: Flow, values: Sequence[float], x: Array) -> LowRankNewton | None:
    """Newton's steps by the inverse at one of the points (m, N); None where that saves nothing or fails."""
    m = flow.size
    if m < LEAST_STATES or flow.linear or len(flow.nonlinear) > MOST_NONLINEAR_SHARE * m:
        return None
    for point in x.T[:REFERENCES_TRIED]:
        with np.errstate(all="ignore"):
            matrix = flow.jacobian(point, values)
        inverse = inverse_of(matrix) if np.isfinite(matrix).all() else None
        if inverse is not None:
            return LowRankNewton(flow, values, inverse, matrix[:, flow.nonlinear])
    return None


def polish_zeros(flow: Flow, x: Array, values: Sequence[Any], scale: Array) -> tuple[Array, Array]:
    """Those of the points (m, N) that Newton's method turns into zeros, and the uncertainty of each.

    The uncertainty is the effect of the flow's rounding on a zero, plus the last step.  At a double zero
    steps are halved each time, so the last step is the distance to it.  A zero may be so far out that
    rounding determines its place.  It is left out, unless it is the only one far around.  `scale` (m, 1) is
    the scale of states that are zero.
    """
    x, step = _polish(flow, x[:, _is_near_zero(flow, x, values, scale)], values)
    noise, shift, terms, distance = _rounding_noise(flow, x, values, scale)
    least, rtol = SCALE_ROUNDING * np.fmax(scale, terms), LAST_STEP_RTOL / NOISE_DISTANCE * distance
    forces = _times(np.abs(flow.jacobian(x, values)), np.abs(x) + least)
    # At a singular matrix a step of zero does not mean a zero: the rates themselves have to vanish.
    balanced = np.abs(flow.rhs(x, values)) <= np.fmax(rtol * forces, SAME_ZERO_FACTOR * noise)
    converged = step <= np.fmax(rtol * np.abs(x) + least, SAME_ZERO_FACTOR * shift)
    converged &= ~_is_pole(flow, x, values)
    error = step + shift
    zeros: Any = (balanced & converged).all(axis=0)
    doubtful = np.flatnonzero(zeros & ~(error <= MAX_UNCERTAINTY * np.abs(x) + least).all(axis=0))
    room = error[:, doubtful] / MAX_UNCERTAINTY
    zeros[doubtful] = _is_regular(flow, x[:, doubtful], [_chosen(one, doubtful) for one in values], room)
    return x[:, zeros], error[:, zeros]


def _is_regular(flow: Flow, x: Array, values: Sequence[Any], room: Array) -> Any:
    """Whether all matrices within the Jacobian's bounds are regular, in boxes x +- room (m, N).

    Then a zero is the only one in its box, also where its states are small by chance.  By the condition of
    H. Beeck: the spectral radius of |J^-1| dJ is below 1.
    """
    try:
        entries = flow.slopes([*map(Interval, x - room, x + room)], values)
    except TypeError:  # a function without bounds
        return False
    matrices = flow.jacobian(x, values)
    changes, unit = np.zeros_like(matrices), np.broadcast_to(np.eye(len(x)), matrices.shape)
    for (i, j), entry in entries.items():
        bounds = interval(entry)
        changes[:, i, j] = np.fmax(bounds.high - matrices[:, i, j], matrices[:, i, j] - bounds.low)
    ratios = np.abs(solve_matrices(matrices, unit)) @ changes
    known = np.isfinite(ratios).all(axis=(1, 2))
    known[known] = np.abs(np.linalg.eigvals(ratios[known])).max(axis=1, initial=0.0) <= SAFE_CHANGE
    return known


def _is_pole(flow: Flow, x: Array, values: Sequence[Any]) -> Any:
    """Where a rate is much larger than all around: near a pole Newton's steps are short as well."""
    random, most = np.random.default_rng(0), np.zeros_like(x)
    shares = [random.uniform(-1, 1, size=(len(x), 1)) for _ in range(NOISE_SAMPLES)]
    around = np.hstack([x + share * POLE_DISTANCE * np.abs(x) for share in shares])
    for rates in np.hsplit(np.abs(flow.rhs(around, _repeated(values, NOISE_SAMPLES))), NOISE_SAMPLES):
        most = np.fmax(most, rates)
    return (np.abs(flow.rhs(x, values)) > POLE_FACTOR * most) & (most > 0)


def _is_near_zero(flow: Flow, x: Array, values: Sequence[Any], scale: Array) -> Any:
    """Where Newton's method has nearly converged."""
    least = SCALE_ROUNDING * np.fmax(scale, np.abs(x).max(axis=0))
    return (np.abs(newton_step(flow, x, values)) <= MAX_UNCERTAINTY * np.abs(x) + least).all(axis=0)


def _polish(flow: Flow, x: Array, values: Sequence[Any]) -> tuple[Array, Array]:
    """The points after Newton's steps, as long as these shrink, and the size of the next step."""
    step, active = newton_step(flow, x, values), np.ones(x.shape[1], dtype=bool)
    for _ in range(MAX_POLISH_STEPS):
        x = np.where(active, x + step, x)
        after = newton_step(flow, x, values)
        least, most = MACHINE_EPSILON * np.abs(x), POLISH_CONTRACTION * np.abs(step)
        shrinks = (np.abs(after) < most) & (np.abs(after) > least)
        step, active = after, active & shrinks.any(axis=0)
        if not active.any():
            break
    return x, np.abs(step)


def _rounding_noise(
    flow: Flow, x: Array, values: Sequence[Any], scale: Array
) -> tuple[Array, Array, Array, Array]:
    """The flow's rounding at zeros (m, N), and the uncertainty of the zeros by it.

    Also the size of the terms whose sum gives each state of a zero, larger than the state where they cancel;
    and the distance (N,) of the samples, as a share of the state: within it the flow is linear.
    """
    matrices, random = flow.jacobian(x, values), np.random.default_rng(0)
    distance = np.full(x.shape[1], NOISE_DISTANCE)
    noise, bent, turned = _sampled_noise(flow, x, values, random, NOISE_DISTANCE)
    closer = np.random.default_rng(1)
    for finer in FINER_DISTANCES:
        (there,) = np.nonzero(bent)
        if not there.size:
            break
        some = [_chosen(one, there) for one in values]
        noise[:, there], bent[there], now = _sampled_noise(flow, x[:, there], some, closer, finer)
        # Where all of the Jacobian turns within the last digits, nothing is known.  At a double zero it turns
        # in proportion to the distance.
        distance[there] = np.where(bent[there] & (now > TURNED_SHARE * turned[there]), 0.0, finer)
    noise[:, distance == 0.0] = 0.0
    leasts = MACHINE_EPSILON * np.geomspace(1, ORIGIN_DISTANCE, NOISE_SAMPLES)
    ways = [_random_way(random, distance * np.abs(x) + least * scale) for least in leasts]
    for missed, curved, _ in _missed(flow, x, values, ways):
        noise = np.where(curved, noise, np.fmax(noise, missed))  # too far from a zero so near to the origin
    inverse = np.abs(solve_matrices(matrices, np.broadcast_to(np.eye(len(x)), matrices.shape)))
    terms = _times(inverse, _times(np.abs(matrices), np.abs(x)))
    return noise, MACHINE_EPSILON * terms + _times(inverse, noise), terms, distance


def _sampled_noise(
    flow: Flow, x: Array, values: Sequence[Any], random: np.random.Generator, distance: float
) -> tuple[Array, Any, Array]:
    """The flow's rounding near zeros, at a distance that is a share of the states.

    Also where the flow is not linear so far, and the largest change of its Jacobian there.
    """
    noise, turned = np.zeros_like(x), np.zeros(x.shape[1])
    bent: Any = np.zeros(x.shape[1], dtype=bool)
    ways = [_random_way(random, distance * np.abs(x)) for _ in range(NOISE_SAMPLES)]
    for missed, curved, change in _missed(flow, x, values, ways):
        noise, bent, turned = np.fmax(noise, missed), bent | curved.any(axis=0), np.fmax(turned, change)
    return noise, bent, turned


def _random_way(random: np.random.Generator, distance: Array) -> Array:
    """A way (m, N) from each point; all points have the same random numbers."""
    return random.uniform(-1, 1, size=(len(distance), 1)) * distance


def _chosen(values: Any, there: Any) -> Any:
    """The values of a parameter at some of the points, if it has one for each."""
    return values[there] if np.ndim(values) else values


def _repeated(values: Sequence[Any], count: int) -> list[Any]:
    """The values of parameters for points that are repeated `count` times."""
    return [np.tile(one, count) if np.ndim(one) else one for one in values]


def _missed(
    flow: Flow, x: Array, values: Sequence[Any], ways: Sequence[Array]
) -> Iterator[tuple[Array, Any, Array]]:
    """By how much the flow's change along each way (m, N), ahead and back, is not that of its Jacobian.

    Ahead and back, since curvature is no rounding.  Also where the Jacobian changes along the way, and the
    largest change of its entries.  Many ways are evaluated together: of few points a call costs as much.
    """
    matrices = flow.jacobian(x, values)
    at_once = max(NUMBERS_AT_ONCE // max(matrices.size, 1), 1)
    for first in range(0, len(ways), at_once):
        some = ways[first : first + at_once]
        way, here = np.hstack(some), np.tile(x, (1, len(some)))
        slopes, at = np.tile(matrices, (len(some), 1, 1)), _repeated(values, 2 * len(some))
        ahead, back = here + way, here - way
        both = np.hstack([ahead, back])
        there, before = np.hsplit(flow.rhs(both, at), 2)
        missed = np.abs(there - before - _times(slopes, ahead - back))
        change = np.subtract(*np.split(flow.jacobian(both, at), 2))
        curved = np.abs(_times(change, way)) > NONLINEARITY_RTOL * _times(np.abs(slopes), np.abs(way))
        largest = np.abs(change).max(axis=(1, 2), initial=0.0)
        count = len(some)
        yield from zip(np.hsplit(missed, count), np.hsplit(curved, count), np.split(largest, count))


def _times(matrices: Array, x: Array) -> Array:
    """Products (m, N) of matrices (N, m, m) and columns."""
    return (matrices @ x.T[:, :, None])[:, :, 0].T


def distinct_zeros(x: Array, error: Array) -> Array:
    """Zeros (m, K), each once, by their distance from the origin; those within their uncertainty are one.

    Symmetric zeros have the same distance up to rounding.  The one with the larger first state comes first.
    """
    distinct: list[int] = []
    for i in np.argsort(np.linalg.norm(x, axis=0), kind="stable"):
        distances = np.abs(x[:, distinct] - x[:, [i]])
        if (distances > SAME_ZERO_FACTOR * (error[:, distinct] + error[:, [i]])).any(axis=0).all():
            distinct.append(int(i))
    return x[:, sorted(distinct, key=lambda i: (float(f"{np.linalg.norm(x[:, i]):.9e}"), *-x[:, i]))]


def merge_candidates(x: Array) -> Array:
    """The points (m, K) among those given (m, N) that differ, in their order."""
    distinct: list[int] = []
    for i in range(x.shape[1]):
        differs = np.abs(x[:, distinct] - x[:, [i]]) > SAME_CANDIDATE_RTOL * np.abs(x[:, [i]])
        if differs.any(axis=0).all():
            distinct.append(i)
    return x[:, distinct]


class Zeros(NamedTuple):
    """What a search for zeros gave.

    Parameters
    ----------
    points : array (m, K)
        Zeros, each once, by their distance from the origin.
    why : str
        Why others cannot be excluded; empty where it is known that there are none.
    """

    points: Array
    why: str = ""


def find_zeros(flow: Flow, values: Sequence[float]) -> Zeros:
    """The zeros of a flow; those that differ by whole turns of angles are one.

    If bounds of the flow tell in which boxes zeros may lie (`root_boxes`), Newton's method starts there.
    Otherwise it starts from all decades, as it leads to a zero from within some factor of it.  If several
    coordinates have several zeros each, few starts are near each combination.  So the search starts again
    from the zeros that it has, until it finds no more.
    """
    with np.errstate(all="ignore"):  # a start may lead out of the range of floats; it is dropped then
        angles = angles_of(flow, values)
        boxes = root_boxes(flow, values, angles)
        if not boxes.why and not boxes.starts.shape[1]:
            return Zeros(boxes.starts)
        random = np.random.default_rng(0)
        x, scale = _starts(flow, values, random)
        sure = boxes.starts[:, boxes.on_jump]
        if not boxes.why and not flow.linear:
            inside = _zeros_in_boxes(flow, values, boxes, scale)
            if not inside.why:
                return Zeros(_within_turn(flow, values, angles, inside.points, scale))
            sure, boxes = inside.points, replace(boxes, why=inside.why)
        cheap = low_rank_newton(flow, values, x)
        candidates = _zeros_from(flow, values, np.hstack([x, boxes.starts]), scale, cheap)
        for _ in range(0 if flow.linear else RESTART_ROUNDS):
            before = candidates.shape[1]
            candidates = _zeros_from(
                flow,
                values,
                np.hstack([candidates, _restart_points(flow, values, candidates, random)]),
                scale,
                cheap,
            )
            if not before < candidates.shape[1] < START_COUNT:  # no new zeros, or a continuum of zeros
                break
        candidates = np.hstack([sure, _credible(flow, values, candidates, scale)])
        points = (
            distinct_zeros(candidates, SAME_CANDIDATE_RTOL * np.abs(candidates)) if sure.size else candidates
        )
        points = _within_turn(flow, values, angles, points, scale)
    return Zeros(points, boxes.why)


def settled_first(flow: Flow, points: Array, values: Sequence[float], places: Sequence[int]) -> Array:
    """Zeros (m, K) of a flow in the order in which one is taken, by the states of friction laws at `places`.

    First come those at which these states, with all others held, do not grow.  Of them the nearest to zero in
    these states are first, of -z and z the positive one; all others stay in their order.
    """
    if points.shape[1] < 2 or not places:
        return points
    with np.errstate(all="ignore"):
        blocks = flow.jacobian(points, values)[:, places][:, :, places]
    blocks[~np.isfinite(blocks).all(axis=(1, 2))] = 0.0  # without slopes nothing tells
    grows = (growth_rates(eigenvalues_of_matrices(blocks)) > 0.0).any(axis=1)
    sizes = np.linalg.norm(points[places], axis=0)
    with np.errstate(all="ignore"):
        rounding = SCALE_ROUNDING * _usual_sizes(flow, values)[places].max()
    nearest = (1.0 + SAME_CANDIDATE_RTOL) * sizes[grows == grows.min()].min() + rounding
    far, states = sizes > nearest, points[places]
    signs = np.where(far | (np.abs(states) <= rounding), 0.0, np.sign(states))
    return points[:, np.lexsort((*-signs[::-1], far, grows))]


def _within_turn(
    flow: Flow, values: Sequence[float], angles: tuple[int, ...], x: Array, scale: Array
) -> Array:
    """Zeros (m, K), each once, whose angles are moved by whole turns into (-pi, pi]."""
    if not angles or not x.size:
        return x
    x = x.copy()
    for i in angles:
        x[i] -= 2 * np.pi * np.ceil((x[i] - np.pi) / (2 * np.pi) - SAME_CANDIDATE_RTOL)
    return distinct_zeros(*polish_zeros(flow, x, values, scale))


def _zeros_in_boxes(flow: Flow, values: Sequence[float], boxes: RootBoxes, scale: Array) -> Zeros:
    """The zeros near the starts in boxes that hold all of them."""
    ends = _search(lambda at: newton_step(flow, at, values), boxes.starts)
    zeros, error = polish_zeros(flow, ends, values, scale)
    distances = np.abs(zeros[:, None, :] - boxes.starts[:, :, None])
    room = (boxes.room + BOX_RTOL * np.abs(boxes.starts) + BOX_ATOL * scale)[:, :, None]
    near: Any = (distances <= room).all(axis=0)
    met = near.any(axis=1) if zeros.shape[1] else np.zeros(len(boxes.flat), bool)
    # A zero of a higher odd order is where a rate changes its sign, and Newton's method does not reach it.
    flats = boxes.flat & ~met
    flat, on_jump = boxes.starts[:, flats], boxes.starts[:, boxes.on_jump]
    points = distinct_zeros(
        np.hstack([on_jump, zeros, flat]),
        np.hstack(
            [MACHINE_EPSILON * np.abs(on_jump), error, BOX_RTOL * np.abs(flat) + SCALE_ROUNDING * scale]
        ),
    )
    doubtful = ~met & ~flats & ~boxes.on_jump
    return Zeros(points, "rates come within rounding of zero elsewhere" if doubtful.any() else "")


def _credible(flow: Flow, values: Sequence[float], x: Array, scale: Array) -> Array:
    """The points that may be zeros by bounds of the flow around them, as wide as rounding of the states."""
    room = SAME_CANDIDATE_RTOL * (np.abs(x) + scale)
    try:
        rows = flow.rates.arrays(*map(Interval, x - room, x + room), *values)
        held: Any = [np.broadcast_to(interval(row).contains_zero(), x.shape[1]) for row in rows]
        return x[:, np.all(held, axis=0)]
    except TypeError:  # a function without bounds
        return x


def _zeros_from(
    flow: Flow, values: Sequence[float], x: Array, scale: Array, cheap: LowRankNewton | None
) -> Array:
    """The zeros that Newton's method finds from the starts."""
    if cheap is None:
        candidates = _search(lambda at: newton_step(flow, at, values), x)
    else:
        candidates = merge_candidates(_search(cheap.step, x))
    return distinct_zeros(*polish_zeros(flow, candidates, values, scale))


def _restart_points(flow: Flow, values: Sequence[float], zeros: Array, random: np.random.Generator) -> Array:
    """Starting points (m, 2 START_COUNT), made of known zeros, for zeros that are hard to find from afar.

    In half of them each coordinate is near that of a zero chosen at random.  At the others all rates but one
    are zero to first order.  So Newton's method looks for other zeros of that one rate, and the others stay
    zero.  Without known zeros there are none.
    """
    rows, count = zeros.shape
    if not count:
        return zeros
    away = random.normal(size=(rows, START_COUNT)) * 10.0 ** random.uniform(
        *RESTART_DECADES, size=START_COUNT
    )
    combined = np.take_along_axis(zeros, random.integers(count, size=(rows, START_COUNT)), axis=1) * (
        1 + away
    )
    zero, rate = random.integers(count, size=START_COUNT), random.integers(rows, size=START_COUNT)
    base = zeros[:, zero]
    if rows < LEAST_STATES:
        only = solve_matrices(flow.jacobian(base, values), np.eye(rows)[rate][:, :, None])[:, :, 0].T
    else:  # by the inverse at each zero: there are fewer zeros than starts
        of_zeros = flow.jacobian(zeros, values)
        inverses = solve_matrices(of_zeros, np.broadcast_to(np.eye(rows), of_zeros.shape))
        only = inverses[zero, :, rate].T
    length = np.abs(base).max(axis=0) / np.abs(only).max(axis=0)
    return np.hstack([combined, base + away[0] * length * only])


def follow_zero(
    flow: Flow,
    x: Array,
    base: Sequence[float],
    admits: Callable[[Array, Sequence[Any]], Any],
    values: Sequence[Any],
    count: int,
) -> Array:
    """Zeros (m, count) for other values of the parameters, followed from `x` (m,) at `base`.

    They are NaN where the zero is lost, and at states that `admits(states, values)` refuses.  The way to the
    values is divided until each part is safe.  A zero is lost where the parts become too short, as at a fold,
    or too many.
    """
    zeros = np.repeat(x[:, None], count, axis=1)
    values = [v if np.ndim(v) == 0 else np.broadcast_to(v, count) for v in values]
    share, part, going = np.zeros(count), np.ones(count), np.arange(count)
    with np.errstate(all="ignore"):
        for _ in range(MOST_PARTS):
            ahead = np.fmin(share[going] + part[going], 1.0)
            step, safe = _first_step(flow, zeros[:, going], _between(base, values, ahead, going))
            short = ~safe & (part[going] < 2 * SHORTEST_PART)
            if short.any():
                some = going[short]
                here, there = (_between(base, values, s, some) for s in (share[some], ahead[short]))
                step[:, short], safe[short] = _corner_step(flow, zeros[:, some], here, there, x[:, None])
            zeros[:, going[safe]] += step[:, safe]
            share[going[safe]] = ahead[safe]
            part[going] *= np.where(safe, 2.0, 0.5)
            going = going[(share[going] < 1.0) & (part[going] >= SHORTEST_PART)]
            if not going.size:
                break
        zeros[:, share < 1.0] = np.nan
        zeros = _settled(flow, zeros, values, x[:, None])
        zeros[:, ~admits(zeros, values)] = np.nan
    return zeros


def _between(
    base: Sequence[float], values: Sequence[Any], shares: Array, some: NDArray[np.intp]
) -> list[Any]:
    """The values of the parameters in columns `some` (N,), at shares (N,) of the way from `base`."""
    return [_part_way(b, _chosen(v, some), shares) for b, v in zip(base, values, strict=True)]


def _part_way(base: float, values: Any, share: Array) -> Any:
    if (share == 1.0).all() or (np.ndim(values) == 0 and values == base):
        return values
    return np.where(share == 1.0, values, base + share * (values - base))


def _first_step(flow: Flow, x: Array, values: Sequence[Any]) -> tuple[Array, Any]:
    """Newton's step (m, N) at other values, and where his method converges from there to the zero at hand.

    By Newton and Kantorovich it does where the Jacobian J changes on the way by at most half of itself.  The
    spectral radius of J^-1 dJ tells that share: it depends on no unit, and on no choice of coordinates.  A
    norm in units of the step is no less, and takes no eigenvalues.
    J says nothing about a rate that jumps.  So the next step by the same J is at most a quarter of this one,
    in each state, but for what dJ explains.  Where it is more, dJ is that to where the next step leads.
    """
    matrices, rates = flow.jacobian(x, values), flow.rhs(x, values)
    step, bent = _newton_step(matrices, rates), flow.nonlinear
    safe: Any = np.isfinite(step).all(axis=0)
    if flow.linear or not safe.any():
        return step, safe
    at, size = x[:, None] + STEP_SHARES * step[:, None], np.abs(step)[:, None]
    next_step = _newton_step(matrices, flow.rhs(at, values) - (1 - STEP_SHARES) * rates[:, None])
    quarter = SAFE_CONTRACTION * size + _rounding(x)[:, None]
    ends = at + np.where((np.abs(next_step) > quarter).any(axis=0), next_step, 0.0)
    changes = flow.nonlinear_columns(ends, values) - matrices[..., bent]
    ratios = _newton_step(matrices, changes.transpose(2, 3, 0, 1))  # (m, k, shares, N), but for the sign
    explained = np.einsum("ij...,j...->i...", np.abs(ratios), size[bent])
    safe &= ((np.abs(next_step) <= quarter + explained) & np.isfinite(explained)).all(axis=(0, 1))
    small = (explained[bent] <= SAFE_CHANGE * size[bent]) & (size[bent] > 0)
    unsure = safe & (~small & ratios.any(axis=0)).any(axis=(0, 1))  # a column of zeros adds nothing
    radii = np.abs(np.linalg.eigvals(ratios[bent][..., unsure].transpose(2, 3, 0, 1))).max(axis=-1)
    safe[unsure] = (radii <= SAFE_CHANGE).all(axis=0)
    return step, safe


def _corner_step(
    flow: Flow, x: Array, here: Sequence[Any], there: Sequence[Any], start: Array
) -> tuple[Array, Any]:
    """A step (m, N) over a corner of a law, at which none is safe however short, and where it is right.

    Newton's method leads to the zeros on both sides of that at hand, and from each back to it.  On one side
    of a fold there is none, and from another branch no way leads back.
    """
    behind = [h + h - t for h, t in zip(here, there, strict=True)]
    at_hand, steps = _settled(flow, x, here, start, CORNER_STEPS), []
    for values in (there, behind):
        zeros = _settled(flow, at_hand, values, start, CORNER_STEPS)
        back = _settled(flow, zeros, here, start, CORNER_STEPS)
        same = np.abs(back - at_hand) <= CORNER_RTOL * np.abs(zeros - at_hand) + _rounding(at_hand)
        at_hand[:, ~same.all(axis=0)] = np.nan  # so that the other side is not looked at
        steps.append(zeros - x)
    return steps[0], np.isfinite(at_hand).all(axis=0)


def _rounding(x: Array) -> Array:
    """What may be rounding of states (m, N), each by itself; one that is zero is so to rounding of others."""
    return LAST_STEP_RTOL * np.abs(x) + ROUNDING_OF_OTHERS * np.abs(x).max(axis=0)


def _starts(flow: Flow, values: Sequence[float], random: np.random.Generator) -> tuple[Array, Array]:
    """The origin and points scattered about it (m, START_COUNT), and sizes of the states (m, 1).

    Where the flow is linear it is the origin alone, as one start is enough.

    The points lie in all decades about the sizes: in half of the points all coordinates share a decade, in
    the others each has one of its own.
    """
    origin, scale = np.zeros((flow.size, 1)), _usual_sizes(flow, values)
    if flow.linear:
        return origin, scale
    scatter = random.normal(size=(len(origin), START_COUNT))
    scatter[:, ::2] *= 10.0 ** random.uniform(-START_DECADES, START_DECADES, size=scatter[:, ::2].shape)
    scatter[:, 1::2] *= 10.0 ** random.uniform(-START_DECADES, START_DECADES, size=scatter[0, 1::2].shape)
    scatter[flow.unseen] = 0.0  # their values do not matter
    return np.hstack([origin, scale * scatter]), scale


def _usual_sizes(flow: Flow, values: Sequence[float]) -> Array:
    """Sizes of the states (m, 1): those of the linearised flow's zero."""
    return _replace_unknown(np.abs(newton_step(flow, np.zeros((flow.size, 1)), values)))


def _replace_unknown(sizes: Array) -> Array:
    """Sizes (m, N) with the largest of its column for one that is zero or unknown; 1 where all are."""
    finite = np.where(np.isfinite(sizes), sizes, 0.0)
    largest = finite.max(axis=0)
    return np.where(finite > 0, finite, np.where(largest > 0, largest, 1.0))


def _settled(
    flow: Flow, x: Array, values: Sequence[Any], start: Array, most_steps: int = CORRECTOR_STEPS
) -> Array:
    """Zeros (m, N) that Newton's method converges to, followed from `start` (m, 1); NaN where it does not, or
    is stuck at a singular matrix.

    The last steps are less than rounding.  In a large system the elimination rounds by more than that; there
    short steps that no longer shrink are enough.  Next to a fold each step is half of the one before.
    """
    count = x.shape[1]
    zeros, before, going = np.full_like(x, np.nan), np.full(count, np.inf), np.arange(count)
    for _ in range(most_steps):
        some = [_chosen(v, going) for v in values]
        matrices, rates = flow.jacobian(x, some), flow.rhs(x, some)
        step = _newton_step(matrices, rates)
        x, size = x + step, np.abs(step)
        # Not by the first step, which has no bounds from a zero near a fold: all would be small beside it.
        scale = _replace_unknown(np.abs(start) + np.abs(x - start))
        solved = size <= LAST_STEP_RTOL * np.abs(x) + SCALE_ROUNDING * scale
        solved &= np.abs(rates) <= LAST_STEP_RTOL * _times(np.abs(matrices), np.fmax(np.abs(x), scale))
        zeros[:, going] = np.where(solved.all(axis=0), x, np.nan)
        relative = (size / np.fmax(np.abs(x), TINY)).max(axis=0)
        short = (size <= _rounding(x)).all(axis=0)
        moves = (size > MACHINE_EPSILON * np.abs(x)).any(axis=0)
        moves &= ~short | (relative < POLISH_CONTRACTION * before)
        if not moves.any():
            break
        x, before, going = x[:, moves], relative[moves], going[moves]
    return zeros


def _search(newton: Callable[[Array], Array], x: Array) -> Array:
    """Newton's method by the steps `newton(x)` from all starts, each until it has converged or left the range
    of floats."""
    x, going = x.copy(), np.arange(x.shape[1])
    for _ in range(SEARCH_STEPS):
        step = newton(x[:, going])
        x[:, going] += step
        going = going[
            (np.abs(step) > LAST_STEP_RTOL * np.abs(x[:, going])).any(axis=0) & np.isfinite(step).all(axis=0)
        ]
        if not going.size:
            break
    return x
