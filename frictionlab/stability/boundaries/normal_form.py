"""The normal form of a Hopf point, w' = (i omega + slope (p - p0)) w + cubic w |w|^2, x = x0 + 2 Re(w q).

Derivatives of any order along given directions are made by sympy once: f(x + s u + t v + ...) is
differentiated once by each of s, t, ... at zero.  The result is linear in each direction, so it takes complex
vectors, and it stays far smaller than a table of partial derivatives.  Yu. A. Kuznetsov, "Elements of Applied
Bifurcation Theory", 3rd ed., Springer, 2004; also his "Andronov-Hopf bifurcation", Scholarpedia 1(10) (2006)
1858.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from itertools import chain
from typing import Any, NamedTuple

import numpy as np
import sympy
from numpy.typing import NDArray

from frictionlab.hybrid.outputs import numpy_function
from frictionlab.stability.flow import Flow

Vector = NDArray[Any]

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
ZERO_RTOL = 1e-9  # what is below this share of its terms, or of the largest eigenvalue, counts as zero
# Eigenvalues nearer to each other than this share count as one: rounding parts a double one so far.
DOUBLE_EIGENVALUE_RTOL = 1e-6


class ExpansionPoint(NamedTuple):
    """The point at which a flow is differentiated: a state (m,), and the values of the parameters."""

    flow: Flow
    state: NDArray[np.float64]
    values: Sequence[float]


def directional_derivative(at: ExpansionPoint, *directions: Vector) -> Vector:
    """The derivative of x' along each of the directions (m,), complex or real: B(u, v) or C(u, v, w)."""
    return function_derivative(at, at.flow.expressions, *directions)


def parameter_derivative(at: ExpansionPoint, parameter: str, *directions: Vector) -> Vector:
    """The derivative of x' by a parameter and along each of the directions (m,)."""
    return function_derivative(at, _parameter_rates(at.flow, parameter), *directions)


def function_derivative(at: ExpansionPoint, functions: tuple[Any, ...], *directions: Vector) -> Vector:
    """As :func:`directional_derivative` for other functions (k,) of the state; values without directions."""
    form = _multilinear_form(at.flow, functions, len(directions))
    return np.array(form(*at.state, *at.values, *chain.from_iterable(directions)))


@lru_cache(maxsize=256)
def _multilinear_form(flow: Flow, functions: tuple[Any, ...], order: int) -> Callable[..., Any]:
    """A function of states, parameters and `order` directions, one after the other."""
    directions = [u for level in range(order) for u in _direction(level, len(flow.states))]
    expressions = list(_differentiate(functions, flow.states, order))
    arguments = [*flow.states, *flow.parameters, *directions]
    return numpy_function(arguments, expressions)


@lru_cache(maxsize=256)
def _differentiate(functions: tuple[Any, ...], states: tuple[Any, ...], order: int) -> tuple[Any, ...]:
    if order == 0:
        return functions
    step = sympy.Dummy(real=True)
    moved = {x: x + step * u for x, u in zip(states, _direction(order - 1, len(states)))}
    lower = _differentiate(functions, states, order - 1)
    return tuple(_derivative(f.xreplace(moved), step).xreplace({step: sympy.S.Zero}) for f in lower)


@lru_cache(maxsize=256)
def _parameter_rates(flow: Flow, parameter: str) -> tuple[Any, ...]:
    symbol = next(symbol for symbol in flow.parameters if symbol.name == parameter)
    return tuple(_derivative(f, symbol) for f in flow.expressions)


def _derivative(function: Any, symbol: Any) -> Any:
    # No equilibrium lies at a kink, such as that of |v_r|; elsewhere the delta function in its derivative is
    # zero.
    rate = sympy.diff(function, symbol)
    return rate.replace(sympy.DiracDelta, lambda *_: sympy.S.Zero) if rate.has(sympy.DiracDelta) else rate


@lru_cache(maxsize=64)
def _direction(level: int, count: int) -> tuple[Any, ...]:
    return tuple(sympy.Dummy(f"u{level}_{i}", real=True) for i in range(count))


class CriticalPair(NamedTuple):
    """An eigenvalue i omega (rad/s), its right vector q of length 1, its left vector p with p q = 1."""

    omega: float
    right: ComplexArray
    left: ComplexArray


def critical_pair(matrix: Array, frequency: float) -> CriticalPair | None:
    """The pair of that frequency (Hz); None if it is double, or another mode neither grows nor decays."""
    pairs: Any = np.linalg.eig(matrix.astype(complex))
    values, vectors = pairs.eigenvalues, pairs.eigenvectors
    k = int(np.argmin(np.abs(values - 2j * np.pi * frequency)))
    critical, right = values[k], vectors[:, k]
    others: Any = np.delete(values, [k, int(np.argmin(np.abs(values - critical.conjugate())))])
    neutral = np.abs(others.real).min(initial=np.inf) < ZERO_RTOL * np.abs(values).max()
    if neutral or np.abs(others - critical).min(initial=np.inf) < DOUBLE_EIGENVALUE_RTOL * abs(critical):
        return None
    return CriticalPair(float(critical.imag), right, _left_vector(matrix, critical, right))


def _left_vector(matrix: Array, value: complex, right: ComplexArray) -> ComplexArray:
    """The left vector, from a bordered system, which is regular for a simple eigenvalue."""
    m = len(right)
    bordered = np.zeros((m + 1, m + 1), dtype=complex)
    bordered[:m, :m] = matrix.T - value * np.eye(m)
    bordered[:m, m], bordered[m, :m] = right.conj(), right
    return np.linalg.solve(bordered, np.eye(m + 1)[m])[:m]


def cubic_coefficient(at: ExpansionPoint, matrix: Array, pair: CriticalPair) -> complex:
    """The coefficient of w |w|^2; its real part is exactly zero where it is zero to rounding."""
    omega, q, p = pair
    shift = -np.linalg.solve(matrix, directional_derivative(at, q, q.conj()))
    second = np.linalg.solve(2j * omega * np.eye(len(q)) - matrix, directional_derivative(at, q, q))
    terms = [
        directional_derivative(at, q, q, q.conj()),
        2 * directional_derivative(at, q, shift),
        directional_derivative(at, q.conj(), second),
    ]
    found = 0.5 * complex(p @ sum(terms))
    size = 0.5 * float(sum(np.abs(p) @ np.abs(term) for term in terms))
    return found if abs(found.real) > ZERO_RTOL * size else complex(0.0, found.imag)


def eigenvalue_slope(at: ExpansionPoint, matrix: Array, pair: CriticalPair, parameter: str) -> complex:
    """d(eigenvalue)/d(parameter), with the equilibrium as it moves."""
    _, q, p = pair
    moved = -np.linalg.solve(matrix, parameter_derivative(at, parameter))
    return complex(p @ (parameter_derivative(at, parameter, q) + directional_derivative(at, moved, q)))
