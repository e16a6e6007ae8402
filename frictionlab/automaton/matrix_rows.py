"""Products of a matrix of numbers with expressions, of which each row is one expression.

The equations of a structure with n freedoms are some 2 n^2 numbers times states.  To sympy each row is an
atom, whose numbers are an array: it neither sorts nor copies them.  A tape takes a row as one operation.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import count
from typing import Any

import numpy as np
import sympy
from numpy.typing import NDArray

from frictionlab.automaton.mode import Expr

Array = NDArray[np.float64]
_NUMBERS = count()
MOST_PRINTED = 6  # terms that are printed


@dataclass(frozen=True, eq=False)
class MatrixProduct:
    """A matrix of numbers times expressions.

    Parameters
    ----------
    matrix : array (rows, factors)
    factors : tuple of Expr
    own : int
        How many factors at the end are those of one mode, where other modes have a product like this one.
    like : MatrixProduct or None
        Another product of the same matrix, whose entries this one shares.
    """

    matrix: Array
    factors: tuple[Expr, ...]
    own: int = 0
    like: MatrixProduct | None = None
    number: int = field(default_factory=lambda: next(_NUMBERS))

    def with_own(self, factors: Sequence[Expr]) -> MatrixProduct:
        """The product with other factors at the end, those of a mode."""
        first = len(self.factors) - len(factors)
        return MatrixProduct(self.matrix, (*self.factors[:first], *factors), len(factors), self)

    def with_factors(self, factors: Iterable[Expr]) -> MatrixProduct:
        """The product with these factors."""
        own = tuple(factors)
        if self.like is None or own[: -self.own] != self.like.factors[: -self.own]:
            return MatrixProduct(self.matrix, own)
        return self.like.with_own(own[-self.own :])

    @cached_property
    def count(self) -> int:
        """Number of entries that are not zero."""
        return int(np.count_nonzero(self.matrix)) if self.like is None else self.like.count

    @cached_property
    def symbols(self) -> frozenset[Any]:
        """All symbols on which the product depends."""
        return frozenset().union(*set(map(_symbols_of, self.factors)))

    @cached_property
    def places(self) -> dict[Expr, list[int]]:
        """The columns of the factors in which each symbol is."""
        places: dict[Expr, list[int]] = {}
        for j, factor in enumerate(self.factors):
            for one in factor.free_symbols:
                places.setdefault(one, []).append(j)
        return places

    def rows(self) -> list[Expr]:
        """The rows as expressions; one with a single term is this term."""
        return [self.row(i) for i in range(len(self.matrix))]

    def row(self, i: int) -> Expr:
        """A row as an expression."""
        if np.count_nonzero(self.matrix[i]) > 1:
            return MatrixRow(self, i)
        return sympy.Add(*(_times(*term) for term in self.terms(i)))

    def terms(self, i: int) -> list[tuple[float, Expr]]:
        """Entries of a row that are not zero, each with its factor."""
        columns = np.flatnonzero(self.matrix[i])
        pairs = zip(self.matrix[i, columns].tolist(), columns.tolist(), strict=True)
        return [(entry, self.factors[j]) for entry, j in pairs]


def matrix_rows(matrix: Any, factors: Sequence[Expr]) -> list[Expr]:
    """The rows of a matrix (rows, factors) times expressions, as expressions."""
    return MatrixProduct(np.array(matrix, dtype=float), tuple(factors)).rows()


def _symbols_of(expr: Expr) -> frozenset[Any]:
    """Its free symbols; those of rows of one product are one object."""
    return expr.product.symbols if isinstance(expr, MatrixRow) else frozenset(expr.free_symbols)


def _times(entry: float, factor: Expr) -> Expr:
    return factor if entry == 1.0 else sympy.Float(float(entry)) * factor


class MatrixRow(sympy.AtomicExpr):
    """A row of a `MatrixProduct`: the sum of its entries times the factors, an atom to sympy."""

    is_commutative = True
    is_real = True
    product: MatrixProduct
    index: int

    def __new__(cls, product: MatrixProduct, index: int) -> MatrixRow:
        row = super().__new__(cls)
        row.product, row.index = product, index
        return row

    def _hashable_content(self) -> tuple[int, int]:
        return self.product.number, self.index

    def sort_key(self, order: Any = None) -> Any:
        """By the product, then by the row: the printed sum would be long."""
        key = self.class_key(), (1, (f"{self.product.number:09d} {self.index:09d}",)), sympy.S.One.sort_key()
        return (*key, sympy.S.One)

    def __getnewargs__(self) -> tuple[Any, ...]:
        return self.product, self.index

    @property
    def free_symbols(self) -> Any:
        """Symbols of all factors of the product."""
        return set(self.product.symbols)

    def terms(self) -> list[tuple[float, Expr]]:
        """Entries that are not zero, each with its factor."""
        return self.product.terms(self.index)

    def _eval_derivative(self, s: Any) -> Expr:
        entries, factors = self.product.matrix[self.index], self.product.factors
        places = [j for j in self.product.places.get(s, ()) if entries[j]]
        return sympy.Add(*(_times(float(entries[j]), sympy.diff(factors[j], s)) for j in places))

    def _eval_derivative_n_times(self, s: Any, n: Any) -> Expr:
        return super(sympy.AtomicExpr, self)._eval_derivative_n_times(s, n)

    def xreplace(self, rule: Any) -> Expr:
        """The row with factors replaced, written out; itself where none is."""
        return self._xreplace(rule)[0]

    def _xreplace(self, rule: Any) -> tuple[Expr, bool]:
        if self in rule:
            return rule[self], True
        if rule and not self.product.symbols.isdisjoint(rule):
            return sympy.Add(*(_times(entry, factor.xreplace(rule)) for entry, factor in self.terms())), True
        return self, False

    def _eval_subs(self, old: Any, new: Any) -> Expr:
        if self.product.symbols.isdisjoint(old.free_symbols):
            return self
        return sympy.Add(*(_times(entry, factor.subs(old, new)) for entry, factor in self.terms()))

    def _sympystr(self, printer: Any) -> str:
        return self._printed(printer)

    def _latex(self, printer: Any) -> str:
        return self._printed(printer)

    def _printed(self, printer: Any) -> str:
        terms = self.terms()
        printed = [printer.doprint(_times(*term)) for term in terms[:MOST_PRINTED]]
        more = [f"({len(terms) - MOST_PRINTED} more terms)"] if len(terms) > MOST_PRINTED else []
        return f"({' + '.join([*printed, *more])})"
