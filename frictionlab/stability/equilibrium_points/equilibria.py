"""`fl.equilibria` and `fl.equilibrium`: all equilibria of a model or an automaton, or the default one.

Also the `EquilibriumProblem` at one of them, or at all in a range of a parameter.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionlab.automaton import HybridAutomaton
from frictionlab.automaton.modes_on_demand import has_regime
from frictionlab.models.mechanical.mechanical_model import MechanicalModel
from frictionlab.models.model import PROBLEM, Model, ModelOrAutomaton, automaton_of
from frictionlab.presentation import PHASE, Drawable, force_symbol, output_unit, shorten, unit_of_state
from frictionlab.stability.equilibrium_points.frozen_time import automaton_at_rest, is_sliding, refuse_time
from frictionlab.stability.equilibrium_points.newton import follow_zero, newton_step, settled_first
from frictionlab.stability.equilibrium_points.sliding import (
    Statics,
    all_penetrations,
    sliding_equations,
    sliding_problem,
    statics_at,
)
from frictionlab.stability.equilibrium_points.steady_modes import (
    SteadyMode,
    all_mode_equilibria,
    first_mode_equilibria,
    has_many_modes,
    parameter_values,
    steady_modes,
)
from frictionlab.stability.equilibrium_points.steady_rates import clocks_of
from frictionlab.stability.equilibrium_problem import EquilibriumProblem, check_masses_of
from frictionlab.stability.flow import Flow
from frictionlab.stability.large_system import LargeSystem
from frictionlab.validation import abbreviate

EQUILIBRIUM_RTOL = 1e-12  # share of a coordinate: an equilibrium computed again is the same but for rounding

Array = NDArray[np.float64]
# Values at which all equilibria are looked for: one branch may live between two of them.
BRANCH_SEARCH_POINTS = 9
# Where one is looked for in a range: not in its middle, where a fold is likely.
BRANCH_SEARCH_SHARES = (np.arange(BRANCH_SEARCH_POINTS) + 0.47) / BRANCH_SEARCH_POINTS
# Shares of a range beside a value: if an equilibrium is lost on both sides, it is at a fold.
BESIDE_SHARES = np.array([-1e-9, 1e-9])
SAME_BRANCH_RTOL = 1e-6  # share of a state to which two branches agree
SAME_BRANCH_ROUNDING = 1e-12  # share of the largest state: what differs by less differs by rounding

MAX_STATIC_RESIDUAL = 1e-6  # share of the largest force that may be left over at an equilibrium


def equilibrium_problem(
    model: ModelOrAutomaton,
    equilibrium: Equilibrium | None = None,
    within: Mapping[str, Sequence[float] | Array] | None = None,
) -> EquilibriumProblem:
    """The problem of a model or an automaton, at its default equilibrium or at a given one.

    Where the model's own parameters have none, or have it at a fold, it is that at the nearest of the values
    that are searched between the least and the largest that some parameters take `within` a study.

    Raises
    ------
    TypeError
        If it is neither.
    ValueError
        If the equilibrium is not one of the model, or values `within` a study leave a motion without a mass.
    """
    check_masses_of(model, within or {})
    if equilibrium is not None:
        return _new_problem(model, _check_equilibrium(model, equilibrium))
    if within and sliding_equations(model) is None and (problem := _problem_within(model, within)):
        return problem
    notes = vars(model) if isinstance(model, Model) else {}
    if PROBLEM not in notes:
        notes[PROBLEM] = _new_problem(model)
    return notes[PROBLEM]


def _problem_within(
    model: ModelOrAutomaton, within: Mapping[str, Sequence[float] | Array]
) -> EquilibriumProblem | None:
    """The problem at the model's own values, or where it cannot be followed, at the nearest that have an
    equilibrium; None where none has.

    These are at shares of the ranges that are not round: an equilibrium at a fold could not be followed.
    """
    automaton, sliding = automaton_at_rest(model), is_sliding(model)
    own = np.array([automaton.values[name] for name in within])
    spans = np.array([np.ptp(values) or 1.0 for values in within.values()])
    if first_mode_equilibria(automaton, sliding).points.size:
        problem = equilibrium_problem(model)
        if problem.flow.linear:  # it has no fold
            return problem
        beside = own[:, None] + BESIDE_SHARES * spans[:, None]
        if np.isfinite(problem.states(dict(zip(within, beside)))).all(axis=0).any():
            return problem
    some = [np.unique(np.min(values) + np.ptp(values) * BRANCH_SEARCH_SHARES) for values in within.values()]
    for point in sorted(product(*some), key=lambda one: np.abs((one - own) / spans).max()):
        change = dict(zip(within, map(float, point)))
        mode, points = _first_equilibria(model, automaton.replace(**change))
        if points.size:
            return _problem_from_equilibrium(model, automaton, mode, points[:, 0], **change)
    return None


def _new_problem(model: ModelOrAutomaton, near: Array | None = None) -> EquilibriumProblem:
    if not isinstance(model, Model) or (equations := sliding_equations(model)) is None:
        return _nearest_problem(model, near)
    return sliding_problem(model, equations, near)


def _check_equilibrium(model: ModelOrAutomaton, equilibrium: Any) -> NDArray[np.float64]:
    """The state of one of the model's equilibria, checked to have F_N > 0 where there is a contact."""
    candidates = equilibria(model)
    if not isinstance(equilibrium, Equilibrium) or not any(
        _same_equilibrium(e, equilibrium) for e in candidates
    ):
        raise ValueError(
            f"equilibrium must be one of the {len(candidates)} of the model, got {abbreviate(equilibrium)}: "
            "take one from equilibria(model)"
        )
    if sliding_equations(model) is not None and not equilibrium.normal_force > 0:
        raise ValueError(
            f"equilibrium must have F_N > 0, got {equilibrium.normal_force:.4g} N: there is no contact"
        )
    return equilibrium.state


