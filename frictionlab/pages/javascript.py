"""Formulas as JavaScript that computes what Python computes, and the rules that parameters keep.

Each operation is a statement, in the order in which Python computes them, so that numbers are the same to the
last bit.  Powers and functions are calls of the kernels that Python calls too, through the object ``F`` of
``functions.js``.

Bounds of single parameters are in their metadata.  Rules between parameters are Python code: the `check` of a
law or a model.  It is run with values that record the comparisons made with them, once for each combination
of outcomes, so that a page can make the same comparisons with numbers and show the same messages.
"""

from __future__ import annotations

import operator
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from math import isfinite
from typing import Any

from frictionlab.automaton import HybridAutomaton
from frictionlab.components.component import Component, Parameter, check_value, parameters_of, structure_of
from frictionlab.lazy_names import sympy as sp
from frictionlab.models import Model
from frictionlab.models.mechanical.limits import Limit, limits_of
from frictionlab.models.mechanical.mechanical_model import MechanicalModel
from frictionlab.models.model import parameters_about
from frictionlab.models.symbols import symbol
from frictionlab.tape.formulas import (
    ABS,
    AND,
    ATAN2,
    CEILING,
    EQUAL,
    FLOOR,
    FUNCTIONS_BY_KIND,
    INTEGER_POWER,
    LESS,
    LESS_OR_EQUAL,
    MAXIMUM,
    MINIMUM,
    NOT,
    OR,
    REAL_POWER,
    SELECT,
    SIGN,
    STEP,
    Formulas,
    formulas_of,
)
from frictionlab.tape.functions import AFFINE, POWER, PRODUCT, QUOTIENT, SQUARE
from frictionlab.tape.tape import Tape

MAX_OUTCOMES = 64  # combinations of outcomes in one `check`; a page leaves out the rules of one with more
MARK = "\0"  # encloses the places of values in a message


class JavaScript(str):
    """Text that is code; all other text is data."""

    __slots__ = ()


