"""A hybrid automaton as plain data: modes with a flow, event functions that guard them, resets.

This module is the common language of the models, which write automata, and of the solver, which runs
them.  It knows nothing of friction and does no work: expressions are sympy expressions in the state and
parameter symbols, and :mod:`frictionlab.hybrid` turns them into numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from threading import Lock
from types import MappingProxyType
from typing import Any, overload

# sympy's types, named without importing sympy: this module only carries them.
Expr = Any
Symbol = Any

NOTHING: Mapping[Any, Any] = MappingProxyType({})


@dataclass(frozen=True, eq=False)
class Reset:
    """What jumps at an event.

    Parameters
    ----------
    jump : mapping of Symbol to Expr
        New values of the states that jump, in terms of the states just before; the others stay.
    vanishing : mapping of Expr to int
        Functions of the state that are zero right after the event *by construction*, with the number
        of their leading Taylor coefficients (value, rate, ...) that vanish.  Those coefficients count
        as zero, not as the rounding error they would be computed to.  The function that triggered the
        event and the constraints of the mode it left need not be listed.
    """

    jump: Mapping[Symbol, Expr] = field(default_factory=dict)
    vanishing: Mapping[Expr, int] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Event:
    """A guard: `function` is positive while its mode lasts; where it reaches zero the event happens.

    Parameters
    ----------
    name : str
        What the run's event table calls it, e.g. ``"gap"``.
    function : Expr
        The event function.
    targets : tuple of str
        Modes to try first, in this order; the automaton's other modes follow in its own order.
    reset : Reset
        What happens to the state.
    accumulation : Reset or None
        Used instead of `reset` when these events pile up in finite time (chatter).
    """

    name: str
    function: Expr
    targets: tuple[str, ...] = ()
    reset: Reset = field(default_factory=Reset)
    accumulation: Reset | None = None

    def __post_init__(self) -> None:
        if isinstance(self.targets, str):
            raise TypeError(
                f"the targets of event {self.name!r} must be a tuple of names, got {self.targets!r}: "
                f"write ({self.targets!r},)"
            )


@dataclass(frozen=True, eq=False)
class Mode:
    """A smooth regime: x' = flow(x) while every event function is positive.

    Parameters
    ----------
    name : str
    flow : tuple of Expr
        Time derivative of every state, in the automaton's order.
    events : tuple of Event
    constraints : tuple of Expr
        Functions that are zero throughout the mode (v_r in stick): a state where they are not cannot
        enter it.
    outputs : mapping of str to Expr
        Named quantities that the trajectory offers as ``run.<name>``; every mode has the same names.
    limit : bool
        Whether this is what events that pile up come to: entered, before any other mode, by an event's
        `accumulation` reset, and in no other way.
    """

    name: str
    flow: tuple[Expr, ...]
    events: tuple[Event, ...] = ()
    constraints: tuple[Expr, ...] = ()
    outputs: Mapping[str, Expr] = field(default_factory=dict)
    limit: bool = False

    def __post_init__(self) -> None:
        _check_all(f"the events of mode {self.name!r}", self.events, Event)

    @property
    def holds(self) -> bool:
        """Whether it holds something fast."""
        return bool(self.constraints)


@dataclass(frozen=True, eq=False)
class Sketch(Mode):
    """What is known of a mode before it is derived: where it cannot be entered.

    None of its `constraints` may be negative where the mode is entered; its flow is not known, and zero.
    """

    @property
    def holds(self) -> bool:
        return any(-function in self.constraints for function in self.constraints)


class ModesOnDemand(Sequence[Mode]):
    """Modes that are derived once they are asked for, by index or in turn, and then kept.

    Parameters
    ----------
    sketches : iterable of Sketch
        One for each mode, in the automaton's order.
    derive : callable
        From a name to the mode.
    """

    def __init__(self, sketches: Iterable[Sketch], derive: Callable[[str], Mode]) -> None:
        self._sketches, self._derive = tuple(sketches), derive
        self._derived: dict[str, Mode] = {}
        self._one_at_a_time = Lock()  # else two threads might have two modes of one name

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all modes, of which none is derived for that."""
        return tuple(sketch.name for sketch in self._sketches)

    @property
    def derived(self) -> tuple[str, ...]:
        """Names of those that are derived, in that order."""
        return tuple(self._derived)

    def known(self, names: Iterable[str] | None = None) -> tuple[Mode, ...]:
        """All, with a sketch for each but those of the given names; by default those derived so far."""
        chosen = frozenset(self.derived if names is None else names)
        return tuple(self[i] if s.name in chosen else s for i, s in enumerate(self._sketches))

    def __len__(self) -> int:
        return len(self._sketches)

    @overload
    def __getitem__(self, index: int) -> Mode: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[Mode, ...]: ...
    def __getitem__(self, index: int | slice) -> Mode | tuple[Mode, ...]:
        if isinstance(index, slice):
            return tuple(self[i] for i in range(len(self))[index])
        name = self._sketches[index].name
        with self._one_at_a_time:
            if name not in self._derived:
                self._derived[name] = self._derive(name)
        return self._derived[name]

    def __reduce__(self) -> tuple[Any, ...]:
        return tuple, (list(self),)  # a file or another process gets them all


