"""Equilibria of the modes of an automaton, by Newton's method, and the problem that follows one of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache, partial
from typing import Any

import numpy as np
import sympy
from numpy.typing import NDArray

from frictionlab.automaton import HybridAutomaton, Mode
from frictionlab.automaton.modes_on_demand import ModesOnDemand, Regime
from frictionlab.models import Model
from frictionlab.models.coercion import automaton_of
from frictionlab.stability.equilibrium_points.newton import find_zeros, follow_zero, newton_step
from frictionlab.stability.equilibrium_problem import EquilibriumProblem
from frictionlab.stability.flow import Flow

Array = NDArray[np.float64]
CONSTRAINT_RTOL = 1e-9  # share of its terms to which a constraint has to hold at an equilibrium


def nearest_equilibrium_problem(model: Any, closest_to: Array | None = None) -> EquilibriumProblem:
    """The equilibrium, nearest to the origin, of the first mode that has one inside its guards.

    Or the one nearest to the coordinates `closest_to` (n,), or to these states where there are no
    coordinates.

    Raises
    ------
    ValueError
        If no mode has one.
    """
    automaton = automaton_of(model)
    mode, flow, points = first_mode_equilibria(automaton, isinstance(model, Model))
    if not points.size:
        raise no_equilibrium_error(model)
    i = (
        0
        if closest_to is None
        else int(np.argmin(np.linalg.norm(points[: len(closest_to)] - closest_to[:, None], axis=0)))
    )
    return problem_from_equilibrium(model, automaton, mode, flow, points[:, i])


def problem_from_equilibrium(
    model: Any, automaton: HybridAutomaton, mode: Mode, flow: Flow, x: Array, **changes: float
) -> EquilibriumProblem:
    """The steady state of a mode followed from `x` (m,), where it is with some parameters changed."""
    guards, values = tuple(event.function for event in mode.events), parameter_values(automaton)
    start = parameter_values(automaton.replace(**changes)) if changes else values
    return EquilibriumProblem(
        model,
        _state_names(automaton),
        flow,
        values,
        continuation_solver(flow, x, start, partial(_is_admissible, mode, flow)),
        guards,
    )


def no_equilibrium_error(model: Any) -> ValueError:
    """The error for a model or an automaton that has none."""
    modes = equilibrium_modes(automaton_of(model), not isinstance(model, HybridAutomaton))
    what = "the automaton" if isinstance(model, HybridAutomaton) else type(model).__name__
    return ValueError(
        f"{what} must have a mode with an equilibrium inside its guards, "
        f"got none in {', '.join(mode.name for mode in modes)}: change its parameters"
    )


def equilibrium_modes(automaton: HybridAutomaton, sliding: bool) -> Iterator[Mode]:
    """The modes in which equilibria are searched for, derived one by one.

    For a model those without constraints (`sliding`): in stick every position within the friction cone is an
    equilibrium.
    """
    if isinstance(automaton.modes, ModesOnDemand):
        return automaton.modes.select(
            lambda regime: not (sliding and regime.holds) and _can_rest(automaton, regime)
        )
    return (mode for mode in automaton.modes if not (sliding and (mode.constraints or mode.limit)))


def first_mode_equilibria(automaton: HybridAutomaton, sliding: bool) -> tuple[Mode, Flow, Array]:
    """The first mode with equilibria inside its guards, its flow, and them (m, K); else K is 0."""
    values = tuple(automaton.parameters.items())
    return _mode_equilibria(automaton.modes, sliding, automaton.states, values, automaton.coordinates)


@lru_cache(maxsize=64)
def _mode_equilibria(
    modes: tuple[Mode, ...] | ModesOnDemand, sliding: bool, states: Any, parameters: Any, coordinates: int
) -> tuple[Mode, Flow, Array]:
    """The same of these modes; remembered, as one question about a model leads to several."""
    automaton = HybridAutomaton(states, modes, dict(parameters), coordinates)
    mode = next(equilibrium_modes(automaton, sliding), None) or modes[0]
    flow = _flow_in_automaton(automaton, mode)
    for mode in (m for m in equilibrium_modes(automaton, sliding) if _allows_rest(automaton, m)):
        flow = _flow_in_automaton(automaton, mode)
        points = find_zeros(flow, parameter_values(automaton))
        points = points[:, _is_admissible(mode, flow, points, parameter_values(automaton))]
        if points.size:
            return mode, flow, points
    return mode, flow, np.zeros((len(automaton.states), 0))


def _allows_rest(automaton: HybridAutomaton, mode: Mode) -> bool:
    """Whether a mode's constraints can hold at zero velocities: not in stick on a running belt."""
    return all(c == 0 for c in _constants_at_rest(automaton, mode.constraints))