def javascript_function(arguments: Sequence[Sequence[Any]], expressions: Sequence[Any]) -> JavaScript:
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
    '([v0,v1]) => {const v2=v0/v1,v3=Math.sqrt(v2);return [v3];}'
    """
    inputs = [symbol for some in arguments for symbol in some]
    return javascript_of_formulas(formulas_of(inputs, expressions), list(map(len, arguments)))


def javascript_of_formulas(formulas: Formulas, lengths: Sequence[int]) -> JavaScript:
    """Formulas as a JavaScript function of arrays of these lengths, which together are the inputs."""
    names = iter(f"v{i}" for i in range(formulas.tape.inputs))
    head = ", ".join(f"[{','.join(next(names) for _ in range(length))}]" for length in lengths)
    tape = formulas.tape
    lines = [f"v{tape.inputs + i}={_operation(tape, i)}" for i in formulas.needed]
    body = f"const {','.join(lines)};" if lines else ""
    results = ",".join(f"v{slot}" for slot in formulas.outputs)
    return JavaScript(f"({head}) => {{{body}return [{results}];}}")


def _operation(tape: Tape, i: int) -> str:
    kind, a, b = tape.ops[i]
    number = tape.constants[i]
    if kind == AFFINE:
        return _affine(number, [(factor, f"v{slot}") for slot, factor in tape.terms[a:b]])
    template = TEMPLATES.get(kind) or f"F.{FUNCTIONS_BY_KIND[kind].name}({{a}})"
    if kind == POWER and abs(number) == 0.5:
        template = "Math.sqrt({a})" if number > 0.0 else "1/Math.sqrt({a})"
    return template.format(a=f"v{a}", b=f"v{b}", number=_number(number), condition=f"v{int(number)}")


def _affine(constant: float, terms: Sequence[tuple[float, str]]) -> str:
    """A sum, added up in the order in which Python does."""
    (factor, first), *others = terms or [(0.0, "")]
    if not terms:
        return _number(constant)
    text = first if factor == 1.0 else f"{_number(factor)}*{first}"
    if constant != 0.0:
        text = f"{_number(constant)}+{text}"
    for factor, name in others:
        part = name if abs(factor) == 1.0 else f"{_number(abs(factor))}*{name}"
        text += f"{'-' if factor < 0.0 else '+'}{part}"
    return text


def _number(number: float) -> str:
    text = repr(number) if isfinite(number) else "NaN" if number != number else "Infinity"
    return f"({text})" if number < 0.0 else text


# Operations of formulas as JavaScript; others are calls of the kernels by their names.
TEMPLATES = {
    PRODUCT: "{a}*{b}",
    SQUARE: "{a}*{a}",
    QUOTIENT: "{a}/{b}",
    POWER: "F.real_power({a},{number})",
    INTEGER_POWER: "F.integer_power({a},{number})",
    REAL_POWER: "F.real_power({a},{b})",
    ABS: "Math.abs({a})",
    SIGN: "Math.sign({a})",
    FLOOR: "Math.floor({a})",
    CEILING: "Math.ceil({a})",
    ATAN2: "Math.atan2({a},{b})",
    MAXIMUM: "Math.max({a},{b})",
    MINIMUM: "Math.min({a},{b})",
    STEP: "0.5*(1+Math.sign({a}))",
    LESS: "{a}<{b}",
    LESS_OR_EQUAL: "{a}<={b}",
    EQUAL: "{a}==={b}",
    AND: "{a}&&{b}",
    OR: "{a}||{b}",
    NOT: "!{a}",
    SELECT: "{condition}?{a}:{b}",
}


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


def rule_data(model: Model | HybridAutomaton, parameters: tuple[Any, ...]) -> dict[str, Any]:
    """The rules that a page checks, in the order in which Python does; `parameters` are symbols.

    ``numbers`` is a JavaScript function that returns, for one rule after the other, the relations that must
    all hold for its message to be shown, and the values in the message; ``words`` has for each rule the
    number of relations, the number of values, and the message.
    """
    known = set(parameters)
    every = list(_rules_of(model, parameters))
    if isinstance(model, MechanicalModel):
        every += map(_rule_of, limits_of(model))
    rules = [rule for rule in every if set().union(*(x.free_symbols for x in rule.numbers)) <= known]
    words = [
        {"relations": len(rule.broken), "values": len(rule.values), "message": rule.message.split(MARK)}
        for rule in rules
    ]
    numbers = [number for rule in rules for number in rule.numbers]
    return {"numbers": javascript_function([parameters], numbers), "words": words}


def _rules_of(model: Model | HybridAutomaton, parameters: tuple[Any, ...]) -> Iterator[Rule]:
    if isinstance(model, HybridAutomaton):
        about = parameters_about(model)
        for each in parameters:
            yield from _bounds(each, about[each.name])
        return
    for component in (*model.components.values(), model):
        for name, its in parameters_of(type(component)).items():
            yield from _bounds(symbol(name), its)
        yield from _checked(component)


def _bounds(x: Any, about: Parameter) -> Iterator[Rule]:
    """Rules for the bounds of a parameter, with the messages of :func:`check_value`."""
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
            check_value(x.name, value, about)
        except ValueError as error:
            words = str(error).replace(f"got {value}:", f"got {MARK}{MARK}:")
            yield Rule((relation(x, bound),), (x,), words)


def _rule_of(limit: Limit) -> Rule:
    """The rule of a mass, a damper or a normal force."""
    names = re.findall(r"\{(\w+)\}", limit.words)
    values = tuple(limit.value if name == "value" else symbol(name) for name in names)
    relation = sp.Le if limit.above else sp.Lt
    return Rule((relation(limit.value, 0),), values, re.sub(r"\{\w+\}", f"{MARK}g{MARK}", limit.words))


def _checked(component: Component | Model) -> Iterator[Rule]:
    """The rules of a `check`, which raise ValueError; none if it needs more than formulas and comparisons."""
    waiting: list[tuple[bool, ...]] = [()]
    rules: list[Rule] = []
    for _ in range(MAX_OUTCOMES):
        if not waiting:
            yield from rules
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
            rules.append(Rule(tuple(trace.relations), tuple(trace.values), str(error)))
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


def _comparison(relation: str) -> Any:
    return lambda self, other: _Relation(getattr(sp, relation)(self.formula, _plain(other)), self.trace)


for _name in ("add", "sub", "mul", "truediv", "pow"):
    setattr(_Traced, f"__{_name}__", _arithmetic(getattr(operator, _name), False))
    setattr(_Traced, f"__r{_name}__", _arithmetic(getattr(operator, _name), True))
for _name in ("neg", "abs"):
    setattr(_Traced, f"__{_name}__", _of_itself(getattr(operator, _name)))
for _name in ("lt", "le", "gt", "ge", "eq", "ne"):
    setattr(_Traced, f"__{_name}__", _comparison(_name.capitalize()))
