"""Where guards are negative: bounds of a mode's functions over pieces of a run, by interval arithmetic.

Nothing of the search for events is used: neither series of guards, nor their roots, nor the lengths of the
run's steps.  A piece is the polynomial of the states on an interval of time, by its Chebyshev coefficients.
One pass through the tape gives intervals of the values and of the rates of all functions on it
(:mod:`frictionlab.tape.intervals`).  Where these do not show that a guard stays positive, the piece is
halved.  So a function that changes fast against the step is resolved to any depth, and only where it may be
zero.  Source: R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, SIAM 2009,
chapters 6 and 8.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from frictionlab.hybrid.kernels.jets import MACHINE_EPSILON
from frictionlab.hybrid.problem import Problem, RunData
from frictionlab.tape import functions as kinds
from frictionlab.tape.formulas import ALONG_RUNS
from frictionlab.tape.intervals import Interval
from frictionlab.tape.panels import ROWS
from frictionlab.tape.program import Code, Numbers

Array = Any

STATES_AT_ONCE = 20_000  # at which values are computed
MOST_HALVINGS = 40
MOST_PIECES = 4096  # in doubt at once; with more, the guards on all of these count as positive
RESOLUTION = 0.1  # share of the largest rate up to which rates between points may be unknown
NOTHING = 1e-12  # share of a state's size: a smaller defect is not looked for
HIDDEN = 1e-11  # share of a state's size: what functions that change much on a piece may add unseen
SCALE = 1.0  # of a function: the most by which its argument may change on a piece
RATIO = 2.0  # of powers, quotients and logarithms: the largest ratio of the argument's ends on a piece
LEAST_SIZE = 1e-6  # of a state, as a share of the largest of its kind
POINTS = np.array([-1.0, 0.0, 1.0])  # of a piece, at which values are computed: its start, middle and end


class Tape:
    """A mode's operations at the parameters' values, evaluated on intervals."""

    def __init__(self, code: Code, numbers: Numbers, mode: int) -> None:
        first, last = (int(end) for end in code.mode_ops[mode : mode + 2])
        self._inputs = int(code.inputs)
        rows = code.ops[first:last].tolist()
        self._operations = [(*row, float(numbers.constants[first + i])) for i, row in enumerate(rows)]
        self._shared, columns = int(code.shared), code.term_slots[code.shared :]
        slots = np.concatenate([code.term_slots[: code.shared], np.repeat(columns, ROWS)])
        self._terms = list(zip(slots.tolist(), numbers.terms.tolist(), strict=True))
        self.guards = code.function_slots[code.mode_guards[mode] : code.mode_guards[mode + 1]].tolist()
        held = slice(code.mode_constraints[mode], code.mode_constraints[mode + 1])
        self.held = code.function_slots[held].tolist()
        self.flow = code.flow[mode].tolist()
        self.bases = sorted({row[1] for row in rows if row[0] == kinds.POWER})

    def sizes(self, states: Array, slots: Sequence[int] | None = None, least: Any = 0.0) -> Array:
        """The largest sums of absolute terms among states, of slots as in :meth:`values`: their sizes.

        `least` are the least sizes of the states, (states,).
        """
        with np.errstate(all="ignore"):
            terms = self.magnitudes(states, slots, least)
        return np.where(np.isfinite(terms), terms, 0.0).max(axis=0, initial=0.0)  # in other modes NaN

    def _between(self, a: int, b: int) -> list[tuple[int, float]]:
        """The terms of a sum that are not zero: of a row of a panel every ROWS-th."""
        return [term for term in self._terms[a : b : 1 if a < self._shared else ROWS] if term[1]]

    @property
    def functions(self) -> list[int]:
        """The slots of the guards, then those of the constraints."""
        return [*self.guards, *self.held]

    def slots(self, states: Sequence[Any]) -> list[Any]:
        """Values of all slots, where states are arrays; their ranges, where states are intervals."""
        known = list(states)
        for kind, a, b, constant in self._operations:
            if kind == kinds.AFFINE:
                known.append(self._sum(constant, self._between(a, b), known))
            elif kind in (kinds.PRODUCT, kinds.SQUARE):
                known.append(known[a] * known[b])
            elif kind == kinds.QUOTIENT:
                known.append(known[a] / known[b])
            elif kind == kinds.POWER:
                known.append(_power(known[a], constant))
            elif kind == kinds.RATE:  # belongs to the recurrence of the next operation
                known.append(known[a])
            else:
                known.append(ALONG_RUNS.functions[kind](known[a]))
        return known

    def rates(self, known: list[Interval], states: list[Interval]) -> list[Interval]:
        """Ranges of the rates of all slots, from those of the states and the ranges of the values."""
        rates = list(states)
        for out, (kind, a, b, constant) in enumerate(self._operations, start=self._inputs):
            if kind == kinds.AFFINE:
                rates.append(self._sum(0.0, self._between(a, b), rates))
            elif kind == kinds.PRODUCT:
                rates.append(rates[a] * known[b] + known[a] * rates[b])
            elif kind == kinds.SQUARE:
                rates.append(2.0 * (known[a] * rates[a]))
            elif kind == kinds.QUOTIENT:
                rates.append((rates[a] - known[out] * rates[b]) / known[b])
            elif kind == kinds.POWER:
                rates.append(constant * (_power(known[a], constant - 1.0) * rates[a]))
            elif kind == kinds.RATE:
                rates.append(rates[a])
            else:
                rates.append(known[b] * rates[a])
        return rates

    def hidden(self, known: list[Interval]) -> list[Array]:
        """For each slot how much of its value may be hidden between points at which values are computed.

        A function hides its whole range if its argument changes by more than the function's own scale.  Other
        operations pass on what their operands hide.  What is smooth on the piece hides nothing.
        """
        hidden: list[Array] = [0.0 * known[0].low] * self._inputs
        for out, (kind, a, b, constant) in enumerate(self._operations, start=self._inputs):
            if kind == kinds.AFFINE:
                terms = (abs(factor) * hidden[slot] for slot, factor in self._between(a, b))
                hidden.append(sum(terms, hidden[0]))
            elif kind == kinds.PRODUCT:
                hidden.append(_times(known[a], hidden[b]) + _times(known[b], hidden[a]))
            elif kind == kinds.SQUARE:
                hidden.append(2.0 * _times(known[a], hidden[a]))
            elif kind == kinds.QUOTIENT:
                part = _times(known[b].reciprocal(), hidden[a] + _times(known[out], hidden[b]))
                hidden.append(np.where(_spans_ratio(known[b]), known[out].width, part))
            elif kind == kinds.POWER:
                part = abs(constant) * _times(_power(known[a], constant - 1.0), hidden[a])
                hidden.append(np.where(_spans_ratio(known[a]), known[out].width, part))
            elif kind == kinds.RATE:
                hidden.append(hidden[a])
            else:
                wide = _spans_ratio(known[a]) if kind == kinds.LOG else known[a].width > SCALE
                hidden.append(np.where(wide, known[out].width, _times(known[b], hidden[a])))
        return hidden

    def values(self, states: Array, slots: Sequence[int] | None = None) -> Array:
        """Values (N, slots) at states (N, states), by default of guards and constraints."""
        return self._at_states(lambda part: self.slots(list(part.T)), states, slots)

    def magnitudes(self, states: Array, slots: Sequence[int] | None = None, least: Any = 0.0) -> Array:
        """Sums of the absolute terms (N, slots), as :meth:`values`."""
        return self._at_states(lambda part: self._sums(part, least), states, slots)

    def _at_states(
        self, evaluate: Callable[[Array], list[Array]], states: Array, slots: Sequence[int] | None
    ) -> Array:
        """Numbers of slots (N, slots), by a function of some states that gives those of all slots."""
        asked, columns = self.functions if slots is None else slots, []
        for part in np.array_split(states, max(1, -(-len(states) // STATES_AT_ONCE))):
            every = evaluate(part)
            columns.append(np.array([every[i] for i in asked]).reshape(len(asked), len(part)))
        return np.hstack(columns).T

    def _sums(self, states: Array, least: Any) -> list[Array]:
        """Sums of the absolute terms of all slots."""
        states = np.where(np.abs(states) < least, least, states)
        values, sums = self.slots(list(states.T)), list(np.abs(states).T)
        for out, (kind, a, b, constant) in enumerate(self._operations, start=self._inputs):
            if kind == kinds.AFFINE:
                terms = (abs(factor) * sums[slot] for slot, factor in self._between(a, b))
                sums.append(sum(terms, abs(constant) + 0.0 * sums[0]))
            elif kind in (kinds.PRODUCT, kinds.SQUARE):
                # Not the product of both sums, which grows with each factor of an angle that turns.
                one, other = np.abs(values[a]), np.abs(values[b])
                sums.append(one * sums[b] + (sums[a] - one) * other)
            elif kind == kinds.QUOTIENT:
                sums.append((sums[a] + sums[b] * np.abs(values[out])) / np.abs(values[b]))
            elif kind == kinds.POWER:
                sums.append(np.abs(values[out]) * (1.0 + np.abs(constant / values[a]) * sums[a]))
            elif kind == kinds.RATE:
                sums.append(sums[a])
            else:
                sums.append(np.abs(values[out]) + np.abs(values[b]) * sums[a])
        return sums

    @staticmethod
    def _sum(constant: float, terms: list[tuple[int, float]], known: list[Any]) -> Any:
        total: Any = constant
        for slot, factor in terms:
            total = known[slot] * factor + total
        return total if terms else known[0] * 0.0 + constant


def _power(base: Any, exponent: float) -> Any:
    return ALONG_RUNS.functions[kinds.POWER](base, exponent)


def _spans_ratio(values: Interval) -> Array:
    """Whether the ends differ in sign, or by more than the factor `RATIO`."""
    ends = np.abs(values.low), np.abs(values.high)
    return (np.maximum(*ends) > RATIO * np.minimum(*ends)) | (values.low * values.high < 0.0)


def _times(values: Interval, hidden: Array) -> Array:
    """What a product hides if one factor has these `values` and the other hides something."""
    return np.where(hidden > 0.0, values.magnitude * hidden, 0.0)


def condition_violation(problem: Problem, raw: RunData, states: Array, modes: Array) -> float:
    """Largest violation, at samples of a run, of a condition of their modes, as a share of its size.

    Event functions must not be negative, constraints must be zero.  The size of a condition is the largest
    sum of its absolute terms along the whole run, in all modes.  A flight's own samples would not do: where
    it begins the gap is all rounding, and a flight can be arbitrarily short.  Nor would the own size of a
    state that is all rounding, as the height of a body that slides on two feet: a share of the largest
    coordinate, or velocity, is the least.

    Parameters
    ----------
    problem, raw : Problem, RunData
    states : array (N, states)
        Samples of the run.
    modes : int array (N,)
        The mode of each sample.
    """
    worst, least = 0.0, np.abs(states).max(axis=0, initial=0.0)
    for first, last in pairwise(problem.program.code.groups):
        least[first:last] = LEAST_SIZE * least[first:last].max(initial=0.0)
    for mode in np.unique(modes):
        tape, samples = Tape(problem.program.code, problem.numbers, mode), states[modes == mode]
        sizes = tape.sizes(np.vstack([samples, raw.step_states]), least=least)
        sized, values = sizes > 0.0, tape.values(samples)
        values[:, len(tape.guards) :] = -np.abs(values[:, len(tape.guards) :])
        worst = max(worst, float((-values[:, sized] / sizes[sized]).max(initial=0.0)))
    return worst


class Pieces(NamedTuple):
    """Pieces of a run: where they begin, how long they are, and the states' Chebyshev coefficients."""

    starts: Array  # (pieces,)
    lengths: Array  # (pieces,)
    coefficients: Array  # (pieces, order + 1, states)

    def chosen(self, some: Array) -> Pieces:
        """Some of the pieces."""
        return Pieces(*(field[some] for field in self))

    def halves(self) -> Pieces:
        """The two halves of each, in the order of time."""
        basis = chebyshev_basis(self.coefficients.shape[1] - 1)
        both = np.stack([basis.left @ self.coefficients, basis.right @ self.coefficients], axis=1)
        half = np.repeat(0.5 * self.lengths, 2)
        starts = np.repeat(self.starts, 2) + np.where(np.arange(len(half)) % 2, half, 0.0)
        return Pieces(starts, half, both.reshape(len(half), *self.coefficients.shape[1:]))


