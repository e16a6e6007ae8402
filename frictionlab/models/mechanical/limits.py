"""What energies, loads and contacts say of parameters without bounds: masses are above 0, dampers and given
normal forces at least 0, as is the frequency of loads, which have the period of the phase.

Masses, loads and contacts are checked with numbers by `masses.py`, `period_of_phase.py` and
`contact_numbers.py`, dampers here.  A page, which has no Python, checks loads, and the masses and dampers of
single coordinates, by the formulas of :func:`limits_of`.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionlab.components.component import StructureKey
from frictionlab.lazy_names import sympy
from frictionlab.models.kept_structures import derivations_of
from frictionlab.models.symbols import gradient, parameter_symbols, structure_values, symbol
from frictionlab.presentation import BACKWARDS
from frictionlab.tape.formulas import Formulas, formulas_of, kept_formulas

from .contact_numbers import NORMAL_FORCE, given_normal_forces
from .masses import KINETIC, known_signs
from .period_of_phase import period_limits

if TYPE_CHECKING:
    from frictionlab.models.mechanical.mechanical_model import MechanicalModel

DISSIPATION = (
    "dissipation of {of} must not be negative for any motion, and {got}: write a force that drives as a "
    "load; fl.parameter(..., minimum=0.0) refuses a negative damper at once"
)
DAMPER = "the damper of {name!r} is {value}"
ROUNDING = 1e-9  # share of the dampers of its coordinates; files hold matrices with some ten digits


class Limit(NamedTuple):
    """A formula of parameters that must be above 0, or at least 0.

    Parameters
    ----------
    value : Expr
    above : bool
        Whether 0 itself is refused.
    words : str
        The message, with "{value}" where the value stands, and with the names of parameters in braces.
    """

    value: Any
    above: bool
    words: str


def check_dampers(model: MechanicalModel) -> None:
    """Raise ValueError where a motion has negative dissipation, at the values of the model's parameters.

    The second derivatives of D by the velocities must have no negative eigenvalue.
    """
    about, formulas = _dampers(model.structure_key)
    if not about["places"]:
        return
    names = model.coordinates
    matrix = np.zeros((len(names), len(names)))
    for (i, j), value in zip(about["places"], formulas.numbers(*structure_values(model)), strict=True):
        matrix[i, j] = matrix[j, i] = value
    for block in about["blocks"]:
        motion = [names[block[i]] for i in _driven_motion(matrix[np.ix_(block, block)])]
        if motion:
            got = f"that of {' and '.join(map(repr, motion))} together is"
            if len(motion) == 1:
                i = names.index(motion[0])
                got = DAMPER.format(name=motion[0], value=f"{matrix[i, i]:g}")
            raise ValueError(DISSIPATION.format(of=type(model).__name__, got=got))


def _driven_motion(dampers: NDArray[np.float64]) -> list[int]:
    """The coordinates of a motion whose dissipation is negative beyond rounding; [] if there is none."""
    diagonal = np.diag(dampers)
    least = -ROUNDING * diagonal.max(initial=0.0)
    if (diagonal < least).any():
        return [int(np.argmin(diagonal))]
    if not np.isfinite(dampers).all():  # of laws and contacts that are refused in words of their own
        return []
    size = np.sqrt(np.maximum(diagonal, -least) if least else np.ones(len(diagonal)))
    shares, motions = np.linalg.eigh(dampers / size[:, None] / size)
    part = np.abs(motions[:, 0])
    return [int(i) for i in np.flatnonzero(part > 1e-6)] if shares[0] < -ROUNDING else []


@cache
def _dampers(key: StructureKey) -> tuple[dict[str, Any], Formulas]:
    """Where dissipation may be negative: blocks of coordinates, and formulas of the dampers in them."""
    derivations = derivations_of(key)
    about = derivations.value("dampers", lambda: _about_dampers(key))

    def derive() -> Formulas:
        second = _second_derivatives(key)
        return formulas_of(parameter_symbols(key), [second[i][j] for i, j in about["places"]])

    return about, kept_formulas(derivations, "dampers", derive)


def _about_dampers(key: StructureKey) -> dict[str, Any]:
    """Coordinates all of whose dampers depend on parameters only, together; each of the others alone.

    No block, and no place, where the dissipation is a sum of squares whose coefficients are bound to be at
    least 0.
    """
    from .equations_of_motion import system_of

    second, parameters, signs = _second_derivatives(key), set(parameter_symbols(key)), known_signs(key)
    known = [[one.free_symbols <= parameters for one in row] for row in second]
    dissipation = sympy.sympify(system_of(key).mechanics.dissipation, strict=True)
    if all(map(all, known)) and dissipation.xreplace(signs).is_nonnegative:
        return {"blocks": [], "places": []}
    count = range(len(second))
    together = [i for i in count if all(known[i]) and any(second[i])]
    coupled = any(second[i][j] != 0 for i in together for j in together if i != j)
    blocks = [together] if coupled else [[i] for i in together]
    blocks += [[i] for i in count if known[i][i] and not all(known[i])]
    blocks = [b for b in blocks if len(b) > 1 or not second[b[0]][b[0]].xreplace(signs).is_nonnegative]
    places = [[i, j] for b in blocks for i in b for j in b if i <= j and second[i][j] != 0]
    return {"blocks": blocks, "places": places}


def _second_derivatives(key: StructureKey) -> list[list[Any]]:
    """Those of the dissipation by the velocities."""
    from .equations_of_motion import system_of

    system = system_of(key)
    return [gradient(slope, system.v) for slope in gradient(system.mechanics.dissipation, system.v)]


def _values(key: StructureKey, formula: Any) -> str:
    """The parameters of a formula, with places for their values."""
    return ", ".join(
        f"{name} = {{{name}}}" for name in key.parameters if symbol(name) in formula.free_symbols
    )


def limits_of(model: MechanicalModel) -> Iterator[Limit]:
    """What masses, loads, dampers and given normal forces ask of parameters whose bounds do not ensure it."""
    from .equations_of_motion import system_of

    key, of = model.structure_key, type(model).__name__
    system, signs, parameters = system_of(key), known_signs(key), parameter_symbols(key)
    within = set(parameters)
    for i, q in enumerate(system.q):
        mass = system.mass[i, i]
        if mass.free_symbols <= within and not mass.xreplace(signs).is_positive:
            got = f"the mass of {q.name!r} is {{value}}"
            yield Limit(mass, True, KINETIC.format(of=of, got=got, at=f" at {_values(key, mass)}"))
    for margin, words in period_limits(model):
        yield Limit(margin, False, words)
    for rate in [sympy.sympify(system.mechanics.frequency, strict=True)] if system.phase else []:
        if not rate.xreplace(signs).is_nonnegative:
            at = " at " + _values(key, rate)
            yield Limit(rate, False, BACKWARDS.format(rate="{value}", at=at))
    second = _second_derivatives(key)
    for i, name in enumerate(model.coordinates):
        if second[i][i].free_symbols <= within and not second[i][i].xreplace(signs).is_nonnegative:
            got = DAMPER.format(name=name, value="{value}")
            yield Limit(second[i][i], False, DISSIPATION.format(of=of, got=got))
    for number, press in given_normal_forces(key):
        if not press.xreplace(signs).is_nonnegative:
            yield Limit(press, False, NORMAL_FORCE.format(number=number, of=of, value="{value}"))
