"""Numbers in what a study returns: the quantities whose effects are asked for."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionlab.analysis.steady_state.result import SteadyState

OF_STEADY_STATE = ("kind", "intensity", "period")


def numbers_of(result: Any, name: str, within: str = "") -> dict[str, float]:
    """Quantity -> number: a text is the quantity "name = text", which is 1 where it is that text.

    Parameters
    ----------
    result : number, str, None, SteadyState, or mapping of these
        None is a number that is not there.  Of anything else there are none.
    name : str
        The study's.
    within : str
        What the names of a mapping's entries begin with.
    """
    if result is None:
        return {name: float("nan")}
    if isinstance(result, str):
        return {f"{name} = {result!s}": 1.0}
    if isinstance(result, (Real, np.bool_)):
        return {name: float(result)}
    if isinstance(result, SteadyState):
        result = {key: getattr(result, key) for key in OF_STEADY_STATE}
    if not isinstance(result, Mapping):
        return {}
    entries = (numbers_of(entry, f"{within}{key}", f"{within}{key}.") for key, entry in result.items())
    return {name: number for numbers in entries for name, number in numbers.items()}


def table_of_numbers(results: Sequence[Mapping[str, float]]) -> dict[str, NDArray[np.float64]]:
    """Quantity -> numbers of all results (N,); NaN where one lacks it, 0 where it has another text."""
    names = dict.fromkeys(name for result in results for name in result)
    return {name: np.array([_entry(result, name) for result in results]) for name in names}


def _entry(result: Mapping[str, float], name: str) -> float:
    question, is_text, _ = name.partition(" = ")
    another = 0.0 if is_text and _has_text(result, question) else float("nan")
    return result.get(name, another)


def _has_text(result: Iterable[str], question: str) -> bool:
    return any(name.startswith(f"{question} = ") for name in result)
