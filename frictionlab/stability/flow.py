"""The flow of one mode as functions of arrays, with its derivatives by the state and by all parameters.

With x' = f(x, p) and its Jacobian A = f_x at the equilibrium f = 0,

    dx/dp = -A^-1 f_p,    d(lambda)/dp = l (f_xp + f_xx dx/dp) r,

for the right vector r and the left vector l of a simple eigenvalue, l r = 1.  The second term needs one
solution of A^T w = l f_xx r, however many parameters there are (the adjoint equation).  sympy derives the
entries of f_p, f_xp and f_xx that are not zero, once for a flow.  Equilibria and eigenvalues need only the
flow and its Jacobian as functions; for models of the library these are kept in files (`late_flow`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionlab.automaton.expressions import combinations_of, within_floats
from frictionlab.hybrid.elementary.parameter_functions import OF_ARRAYS
from frictionlab.lazy_names import sympy
from frictionlab.models.serialisation import Derivations
from frictionlab.models.symbols import derivatives

Array = NDArray[np.float64]
# From so many terms on, Python code of each takes seconds: they become sums of a few expressions instead.
MANY_TERMS = 1000


def _real_derivatives(row: Any, states: set[Any]) -> dict[Any, Any]:
    """Derivatives by the states, which are real: to sympy Abs(x) has none unless it is told so."""
    row = sympy.sympify(row, strict=True)
    if not row.has(sympy.Abs, sympy.sign):
        return derivatives(row, states)
    real = {x: sympy.Dummy(x.name, real=True) for x in row.free_symbols if not x.is_real}
    back = {dummy: x for x, dummy in real.items()}
    found = derivatives(row.xreplace(real), {real.get(x, x) for x in states})
    return {back.get(x, x): entry.xreplace(back) for x, entry in found.items()}


class Jacobian(NamedTuple):
    """The state matrix of a flow as its entries that are not zero.

    Parameters
    ----------
    size : int
        How many states there are.
    places : sequence of (row, column)
    entries : callable
        Their values, as a function of all states, then all parameters.
    """

    size: int
    places: Sequence[tuple[int, int]]
    entries: Callable[..., Any]

    def at(self, x: Any, values: Sequence[Any]) -> Array:
        """d x'/d x as (..., m, m), at states `x` (m, ...)."""
        matrix = np.zeros((self.size, self.size, *np.shape(x[0])))
        entries = self.entries(*x, *values)
        if isinstance(entries, np.ndarray):
            rows, columns = zip(*self.places)
            matrix[rows, columns] = entries.reshape(len(rows), -1) if matrix.ndim > 2 else entries
        else:
            for (row, column), entry in zip(self.places, entries):
                matrix[row, column] = entry
        return np.moveaxis(matrix, (0, 1), (-2, -1))


class LateFlow(NamedTuple):
    """A flow whose expressions are derived when they are asked for.

    Parameters
    ----------
    kept : Derivations
        What has been derived of its model's structure and is kept in files.
    name : str
        Tells it from other flows of that structure.
    derive : callable
        Gives the flow with its expressions.
    """

    kept: Derivations
    name: str
    derive: Callable[[], Flow]


