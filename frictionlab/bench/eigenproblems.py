"""Time of many eigenvalue problems at once, against a Python loop: part of `frictionlab bench`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from frictionlab.analysis.markdown import markdown
from frictionlab.models import SliderOnBelt
from frictionlab.stability import eigenvalues, root_locus, stability_changes

from .switches import interleaved

LOOP = 20  # the loop solves one problem in so many and is scaled up
MODEL = SliderOnBelt()


@dataclass(frozen=True)
class Row:
    """What was done, wall time in s, largest difference of an eigenvalue from those of the loop in 1/s."""

    name: str
    seconds: float
    difference: float


def eigenproblems(count: int = 10_000, repeats: int = 3) -> list[Row]:
    """Equilibrium and eigenvalues for `count` values of mu_k: tracked all at once, and in a loop."""
    values = np.linspace(0.0, 3.0, count)
    some = values[::LOOP]
    at_once, loop, changes = interleaved(
        [lambda: root_locus(MODEL, "mu_k", values), lambda: _loop(some), _changes], repeats
    )
    scale = count / len(some)
    return [
        Row(f"{count} values, modes tracked (root_locus)", at_once, _difference(some)),
        Row(f"{count} values, one after another (eigenvalues)", loop * scale, 0.0),
        Row("every stability change from mu_k 0 to 3 (stability_changes)", changes, 0.0),
    ]


def _loop(values: Any) -> list[Any]:
    return [eigenvalues(MODEL.replace(mu_k=float(value))).values for value in values]


def _changes() -> Any:
    return stability_changes(MODEL, "mu_k", (0.0, 3.0))


def _difference(values: Any) -> float:
    tracked = np.sort_complex(root_locus(MODEL, "mu_k", values).values)
    upper = np.array([np.sort_complex(one[one.imag > 0]) for one in _loop(values)])
    return float(np.abs(tracked - upper).max())


def table(rows: list[Row]) -> str:
    """The rows as Markdown; times also as multiples of the first."""
    lines = (
        f"{r.name} | {r.seconds:.3g} s | {r.seconds / rows[0].seconds:.2g} | {r.difference:.0e}" for r in rows
    )
    return markdown("eigenvalue problems | wall time | x | difference, 1/s", lines)