class Basis(NamedTuple):
    """The Chebyshev polynomials up to an order, T_k(x) for -1 <= x <= 1."""

    nodes: Array
    fit: Array  # from values at the nodes to coefficients
    left: Array  # to the coefficients on the left half
    right: Array
    slope: Array  # to those of the derivative by x
    points: Array  # (3, order + 1): values at POINTS


@lru_cache(maxsize=16)
def chebyshev_basis(order: int) -> Basis:
    """The polynomials up to this order."""
    count = order + 1
    angles = np.pi * (np.arange(count) + 0.5) / count
    nodes, k = np.cos(angles), np.arange(count)
    fit = 2.0 / count * np.cos(np.outer(k, angles))
    fit[0] *= 0.5
    values = np.polynomial.chebyshev.chebvander
    slope = np.zeros((count, count))
    for j in range(1, count):
        column = np.polynomial.chebyshev.chebder(np.eye(count)[j])
        slope[: len(column), j] = column
    left, right = (fit @ values(0.5 * (nodes + side), order) for side in (-1.0, 1.0))
    return Basis(nodes, fit, left, right, slope, values(POINTS, order))


def pieces_of(starts: Array, lengths: Array, order: int, states: Callable[[Array], Array]) -> Pieces:
    """Pieces on which the states are polynomials of an order; `states` gives them at times (N,)."""
    basis = chebyshev_basis(order)
    times = starts[:, None] + 0.5 * lengths[:, None] * (1.0 + basis.nodes[::-1])
    values = states(times.ravel()).reshape(*times.shape, -1)[:, ::-1]
    return Pieces(starts, lengths, basis.fit @ values)


