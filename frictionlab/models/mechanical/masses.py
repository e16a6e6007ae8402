"""Whether the kinetic energy is positive for every motion, at the values of a model's parameters.

Most models need no look: their masses are parameters that cannot be zero or negative.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache, partial
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from frictionlab.components.component import StructureKey
from frictionlab.lazy_names import sympy
from frictionlab.models.composition import parameter_metadata
from frictionlab.models.kept_structures import derivations_of
from frictionlab.models.symbolic_laws import symbolic_copy
from frictionlab.models.symbols import symbol
from frictionlab.presentation import PHASE
from frictionlab.tape.formulas import Formulas, formulas_of, kept_formulas

from .massless_motions import SEED, motion_without_energy

if TYPE_CHECKING:
    from frictionlab.models.mechanical.mechanical_model import MechanicalModel

Array = NDArray[np.float64]
# Phases, and sizes of coordinates, at which masses are checked that change with time, or depend on place.
PHASES: list[float] = np.linspace(0.0, 2 * np.pi, 16, endpoint=False).tolist()
SIZES: list[float] = np.geomspace(1e-3, 1.0, 8).tolist()
SURE_SHARE = 1e-9  # least energy of a motion, as a share of that of its parts, that is no rounding error

KINETIC = (
    "kinetic of {of} must be positive for every motion, and {got}{at}: give it a mass above 0; "
    "fl.parameter(..., exclusive_minimum=0.0) refuses others at once"
)


def check_masses(model: MechanicalModel, start: Any = None) -> None:
    """Raise ValueError unless T is positive for every motion, at the values of the model's parameters.

    Masses that change with time are computed at 16 phases of a period.  Those that depend on place may be
    positive in some places only: with `start`, a state, they must be positive there, without it somewhere.
    """
    about, _ = _masses(model.structure_key)
    if about["places"] and (start is None or about["in place"]):
        _check_masses(model, model.parameters, start)


def check_masses_within(model: MechanicalModel, within: Mapping[str, Sequence[float] | Array]) -> None:
    """Raise ValueError unless T is positive for every motion at all combinations of values of parameters."""
    about, _ = _masses(model.structure_key)
    names = [name for name in within if name in about["parameters"]]
    if about["places"] and names:
        *others, last = names
        at = np.asarray(within[last], dtype=float)
        for values in product(*(map(float, within[name]) for name in others)):
            parameters = {**model.parameters, **dict(zip(others, values))}
            for value in at[~_are_surely_positive(model, {**parameters, last: at}, len(at))]:
                _check_masses(model, {**parameters, last: float(value)}, None)


def _are_surely_positive(
    model: MechanicalModel, parameters: Mapping[str, Any], count: int
) -> NDArray[np.bool_]:
    """Where (count,) no closer look is needed, as masses are constant and far from singular.

    All are computed at once: of a map of 100 by 100 values that is some fifty times as fast as one by one.
    """
    about, formulas = _masses(model.structure_key)
    if about["in place"] or about["in time"]:
        return np.zeros(count, dtype=bool)
    n = len(model.coordinates)
    with np.errstate(all="ignore"):
        mass = _mass_matrix(about, formulas.arrays, parameters, np.zeros(n), 0.0, (count,))
    diagonal = np.diagonal(mass, axis1=1, axis2=2)
    sure: Any = np.isfinite(mass).all(axis=(1, 2)) & (diagonal > 0.0).all(axis=1)
    size = np.sqrt(diagonal[sure])
    shares = np.linalg.eigvalsh(mass[sure] / size[:, :, None] / size[:, None])
    sure[sure] = shares[:, 0] > SURE_SHARE
    return sure


def _check_masses(model: MechanicalModel, parameters: Mapping[str, float], start: Any) -> None:
    about, formulas = _masses(model.structure_key)
    n, masses = len(model.coordinates), partial(_mass_matrix, about, formulas.numbers, parameters)
    places = _places(n) if about["in place"] else [np.zeros(n)]
    if start is not None:
        places = [np.asarray(start, dtype=float)[:n]]
    for phase in PHASES if about["in time"] else [0.0]:
        motions = [_without_positive_energy(masses(place, phase)) for place in places]
        if all(motions):
            at = {} if start is None else dict(zip(model.coordinates, places[0], strict=True))
            at |= {PHASE: phase} if about["in time"] else {}
            at = {name: parameters[name] for name in about["parameters"]} | at
            raise ValueError(_words(model, motions[0], masses(places[0], phase), at))


def _places(n: int) -> list[Array]:
    rng = np.random.default_rng(SEED)
    return [size * rng.normal(size=n) for size in SIZES]


def _without_positive_energy(mass: Array) -> list[int]:
    """The coordinates of a motion whose energy is not positive; [] if there is none."""
    diagonal = np.diag(mass)
    if not (np.isfinite(mass).all() and (diagonal > 0).all()):
        return [int(np.argmin(np.where(np.isfinite(diagonal), diagonal, -np.inf)))]
    return motion_without_energy(mass)


def _words(model: MechanicalModel, motion: Sequence[int], mass: Array, values: Mapping[str, float]) -> str:
    names, value = [model.coordinates[i] for i in motion], mass[motion[0], motion[0]]
    got = f"that of {' and '.join(map(repr, names))} together is not"
    if len(names) == 1:
        got = f"the mass of {names[0]!r} is {value:g}"
    at = ", ".join(f"{name} = {one:g}" for name, one in values.items())
    return KINETIC.format(of=type(model).__name__, got=got, at=f" at {at}" if at else "")


def _mass_matrix(
    about: Mapping[str, Any],
    evaluate: Callable[..., Any],
    values: Mapping[str, Any],
    place: Array,
    phase: float,
    shape: tuple[int, ...] = (),
) -> Array:
    """M (*shape, n, n) at a place and a phase, of values of this shape; NaN where it has no real value."""
    mass = np.zeros((*shape, len(place), len(place)))
    at_start = [0.0] if about["timed"] else []
    numbers = [values[name] for name in about["parameters"]]
    entries = evaluate(*map(float, place), float(phase), *at_start, *numbers)
    for (i, j), entry in zip(about["places"], entries, strict=True):
        mass[..., i, j] = mass[..., j, i] = entry
    return mass


@cache
def _masses(key: StructureKey) -> tuple[dict[str, Any], Formulas]:
    """The entries of M as formulas of coordinates, phase and parameters; none where T is surely positive."""
    derivations = derivations_of(key)
    about = derivations.value("masses", lambda: _about_masses(key))
    return about, kept_formulas(derivations, "masses", lambda: _mass_formulas(key, about))


def _about_masses(key: StructureKey) -> dict[str, Any]:
    from .equations_of_motion import system_of

    system = system_of(key)
    mass = system.mass
    there = mass.free_symbols
    entries = [] if _surely_positive(system, key) else sorted(mass.todok())
    return {
        "places": [[i, j] for i, j in entries if i <= j],
        "parameters": [name for name in key.parameters if symbol(name) in there],
        "in place": not there.isdisjoint(system.q),
        "in time": symbol(PHASE) in there,
        "timed": bool(system.time),
    }


def _mass_formulas(key: StructureKey, about: Mapping[str, Any]) -> Formulas:
    from .equations_of_motion import system_of

    system = system_of(key)
    inputs = [*system.q, symbol(PHASE), *system.time, *map(symbol, about["parameters"])]
    return formulas_of(inputs, [system.mass[i, j] for i, j in about["places"]])


def _surely_positive(masses: Any, key: StructureKey) -> bool:
    """Whether masses that are not coupled, or coupled by numbers only, are positive whatever their values."""
    signs = known_signs(key)
    if masses.masses:
        return all(one.xreplace(signs).is_positive for one in masses.masses)
    return masses.coupled is not None and bool(masses.coupled.scale.xreplace(signs).is_positive)


def known_signs(key: StructureKey) -> dict[Any, Any]:
    """For the symbol of each parameter with a lower bound of at least 0 one of which sympy knows that."""
    copy, signs = symbolic_copy(key), {}
    known = parameter_metadata(type(copy), copy.components)
    for name, about in known.items():
        above = -1.0 if about.exclusive_minimum is None else about.exclusive_minimum
        if above >= 0 or (about.minimum or 0) > 0:
            signs[symbol(name)] = sympy.Dummy(name, positive=True)
        elif about.minimum == 0:
            signs[symbol(name)] = sympy.Dummy(name, nonnegative=True)
    return signs
