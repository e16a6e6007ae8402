"""Boxes that hold all zeros of a flow: bisection of the whole space by bounds of the flow in each box.

First states are eliminated.  Linear rows, such as q' = v, give some states by the others.  So do sums of rows
in which all that is nonlinear cancels.  Of the remaining states those that enter linearly are eliminated too.
So k equations are left in the k states that enter nonlinearly, one for each coordinate with a spring or law
of its own.

Then boxes are bisected in decades, from 1e-30 to 1e30, whatever the units; of an angle, on which all depends
with the period 2 pi, one turn is enough.  A box is left out if the bounds
of an equation in it do not hold zero.  Krawczyk's operator says that a box holds one zero only, or none.  R.
Krawczyk, Computing 4 (1969) 187-201.

Where an equation jumps it is bounded for each way in which its steps may turn out.  So a box is left out if
the equation jumps past zero in it.  A zero exactly on a jump counts, and is looked for among floats.

What the search says is proved up to the rounding of the elimination.  If the budget of boxes is used up, or a
function has no bounds, it says that it does not know.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionlab.stability.flow import Flow
from frictionlab.tape.intervals import Interval, interval

Array = NDArray[np.float64]
LARGEST, SMALLEST = 1e30, 1e-30  # sizes of states that are searched; smaller ones count as zero
ONE_TURN = -3.3, 2 * np.pi - 3.3  # rad: its ends are no likely equilibria, as -pi and pi are
PERIODIC_RTOL = 1e-9  # share of its terms by which a function may differ after a turn
MOST_UNKNOWNS = 4  # with more the boxes that come near to zeros are too many
MOST_BOXES = 12_000  # divided by the number of unknowns
LATE = 0.05  # decades: unknowns that equations give by the others are bisected once these are as narrow
FEW_BOXES = 64  # of one unknown are cut in two at once as often as possible: bounds of many cost as much
FINEST = 2.0**-30  # share of a state below which boxes are not bisected
ROUNDED = 1e-5  # the same if the equations are zero up to rounding in the middle of the box
CONTRACTIONS, SHRINKING = 32, 0.9  # of a box that holds one zero, as long as it shrinks to this share
ROUNDING_FACTOR = 16.0  # times the bounds at a point: in a box no wider than that all is rounding
SAMPLES = 24  # states that show what is nonlinear in the rows
EDGE = 0.1  # share of a box by which it is enlarged to show that it holds one zero
POLE_PARTS = 64  # parts of a box without bounds: next to a pole some ten floats are
TOUCHING = 64  # clusters that a box is compared with
PIVOT_RTOL = 1e-10  # share of a row or a column: what is smaller is rounding
SCALINGS = 20  # rounds of geometric means: they converge by a factor of two or more each


class Elimination(NamedTuple):
    """How states are eliminated.

    Linear rows leave the unknowns u; the states are x = origin + basis u.  Of these unknowns those that enter
    linearly are eliminated too.

    Parameters
    ----------
    origin, basis : array (m,), (m, p)
    rows : int array (r,)
        The rows of the flow that are not linear.
    nonlinear : int array (k,)
        Which of the unknowns u enter nonlinearly.
    combined : array (k, r)
        Sums of the rows that hold these alone.
    columns : array (r, p - k)
        Coefficients of the others.
    """

    origin: Array
    basis: Array
    rows: NDArray[np.intp]
    nonlinear: NDArray[np.intp]
    combined: Array
    columns: Array

    @property
    def unknowns(self) -> list[int]:
        """The states (k,) that the nonlinear unknowns are."""
        rows = np.abs(self.basis).sum(axis=1) == 1
        return [int(np.flatnonzero(rows & (self.basis[:, k] == 1))[0]) for k in self.nonlinear]


@dataclass(frozen=True, eq=False)
class RootBoxes:
    """What is known of where zeros are.

    Parameters
    ----------
    starts : array (m, N)
        A state in each box, or cluster of boxes, that may hold a zero.
    room : array (m, N)
        How far from that state a zero in the box may be; infinite for states that depend on others.
    flat : bool array (N,)
        Whether the start is a zero at which the one equation changes its sign with zero slope.
    on_jump : bool array (N,)
        Whether the start is a zero at which an equation jumps.
    why : str
        Why there may be zeros outside these boxes; empty where it is known that there are none.
    """

    starts: Array
    room: Array
    flat: NDArray[np.bool_]
    on_jump: NDArray[np.bool_]
    why: str = ""


def angles_of(flow: Flow, values: Sequence[float]) -> tuple[int, ...]:
    """The states on which all depends with the period 2 pi, as on the angle of a rod."""
    if flow.linear:
        return ()
    random = np.random.default_rng(0)
    x = random.uniform(-10.0, 10.0, size=(flow.size, SAMPLES))
    with np.errstate(all="ignore"):
        before, slopes = _with_margins(flow, x, values), np.abs(flow.jacobian(x, values))
        size = np.zeros_like(before)
        size[: flow.size] = (slopes @ np.abs(x).T[:, :, None])[:, :, 0].T
        return tuple(i for i in flow.nonlinear if _is_periodic(flow, x, values, i, before, size))


def _is_periodic(flow: Flow, x: Array, values: Sequence[float], i: int, before: Array, size: Array) -> bool:
    """Whether rates and margins are the same at states (m, N) whose state `i` is greater by 2 pi."""
    turned = x.copy()
    turned[i] += 2 * np.pi
    after = _with_margins(flow, turned, values)
    same = np.abs(after - before) <= PERIODIC_RTOL * (size + np.abs(before) + np.abs(after))
    undefined = np.isnan(before) & np.isnan(after)
    return bool((same | undefined).all() and same.any())


def _with_margins(flow: Flow, x: Array, values: Sequence[float]) -> Array:
    margins = [np.broadcast_to(one, x.shape[1]) for one in flow.margins.arrays(*x, *values)]
    return np.vstack([flow.rhs(x, values), *margins])


def root_boxes(flow: Flow, values: Sequence[float], angles: tuple[int, ...]) -> RootBoxes:
    """Boxes that hold the zeros of a flow; of `angles` within one turn."""
    none, never = np.zeros((flow.size, 0)), np.zeros(0, dtype=bool)
    nowhere = RootBoxes(none, none, never, never)
    try:
        with np.errstate(all="ignore"):
            reduced = _eliminate(flow, values)
            if reduced is None:
                return nowhere
            if isinstance(reduced, str):
                return replace(nowhere, why=reduced)
            return _search(ReducedFlow(flow, values, reduced, angles))
    except TypeError:  # a power of a negative number, whose exponent varies
        return replace(nowhere, why="a function has no bounds")


# --- elimination


def _eliminate(flow: Flow, values: Sequence[float]) -> Elimination | str | None:
    """The elimination; None if linear rows contradict each other, so that there is no zero; a text that says
    why nothing is known."""
    m, origin = flow.size, np.zeros(flow.size)
    entries = flow.slopes(_whole(m, np.inf), values)
    constant = {place: _constant(entry) for place, entry in entries.items()}
    rows = np.array([None not in [c for (r, _), c in constant.items() if r == i] for i in range(m)])
    matrix = np.zeros((m, m))
    for (i, j), entry in constant.items():
        matrix[i, j] = 0.0 if entry is None else entry
    rates = flow.rhs(origin, values)
    if not np.isfinite(rates[rows]).all():
        return "linear rates are not finite"
    solution = _solve_rows(matrix[rows], -rates[rows])
    if solution is None:
        return None
    held: Any = np.all(solution[1] == 0.0, axis=1)
    if flow.rates.jumps(*map(_rounded, solution[0], held), *values):
        return "rounding decides on which side of a jump the linear rates hold a state"
    nonlinear = np.flatnonzero(~rows)
    sums, nonlinear = _linear_sums(flow, values, nonlinear, held)
    if len(sums):
        with_sums = np.vstack([matrix[rows], _sums_of_rows(sums, flow.jacobian(origin, values))])
        solution = _solve_rows(with_sums, -np.append(rates[rows], _sums_of_rows(sums, rates)))
        if solution is None:
            return None
    origin, basis = solution
    unknowns = basis.shape[1]
    # Linear rows may have made columns of the others constant.
    there = [interval(state) if unknowns else state for state in _combined(origin, basis, _whole(unknowns))]
    entries = flow.slopes(there, values)
    columns = [[_column(entries, i, basis[:, k]) for k in range(unknowns)] for i in nonlinear]
    linear = np.array([all(_constant(row[k]) is not None for row in columns) for k in range(unknowns)], bool)
    coefficients = np.array([[_constant(row[k]) for k in np.flatnonzero(linear)] for row in columns], float)
    coefficients = coefficients.reshape(len(nonlinear), int(linear.sum()))
    combined, _ = _rows_without(coefficients)
    elimination = Elimination(origin, basis, nonlinear, np.flatnonzero(~linear), combined, coefficients)
    everywhere = ReducedFlow(flow, values, elimination).rates(_whole(int((~linear).sum())))
    if not all(np.all(row.contains_zero()) for row in everywhere):
        return None
    if len(combined) != len(elimination.nonlinear):
        return "states may be anywhere"
    if len(elimination.nonlinear) > MOST_UNKNOWNS:
        return f"{len(elimination.nonlinear)} states enter nonlinearly"
    return elimination


def _rounded(state: float, held: bool) -> Any:
    """A state that linear rows hold, up to rounding; zero is exact, as for velocities."""
    return Interval(*np.sort(state * (1 + PIVOT_RTOL * np.array([-1.0, 1.0])))) if held and state else state


def _linear_sums(
    flow: Flow, values: Sequence[float], nonlinear: NDArray[np.intp], held: NDArray[np.bool_]
) -> tuple[Array, NDArray[np.intp]]:
    """Sums (s, m) of rows in which all that is nonlinear cancels, and the rows that are left.

    Rows that jump where states are not held are no part of them: derivatives do not tell of jumps.
    """
    none, free = np.zeros((0, flow.size)), {*np.flatnonzero(~held)}
    rows = np.array([i for i in nonlinear if not free & flow.rates.step_dependences[i]], dtype=np.intp)
    if len(rows) < 2:
        return none, nonlinear
    random = np.random.default_rng(0)
    sizes = 10.0 ** random.uniform(-2, 2, size=(flow.size, SAMPLES))
    at = sizes * random.choice([-1.0, 1.0], size=sizes.shape)
    change = np.diff(flow.jacobian(at, values)[:, rows], axis=0)
    change = change[np.isfinite(change).all(axis=(1, 2))]
    if len(change) < SAMPLES // 2:  # a function is defined on one side only, or overflows
        return none, nonlinear
    columns = change.transpose(1, 0, 2).reshape(len(rows), -1)
    size = np.abs(columns).max(axis=0)
    cancelled, pivots = _rows_without(columns[:, size > 0] / size[size > 0])
    sums = np.zeros((len(cancelled), flow.size))
    sums[:, rows] = cancelled
    return sums, np.setdiff1d(nonlinear, rows[~pivots])


def _sums_of_rows(sums: Array, rows: Array) -> Array:
    """Sums (s, m) of rows (m, ...); what but rounding leaves where the terms cancel is zero."""
    total = sums @ rows
    return np.where(np.abs(total) <= PIVOT_RTOL * (np.abs(sums) @ np.abs(rows)), 0.0, total)


def _whole(count: int, size: float = LARGEST) -> list[Interval]:
    """All values of some states; each is an interval of its own, as one times itself is a square."""
    return [Interval(np.full(1, -size), np.full(1, size)) for _ in range(count)]


def _constant(entry: Any) -> float | None:
    """The number that an entry is; None if it is not the same everywhere."""
    if not isinstance(entry, Interval):
        return float(np.ravel(entry)[0])
    low, high = float(np.min(entry.low)), float(np.max(entry.high))
    size = max(abs(low), abs(high))
    return (low + high) / 2 if np.isfinite(size) and high - low <= PIVOT_RTOL * size else None


def _column(entries: dict[tuple[int, int], Any], row: int, direction: Array) -> Any:
    total: Any = 0.0
    for j in np.flatnonzero(direction):
        if (row, int(j)) in entries:
            total = total + entries[row, int(j)] * float(direction[j])
    return total


def _combined(origin: Array, basis: Array, u: Sequence[Any]) -> list[Any]:
    """The states origin + basis u, where unknowns are numbers or intervals; most are one of the unknowns."""
    states = []
    for start, row in zip(origin.tolist(), basis, strict=True):
        places = np.flatnonzero(row).tolist()
        if len(places) == 1 and row[places[0]] == 1.0 and start == 0.0:
            states.append(u[places[0]])
            continue
        total: Any = start
        for k in places:
            total = u[k] * float(row[k]) + total
        states.append(total)
    return states


def _solve_rows(matrix: Array, right: Array) -> tuple[Array, Array] | None:
    """All solutions x = origin + basis u of linear equations, by elimination with pivots; None if there is
    none."""
    m = matrix.shape[1]
    filled = matrix.any(axis=1)
    if right[~filled].any():
        return None
    rows, units = _scales(matrix[filled])
    a = np.hstack([matrix[filled] / rows[:, None] / units, (right[filled] / rows)[:, None]])
    size = np.abs(a[:, m])  # what the right sides are sums of, to tell rounding
    pivots: list[int] = []
    row = 0
    while row < len(a):
        i, j = np.unravel_index(np.argmax(np.abs(a[row:, :m])), (len(a) - row, m))
        i += row
        if abs(a[i, j]) <= PIVOT_RTOL:
            break
        a[[row, i]], size[[row, i]] = a[[i, row]], size[[i, row]]
        size[row] /= abs(a[row, j])
        a[row] /= a[row, j]
        others = np.arange(len(a)) != row
        size[others] += np.abs(a[others, j]) * size[row]
        a[others] -= a[others, j][:, None] * a[row]
        a[others, j] = 0.0
        pivots.append(int(j))
        row += 1
    if (np.abs(a[row:, m]) > PIVOT_RTOL * size[row:]).any():
        return None
    free = [j for j in range(m) if j not in pivots]
    origin, basis = np.zeros(m), np.zeros((m, len(free)))
    origin[pivots] = a[:row, m]
    basis[pivots] = -a[:row][:, free]
    basis[free, range(len(free))] = 1.0
    basis[np.abs(basis) <= PIVOT_RTOL] = 0.0
    return origin / units + 0.0, basis * (units[free] / units[:, None])


def _scales(matrix: Array) -> tuple[Array, Array]:
    """Powers of two of rows (r,) and columns (m,) by which to divide: entries are near 1, whatever the units.

    Geometric means of rows and columns in turns, then the largest entry of each row.  So a stiffness per mass
    of 1e-24/s^2 is not lost beside a damping of 1e-14/s.
    """
    there = matrix != 0.0
    sizes = np.log2(np.abs(matrix), where=there, out=np.zeros(matrix.shape))
    rows, columns = np.zeros(len(matrix)), np.zeros(matrix.shape[1])
    counts = [np.maximum(there.sum(axis=axis), 1) for axis in (0, 1)]
    for _ in range(SCALINGS):
        rows = (there * (sizes - columns)).sum(axis=1) / counts[1]
        columns = (there * (sizes - rows[:, None])).sum(axis=0) / counts[0]
    columns = np.round(columns)
    rows = np.ceil(np.where(there, sizes - columns, -np.inf).max(axis=1, initial=-np.inf))
    return np.exp2(rows), np.exp2(columns)


def _rows_without(columns: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Sums (k, r) of r rows in which these columns (r, c) cancel, and which rows were used as pivots."""
    r, c = columns.shape
    rows = np.abs(columns).max(axis=1, initial=0.0)
    scale = np.where(rows > 0, rows, 1.0)
    a, sums, pivots = columns / scale[:, None], np.eye(r), np.zeros(r, dtype=bool)
    for _ in range(min(r, c)):
        i, j = np.unravel_index(np.argmax(np.where(pivots[:, None], 0.0, np.abs(a))), a.shape)
        if pivots[i] or abs(a[i, j]) <= PIVOT_RTOL:
            break
        pivots[i] = True
        factor = np.where(pivots, 0.0, a[:, j] / a[i, j])
        a, sums = a - factor[:, None] * a[i], sums - factor[:, None] * sums[i]
        a[:, j] = 0.0
    sums[np.abs(sums) <= PIVOT_RTOL] = 0.0
    return (sums / scale)[~pivots], pivots


