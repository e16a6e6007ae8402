"""Where motions settle to: many initial states, each run only for as long as it takes to tell."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from frictionlab.automaton import HybridAutomaton
from frictionlab.hybrid.bookkeeping import FINISHED
from frictionlab.hybrid.under_way import UnderWay, kept

from .attractors import UNDECIDED, Catalogue, Found, size_of, spread_of
from .ensemble import begun, taken_on
from .examine import Settings, cloud, examined, with_ranges
from .kinds import ENDED
from .recurrence import Array

CHECKS = 20  # looks at the runs within the transient, evenly
EARLY = 4  # and before the first of them


def known_attractors(automaton: HybridAutomaton, probed: Sequence[Found], settings: Settings) -> Catalogue:
    """A catalogue of what probes found, each once."""
    size = size_of(probed, spread_of(probed), automaton.coordinates)
    catalogue = Catalogue(size, settings["near"])
    for each in probed:
        if catalogue.known(each) == UNDECIDED:
            catalogue.place(each, cloud(automaton, each, settings))
    return catalogue


def looks(transient: float) -> Array:
    """Times of the looks at the runs: first each twice the one before, for what settles soon."""
    even = transient / CHECKS
    return np.array([*(even / 2**k for k in range(EARLY, 0, -1)), *(even * k for k in range(1, CHECKS + 1))])


def settle(
    automaton: HybridAutomaton, starts: Array, known: Catalogue, settings: Settings
) -> dict[str, list[Any]]:
    """One task: which attractors the starts (N, n) go to.

    Runs are looked at from time to time; who has come to a known attractor is run no further.  What is left
    after the transient is examined one by one.

    Returns
    -------
    dict
        "labels": N indices, those beyond the known attractors into "found".
    """
    catalogue, states = known.copy(), np.array(starts, dtype=float)
    labels, left = np.full(len(states), UNDECIDED), np.arange(len(states))
    group = begun(automaton, states, settings["method"])
    for t in looks(settings["transient"]):
        taken_on(group, t)
        states[left], labels[left] = group.runs.states, _labels(group, catalogue)
        goes_on = labels[left] == UNDECIDED
        group, left = kept(group, goes_on), left[goes_on]
        if not len(left):
            break
    for i in left:
        labels[i] = catalogue.reached(states[i : i + 1])[0]
        if labels[i] == UNDECIDED:
            labels[i] = _examine(automaton, states[i], catalogue, settings)
    return {"labels": labels.tolist(), "found": catalogue.found[len(known.found) :]}


def _labels(group: UnderWay, catalogue: Catalogue) -> np.ndarray:
    """Which attractor each run is on; runs that ended early are on that of their kind."""
    labels = catalogue.reached(group.runs.states)
    for i in np.flatnonzero(group.runs.status != FINISHED):
        labels[i] = catalogue.place({"kind": ENDED, "period": None, "state": group.runs.states[i].tolist()})
    return labels


def _examine(automaton: HybridAutomaton, state: Array, catalogue: Catalogue, settings: Settings) -> int:
    """What the motion from a state comes to, the transient being over."""
    found = examined(automaton, state, settings["spread"], settings)
    points = cloud(automaton, found, settings)
    return catalogue.place(with_ranges(found, points), points)
