"""A mode: its flow, the events that end it, and what jumps at them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

# sympy's types, named without importing sympy: this package only carries them.
Expr = Any
Symbol = Any


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
        The name in the run's event table, e.g. ``"gap"`` where a contact opens or closes.
    function : Expr
        The event function.
    targets : tuple of str
        Modes to try first, in this order; the automaton's other modes follow in its own order.
    reset : Reset
        The jump of the state.
    accumulation : Reset or None
        Used instead of `reset` at a Zeno accumulation of these events (chatter).
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
        Whether this is a limit mode of Zeno behaviour: it is entered by an event's `accumulation` reset,
        before any other mode, and in no other way.
    """

    name: str
    flow: tuple[Expr, ...]
    events: tuple[Event, ...] = ()
    constraints: tuple[Expr, ...] = ()
    outputs: Mapping[str, Expr] = field(default_factory=dict)
    limit: bool = False

    def __post_init__(self) -> None:
        check_elements(f"the events of mode {self.name!r}", self.events, Event)

    @property
    def holds(self) -> bool:
        """Whether the mode has constraints, as stick has."""
        return bool(self.constraints)


def check_elements(what: str, given: Any, kind: type) -> None:
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
