"""LaTeX of equations of motion: dots for time derivatives, the paper's letters for parameters."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from sympy import Symbol
from sympy.printing.latex import LatexPrinter

TIME = Symbol("t", real=True)
DOTS = {1: r"\dot", 2: r"\ddot"}


class MotionPrinter(LatexPrinter):
    """Prints x1(t) as x_{1}, its derivatives with dots; `letters` has the names with LaTeX of their own."""

    def __init__(self, letters: Mapping[str, str]) -> None:
        super().__init__()
        self.letters = letters

    def _print_Symbol(self, expr: Any, style: str = "plain") -> str:
        return self.letters.get(expr.name) or super()._print_Symbol(expr, style)

    def _print_Function(self, expr: Any, exp: Any = None) -> str:
        name = getattr(type(expr), "name", None)
        if name is None:
            return super()._print_Function(expr, exp)
        letter = self._print_Symbol(Symbol(name))
        if expr.args != (TIME,):
            letter += rf"\left({', '.join(map(self._print, expr.args))}\right)"
        return letter if exp is None else f"{letter}^{{{exp}}}"

    def _print_Derivative(self, expr: Any) -> str:
        order = len(expr.variables)
        if expr.expr.args != (TIME,) or order not in DOTS:
            return super()._print_Derivative(expr)
        letter, _, index = self._print(expr.expr).partition("_")
        return f"{DOTS[order]}{{{letter}}}" + (f"_{index}" if index else "")

    def _print_sign(self, expr: Any, exp: Any = None) -> str:
        sign = rf"\operatorname{{sgn}}\left({self._print(expr.args[0])}\right)"
        return sign if exp is None else f"{sign}^{{{exp}}}"


def aligned(relations: Iterable[Any], letters: Mapping[str, str]) -> str:
    """The relations, one a line, aligned at their signs."""
    printer = MotionPrinter(letters)
    signs = {"==": "=", "<=": r"\leq", ">=": r"\geq", "!=": r"\neq", "<": "<", ">": ">"}
    lines = (f"{printer.doprint(r.lhs)} &{signs[r.rel_op]} {printer.doprint(r.rhs)}" for r in relations)
    return r"\begin{aligned}" + r" \\ ".join(lines) + r"\end{aligned}"
