"""Basins of attraction, as `fl.basins` and `fl.basin_stability` return them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from .attractors import UNDECIDED, Attractor, Catalogue, named, size_of, spread_of
from .journal import read, write
from .recurrence import Array


@dataclass(frozen=True, eq=False)
class Labelled:
    """Initial states, each with the attractor it goes to; the base of both results."""

    labels: np.ndarray
    attractors: tuple[Attractor, ...]
    names: tuple[str, ...]
    asked: dict[str, Any]
    results: dict[int, Any]

    @property
    def fractions(self) -> dict[str, float]:
        """Share p of the initial states that goes to each attractor, by its name."""
        done = max(1, int((self.labels != UNDECIDED).sum()))
        return {a.name: float((self.labels == i).sum()) / done for i, a in enumerate(self.attractors)}

    def save(self, path: str | Path) -> Path:
        """Write the result as JSON lines: what :func:`load_basins` reads and `resume` continues."""
        return write(path, self.asked, self.results)


@dataclass(frozen=True, eq=False)
class Basins(Labelled):
    """Basins of attraction in a plane of initial states.

    Parameters
    ----------
    x, y : str
        Names of the states that vary.
    x_values, y_values : array (N,), (M,)
    labels : int array (M, N)
        Index of the attractor that each initial state goes to; -1 where that was not computed (after ctrl-C).
    attractors : tuple of Attractor
        In the order in which they were found.
    names : tuple of str
        Names of all states.
    asked : mapping
        All that determines the result.
    results : mapping of int to mapping
        What was computed, by task.
    """

    x: str
    y: str
    x_values: Array
    y_values: Array

    def __repr__(self) -> str:
        return f"Basins({self.x}, {self.y}: {_shares(self.fractions)})"


@dataclass(frozen=True, eq=False)
class BasinStability(Labelled):
    """Shares of random initial states that go to each attractor.

    Parameters
    ----------
    ranges : mapping of str to (float, float)
    points : array (N, k)
        Initial values of the states in `ranges`.
    labels : int array (N,)
        Index of the attractor that each goes to; -1 where that was not computed (after ctrl-C).
    attractors, names, asked, results
        As :class:`Basins`.
    """

    ranges: dict[str, tuple[float, float]]
    points: Array

    @property
    def errors(self) -> dict[str, float]:
        """Standard error of each share, sqrt(p (1 - p)/N)."""
        count = max(1, int((self.labels != UNDECIDED).sum()))
        return {name: float(np.sqrt(p * (1.0 - p) / count)) for name, p in self.fractions.items()}

    def __repr__(self) -> str:
        return f"BasinStability({_shares(self.fractions, self.errors)})"


def load_basins(path: str | Path) -> Basins | BasinStability:
    """A result that `save`, or `resume`, wrote.

    Raises
    ------
    ValueError
        If the file is none.
    """
    asked, results = read(path)
    if not {"coordinates", "probes", "group"} <= asked.keys():
        raise ValueError(f"{path} must be a file of basins, and is one of another sweep: give another path")
    return basins_of(asked, results) if "x" in asked else stability_of(asked, results)


def basins_of(asked: dict[str, Any], results: dict[int, Any]) -> Basins:
    labels, attractors = _collected(asked, results)
    x, y = asked["x"], asked["y"]
    return Basins(
        x=x["name"],
        y=y["name"],
        x_values=np.array(x["values"]),
        y_values=np.array(y["values"]),
        labels=labels.reshape(len(y["values"]), len(x["values"])),
        attractors=attractors,
        names=tuple(asked["states"]),
        asked=asked,
        results=results,
    )


def stability_of(asked: dict[str, Any], results: dict[int, Any]) -> BasinStability:
    labels, attractors = _collected(asked, results)
    ranges = {name: (low, high) for name, (low, high) in asked["ranges"].items()}
    return BasinStability(
        ranges=ranges,
        points=drawn(ranges, asked["samples"], asked["seed"]),
        labels=labels,
        attractors=attractors,
        names=tuple(asked["states"]),
        asked=asked,
        results=results,
    )


def drawn(ranges: dict[str, tuple[float, float]], samples: int, seed: int) -> Array:
    """Random initial values (samples, k), uniform in the ranges."""
    low, high = np.array(list(ranges.values())).T
    return np.random.default_rng(seed).uniform(low, high, (samples, len(ranges)))


def _collected(asked: dict[str, Any], results: dict[int, Any]) -> tuple[np.ndarray, tuple[Attractor, ...]]:
    """Labels of all initial states, and the attractors: those of the probes, then those of each group."""
    probes, group = asked["probes"], asked["group"]
    probed = [results[i] for i in range(probes) if i in results]
    catalogue = Catalogue(size_of(probed, spread_of(probed), asked["coordinates"]), asked["near"])
    places = [catalogue.place(found) for found in probed]
    known, labels = len({*places}), np.full(asked["count"], UNDECIDED)
    for i in sorted(i for i in results if i >= probes):
        index = np.array([*range(known), *(catalogue.place(found) for found in results[i]["found"])])
        first = (i - probes) * group
        labels[first : first + group] = index[results[i]["labels"]]
    return labels, named(catalogue.found)


def _shares(fractions: dict[str, float], errors: dict[str, float] | None = None) -> str:
    bounds = {
        name: "" if errors is None else f" +- {error:.2g}" for name, error in (errors or fractions).items()
    }
    return ", ".join(f"{name} {share:.4g}{bounds[name]}" for name, share in fractions.items())
