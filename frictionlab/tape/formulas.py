"""Expressions as functions of numbers, arrays and intervals, with their derivatives.

`Formulas` are a tape whose inputs are all symbols, states and parameters alike, and whose coefficients are
numbers.  Rates, event functions, outputs, statics, energies and the numbers in the tapes of modes are
evaluated by it.  Its operations are those of the kernels and a few more, such as |a| and the greater of two.

Derivatives are formulas again: each operation is differentiated into further operations (forward mode,
A. Griewank and A. Walther, "Evaluating Derivatives", SIAM 2008).  So Jacobians, derivatives along directions
and those of any order need no sympy, and what is kept of a structure for later processes is the tape alone.

Three arithmetics evaluate the same tape:

`NUMBERS`
    Single numbers, the same to the last bit on every machine.
`ARRAYS`
    numpy's functions, for arrays, complex numbers and intervals.  A power of a negative number
    is NaN.
`ALONG_RUNS`
    As `ARRAYS`, by the kernels' rule for powers: a base that rounding has made negative counts as zero.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache, reduce
from itertools import product
from typing import Any, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from frictionlab.automaton.expressions import integer_exponent, unsorted_product, within_floats
from frictionlab.lazy_names import sympy as sp
from frictionlab.tape.elementary import exponentials, trigonometry
from frictionlab.tape.functions import (
    AFFINE,
    CONSTANT_TERM,
    FUNCTIONS,
    LOG,
    POWER,
    PRODUCT,
    QUOTIENT,
    SQUARE,
    Function,
)
from frictionlab.tape.intervals import Interval, crosses_negative_axis, interval, select
from frictionlab.tape.tape import AffineTerms, Tape, TapeBuilder, TapeError

# Operations that only formulas have, as kernels have no series of them.
FIRST_OF_FORMULAS = 64
INTEGER_POWER, REAL_POWER, ABS, SIGN, FLOOR, CEILING = range(FIRST_OF_FORMULAS, FIRST_OF_FORMULAS + 6)
ASIN, ACOS, ACOSH, ATANH, ATAN2 = range(CEILING + 1, CEILING + 6)
MAXIMUM, MINIMUM, LESS, LESS_OR_EQUAL, EQUAL, AND, OR, NOT, SELECT = range(ATAN2 + 1, ATAN2 + 10)
STEP = SELECT + 1

Data = dict[str, Any]
Step = Callable[[list[Any]], Any]  # an operation, of the values so far
Derivative = dict[int, AffineTerms]  # of a slot: by number of the direction, as a combination of slots


class Arithmetic(NamedTuple):
    """What evaluates formulas: functions of one and of two values by their operations.

    Parameters
    ----------
    name : str
    functions : mapping of int to callable
    select : callable
        Of a condition and two values.
    """

    name: str
    functions: Mapping[int, Callable[..., Any]]
    select: Callable[[Any, Any, Any], Any]


def _quotient(a: float, b: float) -> float:
    return a / b if b else math.nan


def integer_power(x: float, n: float) -> float:
    """x^n by repeated squaring; the squares are multiplied from the lowest power to the highest."""
    value, square, count = 1.0, float(x), abs(int(n))
    while count:
        if count % 2:
            value *= square
        square *= square
        count //= 2
    return value if n >= 0 else _quotient(1.0, value)


def real_power(x: float, y: float) -> float:
    """x^y; a product where y is an integer, by a square root where it is a half or minus a half."""
    if float(y).is_integer():
        return integer_power(x, y)
    if abs(y) == 0.5:
        root = math.sqrt(x) if x >= 0.0 else math.nan
        return root if y > 0.0 else _quotient(1.0, root)
    return exponentials.power(float(x), float(y))


def _of_float(function: Callable[[float], float]) -> Callable[[float], float]:
    return lambda x: function(float(x))  # an integer would be another signature of the kernel


def _sign(x: float) -> float:
    return math.copysign(1.0, x) if x else 0.0


def _of_square(sign: int, constant: int, root: bool, factor: int = 1) -> Callable[..., Any]:
    """A slope `factor`/(constant + sign a^2), or over the root of this."""

    def slope(make: Any, a: int, y: int) -> dict[int, Any]:
        inner = {make.product(a, a): sign, CONSTANT_TERM: constant}
        return {make.power(inner, -0.5) if root else make.inverse(inner): factor}

    return slope


def _flat(*_: Any) -> dict[int, Any]:
    return {}


# Functions of one argument that only formulas have, as kernels have no series of them.
INVERSE_FUNCTIONS = (
    Function(ASIN, "asin", trigonometry.asin, np.arcsin, _of_square(-1, 1, True)),
    Function(ACOS, "acos", trigonometry.acos, np.arccos, _of_square(-1, 1, True, -1)),
    Function(ACOSH, "acosh", exponentials.acosh, np.arccosh, _of_square(1, -1, True)),
    Function(ATANH, "atanh", exponentials.atanh, np.arctanh, _of_square(-1, 1, False)),
)
OTHER_FUNCTIONS = (
    *INVERSE_FUNCTIONS,
    Function(ABS, "Abs", abs, np.abs, lambda make, a, y: {make.function(SIGN, a): 1}),
    Function(SIGN, "sign", _sign, np.sign, _flat),
    Function(FLOOR, "floor", lambda x: float(np.floor(x)), np.floor, _flat),
    Function(CEILING, "ceiling", lambda x: float(np.ceil(x)), np.ceil, _flat),
    Function(STEP, "Heaviside", lambda x: 0.5 * (1.0 + _sign(x)), lambda x: np.heaviside(x, 0.5), _flat),
    Function(NOT, "Not", operator.not_, np.logical_not, _flat),
)
FUNCTIONS_BY_KIND = {function.kind: function for function in (*FUNCTIONS, *OTHER_FUNCTIONS)}
# Functions of one number that kernels compute, the same to the last bit on every machine.
ELEMENTARY = {function.kind: function.value for function in (*FUNCTIONS, *INVERSE_FUNCTIONS)}

NUMBERS = Arithmetic(
    "numbers",
    {
        **{kind: _of_float(function.value) for kind, function in FUNCTIONS_BY_KIND.items()},
        NOT: operator.not_,
        ATAN2: math.atan2,
        QUOTIENT: _quotient,
        INTEGER_POWER: integer_power,
        POWER: real_power,
        REAL_POWER: real_power,
        MAXIMUM: max,
        MINIMUM: min,
        LESS: operator.lt,
        LESS_OR_EQUAL: operator.le,
        EQUAL: operator.eq,
        AND: lambda a, b: a and b,
        OR: lambda a, b: a or b,
    },
    lambda condition, a, b: a if condition else b,
)


def nonnegative_power(base: Any, exponent: Any) -> Any:
    """A power whose base counts as zero where it is negative, as rounding may make it: penetration^1.5 at a
    penetration of -1e-18 m."""
    with np.errstate(divide="ignore"):
        return np.maximum(base, 0.0) ** exponent


ARRAYS = Arithmetic(
    "arrays",
    {
        **{kind: function.array for kind, function in FUNCTIONS_BY_KIND.items()},
        ATAN2: np.arctan2,
        QUOTIENT: operator.truediv,
        INTEGER_POWER: operator.pow,
        POWER: lambda x, y: np.sqrt(x) if y == 0.5 else _array_power(x, y),
        REAL_POWER: lambda x, y: _array_power(x, y),
        MAXIMUM: np.maximum,
        MINIMUM: np.minimum,
        LESS: np.less,
        LESS_OR_EQUAL: np.less_equal,
        EQUAL: np.equal,
        AND: np.logical_and,
        OR: np.logical_or,
    },
    select,
)
ALONG_RUNS = Arithmetic(
    "along runs",
    {**ARRAYS.functions, POWER: nonnegative_power, REAL_POWER: nonnegative_power},
    select,
)


def _array_power(x: Any, y: Any) -> Any:
    """x^y; of a negative float Python would give a complex number."""
    return np.float64(x) ** y if isinstance(x, float) else x**y


class FormulaBuilder(TapeBuilder):
    """Lowers expressions of symbols onto the tape of formulas; its coefficients are floats."""

    has_corners = True

    def number(self, expr: Any) -> float:
        """A number as the tape holds it."""
        if isinstance(expr, (int, float)):
            return float(expr)
        exact = sp.sympify(expr, strict=True)
        if exact.is_Rational or exact.is_Float:
            return float(exact)
        if exact.free_symbols:
            raise TapeError(f"formulas are of {', '.join(map(str, self._states))}, got {exact}")
        try:
            return float(exact.evalf(30))
        except TypeError:
            return math.nan  # of zoo and nan; an error says so where the value is asked for

    def _factored(self, expr: Any) -> tuple[Any, Any]:
        """The number in front of a product, and the rest."""
        fixed = [f for f in expr.args if self.constant(f)] if expr.is_Mul else []
        if not fixed:
            return sp.S.One, expr
        return unsorted_product(fixed), unsorted_product([f for f in expr.args if not self.constant(f)])

    def _after_rate(self, kind: int, a: int, constant: Any = 0) -> int:
        return self.operation(kind, a, a, self.number(constant))

    def operation(self, kind: int, a: int, b: int, constant: float = 0.0) -> int:
        """Slot of an operation, emitted if it is not there."""
        key = kind, a, b, constant
        if key not in self._slots:
            self._slots[key] = self.tape.emit(kind, a, b, constant)
        return self._slots[key]

    def _binary(self, kind: int, a: int, b: int) -> int:
        return self.operation(SQUARE if a == b and kind == PRODUCT else kind, a, b)

    def materialised(self, terms: AffineTerms) -> int:
        """Slot of a combination of numbers times slots."""
        return self._materialise({slot: float(c) for slot, c in terms.items()})

    def _materialise(self, combination: AffineTerms) -> int:
        """Slot of a combination; terms keep their order, so that a number does not depend on others."""
        numbers = {slot: self.number(c) for slot, c in combination.items()}
        constant = numbers.pop(CONSTANT_TERM, 0.0)
        if not constant and [*numbers.values()] == [1.0]:
            return next(iter(numbers))
        key = (*numbers.items(), constant)
        if key not in self._slots:
            first = len(self.tape.terms)
            self.tape.terms.extend(numbers.items())
            self._slots[key] = self.tape.emit(AFFINE, first, len(self.tape.terms), constant)
        return self._slots[key]

    def _row(self, row: Any) -> AffineTerms:
        """A row of a product of a matrix, as a combination: formulas hold but what they need."""
        total: AffineTerms = {}
        for entry, factor in row.terms():
            for slot, number in self._lower(factor).items():
                total[slot] = total.get(slot, 0.0) + entry * number
        return total

    def _power(self, base: Any, exponent: int) -> int:
        slot = self.slot(base)
        return slot if exponent == 1 else self.operation(INTEGER_POWER, slot, slot, float(exponent))

    def _lower_new(self, expr: Any) -> AffineTerms:
        if expr.is_Pow and not self.constant(expr.exp) and integer_exponent(expr) is None:
            return {self.operation(REAL_POWER, self.slot(expr.base), self.slot(expr.exp)): sp.S.One}
        if not self.constant(expr):
            function = _functions_of_formulas().get(expr.func)
            if function is not None:
                return {self._fold(function, [self.slot(arg) for arg in expr.args]): sp.S.One}
            if expr.func is sp.Piecewise:
                return {self._piecewise(expr.args): sp.S.One}
            if expr.func.__name__ == "Pieces":  # of laws in pieces, if there are any
                return {self._pieces(expr): sp.S.One}
            if expr.func in (sp.Gt, sp.Ge):
                return self._lower(expr.reversed)
            if expr.func is sp.Ne:
                return self._lower(sp.Not(sp.Eq(*expr.args), evaluate=False))
        elif expr in (sp.true, sp.false):
            return {CONSTANT_TERM: sp.Integer(int(expr == sp.true))}
        return super()._lower_new(expr)

    def function(self, kind: int, a: int) -> int:
        """Slot of a function of another slot."""
        return self.operation(kind, a, a)

    def _fold(self, kind: int, slots: Sequence[int]) -> int:
        """The function of one or two slots; of more, such as the greatest of three, one after the other."""
        first, *others = slots
        if not others:
            return self.operation(kind, first, first)
        for other in others:
            first = self.operation(kind, first, other)
        return first

    def _piecewise(self, pairs: Sequence[Any]) -> int:
        value = self.slot(sp.nan)
        for each, condition in reversed(pairs):
            first = self.slot(each)
            value = first if condition == sp.true else self.select(self.slot(condition), first, value)
        return value

    def _pieces(self, expr: Any) -> int:
        x, (*below, value) = self.slot(expr.x), map(self.slot, expr.values)
        for border, first in zip(reversed(expr.borders), reversed(below), strict=True):
            value = self.select(self.operation(LESS, x, self.slot(border)), first, value)
        return value

    def select(self, condition: int, a: int, b: int) -> int:
        """Slot of a value where a condition holds, of another elsewhere; the condition is the number."""
        return self.operation(SELECT, a, b, float(condition))


@lru_cache(maxsize=1)
def _functions_of_formulas() -> dict[Any, int]:
    """Operations of formulas alone by their sympy functions."""
    of_several = {
        sp.atan2: ATAN2,
        sp.Max: MAXIMUM,
        sp.Min: MINIMUM,
        sp.Lt: LESS,
        sp.Le: LESS_OR_EQUAL,
        sp.Eq: EQUAL,
        sp.And: AND,
        sp.Or: OR,
    }
    return {function.expression: function.kind for function in OTHER_FUNCTIONS} | of_several


COMPARISONS = frozenset({LESS, LESS_OR_EQUAL, EQUAL, AND, OR})  # of zero derivative
# Operations that jump: their derivatives do not tell of it.
JUMPS = frozenset({LESS, LESS_OR_EQUAL, EQUAL, SIGN, FLOOR, CEILING, STEP, ATAN2})
AT_JUMPS = {SIGN: 0.0, STEP: 0.5}  # values of those that have one of their own there
MOST_BRANCHES = 64  # with more, steps that come late count as unknown


@dataclass(frozen=True, eq=False)
class Formulas:
    """Functions of the same inputs, evaluated together.

    Parameters
    ----------
    tape : Tape
        Its coefficients are floats.
    outputs : tuple of int
        The slot of each function.

    Examples
    --------
    >>> import sympy
    >>> k, m = sympy.symbols("k m")
    >>> made = formulas_of([k, m], [sympy.sqrt(k / m), m**3])
    >>> made.numbers(8.0, 2.0)
    array([2., 8.])
    >>> places, slopes = made.jacobian()
    >>> places, slopes.numbers(8.0, 2.0).tolist()
    ([(0, 0), (0, 1), (1, 1)], [0.125, -0.5, 12.0])
    """

    tape: Tape
    outputs: tuple[int, ...]

    def fixed(self, i: int) -> float | None:
        """The value of a function that is the same number for all inputs; None of any other function."""
        op = self.outputs[i] - self.tape.inputs
        kind, a, b = self.tape.ops[op] if op >= 0 else (SELECT, 0, 0)
        return self.tape.constants[op] if kind == AFFINE and a == b else None

    def numbers(self, *inputs: float) -> NDArray[np.float64]:
        """The values at single numbers, the same to the last bit on every machine.

        What has no real value is NaN.
        """
        slots, places = self._distinct_outputs
        values = self._values(self._number_steps, inputs)
        return np.array([values[slot] for slot in slots], dtype=float)[places]

    def arrays(self, *inputs: Any) -> list[Any]:
        """The values at arrays, complex numbers and intervals."""
        values = self._values(self._array_steps, inputs)
        return [values[slot] for slot in self.outputs]

    def along_run(self, *inputs: Any) -> list[Any]:
        """The values at states of a run: the base of a power counts as zero where it is negative."""
        values = self._values(self._run_steps, inputs)
        return [values[slot] for slot in self.outputs]

    def _values(self, steps: Sequence[tuple[int, Step]], inputs: Sequence[Any]) -> list[Any]:
        if len(inputs) != self.tape.inputs:
            raise TypeError(f"{self.tape.inputs} values are needed, got {len(inputs)}")
        values = [*inputs, *[None] * len(self.tape.ops)]
        for slot, step in steps:
            values[slot] = step(values)
        return values

    @cached_property
    def _distinct_outputs(self) -> tuple[list[int], NDArray[np.intp]]:
        """The slots of outputs, each once, and for each output its place among them."""
        slots, places = np.unique(np.array(self.outputs, dtype=np.intp), return_inverse=True)
        return slots.tolist(), places

    @cached_property
    def _number_steps(self) -> list[tuple[int, Step]]:
        return _steps(self.tape, NUMBERS, self.needed)

    @cached_property
    def _array_steps(self) -> list[tuple[int, Step]]:
        return _steps(self.tape, ARRAYS, self.needed)

    @cached_property
    def _run_steps(self) -> list[tuple[int, Step]]:
        return _steps(self.tape, ALONG_RUNS, self.needed)

    @cached_property
    def needed(self) -> tuple[int, ...]:
        """The operations on which an output depends, in order."""
        needed = {*self.outputs}
        for i in reversed(range(len(self.tape.ops))):
            if self.tape.inputs + i in needed:
                needed.update(operands(self.tape, i))
        return tuple(sorted(slot - self.tape.inputs for slot in needed if slot >= self.tape.inputs))

    @cached_property
    def dependences(self) -> list[frozenset[int]]:
        """For each function the inputs on which it depends."""
        of_slots = self._dependences_of_slots
        return [of_slots[slot] for slot in self.outputs]

    def moved_by(self, place: int, *inputs: Any) -> list[Any]:
        """Whether each function depends on one input, for numbers or arrays of others; None is any number.

        What is multiplied by zero is zero.
        """
        values: list[Any] = [None if one is None else np.asarray(one, float)[()] for one in inputs]
        zero: list[Any] = [False if one is None else one == 0.0 for one in values]
        moved: list[Any] = [slot == place for slot in range(len(inputs))]
        with np.errstate(all="ignore"):
            for i, (kind, a, b) in enumerate(self.tape.ops):
                takes = operands(self.tape, i)
                value: Any = None
                if all(values[slot] is not None for slot in takes):
                    value = _step(self.tape, i, ARRAYS)(values)
                    zero.append(np.equal(value, 0.0))
                elif kind == AFFINE:
                    terms = reduce(np.logical_and, [zero[slot] for slot in takes])
                    zero.append(np.logical_and(terms, self.tape.constants[i] == 0.0))
                else:
                    factors = {PRODUCT: (a, b), SQUARE: (a,), QUOTIENT: (a,)}.get(kind, ())
                    zero.append(reduce(np.logical_or, [zero[slot] for slot in factors], False))
                depends = reduce(np.logical_or, [moved[slot] for slot in takes], False)
                moved.append(np.logical_and(depends, np.logical_not(zero[-1])))
                values.append(np.float64(0.0) if np.all(zero[-1]) else value)
        return [moved[slot] for slot in self.outputs]

    @cached_property
    def step_dependences(self) -> list[frozenset[int]]:
        """For each function the inputs on which steps in it depend: signs, whole parts, conditions."""
        of_slots = self._dependences_of_slots
        return [frozenset().union(*(of_slots[slot] for slot in steps)) for steps in self._steps_of_outputs]

    @cached_property
    def _steps_of_outputs(self) -> list[frozenset[int]]:
        """For each function the slots of the steps in it."""
        steps: list[frozenset[int]] = [frozenset()] * self.tape.inputs
        for i, (kind, _, _) in enumerate(self.tape.ops):
            own = {self.tape.inputs + i} if kind in JUMPS else ()
            steps.append(frozenset(own).union(*(steps[slot] for slot in operands(self.tape, i))))
        return [steps[slot] for slot in self.outputs]

    @cached_property
    def _step_slots(self) -> list[int]:
        return sorted(frozenset().union(*self._steps_of_outputs))

    def steps(self, *inputs: Any) -> list[Any]:
        """The values of all steps in the functions: signs, whole parts, conditions."""
        values = self._values(self._array_steps, inputs)
        return [values[slot] for slot in self._step_slots]

    def jumps(self, *inputs: Any) -> dict[tuple[int, int], Any]:
        """By function and input: in which boxes the function may jump along that input; inputs are intervals.

        Functions and inputs along which there are no jumps are left out.
        """
        jumps: dict[tuple[int, int], Any] = {}
        values = self._values(self._array_steps, inputs) if self._step_slots else []
        jumping = {slot: where for slot in self._step_slots if np.any(where := self._may_jump(slot, values))}
        for row, steps in enumerate(self._steps_of_outputs):
            for slot in steps & jumping.keys():
                for column in self._dependences_of_slots[slot]:
                    jumps[row, column] = jumps.get((row, column), False) | jumping[slot]
        return jumps

    def branches(self, *inputs: Any) -> Iterator[list[Any]]:
        """Bounds of the functions in boxes, for each way in which steps may turn out that are open there.

        A step from -1 to 1 is -1, 0 or 1.  So bounds tell that a function has no zero where it jumps past it.
        """
        values = self._values(self._array_steps, inputs) if self._step_slots else []
        waiting: dict[int, int] = {}  # in how many ways each step may turn out
        for slot in self._step_slots:
            kind = self.tape.ops[slot - self.tape.inputs][0]
            ways = 3 if kind in AT_JUMPS else 2
            few = math.prod(waiting.values()) * ways <= MOST_BRANCHES
            if few and kind != ATAN2 and np.any(self._may_jump(slot, values)):
                waiting[slot] = ways
        for ways in product(*map(range, waiting.values())):
            sides = dict(zip(waiting, ways, strict=True))
            values = [*inputs, *[None] * len(self.tape.ops)]
            for slot, step in self._array_steps:
                values[slot] = step(values)
                if slot in sides:
                    kind = self.tape.ops[slot - self.tape.inputs][0]
                    values[slot] = _outcome(kind, interval(values[slot]), sides[slot])
            yield [values[slot] for slot in self.outputs]

    def _may_jump(self, slot: int, values: Sequence[Any]) -> Any:
        """In which boxes a step is not the same everywhere."""
        kind, a, b = self.tape.ops[slot - self.tape.inputs]
        if not isinstance(values[slot], Interval):
            return False
        if kind == ATAN2:
            return crosses_negative_axis(interval(values[a]), interval(values[b]))
        return values[slot].low != values[slot].high

    @cached_property
    def _dependences_of_slots(self) -> list[frozenset[int]]:
        of_slots = [frozenset({i}) for i in range(self.tape.inputs)]
        for i in range(len(self.tape.ops)):
            of_slots.append(frozenset().union(*(of_slots[slot] for slot in operands(self.tape, i))))
        return of_slots

    def is_polynomial_in(self, i: int) -> bool:
        """Whether the functions are polynomials in an input, by their operations."""
        return all(self._keeps_polynomials(op, i) for op in self.needed)

    def _keeps_polynomials(self, op: int, i: int) -> bool:
        """Whether an operation makes polynomials in an input from polynomials in it."""
        (kind, _, b), depends = self.tape.ops[op], self._dependences_of_slots
        if i not in depends[self.tape.inputs + op] or kind in (AFFINE, PRODUCT, SQUARE):
            return True
        if kind == INTEGER_POWER:
            return self.tape.constants[op] > 0.0
        return kind == QUOTIENT and i not in depends[b]

    def jacobian(self, inputs: Sequence[int] | None = None) -> tuple[list[tuple[int, int]], Formulas]:
        """The derivatives that are not zero everywhere: places (function, input), and formulas of the values.

        Parameters
        ----------
        inputs : sequence of int, optional
            Those by which to differentiate; by default all.
        """
        return _jacobian(self, tuple(range(self.tape.inputs) if inputs is None else inputs))

    def along(self, inputs: Sequence[int]) -> Formulas:
        """The derivatives along a direction in some inputs; its components are further inputs, at the end."""
        return _along(self, tuple(inputs))

    def to_data(self) -> Data:
        """The formulas as data that JSON can hold: the operations on which they depend."""
        alone = self._without_others()
        tape = alone.tape
        return {
            "inputs": tape.inputs,
            "ops": [list(op) for op in tape.ops],
            "constants": tape.constants,
            "terms": [list(term) for term in tape.terms],
            "outputs": list(alone.outputs),
        }

    def _without_others(self) -> Formulas:
        """The same formulas on a tape of their own: other formulas may share this one."""
        tape, count = Tape(self.tape.inputs), self.tape.inputs
        places = {slot: slot for slot in range(count)}
        for i in self.needed:
            (kind, a, b), number = self.tape.ops[i], self.tape.constants[i]
            if kind == AFFINE:
                first = len(tape.terms)
                tape.terms.extend((places[slot], factor) for slot, factor in self.tape.terms[a:b])
                op = first, len(tape.terms)
            else:
                op = places[a], places[b]
            operand = float(places[int(number)]) if kind == SELECT else number
            places[count + i] = tape.emit(kind, *op, operand)
        return Formulas(tape, tuple(places[slot] for slot in self.outputs))


@lru_cache(maxsize=256)
def _jacobian(formulas: Formulas, inputs: tuple[int, ...]) -> tuple[list[tuple[int, int]], Formulas]:
    builder = _Differentiation(formulas.tape, {i: {i: {CONSTANT_TERM: 1.0}} for i in inputs})
    rows = [sorted(builder.derivatives[slot].items()) for slot in formulas.outputs]
    places = [(row, column) for row, some in enumerate(rows) for column, _ in some]
    slots = tuple(builder.materialised(terms) for some in rows for _, terms in some)
    return places, Formulas(builder.tape, slots)


@lru_cache(maxsize=256)
def _along(formulas: Formulas, inputs: tuple[int, ...]) -> Formulas:
    count = formulas.tape.inputs
    wider = _with_inputs(formulas.tape, len(inputs))
    seeds: dict[int, Derivative] = {i: {0: {count + k: 1.0}} for k, i in enumerate(inputs)}
    builder = _Differentiation(wider, seeds)
    outputs = (slot if slot < count else slot + len(inputs) for slot in formulas.outputs)
    slots = tuple(builder.materialised(builder.derivatives[slot].get(0, {})) for slot in outputs)
    return Formulas(builder.tape, slots)


def _outcome(kind: int, step: Interval, way: int) -> Interval:
    """One of the values that a step may have: the least, the greatest, and that at the jump itself."""
    low, high = step.low, step.high
    if way == 2:
        middle = np.clip(AT_JUMPS[kind], low, high)
        return Interval(middle, middle)
    one = high - low <= 1.0 if kind in (FLOOR, CEILING) else True  # across many whole numbers it stays open
    return Interval(np.where(one & (way == 1), high, low), np.where(one & (way == 0), low, high))


def formulas_from_data(data: Data) -> Formulas:
    """The formulas from what :meth:`Formulas.to_data` gave."""
    ops = [(kind, a, b) for kind, a, b in data["ops"]]
    terms = [(slot, number) for slot, number in data["terms"]]
    return Formulas(Tape(data["inputs"], ops, list(data["constants"]), terms), tuple(data["outputs"]))


def formulas_of(inputs: Sequence[Any], expressions: Sequence[Any]) -> Formulas:
    """The formulas of expressions.

    Parameters
    ----------
    inputs : sequence of Symbol
    expressions : sequence of Expr

    Raises
    ------
    TapeError
        Where an expression needs an operation that there is not, or another symbol.
    """
    builder = FormulaBuilder(inputs)
    return Formulas(builder.tape, tuple(builder.slot(within_floats(one)) for one in expressions))


def function_along_run(inputs: Sequence[Any], expression: Any) -> Callable[..., Any]:
    """One expression as a function of arrays, by the kernels' rule for powers."""
    formulas = formulas_of(inputs, [expression])
    return lambda *values: formulas.along_run(*values)[0]


