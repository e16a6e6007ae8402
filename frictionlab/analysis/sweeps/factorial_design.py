"""Full factorial designs: switches, scenes, and the effects of switches with their standard errors.

The effects are main effects, interactions, Shapley values and shares of the variance.  They are computed from
an array of one quantity, with one axis for each switch, one for conditions and one for repetitions (initial
states), as functions of its mean over repetitions.  Errors come from leaving out one repetition after the
other (jackknife), which for means gives the usual standard error.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain, combinations, product
from math import factorial
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionlab.analysis.initial_states import initial_state_of
from frictionlab.analysis.steady_state.steady_state import SteadyState
from frictionlab.components.component import Component
from frictionlab.models.composition import nonlinearities_of
from frictionlab.models.model import Model, ModelOrAutomaton, automaton_of
from frictionlab.presentation import Drawable, dataframe, text_table
from frictionlab.validation import (
    abbreviate,
    check_key,
    check_mapping,
    did_you_mean,
    is_sequence,
    with_article,
)

Array = NDArray[np.float64]
Scene = tuple[int, ...]  # one level for each switch
Term = tuple[tuple[int, int], ...]  # pairs of a switch and one of its levels
WITH, WITHOUT = "with", "without"  # the two levels of a nonlinearity
OF_STEADY_STATE = ("kind", "intensity", "period")


@dataclass(frozen=True)
class Switch:
    """A place in a model that has several alternatives.

    Parameters
    ----------
    name : str
    levels : tuple of str
        Names of the alternatives: "with" and "without" for a nonlinearity.
    changes : tuple of mappings, or None
        Arguments of ``replace`` for each level; None for a nonlinearity, which ``without`` removes.
    reference : int
        The level that effects are counted from: "without", or the first alternative.
    end : int
        The level at the other end, to which Shapley values go: "with", or the last alternative.
    """

    name: str
    levels: tuple[str, ...]
    changes: tuple[Mapping[str, Any], ...] | None
    reference: int
    end: int

    @property
    def others(self) -> list[int]:
        """The levels that have an effect: all but the reference."""
        return [level for level in range(len(self.levels)) if level != self.reference]

    def label(self, level: int) -> str:
        """A level in words: "contact HertzContact", "without geometry"."""
        words = self.levels[level], self.name
        return " ".join(words if self.changes is None else reversed(words))


def switches_of(model: ModelOrAutomaton, switches: Any) -> tuple[Switch, ...]:
    """The switches that `fl.ablation` was asked for; all nonlinearities where `switches` is None.

    Raises
    ------
    TypeError
        Where `switches` is neither a sequence of names nor a mapping.
    ValueError
        For an unknown name, or fewer than two alternatives.
    """
    if switches is None:
        if not isinstance(model, Model):
            raise ValueError(
                f"switches must be a mapping of parameters of {with_article(type(model))}, which has no "
                "nonlinearities by name, got none: give parameters their alternatives, such as "
                '{"k": [0.0, 1.0]}'
            )
        return tuple(_on_off(name) for name in model.nonlinearities)
    if not isinstance(switches, Mapping) and not is_sequence(switches):
        raise TypeError(
            "switches must be names of nonlinearities or a mapping of names to alternatives, got "
            f'{abbreviate(switches)}: write ["cubic"] '
            'or {"contact": [fl.LinearContact(), fl.CubicContact()]}'
        )
    if isinstance(switches, Mapping):
        check_mapping("switches", switches, "write {'contact': [fl.LinearContact(), fl.CubicContact()]}")
        alternatives = switches
    else:
        alternatives = {_check_nonlinearity(model, name): None for name in switches}
    if not alternatives:
        raise ValueError("switches must name one at least, got none: leave it out for all nonlinearities")
    return tuple(
        _on_off(_check_nonlinearity(model, n)) if a is None else _alternatives(model, n, a)
        for n, a in alternatives.items()
    )


def _check_nonlinearity(model: ModelOrAutomaton, name: Any) -> str:
    of_model = model if isinstance(model, Model) else None
    names = () if of_model is None else tuple(of_model.nonlinearities)
    if not isinstance(name, str) or name not in names:
        if of_model is not None and isinstance(name, str) and name in nonlinearities_of(of_model):
            of_model.without(name)  # it says why the model cannot be without
        hint = did_you_mean(name, names) if isinstance(name, str) else ""
        raise ValueError(
            f"switches must be nonlinearities of {type(model).__name__} "
            f"({', '.join(names) or 'it has none'}) or have alternatives, "
            f"got {abbreviate(name)}{hint or ': give it a list of alternatives'}"
        )
    return name


def _on_off(name: str) -> Switch:
    return Switch(name, (WITH, WITHOUT), None, reference=1, end=0)


def _alternatives(model: ModelOrAutomaton, name: str, levels: Any) -> Switch:
    if isinstance(levels, (str, Component)) or not isinstance(levels, (Mapping, Sequence)) or len(levels) < 2:
        raise ValueError(
            f"switches[{abbreviate(name)}] must be two levels at least, "
            f"got {abbreviate(levels)}: give a list, or a mapping "
            "of a label to each"
        )
    values = list(levels.values()) if isinstance(levels, Mapping) else list(levels)
    labels = [str(label) for label in levels] if isinstance(levels, Mapping) else _labels(values)
    for value in values:
        if isinstance(value, Mapping):
            check_mapping(
                f"an alternative of switches[{abbreviate(name)}]", value, "name parameters or components"
            )
    changes = tuple(dict(value) if isinstance(value, Mapping) else {name: value} for value in values)
    for change in changes:
        model.replace(**change)  # raises for impossible values before any work is done
    return Switch(name, tuple(labels), changes, reference=0, end=len(values) - 1)


def _labels(values: Sequence[Any]) -> list[str]:
    """Labels of alternatives: class names of components where these differ, else their texts."""
    classes = [type(value).__name__ for value in values]
    if all(isinstance(value, Component) for value in values) and len({*classes}) == len(classes):
        return classes
    return [_changes_text(value) if isinstance(value, Mapping) else str(value) for value in values]


def _changes_text(changes: Mapping[str, Any]) -> str:
    return ", ".join(f"{name}={value}" for name, value in changes.items()) or "as it is"


def all_scenes(switches: Sequence[Switch]) -> tuple[Scene, ...]:
    """Every combination of levels; the last switch varies fastest."""
    return tuple(product(*(range(len(switch.levels)) for switch in switches)))


def model_of_scene(model: Any, switches: Sequence[Switch], scene: Scene) -> Any:
    """The model with one level of each switch."""
    changes: dict[str, Any] = {}
    for switch, level in zip(switches, scene, strict=True):
        changes |= {} if switch.changes is None else switch.changes[level]
    variant = model.replace(**changes) if changes else model
    lacks = left_out(switches, scene)
    return variant.without(*lacks) if lacks else variant


def check_scene_at(
    model: ModelOrAutomaton, switches: Sequence[Switch], scene: Scene, at: Mapping[str, float]
) -> None:
    """Raise ValueError where a scene cannot lack a nonlinearity at these values, as on a belt at rest."""
    lacks = left_out(switches, scene)
    if lacks and at:
        complete = [0 if switch.changes is None else level for switch, level in zip(switches, scene)]
        model_of_scene(model, switches, tuple(complete)).replace(**at).without(*lacks)


def left_out(switches: Sequence[Switch], scene: Scene) -> tuple[str, ...]:
    """The nonlinearities that a scene lacks."""
    return tuple(
        s.name for s, level in zip(switches, scene) if s.changes is None and s.levels[level] == WITHOUT
    )


def scene_name(switches: Sequence[Switch], scene: Scene) -> str:
    """A scene in words: "with all three", "without geometry", "contact HertzContact, without geometry"."""
    without = left_out(switches, scene)
    labels = [s.label(level) for s, level in zip(switches, scene) if s.changes is not None]
    if not without and not labels:
        return f"{WITH} {all_of(len(switches))}"
    return ", ".join([*labels, *([f"{WITHOUT} {', '.join(without)}"] if without else [])])


def all_of(count: int) -> str:
    """The words for all of `count` nonlinearities."""
    return {1: "it", 2: "both", 3: "all three"}.get(count, "all")


def state_of_scene(model: ModelOrAutomaton, full: Any, start: Any) -> Any:
    """An initial state of the full model, for a scene that may lack some of its coordinates."""
    whole = initial_state_of(full, start)
    if isinstance(start, str):
        return start
    names = list(automaton_of(full).state_names)
    by_name = start if isinstance(start, Mapping) else dict(zip(names, whole.tolist()))
    state_names = set(automaton_of(model).state_names)
    return {name: value for name, value in by_name.items() if name in state_names}


def numbers_of(result: Any, name: str, within: str = "") -> dict[str, float]:
    """The quantities, by name, in the result of the study `name`.

    A text gives the quantity "name = text", which is 1; None gives NaN.  A mapping gives those of its
    entries, whose names begin with `within`; anything else gives none.
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
    """Each quantity's numbers (N,) in all results; NaN where one lacks it, 0 where it has another text."""
    names = dict.fromkeys(name for result in results for name in result)
    return {name: np.array([_entry(result, name) for result in results]) for name in names}


