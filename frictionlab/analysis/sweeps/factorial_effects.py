"""Effects, interactions and Shapley values of a full factorial study, with their standard errors.

A study is an array of one axis for each switch, then conditions and repetitions, of one of the numbers in
what the study returns.  Everything here is a function of its mean over repetitions.  Errors come from leaving
out one repetition after the other (jackknife), which for means is the usual standard error.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain, combinations, product
from math import factorial
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionlab.analysis.steady_state.steady_state import SteadyState
from frictionlab.analysis.sweeps.switches import Switch
from frictionlab.presentation import Drawable, dataframe, text_table

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


Array = NDArray[np.float64]
Term = tuple[tuple[int, int], ...]  # pairs of a switch and one of its levels


@dataclass(frozen=True, eq=False)
class Effects(Drawable):
    """What each switch does to a quantity, alone and together with others.

    Parameters
    ----------
    quantity : str
    switches : tuple of str
    terms : tuple of str
        Names of the effects: "geometry", "cubic x geometry"; of several alternatives "contact HertzContact".
    orders : array of int (K,)
        How many switches a term has: 1 for a main effect.
    values, errors : array (K, P)
        Main effect: the mean change of the quantity when the switch goes from its reference level (without
        the nonlinearity, the first alternative) to this level, over all levels of the others.  Interaction
        of two: how much the effect of one changes with the other, averaged likewise; of three: how much that
        changes with the third.
        Standard errors from the initial states; NaN where there is one only.  A column for each condition.
    shapley, shapley_errors : array (M, P)
        The whole change from all switches at their reference level to all at their last (with all
        nonlinearities), divided among the switches: the mean of what each adds, over all orders of switching.
    shares, share_errors : array (M, P)
        Of the variance over all scenes, the part that is due to each switch, an interaction being divided
        equally among its switches.  They sum to 1.
    used : array of int (P,)
        Initial states at which every scene has the quantity; the others are left out.
    """

    drawn_by = "plot_effects"

    quantity: str
    switches: tuple[str, ...]
    terms: tuple[str, ...]
    orders: NDArray[np.int_]
    values: Array
    errors: Array
    shapley: Array
    shapley_errors: Array
    shares: Array
    share_errors: Array
    used: NDArray[np.int_]

    def __repr__(self) -> str:
        if not self.values.size:
            return f"Effects({self.quantity}: no switch)"
        rows = [f"Effects({self.quantity}), Shapley value (share of variance):"]
        for name, value, error, share in zip(self.switches, self.shapley, self.shapley_errors, self.shares):
            rows.append(f"  {name}: {_with_error(value[0], error[0])} ({share[0]:.1%})")
        text = text_table(rows, most=6)
        more = self.values.shape[1] - 1
        return f"{text}\n  at the first of {more + 1} conditions" if more else text

    @property
    def strongest(self) -> str | None:
        """The switch with the largest share of the variance, over all conditions; None where nothing varies
        or a scene lacks the quantity.
        """
        if not np.isfinite(self.shares).any():
            return None
        return self.switches[int(np.nanmean(self.shares, axis=1).argmax())]

    def __getitem__(self, term: str) -> Array:
        """The values (P,) of an effect by its name."""
        if term not in self.terms:
            raise KeyError(f"no effect {term!r}: name one of {', '.join(self.terms)}")
        return self.values[self.terms.index(term)]

    def to_dataframe(self) -> Any:
        """One row for each effect and condition, with the Shapley value and share of single switches."""
        conditions = self.values.shape[1]
        single = {name: i for i, name in enumerate(self.switches)}

        def of_switch(table: Array) -> Array:
            rows = [table[single[t]] if t in single else np.full(conditions, np.nan) for t in self.terms]
            return np.concatenate(rows)

        columns = {
            "order": np.repeat(self.orders, conditions),
            "value": self.values.ravel(),
            "error": self.errors.ravel(),
            "shapley": of_switch(self.shapley),
            "shapley_error": of_switch(self.shapley_errors),
            "share": of_switch(self.shares),
            "share_error": of_switch(self.share_errors),
        }
        index = {
            "effect": np.repeat(self.terms, conditions),
            "condition": np.tile(np.arange(conditions), len(self.terms)),
        }
        return dataframe(columns, index, {})


def _with_error(value: float, error: float) -> str:
    return f"{value:.4g}" if np.isnan(error) else f"{value:.4g} ± {error:.2g}"


def effects_of(quantity: str, numbers: Array, switches: Sequence[Switch]) -> Effects:
    """The effects in an array (levels of each switch ..., P conditions, S repetitions)."""
    conditions = numbers.shape[-2]
    terms = list(_terms(switches))
    known = np.asarray(np.isfinite(numbers).all(axis=tuple(range(len(switches)))))
    kinds: list[Callable[[Array], Array]] = [
        lambda mean: np.array([_mixed_difference(mean, switches, term) for term in terms]),
        lambda mean: _shapley_values(mean, switches),
        _variance_shares,
    ]
    columns = [
        [_jackknife(numbers[..., p, np.flatnonzero(known[p])], kind) for kind in kinds]
        for p in range(conditions)
    ]
    tables = [[np.stack(rows, axis=-1) for rows in zip(*kind)] for kind in zip(*columns)]
    (values, errors), (shapley, shapley_errors), (shares, share_errors) = tables
    return Effects(
        quantity,
        tuple(switch.name for switch in switches),
        tuple(_term_name(term, switches) for term in terms),
        np.array([len(term) for term in terms], dtype=int),
        values,
        errors,
        shapley,
        shapley_errors,
        shares,
        share_errors,
        known.sum(axis=-1),
    )


def _terms(switches: Sequence[Switch]) -> Iterator[Term]:
    """All effects, those of few switches first."""
    places = range(len(switches))
    for chosen in chain.from_iterable(combinations(places, size) for size in range(1, len(switches) + 1)):
        for levels in product(*(switches[i].others for i in chosen)):
            yield tuple(zip(chosen, levels))


def _term_name(term: Term, switches: Sequence[Switch]) -> str:
    names = [
        switches[i].name if len(switches[i].levels) == 2 else switches[i].label(level) for i, level in term
    ]
    return " x ".join(names)


def _jackknife(numbers: Array, statistic: Callable[[Array], Array]) -> tuple[Array, Array]:
    """A function of the mean over repetitions (..., S), and its standard error."""
    count = numbers.shape[-1]
    value = statistic(numbers.mean(axis=-1) if count else np.full(numbers.shape[:-1], np.nan))
    if count < 2:
        return value, np.full(value.shape, np.nan)
    total = numbers.sum(axis=-1)
    without_one = np.array([statistic((total - numbers[..., s]) / (count - 1)) for s in range(count)])
    spread = without_one - without_one.mean(axis=0)
    return value, np.sqrt((count - 1) / count * (spread**2).sum(axis=0))


def _mixed_difference(mean: Any, switches: Sequence[Switch], term: Term) -> Any:
    """The difference along the switches of a term, averaged over the levels of the others."""
    levels = dict(term)
    for axis in reversed(range(len(switches))):
        if axis in levels:
            reference = switches[axis].reference
            mean = mean.take(levels[axis], axis) - mean.take(reference, axis)
        else:
            mean = mean.mean(axis)
    return mean


def _shapley_values(mean: Array, switches: Sequence[Switch]) -> Array:
    """phi_i = sum over S without i of |S|! (m - |S| - 1)! / m! (v(S + i) - v(S)).

    L. S. Shapley, "A value for n-person games", Contributions to the Theory of Games II, 1953.
    """
    m = len(switches)

    def value(chosen: Sequence[int]) -> float:
        return mean[tuple(s.end if i in chosen else s.reference for i, s in enumerate(switches))]

    found = np.zeros(m)
    for i in range(m):
        others = [j for j in range(m) if j != i]
        for size in range(m):
            weight = factorial(size) * factorial(m - size - 1) / factorial(m)
            found[i] += weight * sum(value((*s, i)) - value(s) for s in combinations(others, size))
    return found


def _variance_shares(mean: Array) -> Array:
    """Sum over u with i of V_u / |u| / V, with V_u the variance that the switches u have together only.

    A. B. Owen, "Sobol' indices and Shapley value", SIAM/ASA J. Uncertainty Quantification 2, 2014.
    """
    m = mean.ndim
    parts = np.zeros(m)
    for u in chain.from_iterable(combinations(range(m), size) for size in range(1, m + 1)):
        part: Any = mean
        for axis in range(m):
            average = part.mean(axis, keepdims=True)
            part = part - average if axis in u else average
        parts[list(u)] += (part**2).mean() / len(u)
    total = parts.sum()
    return parts / total if total > 0 else np.full(m, np.nan)
