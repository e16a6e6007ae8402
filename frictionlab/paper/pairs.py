"""Pairs of modes that couple in a root locus, and changes of stability in words."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from frictionlab.stability import RootLocus, StabilityChange


def growing_modes(locus: RootLocus) -> list[int]:
    """The modes that grow somewhere, the fastest first."""
    fastest = np.nanmax(locus.growth_rates, axis=0)
    return [int(mode) for mode in np.argsort(-fastest) if fastest[mode] > 0]


def coupled_pair(locus: RootLocus, mode: int) -> tuple[int, int]:
    """A growing mode and that with the nearest frequency where it grows fastest, in ascending order."""
    row = locus.frequencies[np.nanargmax(locus.growth_rates[:, mode])]
    apart = np.abs(row - row[mode])
    apart[mode] = np.inf
    first, second = sorted((mode, int(np.argmin(apart))))
    return first, second


def in_words(changes: Iterable[StabilityChange]) -> str:
    """ "0 -> 1 at mu_k 1.5138 (15.61 Hz)" and so on: how the number of growing modes goes with mu_k."""
    steps = [
        f"{c.unstable[0]} -> {c.unstable[1]} at {c.value:.4f} ({c.frequency:.2f} Hz)" for c in changes
    ] or ["no change"]
    return ", ".join(steps).replace(" at ", " at mu_k ", 1)
