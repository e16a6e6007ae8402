"""A matrix that depends on named parameters: a sum of coefficients times sparse matrices.

Values of parameters are new coefficients; no matrix is read or checked again.  Derivatives by parameters are
exact, as the coefficients are formulas.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from numbers import Real
from os import PathLike
from typing import Any, TypeAlias

import numpy as np
from scipy import sparse

from frictionlab.lazy_names import sympy as sp
from frictionlab.models.symbols import symbol
from frictionlab.structures.matrix_function import (
    arguments_of,
    called_with_formulas,
    differs,
    hint_of,
    terms_of_function,
    text_of,
)
from frictionlab.tape.arguments import names_in, parse_expression
from frictionlab.tape.formulas import Formulas, formulas_of
from frictionlab.validation import (
    abbreviate,
    check_number,
    float_array,
    floats_of_objects,
    is_sequence,
)

Matrix: TypeAlias = Any  # csc_array (n, n), of which type checkers know neither shape nor sums
ROUNDED_RTOL = 1e-5  # of the largest entry: files have numbers of few digits
MAX_COEFFICIENT = 20_000  # characters; a recorded formula is longer than what a person writes
SHOWN = 3  # entries or freedoms that a message names


@dataclass(frozen=True, eq=False)
class ParametricMatrix:
    """A sum of coefficients times sparse matrices (n, n).

    Parameters
    ----------
    coefficients : tuple of str
        Expressions of parameters, "1" for a matrix that does not depend on any.
    matrices : tuple of csc_array (n, n)
    """

    coefficients: tuple[str, ...]
    matrices: tuple[Matrix, ...]

    @property
    def size(self) -> int:
        """The number of rows."""
        return int(self.matrices[0].shape[0])

    @cached_property
    def parameters(self) -> tuple[str, ...]:
        """Names of the parameters that enter, in the order of the coefficients."""
        return tuple(dict.fromkeys(name for text in self.coefficients for name in names_in(text)))

    def at(self, values: Mapping[str, float]) -> Matrix:
        """The matrix at values of the parameters."""
        return self._sum(self._factors(self._formulas.numbers, values))

    def stack(self, values: Mapping[str, Any], count: int) -> Any:
        """Full matrices (count, n, n) at arrays (count,) of the parameters."""
        factors = self._factors(self._formulas.arrays, values)
        columns = (np.broadcast_to(np.asarray(factor, dtype=float), (count,)) for factor in factors)
        pairs = zip(columns, self.matrices, strict=True)
        return sum(column[:, None, None] * matrix.toarray() for column, matrix in pairs)

    def derivative(self, parameter: str, values: Mapping[str, float]) -> Matrix:
        """Its derivative by a parameter."""
        factors = np.zeros(len(self.matrices))
        if parameter in self.parameters:
            places, slopes = self._formulas.jacobian([self.parameters.index(parameter)])
            numbers = slopes.numbers(*(values[name] for name in self.parameters))
            for (row, _), number in zip(places, numbers, strict=True):
                factors[row] = number
        return self._sum(factors)

    def scaled(self, coefficient: str) -> ParametricMatrix:
        """The product with an expression."""
        texts = tuple(
            coefficient if text == "1" else f"({coefficient})*({text})" for text in self.coefficients
        )
        return ParametricMatrix(texts, self.matrices)

    def projected(self, basis: Any) -> ParametricMatrix:
        """V^T A V of each matrix A, or V^T A of each column (n, 1), for a real basis V (n, r)."""
        small = (matrix @ basis if matrix.shape[1] == self.size else matrix for matrix in self.matrices)
        small = tuple(sparse.csc_array(basis.T @ one) for one in small)
        return ParametricMatrix(self.coefficients, small)

    def __add__(self, other: ParametricMatrix) -> ParametricMatrix:
        return ParametricMatrix(self.coefficients + other.coefficients, self.matrices + other.matrices)

    @property
    def entries(self) -> int:
        """Entries that are stored, of all terms."""
        return sum(matrix.nnz for matrix in self.matrices)

    def _factors(self, formulas: Callable[..., Any], values: Mapping[str, Any]) -> Any:
        with np.errstate(all="ignore"):  # what is not finite is refused
            factors = formulas(*(values[name] for name in self.parameters))
        for text, factor in zip(self.coefficients, factors, strict=True):
            if not np.isfinite(factor).all():
                at = ", ".join(f"{name} = {abbreviate(values[name])}" for name in names_in(text))
                raise ValueError(
                    f"the coefficient {text} must be finite, got {abbreviate(factor)} at {at}: take another "
                    "value"
                )
        return factors

    def _sum(self, factors: Any) -> Matrix:
        total = sparse.csc_array(self.matrices[0].shape)
        for factor, matrix in zip(factors, self.matrices, strict=True):
            if factor:
                total = total + factor * matrix
        return total

    @cached_property
    def _formulas(self) -> Formulas:
        symbols = {name: symbol(name) for name in self.parameters}
        return formulas_of(
            list(symbols.values()), [parse_coefficient(text, symbols) for text in self.coefficients]
        )

    def __getstate__(self) -> dict[str, Any]:  # formulas are made again where they are needed
        return {"coefficients": self.coefficients, "matrices": self.matrices}


def paths_in(given: Any) -> list[Any]:
    """The paths in what a user gives as one matrix of a structure."""
    matrices = [term[1] for term in given] if _is_list_of_terms(given, _is_matrix) else [given]
    return [one for one in matrices if isinstance(one, (str, PathLike))]


def parametric_matrix(
    name: str, given: Any, parameters: Mapping[str, float], files: Mapping[Any, Matrix]
) -> ParametricMatrix:
    """What a user gives as one matrix of a structure.

    Parameters
    ----------
    name : str
        What errors call it.
    given : array, sparse matrix, str, Path, function, ParametricMatrix or list of (coefficient, matrix)
        A coefficient is a number, a text such as "1/r - 1", or a function of parameters.  A function of
        parameters that gives the matrix is such a list.
    parameters : mapping of str to float
        Those that coefficients may name.
    files : mapping of paths to matrices

    Raises
    ------
    ValueError
        For anything else, for what is not square or not finite, for an unknown parameter.
    """
    if isinstance(given, ParametricMatrix):
        return given
    texts, matrices = [], []
    for where, coefficient, matrix in _terms(name, given, parameters, _is_matrix):
        texts.append(_coefficient(where, coefficient, parameters))
        matrices.append(_sparse(where, matrix, files))
    for i, matrix in enumerate(matrices):
        if matrix.shape != matrices[0].shape:
            raise ValueError(
                f"all terms of {name} must have the same shape, got {matrices[0].shape} and, in term {i}, "
                f"{matrix.shape}: give matrices of the same freedoms"
            )
    return ParametricMatrix(tuple(texts), tuple(matrices))


def parametric_vector(given: Any, parameters: Mapping[str, float], size: int) -> ParametricMatrix:
    """What a user gives as constant forces, as columns (n, 1): an array, a function, or a list of terms.

    Raises
    ------
    ValueError
        As :func:`parametric_matrix`.
    """
    texts, columns = [], []
    for where, coefficient, force in _terms("load", given, parameters, _is_vector):
        texts.append(_coefficient(where, coefficient, parameters))
        column = float_array(where, force, "give one force for each freedom", finite=True).ravel()
        if len(column) != size:
            raise ValueError(
                f"{where} must have one force for each of {size} freedoms, got {len(column)}: give an array"
            )
        columns.append(sparse.csc_array(column[:, None]))
    return ParametricMatrix(tuple(texts), tuple(columns))


def _terms(
    name: str, given: Any, parameters: Mapping[str, float], is_part: Callable[[Any], bool]
) -> list[tuple[str, Any, Any]]:
    """What errors call each term, its coefficient and its part; of a function, a list, or a single part."""
    if callable(given):
        return [(name, *term) for term in _terms_of_function(name, given, parameters)]
    if _is_list_of_terms(given, is_part):
        return [(f"term {i} of {name}", *term) for i, term in enumerate(given)]
    return [(name, 1, given)]


def _is_list_of_terms(given: Any, is_part: Callable[[Any], bool]) -> bool:
    return (
        isinstance(given, (list, tuple))
        and bool(given)
        and all(isinstance(term, (list, tuple)) and len(term) == 2 and is_part(term[1]) for term in given)
    )


def _is_vector(given: Any) -> bool:
    return is_sequence(given) or bool(getattr(given, "ndim", 0))


def _is_matrix(given: Any) -> bool:
    return (
        isinstance(given, (str, PathLike))
        or getattr(given, "ndim", 0) == 2
        or (is_sequence(given) and bool(len(given)) and all(map(is_sequence, given)))
    )


def _coefficient(where: str, given: Any, parameters: Mapping[str, float]) -> str:
    """A coefficient as the text of an expression."""
    what = f"the coefficient of {where}"
    if isinstance(given, Real):
        return "1" if given == 1 else repr(float(check_number(what, given)))
    if isinstance(given, str):
        _parse(what, given, parameters)
        return given
    if callable(given):
        return _text_of_function(what, given, parameters)
    raise ValueError(
        f"{what} must be a number, a text or a function of parameters, got {abbreviate(given)}: "
        'write for example "1/r - 1"'
    )


def parse_coefficient(text: str, symbols: Mapping[str, Any]) -> Any:
    """A coefficient as an expression of sympy."""
    return parse_expression(text, symbols, MAX_COEFFICIENT)


def _parse(what: str, text: str, parameters: Mapping[str, float]) -> Any:
    for each in names_in(text):
        if each not in parameters:
            raise ValueError(f"{what} names {each!r}, which is no parameter{hint_of(each, parameters)}")
    try:
        return parse_coefficient(text, {each: symbol(each) for each in names_in(text)})
    except ValueError as error:
        raise ValueError(
            f"{what} must be an expression of parameters, got {abbreviate(text)}: {error}"
        ) from None


def _text_of_function(what: str, function: Callable[..., Any], parameters: Mapping[str, float]) -> str:
    """The expression that a function of parameters computes."""
    names = arguments_of(what, function, parameters)
    cure = "take its parameters by name and use arithmetic and functions of numpy, such as lambda r: 1/r - 1"
    with _refusal(f"{what} must be a formula", cure):
        text = text_of(sp.sympify(called_with_formulas(function, names), strict=True))
        _parse(what, text, parameters)
    return text


def _terms_of_function(
    name: str, function: Callable[..., Any], parameters: Mapping[str, float]
) -> list[tuple[str, Any]]:
    """The list of (text, matrix) that a function of parameters computes."""
    names = arguments_of(name, function, parameters)
    cure = (
        "use + - * / ** @ and functions of numpy such as np.sqrt(r), as in lambda r: D + r*G + (1/r - 1)*R, "
        f'or give the list {name}=[(1, D), ("r", G), ("1/r - 1", R)]'
    )
    with _refusal(f"{name} must be a sum of expressions of its arguments times matrices", cure):
        terms = terms_of_function(function, names)
        for text, _ in terms:
            _parse(f"a coefficient of {name}", text, parameters)
    return terms


@contextmanager
def _refusal(rule: str, cure: str) -> Iterator[None]:
    """Any error of a function of somebody's own as a ValueError with the rule and the cure."""
    try:
        yield
    except Exception as error:
        raise ValueError(f"{rule}, but called with formulas it fails ({error}): {cure}") from None


