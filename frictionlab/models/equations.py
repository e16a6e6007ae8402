"""`Equations` of one mode, as text and LaTeX, and how they follow from the flow of an automaton."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import sympy
from sympy import Symbol
from sympy.printing.latex import LatexPrinter

from frictionlab.automaton.modes_on_demand import check_mode_name
from frictionlab.models.automaton_of_model import automaton_of_structure
from frictionlab.models.composition import parameter_metadata

if TYPE_CHECKING:
    from frictionlab.models.model import Model

TIME = Symbol("t", real=True)
TIME_DERIVATIVE_DOTS = {1: r"\dot", 2: r"\ddot"}

LETTERS = {
    "phi": r"\varphi",
    "F_N": r"F_{\mathrm{N}}",
    "F_T": r"F_{\mathrm{T}}",
    "v_r": r"v_{\mathrm{r}}",
    "t_s": r"t_{\mathrm{s}}",
}


class MotionPrinter(LatexPrinter):
    """Prints x1(t) as x_{1}, its derivatives with dots; `letters` maps names to their LaTeX."""

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
        if expr.expr.args != (TIME,) or order not in TIME_DERIVATIVE_DOTS:
            return super()._print_Derivative(expr)
        letter, _, index = self._print(expr.expr).partition("_")
        return f"{TIME_DERIVATIVE_DOTS[order]}{{{letter}}}" + (f"_{index}" if index else "")

    def _print_sign(self, expr: Any, exp: Any = None) -> str:
        sign = rf"\operatorname{{sgn}}\left({self._print(expr.args[0])}\right)"
        return sign if exp is None else f"{sign}^{{{exp}}}"


def aligned_latex(relations: Iterable[Any], letters: Mapping[str, str]) -> str:
    """LaTeX of relations, one per line, aligned at =, <, > and the like."""
    printer = MotionPrinter(letters)
    signs = {"==": "=", "<=": r"\leq", ">=": r"\geq", "!=": r"\neq", "<": "<", ">": ">"}
    lines = (f"{printer.doprint(r.lhs)} &{signs[r.rel_op]} {printer.doprint(r.rhs)}" for r in relations)
    return r"\begin{aligned}" + r" \\ ".join(lines) + r"\end{aligned}"


@dataclass(frozen=True, eq=False, repr=False)
class Equations:
    """Equations of one mode; iterating gives each equation, and a notebook shows them in LaTeX.

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
        LaTeX of the names that have a symbol of their own.
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
        return aligned_latex((*self, *self.conditions), self.letters)

    def _repr_latex_(self) -> str:
        return f"$\\displaystyle {self.latex()}$"


def flow_equations(model: Model, mode: str) -> Equations:
    """The equations of a mode as its flow gives them, with its constraints and conditions.

    They are x'' = flow for each coordinate, and x' = flow for the states that are neither coordinates nor
    velocities.

    Raises
    ------
    ValueError
        If the model has no such mode.
    """
    automaton = automaton_of_structure(model.structure_key)
    check_mode_name(mode, automaton.names)
    chosen, n = automaton.mode(mode), automaton.coordinates
    functions = time_functions(automaton.states, n)
    left = [sympy.diff(functions[x], TIME, 2) for x in automaton.states[:n]]
    left += [sympy.diff(functions[x], TIME) for x in automaton.states[2 * n :]]
    flow = [*chosen.flow[n : 2 * n], *chosen.flow[2 * n :]]
    return Equations(
        mode,
        motion=tuple(equation(a, in_time_functions(b, functions)) for a, b in zip(left, flow, strict=True)),
        constraint=tuple(equation(in_time_functions(c, functions), 0) for c in chosen.constraints),
        conditions=tuple(
            sympy.Gt(in_time_functions(e.function, functions), 0, evaluate=False) for e in chosen.events
        ),
        symbols={str(x): f for x, f in functions.items()},
        letters=parameter_letters(model),
    )


def parameter_letters(model: Model) -> dict[str, str]:
    """LaTeX of the parameters."""
    return {name: about.symbol for name, about in parameter_metadata(type(model), model.components).items()}


def time_functions(states: tuple[Any, ...], n: int) -> dict[Any, Any]:
    """States as functions of time; the velocities as derivatives of the coordinates."""
    functions = {x: sympy.Function(x.name, real=True)(TIME) for x in (*states[:n], *states[2 * n :])}
    return functions | {
        v: sympy.diff(functions[x], TIME) for x, v in zip(states[:n], states[n : 2 * n], strict=True)
    }


def in_time_functions(expression: Any, functions: Mapping[Any, Any]) -> Any:
    """The expression with its states replaced by functions of time."""
    return sympy.sympify(expression, strict=True).xreplace(dict(functions))


def equation(left: Any, right: Any) -> Any:
    """An equation that sympy does not try to evaluate to true or false."""
    return sympy.Eq(left, right, evaluate=False)
