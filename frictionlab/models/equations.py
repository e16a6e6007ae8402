"""Equations of a mode as data, with their LaTeX."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from .latex import aligned

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
