"""The equations of a re-contact, Eqs. (10) to (17)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import sympy

from .resets import RATES, impulse, rates_after
from .scene import Scene, scene
from .symbols import symbol

IMPULSE = symbol("p")


def impact_equations(model: Any) -> tuple[tuple[Any, ...], dict[str, Any]]:
    """Eqs. (10) to (17) for a symbolic model, and their symbols by name.

    Velocities just before and just after the impact are named ``y1'-`` and ``y1'+``.  Eq. (16) is the one
    that follows from Eqs. (11) and (14): as printed in the paper it has two terms too many.
    """
    before, after = (_at(model, sign) for sign in "-+")
    rows = list(zip(before.v, after.v, before.normal, before.mass, strict=True))
    jumps = [(old, new, w / mass) for old, new, w, mass in rows if w != 0]
    solved = impulse(before, model.impact)
    equations = (
        *(_eq(new - old, factor * IMPULSE) for old, new, factor in jumps),
        *_law(before, after),
        _eq(IMPULSE, solved),
        *(_eq(new, old + factor * solved) for old, new, factor in jumps),
    )
    symbols = {str(x): x for x in (*before.q, *before.v, *after.v, IMPULSE)}
    return equations, symbols


def impact_letters(model: Any, letters: Mapping[str, str]) -> dict[str, str]:
    """LaTeX of the velocities before and after, as the paper writes them, and of the coordinates."""
    found = {}
    for name in model.coordinates:
        letter = letters.get(name) or f"{name[0]}_{{{name[1:]}}}"
        head, _, index = letter.partition("_")
        found[name] = letter
        for sign in "-+":
            dotted = rf"\dot{{{head}}}" + (f"_{index}" if index else "")
            found[f"{name}'{sign}"] = rf"{dotted}(t_{{\mathrm{{r}}}}^{{{sign}}})"
    return found


def _at(model: Any, sign: str) -> Scene:
    q = [symbol(name) for name in model.coordinates]
    return scene(model, q, [symbol(f"{name}'{sign}") for name in model.coordinates])


def _law(before: Scene, after: Scene) -> tuple[Any, ...]:
    """Eq. (13): the rate that the impact law brings to a multiple of what it was."""
    material, full = rates_after(before, before.model.impact)
    pairs = (
        (before.material_rate, after.material_rate, material, RATES[0]),
        (before.gap_rate, after.gap_rate, full, RATES[1]),
    )
    for old, new, left, rate in pairs:
        factor = sympy.cancel(left / rate)
        if not factor.has(*RATES):
            return (_eq(new, factor * old),)
    return ()


def _eq(left: Any, right: Any) -> Any:
    return sympy.Eq(left, right, evaluate=False)