def kept_formulas(derivations: Any, name: str, derive: Callable[[], Formulas]) -> Formulas:
    """Formulas among the derivations of a structure; where they are not there yet, those that `derive` makes.

    Where a structure has none in files (None) they are derived.
    """
    if derivations is None:
        return derive()
    objects = derivations.objects
    if name not in objects:
        data = derivations.get(f"{name}()")
        if data is not None:
            objects[name] = formulas_from_data(data)
        else:
            objects[name] = derive()
            derivations.keep(f"{name}()", objects[name].to_data())
    return objects[name]


def operands(tape: Tape, i: int) -> list[int]:
    """The slots that an operation takes."""
    kind, a, b = tape.ops[i]
    if kind == AFFINE:
        return [slot for slot, _ in tape.terms[a:b]]
    return [a, b, int(tape.constants[i])] if kind == SELECT else [a] if a == b else [a, b]


_STEPS: WeakKeyDictionary[Tape, dict[str, dict[int, Step]]] = WeakKeyDictionary()


def _steps(tape: Tape, arithmetic: Arithmetic, needed: Sequence[int]) -> list[tuple[int, Step]]:
    """Operations as functions of the values so far, each with the slot that it writes.

    They are remembered for each tape, as a tape grows where modes are derived on demand.
    """
    steps = _STEPS.setdefault(tape, {}).setdefault(arithmetic.name, {})
    for i in needed:
        if i not in steps:
            steps[i] = _step(tape, i, arithmetic)
    return [(tape.inputs + i, steps[i]) for i in needed]