class Negative(NamedTuple):
    """Points at which functions are below their bounds."""

    times: Array
    functions: Array  # their numbers
    values: Array
    starts: Array  # of the pieces on which they are


def negative_points(tape: Tape, pieces: Pieces, bounds: Array) -> Negative:
    """Points at which guards are below `bounds` (functions,), or constraints farther from zero than that.

    The first point is on the first piece that has one, unless so many pieces are in doubt that some are left
    out.
    """
    points, guards, until = [], len(tape.guards), np.inf
    with np.errstate(all="ignore"):
        for _ in range(MOST_HALVINGS):
            values, doubtful = _judge(tape, pieces, bounds)
            bad = values < bounds
            bad[..., guards:] = ~(np.abs(values[..., guards:]) <= -bounds[guards:])
            piece, point, function = np.nonzero(bad)
            times = pieces.starts[piece] + 0.5 * (1.0 + POINTS[point]) * pieces.lengths[piece]
            points.append((times, function, values[piece, point, function], pieces.starts[piece]))
            until = min(until, times.min(initial=np.inf))
            doubtful &= (pieces.starts < until) & (pieces.lengths > 0.0)
            if not 0 < doubtful.sum() <= MOST_PIECES:
                break
            pieces = pieces.chosen(doubtful).halves()
    return Negative(*(np.concatenate(parts) for parts in zip(*points, strict=True)))


