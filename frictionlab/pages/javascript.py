"""Sympy expressions as JavaScript that computes what Python computes, and the rules that parameters keep.

Sums and products are printed in the order in which Python computes them, so that numbers are the same to the
last bit.  Powers and functions are calls of the kernels that Python calls too, through the object ``F`` of
``functions.js``.

Bounds of single parameters are in their metadata.  Rules between parameters are Python code: the `check` of a
law or a model.  It is run with values that record the comparisons made with them, once for each combination
of outcomes, so that a page can make the same comparisons with numbers and show the same messages.
"""

from __future__ import annotations

import operator
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, cast

import sympy as sp

from frictionlab.components.component import Component, Parameter, check_value, parameters_of, structure_of
from frictionlab.hybrid.elementary.parameter_functions import KERNELS
from frictionlab.hybrid.expression_functions import ParameterPrinter
from frictionlab.hybrid.tape.functions import FUNCTIONS
from frictionlab.models import Model
from frictionlab.models.symbols import symbol

MAX_OUTCOMES = 64  # combinations of outcomes in one `check`; a page leaves out the rules of one with more
MARK = "\0"  # encloses the places of values in a message
RELATIONS = {"lt": sp.Lt, "le": sp.Le, "gt": sp.Gt, "ge": sp.Ge, "eq": sp.Eq, "ne": sp.Ne}


class JavaScriptPrinter(ParameterPrinter):
    """Prints what the two languages write differently; sums and products read the same in both."""

    root, prefix = "Math.sqrt", "F."

    def _print_Function(self, expr: Any) -> str:
        return f"F.{type(expr).__name__}({', '.join(map(self._print, expr.args))})"

    def _print_Abs(self, expr: Any) -> str:
        return f"Math.abs({self._print(expr.args[0])})"

    def _print_sign(self, expr: Any) -> str:
        return f"Math.sign({self._print(expr.args[0])})"

    def _print_Min(self, expr: Any) -> str:
        return f"Math.min({', '.join(map(self._print, expr.args))})"

    def _print_Max(self, expr: Any) -> str:
        return f"Math.max({', '.join(map(self._print, expr.args))})"

    def _print_Piecewise(self, expr: Any) -> str:
        text = "NaN"
        for value, condition in reversed(expr.args):
            if condition == sp.true:
                text = f"({self._print(value)})"
            else:
                text = f"(({self._print(condition)}) ? ({self._print(value)}) : {text})"
        return text

    def _print_Pi(self, expr: Any) -> str:
        return "Math.PI"

    def _print_Exp1(self, expr: Any) -> str:
        return "Math.E"


def _named_function(name: str) -> Any:
    def printed(printer: JavaScriptPrinter, expr: Any) -> str:
        return f"F.{name}({printer._print(expr.args[0])})"

    return printed


# Python's printer knows these by methods of their own, which would write math.exp.
for _name in {function.name for function in FUNCTIONS} | {function.__name__ for function in KERNELS}:
    setattr(JavaScriptPrinter, f"_print_{_name}", _named_function(_name))


def javascript_function(arguments: Sequence[Sequence[Any]], expressions: Sequence[Any]) -> str:
    """A JavaScript function of arrays of numbers that returns the values of the expressions.

    Parameters
    ----------
    arguments : sequence of sequences of Symbol
        The symbols in each array, in their order.
    expressions : sequence of Expr

    Examples
    --------
    >>> import sympy
    >>> k, m = sympy.symbols("k m")
    >>> javascript_function([(k, m)], [sympy.sqrt(k / m)])
    '([a0, a1]) => {return [Math.sqrt(a0/a1)];}'
    """
    # The same common subexpressions, in the same order, as sympy's lambdify finds.
    common, reduced = sp.cse(list(map(sp.sympify, expressions)), list=False)
    return _function(arguments, common, cast(list, reduced))


def javascript_function_apart(arguments: Sequence[Sequence[Any]], expressions: Sequence[Any]) -> str:
    """As :func:`javascript_function`, but each expression is evaluated on its own, as in modes on demand."""
    return _function(arguments, [], list(map(sp.sympify, expressions)))


def _function(arguments: Sequence[Sequence[Any]], common: Sequence[Any], reduced: Sequence[Any]) -> str:
    names = iter(f"a{i}" for i in range(sum(map(len, arguments))))
    arrays = [[next(names) for _ in some] for some in arguments]
    renamed = {s: n for some, array in zip(arguments, arrays) for s, n in zip(some, array, strict=True)}
    printer = _Renaming(renamed | {symbol: f"c{i}" for i, (symbol, _) in enumerate(common)})
    lines = [f"const c{i} = {printer.text(value)};" for i, (_, value) in enumerate(common)]
    values = ", ".join(map(printer.text, reduced))
    head = ", ".join(f"[{', '.join(array)}]" for array in arrays)
    return f"({head}) => {{{''.join(lines)}return [{values}];}}"


class _Renaming(JavaScriptPrinter):
    """Prints symbols by short names, as their own need not be names in JavaScript."""

    def __init__(self, names: dict[Any, str]) -> None:
        super().__init__()
        self._names_of_symbols = names

    def text(self, expr: Any) -> str:
        """An expression as JavaScript."""
        return str(self.doprint(expr))

    def _print_Symbol(self, expr: Any) -> str:
        return self._names_of_symbols[expr]

    _print_Dummy = _print_Symbol


@dataclass(frozen=True)
class Rule:
    """A rule that is broken where all relations in `broken` hold.

    In the message each value is replaced by its format, as "g", between marks.
    """

    broken: tuple[Any, ...]
    values: tuple[Any, ...]
    message: str

    @property
    def numbers(self) -> tuple[Any, ...]:
        return (*self.broken, *self.values)


