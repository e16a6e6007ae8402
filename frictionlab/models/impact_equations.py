"""The equations of a re-contact, Eqs. (10) to (17)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import sympy

from .resets import RATES, friction_impulse, impulse, rates_after, velocities_after
from .scene import Scene, scene
from .symbols import symbol

IMPULSE, FRICTION = symbol("p"), symbol("p_T")


def impact_equations(model: Any) -> tuple[tuple[Any, ...], dict[str, Any]]:
    """Eqs. (10) to (17) for a symbolic model, and their symbols by name.

    Velocities just before and just after the impact are named ``y1'-`` and ``y1'+``.  Eq. (16) is the one
    that follows from Eqs. (11) and (14): as printed in the paper it has two terms too many.  With friction in
    the impact there is its impulse, and the normal one is that for the velocities after it.
    """
    before, after = (_at(model, sign) for sign in "-+")
    solved, rubbing = impulse(before, model.impact), friction_impulse(before, model.impact)
    symbols = {str(x): x for x in (*before.q, *before.v, *after.v, IMPULSE)}
    if rubbing != 0:
        return _with_friction(before, after, solved, rubbing), symbols | {str(FRICTION): FRICTION}
    rows = list(zip(before.v, after.v, before.normal, before.mass, strict=True))
    jumps = [(old, new, w / mass) for old, new, w, mass in rows if w != 0]
    equations = (
        *(_eq(new - old, factor * IMPULSE) for old, new, factor in jumps),
        *_law(before, after),
        _eq(IMPULSE, solved),
        *(_eq(new, old + factor * solved) for old, new, factor in jumps),
    )
    return equations, symbols


def _with_friction(before: Scene, after: Scene, solved: Any, rubbing: Any) -> tuple[Any, ...]:
    rows = zip(before.v, after.v, before.normal, before.tangent, before.mass, strict=True)
    jumps = (_eq(new - old, (n * IMPULSE + t * FRICTION) / mass) for old, new, n, t, mass in rows)
    rubbed = velocities_after(before, before.tangent, FRICTION)
    return *jumps, _eq(FRICTION, rubbing), _eq(IMPULSE, solved.xreplace(rubbed))


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
