"""Modes with their flows, events and resets, and modes that are derived on demand.

N contacts of three regimes have 3^N modes, of which a run visits few.  So a mode is derived, and even its
name made, only when it is asked for; :meth:`ModesOnDemand.known` gives the modes derived so far.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import islice, product
from threading import Lock
from typing import Any, NamedTuple, overload

from frictionlab.validation import (
    abbreviate,
    check_choice,
    check_flag,
    check_mapping,
    check_number,
    check_sequence,
    check_text,
)

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

    @property
    def holds(self) -> bool:
        """Whether the mode has constraints, as stick has."""
        return bool(self.constraints)


def check_elements(what: str, given: Any, *classes: type) -> None:
    """Raise TypeError unless all elements are of these classes; `what` names the sequence in the message."""
    if isinstance(given, classes):
        name = f" {given.name!r}" if hasattr(given, "name") else ""
        raise TypeError(
            f"{what} must be a tuple, got the {type(given).__name__}{name} alone: write it in brackets, "
            "with a comma after it"
        )
    for one in check_sequence(what, given, "write it in brackets"):
        check_element(what, one, *classes)


def check_element(what: str, given: Any, *classes: type) -> None:
    """Raise TypeError unless it is of one of these classes."""
    if not isinstance(given, classes):
        names = [each.__name__ for each in classes]
        calls = " or ".join(f"{name}(...)" for name in names)
        raise TypeError(
            f"{what} must be of the class {' or '.join(names)}, got {abbreviate(given)}: write {calls}"
        )


MAX_NAME = 1000  # characters of the name of a mode or an event, which messages repeat
JOINT = " | "  # separates the regimes in a mode's name
NO_PARTS = "only"  # the name of the only mode where there are no parts
MOST_REMEMBERED = 4096  # names whose combinations are remembered
LISTED = 243  # most modes that a message lists: those of five contacts
Combination = tuple[int, ...]  # for each part the index of its regime

LOGGER = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class Regime:
    """A regime of one part, such as stick of one contact, as known before the modes with it are derived.

    Parameters
    ----------
    name : str
    conditions : tuple of Expr
        Functions that must not be negative where a mode with this regime is entered.
    sticks : bool
        Whether it keeps a velocity at zero wherever the bodies are, as stick does.
    """

    name: str
    conditions: tuple[Expr, ...] = ()
    sticks: bool = False


Parts = tuple[tuple[Regime, ...], ...]


class ModeNames(Sequence[str]):
    """Names of all modes, which are combinations of regimes; each name is made when it is read.

    Parameters
    ----------
    regimes : tuple of tuple of str
        Names of the regimes of each part; one that is empty is left out of names of modes.
    allows : callable
        Whether a combination is a mode.
    """

    def __init__(self, regimes: tuple[tuple[str, ...], ...], allows: Callable[[Combination], bool]) -> None:
        self._names, self._allows = regimes, allows
        self._numbers = [{name: i for i, name in enumerate(names)} for names in regimes]
        self._made: dict[str, Combination] = {}  # of the names that were made last

    def combinations(self) -> Iterator[Combination]:
        """All combinations that are modes, in order: the last part's regime changes fastest."""
        return filter(self._allows, product(*(range(len(names)) for names in self._names)))

    def name_of(self, combination: Combination) -> str:
        """The name of a combination."""
        words = (names[i] for names, i in zip(self._names, combination, strict=True))
        name = JOINT.join(filter(None, words)) or NO_PARTS
        if len(self._made) == MOST_REMEMBERED:
            self._made.clear()
        self._made[name] = combination
        return name

    def combination_of(self, name: Any) -> Combination | None:
        """The combination of that name; None where there is no such mode."""
        if isinstance(name, str) and (made := self._made.get(name)) is not None:
            return made if self._allows(made) else None
        words = name.split(JOINT) if isinstance(name, str) and name != NO_PARTS else []
        combination = ()
        for numbers in self._numbers:
            named = bool(words) and words[0] in numbers
            combination += (numbers.get(words.pop(0) if named else "", -1),)
        return combination if not words and -1 not in combination and self._allows(combination) else None

    def has_regime(self, name: str) -> bool:
        """Whether some part has a regime of this name."""
        return any(name in names for names in self._names)

    def place_of(self, name: str) -> int:
        """The place of a mode in the order, counted as if all combinations were modes."""
        place = 0
        for regime, names in zip(self.combination_of(name) or (), self._names):
            place = place * len(names) + regime
        return place

    def __contains__(self, name: object) -> bool:
        return self.combination_of(name) is not None

    def __iter__(self) -> Iterator[str]:
        return map(self.name_of, self.combinations())

    def __len__(self) -> int:
        return sum(1 for _ in self.combinations())

    @overload
    def __getitem__(self, index: int) -> str: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[str, ...]: ...
    def __getitem__(self, index: int | slice) -> str | tuple[str, ...]:
        if isinstance(index, slice):
            return tuple(self)[index]
        return self.name_of(self.combination_at(index))

    def combination_at(self, index: int) -> Combination:
        """The combination of that place in the order."""
        place = index if index >= 0 else len(self) + index
        combination = next(islice(self.combinations(), max(place, 0), None), None)
        if combination is None or place < 0:
            raise IndexError(f"there is no mode number {index}")
        return combination

    def more_than(self, count: int) -> bool:
        """Whether there are more modes than `count`, found without going through all of them."""
        return next(islice(self.combinations(), count, None), None) is not None

    def __eq__(self, other: object) -> bool:
        if isinstance(other, ModeNames):
            return self._names == other._names
        return isinstance(other, tuple) and tuple(self) == other

    def __hash__(self) -> int:
        return hash(self._names)

    def __repr__(self) -> str:
        return JOINT.join("/".join(filter(None, names)) for names in self._names if any(names)) or NO_PARTS


