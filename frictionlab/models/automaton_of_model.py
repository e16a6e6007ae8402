"""The automaton of a model: derived once for its structure, then with the values of the model's parameters.

The structure of a model is the classes of its components and those of their fields that are no parameters.
It is derived on a copy of the model whose parameters are symbols.  For models of the library the cache on
disk has what runs ask for, so that their automata need no sympy (`CachedAutomaton`).
"""

from __future__ import annotations

import logging
import time
from collections.abc import Mapping
from dataclasses import replace
from functools import cache, cached_property, lru_cache
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from frictionlab.automaton import HybridAutomaton, Mode
from frictionlab.automaton.mode import Symbol
from frictionlab.automaton.modes_on_demand import ModesOnDemand, names_of_regimes
from frictionlab.components.component import StructureKey, structure_of
from frictionlab.components.surroundings import surroundings_of
from frictionlab.tape.automaton_data import DERIVED_FROM, automaton_from_data
from frictionlab.validation import abbreviate, with_article

from .kept_structures import Derivations, derivations_of
from .serialisation import loaded_class, value_from_data
from .symbolic_laws import check_laws, symbolic_copy
from .symbols import symbol

if TYPE_CHECKING:
    from frictionlab.models.model import Model

LOGGER = logging.getLogger(__name__)
# Up to so many modes of a model with several contacts are all derived and cached; where there are more, each
# is derived when a run first tries to enter it.
MOST_CACHED_MODES = 27
# Errors that deriving may raise where a structure, read from a file, is that of no model.
NO_STRUCTURE = ValueError, TypeError, AttributeError, LookupError, ArithmeticError, RecursionError


class CachedAutomaton(HybridAutomaton):
    """The automaton of a structure that is in the cache on disk.

    Its names and numbers need no sympy.  States, modes and parameters as symbols are derived when they are
    first asked for.
    """

    def __init__(
        self,
        key: StructureKey,
        outline: Mapping[str, Any],
        values: Mapping[str, float],
        derivations: Derivations,
    ) -> None:
        self._key, self._outline = key, outline
        vars(self).update(outline, values=MappingProxyType(dict(values)), derivations=derivations)

    def __reduce__(self) -> Any:
        # A copy is plain data, as where it is read the cache may be empty: `replace` gives it back as it is.
        return replace, (self.derived(),)

    @cached_property
    def _derived(self) -> HybridAutomaton:
        return replace(automaton_of_structure(self._key), parameters=_numbers(self.values))

    def derived(self) -> HybridAutomaton:
        """The automaton as plain data, with all symbols and modes derived."""
        return self._derived

    @property
    def whole(self) -> HybridAutomaton:
        """The automaton itself: structures with laws in pieces are not cached."""
        return self

    @property
    def states(self) -> tuple[Symbol, ...]:
        """Coordinates first, then their velocities, then other states."""
        return self._derived.states

    @property
    def modes(self) -> tuple[Mode, ...] | ModesOnDemand:
        """The modes, in the order in which they are tried."""
        return self._derived.modes

    @property
    def parameters(self) -> Mapping[Symbol, float]:
        """Symbol -> value of every parameter."""
        return self._derived.parameters

    def _with_values(self, changes: Mapping[str, float]) -> HybridAutomaton:
        return CachedAutomaton(self._key, self._outline, {**self.values, **changes}, self.derivations)


@lru_cache(maxsize=256)
def automaton_of_structure(key: StructureKey) -> HybridAutomaton:
    """The automaton of a structure, without values of the model's parameters."""
    begin = time.perf_counter()
    model = symbolic_copy(key)
    automaton = model.derive()
    _check_states(model, automaton)
    seconds = time.perf_counter() - begin
    LOGGER.info("derived the automaton of %s in %.2g s", type(model).__name__, seconds)
    return automaton


def _check_states(model: Model, automaton: HybridAutomaton) -> None:
    """Raise ValueError unless an automaton has the model's coordinates first, then their velocities."""
    names = tuple(model.coordinates)
    needed = (*names, *(f"{name}'" for name in names))
    if automaton.coordinates != len(names) or automaton.state_names[: len(needed)] != needed:
        raise ValueError(
            f"the automaton of {type(model).__name__} must begin with the states {', '.join(needed)}, its "
            f"coordinates and their velocities, got {', '.join(automaton.state_names)} with coordinates="
            f'{automaton.coordinates}: name velocities by a prime, as sympy.Symbol("x\'")'
        )


def automaton_of_model(model: Model) -> HybridAutomaton:
    """The automaton of a model; models of one structure share their `modes` object.

    Raises
    ------
    ValueError
        Where a law has no real value at the values of the parameters.
    """
    key, numbers = model.structure_key, model.parameters
    values = {name: numbers[name] for name in key.parameters}
    check_laws(key, values)
    derivations = derivations_of(key)
    outline = _outline(key, derivations)
    if outline is None:
        automaton = automaton_of_structure(key)
        return replace(automaton, parameters=_numbers(values) | dict(automaton.parameters))
    outline, added = outline
    return CachedAutomaton(key, outline, {**values, **added}, derivations)


