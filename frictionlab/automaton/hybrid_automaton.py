"""Hybrid automata: modes over one state space, and the values of their parameters."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any, ClassVar

from frictionlab.presentation import OUTPUT_UNITS, is_angle, output_of_contact
from frictionlab.validation import (
    abbreviate,
    check_field,
    check_key,
    check_mapping,
    check_names_among,
    check_number,
    check_sequence,
    unknown_parameter,
)

from .mode import Mode, Symbol, check_elements, keep_as_tuples
from .modes_on_demand import ModeNames, ModesOnDemand


def module_of_pieces() -> Any:
    """The module of functions in pieces; None where none has been made in this process."""
    return sys.modules.get("frictionlab.automaton.pieces")


@dataclass(frozen=True, eq=False, repr=False)
class HybridAutomaton:
    """Modes over one state space, and the numbers they need.

    Parameters
    ----------
    states : tuple of Symbol
        Coordinates first, then their velocities, then other states.
    modes : tuple of Mode, or ModesOnDemand
        In the order in which they are tried, at the start too, after those that an event names first.
        What is derived from them is cached per Mode object: build them once, vary `parameters`.
    parameters : mapping of Symbol to float
        Every symbol of the expressions that is not a state.  Where there are limit modes, the solver sets one
        called ``chatter`` to the dwell time (s) below which it replaces a sequence of events by them.
    coordinates : int
        How many of the states are coordinates; as many velocities follow them.
    cyclic : tuple of str
        Coordinates that may turn for ever, by their names: where nothing depends on how far they have turned,
        a steady rotation is an equilibrium.
    period : float or None
        Approximate period of an oscillation, s: explorers and pages show multiples of it.  None lets them
        find it in the motion: from its turns, its way to rest, or the fastest eigenvalue.  Where none of them
        tells a time it is the length of a run that ends by itself, or 1, so state it in a unit other than s.

    Raises
    ------
    TypeError
        For states that are no symbols, or modes that are no `Mode`.

    Examples
    --------
    >>> import frictionlab as fl, sympy as sp
    >>> x, v = sp.symbols("x v")
    >>> swing = fl.HybridAutomaton((x, v), (fl.Mode("on", (v, -x)),), coordinates=1)
    >>> fl.solve(swing, 1.0, x0=[1.0, 0.0]).final_state.round(12).tolist()  # cos 1, -sin 1
    [0.540302305868, -0.841470984808]
    """

    states: tuple[Symbol, ...]
    modes: tuple[Mode, ...] | ModesOnDemand
    parameters: Mapping[Symbol, float] = field(default_factory=dict)
    coordinates: int = 0
    cyclic: tuple[str, ...] = ()
    period: float | None = None
    # What is cached on disk of the structure that it was derived from; None where nothing is.
    derivations: ClassVar[Any] = None
    # The structure that it stands for, as an explorer shows it; None of any other automaton.
    source: ClassVar[Any] = None

    def __post_init__(self) -> None:
        if not isinstance(self.modes, ModesOnDemand):
            check_elements("modes", self.modes, Mode)
        cure = "make them with sympy.symbols, and write the expressions with these"
        states = check_sequence("states", self.states, cure)
        check_mapping("parameters", self.parameters, "give symbols their values, {k: 1.0}", keys=object)
        for what, symbols in {"states": states, "parameters": self.parameters}.items():
            if others := [s for s in symbols if isinstance(s, str) or not getattr(s, "is_Symbol", False)]:
                raise TypeError(f"{what} must be symbols, got {abbreviate(others[0])}: {cure}")
        keep_as_tuples(self, "states")
        if not isinstance(self.modes, ModesOnDemand):
            keep_as_tuples(self, "modes")
            self._split()
        check_field(
            self,
            "coordinates",
            integer=True,
            least=0,
            cure="count the coordinates, which come first in states",
        )
        if self.period is not None:
            check_field(self, "period", above=0.0, cure="leave it out to have it found in the motion")
        check_names_among("cyclic", self.cyclic, self.state_names[: self.coordinates])
        object.__setattr__(self, "cyclic", tuple(self.cyclic))
        object.__setattr__(self, "parameters", MappingProxyType(dict(self.parameters)))

    def __getstate__(self) -> dict[str, Any]:  # a read-only view is not pickled
        state = {each.name: getattr(self, each.name) for each in fields(self)}
        return state | {"parameters": dict(self.parameters)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state, parameters=MappingProxyType(state["parameters"]))

    def _split(self) -> None:
        """Smooth modes in place of those with functions in pieces, if there are any."""
        pieces = module_of_pieces()
        if pieces is not None and (split := pieces.split_modes(self.modes, self.states)) is not self.modes:
            object.__setattr__(self, "modes", split)

    @property
    def whole(self) -> HybridAutomaton:
        """The automaton without borders of laws in pieces: its modes are on all sides of them."""
        if isinstance(self.modes, ModesOnDemand):
            modes: Any = self.modes if self.modes.whole is None else self.modes.whole
        elif any(mode.whole is not None for mode in self.modes):
            modes = tuple(dict.fromkeys(mode.whole or mode for mode in self.modes))
        else:
            modes = self.modes
        if modes is self.modes:
            return self
        return WholeAutomaton(self.states, modes, self.parameters, self.coordinates, self.cyclic, self.period)

    @property
    def shown_states(self) -> tuple[str, ...]:
        """Names of the coordinates, or of all states where there are none."""
        return self.state_names[: self.coordinates or len(self.state_names)]

    @property
    def rates(self) -> Mapping[str, str]:
        """Coordinate -> the name of its velocity."""
        n = self.coordinates
        return dict(zip(self.state_names[:n], self.state_names[n : 2 * n], strict=False))

    @property
    def shown_state(self) -> str:
        """What pictures show where no state is named: if it can, a coordinate that does not turn for ever."""
        names = self.state_names[: self.coordinates]
        return next((name for name in names if name not in self.cyclic), self.state_names[0])

    def drawn_against(self, name: str) -> str:
        """The state against which a phase plane draws one: its rate, or the next if none is a coordinate."""
        names = self.state_names
        return self.rates[name] if self.coordinates else names[(names.index(name) + 1) % len(names)]

    def derived(self) -> HybridAutomaton:
        """The automaton as plain data, with all symbols and modes derived."""
        return self

    @cached_property
    def state_names(self) -> tuple[str, ...]:
        """Names of the states."""
        return tuple(state.name for state in self.states)

    @cached_property
    def values(self) -> Mapping[str, float]:
        """The parameters by name."""
        return MappingProxyType({symbol.name: value for symbol, value in self.parameters.items()})

    @cached_property
    def on_demand(self) -> bool:
        """Whether modes are derived as a run comes to them."""
        return isinstance(self.modes, ModesOnDemand)

    @cached_property
    def names(self) -> Sequence[str]:
        """Names of the modes, in order."""
        if isinstance(self.modes, ModesOnDemand):
            return self.modes.names
        return tuple(mode.name for mode in self.modes)

    def place_of_mode(self, name: str) -> int:
        """The place of a mode in the order, which does not depend on the modes that are derived already."""
        names = self.names
        return names.place_of(name) if isinstance(names, ModeNames) else names.index(name)

    @cached_property
    def outputs(self) -> tuple[str, ...]:
        """Names of the outputs."""
        return tuple(self._expressions)

    @property
    def _expressions(self) -> Mapping[str, Any]:
        """The outputs in the first of the modes that are known."""
        so_far = self.modes.known().modes if isinstance(self.modes, ModesOnDemand) else ()
        any_mode = so_far or self.modes
        return any_mode[0].outputs if any_mode else {}

    @cached_property
    def rotational_outputs(self) -> tuple[str, ...]:
        """Names of the outputs of contacts whose bodies turn: they are angles, their rates and moments.

        Such a contact moves by angles alone, at least by one of them without a lever, that is with the factor
        1 or -1; 1.0 is a lever of 1 m.
        """
        if not any(map(is_angle, self.shown_states)):
            return ()
        expressions = self._expressions
        return tuple(name for name in expressions if self._is_angle(expressions, name))

    def _is_angle(self, expressions: Mapping[str, Any], name: str) -> bool:
        base, number = output_of_contact(name)
        if base not in OUTPUT_UNITS:
            return False
        tangential = base in ("relative_velocity", "friction_force")
        measures = ("relative_velocity",) if tangential else ("penetration", "distance", "relative_velocity")
        names = (f"{measure}_{number}" if number else measure for measure in measures)
        motion = next((expressions[each] for each in names if each in expressions), None)
        if motion is None:
            return False
        moving = [s for s in self.states[: 2 * self.coordinates] if s in motion.free_symbols]
        levers = (motion.diff(s) for s in moving)
        return all(is_angle(s.name) for s in moving) and any(
            lever.is_Integer and abs(lever) == 1 for lever in levers
        )

    def mode(self, name: str) -> Mode:
        """The mode of that name, derived if it is not yet.

        Raises
        ------
        KeyError
            If there is none.
        """
        if isinstance(self.modes, ModesOnDemand):
            return self.modes.named(name)
        check_key("mode", name, self.names)
        return next(mode for mode in self.modes if mode.name == name)

    def replace(self, /, **values: float) -> HybridAutomaton:
        """The automaton with other values of parameters, by their names.

        Raises
        ------
        TypeError
            For an unknown name.
        """
        parameters = self.values
        for name in values:
            if name not in parameters:
                raise unknown_parameter("HybridAutomaton", name, list(parameters))
            if not getattr(values[name], "is_real", False):  # of sympy, such as pi
                check_number(
                    f"the parameter {name}", values[name], cure=f"give it one, such as replace({name}=1.0)"
                )
        return self._with_values(values)

    def _with_values(self, changes: Mapping[str, float]) -> HybridAutomaton:
        symbols = {symbol.name: symbol for symbol in self.parameters}
        numbers = {symbols[name]: value for name, value in changes.items()}
        return replace(self, parameters={**self.parameters, **numbers})

    def __repr__(self) -> str:  # without the equations, which may be pages long
        return f"HybridAutomaton(states {', '.join(self.state_names)}; modes {self._modes_in_words()})"

    def _modes_in_words(self) -> str:
        return repr(self.names) if self.on_demand else ", ".join(self.names)


class WholeAutomaton(HybridAutomaton):
    """An automaton whose modes have functions in pieces, for what is asked of all sides of borders at once.

    Its expressions can be evaluated, and its flow differentiated; it does not run.
    """

    def _split(self) -> None:
        """Its modes stay as they are."""