def _step(tape: Tape, i: int, arithmetic: Arithmetic) -> Step:
    """An operation as a function of the values so far."""
    kind, a, b = tape.ops[i]
    number = tape.constants[i]
    if kind == AFFINE:
        return _affine(number, [(c, slot) for slot, c in tape.terms[a:b]])
    if kind == PRODUCT:
        return lambda v: v[a] * v[b]
    if kind == SQUARE:
        return lambda v: v[a] * v[a]
    if kind == SELECT:
        select, condition = arithmetic.select, int(number)
        return lambda v: select(v[condition], v[a], v[b])
    function = arithmetic.functions[kind]
    if kind in (INTEGER_POWER, POWER):
        exponent = int(number) if kind == INTEGER_POWER else number
        return lambda v: function(v[a], exponent)
    if kind in FUNCTIONS_BY_KIND:
        return lambda v: function(v[a])
    return lambda v: function(v[a], v[b])


def _affine(constant: float, terms: Sequence[tuple[float, int]]) -> Step:
    if not terms:
        return lambda _: constant
    (factor, first), *others = terms
    if not others and constant == 0.0:
        return (lambda v: -v[first]) if factor == -1.0 else lambda v: factor * v[first]

    def total(v: list[Any]) -> Any:
        value = v[first] if factor == 1.0 else factor * v[first]
        if constant != 0.0:
            value = constant + value
        for c, slot in others:
            value = value + v[slot] if c == 1.0 else value - v[slot] if c == -1.0 else value + c * v[slot]
        return value

    return total


