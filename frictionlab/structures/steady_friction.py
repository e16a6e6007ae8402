"""Friction laws with states of their own in steady sliding, and how they respond next to it.

The states of a law such as LuGre's are where their rates are zero, and lag behind motions.  Those of an
elastic-plastic law such as Jenkins' are at their limits, and follow these: it slides as a law without states.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionlab.components.component import StructureKey
from frictionlab.components.friction import FrictionLaw
from frictionlab.lazy_names import sympy
from frictionlab.models.symbolic_laws import symbolic_copy
from frictionlab.models.symbols import symbol
from frictionlab.tape.formulas import Formulas, formulas_of

Array = NDArray[Any]
NEWTON_STEPS = 100
HALVINGS = 200  # of a step of Newton's method: rates may be exponentials of the states
ROUNDING = float(np.finfo(float).eps)
SETTLED_RTOL = 1e-9  # of a state: a last step that is shorter has only rounding left to do


class SteadyFriction(NamedTuple):
    """Friction of k contacts in steady sliding, and its derivatives; of s states that lag.

    Parameters
    ----------
    force : array (..., k)
        N; with its derivatives by the normal force and by v_r, which the states do not follow.
    by_force, by_speed : array (..., k)
    by_states : array (s, ..., k)
    rates_by_force, rates_by_speed : array (s, ..., k)
        Derivatives of the rates of the states.
    rates_by_states : array (s, s, ..., k)
    states : array (all states, ..., k)
    """

    force: Array
    by_force: Array
    by_speed: Array
    by_states: Array
    rates_by_force: Array
    rates_by_speed: Array
    rates_by_states: Array
    states: Array


def lagging_states(law: FrictionLaw | None) -> tuple[str, ...]:
    """Names of a law's states that lag behind motions about steady sliding; () of an elastic-plastic law."""
    if law is None or not law.states:
        return ()
    from frictionlab.models.mechanical.dynamic_laws import limits_of_law

    return () if limits_of_law(law, 1.0) else law.states


def steady_friction(
    law: FrictionLaw, normal_force: Array, velocity: Any, parameters: Sequence[Any]
) -> SteadyFriction:
    """The friction of contacts with these normal forces, of one shape (..., k); all may be complex.

    Parameters
    ----------
    law : FrictionLaw
        With states.
    normal_force : array (..., k)
        N, above 0.
    velocity : number or array
        v_r, not 0, broadcast to the shape of the normal forces, as are the parameters.
    parameters : sequence
        Values of the law's parameters.

    Returns
    -------
    SteadyFriction
        NaN where the states do not settle.
    """
    arguments = normal_force, velocity, *parameters
    given = [np.broadcast_to(one, normal_force.shape).ravel() for one in arguments]
    forwards, parts = np.real(given[1]) > 0.0, []
    for sign, chosen in ((1, forwards), (-1, ~forwards)):
        if chosen.any() or (sign == 1 and not chosen.size):  # none at all: parts of no contacts
            parts.append((chosen, _on_one_side(law, sign, [one[chosen] for one in given])))
    whole = []
    for each in zip(*(found for _, found in parts), strict=True):
        joined = np.zeros((*each[0].shape[:-1], forwards.size), dtype=each[0].dtype)
        for (chosen, _), part in zip(parts, each, strict=True):
            joined[..., chosen] = part
        whole.append(joined.reshape(*joined.shape[:-1], *normal_force.shape))
    return SteadyFriction(*whole)


def _on_one_side(law: FrictionLaw, sign: int, given: Sequence[Any]) -> SteadyFriction:
    """The friction of contacts where v_r has this sign, at normal forces, v_r and parameters, each (k,)."""
    lagging = len(lagging_states(law))
    states = _settled(law, sign, given) if lagging else np.zeros((0, len(given[0])))
    values, slopes = _evaluated(_formulas(law.structure_key, sign), states, given)
    return SteadyFriction(
        values[0],
        slopes[0, 0],
        slopes[0, 1],
        slopes[0, 2:],
        slopes[1 : 1 + lagging, 0],
        slopes[1 : 1 + lagging, 1],
        slopes[1 : 1 + lagging, 2:],
        states if lagging else values[1:],
    )