def _entry(result: Mapping[str, float], name: str) -> float:
    question, is_text, _ = name.partition(" = ")
    has_text = is_text and any(other.startswith(f"{question} = ") for other in result)
    return result.get(name, 0.0 if has_text else float("nan"))


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
        Standard errors come from several initial states, else they are NaN.  A column for each condition.
    shapley, shapley_errors : array (M, P)
        The whole change from all switches at their reference level to all at their last (with all
        nonlinearities), divided among the switches: the mean of what each adds, over all orders of switching.
    shares, share_errors : array (M, P)
        Of the variance over all scenes, the part that is due to each switch, an interaction being divided
        equally among its switches.  They sum to 1.
    used : array of int (P,)
        Number of initial states from which every scene has the quantity; the others are left out.
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
            rows.append(f"  {name}: {_value_and_share(value[0], error[0], share[0])}")
        text = text_table(rows, most=6)
        more = self.values.shape[1] - 1
        return f"{text}\n  at the first of {more + 1} conditions" if more else text

    @property
    def strongest(self) -> str | None:
        """The switch with the largest mean share of the variance over all conditions; None where nothing
        varies or a scene lacks the quantity.
        """
        if not np.isfinite(self.shares).any():
            return None
        return self.switches[int(np.nanmean(self.shares, axis=1).argmax())]

    def __getitem__(self, term: str) -> Array:
        """The values (P,) of an effect by its name."""
        check_key("effect", term, self.terms)
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
        effects, places = np.repeat(self.terms, conditions), np.tile(np.arange(conditions), len(self.terms))
        return dataframe(columns, {"effect": effects, "condition": places}, {})


