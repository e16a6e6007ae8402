"""Modes that are derived when they are first asked for, and sketches that stand for them until then."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from threading import Lock
from typing import Any, overload

from .mode import Mode

LOGGER = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class Sketch(Mode):
    """What is known of a mode before it is derived: where it cannot be entered.

    None of its `constraints` may be negative where the mode is entered; its flow is not known, and zero.

    Parameters
    ----------
    held : bool
        Whether the mode will have constraints.
    """

    held: bool = False

    @property
    def holds(self) -> bool:
        return self.held


class ModesOnDemand(Sequence[Mode]):
    """A sequence of modes, each derived when it is first used and then kept.

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
        """Names of all modes; none is derived for this."""
        return tuple(sketch.name for sketch in self._sketches)

    @property
    def derived(self) -> tuple[str, ...]:
        """Names of those that are derived, in that order."""
        return tuple(self._derived)

    def known(self, names: Iterable[str] | None = None) -> tuple[Mode, ...]:
        """All modes, as sketches but for those named; by default those derived so far are complete."""
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
                LOGGER.debug("deriving mode %r, to which a run came", name)
                self._derived[name] = self._derive(name)
        return self._derived[name]

    def __reduce__(self) -> tuple[Any, ...]:
        return tuple, (list(self),)  # a pickle contains all modes
