"""An automaton as data that JSON can hold, and back; no text is evaluated on the way.

Expressions are a list of *nodes* in the order in which they are made: a symbol, a number, or the name of an
operation and the places of its arguments, which come before it.  Only the operations of `operations` are
made, as they were written, so that the automaton that is read gives the same tape and the same bits.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from functools import cache, lru_cache
from hashlib import sha256
from typing import Any

from frictionlab.automaton import Event, HybridAutomaton, Mode, Reset
from frictionlab.automaton.modes_on_demand import ModesOnDemand
from frictionlab.cache_folder import DIGEST_LENGTH
from frictionlab.lazy_names import sympy as sp
from frictionlab.tape.functions import FUNCTIONS

DERIVED_FROM = "derived from"  # the key of what modes on demand are derived from


@cache
def operations() -> dict[str, Any]:
    """The operations of sympy that files hold, by name."""
    from sympy.functions.elementary.piecewise import ExprCondPair

    of_one = (*(f.expression for f in FUNCTIONS), sp.asin, sp.acos, sp.acosh, sp.atanh, sp.Abs, sp.sign)
    of_two = sp.Add, sp.Mul, sp.Pow, sp.atan2, sp.Heaviside, sp.Max, sp.Min
    conditions = sp.Eq, sp.Ne, sp.Gt, sp.Ge, sp.Lt, sp.Le, sp.And, sp.Or, sp.Not
    every = *of_one, sp.floor, sp.ceiling, *of_two, *conditions, ExprCondPair, sp.Piecewise
    return {operation.__name__: operation for operation in every}


def unevaluated(operation: Any, arguments: Iterable[Any]) -> Any:
    """An operation as it is written: sympy neither sorts nor simplifies it."""
    options = {} if operation.__name__ == "ExprCondPair" else {"evaluate": False}
    return operation(*arguments, **options)


@cache
def constants() -> dict[str, Any]:
    """Constants by name."""
    return {"pi": sp.pi, "E": sp.E, "true": sp.true, "false": sp.false}


class UnknownOperation(ValueError):
    """An expression that the file cannot hold: an unknown operation, or no finite number."""


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


def equations_digest(automaton: HybridAutomaton) -> str:
    """Digest of an automaton's equations; of modes on demand, of some that have all regimes between them."""
    return _digest_of_modes(automaton.modes)


@lru_cache(maxsize=256)
def _digest_of_modes(modes: tuple[Mode, ...] | ModesOnDemand) -> str:
    some = modes.samples() if isinstance(modes, ModesOnDemand) else modes
    writer = _Writer()
    try:
        data = [_mode_to_data(mode, writer) for mode in some]
    except UnknownOperation:
        data = [[str(mode.flow), str(mode.events)] for mode in some]
    return sha256(json.dumps([data, writer.written]).encode()).hexdigest()[:DIGEST_LENGTH]


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
        "period": automaton.period,
        "modes": [_mode_to_data(mode, writer) for mode in automaton.modes],
    }
    data["nodes"] = writer.written
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
        operation = operations().get(type(expr).__name__)
        if operation is not type(expr) or unevaluated(operation, expr.args) != expr:
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
        nodes: list[Any] = []
        for row in data["nodes"]:
            nodes.append(_expression(*row, nodes=nodes))
        return HybridAutomaton(
            _all(nodes, data["states"]),
            tuple(_mode_from_data(mode, nodes) for mode in data["modes"]),
            {nodes[place]: float(value) for place, value in data["parameters"]},
            data["coordinates"],
            tuple(data["cyclic"]),
            data.get("period"),
        )
    except (LookupError, TypeError, AttributeError, NotImplementedError, ArithmeticError) as error:
        raise ValueError(f"the automaton in it is damaged, {error!r}") from error


def _expression(name: str, *about: Any, nodes: list[Any]) -> Any:
    if name in ("Symbol", "Dummy"):
        symbol, assumptions = about
        return (sp.Dummy if name == "Dummy" else sp.Symbol)(symbol, **assumptions)
    if name == "Rational":
        return sp.Rational(*about)
    if name == "Float":
        mantissa, exponent, precision = about
        return sp.Float((int(mantissa < 0), abs(mantissa), exponent), precision=precision)
    if name in constants():
        return constants()[name]
    if name not in operations():
        raise ValueError(f"an expression has the operation {name!r}, which no file of a run holds")
    return unevaluated(operations()[name], _all(nodes, about))


def _all(nodes: list[Any], places: Iterable[int]) -> tuple[Any, ...]:
    """The expressions at some places."""
    return tuple(nodes[place] for place in places)


def _mode_from_data(data: Mapping[str, Any], nodes: list[Any]) -> Mode:
    return Mode(
        data["name"],
        _all(nodes, data["flow"]),
        tuple(_event_from_data(event, nodes) for event in data["events"]),
        _all(nodes, data["constraints"]),
        {name: nodes[place] for name, place in data["outputs"]},
        data["limit"],
    )


def _event_from_data(data: Mapping[str, Any], nodes: list[Any]) -> Event:
    closing = data["accumulation"]
    return Event(
        data["name"],
        nodes[data["function"]],
        tuple(data["targets"]),
        _reset_from_data(data["reset"], nodes),
        None if closing is None else _reset_from_data(closing, nodes),
    )


def _reset_from_data(data: Mapping[str, Any], nodes: list[Any]) -> Reset:
    return Reset(
        {nodes[state]: nodes[place] for state, place in data["jump"]},
        {nodes[place]: count for place, count in data["vanishing"]},
    )