@dataclass(frozen=True, eq=False)
class Flow:
    """x' = rhs(x) and its Jacobian, for N states and N values of the parameters.

    Parameters
    ----------
    states, parameters : tuple of sympy.Symbol
    expressions : tuple of sympy.Expr
        The right-hand sides.
    margins : tuple of sympy.Expr
        Positive where the mode can last: its event functions, its normal force.
    coordinates : int
        How many states are coordinates.
    """

    states: tuple[Any, ...]
    parameters: tuple[Any, ...]
    expressions: tuple[Any, ...]
    margins: tuple[Any, ...]
    coordinates: int
    _late: ClassVar[LateFlow | None] = None

    def __getattr__(self, name: str) -> Any:  # for the fields that are derived late
        if self._late is None or name not in self.__match_args__:
            raise AttributeError(f"a Flow has no attribute {name!r}")
        derived = self._late.derive()
        for each in self.__match_args__:
            object.__setattr__(self, each, getattr(derived, each))
        return getattr(derived, name)

    @cached_property
    def _partial(self) -> dict[tuple[int, int], Any]:
        places, states = {x: j for j, x in enumerate(self.states)}, {*self.states}
        return {
            (i, places[x]): entry
            for i, row in enumerate(self.expressions)
            for x, entry in sorted(_real_derivatives(row, states).items(), key=lambda item: places[item[0]])
        }

    @cached_property
    def _outline(self) -> dict[str, Any]:
        """All that is known of the flow, except its functions, as data that JSON can hold."""

        def derive() -> dict[str, Any]:
            states, partial = {*self.states}, self._partial
            changing = {j for (_, j), entry in partial.items() if not states.isdisjoint(entry.free_symbols)}
            return {
                "size": len(self.states),
                "places": [*partial],
                "nonlinear": sorted(changing),
                "bounded": bool(self.margins),
            }

        late = self._late
        return derive() if late is None else late.kept.value(f"flow of {late.name}", derive)

    @property
    def size(self) -> int:
        """How many states there are."""
        return self._outline["size"]

    @cached_property
    def free(self) -> list[int]:
        """The states whose rates depend on no state."""
        return sorted({*range(self.size)} - {row for row, _ in self._outline["places"]})

    @cached_property
    def unseen(self) -> list[int]:
        """The states on which no rate depends."""
        return sorted({*range(self.size)} - {column for _, column in self._outline["places"]})

    @property
    def linear(self) -> bool:
        """Whether the Jacobian is the same at every state."""
        return not self.nonlinear

    @property
    def nonlinear(self) -> list[int]:
        """The states that enter nonlinearly: columns of the Jacobian that are not the same at every state."""
        return self._outline["nonlinear"]

    @cached_property
    def derivative(self) -> Jacobian:
        """The Jacobian as a function."""
        entries = self._function("Jacobian", lambda: tuple(self._partial.values()))
        return Jacobian(self.size, self._outline["places"], entries)

    @cached_property
    def _nonlinear_places(self) -> list[tuple[int, int]]:
        return [(i, j) for i, j in self._outline["places"] if j in self.nonlinear]

    @cached_property
    def _nonlinear_entries(self) -> Callable[..., Any]:
        places = self._nonlinear_places
        return self._function("nonlinear columns", lambda: [self._partial[place] for place in places])

    @cached_property
    def _rhs(self) -> Callable[..., Any]:
        return self._function("rates", lambda: self.expressions)

    @cached_property
    def _margins(self) -> Callable[..., Any]:
        return self._function("margins", lambda: self.margins)

    def _function(self, name: str, expressions: Callable[[], Sequence[Any]]) -> Callable[..., Any]:
        """A function as `compiled` gives it, or as it is kept in a file."""
        late, derive = self._late, lambda: self.compiled(expressions())
        return derive() if late is None else late.kept.function(f"{name} of {late.name}", OF_ARRAYS, derive)

    def compiled(self, expressions: Sequence[Any]) -> Callable[..., Any]:
        """A numpy function of all states, then all parameters."""
        from frictionlab.hybrid.expression_functions import numpy_function  # which loads sympy

        arguments = [*self.states, *self.parameters]
        expressions = [within_floats(one) for one in expressions]
        if sum(len(sympy.Add.make_args(one)) for one in expressions) < MANY_TERMS:
            return numpy_function(arguments, list(expressions))
        from scipy.sparse import csr_array  # imported here, as few flows need it

        sums = combinations_of(expressions, self.states)
        of = numpy_function(arguments, list(sums.expressions))
        matrix = csr_array((sums.numbers, tuple(sums.places.T)), (sums.sums, len(sums.expressions)))
        return lambda *values: matrix @ np.stack(np.broadcast_arrays(*of(*values)))

    def rhs(self, x: Any, values: Sequence[Any]) -> Array:
        """x' (m, ...) at states `x` (m, ...); parameters are numbers or arrays."""
        return _stacked(self._rhs(*x, *values), np.shape(x[0]))

    def bounds(self, x: Sequence[Any], values: Sequence[Any]) -> Sequence[Any]:
        """x' where states are numbers or intervals."""
        return self._rhs(*x, *values)

    def margin(self, x: Any, values: Sequence[Any]) -> Array:
        """The least of the margins, (...)."""
        if not self._outline["bounded"]:
            return np.full(np.shape(x[0]), np.inf)
        return _stacked(self._margins(*x, *values), np.shape(x[0])).min(axis=0)

    def jacobian(self, x: Any, values: Sequence[Any]) -> Array:
        """d x'/d x as (..., m, m)."""
        return self.derivative.at(x, values)

    def nonlinear_columns(self, x: Array, values: Sequence[Any]) -> Array:
        """The columns `nonlinear` of the Jacobian as (N, m, k), at states (m, N)."""
        columns = {j: k for k, j in enumerate(self.nonlinear)}
        found = np.zeros((x.shape[1], self.size, len(columns)))
        for (i, j), entry in zip(self._nonlinear_places, self._nonlinear_entries(*x, *values)):
            found[:, i, columns[j]] = entry
        return found