class Defect(NamedTuple):
    """The largest |x' - f(x)| times the length of a piece, as a share of a state's size."""

    share: float
    time: float
    state: int


def largest_defect(tape: Tape, pieces: Pieces, sizes: Array) -> Defect:
    """The largest defect of pieces as motions of a mode; layers that are narrow against a piece are resolved.

    Pieces are halved until two things hold.  The rates at three points tell the rates on the whole piece, up
    to a share of the largest.  No function that changes much on the piece, as the layer of a law, adds
    anything.
    """
    worst, largest = Defect(0.0, np.nan, 0), np.zeros(len(sizes))
    with np.errstate(all="ignore"):
        for _ in range(MOST_HALVINGS):
            flow, slopes, reach, hidden = _flow(tape, pieces)
            missed = np.abs(slopes - flow) * pieces.lengths[:, None, None]
            defects = np.fmax(missed - _slope_rounding(pieces)[:, None], 0.0) / sizes
            defects = np.where(np.isnan(defects), 0.0, defects)
            if (most := float(defects.max(initial=0.0))) > worst.share:
                piece, point, state = np.unravel_index(int(defects.argmax()), defects.shape)
                time = pieces.starts[piece] + 0.5 * (1.0 + POINTS[point]) * pieces.lengths[piece]
                worst = Defect(most, float(time), int(state))
            finite = np.where(np.isfinite(flow), np.abs(flow), 0.0)
            largest = np.maximum(largest, finite.max(axis=(0, 1), initial=0.0))
            beyond = np.fmax(reach.high - flow.max(axis=1), flow.min(axis=1) - reach.low)
            lengths = pieces.lengths[:, None]
            doubtful = (beyond > RESOLUTION * largest) & (beyond * lengths > NOTHING * sizes)
            doubtful |= hidden * lengths > HIDDEN * sizes
            if not 0 < doubtful.any(axis=1).sum() <= MOST_PIECES:
                break
            pieces = pieces.chosen(doubtful.any(axis=1)).halves()
    return worst


