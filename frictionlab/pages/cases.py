"""Python code that asks for parameters, as cases of formulas: the rules of a model, and its picture.

The `check` of a law or a model and the `mechanism` of a model are Python code.  It is run with formulas in
place of numbers, which record the comparisons made with them, once for each combination of outcomes.  Each
combination is a case: relations that hold in it, and what the code gives.  A page evaluates relations and
formulas, and takes the first case all of whose relations hold.
"""

from __future__ import annotations

import math
import operator
import re
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeVar

from frictionlab.automaton import HybridAutomaton
from frictionlab.components.component import Component, Parameter, check_value, parameters_of, structure_of
from frictionlab.lazy_names import sympy as sp
from frictionlab.models import Model
from frictionlab.models.mechanical.limits import Limit, limits_of
from frictionlab.models.mechanical.mechanical_model import MechanicalModel
from frictionlab.models.model import parameters_about
from frictionlab.models.symbols import symbol
from frictionlab.pages.javascript import javascript_function
from frictionlab.pages.scene import MARK, Data, Shown, mechanism_data
from frictionlab.validation import with_article

T = TypeVar("T")
MAX_OUTCOMES = 64  # combinations of outcomes of one piece of code; with more it is left to Python
FORMATS = re.compile(r"((\.[0-5]?\d)?[efg])?")  # of numbers in words, as pages write them
FORCE = Parameter(exclusive_minimum=0.0)  # a normal force that is given


@dataclass(frozen=True)
class Rule:
    """A rule that is broken where all relations in `broken` hold; marks in the message stand for values."""

    broken: tuple[Any, ...]
    values: tuple[Any, ...]
    message: str

    def renamed(self, symbols: Mapping[Any, Any]) -> Rule:
        """The same rule of other symbols."""
        broken, values = (tuple(x.xreplace(symbols) for x in part) for part in (self.broken, self.values))
        return Rule(broken, values, self.message)


def rule_data(model: Shown, parameters: tuple[Any, ...]) -> Data:
    """The rules that a page checks, in the order in which Python does; `parameters` are symbols.

    ``numbers`` is a JavaScript function that returns relations and values; each of the ``cases`` has the
    places of its relations ``when`` its ``message`` is shown.
    """
    known = set(parameters)
    every = list(_rules_of(model, parameters))
    if isinstance(model, MechanicalModel):
        every += map(_rule_of, limits_of(model))
    numbers: list[Any] = []
    cases = [
        {"when": _places(rule.broken, numbers), "message": _text(rule.message, rule.values, numbers)}
        for rule in every
        if set().union(*(x.free_symbols for x in (*rule.broken, *rule.values))) <= known
    ]
    return {"numbers": javascript_function([parameters], numbers), "cases": cases}


def picture_data(model: Shown, parameters: tuple[Any, ...]) -> Data | None:
    """The model's picture on a page, as :func:`rule_data` has rules; None where it has none.

    In the ``parts`` of a case a list stands for the number at this place.  A picture that takes no formulas
    is the present one, and a warning says so.
    """
    present = mechanism_data(model)
    if not isinstance(model, Model) or not present:
        return None
    numbers: list[Any] = []
    try:
        cases = [
            {"when": _places(trace.relations, numbers), "parts": _placed(parts, trace.values, numbers)}
            for trace, parts in _outcomes(model, mechanism_data)
        ]
        return {"numbers": javascript_function([parameters], numbers), "cases": cases}
    except Exception as error:  # any that functions of numbers raise
        warnings.warn(
            f"the picture of {with_article(type(model))} does not follow its page's sliders ({error}): make "
            "its numbers by arithmetic, comparisons, numpy's functions and fl.functions",
            RuntimeWarning,
            stacklevel=2,
        )
    return {"numbers": javascript_function([parameters], []), "cases": [{"when": [], "parts": present}]}


def _places(formulas: Sequence[Any], numbers: list[Any]) -> list[int]:
    """The places that formulas get in `numbers`, to which they are added."""
    numbers += formulas
    return list(range(len(numbers) - len(formulas), len(numbers)))


