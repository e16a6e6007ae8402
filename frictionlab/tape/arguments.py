"""What the solver is given: an automaton, and expressions as text, such as a section "x1 - x2'".

An automaton is checked before any work is done; one that is not well formed gives one clear error.  Text is
read by a parser that knows nothing but arithmetic and functions of one argument.  sympy's own parser runs its
text as Python, and computes 9**9**9.  This one walks the syntax tree of the text, accepts numbers, the names
it is given, + - * / **, parentheses and the functions, and bounds the length of the text, the numbers and the
exponents.
"""

from __future__ import annotations

import ast
import operator
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import lru_cache
from math import isfinite
from typing import Any

from frictionlab.automaton import Event, HybridAutomaton, Mode
from frictionlab.automaton.mode import Symbol
from frictionlab.lazy_names import sympy as sp
from frictionlab.presentation import shorten
from frictionlab.tape.tape import is_matrix_row
from frictionlab.validation import MAX_CHARACTERS, abbreviate, check_number, did_you_mean_or_known

GROWING_FUNCTIONS = "exp", "sinh", "cosh"
FUNCTIONS = (
    *GROWING_FUNCTIONS,
    "log",
    "sqrt",
    "sin",
    "cos",
    "tan",
    "tanh",
    "atan",
    "asinh",
)  # as sympy calls them
NAME_PATTERN = re.compile(  # x' is the rate of x; a function is no name where it is called
    rf"(?<![\w.])(?!(?:{'|'.join(FUNCTIONS)})\s*\()[A-Za-z_]\w*'?"
)
# Columns of tables of runs and their events, beside states and outputs.
COLUMNS = re.compile(r"mode|source|target|guard|closed|(friction_)?impulse(_\d+)?")
MAX_LENGTH = 1000  # characters; a text that a person wrote is shorter
MAX_EXPONENT = 100  # a power becomes at most as many products
MAX_NUMBER = 1e300  # within the range of double precision, with room for products
OPERATIONS: dict[type, Callable[..., Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.UAdd: operator.pos,
    ast.USub: operator.neg,
}
TIME_NAMES = "t", "time"  # what users call time
ARITHMETIC = f"numbers, names, + - * / **, parentheses, {', '.join(FUNCTIONS)} are all that it may hold"


def check_automaton(automaton: Any) -> None:
    """Raise TypeError for what is no automaton, ValueError for a parameter that is no finite number."""
    if not isinstance(automaton, HybridAutomaton):
        cure = "write solve(automaton, t_end, x0=...)"
        cure = "use fl.simulate for a model" if hasattr(automaton, "automaton") else cure
        raise TypeError(f"automaton must be a HybridAutomaton, got {abbreviate(automaton)}: {cure}")
    _check_values(automaton)


@lru_cache(maxsize=64)  # an automaton never changes
def _check_values(automaton: HybridAutomaton) -> None:
    for name, value in automaton.values.items():
        if type(value) is float and isfinite(value):  # the quick case, that of models
            continue
        number = float(value) if getattr(value, "is_real", False) else value  # of sympy, such as pi
        check_number(f"the parameter {name}", number, cure=f"give it one, such as replace({name}=1.0)")


def check_structure(
    states: Sequence[Symbol],
    modes: Sequence[Mode],
    parameters: Sequence[Symbol],
    coordinates: int,
) -> None:
    """Raise ValueError unless the structure is well formed; it says what was got, expected, and the cure."""
    names = [mode.name for mode in modes]
    if not modes:
        raise ValueError("an automaton needs at least one mode, got none: add a frictionlab.Mode")
    if len(set(names)) < len(names):
        raise ValueError(f"mode names must differ, got {names}: rename one")
    if not 0 <= 2 * coordinates <= len(states):
        raise ValueError(
            f"coordinates must leave room for as many velocities among the {len(states)} states, "
            f"got {coordinates}: list the coordinates first, then their velocities"
        )
    symbols = [symbol.name for symbol in (*states, *parameters)]
    if len({*symbols}) < len(symbols):
        twice = sorted({name for name in symbols if symbols.count(name) > 1})
        raise ValueError(f"states and parameters must have different names, got {twice} twice: rename one")
    for mode in modes:
        if {*mode.outputs} != {*modes[0].outputs}:
            raise ValueError(
                f"every mode must have the same outputs, got {abbreviate([*mode.outputs])} in {mode.name!r} "
                f"and {abbreviate([*modes[0].outputs])} in {modes[0].name!r}: give each mode all of them"
            )
    shown = modes[0].outputs  # with the states and those of COLUMNS the columns of tables
    if taken := [name for name in symbols[: len(states)] if name in shown or COLUMNS.fullmatch(name)]:
        raise ValueError(
            f"a state must not be named like an output ({', '.join(shown) or 'there is none'}) or another "
            f"column of tables (mode, source, target, guard, closed, impulse), got {taken[0]!r}: rename it"
        )
    context = tuple(names), tuple(states), frozenset((*states, *parameters)), dict[int, Any]()
    for mode in modes:
        check_mode(mode, *context)


def check_section_or_quadrature(name: str, function: Any, automaton: HybridAutomaton) -> None:
    """Raise ValueError where a section or quadrature asks for what the automaton does not have."""
    outputs = automaton.outputs
    symbols = {*automaton.states, *automaton.parameters}
    if isinstance(function, str):
        strange = [] if function in outputs else [function]
    else:
        strange = sorted(map(str, _symbols(name, function) - symbols))
    if strange:
        raise ValueError(
            f"the section or quadrature {name!r} uses {strange}: write it with the states and parameters "
            f"({', '.join(sorted(map(str, symbols)))}), or give an output's name "
            f"({', '.join(outputs) or 'there is none'})"
        )


def _symbols(name: str, function: Any) -> set:
    try:
        return sp.sympify(function, strict=True).free_symbols
    except (AttributeError, TypeError, sp.SympifyError):
        raise ValueError(
            f"the section or quadrature {name!r} must be an expression of the states, or an output's name, "
            f"got {abbreviate(function)}: write it with the automaton's symbols"
        ) from None


def check_mode(
    mode: Mode,
    names: Sequence[str],
    states: tuple[Symbol, ...],
    allowed: frozenset[Symbol],
    sound: dict[int, Any],
) -> None:
    """Raise ValueError, or TypeError for a text, unless a mode is well formed.

    `names` are those of all modes, `known` are the states and parameters.  `sound` has the expressions of the
    modes before, by their identity.
    """
    if len(mode.flow) != len(states):
        raise ValueError(
            f"the flow of mode {abbreviate(mode.name)} must have one expression per state ({len(states)}), "
            f"got {len(mode.flow)}: give each state its time derivative"
        )
    for event in mode.events:
        if unknown := [name for name in event.targets if name not in names]:
            raise ValueError(
                f"event {event.name!r} of mode {abbreviate(mode.name)} leads to {abbreviate(unknown)}, "
                f"but the modes are {abbreviate(list(names))}: correct its targets"
            )
        _check_resets(event, mode, states)
    for what, expr in _expressions(mode):
        whole = expr.product if is_matrix_row(expr) else expr  # all rows have the symbols of their product
        if id(whole) in sound:
            continue
        if isinstance(expr, str):  # which sympy would run as Python
            raise TypeError(
                f"{what} of mode {abbreviate(mode.name)} must be an expression, got the text "
                f"{abbreviate(expr)}: "
                "write it with the automaton's symbols"
            )
        if strange := _free_symbols(what, mode, expr) - allowed:
            raise ValueError(
                f"{what} of mode {abbreviate(mode.name)} uses {sorted(map(str, strange))}, "
                "which is neither a state "
                f"nor a parameter: {_cure_of_unknown(strange, allowed)}"
            )
        sound[id(whole)] = whole


def _cure_of_unknown(strange: set[Any], known: Iterable[Any]) -> str:
    if not {*map(str, strange)}.isdisjoint(map(str, known)):
        return "take the symbol that the automaton holds, with the same assumptions"
    if any(str(each) in TIME_NAMES for each in strange):  # as a parameter, time would stand still
        return (
            "for a force that depends on time give Mechanics its frequency, and write cos(q.phase), or q.t; "
            "in an automaton add a state whose rate is 1, or the angular frequency"
        )
    return "add it to the automaton's parameters"


def _free_symbols(what: str, mode: Mode, expr: Any) -> set:
    try:
        expression = sp.sympify(expr, strict=True)
        if not isinstance(expression, sp.Expr):
            raise TypeError
        return expression.free_symbols
    except (TypeError, ValueError, AttributeError, OverflowError):  # SympifyError is a ValueError
        raise TypeError(
            f"{what} of mode {abbreviate(mode.name)} must be an expression, got {abbreviate(expr)}: "
            "write it with the automaton's symbols"
        ) from None


def _check_resets(event: Event, mode: Mode, states: tuple[Symbol, ...]) -> None:
    for reset in filter(None, (event.reset, event.accumulation)):
        if strange := [symbol for symbol in reset.jump if symbol not in states]:
            listed = shorten(str(symbol)[:MAX_CHARACTERS] for symbol in strange)
            raise ValueError(
                f"the reset of event {event.name!r} of mode {abbreviate(mode.name)} may give values to "
                "states only "
                f"({', '.join(sorted(map(str, states)))}), got one for {listed}: "
                "take the symbol that the automaton's states hold, with the same assumptions"
            )


def _as_function(mode: Mode, what: str, expr: Any) -> Any:
    """The expression, if it is one: a plain number or a text cannot be followed to its zero."""
    if not hasattr(type(expr), "free_symbols"):
        kind = "the text " if isinstance(expr, str) else ""
        raise TypeError(
            f"{what} of mode {abbreviate(mode.name)} must be an expression, got {kind}{abbreviate(expr)}: "
            "write it with the automaton's symbols"
        )
    return expr


def _expressions(mode: Mode):
    yield from (("the flow", expr) for expr in mode.flow)
    yield from (("a constraint", _as_function(mode, "a constraint", expr)) for expr in mode.constraints)
    yield from ((f"output {name!r}", expr) for name, expr in mode.outputs.items())
    for event in mode.events:
        yield f"event {event.name!r}", _as_function(mode, f"event {event.name!r}", event.function)
        for reset in filter(None, (event.reset, event.accumulation)):
            vanishing = f"what vanishes at event {event.name!r}"
            yield from ((vanishing, _as_function(mode, vanishing, expr)) for expr in reset.vanishing)
            yield from ((f"the reset of event {event.name!r}", expr) for expr in reset.jump.values())


def read_expression(automaton: HybridAutomaton, text: Any, what: str) -> Any:
    """The text as an expression of the automaton's states and parameters; x' is the rate of x.

    The name of an output, or an object that is no text, is returned as it is.

    Parameters
    ----------
    automaton : HybridAutomaton
    text : str or object
    what : str
        What errors call it, such as "section".

    Raises
    ------
    ValueError
        For unknown names, for what is no arithmetic, and where no state is named.
    """
    if not isinstance(text, str) or text in automaton.outputs:
        return text
    states = [symbol.name for symbol in automaton.states]
    symbols = {symbol.name: symbol for symbol in (*automaton.states, *automaton.parameters)}
    unknown = [name for name in names_in(text) if name not in symbols]
    if unknown:
        hint = did_you_mean_or_known(unknown[0], [*states, *automaton.outputs])
        raise ValueError(f"{what} {abbreviate(text)} has the unknown name {abbreviate(unknown[0])}{hint}")
    expected = f'{what} must be an expression of the states such as "x1 - x2", got {abbreviate(text)}'
    try:
        expression = symbols.get(text) or parse_expression(text, symbols)
    except ValueError as error:
        raise ValueError(f"{expected}: {error}") from None
    if not expression.free_symbols & {*automaton.states}:
        raise ValueError(f"{expected}: name one of {', '.join(states)}")
    return expression


def names_in(text: str) -> list[str]:
    """Names that a text mentions, with the primes of rates."""
    return NAME_PATTERN.findall(text)


def parse_expression(text: str, symbols: Mapping[str, Any], longest: int = MAX_LENGTH) -> Any:
    """The text as a sympy expression of these symbols.

    Parameters
    ----------
    text : str
        Such as ``"(y2 - y1)/3 - mu_k*x1'**2"``.
    symbols : mapping of str to Symbol
        Those that it may mention, by their names.
    longest : int, optional
        The most characters that are read.

    Raises
    ------
    ValueError
        For anything but arithmetic and functions, for unknown names, and where numbers, exponents or the text
        are too large; it says which.
    """
    if len(text) > longest:
        raise ValueError(f"it has {len(text)} characters, of which at most {longest} are read")
    # Each name gets a stand-in: x' is no name in Python, and a symbol may be called `lambda`.
    places = {name: f"_{i}" for i, name in enumerate(dict.fromkeys(names_in(text)))}
    source = NAME_PATTERN.sub(lambda name: places[name[0]], " ".join(text.split()))
    try:
        tree = ast.parse(source.replace("\0", "?"), mode="eval").body  # a null is a ValueError before 3.11.4
        return _value(tree, {place: symbols[name] for name, place in places.items() if name in symbols})
    except (SyntaxError, RecursionError, MemoryError):
        raise ValueError(ARITHMETIC) from None


def _value(node: ast.expr, symbols: Mapping[str, Any]) -> Any:
    match node:
        case ast.Constant(value=int() | float() as number) if not isinstance(number, bool):
            return _bounded(sp.sympify(number, strict=True))
        case ast.Name(id=name) if name in symbols:
            return symbols[name]
        case ast.UnaryOp(op=sign, operand=only) if type(sign) in OPERATIONS:
            return OPERATIONS[type(sign)](_value(only, symbols))
        case ast.BinOp(left=left, op=ast.Pow(), right=right):
            exponent = _value(right, symbols)
            _check_exponent(exponent)
            return _bounded(_value(left, symbols) ** exponent)
        case ast.Call(func=ast.Name(id=name), args=[only], keywords=[]) if name in FUNCTIONS:
            argument = _value(only, symbols)
            if name in GROWING_FUNCTIONS:
                _check_exponent(argument)
            return _bounded(getattr(sp, name)(argument))
        case ast.BinOp(left=left, op=sign, right=right) if type(sign) in OPERATIONS:
            return _bounded(OPERATIONS[type(sign)](_value(left, symbols), _value(right, symbols)))
    raise ValueError(ARITHMETIC)


def _bounded(result: Any) -> Any:
    """The result of an operation, if it is within bounds: powers of powers grow without limit."""
    if result.has(sp.zoo, sp.nan, sp.oo, sp.I):
        raise ValueError("it divides by zero, takes a root of a negative number, or is infinite")
    for power in result.atoms(sp.Pow, sp.exp):
        _check_exponent(power.exp)
    for number in result.atoms(sp.Number):
        if any(abs(part) > MAX_NUMBER for part in number.as_numer_denom()):
            raise ValueError(f"its numbers may be at most {MAX_NUMBER:g}")
    return result


def _check_exponent(exponent: Any) -> None:
    if exponent.is_number and abs(exponent) > MAX_EXPONENT:
        raise ValueError(f"its exponents may be at most {MAX_EXPONENT}")
