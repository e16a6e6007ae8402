"""Modes with their flows, events and resets."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from frictionlab.validation import (
    abbreviate,
    check_flag,
    check_mapping,
    check_number,
    check_sequence,
    check_text,
)

# sympy's types, named without importing sympy: this package only carries them.
Expr = Any
Symbol = Any
MAX_NAME = 100_000  # characters of the name of a mode or an event: a mode names a regime of each contact


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
        as zero: if computed, they would be rounding errors.  The function that triggered the event and
        the constraints of the mode it left need not be listed.
    """

    jump: Mapping[Symbol, Expr] = field(default_factory=dict)
    vanishing: Mapping[Expr, int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        check_mapping("jump", self.jump, "give states their values after the event", keys=object)
        check_mapping(
            "vanishing", self.vanishing, "give expressions the numbers of coefficients", keys=object
        )
        for count in self.vanishing.values():
            check_number("a count in vanishing", count, integer=True, least=0, cure="1 is the value alone")


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
        Used instead of `reset` at a Zeno accumulation of these events (chatter).  An event that has one is an
        impact: of several at one instant the one with the greatest jump comes first.
    """

    name: str
    function: Expr
    targets: tuple[str, ...] = ()
    reset: Reset = field(default_factory=Reset)
    accumulation: Reset | None = None

    def __post_init__(self) -> None:
        check_text("the name of an event", self.name, "give it a name", most=MAX_NAME)
        if not isinstance(self.targets, (tuple, list)) or not all(isinstance(t, str) for t in self.targets):
            example = f"({self.targets!r},)" if isinstance(self.targets, str) else "('slip+', 'slip-')"
            raise TypeError(
                f"the targets of event {self.name!r} must be a tuple of names, "
                f"got {abbreviate(self.targets)}: write {abbreviate(example)[1:-1]}"
            )
        check_element(f"the reset of event {self.name!r}", self.reset, Reset)
        if self.accumulation is not None:
            check_element(f"the accumulation of event {self.name!r}", self.accumulation, Reset)
        keep_as_tuples(self, "targets")


class Balance(NamedTuple):
    """The forces (n,) on the coordinates but for M q'', which vanish at rest, and the symbols in them of the
    reactions (r,) by which contacts hold velocities at zero."""

    forces: tuple[Expr, ...]
    reactions: tuple[Symbol, ...]


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
        before any other mode, or by an event of a limit mode that names it, and in no other way.
    whole : Mode or None
        Of a mode on one side of a border, as of a law in pieces, the mode on all sides.
    balance : Balance or None
        Of a mode of a mechanical model the forces, of which accelerations are M^-1 times.
    """

    name: str
    flow: tuple[Expr, ...]
    events: tuple[Event, ...] = ()
    constraints: tuple[Expr, ...] = ()
    outputs: Mapping[str, Expr] = field(default_factory=dict)
    limit: bool = False
    whole: Mode | None = None
    balance: Balance | None = None

    def __post_init__(self) -> None:
        check_text("the name of a mode", self.name, "give it a name", most=MAX_NAME)
        of = f"mode {self.name!r}"
        check_elements(f"the events of {of}", self.events, Event)
        check_sequence(f"the flow of {of}", self.flow, "give the rate of each state, (v, -x)")
        check_sequence(f"the constraints of {of}", self.constraints, "give expressions, (v,)")
        check_mapping(f"the outputs of {of}", self.outputs, "give each a name, {'force': expression}")
        check_flag(f"limit of {of}", self.limit, "leave it out for usual modes")
        keep_as_tuples(self, "flow", "events", "constraints")

    @property
    def holds(self) -> bool:
        """Whether the mode has constraints, as stick has."""
        return bool(self.constraints)


def keep_as_tuples(of: Any, *names: str) -> None:
    """Fields of a frozen dataclass as tuples where lists are given, which have no hash."""
    for name in names:
        if not isinstance(given := getattr(of, name), tuple):
            object.__setattr__(of, name, tuple(given))


def check_elements(what: str, elements: Any, *classes: type) -> None:
    """Raise TypeError unless all elements are of these classes; `what` names the sequence in the message."""
    if isinstance(elements, classes):
        name = f" {elements.name!r}" if hasattr(elements, "name") else ""
        raise TypeError(
            f"{what} must be a tuple, got the {type(elements).__name__}{name} alone: write it in brackets, "
            "with a comma after it"
        )
    for one in check_sequence(what, elements, "write it in brackets"):
        check_element(what, one, *classes)


def check_element(what: str, element: Any, *classes: type) -> None:
    """Raise TypeError unless it is of one of these classes."""
    if not isinstance(element, classes):
        names = [each.__name__ for each in classes]
        calls = " or ".join(f"{name}(...)" for name in names)
        raise TypeError(
            f"{what} must be of the class {' or '.join(names)}, got {abbreviate(element)}: write {calls}"
        )


LOGGER = logging.getLogger(__name__)
