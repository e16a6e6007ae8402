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
from frictionlab.stability.equilibrium_points.newton import (
    find_zeros,
    follow_zero,
    settled_first,
    solve_matrices,
)
from frictionlab.stability.flow import Flow
from frictionlab.tape.formulas import Formulas, formulas_of

Array = NDArray[Any]


class UnsettledStatesError(ValueError):
    """States of a friction law never settle in steady sliding."""


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
        slopes[0, lagging],
        slopes[0, lagging + 1],
        slopes[0, :lagging],
        slopes[1 : 1 + lagging, lagging],
        slopes[1 : 1 + lagging, lagging + 1],
        slopes[1 : 1 + lagging, :lagging],
        states if lagging else values[1:],
    )


@lru_cache(maxsize=64)
def _formulas(key: StructureKey, sign: int) -> Formulas:
    """The force, and the rates of states that lag or the states at their limits, where v_r has this sign.

    Inputs are the states that lag, the normal force, v_r, and the parameters.
    """
    from frictionlab.models.mechanical.dynamic_laws import limits_of_law, values_on_one_side

    law: Any = symbolic_copy(key)
    force, velocity = sympy.Dummy("normal_force", positive=True), sympy.Dummy("relative_velocity", real=True)
    states: list[Any]
    if limits := limits_of_law(law, force):
        lagging, states = [], [sign * one for one in limits]
        values = [values_on_one_side(law, force, velocity, states, sign).force, *states]
    else:
        lagging = states = [sympy.Dummy(name, real=True) for name in law.states]
        known = values_on_one_side(law, force, velocity, states, sign)
        values = [known.force, *known.rates]
    return formulas_of([*lagging, force, velocity, *map(symbol, key.parameters)], values)


@lru_cache(maxsize=64)
def _flow(key: StructureKey, sign: int) -> Flow:
    """The rates of states that lag where v_r has this sign; parameters are the other inputs."""
    whole = _formulas(key, sign)
    rates = Formulas(whole.tape, whole.outputs[1:])
    return Flow(("normal_force", "relative_velocity", *key.parameters), rates, Formulas(whole.tape, ()))


def _evaluated(formulas: Formulas, states: Array, given: Sequence[Any]) -> tuple[Array, Array]:
    """Values (1 + s, k), and their derivatives (1 + s, s + 2, k) by the states, the normal force and v_r."""
    inputs = [*states, *given]
    kind = np.result_type(float, *inputs)
    count, shape = len(states) + 2, np.shape(given[0])
    places, derivatives = formulas.jacobian(range(count))
    with np.errstate(all="ignore"):
        values = np.array([np.broadcast_to(one, shape) for one in formulas.arrays(*inputs)], dtype=kind)
        slopes = np.zeros((len(values), count, *shape), dtype=kind)
        for place, slope in zip(places, derivatives.arrays(*inputs), strict=True):
            slopes[place] = slope
    return values, slopes


def _settled(law: FrictionLaw, sign: int, given: Sequence[Any]) -> Array:
    """States (s, k) whose rates are zero, NaN where none are found.

    They are searched for one contact, and followed from it to the others; where they are lost on the way they
    are searched for again.
    """
    formulas, flow = _formulas(law.structure_key, sign), _flow(law.structure_key, sign)
    seen = frozenset().union(*flow.rates.dependences)
    # What the rates do not depend on is put to 1, so that contacts that settle alike are one.
    real = [np.real(one) if flow.size + i in seen else np.ones(len(one)) for i, one in enumerate(given)]
    values, places = np.unique(real, axis=1, return_inverse=True)
    states, left = np.full((flow.size, values.shape[1]), np.nan), np.arange(values.shape[1])
    while left.size:
        middle = left.size // 2
        first, left = left[middle], np.delete(left, middle)
        base = (*values[:, first].tolist(),)
        states[:, first] = start = _searched(law.structure_key, sign, base)
        if left.size and np.isfinite(start).all():
            states[:, left] = follow_zero(flow, start, base, _is_finite, [*values[:, left]], left.size)
            left = left[~_is_finite(states[:, left], ())]
    states = states[:, places.ravel()]  # numpy 2.0 gives them as a row
    if not any(map(np.iscomplexobj, given)):
        return states
    known = _is_finite(states, ())  # a step of Newton's method, with derivatives as imaginary parts
    rates, slopes = _evaluated(formulas, states[:, known], [one[known] for one in given])
    matrices = np.moveaxis(slopes[1:, : flow.size], -1, 0)
    states = states.astype(complex)
    states[:, known] -= solve_matrices(matrices, rates[1:].T[..., None])[..., 0].T
    return states


@lru_cache(maxsize=1024)
def _searched(key: StructureKey, sign: int, values: tuple[float, ...]) -> Array:
    """States (s,) whose rates are zero, of several those `settled_first`; NaN where none are found."""
    flow = _flow(key, sign)
    points = settled_first(flow, find_zeros(flow, values).points, values, range(flow.size))
    return points[:, 0] if points.size else np.full(flow.size, np.nan)


def _is_finite(states: Array, _: Sequence[Any]) -> Any:
    return np.isfinite(states).all(axis=0)
