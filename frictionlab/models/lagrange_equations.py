"""Lagrange's equations of a model with its contact forces, mode by mode."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product
from typing import Any, NamedTuple

import sympy

from .equations import LETTERS, Equations
from .flow_equations import check_mode, equation, letters_of, of_time, written
from .lagrange import System, name_of, number, solved, system
from .latex import TIME
from .mechanics import Friction, Stop
from .regimes import Regime, rate_after, regimes
from .symbols import structure, symbol, symbolic


class Written(NamedTuple):
    """A system, and what its symbols are as functions of time."""

    system: System
    functions: Mapping[Any, Any]

    def __call__(self, expression: Any) -> Any:
        return written(expression, self.functions)


def equations(model: Any, mode: str) -> Equations:
    """The equations of a mode, of "slip" in both directions, or of the "impact" on a stop.

    Raises
    ------
    ValueError
        If the model has no such mode.
    """
    found = system(symbolic(structure(model)))
    contacts = found.mechanics.contacts
    chosen = {name_of(some): some for some in product(*(regimes(c, found.rate) for c in contacts))}
    single = len(contacts) == 1
    merged = ("slip",) * (single and "slip+" in chosen) + ("impact",) * (single and "flight" in chosen)
    check_mode(mode, (*chosen, *merged))
    functions = of_time((*found.q, *found.v), len(found.q))
    if found.phase:
        functions |= {found.phase[0]: found.mechanics.frequency * TIME}
    write = Written(found, functions)
    letters = {**LETTERS, **letters_of(model), **_letters(found)}
    if mode == "impact":
        return Equations(mode, impact=_impact(write), letters=letters)
    return _of_mode(write, mode, chosen.get(mode) or chosen["slip+"], letters)


def _of_mode(write: Written, mode: str, chosen: Sequence[Regime], letters: Mapping[str, str]) -> Equations:
    found = write.system
    forces = [_force(found, i) for i in range(len(chosen))]
    named = {str(f.func): f for f in (*forces, *(write(x) for x in found.q))}
    return Equations(
        mode,
        motion=_motion(write, forces, chosen),
        forces=tuple(eq for i in range(len(chosen)) for eq in _forces(write, mode, chosen, i)),
        definitions=_definitions(write),
        constraint=tuple(equation(write(c), 0) for regime in chosen for c in regime.constraints),
        conditions=tuple(c for i in range(len(chosen)) for c in _conditions(write, mode, chosen[i], i)),
        symbols={"t": TIME, **named},
        letters=letters,
    )


def _motion(write: Written, forces: Sequence[Any], chosen: Sequence[Regime]) -> tuple[Any, ...]:
    """M q'' + what energies and dampers give = loads + sum of W F."""
    found = write.system
    second = sympy.Matrix([sympy.diff(write(x), TIME, 2) for x in found.q])
    left = found.mass * second + sympy.Matrix([write(r) for r in found.internal])
    right = sympy.Matrix([write(load) for load in found.loads])
    for i, (contact, force) in enumerate(zip(found.mechanics.contacts, forces, strict=True)):
        right += found.direction(contact) * force
        right += found.pressed(contact, chosen[i].name) * _named(found, "F_N", i)
    return tuple(map(equation, left.applyfunc(write), right.applyfunc(write)))


def _forces(write: Written, mode: str, chosen: Sequence[Regime], i: int) -> tuple[Any, ...]:
    """F_N and F_T of a contact with friction; in stick F_T, and at a stop F_N, is what holds it."""
    found, force = write.system, _force(write.system, i)
    contact, value = found.mechanics.contacts[i], solved(found, chosen)[1][i]
    if isinstance(contact, Stop):
        return (equation(force, write(value)),)
    normal, velocity = (_named(found, name, i) for name in ("F_N", "v_r"))
    pressed = 0 if chosen[i].name == "separation" else write(contact.normal_force)
    return equation(normal, pressed), equation(
        force, _friction(mode, contact, chosen[i], velocity, normal, write(value))
    )


def _friction(mode: str, contact: Friction, regime: Regime, velocity: Any, normal: Any, value: Any) -> Any:
    if not regime.name.startswith("slip"):
        return value
    if mode == "slip":
        return sympy.sign(velocity) * contact.law.kinetic(normal, sympy.Abs(velocity))
    sign = 1 if regime.name == "slip+" else -1
    return sign * contact.law.kinetic(normal, sign * velocity)


def _definitions(write: Written) -> tuple[Any, ...]:
    contacts = enumerate(write.system.mechanics.contacts)
    rows = [(i, c.relative_velocity) for i, c in contacts if isinstance(c, Friction)]
    return tuple(equation(_named(write.system, "v_r", i), write(v)) for i, v in rows)


def _conditions(write: Written, mode: str, regime: Regime, i: int) -> tuple[Any, ...]:
    """What holds while the regime lasts."""
    found, contact = write.system, write.system.mechanics.contacts[i]
    if isinstance(contact, Stop):
        positive = _force(found, i) if regime.name == "contact" else write(contact.distance)
        return (sympy.Gt(positive, 0, evaluate=False),)
    pressed = () if contact.gap is None else (sympy.Gt(write(contact.gap), 0, evaluate=False),)
    if regime.name == "separation":
        return (sympy.Lt(write(contact.gap), 0, evaluate=False),)
    velocity = _named(found, "v_r", i)
    if regime.name == "stick":
        limit = contact.law.static_limit(_named(found, "F_N", i))
        return (sympy.Le(sympy.Abs(_force(found, i)), limit, evaluate=False), *pressed)
    signs = {"slip": sympy.Ne, "slip+": sympy.Gt, "slip-": sympy.Lt}
    return (signs["slip" if mode == "slip" else regime.name](velocity, 0, evaluate=False), *pressed)


def _impact(write: Written) -> tuple[Any, ...]:
    """The rate of the distance after the impact from that before."""
    stop = write.system.mechanics.contacts[0]
    before, after = symbol("rate-"), symbol("rate+")
    rate = write(write.system.rate(stop.distance))
    return (equation(before, rate), equation(after, rate_after(stop.law, before)))


def _force(found: System, i: int) -> Any:
    """F_T of a contact with friction, F_N of a stop."""
    return _named(found, "F_N" if isinstance(found.mechanics.contacts[i], Stop) else "F_T", i)


def _named(found: System, name: str, i: int) -> Any:
    return sympy.Function(name + number(found, i), real=True)(TIME)


def _letters(found: System) -> dict[str, str]:
    """LaTeX of numbered forces, and of the rates around an impact."""
    letters = {"rate-": r"\dot{d}^{-}", "rate+": r"\dot{d}^{+}"}
    for i in range(len(found.mechanics.contacts)):
        for name, letter in (("F_N", r"\mathrm{N}"), ("F_T", r"\mathrm{T}"), ("v_r", r"\mathrm{r}")):
            if number(found, i):
                letters[name + number(found, i)] = rf"{name[0]}_{{{letter},{i + 1}}}"
    return letters