def values_of(owners: Any, values: Sequence[Any]) -> list[Any]:
    """The parameters' values of each owner: of those that are arrays the owner's, of others the one."""
    return [value if np.ndim(value) == 0 else np.asarray(value)[owners] for value in values]


def one_equation(flow: Flow, values: Sequence[Any]) -> ReducedFlow:
    """A flow of one state, which needs no elimination; values of parameters may be arrays."""
    one, none = np.ones((1, 1)), np.zeros(1, dtype=np.intp)
    return ReducedFlow(flow, values, Elimination(np.zeros(1), one, none, none, one, np.zeros((1, 0))))


# --- bisection


@dataclass(frozen=True, eq=False)
class ReducedFlow:
    """The k equations in the k states that enter nonlinearly.

    Parameters
    ----------
    flow : Flow
    values : sequence of float or array
        Of the parameters; arrays have a value for each owner of boxes.
    by : Elimination
    angles : tuple of int
        States whose size is one turn, whatever their decade.
    """

    flow: Flow
    values: Sequence[Any]
    by: Elimination
    angles: tuple[int, ...] = ()

    @property
    def unknowns(self) -> list[int]:
        """The states that the unknowns are."""
        return self.by.unknowns

    @property
    def turning(self) -> NDArray[np.bool_]:
        """Which of the unknowns are angles (k,)."""
        return np.array([i in self.angles for i in self.unknowns], dtype=bool)

    @property
    def proportional(self) -> NDArray[np.bool_]:
        """Which of several unknowns have slopes that do not depend on themselves, as reactions have (k,)."""
        if len(self.unknowns) < 2:
            return np.zeros(len(self.unknowns), dtype=bool)
        entries = self.flow.derivative
        pairs = [*zip(entries.places, entries.formulas.dependences, strict=True)]
        bent = {j for (_, j), inputs in pairs if j in inputs} | {*self.flow.stepped}
        return np.array([i not in bent for i in self.unknowns], dtype=bool)

    def steps(self, w: float) -> list[float]:
        """The values of all steps at a value of the one unknown."""
        return list(map(float, self.flow.rates.steps(*self._states([w]), *self.values)))

    def of(self, owners: NDArray[np.intp]) -> ReducedFlow:
        """The flow for boxes of these owners: of each parameter a box has its owner's value."""
        if all(np.ndim(value) == 0 for value in self.values):
            return self
        return replace(self, values=values_of(owners, self.values))

    def _states(self, w: Sequence[Any]) -> list[Any]:
        return _combined(self.by.origin, self.by.basis[:, self.by.nonlinear], w)

    def _sums(self, rows: Sequence[Any]) -> list[Interval]:
        totals = []
        for weights in self.by.combined:
            total: Any = 0.0
            for i in np.flatnonzero(weights).tolist():
                total = total + (rows[i] if weights[i] == 1.0 else rows[i] * float(weights[i]))
            totals.append(interval(total))
        return totals

    def rates(self, w: Sequence[Any]) -> list[Interval]:
        """The equations (k,)."""
        every = self.flow.rates.arrays(*self._states(w), *self.values)
        return self._sums([every[i] for i in self.by.rows])

    def branches(self, w: Sequence[Interval]) -> Iterator[list[Interval]]:
        """The equations for each way in which steps may turn out that are open in the boxes."""
        for every in self.flow.rates.branches(*self._states(w), *self.values):
            yield self._sums([every[i] for i in self.by.rows])

    def may_vanish(self, w: Sequence[Interval], count: int) -> NDArray[np.bool_]:
        """In which of `count` boxes the equations may have a zero."""
        return np.any([_vanishes(rows, count) for rows in self.branches(w)], axis=0)

    def jumps(self, w: Sequence[Interval], count: int) -> NDArray[np.bool_]:
        """In which of `count` boxes an equation may jump."""
        places = self.flow.rates.jumps(*self._states(w), *self.values)
        own = [where for (row, _), where in places.items() if row in self.by.rows]
        return np.any([np.broadcast_to(where, count) for where in [False, *own]], axis=0)

    def jacobian(self, w: Sequence[Interval]) -> list[list[Interval]]:
        """Their derivatives: for each of the states the k equations."""
        entries = self.flow.slopes(self._states(w), self.values)
        columns = (self.by.basis[:, k] for k in self.by.nonlinear)
        return [self._sums([_column(entries, i, column) for i in self.by.rows]) for column in columns]

    def full_states(self, w: Array) -> Array:
        """States (m, N) of the flow at unknowns (k, N)."""
        u = np.zeros((self.by.basis.shape[1], w.shape[1]))
        u[self.by.nonlinear] = w
        x = self.by.origin[:, None] + self.by.basis @ u
        others = np.setdiff1d(np.arange(len(u)), self.by.nonlinear)
        if len(others):
            scale = np.abs(self.by.columns).max(axis=1, keepdims=True)
            scale[scale == 0] = 1.0
            rest = self.flow.rhs(x, self.values)[self.by.rows] / scale
            u[others] = -np.linalg.lstsq(self.by.columns / scale, rest)[0]
            x = self.by.origin[:, None] + self.by.basis @ u
        return x