def _same_equilibrium(one: Equilibrium, other: Equilibrium) -> bool:
    x, y = one.state, other.state
    return x.shape == y.shape and np.allclose(x, y, rtol=EQUILIBRIUM_RTOL, atol=0.0)


def _nearest_problem(model: ModelOrAutomaton, closest_to: Array | None) -> EquilibriumProblem:
    """The problem of the equilibrium nearest to the origin, in the first mode that has one inside its guards.

    With `closest_to` (m,) it is the equilibrium nearest to this state.

    Raises
    ------
    ValueError
        If no mode has one.
    """
    automaton = automaton_at_rest(model)
    if closest_to is None:
        mode, points = _first_equilibria(model, automaton)
    else:
        mode, points, *_ = min(
            all_mode_equilibria(automaton, is_sliding(model)),
            key=lambda one: _distances(one.points, closest_to).min(initial=np.inf),
        )
    if not points.size:
        raise _no_equilibrium_error(model)
    i = 0 if closest_to is None else int(np.argmin(_distances(points, closest_to)))
    return _problem_from_equilibrium(model, automaton, mode, points[:, i])


def _first_equilibria(model: ModelOrAutomaton, automaton: HybridAutomaton) -> tuple[SteadyMode, Array]:
    """The first mode that has equilibria, and these (m, K), the one that is taken first."""
    mode, points, _ = first_mode_equilibria(automaton, is_sliding(model))
    return mode, _in_order(model, automaton, mode, points)


def _in_order(model: ModelOrAutomaton, automaton: HybridAutomaton, mode: SteadyMode, points: Array) -> Array:
    """Equilibria (m, K) of a mode, by `settled_first`."""
    if points.shape[1] < 2 or not isinstance(model, MechanicalModel):
        return points
    names = [name for about in model.states_of_laws().known for name in about["names"]]
    places = [automaton.state_names.index(name) for name in names]
    return settled_first(mode.flow, points, parameter_values(automaton), places)


