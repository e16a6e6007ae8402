"""Modes that are combinations of regimes, one for each part, such as a contact.

N contacts of three regimes have 3^N modes, of which a run visits few.  So a mode is derived, and even its
name made, only when it is asked for; :meth:`ModesOnDemand.known` gives the modes derived so far.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import islice, product
from threading import Lock
from typing import Any, NamedTuple, overload

from frictionlab.automaton.mode import Expr, Mode
from frictionlab.validation import (
    abbreviate,
    check_choice,
)

LOGGER = logging.getLogger(__name__)

JOINT = " | "  # separates the regimes in a mode's name
NO_PARTS = "only"  # the name of the only mode where there are no parts
MOST_REMEMBERED = 4096  # names whose combinations are remembered
LISTED = 243  # most modes that a message lists: those of five contacts
Combination = tuple[int, ...]  # for each part the index of its regime


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
    rates : tuple of Expr
        The rates of states that only this part moves.
    """

    name: str
    conditions: tuple[Expr, ...] = ()
    sticks: bool = False
    rates: tuple[Expr, ...] = ()


Parts = tuple[tuple[Regime, ...], ...]


class ModeNames(Sequence[str]):
    """Names of all modes, which are combinations of regimes; each name is made when it is read.

    Parameters
    ----------
    regimes : tuple of tuple of str
        Names of the regimes of each part; one that is empty is left out of names of modes.
    allows : callable
        Whether a combination is a mode; of some leading regimes, whether modes may have them.
    """

    def __init__(self, regimes: tuple[tuple[str, ...], ...], allows: Callable[[Combination], bool]) -> None:
        self._names, self.allows = regimes, lru_cache(maxsize=MOST_REMEMBERED)(allows)
        self._numbers = [{name: i for i, name in enumerate(names)} for names in regimes]
        self._made: dict[str, Combination] = {}  # of the names that were made last

    def combinations(self) -> Iterator[Combination]:
        """All combinations that are modes, in order: the last part's regime changes fastest."""
        return filter(self.allows, product(*(range(len(names)) for names in self._names)))

    def conflict(self, combination: Combination) -> int:
        """How many leading regimes of a combination that is no mode exclude each other."""
        return next(i for i in range(1, 1 + len(combination)) if not self.allows(combination[:i]))

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
        if isinstance(name, str) and (combination_of_name := self._made.get(name)) is not None:
            return combination_of_name if self.allows(combination_of_name) else None
        words = name.split(JOINT) if isinstance(name, str) and name != NO_PARTS else []
        combination = ()
        for numbers in self._numbers:
            has_number = bool(words) and words[0] in numbers
            combination += (numbers.get(words.pop(0) if has_number else "", -1),)
        return combination if not words and -1 not in combination and self.allows(combination) else None

    def regimes(self, parts: slice = slice(None)) -> set[str]:
        """The names of the regimes that some of these parts has."""
        return {name for names in self._names[parts] for name in names if name}

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


def names_of_parts(parts: Parts, allows: Callable[[Combination], bool]) -> ModeNames:
    """`ModeNames` of parts with these regimes."""
    return ModeNames(tuple(tuple(regime.name for regime in part) for part in parts), allows)


def regimes_in(names: Sequence[str], parts: slice = slice(None)) -> set[str]:
    """The regimes that contacts, or these parts, have in some mode; many modes are not gone through."""
    if isinstance(names, ModeNames):
        return names.regimes(parts)
    return {regime for name in names for regime in name.split(JOINT)[parts]}


def has_regime(names: Sequence[str], regime: str) -> bool:
    """Whether a contact has a regime in some mode."""
    return regime in regimes_in(names)


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
    names : ModeNames or None
        Names of all modes, which also tell what combinations are modes; with None all are.
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
    """

    def __init__(
        self,
        parts: Parts,
        derive: Callable[[Combination], Mode],
        names: ModeNames | None = None,
        again: tuple[Callable[..., ModesOnDemand], tuple[Any, ...]] | None = None,
        origin: Callable[[], dict[str, Any]] | None = None,
        whole: Sequence[Mode] | None = None,
        products: tuple[Any, ...] = (),
    ) -> None:
        self.parts, self.origin, self.whole, self.products = parts, origin, whole, products
        self.names = names_of_parts(parts, lambda _: True) if names is None else names
        self._derive, self._again = derive, again
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

    def samples(self) -> list[Mode]:
        """Some modes that have all regimes between them, as far as they are modes; they are not kept."""
        longest, allows = max(map(len, self.parts), default=1), self.names.allows
        some = {tuple(min(i, len(part) - 1) for part in self.parts) for i in range(longest)}
        some = set(filter(allows, some))
        for place, part in enumerate(self.parts):
            for i in {*range(len(part))}.difference(one[place] for one in some):
                choices = [range(len(each) - 1, -1, -1) for each in self.parts]  # apart before at rest
                choices[place] = range(i, i + 1)
                some.update(islice(filter(allows, islice(product(*choices), MOST_REMEMBERED)), 1))
        with self._one_at_a_time:
            return [self._derive(one) for one in sorted(some)]

    def chosen(self, names: Sequence[str]) -> KnownModes:
        """As :meth:`known`, but only the modes of these names, in this order."""
        combinations = tuple(self.names.combination_of(name) or () for name in names)
        return KnownModes(tuple(map(self.named, names)), combinations, ())

    def mode(self, combination: Combination) -> Mode | None:
        """The mode of a combination; None if the combination is no mode."""
        with self._one_at_a_time:
            if combination not in self._derived and combination not in self._refused:
                if self.names.allows(combination):
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
        suitable = [[i for i, regime in enumerate(part) if suits(regime)] for part in self.parts]
        return (mode for one in self._joined(suitable, ()) if (mode := self.mode(one)) is not None)

    def _joined(self, suitable: Sequence[Sequence[int]], leading: Combination) -> Iterator[Combination]:
        """The combinations with these leading regimes, but for those that exclude each other."""
        if len(leading) == len(suitable):
            yield leading
        elif not leading or self.names.allows(leading):
            for one in suitable[len(leading)]:
                yield from self._joined(suitable, (*leading, one))

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