def late_flow(late: LateFlow) -> Flow:
    """A flow whose functions are kept in files; its expressions are derived when they are needed."""
    made = object.__new__(Flow)
    object.__setattr__(made, "_late", late)
    return made


def _stacked(parts: Sequence[Any], shape: tuple[int, ...]) -> Array:
    found = np.empty((len(parts), *shape))
    for i, part in enumerate(parts):
        found[i, ...] = part
    return found


ComplexArray = NDArray[np.complex128]
Places = NDArray[np.intp]
SINGULAR_RTOL = (
    1e-13  # of the largest singular value: below it the equilibrium is no function of the parameters
)


class Entries(NamedTuple):
    """The entries of an array of derivatives that are not zero: where they are, and their values."""

    places: Places
    values: Callable[..., Array]

    def at(self, x: Array, parameters: Sequence[float]) -> Array:
        """Their values (k,) at a state and values of the parameters."""
        if not len(self.places):
            return np.zeros(0)
        return np.array([float(v) for v in self.values(*x, *parameters)])


class FlowDerivatives(NamedTuple):
    """f_p, f_xp and f_xx of a flow: places are (i, k), (i, j, k) and (i, j, l)."""

    by_parameter: Entries
    mixed: Entries
    second: Entries


@lru_cache(maxsize=64)
def flow_derivatives(flow: Flow) -> FlowDerivatives:
    """The derivatives of a flow, derived by sympy."""
    states = {x: j for j, x in enumerate(flow.states)}
    parameters = {p: k for k, p in enumerate(flow.parameters)}
    by_parameter, mixed, second = {}, {}, {}
    for i, rate in enumerate(flow.expressions):
        for symbol, slope in _derivatives(rate, {*states, *parameters}).items():
            if symbol in parameters:
                by_parameter[i, parameters[symbol]] = slope
                continue
            for other, curvature in _derivatives(slope, {*states, *parameters}).items():
                table, places = (mixed, parameters) if other in parameters else (second, states)
                table[i, states[symbol], places[other]] = curvature
    return FlowDerivatives(
        _entries(flow, by_parameter, 2), _entries(flow, mixed, 3), _entries(flow, second, 3)
    )


def _derivatives(expression: Any, symbols: set[Any]) -> dict[Any, Any]:
    # No equilibrium lies at a kink, such as that of |v_r|; elsewhere the delta function there is zero.
    found = derivatives(expression, symbols).items()
    return {x: d.replace(sympy.DiracDelta, lambda *_: 0) if d.has(sympy.DiracDelta) else d for x, d in found}


def _entries(flow: Flow, table: dict[tuple[int, ...], Any], dimensions: int) -> Entries:
    known = {place: entry for place, entry in table.items() if entry != 0}
    places = np.array(list(known), dtype=np.intp).reshape(-1, dimensions)
    return Entries(places, flow.compiled(tuple(known.values())) if known else lambda *_: np.zeros(0))