def _sparse(name: str, given: Any, files: Mapping[Any, Matrix]) -> Matrix:
    """A square sparse matrix of finite numbers."""
    if isinstance(given, (str, PathLike)):
        given = files[given]
    try:
        if not sparse.issparse(given) and np.ma.is_masked(given):
            raise TypeError
        numbers = given if sparse.issparse(given) else np.atleast_2d(np.asarray(given))
        if numbers.dtype.kind == "O":  # numbers of Python or sympy, as a table of a spreadsheet has them
            numbers = floats_of_objects(numbers)
        matrix: Matrix = sparse.csc_array(numbers)
        kind = matrix.dtype.kind
        if kind not in "iufc":
            raise TypeError
    except (TypeError, ValueError, OverflowError):  # an integer such as 10**400
        raise ValueError(
            f"{name} must be a matrix of numbers, got {abbreviate(given)}: give an array, a sparse matrix of "
            "scipy, the path of a file, a function of parameters, or a list of (coefficient, matrix)"
        ) from None
    if matrix.ndim != 2 or matrix.shape[0] != matrix.shape[1] or not matrix.shape[0]:
        raise ValueError(
            f"{name} must be square, got the shape {matrix.shape}: give a row and a column for each freedom"
        )
    matrix = matrix.astype(complex if kind == "c" else float)
    matrix.sum_duplicates()
    matrix.eliminate_zeros()
    if not np.isfinite(matrix.data).all():
        bad = matrix.tocoo()
        at = np.flatnonzero(~np.isfinite(bad.data))
        raise ValueError(
            f"{name} must hold finite numbers, got {bad.data[at[0]]} at row {bad.row[at[0]]}, column "
            f"{bad.col[at[0]]} ({len(at)} in all): correct the export"
        )
    return matrix