def _value_and_share(value: float, error: float, share: float) -> str:
    if not np.isfinite(value):
        return "unknown, as a scene lacks it"
    about = f"{share:.1%}" if np.isfinite(share) else "nothing varies"
    return f"{_with_error(value, error)} ({about})"


def _with_error(value: float, error: float) -> str:
    return f"{value:.4g}" if np.isnan(error) else f"{value:.4g} ± {error:.2g}"


def effects_of(quantity: str, numbers: Array, switches: Sequence[Switch]) -> Effects:
    """The effects in an array (levels of each switch, ..., P conditions, S repetitions)."""
    conditions = numbers.shape[-2]
    terms = list(_terms(switches))
    finite = np.asarray(np.isfinite(numbers).all(axis=tuple(range(len(switches)))))
    kinds: list[Callable[[Array], Array]] = [
        lambda mean: np.array([_mixed_difference(mean, switches, term) for term in terms]),
        lambda mean: _shapley_values(mean, switches),
        _variance_shares,
    ]
    columns = [
        [_jackknife(numbers[..., p, np.flatnonzero(finite[p])], kind) for kind in kinds]
        for p in range(conditions)
    ]
    tables = [[np.stack(rows, axis=-1) for rows in zip(*kind)] for kind in zip(*columns)]
    names = tuple(switch.name for switch in switches)
    term_names = tuple(_term_name(term, switches) for term in terms)
    orders = np.array([len(term) for term in terms], dtype=int)
    return Effects(quantity, names, term_names, orders, *chain(*tables), used=finite.sum(axis=-1))


def _terms(switches: Sequence[Switch]) -> Iterator[Term]:
    """All effects, those of few switches first."""
    places = range(len(switches))
    for subset in chain.from_iterable(combinations(places, size) for size in range(1, len(switches) + 1)):
        for levels in product(*(switches[i].others for i in subset)):
            yield tuple(zip(subset, levels))


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

    def value(subset: Sequence[int]) -> float:
        return mean[tuple(s.end if i in subset else s.reference for i, s in enumerate(switches))]

    values = np.zeros(m)
    for i in range(m):
        others = [j for j in range(m) if j != i]
        for size in range(m):
            weight = factorial(size) * factorial(m - size - 1) / factorial(m)
            values[i] += weight * sum(value((*s, i)) - value(s) for s in combinations(others, size))
    return values


def _variance_shares(mean: Array) -> Array:
    """Sum over u with i of V_u / |u| / V; V_u is the variance due to the interaction of exactly u.

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