@lru_cache(maxsize=64)
def _formulas(key: StructureKey, sign: int) -> Formulas:
    """The force, and the rates of states that lag or the states at their limits, where v_r has this sign.

    Inputs are the normal force, v_r, the states that lag, and the parameters.
    """
    from frictionlab.models.mechanical.dynamic_laws import limits_of_law, values_on_one_side

    law: Any = symbolic_copy(key)
    force, velocity = sympy.Dummy("normal_force", positive=True), sympy.Dummy("relative_velocity", real=True)
    inputs = [force, velocity]
    if limits := limits_of_law(law, force):
        states = [sign * one for one in limits]
        values = [values_on_one_side(law, force, velocity, states, sign).force, *states]
    else:
        states = [sympy.Dummy(name, real=True) for name in law.states]
        inputs += states
        known = values_on_one_side(law, force, velocity, states, sign)
        values = [known.force, *known.rates]
    return formulas_of([*inputs, *map(symbol, key.parameters)], values)


def _evaluated(formulas: Formulas, states: Array, given: Sequence[Any]) -> tuple[Array, Array]:
    """Values (1 + s, k), and their derivatives (1 + s, 2 + s, k) by the normal force, v_r and the states."""
    force, velocity, *parameters = given
    inputs = [force, velocity, *states, *parameters]
    kind = np.result_type(float, *inputs)
    count, shape = 2 + len(states), np.shape(force)
    places, derivatives = formulas.jacobian(range(count))
    with np.errstate(all="ignore"):
        values = np.array([np.broadcast_to(one, shape) for one in formulas.arrays(*inputs)], dtype=kind)
        slopes = np.zeros((len(values), count, *shape), dtype=kind)
        for place, slope in zip(places, derivatives.arrays(*inputs), strict=True):
            slopes[place] = slope
    return values, slopes


def _settled(law: FrictionLaw, sign: int, given: Sequence[Any]) -> Array:
    """States (s, k) whose rates are zero, NaN where none are found.

    Newton's method from zeros, in steps that lower the rates.
    """
    formulas = _formulas(law.structure_key, sign)
    real = [np.real(one) for one in given]
    states = np.zeros((len(law.states), len(real[0])))
    rates, step = _newton_step(formulas, states, real)
    for _ in range(NEWTON_STEPS):
        size, scale = np.abs(rates).max(axis=0), np.ones(len(real[0]))
        for _ in range(HALVINGS):
            ahead = states - scale * step
            values, _ = _evaluated(formulas, ahead, real)
            better = np.abs(values[1:]).max(axis=0) < size
            moving = (np.abs(ahead - states) > ROUNDING * np.abs(states)).any(axis=0)
            if not (moving & ~better).any():
                break
            scale = np.where(better, scale, 0.5 * scale)
        states = np.where(better, ahead, states)
        if not better.any():
            break
        rates, step = _newton_step(formulas, states, real)
    settled = (np.abs(step) <= SETTLED_RTOL * np.abs(states)).all(axis=0)
    states = np.where(settled, states, np.nan)
    if not any(map(np.iscomplexobj, given)):
        return states
    return states - _newton_step(formulas, states, given)[1]  # with derivatives as imaginary parts


def _newton_step(formulas: Formulas, states: Array, given: Sequence[Any]) -> tuple[Array, Array]:
    """The rates (s, k), and the step of Newton's method, NaN where there is none."""
    values, slopes = _evaluated(formulas, states, given)
    matrices = np.moveaxis(slopes[1:, 2:], -1, 0)
    with np.errstate(all="ignore"):
        regular = np.isfinite(matrices).all(axis=(1, 2)) & (np.linalg.det(matrices) != 0.0)
        matrices = np.where(regular[:, None, None], matrices, np.nan)
        steps = np.linalg.solve(matrices, values[1:].T[..., None])[..., 0].T
    return values[1:], steps