def _distances(points: Array, state: Array) -> Array:
    """Distances (K,) of points (m, K) from a state (m,)."""
    return np.linalg.norm(points - state[:, None], axis=0)


def _problem_from_equilibrium(
    model: ModelOrAutomaton, automaton: HybridAutomaton, mode: SteadyMode, x: Array, **changes: float
) -> EquilibriumProblem:
    """The problem of a mode's equilibrium, followed from `x` (m,), its state with `changes` of parameters."""
    values = parameter_values(automaton)
    start = parameter_values(automaton.replace(**changes)) if changes else values
    mode = mode.regular_at(x, start)
    flow = mode.flow
    return EquilibriumProblem(
        model,
        automaton.shown_states,
        tuple(automaton.values),
        values,
        partial(follow_zero, flow, x, start, mode.admits),
        flow,
        lambda: mode.guards,
        mode.following,
    )


def _no_equilibrium_error(model: ModelOrAutomaton) -> ValueError:
    """The error for a model or an automaton of which none was found; it says whether it has none."""
    refuse_time(model, "an equilibrium")
    automaton, sliding = automaton_at_rest(model), is_sliding(model)
    modes = {each.name: each.in_words for each in steady_modes(automaton, sliding)}
    what = type(model).__name__ if sliding else "the automaton"
    search = first_mode_equilibria(automaton, sliding)
    got = "none was found" if search.why else "got none"
    unsure = f" by a search that cannot exclude one, as {search.why}" if search.why else ""
    others = [name for name in automaton.names if name not in modes] if not automaton.on_demand else []
    if automaton.on_demand and has_regime(automaton.names, "stick") and not has_regime([*modes], "stick"):
        others = ["stick of any contact"]
    forced = PHASE in automaton.state_names and sliding
    still = ", such as the amplitude or the frequency of a load, as its phase never rests" if forced else ""
    left_out = f" ({shorten(others)} has none that is a single point)" if others and sliding else ""
    # Modes of an elastic-plastic law have no constraints: that in which it sticks is among those searched.
    elastic = "; the spring of an elastic-plastic law that sticks may rest at any deflection: write it into "
    elastic = (
        f"{elastic}the potential for its eigenvalues" if search.why and has_regime([*modes], "stick") else ""
    )
    drift = _drift_in_words(automaton, sliding)
    return ValueError(
        f"{what} must have a mode with an equilibrium inside its guards, {got} in "
        f"{shorten([*modes.values()]) or 'no mode'}{unsure}{left_out}{drift}: change its "
        f"parameters{still}, or simulate its motion{elastic}"
    )


def _drift_in_words(automaton: HybridAutomaton, sliding: bool) -> str:
    """The further states without whose drift there is an equilibrium; "" where it is not they."""
    names, values = automaton.state_names, parameter_values(automaton)
    clocks, first = clocks_of(automaton), 2 * automaton.coordinates or len(names)

    def rates_with(held: tuple[int, ...]) -> Array | None:
        """The rates (m,) at an equilibrium of the other states; None where there is none."""
        for mode in steady_modes(automaton, sliding) if held else ():
            if (points := mode.equilibria_with(held, values)).size:
                return mode.flow.rhs(points[:, 0], values)
        return None

    held = tuple(place for place in range(first, len(names)) if place not in clocks)
    if (rates := rates_with(held)) is None:
        return ""
    for place in held:
        others = tuple(each for each in held if each != place)
        if (of_others := rates_with(others)) is not None:
            held, rates = others, of_others
    drifts = shorten(f"{names[place]} drifts by {rates[place]:.4g} per s" for place in held)
    which = shorten(names[place] for place in held)
    return f"; with {which} held at zero, as parameters are, there is one, where {drifts}"


