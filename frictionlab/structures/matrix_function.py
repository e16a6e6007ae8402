"""A function of parameters that gives a matrix, as the sum of (expression, matrix) that it computes.

The function is called once, with formulas in place of numbers.  Operators and functions of numpy on formulas,
arrays and sparse matrices record the sum.  What gives no sum raises a TypeError.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable, Mapping
from inspect import Parameter, signature
from numbers import Number
from typing import Any, TypeAlias

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin
from scipy import sparse

from frictionlab.lazy_names import sympy as sp
from frictionlab.models.symbols import symbol
from frictionlab.tape.arguments import FUNCTIONS
from frictionlab.validation import abbreviate, did_you_mean_or_known

Expression: TypeAlias = Any  # of sympy
SYMMETRY_RTOL = 1e-12  # of the largest entry: files have numbers of some 16 digits
NAMES_IN_NUMPY = {"atan": "arctan", "asinh": "arcsinh"}  # of those that sympy calls otherwise
NO_FORMULA = (
    f"is neither arithmetic nor one of {', '.join(NAMES_IN_NUMPY.get(name, name) for name in FUNCTIONS)}"
)
OF_FORMULAS: Mapping[Any, Callable[..., Any]] = {
    np.add: operator.add,
    np.subtract: operator.sub,
    np.multiply: operator.mul,
    np.divide: operator.truediv,
    np.power: operator.pow,
    np.negative: operator.neg,
    np.positive: operator.pos,
} | {
    getattr(np, NAMES_IN_NUMPY.get(name, name)): lambda x, name=name: getattr(sp, name)(x)
    for name in FUNCTIONS
}


def terms_of_function(function: Callable[..., Any], names: Iterable[str]) -> list[tuple[str, Any]]:
    """The terms (text, array) of the sum that a function of these parameters computes.

    Raises
    ------
    TypeError
        For a result that is no sum of expressions times arrays; the function may raise any other error.
    """
    total = _recorded(called_with_formulas(function, names))
    if isinstance(total, Formula):
        raise TypeError(f"it gives the number {total}")
    if all(any(differs(array, sign) for array in total.terms.values()) for sign in (1, -1)):
        total = _expanded(total)
    return [(text_of(each), array) for each, array in total.terms.items()]


def differs(array: Any, sign: int) -> bool:
    """Whether a square matrix is not `sign` times its transpose, but for rounding."""
    if array.shape != array.T.shape or not array.size:
        return False
    # as a complex stiffness is symmetric, not Hermitian, nothing is conjugated
    return bool(abs(array - sign * array.T).max() > SYMMETRY_RTOL * abs(array).max())


def called_with_formulas(function: Callable[..., Any], names: Iterable[str]) -> Any:
    """What a function of these parameters gives for formulas."""
    return function(**{name: Formula(symbol(name)) for name in names})


def arguments_of(what: str, function: Callable[..., Any], parameters: Mapping[str, float]) -> list[str]:
    """The arguments of a function that are parameters; others must have values of their own.

    Raises
    ------
    ValueError
        For any other argument.
    """
    arguments = signature(function).parameters
    for name, argument in arguments.items():
        if name not in parameters and argument.default is Parameter.empty:
            raise ValueError(f"{what} takes {name!r}, which is no parameter{hint_of(name, parameters)}")
    return [name for name in arguments if name in parameters]


def hint_of(name: str, parameters: Mapping[str, float]) -> str:
    """The end of a message about a name that is no parameter."""
    return did_you_mean_or_known(name, parameters) if parameters else f": give parameters={{{name!r}: 1.0}}"


def text_of(expression: Expression) -> str:
    """The text of an expression, with all digits of its numbers.

    Raises
    ------
    TypeError
        For what is not real, not finite, or neither arithmetic nor one of the functions.
    """
    arithmetic = sp.Symbol, sp.Number, sp.NumberSymbol, sp.Add, sp.Mul, sp.Pow
    for part in sp.preorder_traversal(expression):
        if part in (sp.I, sp.zoo, sp.nan, sp.oo, -sp.oo):
            raise TypeError(f"the coefficient {expression} is no finite real number")
        if not isinstance(part, arithmetic) and type(part).__name__ not in FUNCTIONS:
            raise TypeError(f"{part} {NO_FORMULA}")
    numbers = {each: float(each) for each in expression.atoms(sp.Float, sp.NumberSymbol)}
    texts = {each: repr(value) if value >= 0.0 else f"({value!r})" for each, value in numbers.items()}
    return str(expression.xreplace({each: sp.Symbol(text) for each, text in texts.items()}))


class _Recorder(NDArrayOperatorsMixin):
    """What records the operators and functions of numpy that act on it."""

    __hash__ = None  # type: ignore[assignment]  # == is refused

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **options: Any) -> Any:
        in_place = [one for one in options.pop("out", ()) if not isinstance(one, _Recorder)]
        plain = method == "__call__" and not options and not in_place
        recorded = [_recorded(one) for one in inputs]
        result = _result(ufunc, *recorded) if plain else None
        if result is None:
            how = " in place" if in_place else ""
            shown = ", ".join(map(abbreviate, inputs))
            numbers = all(isinstance(one, Formula) for one in recorded)
            rule = NO_FORMULA if numbers else "is no sum of expressions times matrices"
            raise TypeError(f"{ufunc.__name__}({shown}){how} {rule}")
        return result

    def __bool__(self) -> bool:
        raise TypeError(f"whether {self!r} is true depends on the parameters")


class Formula(_Recorder):
    """A number that depends on parameters."""

    def __init__(self, expression: Expression) -> None:
        self.expression = expression

    def _sympy_(self) -> Expression:
        return self.expression

    def __repr__(self) -> str:
        return str(self.expression)


class Sum(_Recorder):
    """A sum of expressions times arrays, or sparse matrices, of one shape."""

    def __init__(self, terms: Mapping[Expression, Any]) -> None:
        self.terms = terms

    @property
    def T(self) -> Sum:
        return Sum({each: array.T for each, array in self.terms.items()})

    def __repr__(self) -> str:
        return " + ".join(f"({each})*matrix" for each in self.terms)


def _recorded(given: Any) -> Formula | Sum:
    """A number, an expression of sympy, an array or a sparse matrix as what is recorded."""
    if isinstance(given, (Formula, Sum)):
        return given
    if sparse.issparse(given) and given.dtype.kind != "O":
        return Sum({sp.S.One: _in_double_precision(sparse.csc_array(given))})
    if isinstance(given, (Number, sp.Expr)):
        return Formula(sp.sympify(given, strict=True))
    array = given.toarray() if sparse.issparse(given) else np.asanyarray(given)
    if array.ndim == 0 and array.dtype.kind in "iufc":
        return Formula(sp.sympify(array.item(), strict=True))
    if array.ndim == 0 or array.dtype.kind not in "biufcO":
        raise TypeError(f"{abbreviate(given)} is neither a number nor a matrix")
    return _sum_of_entries(array) if array.dtype.kind == "O" else Sum({sp.S.One: _in_double_precision(array)})


def _in_double_precision(array: Any) -> Any:
    """Sums and products of integers would wrap round, as a parameter no longer makes them floating-point."""
    return array.astype(complex if array.dtype.kind == "c" else float)


def _sum_of_entries(array: Any) -> Sum:
    """The sum that an array of formulas is."""
    terms: dict[Expression, Any] = {}
    for place, entry in np.ndenumerate(array):
        for part in sp.Add.make_args(sp.sympify(entry, strict=True)):
            number, rest = part.as_coeff_Mul()
            terms.setdefault(rest, np.zeros(array.shape))[place] += float(number)
    return _scaled(Sum(terms), sp.S.One)


def _result(ufunc: Any, *inputs: Formula | Sum) -> Formula | Sum | None:
    """The function of numpy; None where that is no sum."""
    numbers = [one.expression for one in inputs if isinstance(one, Formula)]
    if ufunc in OF_FORMULAS and len(numbers) == len(inputs):
        return Formula(OF_FORMULAS[ufunc](*numbers))
    match ufunc, *inputs:
        case np.negative, Sum() as one:
            return _scaled(one, -sp.S.One)
        case np.positive, Sum() as one:
            return one
        case np.add, Sum() as one, Sum() as other:
            return _sum(one, other)
        case np.subtract, Sum() as one, Sum() as other:
            return _sum(one, _scaled(other, -sp.S.One))
        case np.add | np.subtract, Sum() as one, Formula(expression=sp.S.Zero):
            return one
        case np.add, Formula(expression=sp.S.Zero), Sum() as one:  # as sum() begins
            return one
        case (np.multiply, Formula(expression=factor), Sum() as one) | (
            np.multiply,
            Sum() as one,
            Formula(expression=factor),
        ):
            return _scaled(one, factor)
        case np.divide, Sum() as one, Formula(expression=factor):
            return _scaled(one, 1 / factor)
        case np.matmul, Sum(terms=left), Sum(terms=right) if sp.S.One in left and len(left) == 1:
            return Sum({each: left[sp.S.One] @ array for each, array in right.items()})
        case np.matmul, Sum(terms=left), Sum(terms=right) if sp.S.One in right and len(right) == 1:
            return Sum({each: array @ right[sp.S.One] for each, array in left.items()})
    return None


def _scaled(one: Sum, factor: Expression) -> Sum:
    """The product, numbers and imaginary units of which go into the matrices."""
    total = Sum({})
    for each, array in one.terms.items():
        real = each * factor
        if real.has(sp.I):
            product = sp.expand(real)
            imaginary = product.coeff(sp.I)
            real = product - sp.I * imaginary
            total = _with_product(total, imaginary, 1j * array)
        total = _with_product(total, real, array)
    return total


def _with_product(one: Sum, factor: Expression, array: Any) -> Sum:
    """The sum with a product.

    Arrays with the same expression are one: each by itself need not be symmetric.
    """
    terms = dict(one.terms)
    shape = next(iter(terms.values()), array).shape
    if shape != array.shape:
        raise TypeError(f"matrices of the shapes {shape} and {array.shape} have no sum")
    number, rest = factor.as_coeff_Mul()
    if -rest in terms:
        number, rest = -number, -rest
    array = array if number == 1 else array * float(number)
    terms[rest] = terms[rest] + array if rest in terms else array
    return Sum(terms)


def _expanded(one: Sum) -> Sum:
    """The same sum, in which equal expressions that were written differently are one."""
    total = Sum({})
    for each, array in one.terms.items():
        for part in sp.Add.make_args(sp.expand(each)):
            total = _with_product(total, part, array)
    return total


def _sum(one: Sum, other: Sum) -> Sum:
    for each, array in other.terms.items():
        one = _with_product(one, each, array)
    return one
