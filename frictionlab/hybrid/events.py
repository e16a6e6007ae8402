"""What happened in a run, and when: its events, and its crossings of sections."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np


@dataclass(frozen=True)
class Events:
    """Every event of a run, one row each.

    Attributes
    ----------
    t : (E,) times, in seconds
    source, target : (E,) names of the modes left and entered ("" where none could be entered)
    guard : (E,) names of the event functions that reached zero
    state, before : (E, states) state after and before the reset
    closed : (E,) whether the event closed a Zeno accumulation
    """

    t: np.ndarray
    source: np.ndarray
    target: np.ndarray
    guard: np.ndarray
    state: np.ndarray
    before: np.ndarray
    closed: np.ndarray

    def __len__(self) -> int:
        return len(self.t)

    def counts(self) -> dict[str, int]:
        """Number of events by kind, e.g. ``{"slip+ -> stick": 10}``, the most frequent first."""
        kinds = Counter(f"{a} -> {b}" for a, b in zip(self.source, self.target, strict=True))
        return dict(kinds.most_common())

    def __repr__(self) -> str:
        kinds = ", ".join(f"{kind}: {n}" for kind, n in self.counts().items())
        return f"Events({len(self)}: {kinds})" if kinds else "Events(0)"


class SectionPoints(NamedTuple):
    """Crossings of a section: times (P,) and states (P, states)."""

    t: np.ndarray
    state: np.ndarray
