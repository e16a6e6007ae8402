"""`fl.basins`: which initial states lead to which attractor; `fl.basin_stability`: how large a share does."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Unpack

import numpy as np

from frictionlab.analysis.motion_scales import Array
from frictionlab.analysis.options import Execution, SteadyStateOptions, StudyKeywords, merge_keywords
from frictionlab.analysis.simulate import validate_initial_state
from frictionlab.hybrid.methods.taylor import Taylor
from frictionlab.models.coercion import automaton_of
from frictionlab.validation import abbreviate, check_choice, check_mapping, check_number, float_array

from .result import (
    Basins,
    BasinStability,
    basin_stability_from_results,
    basins_from_results,
    load_basins,
    random_initial_values,
)
from .tasks import run_basin_tasks, state_names

__all__ = ["BasinStability", "Basins", "basin_stability", "basins", "load_basins"]


def basins(
    model: Any,
    x: tuple[str, Any],
    y: tuple[str, Any],
    x0: Any = "rest",
    *,
    options: SteadyStateOptions | None = None,
    execution: Execution | None = None,
    **keywords: Unpack[StudyKeywords],
) -> Basins:
    """Basins of attraction in a plane of initial states.

    First a dozen of the initial states are run to the end, which gives the attractors.  Then all are run side
    by side (see :func:`ensemble`), each until it is on a known attractor; a motion that is on none after the
    transient is classified as by :func:`steady_state`; it either has the features of a known attractor (kind,
    period, range of each state) or is on a new one.

    Parameters
    ----------
    model : SliderOnBelt or HybridAutomaton
    x, y : (str, array_like)
        A state, such as "x1" or "x1'", and its initial values (N,) and (M,).
    x0 : "rest", "near", array_like (n,) or callable
        Initial values of the other states.  A callable takes the state (n,) with the others zero, and returns
        the complete initial state.
    options : SteadyStateOptions or None
        With a method that is a Taylor.  The transient should be as long as the slowest motion takes to
        settle; a longer one costs only those that have not settled.
    execution : Execution or None
        Workers, executor, file and progress bar; None takes the usual ones.
    **keywords
        Fields of :class:`SteadyStateOptions` and :class:`Execution`, in the place of those of `options` and
        `execution`: ``transient=60.0, workers=2``.

    Returns
    -------
    Basins

    Raises
    ------
    TypeError
        For what is no model, or an unknown keyword.
    ValueError
        For other bad arguments, or a file of other basins; like the former before any work is done.
    OSError
        Where the file cannot be written, or another sweep is using it.
    RuntimeError
        Where a task fails, from its error; what was done before is in the file.
    KeyboardInterrupt
        After ctrl-C; :func:`partial_result` is then the Basins with -1 for what was not done, None where
        nothing was.  A first press lets the tasks that have begun be finished, a second one leaves them.

    Examples
    --------
    >>> import frictionlab as fl
    >>> model = fl.SliderOnBelt(mu_k=1.4).without("geometry")
    >>> speeds = ("x1'", [0.0, 0.5]), ("y1'", [0.0, 0.1])
    >>> found = fl.basins(model, *speeds, "near", transient=150.0, window=10.0, progress=False)
    >>> [attractor.kind for attractor in found.attractors]
    ['equilibrium', 'periodic']
    """
    settings, how = _settings("basins", keywords, options, execution)
    axes = [_axis(model, "x", x), _axis(model, "y", y)]
    if axes[0][0] == axes[1][0]:
        raise ValueError(f"x and y must be two states, got {x[0]!r} twice: choose another")
    plane = np.stack(np.meshgrid(axes[0][1], axes[1][1]), axis=-1).reshape(-1, 2)
    starts = _initial_states(model, [name for name, _ in axes], plane, x0)
    about = {key: {"name": name, "values": v.tolist()} for key, (name, v) in zip("xy", axes)}
    return run_basin_tasks(model, starts, about, settings, how, basins_from_results)


def basin_stability(
    model: Any,
    ranges: Mapping[str, tuple[float, float]],
    samples: int = 1000,
    seed: int = 0,
    x0: Any = "rest",
    *,
    options: SteadyStateOptions | None = None,
    execution: Execution | None = None,
    **keywords: Unpack[StudyKeywords],
) -> BasinStability:
    """The share of random initial states that goes to each attractor.

    Its standard error is that of a binomial distribution, sqrt(p (1 - p)/N).  Source: Menck, Heitzig, Marwan
    and Kurths, Nature Physics 9 (2013) 89-92.

    Parameters
    ----------
    model : SliderOnBelt or HybridAutomaton
    ranges : mapping of str to (float, float)
        States, such as "x1" or "x1'", and the interval in which each is uniformly distributed.
    samples : int
    seed : int
        Of the random numbers.
    x0, options, execution, **keywords
        As :func:`basins`.

    Returns
    -------
    BasinStability

    Raises
    ------
    TypeError, ValueError, OSError, RuntimeError, KeyboardInterrupt
        As :func:`basins`.

    Examples
    --------
    >>> import frictionlab as fl
    >>> model = fl.SliderOnBelt(mu_k=0.3).without("geometry")
    >>> found = fl.basin_stability(model, {"x1'": (0.0, 0.1)}, 20, x0="near", progress=False)
    >>> found.fractions
    {'equilibrium': 1.0}
    """
    settings, how = _settings("basin_stability", keywords, options, execution)
    check_number("samples", samples, integer=True, least=1, cure="1000 give errors of 0.016 at most")
    check_number("seed", seed, integer=True, least=0, cure="give another for other random numbers")
    check_mapping("ranges", ranges, "give states their smallest and largest values, as {'x1': (0, 1)}")
    if not ranges:
        raise ValueError("ranges must hold at least one state, got none: give its smallest and largest value")
    limits = {name: _range(model, name, limit) for name, limit in ranges.items()}
    points = random_initial_values(limits, samples, seed)
    starts = _initial_states(model, list(limits), points, x0)
    about = {"ranges": limits, "samples": int(samples), "seed": int(seed)}
    return run_basin_tasks(model, starts, about, settings, how, basin_stability_from_results)


def _settings(
    function: str, keywords: Mapping[str, Any], options: Any, execution: Any
) -> tuple[dict[str, Any], Execution]:
    """What tasks and files need of the options, and how the tasks are done."""
    bundles = {"options": (SteadyStateOptions, options), "execution": (Execution, execution)}
    chosen, how = merge_keywords(function, keywords, "t_max", **bundles)
    if not isinstance(chosen.method, Taylor):
        raise ValueError(
            f"method must be 'taylor' or a Taylor, got {chosen.method!r}: others have no ensembles"
        )
    check_number("transient", chosen.transient, above=0.0, cure="give the seconds in which motions settle")
    if chosen.t_max is not None:
        raise ValueError(f"t_max must be None, got {chosen.t_max}: give a longer transient")
    numbers = {name: float(getattr(chosen, name)) for name in ("transient", "window", "rtol")}
    last = {"method": chosen.method, "section": chosen.section, "tolerance": float(chosen.tolerance)}
    return {**numbers, **last}, how


def _axis(model: Any, which: str, axis: Any) -> tuple[str, Array]:
    names = state_names(model)
    cure = f"for instance ({names[0]!r}, [0, 1])"
    if not isinstance(axis, (tuple, list)) or len(axis) != 2 or not isinstance(axis[0], str):
        raise ValueError(f"{which} must be a name and its values, got {abbreviate(axis)}: {cure}")
    check_choice(which, axis[0], names)
    values = float_array(f"the values of {axis[0]}", axis[1], cure).ravel()
    if not len(values) or not np.isfinite(values).all():
        raise ValueError(
            f"{which} must hold finite values of {axis[0]}, got {abbreviate(axis[1])}: give one at least"
        )
    return axis[0], values


def _range(model: Any, name: str, limits: Any) -> tuple[float, float]:
    check_choice("ranges", name, state_names(model))
    low, high = np.asarray(limits, dtype=float).ravel()[[0, -1]] if np.size(limits) == 2 else (np.nan, np.nan)
    if not -np.inf < low < high < np.inf:
        raise ValueError(
            f"the range of {name} must be two ascending numbers, got {limits!r}: swap or mend it"
        )
    return float(low), float(high)


def _initial_states(model: Any, names: Sequence[str], points: Array, x0: Any) -> Array:
    """Initial states (N, n): the named states take their values from the columns of `points`, the others from
    `x0`."""
    known = state_names(model)
    base = np.zeros(len(known)) if callable(x0) else validate_initial_state(model, x0, automaton_of(model))
    starts = np.repeat(base[None], len(points), axis=0)
    starts[:, [known.index(name) for name in names]] = points
    return _complete_states(x0, starts, known) if callable(x0) else starts


def _complete_states(x0: Callable[[Array], Any], starts: Array, names: tuple[str, ...]) -> Array:
    """The states (N, n), each completed by `x0`."""
    given = [x0(start.copy()) for start in starts]
    try:
        states = np.array(given, dtype=float)
    except ValueError:  # of several lengths
        states = np.zeros(0)
    if states.shape != starts.shape or not np.isfinite(states).all():
        bad = next(each for each in given if not _is_complete(each, len(names)))
        raise ValueError(
            f"x0 must give a finite number for each of {', '.join(names)}, got {np.asarray(bad).tolist()}: "
            "return all of them"
        )
    return states


def _is_complete(state: Any, count: int) -> bool:
    values = np.asarray(state, dtype=float)
    return values.shape == (count,) and bool(np.isfinite(values).all())
