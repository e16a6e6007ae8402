"""`fl.ablation`: studies of a model with every combination of its nonlinearities or other alternatives."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from operator import call
from typing import Any, Unpack

from frictionlab.analysis.options import Execution, ExecutionKeywords, settings_of
from frictionlab.analysis.steady_state.steady_state import steady_state
from frictionlab.models.model import ModelOrAutomaton, data_of, require_model_or_automaton
from frictionlab.presentation import Drawable, import_optional, text_table
from frictionlab.stability.eigenproblems.eigenvalues import eigenvalues
from frictionlab.stability.equilibrium_points.equilibria import equilibria, equilibrium
from frictionlab.stability.equilibrium_points.frozen_time import refuse_time
from frictionlab.validation import abbreviate, check_key, check_sequence, did_you_mean, explains_keywords

from .factorial_design import (
    Array,
    Effects,
    Scene,
    Switch,
    all_scenes,
    check_scene_at,
    effects_of,
    left_out,
    model_of_scene,
    numbers_of,
    scene_name,
    state_of_scene,
    switches_of,
    table_of_numbers,
)
from .function_name import function_name, own_name
from .journal import Journal
from .sweep import Grid, Sweep, axes_of, check_function, check_over, point_name

# studies of models that do not depend on the time, and what such a model has
AT_REST = {
    steady_state: "a steady state",
    **dict.fromkeys((equilibria, equilibrium, eigenvalues), "an equilibrium"),
}


@dataclass(frozen=True, eq=False)
class Ablation(Drawable):
    """Results of studies for each scene, that is for each combination of the levels of all switches.

    Parameters
    ----------
    factors : tuple of Switch
        The switches with their levels.
    scenes : tuple of tuples of int
        The level of each switch; the first scene has all nonlinearities, the last none.
    models : tuple
        The model of each scene.
    results : tuple
        For each scene what the study returned; with several studies, a mapping of their names to that; where
        parameters or initial states vary, a :class:`Sweep` of these.
    studies : tuple of str
        Names of the studies.
    """

    drawn_by = "plot_ablation"
    several_axes = True

    factors: tuple[Switch, ...]
    scenes: tuple[Scene, ...]
    models: tuple[Any, ...]
    results: tuple[Any, ...]
    studies: tuple[str, ...]

    def __getitem__(self, scene: str | tuple[str, ...] | Mapping[str, str]) -> Any:
        """The result of a scene: ``ablation["geometry"]`` without geometry, ``ablation[()]`` with all
        nonlinearities, ``ablation[{"contact": "HertzContact"}]`` by all levels that are not the first.
        """
        levels_of_scene = self._levels(scene)
        for levels, result in zip(self.scenes, self.results):
            if levels == levels_of_scene:
                return result
        raise KeyError(f"no scene {scene!r}")

    def _levels(self, scene: str | tuple[str, ...] | Mapping[str, str]) -> Scene:
        if isinstance(scene, Mapping):
            chosen = dict(scene)
        else:
            cure = "name nonlinearities, such as ablation['geometry'] or ablation[()]"
            names = (scene,) if isinstance(scene, str) else check_sequence("a scene", scene, cure)
            for name in names:
                check_key("switch", name, self.switches)
            chosen = dict.fromkeys(names, "without")
        levels = []
        for switch in self.factors:
            level = chosen.pop(switch.name, switch.levels[0])
            if level not in switch.levels:
                raise KeyError(
                    f"{switch.name} has no level {abbreviate(level)}: name one of {', '.join(switch.levels)}"
                )
            levels.append(switch.levels.index(level))
        if chosen:
            raise KeyError(
                f"no scene lacks {abbreviate(list(chosen))}: name some of {', '.join(self.switches)}"
            )
        return tuple(levels)

    @property
    def switches(self) -> tuple[str, ...]:
        """Names of the switches."""
        return tuple(switch.name for switch in self.factors)

    @property
    def without(self) -> tuple[tuple[str, ...], ...]:
        """The nonlinearities that each scene lacks."""
        return tuple(left_out(self.factors, scene) for scene in self.scenes)

    @property
    def names(self) -> tuple[str, ...]:
        """A name in words for each scene."""
        return tuple(scene_name(self.factors, scene) for scene in self.scenes)

    def __iter__(self) -> Iterator[tuple[tuple[str, ...], Any]]:
        return iter(zip(self.without, self.results, strict=True))

    def __str__(self) -> str:
        rows = list(zip(self.names, map(_result_text, self.results)))
        width = max((len(name) for name, _ in rows), default=0)
        return text_table(f"{name:{width}}  {result}" for name, result in rows)

    __repr__ = __str__

    @property
    def conditions(self) -> Sweep | None:
        """A Sweep with the parameters and initial states of every scene; None where none vary."""
        return next((result for result in self.results if isinstance(result, Sweep)), None)

    @property
    def quantities(self) -> tuple[str, ...]:
        """Names of all numbers in the results.  A single number has the name of its study; a text becomes a
        quantity such as "kind = periodic", which is 1 where that is the text, else 0.
        """
        return tuple(self._numbers)

    @cached_property
    def _numbers(self) -> dict[str, Array]:
        cells = [cell for result in self.results for cell in _cells(result)]
        return table_of_numbers([self._cell_numbers(cell) for cell in cells])

    def _cell_numbers(self, cell: Any) -> dict[str, float]:
        if cell is None or len(self.studies) == 1:
            return {} if cell is None else numbers_of(cell, self.studies[0])
        by_study = (numbers_of(result, study, f"{study}.") for study, result in cell.items())
        return {name: number for numbers in by_study for name, number in numbers.items()}

    def numbers(self, quantity: str | None = None) -> Array:
        """A quantity in all scenes, as (scenes, conditions, initial states).

        Parameters
        ----------
        quantity : str or None
            One of `quantities`; None where there is only one.

        Raises
        ------
        ValueError
            For an unknown name, or for None where there are several.
        """
        name = self._quantity(quantity)
        sweep = self.conditions
        starts = 1 if sweep is None else len(sweep.x0) or 1
        return self._numbers[name].reshape(len(self.scenes), -1, starts)

    def _quantity(self, quantity: str | None) -> str:
        names = self.quantities
        if quantity is None and len(names) == 1:
            return names[0]
        if not isinstance(quantity, str) or quantity not in names:
            hint = did_you_mean(quantity, names) if isinstance(quantity, str) else ": name one"
            raise ValueError(
                f"quantity must be one of {', '.join(map(repr, names)) or 'none: no result holds a number'}, "
                f"got {abbreviate(quantity)}{hint}"
            )
        return quantity

    def effects(self, quantity: str | None = None) -> Effects:
        """Main effects, interactions, Shapley values and shares of the variance.

        They are means over the initial states, whose scatter gives the standard errors; there is a column for
        each combination of parameters.

        Parameters
        ----------
        quantity : str or None
            As for :meth:`numbers`.

        Returns
        -------
        Effects

        Examples
        --------
        >>> import frictionlab as fl
        >>> def critical(model):
        ...     return fl.critical_value(model, "mu_k", (0, 4))
        >>> ablation = fl.ablation(fl.SliderOnBelt(), critical, progress=False)
        >>> ablation.effects().strongest
        'geometry'
        """
        name, numbers = self._quantity(quantity), self.numbers(quantity)
        levels = [len(switch.levels) for switch in self.factors]
        return effects_of(name, numbers.reshape(*levels, *numbers.shape[1:]), self.factors)

    def leave_one_out(self, quantity: str | None = None) -> dict[str, float]:
        """How much a quantity changes if one switch alone leaves its first level, the largest change first.

        A switch with -1 in ``ablation.leave_one_out("kind = non-periodic")`` ends all such motion.  Changes
        are means over parameters and initial states; `quantity` is as for :meth:`numbers`.
        """
        means = dict(zip(self.scenes, self.numbers(quantity).mean(axis=(1, 2)).tolist()))
        first = (0,) * len(self.factors)
        others = [
            (i, level) for i, switch in enumerate(self.factors) for level in range(1, len(switch.levels))
        ]
        changes = {
            self.factors[i].label(level): means[(*first[:i], level, *first[i + 1 :])] - means[first]
            for i, level in others
        }
        return dict(sorted(changes.items(), key=lambda item: -abs(item[1])))

    def to_dataframe(self) -> Any:
        """One row for each scene and condition, a column for each switch and quantity (needs ``data``)."""
        pd = import_optional("pandas", "to_dataframe")
        axes = {} if self.conditions is None else axes_of(self.conditions)
        points = list(product(*axes.values()))
        rows = [(*self._level_names(scene), *point) for scene in self.scenes for point in points]
        index = pd.MultiIndex.from_tuples(rows, names=[*self.switches, *axes])
        return pd.DataFrame(self._numbers, index=index)

    def _level_names(self, scene: Scene) -> tuple[str, ...]:
        return tuple(switch.levels[level] for switch, level in zip(self.factors, scene))


def _cells(result: Any) -> list[Any]:
    """What the studies returned for a scene, an entry for each condition."""
    return list(result.results.ravel()) if isinstance(result, Sweep) else [result]


def _result_text(result: Any) -> str:
    if isinstance(result, Mapping):
        return ", ".join(f"{name} {value}" for name, value in result.items())
    return str(result)


@explains_keywords
def ablation(
    model: ModelOrAutomaton,
    studies: Callable[..., Any] | Mapping[str, Callable[..., Any]],
    switches: Any = None,
    *,
    over: Mapping[str, Any] | None = None,
    x0: Sequence[Any] = (),
    **keywords: Unpack[ExecutionKeywords],
) -> Ablation:
    """Study a model with every combination of its nonlinearities, or of other alternatives.

    This is a full factorial design.  A SliderOnBelt has eight scenes, with the cubic contact, the non-smooth
    behaviours and the moving load each on or off.  :meth:`Ablation.effects` tells what each does, alone and
    together with others.

    Where a system has several attractors, a difference of two scenes from one initial state tells nothing of
    a nonlinearity.  Give many initial states: effects are then means, with standard errors.

    Parameters
    ----------
    model : Model or HybridAutomaton
        With all of its nonlinearities.
    studies : callable, or mapping of str to callable
        Called as ``study(model)``, or ``study(model, start)`` where `x0` is given: ``fl.steady_state``, or
        functions of your own.  Effects are known for numbers, texts, mappings of these, and steady states.
    switches : None, sequence of str, or mapping
        None takes all :attr:`~Model.nonlinearities`, a sequence names some of them; "nonsmooth" is none where
        a belt is at rest, as sliding friction has no direction there.  A mapping gives each
        switch its alternatives, the first being the reference: components or numbers for the field of that
        name, or mappings of arguments of ``replace``.  They are a list, or a mapping of labels to them.
        None in their place stands for a nonlinearity, on and off.  An automaton has no nonlinearities by
        name, so it wants a mapping, of values for its parameters.
    over : mapping of str to array_like
        Parameters and values; each scene is studied at all combinations of them.
    x0 : sequence
        Initial states: names, mappings, or arrays (2n,) for the full model.  Coordinates that a scene lacks
        are left out.
    **keywords
        As for :func:`sweep`: ``workers=2``.

    Returns
    -------
    Ablation

    Raises
    ------
    TypeError
        Where an argument is no model or function, or a keyword is unknown.
    ValueError
        For unknown switches, a bad value or initial state, an impossible scene, another ablation's file.
    OSError
        Where the file cannot be written, or another ablation is using it.
    RuntimeError
        Where the study of a scene fails, raised from its error; the results before it are in the file.
    KeyboardInterrupt
        After ctrl-C; :func:`partial_result` then returns the Ablation, None for scenes that were not done.

    Examples
    --------
    >>> import frictionlab as fl
    >>> ablation = fl.ablation(fl.SliderOnBelt(), lambda m: fl.critical_value(m, "mu_k", (0, 4)))
    >>> ablation["geometry"] > ablation[()]
    True
    >>> laws = {"contact": [fl.LinearContact(), fl.CubicContact(), fl.HertzContact()], "geometry": None}
    >>> forces = fl.ablation(fl.SliderOnBelt(), lambda m: fl.equilibrium(m).normal_force, laws)
    >>> len(forces.results)
    6
    """
    cure = "write ablation(model, study), the model made, such as fl.SliderOnBelt()"
    require_model_or_automaton(model, cure)
    by_name = _studies_by_name(studies)
    for study, what in AT_REST.items():
        if any(study is one for one in by_name.values()):
            refuse_time(model, what)
    (how,) = settings_of("ablation", keywords, Execution)
    factors = switches_of(model, switches)
    starts = check_sequence("x0", x0, "give initial states in a list")
    plan = _Plan(model, factors, Grid({} if over is None else check_over(over), starts))
    specification = {} if how.resume is None else plan.specification(by_name)
    tasks, names = plan.tasks(by_name)
    with Journal(specification, how.resume) as journal:
        journal.run_tasks(call, tasks, names.__getitem__, how, "ablation")
        results = [journal.results.get(i) for i in range(len(tasks))]
        return journal.finish(plan.ablation(results, tuple(by_name)), len(tasks))


def _studies_by_name(studies: Any) -> dict[str, Callable[..., Any]]:
    """The studies by name."""
    by_name = dict(studies) if isinstance(studies, Mapping) else {own_name(studies): studies}
    if not by_name:
        raise ValueError('studies must be one at least, got none: give {"onset": a function of a model}')
    for study in by_name.values():
        check_function(
            "studies" if isinstance(studies, Mapping) else "study", study, "give one such as fl.steady_state"
        )
    return {str(name): study for name, study in by_name.items()}


@dataclass(frozen=True)
class _Plan:
    """Which models are studied at which parameters and from which initial states."""

    model: ModelOrAutomaton
    factors: tuple[Switch, ...]
    grid: Grid

    @cached_property
    def scenes(self) -> tuple[Scene, ...]:
        return all_scenes(self.factors)

    @cached_property
    def models(self) -> tuple[Any, ...]:
        return tuple(model_of_scene(self.model, self.factors, scene) for scene in self.scenes)

    def tasks(self, studies: Mapping[str, Any]) -> tuple[list[tuple[Any, ...]], list[str]]:
        """Tasks of study, model and initial state, and their names; studies vary fastest, then states."""
        tasks, names = [], []
        for scene, model in zip(self.scenes, self.models):
            starts = [
                tuple(state_of_scene(model, self.model, x) for x in start) for start in self.grid.starts()
            ]
            for changes in self.grid.points():
                here = model.replace(**changes) if changes else model
                check_scene_at(self.model, self.factors, scene, changes)
                words = f"the scene {scene_name(self.factors, scene)}"
                for start, study in product(starts, studies.values()):
                    tasks.append((study, here, *start))
                    names.append(f"{words}, {point_name(changes)}" if changes else words)
        return tasks, names

    def specification(self, studies: Mapping[str, Any]) -> dict[str, Any]:
        """What tells the files of different ablations apart."""
        return {
            "ablation": {name: function_name(study) for name, study in studies.items()},
            "model": data_of(self.model),
            "scenes": [data_of(model) for model in self.models],
            **self.grid.specification(),
        }

    def ablation(self, results: list[Any], studies: tuple[str, ...]) -> Ablation:
        """The results of all tasks, sorted by scene."""
        count = len(studies)
        cells = [
            dict(zip(studies, results[i : i + count])) if count > 1 else results[i]
            for i in range(0, len(results), count)
        ]
        per_scene = len(cells) // len(self.scenes)
        groups = [cells[i : i + per_scene] for i in range(0, len(cells), per_scene)]
        function = ", ".join(studies)
        varies = self.grid.over or self.grid.x0
        sweeps = tuple(
            self.grid.sweep(group, model, function) if varies else group[0]
            for model, group in zip(self.models, groups)
        )
        return Ablation(self.factors, self.scenes, self.models, sweeps, studies)
