"""Modes over one state space, and the numbers they need."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from frictionlab.validation import unknown_parameter

from .mode import Mode, ModesOnDemand, Symbol, check_elements


@dataclass(frozen=True, eq=False, repr=False)
class HybridAutomaton:
    """Modes over one state space, and the numbers they need.

    Parameters
    ----------
    states : tuple of Symbol
        Coordinates first, then their velocities, then other states.
    modes : tuple of Mode, or ModesOnDemand
        In the order in which they are tried where no event says otherwise, the start included.
        What is derived from them is remembered per Mode object: build them once, vary `parameters`.
    parameters : mapping of Symbol to float
        Every symbol of the expressions that is not a state.  The solver sets one called ``chatter`` to the
        dwell time (s) below which it replaces events in a row by their limit mode.
    coordinates : int
        How many of the states are coordinates; as many velocities follow them.

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

    def __post_init__(self) -> None:
        if not isinstance(self.modes, ModesOnDemand):
            check_elements("modes", self.modes, Mode)
        for what, symbols in {"states": self.states, "parameters": self.parameters}.items():
            if words := [s for s in symbols if isinstance(s, str)]:
                raise TypeError(
                    f"{what} must be symbols, got {words[0]!r}: make them with sympy.symbols, and write the "
                    "expressions with these"
                )

    @property
    def names(self) -> Sequence[str]:
        """Names of the modes, in order."""
        if isinstance(self.modes, ModesOnDemand):
            return self.modes.names
        return tuple(mode.name for mode in self.modes)

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of the outputs."""
        derived = self.modes.known().modes if isinstance(self.modes, ModesOnDemand) else ()
        any_mode = derived or self.modes
        return tuple(any_mode[0].outputs) if any_mode else ()

    def mode(self, name: str) -> Mode:
        """The mode of that name, derived if it is not yet.

        Raises
        ------
        KeyError
            If there is none.
        """
        if isinstance(self.modes, ModesOnDemand):
            return self.modes.named(name)
        found = next((mode for mode in self.modes if mode.name == name), None)
        if found is None:
            raise KeyError(f"no mode is called {name!r}: the modes are {', '.join(self.names)}")
        return found

    def replace(self, **values: float) -> HybridAutomaton:
        """The automaton with other values of parameters, by their names.

        Raises
        ------
        TypeError
            For an unknown name.
        """
        symbols = {symbol.name: symbol for symbol in self.parameters}
        unknown = [name for name in values if name not in symbols]
        if unknown:
            raise unknown_parameter("HybridAutomaton", unknown[0], list(symbols))
        changed = {symbols[name]: value for name, value in values.items()}
        return HybridAutomaton(self.states, self.modes, {**self.parameters, **changed}, self.coordinates)

    def __repr__(self) -> str:  # without the equations, which may be pages long
        return f"HybridAutomaton(states {', '.join(map(str, self.states))}; modes {self._modes_in_words()})"

    def _modes_in_words(self) -> str:
        return repr(self.names) if isinstance(self.modes, ModesOnDemand) else ", ".join(self.names)