class Boxes(NamedTuple):
    """Boxes of the unknowns, and whose they are.

    Parameters
    ----------
    ends : array (2, k, N)
    owners : int array (N,)
        Which of several values of the parameters each belongs to.
    """

    ends: Array
    owners: NDArray[np.intp]

    def take(self, index: Any) -> Boxes:
        """Some of the boxes."""
        return Boxes(self.ends[:, :, index], self.owners[index])


def _joined(parts: Sequence[Boxes]) -> Boxes:
    return Boxes(
        np.concatenate([part.ends for part in parts], axis=2),
        np.concatenate([part.owners for part in parts]),
    )


class Isolation(NamedTuple):
    """What bisection gives: boxes with one zero each, narrow ones that may hold zeros, and undecided ones.

    Parameters
    ----------
    single, narrow, undecided : Boxes
    spent : int
        How many boxes were bounded.
    settled_at : array (count,)
        Of each owner the upper end of the box that settles its search; infinite if all zeros are looked for.
    """

    single: Boxes
    narrow: Boxes
    undecided: Boxes
    spent: int
    settled_at: Array


def isolate_zeros(
    reduced: ReducedFlow, boxes: Boxes, settles: Callable[[Boxes], NDArray[np.bool_]] | None = None
) -> Isolation:
    """Bisection of boxes until each holds one zero, or none, or is too narrow to tell.

    Of one unknown the least zero of a kind may be enough.  `settles` says which boxes with one zero hold one
    of that kind; above such a box no other is looked for.
    """
    single, narrow, undecided = [boxes.take([])], [boxes.take([])], [boxes.take([])]
    most, count = MOST_BOXES // max(len(reduced.unknowns), 1), 1 + boxes.owners.max(initial=0)
    spent, settled_at = np.zeros(count, dtype=np.intp), np.full(count, np.inf)
    turning, proportional = reduced.turning, reduced.proportional
    while len(boxes.owners):
        spent += np.bincount(boxes.owners, minlength=count)
        boxes, one = _prune(reduced, boxes)
        single.append(one)
        if settles is not None and len(one.owners):
            enough = one.take(settles(one))
            np.minimum.at(settled_at, enough.owners, enough.ends[1, 0])
        boxes = _below(boxes, settled_at)
        width = _widths(*boxes.ends, turning)
        width[proportional] = np.minimum(width[proportional], LATE)
        fine = width.max(axis=0, initial=0.0) <= _finest(reduced.of(boxes.owners), *boxes.ends)
        narrow.append(boxes.take(fine))
        late = ~fine & (spent[boxes.owners] >= most)
        undecided.append(boxes.take(late))
        going = ~fine & ~late
        boxes = _halves(boxes.take(going), turning, width[:, going])
        while len(reduced.unknowns) == 1 and 0 < len(boxes.owners) <= FEW_BOXES:
            boxes = _halves(boxes, turning)
    few, doubtful = (_below(_joined(parts), settled_at) for parts in (narrow, undecided))
    if len(reduced.unknowns) == 1 and len(few.owners):
        few = few.take(~_only_poles(reduced, few))
    return Isolation(_joined(single), few, doubtful, int(spent.sum()), settled_at)


