"""Steady states in words."""

from __future__ import annotations

from itertools import groupby, pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

MOST = 7  # stretches that a reader can take in
SLACK = 1e-9  # for values that are the same but for rounding
AT_REST, PERIODIC, NON_PERIODIC = "equilibrium", "periodic", "non-periodic"


def moving(found: Any) -> NDArray[np.bool_]:
    """Where a sweep found a vibration, periodic or not."""
    return np.isin(found.kinds, (PERIODIC, NON_PERIODIC))


def are(found: Any, kind: str) -> NDArray[np.bool_]:
    """Where a sweep found this kind."""
    return np.array(found.kinds) == kind


def within(found: Any, first: float, last: float, *, open_end: bool = False) -> NDArray[np.bool_]:
    """Which values lie in [first, last], or in [first, last)."""
    return (found.values >= first - SLACK) & (found.values < last + (-SLACK if open_end else SLACK))


def stretches(found: Any) -> str:
    """ "equilibrium 0.05 to 0.35, periodic 0.4 to 3"; where they alternate often, how often each."""
    groups = [(kind, [v for _, v in group]) for kind, group in groupby(zip(found.kinds, found.values), _kind)]
    if len(groups) <= MOST:
        return ", ".join(f"{kind} {_range(values)}" for kind, values in groups)
    return ", ".join(_share(found, kind) for kind in dict.fromkeys(found.kinds))


def count(held: Any) -> str:
    """ "3 of 10"."""
    return f"{int(np.sum(held))} of {len(held)}"


def _kind(pair: tuple[str, float]) -> str:
    return pair[0]


def _range(values: list[float]) -> str:
    return f"{values[0]:g}" if len(values) == 1 else f"{values[0]:g} to {values[-1]:g}"


def _share(found: Any, kind: str) -> str:
    chosen = are(found, kind)
    values = found.values[chosen]
    return f"{kind} at {count(chosen)} values ({_range(values.tolist())})"


def regimes(found: Any) -> list[tuple[str, int]]:
    """Kind, and the onsets of stick in a period where there is one, of all that has settled."""
    settled = moving(found) | are(found, AT_REST)
    return [(kind, int(n)) for kind, n, known in zip(found.kinds, found.onsets, settled) if known]


def regime_changes(found: Any) -> int:
    """How often neighbours along a sweep are of different regimes."""
    each = regimes(found)
    return sum(a != b for a, b in pairwise(each))