@dataclass(frozen=True, eq=False, repr=False)
class HybridAutomaton:
    """Modes over one state space, and the numbers they need.

    Parameters
    ----------
    states : tuple of Symbol
        Coordinates first, then their velocities, then anything else.
    modes : tuple of Mode, or ModesOnDemand
        In the order in which they are tried where no event says otherwise, the start included.
        What is derived from them is remembered per Mode object: build them once, vary `parameters`.
    parameters : mapping of Symbol to float
        Every symbol of the expressions that is not a state.  One called ``chatter`` is given the
        dwell time (s) below which the solver replaces events in a row by their limit.
    coordinates : int
        How many of the states are coordinates; as many velocities follow them.

    Raises
    ------
    TypeError
        For states that are no symbols, or modes that are none.

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
            _check_all("modes", self.modes, Mode)
        for what, symbols in {"states": self.states, "parameters": self.parameters}.items():
            if words := [s for s in symbols if isinstance(s, str)]:
                raise TypeError(
                    f"{what} must be symbols, got {words[0]!r}: make them with sympy.symbols, and write the "
                    "expressions with these"
                )

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the modes, in order."""
        if isinstance(self.modes, ModesOnDemand):
            return self.modes.names
        return tuple(mode.name for mode in self.modes)

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of the outputs."""
        any_mode = [mode for mode in self.known_modes if not isinstance(mode, Sketch)] or self.modes
        return tuple(any_mode[0].outputs) if any_mode else ()

    @property
    def known_modes(self) -> tuple[Mode, ...]:
        """The modes, with a sketch for each that is yet to be derived."""
        return self.modes.known() if isinstance(self.modes, ModesOnDemand) else self.modes

    def replace(self, **values: float) -> HybridAutomaton:
        """The automaton with other values of parameters, by their names.

        Raises
        ------
        ValueError
            For an unknown name.
        """
        symbols = {symbol.name: symbol for symbol in self.parameters}
        unknown = [name for name in values if name not in symbols]
        if unknown:
            raise ValueError(f"no parameter is called {unknown[0]!r}: known are {', '.join(symbols)}")
        changed = {symbols[name]: value for name, value in values.items()}
        return HybridAutomaton(self.states, self.modes, {**self.parameters, **changed}, self.coordinates)

    def __repr__(self) -> str:  # without the equations, which may take pages
        return f"HybridAutomaton(states {', '.join(map(str, self.states))}; modes {', '.join(self.names)})"


def _check_all(what: str, given: Any, kind: type) -> None:
    """Raise unless it is a sequence of that kind."""
    if isinstance(given, kind):
        raise TypeError(
            f"{what} must be a tuple, got the {kind.__name__} {given.name!r} alone: write it in brackets, "
            "with a comma after it"
        )
    for one in given:
        if not isinstance(one, kind):
            name = kind.__name__
            raise TypeError(f"{what} must be of the class {name}, got {one!r}: write frictionlab.{name}(...)")