def _below(boxes: Boxes, settled_at: Array) -> Boxes:
    """The boxes in which zeros are still looked for."""
    going = np.isinf(settled_at[boxes.owners])
    return boxes if going.all() else boxes.take(going | (boxes.ends[0, 0] < settled_at[boxes.owners]))


def _only_poles(reduced: ReducedFlow, boxes: Boxes) -> NDArray[np.bool_]:
    """Which narrow boxes hold a pole of the one equation, and no zero.

    Where the equation has bounds, no zero is within them.  Along the floats at which it has none, it grows
    towards one of them, beyond what it is at the ends of the box, and then becomes smaller again.  Beside a
    zero it would not, unless no more than a few floats lie between zero and pole: for these it is the pole.
    """

    def size(which: NDArray[np.intp], at: Array) -> Array:
        return np.abs(np.broadcast_to(reduced.of(boxes.owners[which]).rates([at])[0].low, at.shape))

    every = np.arange(len(boxes.owners))
    at_low, at_high = (size(every, end) for end in boxes.ends[:, 0])
    at_ends = np.fmax(*(np.where(np.isinf(one), np.nan, one) for one in (at_low, at_high)))
    poles, rest = _without_bounds(reduced, boxes)
    owners, at = np.tile(rest.owners, 2), rest.ends[:, 0].ravel()
    sizes = size(owners, at)
    for i in np.flatnonzero(poles):
        runs = _runs_of_floats(at[owners == i], sizes[owners == i])
        poles[i] = all((run > at_ends[i]).all() and _has_one_peak(run) for run in runs)
    return poles


