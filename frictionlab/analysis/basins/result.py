"""Basins of attraction and shares of attractors, as `fl.basins` and `fl.basin_stability` return them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from frictionlab.analysis.motion_scales import Array
from frictionlab.analysis.sweeps.journal import read_journal, write_journal
from frictionlab.drawable import Drawable
from frictionlab.file_writing import name_written_file
from frictionlab.presentation import shorten

from .attractors import (
    UNDECIDED,
    Attractor,
    AttractorCatalogue,
    attractor_scale,
    name_attractors,
    transient_ranges,
)


@dataclass(frozen=True, eq=False)
class LabelledStates(Drawable):
    """Initial states, each with the attractor it goes to; the base of both results."""

    labels: np.ndarray
    attractors: tuple[Attractor, ...]
    names: tuple[str, ...]
    specification: dict[str, Any]
    results: dict[int, Any]

    @property
    def fractions(self) -> dict[str, float]:
        """Share p of the initial states that goes to each attractor, by its name."""
        done = max(1, int((self.labels != UNDECIDED).sum()))
        return {a.name: float((self.labels == i).sum()) / done for i, a in enumerate(self.attractors)}

    def save(self, path: str | Path) -> Path:
        """Write the result as JSON lines: what :func:`load_basins` reads and `resume` continues."""
        with name_written_file(path):
            return write_journal(path, self.specification, self.results)


@dataclass(frozen=True, eq=False)
class Basins(LabelledStates):
    """Basins of attraction in a plane of initial states.

    Parameters
    ----------
    x, y : str
        Names of the states that vary.
    x_values, y_values : array (N,), (M,)
    labels : int array (M, N)
        Index of the attractor that each initial state goes to; -1 where that was not computed.
    attractors : tuple of Attractor
        In the order in which they were found.
    names : tuple of str
        Names of all states.
    specification : mapping
        All that determines the result.
    results : mapping of int to mapping
        What was computed, by task.
    """

    drawn_by = "plot_basins"

    x: str
    y: str
    x_values: Array
    y_values: Array

    def __repr__(self) -> str:
        return f"Basins({self.x}, {self.y}: {_fractions_text(self.fractions)})"


@dataclass(frozen=True, eq=False)
class BasinStability(LabelledStates):
    """Shares of random initial states that go to each attractor.

    Parameters
    ----------
    ranges : mapping of str to (float, float)
    points : array (N, k)
        Initial values of the states in `ranges`.
    labels : int array (N,)
        Index of the attractor that each goes to; -1 where that was not computed.
    attractors, names, specification, results
        As :class:`Basins`.
    """

    drawn_by = "plot_basin_stability"

    ranges: dict[str, tuple[float, float]]
    points: Array

    @property
    def errors(self) -> dict[str, float]:
        """Standard error of each share, sqrt(p (1 - p)/N)."""
        count = max(1, int((self.labels != UNDECIDED).sum()))
        return {name: float(np.sqrt(p * (1.0 - p) / count)) for name, p in self.fractions.items()}

    def __repr__(self) -> str:
        return f"BasinStability({_fractions_text(self.fractions, self.errors)})"


def load_basins(path: str | Path) -> Basins | BasinStability:
    """A result that `save`, or `resume`, wrote.

    Raises
    ------
    ValueError
        If the file is none.
    """
    specification, results = read_journal(path)
    if not {"coordinates", "probes", "group"} <= specification.keys():
        raise ValueError(f"{path} must be a file of basins, and is one of another sweep: give another path")
    return (
        basins_from_results(specification, results)
        if "x" in specification
        else basin_stability_from_results(specification, results)
    )


def basins_from_results(specification: dict[str, Any], results: dict[int, Any]) -> Basins:
    labels, attractors = _collect_labels(specification, results)
    x, y = specification["x"], specification["y"]
    return Basins(
        x=x["name"],
        y=y["name"],
        x_values=np.array(x["values"]),
        y_values=np.array(y["values"]),
        labels=labels.reshape(len(y["values"]), len(x["values"])),
        attractors=attractors,
        names=tuple(specification["states"]),
        specification=specification,
        results=results,
    )


def basin_stability_from_results(specification: dict[str, Any], results: dict[int, Any]) -> BasinStability:
    labels, attractors = _collect_labels(specification, results)
    ranges = {name: (low, high) for name, (low, high) in specification["ranges"].items()}
    return BasinStability(
        ranges=ranges,
        points=random_initial_values(ranges, specification["samples"], specification["seed"]),
        labels=labels,
        attractors=attractors,
        names=tuple(specification["states"]),
        specification=specification,
        results=results,
    )


def random_initial_values(ranges: dict[str, tuple[float, float]], samples: int, seed: int) -> Array:
    """Random initial values (samples, k), uniform in the ranges."""
    low, high = np.array(list(ranges.values())).T
    return np.random.default_rng(seed).uniform(low, high, (samples, len(ranges)))


def _collect_labels(
    specification: dict[str, Any], results: dict[int, Any]
) -> tuple[np.ndarray, tuple[Attractor, ...]]:
    """Labels of all initial states, and the attractors: those of the probes, then those of each group."""
    probes, group = specification["probes"], specification["group"]
    probed = [results[i] for i in range(probes) if i in results]
    catalogue = AttractorCatalogue(
        attractor_scale(probed, transient_ranges(probed), specification["coordinates"]), specification["rtol"]
    )
    places = [catalogue.place(found) for found in probed]
    known, labels = len({*places}), np.full(specification["count"], UNDECIDED)
    for i in sorted(i for i in results if i >= probes):
        index = np.array([*range(known), *(catalogue.place(found) for found in results[i]["found"])])
        first = (i - probes) * group
        labels[first : first + group] = index[results[i]["labels"]]
    return labels, name_attractors(catalogue.found)


def _fractions_text(fractions: dict[str, float], errors: dict[str, float] | None = None) -> str:
    bounds = {
        name: "" if errors is None else f" +- {error:.2g}" for name, error in (errors or fractions).items()
    }
    return shorten(f"{name} {share:.4g}{bounds[name]}" for name, share in fractions.items())