def equilibrium_branches(
    model: ModelOrAutomaton, parameter: str, bounds: tuple[float, float]
) -> list[EquilibriumProblem]:
    """Problems of all equilibria that are inside the guards of a mode at some values in the range.

    Each is followed from there.  Of models that are solved by the penetration (`sliding_equations`) it is
    only the one with the smallest penetration.

    Raises
    ------
    ValueError
        If there is none in the range.
    """
    if sliding_equations(model) is not None:
        return [equilibrium_problem(model)]
    automaton = automaton_at_rest(model)
    at, problems = np.linspace(*bounds, BRANCH_SEARCH_POINTS), []
    # mode -> states (m, BRANCH_SEARCH_POINTS) of each of its branches, NaN where one does not exist
    branch_states: dict[SteadyMode, list[Array]] = {}
    for i, value in enumerate(at):
        change = {parameter: float(value)}
        searched = all_mode_equilibria(automaton.replace(**change), is_sliding(model))
        for mode, x in ((mode, x) for mode, points, _ in searched for x in points.T):
            branches = branch_states.setdefault(mode, [])
            if branches and _is_among(np.array(branches)[:, :, i], x):
                continue
            problems.append(_problem_from_equilibrium(model, automaton, mode, x, **change))
            branches.append(problems[-1].states({parameter: at}))
    if not problems:
        raise _no_equilibrium_error(model)
    return problems


def _is_among(states: Array, x: Array) -> bool:
    """Whether one of the states (K, m) is x (m,)."""
    size = np.fmax(np.abs(states), np.abs(x))
    slack = SAME_BRANCH_RTOL * size + SAME_BRANCH_ROUNDING * size.max(axis=1, keepdims=True)
    return bool((np.abs(states - x) <= slack).all(axis=1).any())


@dataclass(frozen=True, eq=False)
class Equilibrium(Drawable):
    """A state of steady sliding, or of steady rotation, in which cyclic coordinates turn.

    Parameters
    ----------
    state : array (m,)
        The whole state: coordinates, velocities, and what further states there are.
    penetration : float
        Penetration of the contact, m; rad where the bodies turn.
    normal_force, friction_force : float
        F_N and F_T, N; moments in N m where the bodies turn.  Like the penetration, NaN where the mode of an
        automaton has no such output.
    residual : float
        Largest force or moment left over in the static equations, relative to the largest in them.
    model : Model or HybridAutomaton
    names : tuple of str
        Names of the coordinates, or of all states of an automaton that has none.
    """

    drawn_by = "plot_equilibrium"

    state: Array
    penetration: float
    normal_force: float
    friction_force: float
    residual: float
    model: ModelOrAutomaton
    names: tuple[str, ...]

    @property
    def q(self) -> Array:
        """The coordinates (n,), m and rad; all states of an automaton that has no coordinates."""
        return self.state[: len(self.names)]

    def __repr__(self) -> str:
        has_units = bool(self.model.coordinates)  # of an automaton without coordinates they may be any
        units = {name: unit_of_state(self.model, name) for name in self.names}
        n = len(self.names)
        turning = [
            (f"{name}'", v) for name, v in zip(self.names, self.state[n : 2 * n]) if has_units and v != 0.0
        ]
        units |= {name: unit_of_state(self.model, name) for name, _ in turning}
        numbers = [*zip(self.names, self.q), *turning, *zip(self._further_names, self.state[2 * n :])]
        places = shorten(f"{name} {value:.4g} {units.get(name, '')}".rstrip() for name, value in numbers)
        forces = contact_forces(self).values()
        acting = "".join(f", {name} {force:.4g} {unit}" for name, force, unit in forces)
        return f"Equilibrium({places}{acting})"

    @property
    def _further_names(self) -> tuple[str, ...]:
        """Names of the states that are neither coordinates nor velocities, such as temperatures."""
        if len(self.state) <= 2 * len(self.names):
            return ()
        return automaton_of(self.model).state_names[2 * len(self.names) :]