def _text(text: str, values: Sequence[Any], numbers: list[Any]) -> list[Any]:
    """A text in parts; between marks it has the number of a value and its format, as "0:g"."""
    first, *others = text.split(MARK)
    parts: list[Any] = [first]
    for about, following in zip(others[::2], others[1::2], strict=True):
        number, _, form = about.partition(":")
        parts += [[*_places([values[int(number)]], numbers), form], following]
    return parts


def _placed(field: Any, values: Sequence[Any], numbers: list[Any]) -> Any:
    """A field of a picture, where each formula is a list of its place in `numbers`."""
    if hasattr(field, "free_symbols"):
        return _places([_plain(field)], numbers)
    if isinstance(field, list):
        return [_placed(each, values, numbers) for each in field]
    if isinstance(field, dict):
        return {name: _placed(each, values, numbers) for name, each in field.items()}
    if isinstance(field, str) and MARK in field:
        for about in field.split(MARK)[1::2]:
            form = about.partition(":")[2]
            if not FORMATS.fullmatch(form):
                raise TypeError(f'numbers in words have formats such as ".3g", ".2f" or ".1e", got "{form}"')
        return {"text": _text(field, values, numbers)}
    if isinstance(field, _Relation):
        raise TypeError("a comparison is no number")
    return field


def _rules_of(model: Model | HybridAutomaton, parameters: tuple[Any, ...]) -> Iterator[Rule]:
    if isinstance(model, HybridAutomaton):
        about = parameters_about(model)
        for each in parameters:
            yield from _bounds(each, about[each.name])
        yield from () if model.source is None else _rules_of_structure(model.source)
        return
    for component in (*model.components.values(), model):
        yield from _rules_of_component(component)


def _rules_of_structure(structure: Any) -> Iterator[Rule]:
    """Those of its damping, and of its contacts' laws, whose parameters may have names of their own."""
    if isinstance(structure.C, Component):
        yield from _rules_of_component(structure.C)
    for contacts in structure.contacts:
        for law in contacts.laws:
            own = {symbol(name): symbol(contacts.parameter(name)) for name in parameters_of(type(law))}
            yield from (rule.renamed(own) for rule in _rules_of_component(law))
        yield from _bounds(symbol(contacts.parameter("N")), FORCE)


def _rules_of_component(component: Component | Model) -> Iterator[Rule]:
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
            words = str(error).replace(f"got {value}:", f"got {MARK}0:{MARK}:")
            yield Rule((relation(x, bound),), (x,), words)


def _rule_of(limit: Limit) -> Rule:
    """The rule of a mass, a load, a damper or a normal force."""
    names = re.findall(r"\{(\w+)\}", limit.words)
    values = tuple(limit.value if name == "value" else symbol(name) for name in names)
    relation, count = sp.Le if limit.above else sp.Lt, iter(range(len(names)))
    words = re.sub(r"\{\w+\}", lambda _: f"{MARK}{next(count)}:g{MARK}", limit.words)
    return Rule((relation(limit.value, 0),), values, words)


def _checked(component: Component | Model) -> list[Rule]:
    """The rules of a `check`, which raise ValueError; none if it needs more than formulas and comparisons."""
    try:
        outcomes = _outcomes(component, _message)
    except (TypeError, AttributeError, ArithmeticError):
        return []
    return [Rule(tuple(trace.relations), tuple(trace.values), said) for trace, said in outcomes if said]


def _message(component: Component | Model) -> str:
    try:
        component.check()
    except ValueError as error:
        return str(error)
    return ""


def _outcomes(component: Component | Model, ask: Callable[[Any], T]) -> list[tuple[_Trace, T]]:
    """What `ask` returns of a component whose parameters are formulas, for each combination of outcomes.

    Raises
    ------
    OverflowError
        Where there are more than 64 combinations.
    """
    waiting: list[tuple[bool, ...]] = [()]
    known: list[tuple[_Trace, T]] = []
    while waiting:
        if len(known) == MAX_OUTCOMES:
            raise OverflowError(f"it has more than {MAX_OUTCOMES} combinations of outcomes")
        trace = _Trace(waiting.pop())
        known.append((trace, ask(_copy_of_formulas(component, trace))))
        waiting += trace.others()
    return known


