"""Sympy expressions lowered to a tape: a list of operations on numbered slots.

The first slots are the states, every operation writes one more.  There are few operations, each with a
recurrence for Taylor coefficients (:mod:`frictionlab.hybrid.kernels.jets`), and the numbers in them (the
coefficients of affine combinations) are expressions of the parameters alone.  So a tape depends only on the
structure of a model; parameter values are filled in afterwards.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from enum import IntEnum
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from frictionlab.automaton.expressions import integer_exponent, unsorted_product, within_floats
from frictionlab.automaton.mode import Expr
from frictionlab.lazy_names import sympy as sp
from frictionlab.tape.functions import (
    AFFINE,
    ALLOWED_OPERATIONS,
    CONSTANT_TERM,
    FIRST_FUNCTION,
    FUNCTIONS,
    OPERATION_NAMES,
    POWER,
    PRODUCT,
    QUOTIENT,
    RATE,
    SQUARE,
    function_table,
)
from frictionlab.tape.panels import ROWS, panels_of, range_of_columns

AffineTerms = dict[int, Expr]
# Of a product of a matrix: the terms of larger ones, and all of a tape with such a one, are shared by tapes.
MOST_OWN_TERMS = 200
ALIGNMENT = 32  # slots; more make copies of a mode's own factors come later than they must
FIRST_SHARED = 2**31  # terms from this number on are those of products
# What to write in place of functions with corners, whose borders are no events.
IN_PIECES = {"Abs": "absolute", "sign": "sign", "Min": "minimum", "Max": "maximum"}


class TapeError(ValueError):
    """An expression that the tape has no operation for."""


def is_matrix_row(expr: Any) -> bool:
    """Whether an expression is a row of a product of a matrix."""
    return type(expr).__name__ == "MatrixRow"


class Range(IntEnum):
    """How the range of a slot on a disc is found."""

    UNUSED = 0  # no rate, guard or section depends on it
    WHEN_BLIND = 1  # by its operands, but only where the last terms of polynomials do not tell
    OPERATION = 2  # by its operands
    BOTH = 3  # by its operands and by its own series, as terms of a sum may cancel
    SERIES = 4  # by its own series, which is exact


@dataclass(frozen=True, eq=False)
class ProductTerms:
    """The terms of all panels of a product of a matrix, with the slots of its factors on a tape."""

    product: Any  # a MatrixProduct, whose module needs sympy
    slots: Any  # array (columns of all panels,)

    @cached_property
    def distinct(self) -> frozenset[int]:
        """These slots, each once."""
        return frozenset(self.slots.tolist())


@dataclass(eq=False)
class Tape:
    """Operations in the order of their execution.

    ``ops`` holds (kind, a, b): two slots, or for an affine combination the range [a, b) of ``terms``; its
    constant is ``constants[i]``.  A row of one of the ``products`` has every ROWS-th term of [a, b), counted
    from FIRST_SHARED, and the rows of a panel follow each other.  Operation i writes
    slot ``inputs + i``.  A function f(a), and a power
    with the exponent ``constants[i]``, come directly after the rate t a' of their argument; b is the slot of
    f'(a), which may come later, as it is needed only in lower orders.
    """

    inputs: int
    ops: list[tuple[int, int, int]] = field(default_factory=list)
    constants: list[Expr] = field(default_factory=list)
    terms: list[tuple[int, Expr]] = field(default_factory=list)
    products: list[ProductTerms] = field(default_factory=list)

    def slots_of(self, a: int, b: int) -> list[int]:
        """The slots of a range of terms."""
        if a < FIRST_SHARED:
            return [slot for slot, _ in self.terms[a:b]]
        number, first = self._product_of(a)
        columns = range_of_columns(first, first + b - a)
        return self.products[number].slots[slice(*columns)].tolist()

    def _product_of(self, term: int) -> tuple[int, int]:
        """The number of the product with a shared term, and the place of the term in it."""
        place = term - FIRST_SHARED
        for number, one in enumerate(self.products):
            if place < ROWS * len(one.slots):
                return number, place
            place -= ROWS * len(one.slots)
        raise IndexError(f"there is no term number {term}")

    @property
    def slots(self) -> int:
        """Number of slots in use."""
        return self.inputs + len(self.ops)

    def emit(self, kind: int, a: int, b: int, constant: Expr) -> int:
        """Append an operation; returns the slot it writes."""
        self.ops.append((kind, a, b))
        self.constants.append(constant)
        return self.slots - 1

    def degrees(self) -> list[float]:
        """Degree of each slot as a polynomial of the states; infinite where it is not one."""
        degrees, of_products = [1.0] * self.inputs, dict[int, float]()
        for kind, a, b in self.ops:
            if kind == AFFINE and a >= FIRST_SHARED:
                number, _ = self._product_of(a)
                if number not in of_products:
                    of_products[number] = max(degrees[slot] for slot in self.products[number].distinct)
                degrees.append(of_products[number])
            elif kind == AFFINE:
                degrees.append(max([0.0, *(degrees[slot] for slot in self.slots_of(a, b))]))
            elif kind in (PRODUCT, SQUARE):
                degrees.append(degrees[a] + degrees[b])
            elif kind == RATE:
                degrees.append(1.0)
            else:
                degrees.append(math.inf)
        return degrees

    def operands(self, op: int) -> list[int]:
        """Operands of an operation, as slots; none for a rate, which belongs to the next operation."""
        kind, a, b = self.ops[op]
        if kind == AFFINE:
            return self.slots_of(a, b)
        if kind == RATE:
            return []
        return [a, b] if kind in (PRODUCT, SQUARE, QUOTIENT) else [a]

    def ranges(self, outputs: Sequence[int], degrees: Sequence[float]) -> list[Range]:
        """How the range of each slot on a disc is found, where `outputs` are asked for their remainders.

        Remainders of polynomials show in the last terms of their series.  So slots that serve only
        polynomials need no range, unless these terms do not tell (WHEN_BLIND).
        """
        if max(degrees) < math.inf:
            needed = self._needed(outputs)
            return [Range.WHEN_BLIND if slot in needed else Range.UNUSED for slot in range(self.slots)]
        linear = self._linear()
        curved, needed = {slot for slot in outputs if degrees[slot] == math.inf}, set[int]()
        all_needed, factors = set(outputs), set[int]()
        for op in reversed(range(len(self.ops))):
            slot, operands, affine = self.inputs + op, self.operands(op), self.ops[op][0] == AFFINE
            if slot in all_needed:
                all_needed.update(operands)
            if slot in curved or (slot in needed and slot not in linear):
                curved.update(each for each in operands if degrees[each] == math.inf)
                if slot in needed or not affine:
                    needed.update(operands)
                if not affine:
                    factors.update(operands)
        by_series, by_both, by_operands = needed & linear, needed & factors, needed | curved
        return [
            Range.SERIES
            if slot in by_series
            else Range.BOTH
            if slot in by_both and self._is_affine(slot)
            else Range.OPERATION
            if slot in by_operands
            else Range.WHEN_BLIND
            if slot in all_needed
            else Range.UNUSED
            for slot in range(self.slots)
        ]

    def _needed(self, outputs: Sequence[int]) -> set[int]:
        """The slots that serve an output."""
        needed = set(outputs)
        for op in reversed(range(len(self.ops))):
            if self.inputs + op in needed:
                needed.update(self.operands(op))
        return needed

    def _linear(self) -> set[int]:
        """States, and their affine combinations: their series are exact."""
        linear = set(range(self.inputs))
        for op in range(len(self.ops)):
            if self.ops[op][0] == AFFINE and linear.issuperset(self.operands(op)):
                linear.add(self.inputs + op)
        return linear

    def _is_affine(self, slot: int) -> bool:
        return slot >= self.inputs and self.ops[slot - self.inputs][0] == AFFINE

    def counts(self) -> dict[str, int]:
        """Number of operations by name."""
        kinds = [op[0] for op in self.ops]
        return {name: kinds.count(kind) for kind, name in OPERATION_NAMES.items()}


class PlacedProduct(NamedTuple):
    """A product of a matrix on a tape: the slots of its factors, and the number of its first shared term."""

    slots: list[int]
    first: int | None  # None where each row has terms of its own


class TapeBuilder:
    """Lowers expressions onto one tape; equal subexpressions share a slot.

    `linear` holds the terms of expressions that are affine in the states; tapes that get the same dict share
    what they find.
    """

    has_corners = False  # whether there are operations for Abs and sign

    def __init__(self, states: Sequence[Any], linear: dict[Expr, AffineTerms] | None = None) -> None:
        self.tape = Tape(len(states))
        self._linear_terms = {} if linear is None else linear
        self._states = {state: i for i, state in enumerate(states)}
        self._affine: dict[Expr, AffineTerms] = {}
        self._slots: dict[object, int] = {}
        self._constants: dict[Expr, bool] = {}
        self._products: dict[Any, PlacedProduct] = {}
        self._shared_terms = 0
        self._has_rows = False

    def with_products(self, products: Iterable[Any]) -> TapeBuilder:
        """A builder of another tape, which begins as this one and has the terms of these products."""
        other = copy(self)
        tape = self.tape
        other.tape = replace(
            tape,
            ops=tape.ops[:],
            constants=tape.constants[:],
            terms=tape.terms[:],
            products=tape.products[:],
        )
        other._affine, other._slots = self._affine.copy(), self._slots.copy()
        other._constants, other._products = self._constants.copy(), self._products.copy()
        for product in products:
            other._products[product] = other._add_product(product)
        return other

    def slot(self, expr: Expr) -> int:
        """Slot that holds `expr`, emitting what is missing."""
        return self._materialise(self._lower(sp.sympify(expr, strict=True)))

    def constant(self, expr: Expr) -> bool:
        """Whether `expr` depends on the parameters alone."""
        is_constant = self._constants.get(expr)
        if (
            is_constant is None
        ):  # what free_symbols tells, which searches a deep expression again for each of its parts
            is_constant = all(map(self.constant, expr.args)) if expr.args else self._stands_still(expr)
            self._constants[expr] = is_constant
        return is_constant

    def _stands_still(self, atom: Expr) -> bool:
        if is_matrix_row(atom):
            self._has_rows = True
            return all(map(self.constant, atom.product.factors))
        return atom not in self._states

    def _lower(self, expr: Expr) -> AffineTerms:
        terms = self._affine.get(expr)
        if terms is None:
            terms = self._linear_terms.get(expr)
            if terms is None:
                terms = self._lower_new(expr)
                if all(slot < self.tape.inputs for slot in terms):
                    self._linear_terms[expr] = terms
            self._affine[expr] = terms
        return terms

    def _lower_new(self, expr: Expr) -> AffineTerms:
        if self.constant(expr):
            return {CONSTANT_TERM: expr} if expr != 0 else {}
        if expr in self._states:
            return {self._states[expr]: sp.S.One}
        if is_matrix_row(expr):
            return self._row(expr)
        if expr.is_Add:
            return _total([self._term(arg) for arg in self._with_common_bases(expr.args)])
        if expr.is_Mul:
            return self._mul(expr)
        if expr.is_Pow and expr.base.func is sp.Abs and self.constant(expr.exp) and not self.has_corners:
            return self._power_of_size(expr.base.args[0], expr.exp)
        if expr.is_Pow and (exponent := integer_exponent(expr)) is not None:
            return {self._power(expr.base, exponent) if exponent else CONSTANT_TERM: sp.S.One}
        if expr.is_Pow and self.constant(expr.exp):
            return {self._after_rate(POWER, self.slot(expr.base), expr.exp): sp.S.One}
        if expr.func in function_table():
            return self._function(expr)
        raise TapeError(f"the tape has no operation for {expr}: {_cure(expr)}")

    def _row(self, row: Any) -> AffineTerms:
        """A row of a product of a matrix: an operation, or one of those of a panel."""
        product = row.product
        if product not in self._products:
            self._products[product] = self._add_product(product)
        slots, first = self._products[product]
        if first is None:
            entries = product.matrix[row.index]
            return {self._sum_of((slots[j], float(entries[j])) for j in np.flatnonzero(entries)): sp.S.One}
        number, place = divmod(row.index, ROWS)
        if (product, number) not in self._slots:
            self._slots[product, number] = self._emit_panel(product, number, first)
        return {self._slots[product, number] + place: sp.S.One}

    def _sum_of(self, terms: Iterable[tuple[int, float]]) -> int:
        first = len(self.tape.terms)
        self.tape.terms.extend(terms)
        return self.tape.emit(AFFINE, first, len(self.tape.terms), self.number(0))

    def _emit_panel(self, product: Any, number: int, first: int) -> int:
        """Emit all rows of a panel; the slot of the first."""
        start, end = (first + ROWS * column for column in panels_of(product).starts[number : number + 2])
        rows = range(min(ROWS, len(product.matrix) - ROWS * number))
        slots = [self.tape.emit(AFFINE, start + row, end, self.number(0)) for row in rows]
        return slots[0]

    def _add_product(self, product: Any) -> PlacedProduct:
        """Add the factors of a product to the tape, and its terms where tapes share them."""
        slots, terms = [self.slot(within_floats(factor)) for factor in product.factors], product.count
        if product.own and terms > MOST_OWN_TERMS:
            first = len(slots) - product.own
            slots = [*slots[:first], *self._aligned(slots[first:])]
        if terms <= MOST_OWN_TERMS and not self.tape.products:
            return PlacedProduct(slots, None)
        of_columns = np.array(slots, dtype=np.uint32)[panels_of(product).columns]
        first, self._shared_terms = (
            FIRST_SHARED + self._shared_terms,
            self._shared_terms + ROWS * len(of_columns),
        )
        self.tape.products.append(ProductTerms(product, of_columns))
        return PlacedProduct(slots, first)

    def _aligned(self, slots: Sequence[int]) -> list[int]:
        """Copies of slots from a multiple of ALIGNMENT on: mostly there on the tapes of other modes too, so
        that a product has the same terms."""
        tape = self.tape
        while tape.slots % ALIGNMENT:
            tape.emit(AFFINE, 0, 0, self.number(0))
        return [self._sum_of([(slot, 1.0)]) for slot in slots]

    def _power_of_size(self, expr: Expr, exponent: Expr) -> AffineTerms:
        """|a|^p as the power p/2 of the square of a, which is not negative."""
        if exponent.is_even:
            return self._lower(expr**exponent)
        a = self.slot(expr)
        return {self._after_rate(POWER, self._binary(SQUARE, a, a), exponent / 2): sp.S.One}

    def _function(self, expr: Expr) -> AffineTerms:
        kind = function_table()[expr.func].kind
        return {self.function(kind, self.slot(expr.args[0])): sp.S.One}

    def function(self, kind: int, a: int) -> int:
        """Slot of a function of another slot; its slope comes after it, as it may contain the function."""
        if (kind, a) not in self._slots:
            place = self._slots[kind, a] = self._after_rate(kind, a)
            slope = self._materialise(FUNCTIONS[kind - FIRST_FUNCTION].slope(self, a, place))
            self.tape.ops[place - self.tape.inputs] = kind, a, slope
        return self._slots[kind, a]

    def product(self, a: int, b: int) -> int:
        """Slot of a product."""
        return self._binary(PRODUCT, *sorted((a, b)))

    def inverse(self, terms: AffineTerms) -> int:
        """Slot of 1 over a combination."""
        return self._binary(QUOTIENT, self._materialise({CONSTANT_TERM: 1}), self._materialise(terms))

    def power(self, terms: AffineTerms, exponent: float) -> int:
        """Slot of a power of a combination."""
        return self._after_rate(POWER, self._materialise(terms), exponent)

    def number(self, expr: Expr) -> Any:
        """A number as the tape holds it: an expression of the parameters."""
        return sp.S.Zero if type(expr) is int and expr == 0 else sp.sympify(expr, strict=True)

    def _after_rate(self, kind: int, a: int, constant: Expr = 0) -> int:
        self.tape.emit(RATE, a, a, self.number(0))
        return self.tape.emit(kind, a, a, self.number(constant))

    def _term(self, expr: Expr) -> AffineTerms:
        """A summand: a multiple of a non-linear sum refers to its slot instead of copying its terms."""
        factor, rest = self._factored(expr)
        if rest.is_Add and factor != 1 and not self._linear(rest):
            return {self.slot(rest): factor}
        return self._lower(expr)

    def _with_common_bases(self, summands: Sequence[Expr]) -> Sequence[Expr]:
        """Summands, with k d + c d^3 as d (k + c d^2) where d is a sum.

        Then a force that occurs in several sums is a slot, of which each has one term, whatever its sign is.
        """
        parts = (part for one in summands for part in sp.Mul.make_args(one))
        if not any(isinstance(part, sp.Pow) and part.base.is_Add for part in parts):
            return summands
        others, groups = list(summands), dict[Expr, list[tuple[Expr, Expr, Expr]]]()
        for one in summands:
            factor, rest = self._factored(one)
            base, exponent = rest.as_base_exp()
            if base.is_Add and exponent.is_Integer and exponent > 0:
                groups.setdefault(base, []).append((exponent, factor, one))
        for base, powers in groups.items():
            if len(powers) > 1:
                others = [one for one in others if all(one is not of for *_, of in powers)]
                others.append(_factored_power(base, [(exponent, factor) for exponent, factor, _ in powers]))
        return others

    def _factored(self, expr: Expr) -> tuple[Expr, Expr]:
        """The factors that depend on the parameters alone, and the rest."""
        if expr in self._states or is_matrix_row(expr):
            return sp.S.One, expr
        moving = [f for f in expr.args if not self.constant(f)] if expr.is_Mul else ()
        if len(moving) == 1 and (moving[0] in self._states or is_matrix_row(moving[0])):
            return unsorted_product([f for f in expr.args if f is not moving[0]]), moving[0]
        if self._has_rows:  # to sympy rows are atoms of their own
            fixed = [f for f in expr.args if self.constant(f)] if expr.is_Mul else []
            rest = [f for f in expr.args if f not in fixed] if fixed else [expr]
            return unsorted_product(fixed), unsorted_product(rest)
        return expr.as_independent(*self._states, as_Add=False)

    def _linear(self, expr: Expr) -> bool:
        return all(slot < self.tape.inputs for slot in self._lower(expr))

    def _mul(self, expr: Expr) -> AffineTerms:
        factor, rest = self._factored(expr)
        factors: Any = sp.Mul.make_args(rest)
        if not self.has_corners:
            for total in (f for f in factors if _has_corners_at_zeros_of(f, factors)):
                others = [f for f in sp.Mul.make_args(expr) if f is not total]
                return self._lower(sp.Add(*(sp.Mul(*others, term) for term in total.args)))
            factors = _with_powers_of_sizes(factors)
        if len(factors) == 1:
            terms = self._lower(factors[0]).items()
            return {slot: factor if value is sp.S.One else factor * value for slot, value in terms}
        below = [f for f in factors if f.is_Pow and (integer_exponent(f) or 0) < 0]
        above = [f for f in factors if f not in below]
        slot = self._product(above) if above else self.slot(sp.S.One)
        if below:
            slot = self._binary(QUOTIENT, slot, self._product([1 / f for f in below]))
        return {slot: factor}

    def _product(self, factors: Sequence[Expr]) -> int:
        slots = [self.slot(f) for f in factors]
        result = slots[0]
        for other in slots[1:]:
            result = self.product(result, other)
        return result

    def _power(self, base: Expr, exponent: int) -> int:
        if exponent < 0:
            return self._binary(QUOTIENT, self.slot(sp.S.One), self._power(base, -exponent))
        if exponent == 1:
            return self.slot(base)
        half = self._power(base, exponent // 2)
        square = self._binary(SQUARE, half, half)
        return square if exponent % 2 == 0 else self.product(self.slot(base), square)

    def _binary(self, kind: int, a: int, b: int) -> int:
        if a == b and kind == PRODUCT:
            kind = SQUARE
        key = (kind, a, b)
        if key not in self._slots:
            self._slots[key] = self.tape.emit(kind, a, b, self.number(0))
        return self._slots[key]

    def _materialise(self, combination: AffineTerms) -> int:
        if len(combination) == 1:
            ((slot, factor),) = combination.items()
            if slot != CONSTANT_TERM and factor == 1:
                return slot
        key = frozenset(combination.items())
        if key not in self._slots:
            terms = self.tape.terms
            first = len(terms)
            # By slot: the sum need not wait for the slot that is computed last.
            ordered = sorted(slot for slot in combination if slot != CONSTANT_TERM)
            terms.extend((slot, self.number(combination[slot])) for slot in ordered)
            constant = self.number(combination.get(CONSTANT_TERM, 0))
            self._slots[key] = self.tape.emit(AFFINE, first, len(terms), constant)
        return self._slots[key]


class ResetBuilder(TapeBuilder):
    """Lowers resets, of which only values are needed, no series: they may have corners (Abs)."""

    def _lower_new(self, expr: Expr) -> AffineTerms:
        if expr.func is sp.Abs:
            slot = self.slot(expr.args[0])
            return {self._after_rate(POWER, self._binary(SQUARE, slot, slot), sp.Rational(1, 2)): sp.S.One}
        return super()._lower_new(expr)


def _cure(expr: Expr) -> str:
    name = expr.func.__name__
    if name in IN_PIECES:
        return f"write fl.functions.{IN_PIECES[name]}, whose borders are events of the motion"
    if name in ("Piecewise", "Heaviside"):
        return "write fl.functions.piecewise(x, borders, values), whose borders are events of the motion"
    return f"write it with {ALLOWED_OPERATIONS}"


def _with_powers_of_sizes(factors: Sequence[Expr]) -> Sequence[Expr]:
    """The factors of a product; |a| or sign(a) beside a power of a or of |a| becomes a power of |a|.

    sympy writes |a|^3 as a^2 |a|, its slope as a^2 sign(a) + 2 a |a|, that of |a|^p as p sign(a) |a|^(p - 1).
    """
    for corner in filter(_is_corner, factors):
        a, order = corner.args[0], int(corner.func is sp.Abs)
        size = sp.Abs(a)
        for other in (f for f in factors if f is not corner):
            base, exponent = other.as_base_exp()
            rest = [f for f in factors if f is not corner and f is not other]
            if base == size:
                return _with_powers_of_sizes([*rest, a, _power_of(size, exponent - 1)])
            odd = (exponent + 1 - order) % 2 if exponent.is_Integer and exponent > 0 else None
            if odd is not None and exponent + order > 1 and (ratio := _ratio(base, a)):
                power = _power_of(size, exponent + order - odd)
                return [*rest, *[ratio**exponent] * (ratio != 1), *[a] * odd, power]
    return factors


def _power_of(size: Expr, exponent: Expr) -> Expr:
    """|a|^p, also where sympy would write another product for it."""
    return sp.Pow(size, exponent, evaluate=False)


def _ratio(one: Expr, other: Expr) -> Any:
    """The number by which one expression is a multiple of another; zero if it is none."""
    (first, a), (second, b) = one.as_content_primitive(), other.as_content_primitive()
    return first / second if a == b else -first / second if a == -b else 0


def _has_corners_at_zeros_of(expr: Expr, factors: Sequence[Expr]) -> bool:
    """Whether an expression is a sum with |a| or sign(a), and a is one of the factors."""
    terms = expr.args if expr.is_Add else ()
    corners = [f.args[0] for term in terms for f in sp.Mul.make_args(term) if _is_corner(f)]
    return any(_ratio(f.as_base_exp()[0], a) for a in corners for f in factors)


def _is_corner(expr: Expr) -> bool:
    return expr.func in (sp.Abs, sp.sign)


def _factored_power(base: Expr, powers: Sequence[tuple[Expr, Expr]]) -> Expr:
    """A sum of powers (exponent, factor) of a base, as the lowest one times a sum with a positive first."""
    least, first = min(powers, key=lambda power: power[0])
    sign = -1 if first.could_extract_minus_sign() else 1
    rest = sp.Add(*(sign * factor * base ** (exponent - least) for exponent, factor in powers))
    return sign * (base**least * rest)


def _total(parts: Sequence[AffineTerms]) -> AffineTerms:
    total: AffineTerms = {}
    for part in parts:
        for slot, value in part.items():
            total[slot] = total[slot] + value if slot in total else value
    return {slot: value for slot, value in total.items() if value != 0}
