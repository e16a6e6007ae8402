"""An automaton as data that JSON can hold, and back; no text is evaluated on the way.

Expressions are a list of *nodes* in the order in which they are made: a symbol, a number, or the name of an
operation and the places of its arguments, which come before it.  Only the operations of `operations` are
made, as they were written, so that the automaton that is read gives the same tape and the same bits.  A file
may hold anything: its content and its size are checked before sympy sees it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

from frictionlab.automaton import Event, HybridAutomaton, Mode, Reset
from frictionlab.automaton.mode import ModesOnDemand
from frictionlab.lazy_names import sympy as sp
from frictionlab.tape.functions import FUNCTIONS

MAX_NODES = 200_000  # of all expressions together
MAX_DEPTH = 200  # of operations within operations: sympy's functions call each other to that depth
MAX_SIZE = 1e6  # operations of an expression written out, with nothing shared
MAX_BITS = 1e6  # of an exact number: powers of integers are computed exactly
MAX_TERMS = 1e5  # of an event function or constraint multiplied out, which shows what vanishes
SYMBOL_BITS, MAX_PRECISION, MAX_EXPONENT = 64, 4096, 100_000
MAX_CHARACTERS = 200  # of a name

DERIVED_FROM = "derived from"  # the key of what modes on demand are derived from
NUMBER, TRUTH, PAIR = "number", "truth", "pair"


@dataclass(frozen=True)
class Operation:
    """An operation of sympy: how many arguments it takes, of what kinds, and what it gives."""

    make: Callable[..., Any]
    least: int
    most: float = math.inf
    takes: tuple[str, ...] = (NUMBER,)  # the last kind is that of all further arguments
    gives: str = NUMBER

    def unevaluated(self, arguments: Iterable[Any]) -> Any:
        """The operation as it is written: sympy neither sorts nor simplifies it."""
        options = {} if self.gives == PAIR else {"evaluate": False}
        return self.make(*arguments, **options)


@cache
def operations() -> dict[str, Operation]:
    """All operations by name."""
    from sympy.functions.elementary.piecewise import ExprCondPair

    relations = sp.Eq, sp.Ne, sp.Gt, sp.Ge, sp.Lt, sp.Le
    of_one = (*(f.expression for f in FUNCTIONS), sp.asin, sp.acos, sp.acosh, sp.atanh, sp.Abs, sp.sign)
    found = (
        Operation(sp.Add, 2),
        Operation(sp.Mul, 2),
        Operation(sp.Pow, 2, 2),
        *(Operation(function, 1, 1) for function in (*of_one, sp.floor, sp.ceiling)),
        Operation(sp.atan2, 2, 2),
        Operation(sp.Heaviside, 2, 2),
        Operation(sp.Max, 2),
        Operation(sp.Min, 2),
        *(Operation(relation, 2, 2, gives=TRUTH) for relation in relations),
        Operation(sp.And, 2, takes=(TRUTH,), gives=TRUTH),
        Operation(sp.Or, 2, takes=(TRUTH,), gives=TRUTH),
        Operation(sp.Not, 1, 1, takes=(TRUTH,), gives=TRUTH),
        Operation(ExprCondPair, 2, 2, (NUMBER, TRUTH), PAIR),
        Operation(sp.Piecewise, 1, takes=(PAIR,)),
    )
    return {operation.make.__name__: operation for operation in found}


@cache
def constants() -> dict[str, Any]:
    """Constants by name."""
    return {"pi": sp.pi, "E": sp.E, "true": sp.true, "false": sp.false}


class UnknownOperation(ValueError):
    """An expression that the file cannot hold: an unknown operation, too many terms, or no finite number."""


@dataclass(frozen=True)
class Node:
    """An expression with the measures of its size, which MAX_DEPTH and the constants after it limit."""

    expression: Any
    kind: str = NUMBER
    depth: int = 1
    size: int = 1
    bits: int = SYMBOL_BITS
    terms: int = 1


# --- to data


def storable_automaton(automaton: HybridAutomaton) -> dict[str, Any] | str:
    """The automaton as data that JSON can hold, or the reason why there is none, as text.

    There may be 3^30 modes on demand; for these the data is what they are derived from.
    """
    modes = automaton.modes
    try:
        if not isinstance(modes, ModesOnDemand):
            return automaton_to_data(automaton)
        if modes.origin is None:
            return "as its modes are derived by a function of the session that made it"
        return {DERIVED_FROM: modes.origin(), "coordinates": automaton.coordinates}
    except (UnknownOperation, TypeError) as error:
        return f"as {error}"


def automaton_to_data(automaton: HybridAutomaton) -> dict[str, Any]:
    """The automaton as data that JSON can hold.

    Raises
    ------
    UnknownOperation
        Where an expression has an operation that is not in `operations`, or is too long.
    """
    writer = _Writer()
    data = {
        "states": writer.nodes(automaton.states),
        "parameters": [[writer.node(symbol), float(v)] for symbol, v in automaton.parameters.items()],
        "coordinates": automaton.coordinates,
        "cyclic": list(automaton.cyclic),
        "modes": [_mode_to_data(mode, writer) for mode in automaton.modes],
    }
    data["nodes"] = writer.written
    try:
        automaton_from_data(data)
    except ValueError as error:  # too long, or not reproduced as it was
        raise UnknownOperation(str(error)) from error
    return data


def _mode_to_data(mode: Mode, writer: _Writer) -> dict[str, Any]:
    return {
        "name": mode.name,
        "flow": writer.nodes(mode.flow),
        "events": [_event_to_data(event, writer) for event in mode.events],
        "constraints": writer.nodes(mode.constraints),
        "outputs": [[name, writer.node(expr)] for name, expr in mode.outputs.items()],
        "limit": bool(mode.limit),
    }


def _event_to_data(event: Event, writer: _Writer) -> dict[str, Any]:
    resets = {"reset": event.reset, "accumulation": event.accumulation}
    return {
        "name": event.name,
        "function": writer.node(event.function),
        "targets": list(event.targets),
        **{name: None if r is None else _reset_to_data(r, writer) for name, r in resets.items()},
    }


def _reset_to_data(reset: Reset, writer: _Writer) -> dict[str, Any]:
    return {
        "jump": [writer.nodes(pair) for pair in reset.jump.items()],
        "vanishing": [[writer.node(function), int(count)] for function, count in reset.vanishing.items()],
    }


class _Writer:
    """The nodes written so far; equal expressions share one."""

    def __init__(self) -> None:
        self.written: list[list[Any]] = []
        self._places: dict[Any, int] = {}

    def nodes(self, expressions: Iterable[Any]) -> list[int]:
        """Places of the nodes of some expressions."""
        return [self.node(expr) for expr in expressions]

    def node(self, expression: Any) -> int:
        """Place of the node of an expression; nodes that are missing are written first."""
        stack = [sp.sympify(expression, strict=True)]
        while stack:
            expr = stack[-1]
            # known by type too: 2 and 2.0 are equal in some versions of sympy, and differ in bits
            missing = [arg for arg in _arguments(expr) if _key(arg) not in self._places]
            if missing:
                stack += missing
                continue
            stack.pop()
            if _key(expr) not in self._places:
                self._places[_key(expr)] = len(self.written)
                self.written.append(self._row(expr))
        return self._places[_key(sp.sympify(expression, strict=True))]

    def _row(self, expr: Any) -> list[Any]:
        if type(expr) in (sp.Symbol, sp.Dummy):
            return [type(expr).__name__, expr.name, dict(expr.assumptions0)]
        if expr.is_Integer or expr.is_Rational:
            return ["Rational", int(expr.p), int(expr.q)]
        if expr.is_Float:
            sign, mantissa, exponent, _ = map(int, expr._mpf_)  # the public `num` rounds it to a float
            if mantissa == 0 and exponent:
                raise UnknownOperation(f"{expr} is no finite number")
            return ["Float", -mantissa if sign else mantissa, exponent, expr._prec]
        name = next((name for name, constant in constants().items() if constant is expr), None)
        if name is not None:
            return [name]
        known = operations().get(type(expr).__name__)
        if known is None or known.make is not type(expr) or known.unevaluated(expr.args) != expr:
            raise UnknownOperation(f"the file of a run has no operation for {expr}")
        return [type(expr).__name__, *(self._places[_key(arg)] for arg in expr.args)]


def _arguments(expr: Any) -> tuple[Any, ...]:
    return () if expr.is_Atom else expr.args


def _key(expr: Any) -> tuple[type, Any]:
    return type(expr), expr


# --- from data


def automaton_from_data(data: Mapping[str, Any]) -> HybridAutomaton:
    """The automaton that :func:`automaton_to_data` described.

    Raises
    ------
    ValueError
        For anything that is not such data.
    """
    try:
        nodes = _nodes_from_data(data["nodes"])
        return HybridAutomaton(
            tuple(_symbol(nodes, place) for place in data["states"]),
            tuple(_mode_from_data(mode, nodes) for mode in data["modes"]),
            {_symbol(nodes, place): _finite(value) for place, value in data["parameters"]},
            _whole(data["coordinates"], 0, len(data["states"])),
            tuple(data.get("cyclic", ())),
        )
    except (KeyError, TypeError, AttributeError, IndexError, NotImplementedError, OverflowError) as error:
        raise ValueError(f"the automaton in it is damaged, {error!r}") from error


def _nodes_from_data(rows: Sequence[Sequence[Any]]) -> list[Node]:
    if len(rows) > MAX_NODES:
        raise ValueError(f"its expressions have {len(rows)} parts, more than {MAX_NODES}")
    nodes: list[Node] = []
    for row in rows:
        nodes.append(_node(row, nodes))
    return nodes


def _node(row: Sequence[Any], nodes: list[Node]) -> Node:
    name, *about = row
    if name in ("Symbol", "Dummy"):
        return Node(_symbol_from_data(name, *about))
    if name == "Rational":
        p, q = (_whole(each) for each in about)
        if q < 1:
            raise ValueError(f"a fraction has the denominator {q}")
        return Node(sp.Rational(p, q), bits=p.bit_length() + q.bit_length())
    if name == "Float":
        return Node(_float_from_data(*about))
    if name in constants():
        return Node(constants()[name], TRUTH if name in ("true", "false") else NUMBER)
    if name not in operations():
        raise ValueError(f"an expression has the operation {name!r}, which no file of a run holds")
    return _operation_from_data(
        operations()[name], [nodes[_whole(place, 0, len(nodes) - 1)] for place in about]
    )


def _operation_from_data(operation: Operation, of: list[Node]) -> Node:
    takes = [operation.takes[min(i, len(operation.takes) - 1)] for i in range(len(of))]
    if not operation.least <= len(of) <= operation.most or takes != [node.kind for node in of]:
        name = operation.make.__name__
        raise ValueError(f"{name} is of {len(of)} arguments, {', '.join(node.kind for node in of)}")
    bits, terms = _growth(operation.make, of)
    depth, size = 1 + max(node.depth for node in of), 1 + sum(node.size for node in of)
    if depth > MAX_DEPTH or size > MAX_SIZE or bits > MAX_BITS:
        raise ValueError(
            f"an expression is too long, of depth {depth}, size {size} and numbers of {bits} bits"
        )
    arguments = [node.expression for node in of]
    made = operation.unevaluated(arguments)
    if type(made) is not operation.make or len(made.args) != len(of):
        raise ValueError(f"{operation.make.__name__} cannot be made of {arguments}")
    return Node(made, operation.gives, depth, size, bits, terms)


def _growth(make: Any, of: list[Node]) -> tuple[int, int]:
    """Upper bounds of the bits of exact numbers, and of the terms of the expression multiplied out."""
    bits, terms = sum(node.bits for node in of), sum(node.terms for node in of)
    if make is sp.Mul:
        return bits, min(math.prod(node.terms for node in of), int(MAX_TERMS) + 1)
    if make is sp.Pow and of[1].expression.is_Integer:
        base, exponent = of[0], abs(int(of[1].expression))
        bits = max(base.bits * exponent, 1)
        if bits <= MAX_BITS and base.terms > 1:
            terms = min(math.comb(base.terms + exponent - 1, exponent), int(MAX_TERMS) + 1)
        return bits, terms
    return (bits, terms) if make in (sp.Add, sp.Pow) else (max(SYMBOL_BITS, bits), terms)


def _symbol_from_data(kind: str, name: Any, assumptions: Mapping[str, Any]) -> Any:
    given = assumptions.items()
    if not all(isinstance(key, str) and isinstance(value, (bool, type(None))) for key, value in given):
        raise ValueError(f"the assumptions of the symbol {name!r} must be true or false")
    return (sp.Dummy if kind == "Dummy" else sp.Symbol)(_text(name), **assumptions)


def _float_from_data(mantissa: Any, exponent: Any, precision: Any) -> Any:
    precision, exponent = _whole(precision, 1, MAX_PRECISION), _whole(exponent, -MAX_EXPONENT, MAX_EXPONENT)
    mantissa = _whole(mantissa)
    if mantissa.bit_length() > precision:
        raise ValueError(f"a number of {precision} bits has {mantissa.bit_length()}")
    return sp.Float((int(mantissa < 0), abs(mantissa), exponent), precision=precision)


def _mode_from_data(data: Mapping[str, Any], nodes: list[Node]) -> Mode:
    return Mode(
        _text(data["name"]),
        tuple(_number(nodes, place) for place in data["flow"]),
        tuple(_event_from_data(event, nodes) for event in data["events"]),
        tuple(_expanded(nodes, place) for place in data["constraints"]),
        {_text(name): _number(nodes, place) for name, place in data["outputs"]},
        _one_of(data["limit"], (True, False)),
    )


def _event_from_data(data: Mapping[str, Any], nodes: list[Node]) -> Event:
    accumulation = data["accumulation"]
    return Event(
        _text(data["name"]),
        _expanded(nodes, data["function"]),
        tuple(_text(name) for name in data["targets"]),
        _reset_from_data(data["reset"], nodes),
        None if accumulation is None else _reset_from_data(accumulation, nodes),
    )


def _reset_from_data(data: Mapping[str, Any], nodes: list[Node]) -> Reset:
    return Reset(
        {_symbol(nodes, state): _number(nodes, place) for state, place in data["jump"]},
        {_expanded(nodes, place): _whole(count, 0, MAX_DEPTH) for place, count in data["vanishing"]},
    )


def _number(nodes: list[Node], place: Any) -> Any:
    node = nodes[_whole(place, 0, len(nodes) - 1)]
    if node.kind != NUMBER:
        raise ValueError(f"{node.expression} must be a number")
    return node.expression


def _expanded(nodes: list[Node], place: Any) -> Any:
    """An expression that will be multiplied out; raises ValueError where that gives too many terms."""
    expression = _number(nodes, place)
    if nodes[place].terms > MAX_TERMS:
        raise ValueError(f"an event function or constraint has more than {MAX_TERMS:g} terms, multiplied out")
    return expression


def _symbol(nodes: list[Node], place: Any) -> Any:
    expression = _number(nodes, place)
    if not expression.is_Symbol:
        raise ValueError(f"{expression} must be a symbol")
    return expression


def _whole(value: Any, least: float = -math.inf, most: float = math.inf) -> int:
    if type(value) is not int or not least <= value <= most:
        raise ValueError(f"an integer from {least} to {most} is {value!r}")
    return value


def _finite(value: Any) -> float:
    if type(value) not in (int, float) or not math.isfinite(value):
        raise ValueError(f"a parameter is {value!r}, which is no finite number")
    return float(value)


def _text(value: Any) -> str:
    if not isinstance(value, str) or len(value) > MAX_CHARACTERS:
        raise ValueError(f"a name must be a text of at most {MAX_CHARACTERS} characters")
    return value


def _one_of(value: Any, choices: tuple[Any, ...]) -> Any:
    if not any(value is choice for choice in choices):
        raise ValueError(f"{value!r} must be one of {choices}")
    return value
