"""`fl.ablation`: one study of a model with every combination of its nonlinearities on and off."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import compress, product
from typing import Any, Unpack

from frictionlab.analysis.options import Execution, ExecutionKeywords, merge_keywords
from frictionlab.drawable import Drawable
from frictionlab.models.coercion import require_model
from frictionlab.presentation import text_table

from .journal import Journal
from .task_runner import check_function, function_name, run_tasks


@dataclass(frozen=True, eq=False)
class Ablation(Drawable):
    """The results of a study for each combination of nonlinearities: eight scenes for three of them.

    Parameters
    ----------
    without : tuple of tuples of str
        The nonlinearities that each scene lacks; the first lacks none, the last all.
    models : tuple
    results : tuple
        The results that the study returned.
    """

    drawn_by = "plot_ablation"
    several_axes = True

    without: tuple[tuple[str, ...], ...]
    models: tuple[Any, ...]
    results: tuple[Any, ...]

    def __getitem__(self, without: str | tuple[str, ...]) -> Any:
        """The result without these nonlinearities: ``found["geometry"]``, ``found["cubic", "geometry"]``."""
        names = {without} if isinstance(without, str) else set(without)
        for left_out, result in zip(self.without, self.results, strict=True):
            if set(left_out) == names:
                return result
        raise KeyError(f"no scene lacks {sorted(names)}: name some of {', '.join(self.switches)}")

    @property
    def switches(self) -> tuple[str, ...]:
        """Names of the nonlinearities."""
        return self.without[-1]

    def __iter__(self) -> Iterator[tuple[tuple[str, ...], Any]]:
        return iter(zip(self.without, self.results, strict=True))

    def __str__(self) -> str:
        rows = [(_scene(names, len(self.switches)), str(r)) for names, r in self]
        width = max(len(name) for name, _ in rows)
        return text_table(f"{name:{width}}  {result}" for name, result in rows)

    __repr__ = __str__


def _scene(without: tuple[str, ...], count: int) -> str:
    """Words for a scene of a model that has so many nonlinearities."""
    return f"without {', '.join(without)}" if without else f"with {all_of(count)}"


def all_of(count: int) -> str:
    """Words for all of so many nonlinearities."""
    return {1: "it", 2: "both", 3: "all three"}.get(count, "all")


def ablation(
    model: Any,
    study: Callable[[Any], Any],
    *,
    execution: Execution | None = None,
    **keywords: Unpack[ExecutionKeywords],
) -> Ablation:
    """Put all scenes with a model's :attr:`~Model.nonlinearities` on or off through a study.

    Of a SliderOnBelt these are eight: with the cubic contact, the non-smooth behaviours and the moving load
    on or off.

    Parameters
    ----------
    model : Model
        With all of its nonlinearities.
    study : callable
        Called as ``study(model)``: ``fl.steady_state``, or a function of your own.
    execution : Execution or None
        Workers, executor, file and progress bar; None takes the usual ones.  Results that the file of
        `resume` keeps have to be numbers, texts, or lists and mappings of such.  Of the study the file knows
        only the name, as for :func:`sweep`.
    **keywords
        Fields of :class:`Execution`, in the place of those of `execution`: ``workers=2``.

    Returns
    -------
    Ablation

    Raises
    ------
    TypeError
        For what is no model, or no function, or an unknown keyword.
    ValueError
        For a model that cannot be without one of them, or a file of another ablation.
    OSError
        Where the file cannot be written, or another ablation is using it.
    RuntimeError
        Where the study of a scene fails, from its error; what was done before is in the file.
    KeyboardInterrupt
        After ctrl-C; :func:`partial_result` is then the Ablation with None for the scenes that were not done.

    Examples
    --------
    >>> import frictionlab as fl
    >>> found = fl.ablation(fl.SliderOnBelt(), lambda m: fl.critical_value(m, "mu_k", (0, 4)))
    >>> found["geometry"] > found[()]
    True
    """
    require_model(model, cure="write ablation(model, study), the model made, such as fl.SliderOnBelt()")
    check_function("study", study, "give one such as fl.steady_state")
    (how,) = merge_keywords("ablation", keywords, execution=(Execution, execution))
    switches = tuple(model.nonlinearities)
    left_out = tuple(tuple(compress(switches, choice)) for choice in product((0, 1), repeat=len(switches)))
    models = tuple(model.without(*names) for names in left_out)
    specification = {} if how.resume is None else _specification(model, study, left_out)
    with Journal(specification, how.resume) as journal:
        complete = run_tasks(
            study,
            [(m,) for m in models],
            keep=journal.keep,
            names=[f"the scene {_scene(names, len(switches))}" for names in left_out],
            done=frozenset(journal.results),
            execution=how,
            title="ablation",
        )
        journal.put_in_order()
    found = Ablation(left_out, models, tuple(journal.results.get(i) for i in range(len(models))))
    if not complete:
        raise journal.interruption(found, len(models))
    return found


def _specification(model: Any, study: Callable[[Any], Any], left_out: tuple[Any, ...]) -> dict[str, Any]:
    """What a file tells ablations apart by."""
    return {"ablation": function_name(study), "model": model.to_dict(), "without": left_out}