def rule_data(model: Model, parameters: tuple[Any, ...]) -> dict[str, Any]:
    """The rules that a page checks, in the order in which Python does; `parameters` are symbols.

    ``numbers`` is a JavaScript function that returns, for one rule after the other, the relations that must
    all hold for its message to be shown, and the values in the message; ``words`` has for each rule the
    number of relations, the number of values, and the message.
    """
    known = set(parameters)
    every = [rule for component in (*model.components.values(), model) for rule in _rules(component)]
    rules = [rule for rule in every if set().union(*(x.free_symbols for x in rule.numbers)) <= known]
    words = [
        {"relations": len(rule.broken), "values": len(rule.values), "message": rule.message.split(MARK)}
        for rule in rules
    ]
    numbers = [number for rule in rules for number in rule.numbers]
    return {"numbers": javascript_function_apart([parameters], numbers), "words": words}


def _rules(component: Component | Model) -> Iterator[Rule]:
    for name, about in parameters_of(type(component)).items():
        yield from _bounds(name, about)
    yield from _checked(component)


def _bounds(name: str, about: Parameter) -> Iterator[Rule]:
    """Rules for the bounds of a parameter, with the messages of :func:`check_value`."""
    x = symbol(name)
    bounds = (
        (about.exclusive_minimum, sp.Le, -1.0),
        (about.minimum, sp.Lt, -1.0),
        (about.maximum, sp.Gt, 1.0),
    )
    for bound, relation, away in bounds:
        if bound is None:
            continue
        value = bound + away
        try:
            check_value(name, value, about)
        except ValueError as error:
            words = str(error).replace(f"got {value}:", f"got {MARK}{MARK}:")
            yield Rule((relation(x, bound),), (x,), words)


def _checked(component: Component | Model) -> Iterator[Rule]:
    """The rules of a `check`, which raise ValueError; none if it needs more than formulas and comparisons."""
    waiting: list[tuple[bool, ...]] = [()]
    found: list[Rule] = []
    for _ in range(MAX_OUTCOMES):
        if not waiting:
            yield from found
            return
        trace = _Trace(waiting.pop())
        copy = object.__new__(type(component))
        for name in parameters_of(type(component)):
            object.__setattr__(copy, name, _Traced(symbol(name), trace))
        for name in structure_of(type(component)):
            object.__setattr__(copy, name, getattr(component, name))
        try:
            copy.check()
        except ValueError as error:
            found.append(Rule(tuple(trace.relations), tuple(trace.values), str(error)))
        except (TypeError, AttributeError, ArithmeticError):
            return
        waiting += trace.others()


@dataclass
class _Trace:
    """One run of a `check`: its first comparisons have given outcomes, the others are false.

    It records the relations that held so, and the values in the message.
    """

    given: tuple[bool, ...]
    relations: list[Any] = field(default_factory=list)
    values: list[Any] = field(default_factory=list)

    def outcome(self, relation: Any) -> bool:
        place = len(self.relations)
        holds = self.given[place] if place < len(self.given) else False
        self.relations.append(relation if holds else sp.Not(relation))
        return holds

    def others(self) -> list[tuple[bool, ...]]:
        """Outcomes to try next: as in this run up to a comparison that was not given, and that one true."""
        free = range(len(self.given), len(self.relations))
        return [(*self.given, *[False] * (place - len(self.given)), True) for place in free]


class _Relation:
    """A comparison whose outcome is chosen when its truth value is asked for."""

    def __init__(self, relation: Any, trace: _Trace) -> None:
        self.relation, self.trace = relation, trace

    def __bool__(self) -> bool:
        if self.relation in (sp.true, sp.false):
            return bool(self.relation)
        return self.trace.outcome(self.relation)


class _Traced:
    """A number as a formula of parameters; its comparisons, and its places in messages, are recorded."""

    __hash__ = None  # type: ignore[assignment]  # as == gives a _Relation

    def __init__(self, formula: Any, trace: _Trace) -> None:
        self.formula, self.trace = formula, trace

    def __format__(self, spec: str) -> str:
        self.trace.values.append(self.formula)
        return f"{MARK}{spec}{MARK}"

    def __repr__(self) -> str:
        return format(self, "")

    __str__ = __repr__

    def __bool__(self) -> bool:
        return bool(_Relation(sp.Ne(self.formula, 0), self.trace))


def _plain(value: Any) -> Any:
    return value.formula if isinstance(value, _Traced) else sp.sympify(value, strict=True)


def _arithmetic(operation: Any, swapped: bool) -> Any:
    def method(self: _Traced, other: Any) -> _Traced:
        pair = (_plain(other), self.formula) if swapped else (self.formula, _plain(other))
        return _Traced(operation(*pair), self.trace)

    return method


def _of_itself(operation: Any) -> Any:
    return lambda self: _Traced(operation(self.formula), self.trace)


def _comparison(relation: Any) -> Any:
    return lambda self, other: _Relation(relation(self.formula, _plain(other)), self.trace)


for _name in ("add", "sub", "mul", "truediv", "pow"):
    setattr(_Traced, f"__{_name}__", _arithmetic(getattr(operator, _name), False))
    setattr(_Traced, f"__r{_name}__", _arithmetic(getattr(operator, _name), True))
for _name in ("neg", "abs"):
    setattr(_Traced, f"__{_name}__", _of_itself(getattr(operator, _name)))
for _name, _relation in RELATIONS.items():
    setattr(_Traced, f"__{_name}__", _comparison(_relation))
