"""The equations of a model, mode by mode, as the paper writes them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import sympy

from frictionlab.components.names import did_you_mean

from .impact_equations import impact_equations, impact_letters
from .latex import TIME, aligned
from .modes import sticking_force
from .namespace import about_all
from .scene import Scene, scene
from .symbols import structure, symbol, symbolic

LETTERS = {
    "phi": r"\varphi",
    "F_N": r"F_{\mathrm{N}}",
    "F_T": r"F_{\mathrm{T}}",
    "v_r": r"v_{\mathrm{r}}",
    "t_s": r"t_{\mathrm{s}}",
}


@dataclass(frozen=True, eq=False, repr=False)
class Equations:
    """Equations of one mode; iterating gives every equation, LaTeX appears in a notebook.

    Parameters
    ----------
    mode : str
    motion : tuple of Eq
        Eq. (1): inertia, damping, stiffness and preload on the left, contact forces on the right.
    forces : tuple of Eq
        Eqs. (2) and (3): F_N and F_T.
    definitions : tuple of Eq
        The relative velocity v_r.
    constraint : tuple of Eq
        Eq. (5), in stick.
    impact : tuple of Eq
        Eqs. (10) to (17), for "impact".
    conditions : tuple of relations
        Eqs. (4), (8), (9): what holds while the mode lasts.
    symbols : mapping of str to Expr
        The symbols and functions of time by name, for ``subs``.
    letters : mapping of str to str
        LaTeX of those names that have their own.
    """

    mode: str
    motion: tuple[Any, ...] = ()
    forces: tuple[Any, ...] = ()
    definitions: tuple[Any, ...] = ()
    constraint: tuple[Any, ...] = ()
    impact: tuple[Any, ...] = ()
    conditions: tuple[Any, ...] = ()
    symbols: Mapping[str, Any] = field(default_factory=dict)
    letters: Mapping[str, str] = field(default_factory=dict)

    def __iter__(self) -> Iterator[Any]:
        yield from (*self.motion, *self.forces, *self.definitions, *self.constraint, *self.impact)

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def __repr__(self) -> str:
        lines = (
            f"{r.lhs} {'=' if r.rel_op == '==' else r.rel_op} {r.rhs}" for r in (*self, *self.conditions)
        )
        return "\n".join([f"{self.mode}:", *lines])

    def latex(self) -> str:
        """LaTeX of all equations and conditions, without dollars."""
        return aligned((*self, *self.conditions), self.letters)

    def _repr_latex_(self) -> str:
        return f"$\\displaystyle {self.latex()}$"


def equations(model: Any, mode: str) -> Equations:
    """The equations of a mode of the model, or of its "impact".

    Where slip has two modes, "slip" gives both in one, with sgn(v_r) as in Eq. (3).

    Raises
    ------
    ValueError
        If the model has no such mode.
    """
    names = _names(model.interface.modes)
    if mode not in names:
        hint = did_you_mean(mode, names)
        raise ValueError(f"mode must be one of {', '.join(map(repr, names))}, got {mode!r}: {hint}")
    letters = LETTERS | {n: about.symbol for n, about in about_all(type(model), model.components).items()}
    copy = symbolic(structure(model))
    if mode == "impact":
        impact, symbols = impact_equations(copy)
        return Equations(
            mode, impact=impact, symbols=symbols, letters=letters | impact_letters(copy, letters)
        )
    return _mode_equations(model, copy, mode, letters)


def _names(modes: tuple[str, ...]) -> tuple[str, ...]:
    merged = ("slip",) if "slip+" in modes else ()
    return (*modes, *merged, *(("impact",) if "separation" in modes else ()))


def _mode_equations(model: Any, copy: Any, mode: str, letters: Mapping[str, str]) -> Equations:
    q = [_of_time(name) for name in copy.coordinates]
    s = scene(copy, q, [sympy.diff(x, TIME) for x in q])
    known = {"t": TIME, **{str(x.func): x for x in q}, **{n: _of_time(n) for n in ("F_N", "F_T", "v_r")}}
    return Equations(
        mode,
        motion=_motion(s, known),
        forces=_forces(s, known, mode),
        definitions=(_eq(known["v_r"], s.relative_velocity),),
        constraint=_constraint(s) if mode == "stick" else (),
        conditions=_conditions(s, known, mode),
        symbols={**known, **{name: symbol(name) for name in model.parameters}},
        letters=letters,
    )


def _motion(s: Scene, known: Mapping[str, Any]) -> tuple[Any, ...]:
    """Eq. (1)."""
    inertia = [m * sympy.diff(x, TIME, 2) for m, x in zip(s.mass, s.q, strict=True)]
    left = [a + r - f for a, r, f in zip(inertia, s.internal, s.load, strict=True)]
    right = [n * known["F_N"] + t * known["F_T"] for n, t in zip(s.normal, s.tangent, strict=True)]
    return tuple(map(_eq, left, right))


def _forces(s: Scene, known: Mapping[str, Any], mode: str) -> tuple[Any, ...]:
    """Eqs. (2) and (3); in stick F_T from Eqs. (1) and (5); none in separation."""
    normal, velocity = known["F_N"], known["v_r"]
    if mode == "separation":
        return _eq(normal, 0), _eq(known["F_T"], 0)
    friction = sticking_force(s, normal) if mode == "stick" else _sliding_friction(s, normal, velocity, mode)
    return _eq(normal, s.normal_force), _eq(known["F_T"], friction)


def _sliding_friction(s: Scene, normal: Any, velocity: Any, mode: str) -> Any:
    """Eq. (3).  The sign is that of v_r, but of v where the interface keeps it fixed."""
    law = s.model.friction
    if mode == "slip" and "slip+" in s.model.interface.modes:
        return sympy.sign(velocity) * law.kinetic(normal, sympy.Abs(velocity))
    sign = {"slip+": 1, "slip-": -1}.get(mode, sympy.sign(s.model.v))
    return sign * law.kinetic(normal, sign * velocity)


def _constraint(s: Scene) -> tuple[Any, ...]:
    """Eq. (5): the belt's coordinate from the slider's, since the onset t_s of stick."""
    slider, belt = s.q[s.tangent.index(1)], s.q[s.tangent.index(-1)]
    onset = symbol("t_s")
    travelled = slider - slider.subs(TIME, onset) - s.model.v * (TIME - onset)
    return (
        _eq(sympy.diff(belt, TIME), sympy.diff(slider, TIME) - s.model.v),
        _eq(sympy.diff(belt, TIME, 2), sympy.diff(slider, TIME, 2)),
        _eq(belt, travelled + belt.subs(TIME, onset)),
    )


def _conditions(s: Scene, known: Mapping[str, Any], mode: str) -> tuple[Any, ...]:
    """Eqs. (4), (8) and (9)."""
    normal, velocity = known["F_N"], known["v_r"]
    pressed = (normal > 0,) if "separation" in s.model.interface.modes else ()
    if mode == "separation":
        return (s.gap < 0,)
    if mode == "stick":
        return (sympy.Abs(known["F_T"]) <= s.model.friction.static_limit(normal), *pressed)
    if "slip+" not in s.model.interface.modes:
        return pressed
    return ({"slip": sympy.Ne(velocity, 0), "slip+": velocity > 0, "slip-": velocity < 0}[mode], *pressed)


def _of_time(name: str) -> Any:
    return sympy.Function(name, real=True)(TIME)


def _eq(left: Any, right: Any) -> Any:
    # Unevaluated: an equation stays an equation, and sympy does not try to prove it.
    return sympy.Eq(left, right, evaluate=False)
