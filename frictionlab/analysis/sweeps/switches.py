"""The switches of an ablation: what a model can have in one place, and all combinations of it, the scenes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

from frictionlab.analysis.simulate import initial_state_of
from frictionlab.components.component import Component
from frictionlab.validation import did_you_mean

WITH, WITHOUT = "with", "without"  # the two levels of a nonlinearity


@dataclass(frozen=True)
class Switch:
    """A place in a model that has several alternatives.

    Parameters
    ----------
    name : str
    levels : tuple of str
        Names of the alternatives: "with" and "without" for a nonlinearity.
    changes : tuple of mappings, or None
        What ``replace`` is given for each level; None for a nonlinearity, which ``without`` takes away.
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
        """Words for a level: "contact HertzContact", "without geometry"."""
        if self.changes is None:
            return f"{self.levels[level]} {self.name}"
        return f"{self.name} {self.levels[level]}"


Scene = tuple[int, ...]  # one level for each switch


def switches_of(model: Any, switches: Any = None) -> tuple[Switch, ...]:
    """The switches that `fl.ablation` was asked for; all nonlinearities where it was asked for none.

    Raises
    ------
    TypeError
        For what is neither names nor a mapping.
    ValueError
        For an unknown name, or fewer than two alternatives.
    """
    known = model.nonlinearities
    if switches is None:
        return tuple(_on_off(name) for name in known)
    if isinstance(switches, str) or not isinstance(switches, (Mapping, Sequence)):
        raise TypeError(
            "switches must be names of nonlinearities or a mapping of names to alternatives, got "
            f'{switches!r}: write ["cubic"] or {{"contact": [fl.LinearContact(), fl.CubicContact()]}}'
        )
    asked = switches if isinstance(switches, Mapping) else dict.fromkeys(switches)
    if not asked:
        raise ValueError("switches must name one at least, got none: leave it out for all nonlinearities")
    return tuple(
        _on_off(_known(model, n)) if a is None else _alternatives(model, n, a) for n, a in asked.items()
    )


def _known(model: Any, name: Any) -> str:
    known = tuple(model.nonlinearities)
    if name not in known:
        hint = did_you_mean(name, known) if isinstance(name, str) else ""
        raise ValueError(
            f"switches must be nonlinearities of {type(model).__name__} "
            f"({', '.join(known) or 'it has none'}) or have alternatives, "
            f"got {name!r}{hint or ': give it a list of alternatives'}"
        )
    return name


def _on_off(name: str) -> Switch:
    return Switch(name, (WITH, WITHOUT), None, reference=1, end=0)


def _alternatives(model: Any, name: str, given: Any) -> Switch:
    if isinstance(given, (str, Component)) or not isinstance(given, (Mapping, Sequence)) or len(given) < 2:
        raise ValueError(
            f"switches[{name!r}] must be two alternatives at least, got {given!r}: give a list, or a mapping "
            "of a label to each"
        )
    values = list(given.values()) if isinstance(given, Mapping) else list(given)
    labels = [str(label) for label in given] if isinstance(given, Mapping) else _labels(values)
    changes = tuple(dict(value) if isinstance(value, Mapping) else {name: value} for value in values)
    for change in changes:
        model.replace(**change)  # refuses what cannot be before any work is done
    return Switch(name, tuple(labels), changes, reference=0, end=len(values) - 1)


def _labels(values: Sequence[Any]) -> list[str]:
    """Class names of components where these differ; else as they print."""
    classes = [type(value).__name__ for value in values]
    if all(isinstance(value, Component) for value in values) and len({*classes}) == len(classes):
        return classes
    return [_changes_text(value) if isinstance(value, Mapping) else str(value) for value in values]


def _changes_text(changes: Mapping[str, Any]) -> str:
    return ", ".join(f"{name}={value}" for name, value in changes.items()) or "as it is"


def all_scenes(switches: Sequence[Switch]) -> tuple[Scene, ...]:
    """Every combination of levels; the last switch changes first."""
    return tuple(product(*(range(len(switch.levels)) for switch in switches)))


def model_of_scene(model: Any, switches: Sequence[Switch], scene: Scene) -> Any:
    """The model with one level of each switch."""
    changes: dict[str, Any] = {}
    for switch, level in zip(switches, scene, strict=True):
        changes |= {} if switch.changes is None else switch.changes[level]
    changed = model.replace(**changes) if changes else model
    return changed.without(*left_out(switches, scene))


def left_out(switches: Sequence[Switch], scene: Scene) -> tuple[str, ...]:
    """The nonlinearities that a scene lacks."""
    return tuple(
        s.name for s, level in zip(switches, scene) if s.changes is None and s.levels[level] == WITHOUT
    )


def scene_name(switches: Sequence[Switch], scene: Scene) -> str:
    """Words for a scene: "with all three", "without geometry", "contact HertzContact, without geometry"."""
    without = left_out(switches, scene)
    chosen = [s.label(level) for s, level in zip(switches, scene) if s.changes is not None]
    if not without and not chosen:
        return f"{WITH} {all_of(len(switches))}"
    return ", ".join([*chosen, *([f"{WITHOUT} {', '.join(without)}"] if without else [])])


def all_of(count: int) -> str:
    """Words for all of so many nonlinearities."""
    return {1: "it", 2: "both", 3: "all three"}.get(count, "all")


def state_of_scene(model: Any, full: Any, start: Any) -> Any:
    """An initial state of the full model, for a scene that may lack some of its coordinates."""
    whole = initial_state_of(full, start)
    if isinstance(start, str):
        return start
    names = list(full.automaton().state_names)
    given = start if isinstance(start, Mapping) else dict(zip(names, whole.tolist()))
    known = set(model.automaton().state_names)
    return {name: value for name, value in given.items() if name in known}