def contact_forces(point: Equilibrium) -> dict[str, tuple[str, float, str]]:
    """Symbol, value and unit of each contact force, or moment, that an equilibrium has."""
    sizes = {"normal_force": point.normal_force, "friction_force": point.friction_force}
    return {
        name: (force_symbol(name, point.model), size, output_unit(name, point.model))
        for name, size in sizes.items()
        if np.isfinite(size)
    }


class Equilibria(tuple[Equilibrium, ...]):
    """Equilibria that a search found, as a tuple, and whether there are others.

    Parameters
    ----------
    members : iterable of Equilibrium
    why : str
        Why others cannot be excluded; empty where it is known that there are none.
    left_out : str
        What was not searched, such as "stick"; empty if nothing.
    """

    why: str
    left_out: str

    def __new__(cls, members: Iterable[Equilibrium], why: str = "", left_out: str = "") -> Equilibria:
        self = super().__new__(cls, members)
        self.why, self.left_out = why, left_out
        return self

    @property
    def complete(self) -> bool:
        """Whether it is known that there are no others, but for what was left out."""
        return not self.why

    def __reduce__(self) -> tuple[Any, ...]:
        return Equilibria, (tuple(self), self.why, self.left_out)

    def __repr__(self) -> str:
        listed = shorten(map(repr, self))
        where = f" without {self.left_out}" if self.left_out else ""
        if self.complete:
            return f"Equilibria({listed or f'none exists{where}'})"
        return f"Equilibria({listed or f'none was found{where}'}, others are not excluded: {self.why})"


def equilibria(model: ModelOrAutomaton) -> Equilibria:
    """All real solutions of the static equations of sliding, Eq. (18), in ascending order of the penetration.

    The contact law is taken as it is for a negative penetration too, as the paper's equations do: a solution
    with F_N < 0 is an equilibrium of a bilateral contact only.  Friction has the sign of the belt's speed.

    If the equation for the penetration is a polynomial, no solution is missed.  It is one with all laws of
    the package but HertzContact and PressureDependent.  For those, and for laws of your own that give no
    polynomial, the penetration is searched for in boxes, as states are (see `model`).

    Parameters
    ----------
    model : Model or HybridAutomaton
        If the model has no `statics` (SliderOnBelt has), the equilibria are those inside the guards of each
        mode, mode by mode, by their distance from the origin; of more than 27 modes, those of the first that
        has any.  Where states of a friction law settle at several values, equilibria at which these states
        grow, with all others held, come last; of the others, those nearest to zero in these states are first.
        In a mode in which rigid contacts are closed they keep distances at zero, and push.  A model's modes
        with stick are left out: there each place within the friction cone is one.  States that enter
        linearly are eliminated.  If at most four remain, boxes of their values are bisected by bounds of the
        equations, until each holds one equilibrium or none; a threefold one counts once; of an angle, on
        which all depends with the period 2 pi, those within one turn.  If that does not come to an
        end, Newton's method starts from all decades of size.  In steady rotation cyclic
        coordinates turn; that from which others are measured is zero.
        So is a phase, or the time, that moves nothing, as where a load's amplitude is 0, or stands still.
        Of a straight line of equilibria, as where Jenkins' element sticks with any deflection, one is given,
        and so where a law underflows to zero, as exp(-x) does beyond 745.

    Returns
    -------
    Equilibria
        A tuple of Equilibrium, with `complete`: whether it is known that there are no others, from 1e-30 to
        1e30 in size; and `why` it is not.  An empty one says "none exists" or "none was found",
        and "without stick" where modes with stick are left out.

    Raises
    ------
    ValueError
        If the springs do not hold a coordinate (singular stiffness matrix).
    """
    if not isinstance(model, Model) or (equations := sliding_equations(model)) is None:
        return _automaton_equilibria(model)
    values = equations.values(model)
    statics = statics_at(equations, values)
    penetrations, why = all_penetrations(statics, values)
    each = [_sliding_equilibrium(model, statics, values, penetration) for penetration in penetrations]
    for penetration, one in zip(penetrations, each, strict=True):
        if one is None:
            why = why or f"the last digit of a penetration near {penetration:.6g} m moves its forces too much"
    return Equilibria((one for one in each if one is not None), why)


