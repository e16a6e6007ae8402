"""Polynomials as numbers: a law that is evaluated at a `Polynomial` gives the coefficients of its own."""

from __future__ import annotations

from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Polynomial:
    """Coefficients (degree + 1, N), constant first; a column for each of N values of the parameters.

    It takes the place of a number in a law: sums, products, quotients by numbers, and integer powers are
    polynomials again.  Anything else raises TypeError, which shows that a law is no polynomial.
    """

    __array_ufunc__ = None  # makes numpy leave array * polynomial to this class

    def __init__(self, coefficients: Any) -> None:
        self.coefficients: Array = np.asarray(coefficients, dtype=float)

    def __add__(self, other: Any) -> Polynomial:
        mine, its = self.coefficients, _coefficients(other)
        longer, shorter = (mine, its) if len(mine) >= len(its) else (its, mine)
        count = max(mine.shape[1], its.shape[1])
        total = np.broadcast_to(longer, (len(longer), count)).copy()
        total[: len(shorter)] += shorter
        return Polynomial(total)

    def __mul__(self, other: Any) -> Polynomial:
        mine, its = self.coefficients, _coefficients(other)
        longer, shorter = (mine, its) if len(mine) >= len(its) else (its, mine)
        product = np.zeros((len(mine) + len(its) - 1, max(mine.shape[1], its.shape[1])))
        for k, row in enumerate(shorter):
            product[k : k + len(longer)] += row * longer
        return Polynomial(product)

    def __pow__(self, exponent: Any) -> Polynomial:
        if not isinstance(exponent, int) or exponent < 1:
            raise TypeError(f"a polynomial to the power of {exponent!r} is no polynomial")
        return self if exponent == 1 else self * self ** (exponent - 1)

    def __truediv__(self, other: Any) -> Polynomial:
        return Polynomial(self.coefficients / _constant_coefficients(other))

    def __neg__(self) -> Polynomial:
        return Polynomial(-self.coefficients)

    def __sub__(self, other: Any) -> Polynomial:
        return self + -other

    def __rsub__(self, other: Any) -> Polynomial:
        return -self + other

    __radd__, __rmul__ = __add__, __mul__


UNKNOWN = Polynomial([[0.0], [1.0]])


def _coefficients(other: Any) -> Array:
    return other.coefficients if isinstance(other, Polynomial) else _constant_coefficients(other)


def _constant_coefficients(number: Any) -> Array:
    if not isinstance(number, (Real, np.ndarray)):
        raise TypeError(f"{number!r} is no number")
    return np.atleast_1d(np.asarray(number, dtype=float))[None]