def _without_bounds(reduced: ReducedFlow, boxes: Boxes) -> tuple[NDArray[np.bool_], Boxes]:
    """In which boxes bounds exclude a zero wherever there are any, and between which neighbouring floats of
    each of them there are none.  Owners of these are the boxes."""
    possible = np.abs(boxes.ends).max(axis=(0, 1)) > SMALLEST  # smaller states count as zero
    count = len(possible)
    parts, undecided = Boxes(boxes.ends, np.arange(count)).take(possible), [boxes.take([])]
    while len(parts.owners):
        row = reduced.of(boxes.owners[parts.owners]).rates(_intervals(parts.ends))[0]
        finite = np.broadcast_to(np.isfinite(row.low) & np.isfinite(row.high), parts.owners.shape)
        possible[parts.owners[finite & row.contains_zero()]] = False
        parts = parts.take(~finite)
        possible[np.bincount(parts.owners, minlength=count) > POLE_PARTS] = False
        parts = parts.take(possible[parts.owners])
        low, high = parts.ends[:, 0]
        middle = low + (high - low) / 2
        last = (middle <= low) | (middle >= high)
        undecided.append(parts.take(last))
        halves = [np.stack(two)[:, None] for two in ((low, middle), (middle, high))]
        parts = _joined([Boxes(half, parts.owners).take(~last) for half in halves])
    return possible, _joined(undecided)