def _with_inputs(tape: Tape, count: int) -> Tape:
    """The tape with further inputs behind its own, so that all other slots move."""

    def moved(slot: int) -> int:
        return slot if slot < tape.inputs else slot + count

    ops = [(k, a, b) if k == AFFINE else (k, moved(a), moved(b)) for k, a, b in tape.ops]
    numbers = [float(moved(int(n))) if op[0] == SELECT else n for n, op in zip(tape.constants, ops)]
    return Tape(tape.inputs + count, ops, numbers, [(moved(slot), c) for slot, c in tape.terms])


class _Differentiation(FormulaBuilder):
    """Appends the derivatives of a tape's slots to it.

    Parameters
    ----------
    tape : Tape
    seeds : mapping of int to derivatives
        Those of the inputs by which to differentiate.
    """

    def __init__(self, tape: Tape, seeds: Mapping[int, Derivative]) -> None:
        super().__init__([])
        self.tape = Tape(tape.inputs, list(tape.ops), list(tape.constants), list(tape.terms))
        for i, (op, number) in enumerate(zip(tape.ops, tape.constants, strict=True)):
            self._slots[_key(tape, op, number)] = tape.inputs + i
        self.derivatives: list[Derivative] = [seeds.get(i, {}) for i in range(tape.inputs)]
        for i in range(len(tape.ops)):
            self.derivatives.append(self._derivative(tape, i))

    def _derivative(self, tape: Tape, i: int) -> Derivative:
        (kind, a, b), number, out = tape.ops[i], tape.constants[i], tape.inputs + i
        if kind == AFFINE:
            return _sum([(c, self.derivatives[slot]) for slot, c in tape.terms[a:b]])
        if kind in COMPARISONS or not any(self.derivatives[slot] for slot in operands(tape, i)):
            return {}
        if kind == PRODUCT:
            return _sum([(1.0, self._times(b, a)), (1.0, self._times(a, b))])
        if kind == QUOTIENT:  # (a' - q b')/b
            rest = _sum([(1.0, self.derivatives[a]), (-1.0, self._times(out, b))])
            return {d: {self.operation(QUOTIENT, self.materialised(t), b): 1.0} for d, t in rest.items()}
        if kind == SELECT:
            return self._selected(int(number), a, b)
        if kind in (MAXIMUM, MINIMUM):
            pair = (a, b) if kind == MINIMUM else (b, a)
            return self._selected(self.operation(LESS, *pair), a, b)
        if kind == ATAN2:  # of y and x: (x y' - y x')/(x^2 + y^2)
            size = self.materialised({self.product(a, a): 1.0, self.product(b, b): 1.0})
            rest = _sum([(1.0, self._times(b, a)), (-1.0, self._times(a, b))])
            return {d: {self.operation(QUOTIENT, self.materialised(t), size): 1.0} for d, t in rest.items()}
        if kind == REAL_POWER:
            lower = self.materialised({b: 1.0, CONSTANT_TERM: -1.0})
            by_base = self.product(b, self.operation(REAL_POWER, a, lower))
            by_exponent = self.product(out, self.function(LOG, a))
            return _sum([(1.0, self._times(by_base, a)), (1.0, self._times(by_exponent, b))])
        slope = self._slope(kind, a, number, out)
        return {} if slope is None else self._times(slope, a)

    def _slope(self, kind: int, a: int, number: float, out: int) -> int | None:
        """Slot of the derivative of a function of one slot by this; None where that is zero."""
        if kind == SQUARE:
            return self.materialised({a: 2.0})
        if kind == INTEGER_POWER:
            n = int(number)
            lower = {1: {CONSTANT_TERM: 1.0}, 2: {a: 1.0}}.get(n)
            if lower is None:
                lower = {self.operation(INTEGER_POWER, a, a, n - 1.0): 1.0}
            return self.materialised({slot: number * factor for slot, factor in lower.items()})
        if kind == POWER:
            return self.materialised({self.operation(POWER, a, a, number - 1.0): number})
        terms = FUNCTIONS_BY_KIND[kind].slope(self, a, out)
        return self.materialised(terms) if terms else None

    def _selected(self, condition: int, a: int, b: int) -> Derivative:
        directions = {*self.derivatives[a], *self.derivatives[b]}

        def part(slot: int, d: int) -> int:
            return self.materialised(self.derivatives[slot].get(d, {}))

        return {d: {self.select(condition, part(a, d), part(b, d)): 1.0} for d in directions}

    def _times(self, factor: int, slot: int) -> Derivative:
        """The derivative of a slot times another slot."""
        return {d: self._product_terms(factor, terms) for d, terms in self.derivatives[slot].items()}

    def _product_terms(self, factor: int, terms: AffineTerms) -> AffineTerms:
        if not terms.keys() - {CONSTANT_TERM}:
            return {factor: terms[CONSTANT_TERM]}
        number, (slot, *others) = 1.0, terms
        if not others:  # a multiple of one slot: the number stays outside
            number = terms[slot]
        else:
            slot = self.materialised(terms)
        return {self.product(factor, slot): number}


def _key(tape: Tape, op: tuple[int, int, int], number: float) -> Any:
    """What tells an operation from others, as the builder does."""
    kind, a, b = op
    if kind != AFFINE:
        return kind, a, b, number
    return (*tape.terms[a:b], number)


def _sum(parts: Sequence[tuple[float, Derivative]]) -> Derivative:
    """The sum of derivatives times numbers."""
    total: Derivative = {}
    for factor, derivative in parts:
        for direction, terms in derivative.items():
            into = total.setdefault(direction, {})
            for slot, number in terms.items():
                into[slot] = into.get(slot, 0.0) + factor * number
    cleaned = {d: {slot: c for slot, c in terms.items() if c != 0.0} for d, terms in total.items()}
    return {d: terms for d, terms in cleaned.items() if terms}
