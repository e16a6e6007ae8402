"""The equations of a model that is but an automaton: its flow, mode by mode."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import sympy

from frictionlab.components.names import did_you_mean

from .assembly import assemble
from .equations import Equations
from .latex import TIME
from .namespace import about_all
from .symbols import structure


def equations(model: Any, mode: str) -> Equations:
    """x'' = flow for each coordinate, x' = flow for the other states, with constraints and conditions.

    Raises
    ------
    ValueError
        If the model has no such mode.
    """
    automaton = assemble(structure(model))
    check_mode(mode, automaton.names)
    chosen, n = automaton.modes[automaton.names.index(mode)], automaton.coordinates
    functions = of_time(automaton.states, n)
    left = [sympy.diff(functions[x], TIME, 2) for x in automaton.states[:n]]
    left += [sympy.diff(functions[x], TIME) for x in automaton.states[2 * n :]]
    flow = [*chosen.flow[n : 2 * n], *chosen.flow[2 * n :]]
    return Equations(
        mode,
        motion=tuple(equation(a, written(b, functions)) for a, b in zip(left, flow, strict=True)),
        constraint=tuple(equation(written(c, functions), 0) for c in chosen.constraints),
        conditions=tuple(sympy.Gt(written(e.function, functions), 0, evaluate=False) for e in chosen.events),
        symbols={str(x): f for x, f in functions.items()},
        letters=letters_of(model),
    )


def check_mode(mode: Any, names: tuple[str, ...]) -> None:
    """Raise ValueError unless it is one of the names."""
    if mode not in names:
        hint = did_you_mean(mode, names)
        raise ValueError(f"mode must be one of {', '.join(map(repr, names))}, got {mode!r}: {hint}")


def letters_of(model: Any) -> dict[str, str]:
    """LaTeX of the parameters."""
    return {name: about.symbol for name, about in about_all(type(model), model.components).items()}


def of_time(states: tuple[Any, ...], n: int) -> dict[Any, Any]:
    """States as functions of time; the velocities as derivatives of the coordinates."""
    found = {x: sympy.Function(x.name, real=True)(TIME) for x in (*states[:n], *states[2 * n :])}
    return found | {v: sympy.diff(found[x], TIME) for x, v in zip(states[:n], states[n : 2 * n], strict=True)}


def written(expression: Any, functions: Mapping[Any, Any]) -> Any:
    """The expression with functions of time for its states."""
    return sympy.sympify(expression).xreplace(dict(functions))


def equation(left: Any, right: Any) -> Any:
    """An equation that stays one: sympy does not try to prove it."""
    return sympy.Eq(left, right, evaluate=False)