def _can_rest(automaton: HybridAutomaton, regime: Regime) -> bool:
    """Whether a regime's conditions can hold at zero velocities: not in slip against a running belt."""
    return not any(c < 0 for c in _constants_at_rest(automaton, regime.conditions))


def _constants_at_rest(automaton: HybridAutomaton, functions: Sequence[Any]) -> list[Any]:
    """The values at zero velocities of those functions that do not depend on other states."""
    n = automaton.coordinates
    at_rest = dict.fromkeys(automaton.states[n : 2 * n], 0)
    held = [sympy.sympify(c, strict=True).subs(at_rest) for c in functions]
    return [c.subs(automaton.parameters) for c in held if not c.free_symbols & set(automaton.states)]


def parameter_values(automaton: HybridAutomaton) -> tuple[float, ...]:
    """The parameters' values."""
    return tuple(float(value) for value in automaton.parameters.values())


def newton_residual(flow: Flow, x: Array, values: Sequence[float]) -> float:
    """The step that Newton's method would still take, relative to the state."""
    step = np.abs(newton_step(flow, x[:, None], values)).max()
    return float(step / max(np.abs(x).max(), np.finfo(float).tiny)) if step else 0.0


def continuation_solver(
    flow: Flow, x: Array, base: tuple[float, ...], lasts: Callable[[Array, Sequence[Any]], Any]
) -> Callable[[Sequence[Any], int], Array]:
    """`solve` of an :class:`EquilibriumProblem` that follows a zero of the flow from `x` (m,) at `base`."""

    def solve(values: Sequence[Any], count: int) -> Array:
        found = follow_zero(flow, x, base, values, count)
        found[:, ~lasts(found, values)] = np.nan
        return found

    return solve


def _is_admissible(mode: Mode, flow: Flow, x: Array, values: Sequence[Any]) -> Any:
    """Where a mode can last at states (m, N): inside its guards, with its constraints kept."""
    with np.errstate(all="ignore"):
        lasts = flow.margin(x, values) > 0
        for held, size in zip(*(functions(*x, *values) for functions in _constraints(mode, flow))):
            lasts = lasts & (np.abs(held) <= CONSTRAINT_RTOL * size)
    return lasts


@lru_cache(maxsize=256)
def _constraints(mode: Mode, flow: Flow) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """The constraints of a mode, and the sizes of the terms that cancel in each."""
    at_rest = dict.fromkeys(flow.states, 0)
    held = [sympy.sympify(c, strict=True) for c in mode.constraints]
    terms = [[c.subs(at_rest), *(sympy.diff(c, s) * s for s in flow.states)] for c in held]
    sizes = [sum(abs(term) for term in some) for some in terms]
    return flow.compiled(held), flow.compiled(sizes)


def _flow_in_automaton(automaton: HybridAutomaton, mode: Mode) -> Flow:
    return flow_of_mode(mode, automaton.states, tuple(automaton.parameters), automaton.coordinates)


@lru_cache(maxsize=256)
def flow_of_mode(mode: Mode, states: tuple[Any, ...], parameters: tuple[Any, ...], coordinates: int) -> Flow:
    """The flow of a mode, with its margins, which have to stay positive: event functions and normal force."""
    margins = [event.function for event in mode.events]
    margins += [mode.outputs["normal_force"]] if "normal_force" in mode.outputs else []
    return Flow(states, parameters, mode.flow, tuple(margins), coordinates)


def _state_names(automaton: HybridAutomaton) -> tuple[str, ...]:
    count = automaton.coordinates or len(automaton.states)
    return tuple(symbol.name for symbol in automaton.states[:count])