def names_of_regimes(regimes: Sequence[Sequence[str]], names: Sequence[str]) -> ModeNames:
    """`ModeNames` of an automaton with few modes, which `names` lists."""
    allowed = {*names}
    mode_names = ModeNames(
        tuple(map(tuple, regimes)), lambda combination: mode_names.name_of(combination) in allowed
    )
    return mode_names


def check_mode_name(mode: Any, names: Sequence[str], others: Sequence[str] = ()) -> None:
    """Raise ValueError unless there is a mode of that name, or it is one of the `others`."""
    if isinstance(mode, str) and (mode in names or mode in others):
        return
    if not isinstance(names, ModeNames) or not names.more_than(LISTED):
        check_choice("mode", mode, (*names, *others))
    raise ValueError(
        f"mode must have one regime for each contact, {names!r}, "
        f"got {abbreviate(mode)}: join them by {JOINT!r}"
    )


class KnownModes(NamedTuple):
    """Modes derived so far, the combination of each, and combinations found not to be modes."""

    modes: tuple[Mode, ...]
    combinations: tuple[Combination, ...]
    refused: tuple[Combination, ...]


class ModesOnDemand(Sequence[Mode]):
    """A sequence of modes, each derived when it is first used and then kept.

    Parameters
    ----------
    parts : tuple of tuple of Regime
        The regimes of each part, in the order in which they are tried.
    derive : callable
        Gives the mode of a combination, which has the index of a regime for each part.
    allows : callable
        Whether a combination is a mode.
    again : tuple of callable and arguments, or None
        A call that makes these modes again in another process, for pickling.  With None all modes are
        derived and pickled.
    origin : callable or None
        Gives what the modes are derived from as JSON data, for files of runs; raises TypeError where JSON
        cannot hold it.
    whole : sequence of Mode, or None
        Of modes on sides of borders, as of laws in pieces, the modes on all sides.
    products : tuple of MatrixProduct
        Products of matrices that many modes have in common.

    Attributes
    ----------
    names : ModeNames
        Names of all modes; none is derived for this.
    """

    def __init__(
        self,
        parts: Parts,
        derive: Callable[[Combination], Mode],
        allows: Callable[[Combination], bool] = lambda _: True,
        again: tuple[Callable[..., ModesOnDemand], tuple[Any, ...]] | None = None,
        origin: Callable[[], dict[str, Any]] | None = None,
        whole: Sequence[Mode] | None = None,
        products: tuple[Any, ...] = (),
    ) -> None:
        self.parts, self.origin, self.whole, self.products = parts, origin, whole, products
        self.names = ModeNames(tuple(tuple(regime.name for regime in part) for part in parts), allows)
        self._derive, self.allows, self._again = derive, allows, again
        self._derived: dict[Combination, Mode] = {}
        self._refused: dict[Combination, None] = {}
        self._one_at_a_time = Lock()  # else two threads might derive one mode twice

    @property
    def derived(self) -> tuple[str, ...]:
        """Names of the modes derived so far, in the order in which they were derived."""
        return tuple(map(self.names.name_of, tuple(self._derived)))

    def known(self) -> KnownModes:
        """The modes known so far; those of an earlier call come first, in the same order."""
        with self._one_at_a_time:
            return KnownModes(tuple(self._derived.values()), tuple(self._derived), tuple(self._refused))

    def all(self) -> KnownModes:
        """As :meth:`known`, after deriving all modes, and in order."""
        every = tuple(product(*(range(len(part)) for part in self.parts)))
        modes = {one: mode for one in every if (mode := self.mode(one)) is not None}
        return KnownModes(
            tuple(modes.values()), tuple(modes), tuple(one for one in every if one not in modes)
        )

    def chosen(self, names: Sequence[str]) -> KnownModes:
        """As :meth:`known`, but only the modes of these names, in this order."""
        combinations = tuple(self.names.combination_of(name) or () for name in names)
        return KnownModes(tuple(map(self.named, names)), combinations, ())

    def mode(self, combination: Combination) -> Mode | None:
        """The mode of a combination; None if the combination is no mode."""
        with self._one_at_a_time:
            if combination not in self._derived and combination not in self._refused:
                if self.allows(combination):
                    LOGGER.debug("deriving mode %r, to which a run came", self.names.name_of(combination))
                    self._derived[combination] = self._derive(combination)
                else:
                    self._refused[combination] = None
            return self._derived.get(combination)

    def named(self, name: str) -> Mode:
        """The mode of that name.

        Raises
        ------
        KeyError
            If there is none.
        """
        combination = self.names.combination_of(name)
        mode = None if combination is None else self.mode(combination)
        if mode is None:
            raise KeyError(f"no mode is called {name!r}")
        return mode

    def select(self, suits: Callable[[Regime], bool]) -> Iterator[Mode]:
        """The modes all of whose regimes suit, in order, derived one by one."""
        chosen = ([i for i, regime in enumerate(part) if suits(regime)] for part in self.parts)
        return (mode for one in product(*chosen) if (mode := self.mode(one)) is not None)

    def __iter__(self) -> Iterator[Mode]:
        return self.select(lambda _: True)

    def __len__(self) -> int:
        return len(self.names)

    def __bool__(self) -> bool:
        return True

    @overload
    def __getitem__(self, index: int) -> Mode: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[Mode, ...]: ...
    def __getitem__(self, index: int | slice) -> Mode | tuple[Mode, ...]:
        if isinstance(index, slice):
            return tuple(self.named(name) for name in self.names[index])
        return self.named(self.names[index])

    def __reduce__(self) -> tuple[Any, ...]:
        return (tuple, (tuple(self),)) if self._again is None else self._again