def _slope_rounding(pieces: Pieces) -> Array:
    """How far rounding of the states spoils slopes of the polynomials, times the length (pieces, states).

    Coefficient k amplifies it k^2 times.  It counts where a motion is small beside its states.
    """
    order = pieces.coefficients.shape[1] - 1
    return 2.0 * MACHINE_EPSILON * order**3 * np.abs(pieces.coefficients).max(axis=1)


def _flow(tape: Tape, pieces: Pieces) -> tuple[Array, Array, Interval, Array]:
    """Rates (pieces, 3, states) at POINTS, by the tape and of the polynomials.

    Also the ranges (pieces, states) of the rates by the tape, and what they hide between the points.
    """
    basis, count = chebyshev_basis(pieces.coefficients.shape[1] - 1), len(pieces.starts)
    points, known = _known_slots(tape, pieces, tape.flow)
    flow, by_x = points.reshape(count, 3, -1), basis.slope @ pieces.coefficients
    slopes = basis.points @ by_x * (2.0 / pieces.lengths)[:, None, None]
    rates = tape.rates(known, _ranges(by_x))
    low, high = [], []
    for state, slot in enumerate(tape.flow):
        steepest = rates[slot].magnitude
        low.append(np.fmax(known[slot].low, flow[:, 1, state] - steepest))
        high.append(np.fmin(known[slot].high, flow[:, 1, state] + steepest))
    hidden = tape.hidden(known)
    reach = Interval(np.array(low).T, np.array(high).T)
    return flow, slopes, reach, np.array([hidden[i] for i in tape.flow]).T


def _judge(tape: Tape, pieces: Pieces, bounds: Array) -> tuple[Array, Array]:
    """Values (pieces, 3, functions) at POINTS, and whether guards may be below their bounds in between."""
    basis = chebyshev_basis(pieces.coefficients.shape[1] - 1)
    functions, guards = tape.functions, len(tape.guards)
    points, known = _known_slots(tape, pieces, functions)
    values = points.reshape(len(pieces.starts), 3, len(functions))
    slopes = basis.slope @ pieces.coefficients
    rates = tape.rates(known, _ranges(slopes))
    doubtful = np.zeros(len(pieces.starts), dtype=bool)
    for g, slot in enumerate(functions[:guards]):
        steepest = rates[slot].magnitude  # by x, from -1 to 1
        least = np.fmax(known[slot].low, values[:, 1, g] - steepest)
        least = np.where(np.isnan(values[:, :, g]).any(axis=1), np.inf, least)  # no number, as sqrt(gap)
        one_way = (rates[slot].low >= 0.0) | (rates[slot].high <= 0.0)
        doubtful |= (least < bounds[g]) & ~one_way
    return values, doubtful


def _known_slots(tape: Tape, pieces: Pieces, slots: list[int]) -> tuple[Array, list[Interval]]:
    """Values of slots (3 pieces, slots) at POINTS, and the ranges of all slots on the pieces."""
    basis = chebyshev_basis(pieces.coefficients.shape[1] - 1)
    at = (basis.points @ pieces.coefficients).reshape(-1, pieces.coefficients.shape[2])
    return tape.values(at, slots), tape.slots(_ranges(pieces.coefficients))


def _ranges(coefficients: Array) -> list[Interval]:
    """Ranges of polynomials (pieces, order + 1, states), for each state."""
    middle, reach = coefficients[:, 0], np.abs(coefficients[:, 1:]).sum(axis=1)
    return [Interval(low, high) for low, high in zip((middle - reach).T, (middle + reach).T, strict=True)]
