"""Sections of a run: where stick begins, or where an expression of the states passes zero."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import sympy

from frictionlab.components.names import did_you_mean
from frictionlab.hybrid.trajectory import Points, Trajectory

STICK = "stick"
Section = str | tuple[str, int]


def asked(automaton: Any, section: Section) -> dict[str, Any]:
    """The section as :func:`frictionlab.solve` takes it; nothing for the onset of stick, which is an event.

    Parameters
    ----------
    automaton : HybridAutomaton
    section : "stick", str or (str, int)
        "stick": transitions from slip to stick.  Else an expression of the states ("x1'", "x1 - x2"), and
        the direction in which it passes zero: 1 rising, -1 falling, 0 both.

    Raises
    ------
    ValueError
        For an unknown name in the expression.
    """
    if section == STICK:
        return {}
    text, direction = (section, 0) if isinstance(section, str) else section
    return {"section": (expression(automaton, text), direction)}


def expression(automaton: Any, text: str) -> Any:
    """The text as an expression of the automaton's states and parameters; x' is the rate of x."""
    symbols = {_plain(symbol.name): symbol for symbol in (*automaton.states, *automaton.parameters)}
    words = set(re.findall(r"[A-Za-z_]\w*'?", text))
    unknown = sorted(word for word in words if _plain(word) not in symbols)
    if unknown:
        known = [symbol.name for symbol in automaton.states]
        raise ValueError(
            f"section {text!r} has the unknown name {unknown[0]!r}: {did_you_mean(unknown[0], known)}"
        )
    parse: Any = sympy.sympify
    return parse(re.sub(r"([A-Za-z_]\w*)'", r"\1_rate", text), locals=symbols)


def _plain(name: str) -> str:
    return name.replace("'", "_rate")


def points(run: Trajectory, section: Section) -> Points:
    """Crossings of the section in a run: times (K,), states (K, m)."""
    if section == STICK:
        chosen = stick_onsets(run)
        return Points(run.events.t[chosen], run.events.state[chosen])
    if "section" in run.sections:
        return run.sections["section"]
    return _searched(run, *asked(run.automaton, section)["section"])


def stick_onsets(run: Trajectory) -> Any:
    """Which events lead from slip to stick."""
    slipping = np.char.startswith(run.events.source.astype(str), "slip")
    return slipping & (run.events.target == "stick")


def _searched(run: Trajectory, function: Any, direction: int) -> Points:
    """For methods that record no sections: changes of sign between samples, and linear interpolation."""
    symbols = [*run.automaton.states, *run.automaton.parameters]
    values = list(run.automaton.parameters.values())
    level = sympy.lambdify(symbols, function, modules="numpy")(*run.states.T, *values)
    rising = (level[:-1] < 0) & (level[1:] >= 0) & (direction >= 0)
    falling = (level[:-1] > 0) & (level[1:] <= 0) & (direction <= 0)
    i = np.flatnonzero(rising | falling)
    share = level[i] / (level[i] - level[i + 1])
    times = run.t[i] + share * (run.t[i + 1] - run.t[i])
    return Points(times, run(times))