def _runs_of_floats(x: Array, sizes: Array) -> list[Array]:
    """The sizes at floats in ascending order, floats that are neighbours together."""
    x, first = np.unique(x, return_index=True)
    return np.split(sizes[first], np.flatnonzero(x[1:] > np.nextafter(x[:-1], np.inf)) + 1)


def _has_one_peak(sizes: Array) -> bool:
    """Whether numbers do not fall before the largest, nor rise after it."""
    peak = int(sizes.argmax()) if len(sizes) else 0
    before, after = sizes[: peak + 1], sizes[peak:]
    return bool((before[1:] >= before[:-1]).all() and (after[1:] <= after[:-1]).all())


def _search(reduced: ReducedFlow) -> RootBoxes:
    k = len(reduced.unknowns)
    if not k:  # linear, and no rate contradicts
        start = reduced.full_states(np.zeros((0, 1)))
        neither = np.zeros(1, dtype=bool)
        return RootBoxes(start, np.full(start.shape, np.inf), neither, neither)
    ends = [ONE_TURN if turns else (-LARGEST, LARGEST) for turns in reduced.turning]
    everywhere = np.array(ends).T[:, :, None]
    search = isolate_zeros(reduced, Boxes(everywhere, np.zeros(1, dtype=np.intp)))
    clusters = _clusters(search.narrow.ends)
    every = np.concatenate([_contracted(reduced, search.single.ends), clusters], axis=2)
    middle = every.mean(axis=0)
    starts = reduced.full_states(np.where(np.abs(middle) > SMALLEST, middle, 0.0))
    room = np.full(starts.shape, np.inf)
    room[list(reduced.unknowns)] = every[1] - every[0]
    flat, on_jump = np.zeros((2, starts.shape[1]), dtype=bool)
    first = starts.shape[1] - clusters.shape[2]
    jumping = np.flatnonzero(reduced.jumps(_intervals(clusters), clusters.shape[2]))
    for i in first + jumping:
        zero = _zero_on_jump(reduced, every[:, :, i])
        if zero is not None:
            on_jump[i], starts[:, i] = True, reduced.full_states(zero[:, None])[:, 0]
    smooth = np.setdiff1d(np.arange(first, len(flat)), first + jumping)
    if k == 1 and len(smooth):
        _bracket(reduced, every, smooth, starts, flat)
    count, doubtful = len(search.undecided.owners), starts[:, first + jumping][:, ~on_jump[first + jumping]]
    why = f"{count} of {search.spent} boxes stay undecided" if count else ""
    if doubtful.size and not count:
        why = f"rates may come to zero beside a jump, near {doubtful[reduced.unknowns[0], 0]:.6g}"
    return RootBoxes(starts, room, flat, on_jump, why)


def _zero_on_jump(reduced: ReducedFlow, box: Array) -> Array | None:
    """A zero (k,) in a narrow box (2, k) in which an equation jumps: in its middle, or on the jump itself.

    Up to rounding the equation may be zero on one side alone, where it comes to zero without being it.
    """
    middle = box.mean(axis=0)
    places = [np.where(np.abs(middle) > SMALLEST, middle, 0.0)]
    if len(middle) == 1:
        places += [np.array([x]) for x in _ends_of_jump(reduced, *box[:, 0])]
    for place in places:
        if not any(row.low.any() for row in reduced.rates(list(place))):
            return place
    sides = places[1:]
    return sides[0] if sides and all(_rounds_to_zero(reduced, side) for side in sides) else None


def _ends_of_jump(reduced: ReducedFlow, low: float, high: float) -> tuple[float, float]:
    """The neighbouring floats between which a step changes."""
    before = reduced.steps(low)
    while low < (middle := (low + high) / 2) < high:
        low, high = (middle, high) if reduced.steps(middle) == before else (low, middle)
    return low, high


def _rounds_to_zero(reduced: ReducedFlow, w: Array) -> bool:
    """Whether the equations are zero at a point (k,), up to rounding on its own side of the jump."""
    values = [row.low for row in reduced.rates(list(w))]
    for rows in reduced.branches([Interval(x, x) for x in w]):
        own = all(row.low <= value <= row.high for row, value in zip(rows, values, strict=True))
        if own and _vanishes(rows, 1).all():
            return True
    return False


def _prune(reduced: ReducedFlow, boxes: Boxes) -> tuple[Boxes, Boxes]:
    """The boxes that may hold zeros, each as small as is known; and those that hold one."""
    possible = reduced.of(boxes.owners).may_vanish(_intervals(boxes.ends), len(boxes.owners))
    boxes = _by_single_rows(reduced, boxes.take(possible))
    if not len(boxes.owners):
        return boxes, boxes
    # Zeros at the edge of a box are inside a box that is a little larger.
    (low, high), owners = boxes
    room = EDGE * (high - low)
    wide = np.stack([low - room, high + room])
    image, possible = _krawczyk(reduced.of(owners), wide)
    inside = ((image[0] > wide[0]) & (image[1] < wide[1])).all(axis=0)
    outside = ((image[0] > high) | (image[1] < low)).any(axis=0) | ~possible
    smaller = Boxes(np.stack([np.fmax(low, image[0]), np.fmin(high, image[1])]), owners)
    if len(low) == 1:
        crossed = _crosses(reduced.of(owners), boxes.ends) & ~np.isnan(image[0, 0]) & ~inside
        image, inside = np.where(crossed, smaller.ends, image), inside | crossed
    return smaller.take(~outside & ~inside), Boxes(image, owners).take(inside)