class EquilibriumDerivatives(NamedTuple):
    """An equilibrium with the derivatives of its flow by the state and by all parameters.

    Parameters
    ----------
    flow : Flow
    x : array (m,)
    values : sequence of float
        The parameters.
    matrix : array (m, m)
        The Jacobian A.
    by_parameter : array (m, P)
        f_p.
    """

    flow: Flow
    x: Array
    values: Sequence[float]
    matrix: Array
    by_parameter: Array

    def state(self) -> Array:
        """dx/dp (m, P).

        Raises
        ------
        ValueError
            Where A is singular: the equilibrium ends there, or is one of a line of equilibria.
        """
        return -solve_regular(self.matrix, self.by_parameter)

    def bilinear(self, left: Any, right: Any) -> ComplexArray:
        """l (dA/dp) r (P,), including the shift of the equilibrium."""
        found = flow_derivatives(self.flow)
        mixed, second = found.mixed, found.second
        total: Any = np.zeros(len(self.flow.parameters), dtype=complex)
        i, j, k = mixed.places.T
        np.add.at(total, k, left[i] * mixed.at(self.x, self.values) * right[j])
        if len(second.places):
            force: Any = np.zeros(len(self.x), dtype=complex)
            i, j, k = second.places.T
            np.add.at(force, k, left[i] * second.at(self.x, self.values) * right[j])
            total = total - solve_regular(self.matrix.T, force) @ self.by_parameter
        return total


def equilibrium_derivatives(flow: Flow, x: Array, values: Sequence[float]) -> EquilibriumDerivatives:
    """The derivatives at an equilibrium (m,)."""
    entries = flow_derivatives(flow).by_parameter
    by_parameter = np.zeros((len(x), len(flow.parameters)))
    by_parameter[tuple(entries.places.T)] = entries.at(x, values)
    return EquilibriumDerivatives(flow, x, values, flow.jacobian(x, values), by_parameter)


def solve_regular(matrix: Any, right: Any) -> Any:
    """The solution of a linear system with a state matrix.

    Raises
    ------
    ValueError
        Where the matrix is singular, to rounding.
    """
    # Rows and columns are scaled by their size, as state matrices have stiffnesses beside ones.
    rows = 1.0 / np.maximum(np.abs(matrix).max(axis=1), np.finfo(float).tiny)
    columns = 1.0 / np.maximum(np.abs(rows[:, None] * matrix).max(axis=0), np.finfo(float).tiny)
    scaled = rows[:, None] * matrix * columns
    sizes = np.linalg.svd(scaled, compute_uv=False)
    if sizes[-1] < SINGULAR_RTOL * sizes[0]:
        raise ValueError(
            "the equilibrium must depend smoothly on the parameters to have derivatives, got one where the "
            "state matrix is singular: take another value"
        )
    return columns.reshape(-1, *[1] * (np.ndim(right) - 1)) * np.linalg.solve(
        scaled, rows.reshape(-1, *[1] * (np.ndim(right) - 1)) * right
    )


class NullVectors(NamedTuple):
    """Left and right vectors (m,) of an eigenvalue, of length 1 after scaling; `product` is l r."""

    left: Any
    right: Any
    product: complex


def null_vectors(matrix: Array, value: complex) -> NullVectors:
    """The vectors of the eigenvalue nearest to a value, also where two coalesce and l r = 0.

    They are the last singular vectors of A - lambda 1, in units that give velocities the size of coordinates.
    """
    n, odd = divmod(len(matrix), 2)
    size = float(np.sqrt(np.linalg.norm(matrix, 2))) or 1.0
    units = np.ones(len(matrix)) if odd else np.repeat([1.0, size], n)
    scaled = matrix * units / units[:, None]
    shifted = scaled - value * np.eye(len(matrix))
    u, _, vh = np.linalg.svd(shifted)
    left, right = u[:, -1].conj(), vh[-1].conj()
    return NullVectors(left / units, right * units, complex(left @ right))