def rotational_outputs_of(key: StructureKey) -> tuple[str, ...]:
    """Outputs of contacts whose bodies turn, without values of the parameters."""
    outline = _outline(key, derivations_of(key))
    return (
        automaton_of_structure(key).rotational_outputs
        if outline is None
        else outline[0]["rotational_outputs"]
    )


def _numbers(values: Mapping[str, float]) -> dict[Symbol, float]:
    return {symbol(name): value for name, value in values.items()}


@cache
def _outline(
    key: StructureKey, derivations: Derivations
) -> tuple[Mapping[str, Any], Mapping[str, float]] | None:
    """What is known of a cached automaton without deriving it, by the names of its attributes; and the
    parameters that the derivation adds to the model's.  None where it is not cached."""
    about = derivations.get("automaton")
    if about is None:
        automaton = automaton_of_structure(key)
        if not derivations.keeps or _has_many_modes(automaton) or automaton.whole is not automaton:
            return None
        about = _outline_data(automaton)
        derivations.keep("automaton", about)
    names, regimes = tuple(about["modes"]), about["regimes"]
    outline = {
        "state_names": tuple(about["states"]),
        "names": names if regimes is None else names_of_regimes(regimes, names),
        "outputs": tuple(about["outputs"]),
        "rotational_outputs": tuple(about["rotational"]),
        "coordinates": about["coordinates"],
        "cyclic": tuple(about["cyclic"]),
        "period": about["period"],
        "on_demand": regimes is not None,
    }
    return outline, about["parameters"]


def _has_many_modes(automaton: HybridAutomaton) -> bool:
    modes = automaton.modes
    return isinstance(modes, ModesOnDemand) and modes.names.more_than(MOST_CACHED_MODES)


def _outline_data(whole: HybridAutomaton) -> dict[str, Any]:
    modes: Any = whole.modes
    return {
        "states": whole.state_names,
        "modes": tuple(whole.names),
        "regimes": [[regime.name for regime in part] for part in modes.parts] if whole.on_demand else None,
        "outputs": whole.outputs,
        "rotational": whole.rotational_outputs,
        "parameters": dict(whole.values),
        "coordinates": whole.coordinates,
        "cyclic": whole.cyclic,
        "period": whole.period,
    }


def automaton_from_stored(data: Mapping[str, Any], parameters: Any, kind: type) -> HybridAutomaton:
    """The automaton that `storable_automaton` described: plain data, or the structure it is derived from.

    Parameters
    ----------
    data : mapping
    parameters : mapping of str to float
        Values for an automaton that is derived from a structure.
    kind : type
        The base class that the model of such a structure must have.

    Raises
    ------
    ValueError
        If the data is malformed.
    """
    if DERIVED_FROM not in data:
        return automaton_from_data(data)
    if not isinstance(parameters, Mapping) or not all(type(value) is float for value in parameters.values()):
        raise ValueError(f"its parameters are {abbreviate(parameters)}")
    automaton = automaton_from_structure_data(data[DERIVED_FROM], kind, parameters)
    if data.get("coordinates") != automaton.coordinates:
        raise ValueError(f"it has {data.get('coordinates')} coordinates instead of {automaton.coordinates}")
    return automaton


def automaton_from_structure_data(data: Any, kind: type, parameters: Mapping[str, float]) -> HybridAutomaton:
    """The automaton of a structure, with these values of its parameters.

    Parameters
    ----------
    data : mapping
        The structure, from `structure_to_data`.
    kind : type
        The base class that the model must have.
    parameters : mapping of str to float

    Raises
    ------
    ValueError
        If the data is malformed, a class in it is not loaded, or a parameter is missing.
    """
    try:
        key = _structure_from_data(data, kind)
        automaton = automaton_of_structure(key)
    except NO_STRUCTURE as error:
        raise ValueError(f"the model of its automaton cannot be made, {error}") from error
    needed = dict.fromkeys((*key.parameters, *automaton.values))
    if missing := [name for name in needed if name not in parameters]:
        raise ValueError(f"it lacks the parameters {', '.join(missing)}")
    return replace(automaton, parameters=_numbers(parameters))


def _structure_from_data(data: Any, base: type) -> StructureKey:
    if not isinstance(data, Mapping) or not isinstance(data.get("structure"), Mapping):
        raise ValueError(
            f"{with_article(base)} must be a mapping with 'class' and 'structure', got {abbreviate(data)}"
        )
    cls, values = loaded_class(data.get("class"), base), data["structure"]
    names, roles = structure_of(cls), getattr(cls, "roles", {})
    if sorted(values) != sorted(names):
        raise ValueError(f"{cls.__name__} has {', '.join(names)}, got {', '.join(values)}")
    return StructureKey(
        cls,
        tuple(
            _structure_from_data(values[name], roles[name])
            if name in roles
            else value_from_data(values[name])
            for name in names
        ),
        surroundings_of(cls),
    )