def _by_single_rows(reduced: ReducedFlow, boxes: Boxes) -> Boxes:
    """Boxes without what single equations exclude: each gives each unknown w by the others, where it has a
    slope s of one sign, as c - f(c)/s for the middle c of its range.

    A reaction, which multiplies functions of angles, is known so long before the matrix of slopes is regular.
    """
    if not reduced.proportional.any():
        return boxes
    ends, flow = boxes.ends.copy(), reduced.of(boxes.owners)
    slopes = flow.jacobian(_intervals(ends))
    for j in np.flatnonzero(reduced.proportional):
        low, high = ends[:, j]
        middle, at = (low + high) / 2, _intervals(ends)
        at[j] = Interval(middle, middle)
        for rate, slope in zip(flow.rates(at), slopes[j], strict=True):
            root = Interval(middle, middle) - rate * slope.reciprocal()
            bounds = np.isfinite(root.low) & np.isfinite(root.high) & ~slope.contains_zero()
            ends[0, j] = np.where(bounds, np.fmax(ends[0, j], root.low), ends[0, j])
            ends[1, j] = np.where(bounds, np.fmin(ends[1, j], root.high), ends[1, j])
    return Boxes(ends, boxes.owners).take((ends[0] <= ends[1]).all(axis=0))


def _crosses(reduced: ReducedFlow, boxes: Array) -> NDArray[np.bool_]:
    """Whether the one equation has different signs at the ends of boxes (2, 1, N)."""
    low, high = (reduced.rates([Interval(end[0], end[0])])[0] for end in boxes)
    different = ((low.high < 0) & (high.low > 0)) | ((low.low > 0) & (high.high < 0))
    return np.broadcast_to(different, boxes.shape[2:])


def _intervals(ends: Array) -> list[Interval]:
    return [Interval(*one) for one in np.moveaxis(ends, 1, 0)]