def _copy_of_formulas(component: Any, trace: _Trace) -> Any:
    copy = object.__new__(type(component))
    for name in parameters_of(type(component)):
        object.__setattr__(copy, name, _Traced(symbol(name), trace))
    for name in structure_of(type(component)):
        value = getattr(component, name)
        part = _copy_of_formulas(value, trace) if isinstance(value, Component) else value
        object.__setattr__(copy, name, part)
    return copy


@dataclass
class _Trace:
    """One run of the code: its first comparisons have given outcomes, the others are false.

    It records the relations that held so, and the values in its texts.
    """

    given: tuple[bool, ...]
    relations: list[Any] = field(default_factory=list)
    values: list[Any] = field(default_factory=list)

    def outcome(self, relation: Any) -> bool:
        place = len(self.relations)
        if (
            place == MAX_OUTCOMES
        ):  # each has another outcome: there are more combinations, or a loop is endless
            raise OverflowError(f"it has more than {MAX_OUTCOMES} combinations of outcomes")
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

    def __format__(self, spec: str) -> str:
        return format(bool(self), spec)

    def __repr__(self) -> str:
        return repr(bool(self))


class _Traced:
    """A number as a formula of parameters; its comparisons, and its places in messages, are recorded."""

    __hash__ = None  # type: ignore[assignment]  # as == gives a _Relation

    def __init__(self, formula: Any, trace: _Trace) -> None:
        self.formula, self.trace = formula, trace

    @property
    def free_symbols(self) -> set[Any]:  # by which `fl.functions` know expressions
        return self.formula.free_symbols

    def _sympy_(self) -> Any:
        return self.formula

    def __format__(self, spec: str) -> str:
        self.trace.values.append(self.formula)
        return f"{MARK}{len(self.trace.values) - 1}:{spec}{MARK}"

    def __repr__(self) -> str:
        return format(self, "")

    __str__ = __repr__

    def __bool__(self) -> bool:
        return bool(_Relation(sp.Ne(self.formula, 0), self.trace))


def _plain(value: Any) -> Any:
    return value.formula if isinstance(value, _Traced) else sp.sympify(value, strict=True)


def _arithmetic(operation: Any, swapped: bool = False) -> Any:
    def method(self: _Traced, other: Any) -> _Traced:
        pair = (_plain(other), self.formula) if swapped else (self.formula, _plain(other))
        return _Traced(operation(*pair), self.trace)

    return method


def _of_itself(operation: Any) -> Any:
    return lambda self: _Traced(operation(self.formula), self.trace)


def _comparison(relation: str) -> Any:
    return lambda self, other: _Relation(getattr(sp, relation)(self.formula, _plain(other)), self.trace)


for _name in ("add", "sub", "mul", "truediv", "pow"):
    setattr(_Traced, f"__{_name}__", _arithmetic(getattr(operator, _name)))
    setattr(_Traced, f"__r{_name}__", _arithmetic(getattr(operator, _name), swapped=True))
for _name in ("neg", "abs"):
    setattr(_Traced, f"__{_name}__", _of_itself(getattr(operator, _name)))
for _name in ("lt", "le", "gt", "ge", "eq", "ne"):
    setattr(_Traced, f"__{_name}__", _comparison(_name.capitalize()))
# numpy's functions call the methods of an object that have their names.
for _name in ("sqrt", "exp", "log", "sin", "cos", "tan", "sinh", "cosh", "tanh"):
    setattr(_Traced, _name, _of_itself(lambda x, name=_name: getattr(sp, name)(x)))
for _name in ("sin", "cos", "tan", "sinh"):
    setattr(_Traced, f"arc{_name}", _of_itself(lambda x, name=_name: getattr(sp, f"a{name}")(x)))
for _name in ("deg2rad", "radians"):
    setattr(_Traced, _name, _of_itself(lambda x: x * (math.pi / 180)))
for _name, _operation in {
    "arctan2": lambda y, x: sp.atan2(y, x),
    "hypot": lambda x, y: sp.sqrt(x**2 + y**2),
}.items():
    setattr(_Traced, _name, _arithmetic(_operation))
