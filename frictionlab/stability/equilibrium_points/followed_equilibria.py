"""Equilibria for many parameter values at once.

An automaton's equilibrium is followed by Newton's method.  Of a model in steady sliding it is the equilibrium
with F_N > 0 and the smallest penetration.  With polynomial laws this penetration is a root of a polynomial.
It is found by eigenvalues, and polished by Newton's method on the original equation.  With other laws bounds
of the equation and of its slope tell where roots are, for all values of the parameters at once
(`root_boxes`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionlab.automaton import HybridAutomaton
from frictionlab.models.model import Model, ModelOrAutomaton, automaton_of
from frictionlab.stability.equilibrium_points.newton import find_zeros, follow_zero, newton_step
from frictionlab.stability.equilibrium_points.real_roots import UNKNOWN, Polynomial
from frictionlab.stability.equilibrium_points.root_boxes import (
    LARGEST,
    SMALLEST,
    Boxes,
    isolate_zeros,
    one_equation,
)
from frictionlab.stability.equilibrium_points.static_equations import (
    SlidingEquations,
    Statics,
    is_static,
    sliding_equations,
    statics_groups,
)
from frictionlab.stability.equilibrium_points.steady_modes import (
    SteadyMode,
    first_mode_equilibria,
    parameter_values,
    steady_modes,
)
from frictionlab.stability.equilibrium_problem import MACHINE_EPSILON, EquilibriumProblem
from frictionlab.stability.flow import Flow
from frictionlab.tape.formulas import Formulas, kept_formulas
from frictionlab.tape.intervals import interval

Array = NDArray[np.float64]


def nearest_equilibrium_problem(
    model: ModelOrAutomaton, closest_to: Array | None = None
) -> EquilibriumProblem:
    """The problem of the equilibrium nearest to the origin, in the first mode that has one inside its guards.

    With `closest_to` (m,) it is the equilibrium nearest to this state.

    Raises
    ------
    ValueError
        If no mode has one.
    """
    automaton = automaton_of(model)
    mode, points, *_ = first_mode_equilibria(automaton, isinstance(model, Model))
    if not points.size:
        raise no_equilibrium_error(model)
    offsets = points if closest_to is None else points - closest_to[:, None]
    i = 0 if closest_to is None else int(np.argmin(np.linalg.norm(offsets, axis=0)))
    return problem_from_equilibrium(model, automaton, mode, points[:, i])


def problem_from_equilibrium(
    model: ModelOrAutomaton, automaton: HybridAutomaton, mode: SteadyMode, x: Array, **changes: float
) -> EquilibriumProblem:
    """The problem of a mode's equilibrium, followed from `x` (m,), its state with `changes` of parameters."""
    flow, values = mode.flow, parameter_values(automaton)
    start = parameter_values(automaton.replace(**changes)) if changes else values
    return EquilibriumProblem(
        model,
        _state_names(automaton),
        tuple(automaton.values),
        values,
        continuation_solver(flow, x, start, mode.admits),
        flow,
        lambda: mode.guards,
    )


def no_equilibrium_error(model: ModelOrAutomaton) -> ValueError:
    """The error for a model or an automaton of which none was found; it says whether it has none."""
    automaton, sliding = automaton_of(model), isinstance(model, Model)
    modes = [each.name for each in steady_modes(automaton, sliding)]
    what = type(model).__name__ if sliding else "the automaton"
    search = first_mode_equilibria(automaton, sliding)
    got = "got none" if search.complete else "none was found"
    unsure = "" if search.complete else f" by a search that cannot exclude one, as {search.why}"
    return ValueError(
        f"{what} must have a mode with an equilibrium inside its guards, "
        f"{got} in {', '.join(modes)}{unsure}: change its parameters, or simulate its motion"
    )


def newton_residual(flow: Flow, x: Array, values: Sequence[float]) -> float:
    """The step that Newton's method would still take, relative to the state."""
    step = np.abs(newton_step(flow, x[:, None], values)).max()
    return float(step / max(np.abs(x).max(), np.finfo(float).tiny)) if step else 0.0


def continuation_solver(
    flow: Flow, x: Array, base: tuple[float, ...], lasts: Callable[[Array, Sequence[Any]], Any]
) -> Callable[[Sequence[Any], int], Array]:
    """`solve` of an :class:`EquilibriumProblem` that follows a zero of the flow from `x` (m,) at `base`."""

    def solve(values: Sequence[Any], count: int) -> Array:
        zeros = follow_zero(flow, x, base, values, count)
        zeros[:, ~lasts(zeros, values)] = np.nan
        return zeros

    return solve


def _state_names(automaton: HybridAutomaton) -> tuple[str, ...]:
    count = automaton.coordinates or len(automaton.state_names)
    return automaton.state_names[:count]


REAL_ROOT_RTOL = 1e-4  # a double root comes out of the eigenvalues as a pair, some 1e-8 off the real axis
STATIC_RESIDUAL_RTOL = 1e-9  # share of the largest force: roots with a larger residual are none
NEWTON_STEPS = 4
MOST_HALVINGS = 200  # from 1e30 to 1e-30