def check_symmetry(name: str, matrix: ParametricMatrix, sign: int, cure: str) -> None:
    """Raise ValueError unless every term equals `sign` times its transpose, but for rounding."""
    what = "symmetric" if sign == 1 else "skew"
    for coefficient, term in zip(matrix.coefficients, matrix.matrices, strict=True):
        if not differs(term, sign):
            continue
        difference = abs(term - sign * term.T).tocoo()
        worst = int(difference.data.argmax())
        row, column = int(difference.row[worst]), int(difference.col[worst])
        where = name if len(matrix.matrices) == 1 else f"the matrix of {abbreviate(coefficient)} in {name}"
        rounded = difference.data[worst] <= ROUNDED_RTOL * abs(term).max()
        nearly = f"if rounding made it so, give (A {'+' if sign == 1 else '-'} A.T)/2" if rounded else ""
        raise ValueError(
            f"{where} must be {what}, got {term[row, column]:.12g} at row {row}, column {column}, and "
            f"{term[column, row]:.12g} across the diagonal: {_triangle(term, sign) or nearly or cure}"
        )


def _triangle(term: Matrix, sign: int) -> str:
    """The cure for one triangle of a symmetric or a skew matrix; "" for any other."""
    coordinates = term.tocoo()
    diagonal = (coordinates.row == coordinates.col).any()
    if sign == -1:
        one = not diagonal and len({*np.sign(coordinates.row - coordinates.col)}) == 1
        return "it is one triangle of a matrix, so give A - A.T" if one else ""
    if (coordinates.row >= coordinates.col).all() or (coordinates.row <= coordinates.col).all():
        return "it is one triangle of a matrix, so give A + A.T - scipy.sparse.diags_array(A.diagonal())"
    return ""