def equilibrium(model: ModelOrAutomaton) -> Equilibrium:
    """The equilibrium of steady sliding with F_N > 0; of several the one with the smallest penetration.

    That is the one whose penetration grows from zero with the preload.  States of a friction law that settle
    at several values are where they do not grow by themselves; of several such the nearest to zero.

    Parameters
    ----------
    model : Model, HybridAutomaton or Structure
        See :func:`equilibria`.

    Returns
    -------
    Equilibrium

    Raises
    ------
    ValueError
        If there is none.

    Examples
    --------
    >>> import frictionlab as fl
    >>> fl.equilibrium(fl.SliderOnBelt(mu_k=0.3)).q.round(4).tolist()
    [-0.0042, -0.0304, -0.0036, -0.0061, -0.0001]
    """
    if isinstance(model, LargeSystem):
        return model.find_equilibrium()
    candidates = equilibria(model)
    if not isinstance(model, Model) or sliding_equations(model) is None:
        if not candidates:
            raise _no_equilibrium_error(model)
        return candidates[0]
    # A law with even powers may give F_N > 0 where there is no contact.
    pressed = [e for e in candidates if e.normal_force > 0 and e.penetration > 0]
    if pressed:
        return min(pressed, key=lambda e: e.penetration)
    forces = ", ".join(f"{e.normal_force:.4g} N" for e in candidates) or "none"
    unsure = "" if candidates.complete else f", while others are not excluded, as {candidates.why}"
    raise ValueError(
        f"there must be an equilibrium with F_N > 0, got normal forces: {forces}{unsure}: "
        f"raise the preload F ({model.F:g} N), or change friction or stiffnesses"
    )


def _automaton_equilibria(model: ModelOrAutomaton) -> Equilibria:
    automaton = automaton_at_rest(model)
    searched = all_mode_equilibria(automaton, is_sliding(model))
    values, names = parameter_values(automaton), automaton.shown_states
    members = (
        Equilibrium(
            x,
            *mode.shown(x, values),
            residual=_newton_residual(mode.regular_at(x, values).flow, x, values),
            model=model,
            names=names,
        )
        for mode, points, _ in searched
        for x in _in_order(model, automaton, mode, points).T
    )
    last = searched[-1]
    if not any(one.points.size for one in searched):
        refuse_time(model, "an equilibrium")
    unsearched = f"modes after {last.mode.name} are not searched" if has_many_modes(automaton) else ""
    left_out = "stick" if is_sliding(model) and has_regime(automaton.names, "stick") else ""
    return Equilibria(members, last.why or (unsearched if last.points.size else ""), left_out)


def _newton_residual(flow: Flow, x: Array, values: Sequence[float]) -> float:
    """The step that Newton's method would still take, relative to the state."""
    step = np.abs(newton_step(flow, x[:, None], values)).max()
    return float(step / max(np.abs(x).max(), np.finfo(float).tiny)) if step else 0.0


def _sliding_equilibrium(
    model: Model, statics: Statics, values: Sequence[float], penetration: float
) -> Equilibrium | None:
    """The equilibrium at a penetration; None where double precision cannot solve the static equations."""
    q: Any = np.array(statics.coordinates.arrays(penetration, *values), dtype=float)
    normal, friction = map(float, statics.forces.arrays(penetration, *values))
    residual, is_solved = statics.is_static(penetration, normal, q, values, MAX_STATIC_RESIDUAL)
    if not is_solved:
        return None
    share = float(residual)
    state = np.append(q, np.zeros(len(q)))
    return Equilibrium(state, penetration, normal, friction, share, model, tuple(model.coordinates))
