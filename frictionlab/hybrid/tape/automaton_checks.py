"""What is asked of an automaton before any work is done: whether it is well formed, with one clear error;
which functions are zero after a reset, whatever the numbers, so that their zeros there are no events.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from math import isfinite
from typing import Any

from frictionlab.automaton import Event, HybridAutomaton, Mode, Reset
from frictionlab.automaton.expressions import multiply_out
from frictionlab.automaton.mode import Expr, Symbol
from frictionlab.lazy_names import sympy as sp
from frictionlab.validation import abbreviate, check_number


def check_automaton(automaton: Any) -> None:
    """Raise TypeError for what is none, ValueError for a parameter whose value is no finite number."""
    if not isinstance(automaton, HybridAutomaton):
        cure = "write solve(automaton, t_end, x0=...)"
        cure = "use fl.simulate for a model" if hasattr(automaton, "automaton") else cure
        raise TypeError(f"automaton must be a HybridAutomaton, got {abbreviate(automaton)}: {cure}")
    for name, value in automaton.values.items():
        if type(value) is float and isfinite(value):  # as those of models are, before every run
            continue
        number = float(value) if getattr(value, "is_real", False) else value  # of sympy, such as pi
        check_number(f"the parameter {name}", number, cure=f"give it one, such as replace({name}=1.0)")


def check_structure(
    states: Sequence[Symbol],
    modes: Sequence[Mode],
    parameters: Sequence[Symbol],
    coordinates: int,
) -> None:
    """Raise ValueError with what was got, what was expected and the cure."""
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
    known = tuple(names), tuple(states), frozenset((*states, *parameters))
    for mode in modes:
        check_mode(mode, *known)


def check_section_or_quadrature(name: str, function: Any, automaton: HybridAutomaton) -> None:
    """Raise ValueError where a section or quadrature asks for what the automaton does not have."""
    outputs = automaton.outputs
    known = {*automaton.states, *automaton.parameters}
    if isinstance(function, str):
        strange = [] if function in outputs else [function]
    else:
        strange = sorted(map(str, _symbols(name, function) - known))
    if strange:
        raise ValueError(
            f"the section or quadrature {name!r} uses {strange}: write it with the states and parameters "
            f"({', '.join(sorted(map(str, known)))}), or give an output's name "
            f"({', '.join(outputs) or 'there is none'})"
        )


def _symbols(name: str, function: Any) -> set:
    try:
        return sp.sympify(function, strict=True).free_symbols
    except (AttributeError, sp.SympifyError):
        raise ValueError(
            f"the section or quadrature {name!r} must be an expression of the states, or an output's name, "
            f"got {abbreviate(function)}: write it with the automaton's symbols"
        ) from None


def check_mode(
    mode: Mode, names: Sequence[str], states: tuple[Symbol, ...], known: frozenset[Symbol]
) -> None:
    """Raise ValueError for one mode; `names` are those of all modes, `known` the states and parameters."""
    if len(mode.flow) != len(states):
        raise ValueError(
            f"the flow of mode {mode.name!r} must have one expression per state ({len(states)}), "
            f"got {len(mode.flow)}: give each state its time derivative"
        )
    for event in mode.events:
        if unknown := [name for name in event.targets if name not in names]:
            raise ValueError(
                f"event {event.name!r} of mode {mode.name!r} leads to {unknown}, "
                f"but the modes are {list(names)}: correct its targets"
            )
        _check_resets(event, mode, states)
    for what, expr in _expressions(mode):
        if isinstance(expr, str):  # which sympy would run as Python
            raise TypeError(
                f"{what} of mode {mode.name!r} must be an expression, got the text {abbreviate(expr)}: "
                "write it with the automaton's symbols"
            )
        if strange := sp.sympify(expr, strict=True).free_symbols - known:
            raise ValueError(
                f"{what} of mode {mode.name!r} uses {sorted(map(str, strange))}, which is neither a state "
                "nor a parameter: add it to the automaton's parameters"
            )


def _check_resets(event: Event, mode: Mode, states: tuple[Symbol, ...]) -> None:
    for reset in filter(None, (event.reset, event.accumulation)):
        if strange := [symbol for symbol in reset.jump if symbol not in states]:
            raise ValueError(
                f"the reset of event {event.name!r} of mode {mode.name!r} may give values to states only "
                f"({', '.join(sorted(map(str, states)))}), got one for {', '.join(map(str, strange))}: "
                "take the symbol that the automaton's states hold, with the same assumptions"
            )


def _expressions(mode: Mode):
    yield from (("the flow", expr) for expr in mode.flow)
    yield from (("a constraint", expr) for expr in mode.constraints)
    yield from ((f"output {name!r}", expr) for name, expr in mode.outputs.items())
    for event in mode.events:
        yield f"event {event.name!r}", event.function
        for reset in filter(None, (event.reset, event.accumulation)):
            yield from ((f"the reset of event {event.name!r}", expr) for expr in reset.jump.values())


@lru_cache(maxsize=4096)
def structural_zeros(mode: Mode, event: Event, reset: Reset) -> Mapping[Any, int]:
    """How many leading Taylor coefficients are zero after the event's reset, by function up to its sign.

    What the reset declares; besides, the function that triggered the event and the constraints of the
    mode that ends were zero before it, and stay so unless the reset changes them.
    """
    zero: dict[Any, int] = {}
    for function, count in reset.vanishing.items():
        zero[sign_normal_form(function)] = max(count, zero.get(sign_normal_form(function), 0))
    for function in (event.function, *mode.constraints):
        if sign_normal_form(function) not in zero and _survives(function, reset):
            zero[sign_normal_form(function)] = 1
    return zero


def _survives(function: Expr, reset: Reset) -> bool:
    """Whether a function that was zero before the reset is zero after it."""
    if function.free_symbols.isdisjoint(reset.jump):
        return True
    after: Any = sp.sympify(function.xreplace(dict(reset.jump)), strict=True)  # it may give numbers
    somewhere = after.xreplace(_integers(after.free_symbols))
    if somewhere.is_Rational and somewhere != 0:  # exact, and found sooner than all products are
        return False
    return multiply_out(after) in (0, 0.0)  # to sympy these are two numbers


def _integers(symbols: set[Any]) -> dict[Any, Any]:
    """A different integer for each symbol."""
    return {name: sp.Integer(i) for i, name in enumerate(sorted(symbols, key=str), start=3)}


@lru_cache(maxsize=4096)
def sign_normal_form(function: Expr) -> Expr:
    """The same for f and for -f, however they are written: both are zero together."""
    expanded = multiply_out(function)
    return -expanded if expanded.could_extract_minus_sign() else expanded
