"""What a mechanical model states, in numbers: energies, loads and contacts at states, and their differences.

Nothing of the derivation of an automaton is used: no mass matrix, no equations of motion, no resets.  Slopes
are central differences of order 8 at several steps; of these the two that agree best give the value, and
their difference its error.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
import sympy as sp

from frictionlab.components.component import StructureKey
from frictionlab.models import MechanicalModel
from frictionlab.models.mechanical.dynamic_laws import limits_of_states, values_of_contact, values_of_law
from frictionlab.models.mechanical.equations_of_motion import time_of, with_dampers
from frictionlab.models.mechanical.mechanics import AnyContact, Contact, Stop, mechanics_at
from frictionlab.models.symbolic_laws import symbolic_copy, with_explained_errors
from frictionlab.models.symbols import parameter_symbols, structure_values, symbol
from frictionlab.presentation import PHASE
from frictionlab.tape.formulas import function_along_run

Array = Any
StateFunction = Callable[..., Any]

# of the steps of differences: share of a state's size, factor, number
FIRST_SHARE, REFINEMENT, LEVELS = 1e-2, 0.25, 7
ROUNDING = 4 * np.finfo(float).eps  # share of a function's values that is rounding in their differences
CENTRAL_WEIGHTS = 4 / 5, -1 / 5, 4 / 105, -1 / 280


@dataclass(frozen=True, eq=False)
class StatedContact:
    """The functions of a contact; None for those that it does not have.

    Parameters
    ----------
    speed, pressing, limit : callable or None
        v_r (m/s) and the static limit of friction (N), of contacts with friction; a dynamic law has no limit.
        F_N (N) of contacts that are not rigid.
    sliding : mapping of int to callable
        Friction (N) along v_r where this is positive, by 1, or negative, by -1.  Limit and friction
        of a rigid contact are shares of F_N, which follows from the motion.
    gap : callable or None
        The distance from a stop, or minus the penetration, m.
    normal : tuple of callable or None
        W_N, where it is not the gradient of the gap.
    law : ImpactLaw or None
    elastic : callable or None
        Friction (N) in stick of an elastic-plastic law.
    across : callable or None
        The second component of v_r (m/s) in the plane, where `speed` is the first, and `sliding` has friction
        over speed, N s/m, by 1.
    """

    gap: StateFunction | None
    law: Any
    speed: StateFunction | None = None
    across: StateFunction | None = None
    pressing: StateFunction | None = None
    limit: StateFunction | None = None
    sliding: Any = None
    normal: tuple[StateFunction, ...] | None = None
    elastic: StateFunction | None = None

    @property
    def rigid(self) -> bool:
        """Whether the normal force follows from the motion."""
        return self.pressing is None


@dataclass(frozen=True, eq=False)
class Statement:
    """Energies (J), loads (N) and contacts as functions of states and parameters.

    `others` are the rates of the states that follow coordinates and velocities: phase and further states.
    Those of friction laws come last; they have no part in energies and distances, so their rates are none of
    them.
    """

    names: tuple[str, ...]
    kinetic: StateFunction
    stored: StateFunction
    dissipation: StateFunction
    loads: tuple[StateFunction, ...]
    contacts: tuple[StatedContact, ...]
    others: tuple[StateFunction, ...]


@lru_cache(maxsize=64)
def _statement_of(key: StructureKey) -> Statement:
    copy = symbolic_copy(key)
    names = tuple(copy.coordinates)
    q, v = ([symbol(name + prime) for name in names] for prime in ("", "'"))
    phase, further = symbol(PHASE), [*map(symbol, copy.states)]
    time = time_of(copy)
    about = mechanics_at(copy, q, v, phase, further, *time)
    about = replace(about, contacts=tuple(map(with_explained_errors, about.contacts)))
    time = [one for one in time if about.depends_on(one)]
    about = with_dampers(about, q, v, time)
    in_time = about.frequency is not None
    of_laws = [tuple(map(symbol, names)) for names in about.law_states]
    states = [
        *q,
        *v,
        *([phase] if in_time else []),
        *time,
        *further,
        *(one for some in of_laws for one in some),
    ]
    others = [
        *([about.frequency] if in_time else []),
        *(sp.S.One for _ in time),
        *(about.rates[name] for name in copy.states),
    ]

    def compiled(expression: Any) -> StateFunction:
        return function_along_run([*states, *parameter_symbols(key)], expression)

    return Statement(
        tuple(map(str, states)),
        compiled(about.kinetic),
        compiled(about.stored),
        compiled(about.dissipation),
        tuple(compiled(about.loads.get(name, 0)) for name in names),
        tuple(_contact(c, some, compiled) for c, some in zip(about.contacts, of_laws, strict=True)),
        tuple(map(compiled, others)),
    )


def _contact(
    contact: AnyContact, of_law: tuple[Any, ...], compiled: Callable[[Any], StateFunction]
) -> StatedContact:
    if isinstance(contact, Stop):
        return _rigid_contact(contact, compiled)
    if isinstance(contact, Contact):
        return StatedContact(compiled(-contact.penetration), None, pressing=compiled(contact.pressing))
    (speed, *across), force, law = contact.velocities, contact.pressing, contact.law
    elastic, limits = None, limits_of_states(contact)
    if len(limits) == 1:
        elastic = compiled(values_of_law(law, force, speed, of_law).force)
        sliding = {sign: values_of_law(law, force, speed, (sign * limits[0],)).force for sign in (1, -1)}
    elif of_law:
        sliding = {sign: values_of_contact(contact, of_law, sign).force for sign in (1, -1)}
    elif across:
        size = sp.sqrt(speed**2 + across[0] ** 2)
        sliding = {1: law.kinetic(force, size) / size}
    else:
        sliding = {sign: sign * law.kinetic(force, sign * speed) for sign in (1, -1)}
    return StatedContact(
        None if contact.penetration is None else compiled(-contact.penetration),
        contact.impact,
        compiled(speed),
        compiled(across[0]) if across else None,
        compiled(force),
        None if of_law else compiled(law.static_limit(force)),
        {sign: compiled(friction) for sign, friction in sliding.items()},
        None if contact.normal is None else tuple(map(compiled, contact.normal)),
        elastic,
    )


def _rigid_contact(contact: Stop, compiled: Callable[[Any], StateFunction]) -> StatedContact:
    gap, speed, law = compiled(contact.distance), contact.relative_velocity, contact.friction
    if law is None:
        return StatedContact(gap, contact.law)
    sliding = {sign: compiled(sign * law.kinetic(1.0, sign * speed)) for sign in (1, -1)}
    limit = compiled(law.static_limit(1.0))
    return StatedContact(gap, contact.law, compiled(speed), limit=limit, sliding=sliding)


class StatedMechanics:
    """A model's statement at the values of its parameters; states are arrays (N, states).

    Parameters
    ----------
    model : MechanicalModel
    sizes : array (states,)
        Sizes of the states, by which steps of differences are chosen.
    """

    def __init__(self, model: MechanicalModel, sizes: Array) -> None:
        self._values = structure_values(model)
        self.statement = _statement_of(model.structure_key)
        self.contacts = self.statement.contacts
        self.n, self.sizes = len(self.statement.loads), sizes

    def at(self, function: Any, states: Array) -> Array:
        """Values (N,) of a function."""
        with np.errstate(all="ignore"):
            values = function(*states.T, *self._values)
        return np.broadcast_to(np.asarray(values, dtype=float), len(states))

    def slope(self, function: Callable[[Array], Array], states: Array, along: Array) -> tuple[Array, Array]:
        """The derivative of a function of states along directions (N, states), and its error."""
        with np.errstate(all="ignore"):
            room = np.where(along != 0.0, self.sizes / np.abs(along), np.inf).min(axis=1)
        first = np.where(np.isfinite(room), FIRST_SHARE * room, 1.0)

        def at_steps(h: Array) -> Array:
            places = states + h[..., None] * along
            return function(places.reshape(-1, places.shape[-1])).reshape(h.shape)

        return differences(at_steps, first, LEVELS)

    def gradient(self, function: StateFunction, states: Array, first: int) -> tuple[Array, Array]:
        """Derivatives (N, n) by the coordinates, `first` 0, or the velocities, and their errors."""
        slopes = []
        for i in range(self.n):
            along = np.zeros_like(states)
            along[:, (n := self.n) * first + i] = 1.0
            slopes.append(self.slope(lambda z: self.at(function, z), states, along))
        values, errors = (np.array(part).reshape(n, len(states)).T for part in zip(*slopes, strict=True))
        return values, errors

    def rates(self, states: Array, accelerations: Any = 0.0) -> Array:
        """The rates (N, states) of the states with these accelerations."""
        rates, n = np.zeros_like(states), self.n
        rates[:, :n], rates[:, n : 2 * n] = states[:, n : 2 * n], accelerations
        for i, rate in enumerate(self.statement.others):
            rates[:, 2 * n + i] = self.at(rate, states)
        return rates

    def momentum(self, states: Array, i: int) -> Array:
        """dT/dv_i (N,): T is a polynomial of degree 2 in the velocities, so that no step is too long."""
        h = np.zeros(states.shape[1])
        h[self.n + i] = step = self._velocity_step(states, i)
        there, back = (self.at(self.statement.kinetic, states + side * h) for side in (1, -1))
        return (there - back) / (2.0 * step)

    def _velocity_step(self, states: Array, i: int) -> float:
        """A step of a velocity that rounding spoils least: a motion may be small beside its velocity."""
        return float(np.abs(states[:, self.n + i]).max(initial=self.sizes[self.n + i]))

    def momenta(self, states: Array) -> Array:
        """dT/dv (N, n)."""
        return np.array([self.momentum(states, i) for i in range(self.n)]).T

    def imbalance(self, states: Array, accelerations: Any = 0.0) -> tuple[Array, Array, Array]:
        """d/dt (dT/dv) - dT/dq + dV/dq + dD/dv less the loads (N, n), its error, and the sum of its terms'
        magnitudes; contacts have no part in it."""
        rates, about = self.rates(states, accelerations), self.statement
        turning = [self.slope(lambda z, i=i: self.momentum(z, i), states, rates) for i in range(self.n)]
        parts = [tuple(np.array(part).reshape(self.n, -1).T for part in zip(*turning, strict=True))]
        for function, first in ((about.kinetic, 0), (about.stored, 0), (about.dissipation, 1)):
            parts.append(self.gradient(function, states, first))
        loads = np.array([self.at(load, states) for load in about.loads]).reshape(self.n, -1).T
        values = [parts[0][0], -parts[1][0], parts[2][0], parts[3][0], -loads]
        return sum(values), sum(error for _, error in parts), np.abs(values).sum(axis=0)

    def masses(self, states: Array) -> Array:
        """M (N, n, n)."""
        columns = []
        for j in range(self.n):
            h = np.zeros(states.shape[1])
            h[self.n + j] = step = self._velocity_step(states, j)
            columns.append((self.momenta(states + h) - self.momenta(states - h)) / (2.0 * step))
        return np.stack(columns, axis=-1)

    def rubbing_direction(self, contact: StatedContact, states: Array) -> Array:
        """-dv_r/dv (N, n), along which friction acts; in the plane that of the first component."""
        assert contact.speed is not None
        return -self._velocity_coefficients(contact.speed, states)

    def direction_across(self, contact: StatedContact, states: Array) -> Array:
        """The same (N, n) of the second component of a contact in the plane."""
        assert contact.across is not None
        return -self._velocity_coefficients(contact.across, states)

    def _velocity_coefficients(self, speed: StateFunction, states: Array) -> Array:
        """Derivatives (N, n) of a relative velocity by the velocities; it is linear, so no step is too long.

        A belt may be far faster than all that moves: the second step changes v_r by as much as v_r itself.
        """
        size, coefficients = np.abs(self.at(speed, states)).max(initial=0.0), np.zeros((len(states), self.n))
        for i in range(self.n):
            h, step = np.zeros(states.shape[1]), self._velocity_step(states, i)
            for _ in range(2):
                h[self.n + i] = step
                coefficients[:, i] = (self.at(speed, states + h) - self.at(speed, states - h)) / (2.0 * step)
                step = max(step, size / (np.abs(coefficients[:, i]).max(initial=0.0) or np.inf))
        return coefficients

    def normal_direction(self, contact: StatedContact, states: Array) -> Array:
        """W_N (N, n), along which the normal force or the reaction acts."""
        if contact.normal is not None:
            return np.array([self.at(entry, states) for entry in contact.normal]).reshape(self.n, -1).T
        if contact.gap is None:
            return np.zeros((len(states), self.n))
        return self.gradient(contact.gap, states, 0)[0]

    def rate_of(self, function: Any, states: Array) -> Array:
        """The rate (N,) of a function."""
        return self.slope(lambda z: self.at(function, z), states, self.rates(states))[0]


def differences(function: Callable[[Array], Array], first: Array, levels: int) -> tuple[Array, Array]:
    """The derivative at 0 of a function of steps (N,), and its error; infinite where there is none.

    The function is called twice, with all steps (..., N) of a side, as a call costs more than its numbers.
    """
    h = first * REFINEMENT ** np.arange(levels)[:, None]
    multiples = np.arange(1, len(CENTRAL_WEIGHTS) + 1)
    ahead, back = (function(np.multiply.outer(side * multiples, h)) for side in (1, -1))
    total: Any = sum(w * one for w, one in zip(CENTRAL_WEIGHTS, ahead - back, strict=True))
    size = np.maximum(np.abs(ahead), np.abs(back)).max(axis=0)
    steps = h.reshape(*h.shape, *[1] * (total.ndim - h.ndim))
    values = total / steps
    errors = np.abs(np.diff(values, axis=0)) + (ROUNDING * size / steps)[1:]
    errors = np.where(np.isfinite(errors), errors, np.inf)
    best = errors.argmin(axis=0)[None]
    value = np.take_along_axis(values, best + 1, 0)[0]
    return np.where(np.isfinite(value), value, 0.0), np.take_along_axis(errors, best, 0)[0]