def _krawczyk(reduced: ReducedFlow, boxes: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Bounds (2, k, N) of the zeros in boxes (2, k, N), and which boxes may hold zeros.

    If the bounds are within the box, it holds exactly one zero.  They are NaN if derivatives are not known,
    or singular in the middle.  Which boxes may hold zeros follows from values in the middle and derivatives:
    terms that cancel do not widen these bounds.  For one equation the bounds are those of the interval Newton
    method, which needs no more than a slope of one sign.
    """
    k, count = boxes.shape[1:]
    middle = boxes.mean(axis=0)
    ways = _intervals(boxes - middle)
    at, slopes, values = _mean_values(reduced, boxes)
    possible = np.ones(count, dtype=bool)
    for value in values:
        possible &= np.broadcast_to(value.contains_zero() | np.isnan(value.low), count)
    if k == 1:
        slope = interval(slopes[0][0])
        image = Interval(middle[0], middle[0]) - at[0] * slope.reciprocal()
        # no pole, no jump
        regular = ~slope.contains_zero() & np.isfinite(slope.low) & np.isfinite(slope.high)
        return np.stack([np.where(regular, end, np.nan)[None] for end in (image.low, image.high)]), possible
    centres = np.zeros((count, k, k))
    for j, column in enumerate(slopes):
        for i, entry in enumerate(column):
            centres[:, i, j] = (entry.low + entry.high) / 2
    regular = np.isfinite(centres).all(axis=(1, 2))
    centres[~regular] = np.eye(k)
    regular &= np.abs(np.linalg.det(centres)) > 0
    centres[~regular] = np.eye(k)
    inverse = np.linalg.inv(centres)
    regular &= np.isfinite(inverse).all(axis=(1, 2))
    images = np.full_like(boxes, np.nan)
    for i in range(k):
        image = Interval(middle[i], middle[i])
        for row in range(k):
            image = image - at[row] * inverse[:, i, row]
        for j in range(k):
            factor: Any = interval(float(i == j))
            for row in range(k):
                factor = factor - slopes[j][row] * inverse[:, i, row]
            image = image + factor * ways[j]
        images[:, i] = np.where(regular, [image.low, image.high], np.nan)
    return images, possible


def _mean_values(
    reduced: ReducedFlow, boxes: Array
) -> tuple[list[Interval], list[list[Interval]], list[Interval]]:
    """The equations in the middles of boxes (2, k, N), their derivatives in them, and bounds by these."""
    middle = boxes.mean(axis=0)
    at = reduced.rates([Interval(c, c) for c in middle])
    slopes = reduced.jacobian(_intervals(boxes))
    values = []
    for i, value in enumerate(at):
        for column, way in zip(slopes, _intervals(boxes - middle), strict=True):
            value = value + column[i] * way
        values.append(value)
    return at, slopes, values


def _contracted(reduced: ReducedFlow, boxes: Array) -> Array:
    """Boxes (2, k, N) that hold one zero each, made small about it."""
    for _ in range(CONTRACTIONS if boxes.shape[2] else 0):
        image, _ = _krawczyk(reduced, boxes)
        before = boxes[1] - boxes[0]
        boxes = np.stack([np.fmax(boxes[0], image[0]), np.fmin(boxes[1], image[1])])
        if not (boxes[1] - boxes[0] < SHRINKING * before).any():
            break
    return boxes


def _finest(reduced: ReducedFlow, low: Array, high: Array) -> Any:
    """Widths (N,) of boxes that are not worth bisecting.

    They are larger if the equations are zero up to rounding in the middle.  If they are so in the whole box,
    no width is worth it.
    """
    finest = np.full(low.shape[1], FINEST)
    zero = reduced.may_vanish([Interval(c, c) for c in (low + high) / 2], len(finest))
    if zero.any():
        rounding = _is_rounding(reduced, low, high)
        finest[zero] = np.where(rounding[zero], np.inf, ROUNDED)
    return finest


def _vanishes(rows: list[Interval], count: int) -> NDArray[np.bool_]:
    return np.all([np.broadcast_to(row.contains_zero(), count) for row in rows], axis=0)


def _is_rounding(reduced: ReducedFlow, low: Array, high: Array) -> NDArray[np.bool_]:
    """Whether the equations are zero up to rounding in whole boxes."""
    whole = reduced.rates([Interval(*ends) for ends in zip(low, high, strict=True)])
    *_, means = _mean_values(reduced, np.stack([low, high]))
    widths = [np.fmin(a.high - a.low, b.high - b.low) for a, b in zip(whole, means, strict=True)]
    alike = np.ones(low.shape[1], dtype=bool)
    for point in (low, high, (low + high) / 2):
        rows = reduced.rates([Interval(c, c) for c in point])
        alike &= _vanishes(rows, len(alike))
        for row, width in zip(rows, widths, strict=True):
            alike &= np.broadcast_to(width <= ROUNDING_FACTOR * (row.high - row.low), len(alike))
    return alike


def _widths(low: Array, high: Array, turning: NDArray[np.bool_]) -> Array:
    """Widths (k, N) of boxes in decades, about; relative ones where they are narrow; of angles in rad."""
    sizes = np.abs(low), np.abs(high)
    least, most = (np.maximum(size, SMALLEST) for size in (np.minimum(*sizes), np.maximum(*sizes)))
    ratio = np.log(most) - np.log(least)
    width = np.where(ratio > 1e-3, ratio, (most - least) / most)
    width = np.where((low < 0) & (high > 0) & (most > SMALLEST), np.inf, width)
    return np.where(turning[:, None], high - low, width)


def _halves(boxes: Boxes, turning: NDArray[np.bool_], width: Array | None = None) -> Boxes:
    """The boxes cut in two along their widest side, or their only one: at zero, or so that both have as many
    decades; of an angle in the middle."""
    if not len(boxes.owners):
        return boxes
    low, high = boxes.ends
    widest = 0 if width is None else width.argmax(axis=0)
    side = (widest, np.arange(low.shape[1]))
    a, b = low[side], high[side]
    least, most = np.minimum(np.abs(a), np.abs(b)), np.maximum(np.abs(a), np.abs(b))
    middle = np.where(
        most > 2 * least, np.sqrt(np.maximum(least, SMALLEST)) * np.sqrt(most), (least + most) / 2
    )
    cut = np.where((a < 0) & (b > 0), 0.0, np.where(b > 0, middle, -middle))
    cut = np.where(turning[widest], (a + b) / 2, cut)
    below, above = high.copy(), low.copy()
    below[side], above[side] = cut, cut
    return _joined(
        [Boxes(np.stack([low, below]), boxes.owners), Boxes(np.stack([above, high]), boxes.owners)]
    )


def _clusters(boxes: Array) -> Array:
    """Undecided boxes (2, k, N) that touch, as one box each."""
    clusters: list[Array] = []
    for box in np.moveaxis(boxes, 2, 0)[np.lexsort(boxes[0])] if boxes.shape[2] else ():
        for other in clusters[-TOUCHING:]:
            size = np.maximum(np.abs(box).max(axis=0), np.abs(other).max(axis=0))
            room = 2 * np.maximum(box[1] - box[0], other[1] - other[0]) + 10 * ROUNDED * size + SMALLEST
            if (box[0] <= other[1] + room).all() and (box[1] >= other[0] - room).all():
                other[0], other[1] = np.minimum(other[0], box[0]), np.maximum(other[1], box[1])
                break
        else:
            clusters.append(box.copy())
    return np.stack(clusters, axis=2) if clusters else boxes


def _bracket(
    reduced: ReducedFlow, boxes: Array, which: NDArray[np.intp], starts: Array, flat: NDArray[np.bool_]
) -> None:
    """Put roots where the one equation changes its sign across a box: they are of odd multiplicity."""
    from scipy.optimize.elementwise import find_root  # it takes long to load, and is seldom needed

    def rate(w: Array) -> Array:
        value = reduced.rates([Interval(w, w)])[0]
        return np.broadcast_to((value.low + value.high) / 2, np.shape(w))

    low, high = boxes[:, 0, which]
    room = high - low + ROUNDED * np.maximum(np.abs(low), np.abs(high)) + SMALLEST
    ends = np.stack([low - room, high + room])
    centre = starts[reduced.unknowns[0], which]
    between: Any = find_root(rate, tuple(ends))
    root = np.where(rate(centre) == 0, centre, np.where(between.success, between.x, np.nan))
    # A rate that jumps, as beside a pole, comes no nearer to zero than at an end.
    residual = np.abs(rate(root))
    changes = (residual == 0) | (residual < np.abs([rate(end) for end in ends]).min(axis=0))
    for i, x in zip(which[changes], root[changes], strict=True):
        starts[:, i] = reduced.full_states(np.array([[x]]))[:, 0]
        flat[i] = True