def least_penetration(statics: Statics, values: Sequence[Any], count: int) -> Array:
    """Penetrations (count,) in m; NaN where there is no equilibrium with F_N > 0."""
    excess = excess_polynomial(statics, values)
    with np.errstate(all="ignore"):
        if excess is None:
            penetrations = _isolated_candidates(statics, values, count)
        else:
            penetrations = _polynomial_candidates(
                statics, values, np.broadcast_to(excess, (len(excess), count))
            )
        q = statics.coordinates(penetrations, *values)
        _, solved = is_static(statics, penetrations, q, values, STATIC_RESIDUAL_RTOL)
    least = np.where(
        solved & (penetrations > 0) & (statics.forces(penetrations, *values)[0] > 0), penetrations, np.inf
    ).min(axis=0)
    return np.where(np.isfinite(least), least, np.nan)


def excess_polynomial(statics: Statics, values: Sequence[Any]) -> Array | None:
    """Coefficients of the excess penetration(q(d)) - d as a polynomial in the penetration d.

    With Eq. (2) its degree is at most 9.  None if a law is no polynomial.
    """
    try:
        excess = statics.excess(UNKNOWN, values)
    except (TypeError, ValueError, AttributeError):  # sqrt, a fractional power, exp or a comparison in a law
        return None
    return excess.coefficients if isinstance(excess, Polynomial) else None


def _polynomial_candidates(statics: Statics, values: Sequence[Any], excess: Array) -> Array:
    """Nearly real roots (k, N), polished by Newton's method on the original equation."""
    roots = _companion_roots(excess)
    real = np.abs(roots.imag) <= REAL_ROOT_RTOL * np.abs(roots.real)
    pressed = (roots.real > 0) & (statics.forces(roots.real, *values)[0] > 0)
    penetrations = np.sort(np.where(real & pressed, roots.real, np.nan), axis=0)
    penetrations = penetrations[: int(np.isfinite(penetrations).sum(axis=0).max(initial=1))]  # NaN comes last
    return polish_roots(statics, values, penetrations)


def polish_roots(statics: Statics, values: Sequence[Any], penetrations: Array) -> Array:
    """Newton's method on the original equation, which does not suffer from cancellation as the polynomial
    does."""
    left = np.abs(statics.excess(penetrations, values))
    for _ in range(NEWTON_STEPS):
        trial = penetrations - statics.excess(penetrations, values) / statics.slope(penetrations, values)
        rest = np.abs(statics.excess(trial, values))
        penetrations, left = np.where(rest < left, trial, penetrations), np.fmin(rest, left)
    return penetrations


def _companion_roots(coefficients: Array) -> NDArray[np.complex128]:
    """All roots (degree, N).  Their reciprocals are eigenvalues, so a leading coefficient may vanish."""
    degree = len(coefficients) - 1
    # Without a preload the penetration is a factor: it is divided out, which leaves the other roots.
    coefficients = np.where(coefficients[0] == 0, np.roll(coefficients, -1, axis=0), coefficients)
    companion = np.zeros((coefficients.shape[1], degree, degree))
    companion[:, range(1, degree), range(degree - 1)] = 1.0
    with np.errstate(all="ignore"):
        # In units of the penetration without contact force, which is the constant term.
        scale = np.abs(coefficients[0]) ** np.arange(1, degree + 1)[:, None]
        companion[:, 0] = -(coefficients[1:] * scale / coefficients[0]).T
        broken = ~np.isfinite(companion[:, 0]).all(axis=1)
        companion[broken] = np.eye(degree)
        roots = np.abs(coefficients[0]) / np.linalg.eigvals(companion).astype(complex).T
    roots[:, broken] = np.nan
    return roots


def _isolated_candidates(statics: Statics, values: Sequence[Any], count: int) -> Array:
    """Positive roots (k, N) of an equation that is no polynomial; NaN fills columns with fewer than k."""
    # Of most laws one box ends at the penetration without contact force, and holds the only root.
    free = np.abs(np.broadcast_to(statics.excess(0.0, values), (count,)))
    free = np.where((free > SMALLEST) & (free < LARGEST), free, 1.0)
    least, most = np.full(count, SMALLEST), np.full(count, LARGEST)
    boxes = Boxes(
        np.stack([np.append(least, free), np.append(free, most)])[:, None], np.tile(np.arange(count), 2)
    )
    search = isolate_zeros(one_equation(statics.equation, values), boxes)
    low, high = (_columns(end[0], search.single.owners, count) for end in search.single.ends)
    roots = _enclosed_roots(statics, values, low, high)
    for i in np.unique(np.append(search.narrow.owners, search.undecided.owners)):
        alone = [v if np.ndim(v) == 0 else float(np.broadcast_to(v, (count,))[i]) for v in values]
        points = find_zeros(statics.equation, alone).points[0]
        roots = np.vstack([roots, _columns(points, np.full(len(points), i), count)])
    # Without preload zero is a root, up to rounding: there is no contact.
    return np.where(no_contact(statics, values, roots), np.nan, roots)


