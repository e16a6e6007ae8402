"""Functions that sympy has compiled, as data that a file can hold: straight-line programs.

The source that `lambdify` writes is a list of assignments, with no branches but those of signs.  It is read
once.  The program made of it does the same operations on the same numbers in the same order, so that its
results are the same to the last bit.  It is data, not run as Python, and does not need sympy.
"""

from __future__ import annotations

import ast
import inspect
import math
import operator
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

Data = dict[str, Any]
OPERATORS: dict[str, Callable[..., Any]] = {
    "Add": operator.add,
    "Sub": operator.sub,
    "Mult": operator.mul,
    "Div": operator.truediv,
    "Pow": operator.pow,
    "USub": operator.neg,
    "UAdd": operator.pos,
    "IfEqual": lambda a, b, yes, no: yes if a == b else no,
}
MATH: Mapping[str, Any] = {name: value for name, value in vars(math).items() if not name.startswith("_")}


class NotStraight(Exception):
    """A function that holds more than assignments, arithmetic and calls."""


def straight_line_data(function: Callable[..., Any], functions: Mapping[str, Any]) -> Data | None:
    """A function of sympy's `lambdify` as data that JSON can hold; None where it is no straight line.

    Parameters
    ----------
    function : callable
    functions : mapping of str to callable
        The functions that it may call, by their names in its source.

    Examples
    --------
    >>> import sympy
    >>> x, y = sympy.symbols("x y")
    >>> data = straight_line_data(sympy.lambdify([x, y], [x + sympy.sqrt(y), 3 * x], "math"), MATH)
    >>> StraightLine(data, MATH)(1.0, 4.0)
    [3.0, 3.0]
    """
    try:
        return _Reader(function, functions).data()
    except (NotStraight, OSError, SyntaxError):  # other functions may have no source, or part of a line
        return None


class _Reader:
    """Reads the source of a function; values are ("argument", i), ("number", i) or ("result", i)."""

    def __init__(self, function: Callable[..., Any], functions: Mapping[str, Any]) -> None:
        self._functions, self._globals = functions, function.__globals__
        definition = ast.parse(inspect.getsource(function)).body[0]
        if not isinstance(definition, ast.FunctionDef):
            raise NotStraight
        self._body = definition.body
        self._count = len(definition.args.args)
        self._known = {each.arg: ("argument", i) for i, each in enumerate(definition.args.args)}
        self._numbers: list[float] = []
        self._operations: list[tuple[str, list[Any]]] = []

    def data(self) -> Data:
        """The program; its places count all values in one row: arguments, then numbers, then results."""
        *assignments, last = self._body
        for each in assignments:
            match each:
                case ast.Assign(targets=[ast.Name(id=name)], value=value):
                    self._known[name] = self._value(value)
                case _:
                    raise NotStraight
        if not isinstance(last, ast.Return) or last.value is None:
            raise NotStraight
        returned = self._returned(last.value)
        return {
            "arguments": self._count,
            "numbers": self._numbers,
            "operations": [[name, *map(self._place, of)] for name, of in self._operations],
            "returns": _mapped(self._place, returned),
        }

    def _place(self, value: tuple[str, int]) -> int:
        kind, i = value
        first = {"argument": 0, "number": self._count, "result": self._count + len(self._numbers)}
        return first[kind] + i

    def _returned(self, node: ast.expr) -> Any:
        return (
            [self._returned(each) for each in node.elts]
            if isinstance(node, (ast.List, ast.Tuple))
            else self._value(node)
        )

    def _value(self, node: ast.expr) -> tuple[str, int]:
        match node:
            case ast.Name(id=name) if name in self._known:
                return self._known[name]
            case ast.Name(id=name) if isinstance(self._globals.get(name), float):
                return self._number(self._globals[name])
            case ast.Constant(value=int() | float() as number) if not isinstance(number, bool):
                return self._number(number)
            case ast.UnaryOp(op=sign, operand=only) if type(sign).__name__ in OPERATORS:
                return self._result(type(sign).__name__, [only])
            case ast.BinOp(left=left, op=sign, right=right) if type(sign).__name__ in OPERATORS:
                return self._result(type(sign).__name__, [left, right])
            case ast.IfExp(ast.Compare(left, [ast.Eq()], [right]), yes, no) if _is_sign(yes, no):
                return self._result("IfEqual", [left, right, yes, no])
            case ast.Call(func=ast.Name(id=name), args=given, keywords=[]) if name in self._functions:
                return self._result(name, given)
        raise NotStraight

    def _number(self, number: float) -> tuple[str, int]:
        self._numbers.append(number)
        return "number", len(self._numbers) - 1

    def _result(self, name: str, of: Sequence[ast.expr]) -> tuple[str, int]:
        self._operations.append((name, [self._value(each) for each in of]))  # its operands come before it
        return "result", len(self._operations) - 1


def _is_sign(yes: ast.expr, no: ast.expr) -> bool:
    """Whether a branch is a sign, `0.0 if x == 0 else copysign(1, x)`: both its alternatives have values."""
    called = isinstance(no, ast.Call) and ast.unparse(no.func) == "copysign"
    return called and isinstance(yes, ast.Constant)


def side_by_side(lines: Sequence[Data], chosen: Sequence[int]) -> Data:
    """Join functions of the same arguments, of one value each: the result returns those `chosen` by index."""
    count = lines[0]["arguments"]
    numbers: list[float] = [number for one in lines for number in one["numbers"]]
    operations: list[list[Any]] = []
    returned, before = [], 0  # how many numbers the functions before have
    for one in lines:
        results = count + len(one["numbers"])  # where its results begin
        moves = (0, before, len(numbers) - len(one["numbers"]) + len(operations))
        move = partial(_moved, bounds=(count, results), moves=moves)
        operations += [[name, *map(move, of)] for name, *of in one["operations"]]
        returned.append(move(one["returns"]))
        before += len(one["numbers"])
    returns = [returned[i] for i in chosen]
    return {"arguments": count, "numbers": numbers, "operations": operations, "returns": returns}


def _moved(place: int, bounds: tuple[int, int], moves: tuple[int, int, int]) -> int:
    """The place moved by the entry of `moves` for its part; `bounds` part arguments, numbers and results."""
    return place + moves[sum(place >= bound for bound in bounds)]


class StraightLine:
    """A function of numbers or arrays, made from the data of :func:`straight_line_data`.

    Parameters
    ----------
    data : mapping
    functions : mapping of str to callable
        The functions that it may call.
    """

    def __init__(self, data: Data, functions: Mapping[str, Callable[..., Any]]) -> None:
        self._count, self._numbers, self._returns = data["arguments"], data["numbers"], data["returns"]
        self._operations = [
            (OPERATORS.get(name) or functions[name], of[0], of[1] if len(of) == 2 else None, of)
            for name, *of in data["operations"]
        ]

    def __call__(self, *arguments: Any) -> Any:
        if len(arguments) != self._count:
            raise TypeError(f"{self._count} arguments are needed, got {len(arguments)}")
        values = [*arguments, *self._numbers]
        append = values.append
        for operation, a, b, of in self._operations:
            if b is not None:  # nearly all have two operands
                append(operation(values[a], values[b]))
            else:
                append(operation(*[values[i] for i in of]))
        return _mapped(values.__getitem__, self._returns)


def _mapped(function: Callable[[Any], Any], nested: Any) -> Any:
    """Apply a function to all elements of nested lists, or to a single element."""
    if isinstance(nested, list):
        return [_mapped(function, each) for each in nested]
    return function(nested)
