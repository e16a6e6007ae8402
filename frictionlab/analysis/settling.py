"""Where motions settle to: many initial states, each run only for as long as it takes to tell."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from frictionlab.automaton import HybridAutomaton

from .attractors import UNDECIDED, Catalogue, Found, size_of, spread_of
from .ensemble import ends_of
from .examine import Settings, cloud, examined, with_ranges
from .kinds import ENDED
from .recurrence import Array

CHECKS = 20  # looks at the runs within the transient


def known_attractors(automaton: HybridAutomaton, probed: Sequence[Found], settings: Settings) -> Catalogue:
    """A catalogue of what probes found, each once."""
    size = size_of(probed, spread_of(probed), automaton.coordinates)
    catalogue = Catalogue(size, settings["near"])
    for each in probed:
        catalogue.place(each, cloud(automaton, each, settings))
    return catalogue


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
    labels = np.full(len(states), UNDECIDED)
    for _ in range(CHECKS):
        left = np.flatnonzero(labels == UNDECIDED)
        if len(left):
            _run_on(automaton, states, labels, left, catalogue, settings)
    for i in np.flatnonzero(labels == UNDECIDED):
        labels[i] = catalogue.reached(states[i : i + 1])[0]
        if labels[i] == UNDECIDED:
            labels[i] = _examine(automaton, states[i], catalogue, settings)
    return {"labels": labels.tolist(), "found": catalogue.found[len(known.found) :]}


def _run_on(
    automaton: HybridAutomaton,
    states: Array,
    labels: np.ndarray,
    left: np.ndarray,
    catalogue: Catalogue,
    settings: Settings,
) -> None:
    """Run those that are left until the next look at them."""
    ends = ends_of(automaton, states[left], settings["transient"] / CHECKS, settings["method"])
    states[left], labels[left] = ends.states, catalogue.reached(ends.states)
    for i, status in zip(left, ends.status):
        if not status.ok:
            labels[i] = catalogue.place({"kind": ENDED, "period": None, "state": states[i].tolist()})


def _examine(automaton: HybridAutomaton, state: Array, catalogue: Catalogue, settings: Settings) -> int:
    """What the motion from a state comes to, the transient being over."""
    found = examined(automaton, state, settings["spread"], settings)
    points = cloud(automaton, found, settings)
    return catalogue.place(with_ranges(found, points), points)