def no_contact(statics: Statics, values: Sequence[Any], roots: Array) -> Any:
    """Which roots are zero up to rounding of the equation, so that there is no contact."""
    zero = interval(statics.excess(interval(np.zeros(())), values)).contains_zero()
    around = interval(statics.excess(interval(roots), values))
    return zero & (
        np.abs(roots) <= (around.high - around.low) / np.abs(statics.slope(np.zeros_like(roots), values))
    )


def _enclosed_roots(statics: Statics, values: Sequence[Any], low: Array, high: Array) -> Array:
    """The one root in each interval, by Newton's method, or by halving if a step leads out."""
    rises = statics.excess(high, values) > 0
    x = (low + high) / 2
    for _ in range(MOST_HALVINGS):
        left = statics.excess(x, values)
        below = (left > 0) != rises
        low, high = np.where(below, x, low), np.where(below, high, x)
        step = x - left / statics.slope(x, values)
        inside = (step > low) & (step < high)
        after = np.where(left == 0, x, np.where(inside, step, (low + high) / 2))
        still = np.abs(after - x) <= MACHINE_EPSILON * np.abs(x)
        x = after
        if (still | np.isnan(x)).all():
            break
    return x


def _columns(numbers: Array, owners: Any, count: int) -> Array:
    """The numbers of each owner as a column of (k, count), filled up with NaN."""
    order = np.argsort(owners, kind="stable")
    numbers, owners = numbers[order], owners[order]
    row = np.arange(len(owners)) - np.searchsorted(owners, owners)
    table = np.full((1 + row.max(initial=0), count), np.nan)
    table[row, owners] = numbers
    return table


def sliding_problem(model: Model, start: Array | None = None) -> EquilibriumProblem:
    """Steady sliding of a model at the equilibrium with F_N > 0 and the smallest penetration.

    With `start` (2n,) it is the equilibrium at this state, followed from there.
    """
    equations = sliding_equations(model)
    values = equations.values(model)
    solve: Callable[[Sequence[Any], int], Array] = partial(_solve, equations)
    if start is not None:
        solve = continuation_solver(sliding_flow(equations), start, values, partial(_is_pressed, equations))
    return EquilibriumProblem(
        model,
        equations.coordinates,
        equations.key.parameters,
        values,
        solve,
        sliding_flow(equations),
        lambda: sliding_guards(equations, bool(equations.belt_speed(*values) > 0)),
    )


def _is_pressed(equations: SlidingEquations, x: Array, values: Sequence[Any]) -> Any:
    return (sliding_flow(equations).margin(x, values) > 0) & ~equations.rests(values)


@cache
def sliding_flow(equations: SlidingEquations) -> Flow:
    """The flow of sliding with friction in the sign of the belt's speed, whatever the model's other modes."""
    derivations = equations.derivations
    rates = kept_formulas(
        derivations, "rates of sliding", lambda: equations.formulas_of_states(_sliding_rates(equations))
    )
    margins = kept_formulas(
        derivations,
        "margins of sliding",
        lambda: equations.formulas_of_states([equations.system.rubbing.pressing]),
    )
    return Flow(equations.key.parameters, rates, margins)


def _sliding_rates(equations: SlidingEquations) -> tuple[Any, ...]:
    from frictionlab.models.mechanical.contact_regimes import regime  # which load sympy
    from frictionlab.models.mechanical.modes import flow_of, solve_contact_forces

    system = equations.system
    slip = regime(system.rubbing, "slip", system)
    return flow_of(system, solve_contact_forces(system, (slip,)).accelerations)


@cache
def sliding_guards(equations: SlidingEquations, forwards: bool) -> Formulas:
    """The functions that stay positive while the model slides as in the flow: +-v_r, the penetration."""

    def derive() -> Formulas:
        from frictionlab.models.mechanical.contact_regimes import regime  # which loads sympy

        system = equations.system
        contact = system.rubbing
        name = "slip" if "slip" in contact.modes else "slip+" if forwards else "slip-"
        sliding = regime(contact, name, system)
        return equations.formulas_of_states(
            [end.function for end in sliding.ends(sliding.force, sliding.limit)]
        )

    return kept_formulas(
        equations.derivations, f"guards of sliding {'forwards' if forwards else 'backwards'}", derive
    )


def _solve(equations: SlidingEquations, values: Sequence[Any], count: int) -> Array:
    x = np.full((2 * len(equations.coordinates), count), np.nan)
    for statics, chosen in statics_groups(equations, values, count):
        some = [v if np.ndim(v) == 0 else np.broadcast_to(v, (count,))[chosen] for v in values]
        x[:, chosen] = _states_in_contact(statics, some, len(x), int(chosen.sum()))
    x[:, np.broadcast_to(equations.rests(values), (count,))] = np.nan
    return x


def _states_in_contact(statics: Statics, values: Sequence[Any], rows: int, count: int) -> Array:
    penetrations = least_penetration(statics, values, count)
    x = np.zeros((rows, count))
    for row, q in zip(x, statics.coordinates(penetrations, *values)):
        row[:] = q
    x[:, np.isnan(penetrations)] = np.nan
    return x
