"""`fl.basins`: which initial states lead to which attractor; `fl.basin_stability`: what share does."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Unpack

import numpy as np

from frictionlab.analysis.basins.attractors import (
    UNDECIDED,
    Attractor,
    catalogue_of_probes,
    name_attractors,
)
from frictionlab.analysis.basins.tasks import run_basin_tasks
from frictionlab.analysis.initial_states import initial_state_of
from frictionlab.analysis.motion_scales import Array
from frictionlab.analysis.options import Execution, SteadyStateOptions, StudyKeywords, settings_of
from frictionlab.analysis.sweeps.journal import read_journal, write_journal
from frictionlab.file_writing import name_written_file
from frictionlab.hybrid.methods.taylor import Taylor
from frictionlab.hybrid.solve import state_from_x0, with_phase_in_turn
from frictionlab.models.model import ModelOrAutomaton, automaton_of
from frictionlab.presentation import Drawable, shorten
from frictionlab.validation import (
    abbreviate,
    check_choice,
    check_limits,
    check_mapping,
    check_number,
    check_pair,
    explains_keywords,
    float_array,
    seed_of,
)

__all__ = ["BasinStability", "Basins", "basin_stability", "basins", "load_basins"]

MAX_SAMPLES = 10_000_000  # initial states, each of which is a run


@dataclass(frozen=True, eq=False)
class LabelledStates(Drawable):
    """Initial states, each with the attractor it goes to: the base class of both results."""

    labels: np.ndarray
    attractors: tuple[Attractor, ...]
    names: tuple[str, ...]
    specification: dict[str, Any]
    results: dict[int, Any]

    @property
    def fractions(self) -> dict[str, float]:
        """Share p of the computed initial states that goes to each attractor, by its name."""
        decided = max(1, int((self.labels != UNDECIDED).sum()))
        return {a.name: float((self.labels == i).sum()) / decided for i, a in enumerate(self.attractors)}

    @property
    def cyclic(self) -> tuple[str, ...]:
        """Names of the coordinates that may turn for ever."""
        return tuple(self.specification.get("cyclic", ()))  # older files have none

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
        Results of the tasks, by index.
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
        If the file holds no basins, or is damaged.
    """
    specification, results = read_journal(path)
    if not {"coordinates", "probes", "group"} <= specification.keys():
        raise ValueError(f"{path} must be a file of basins, and is one of another sweep: give another path")
    if "x" in specification:
        return basins_from_results(specification, results)
    return basin_stability_from_results(specification, results)


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
    """Labels of all initial states, and the attractors to which they lead: those of the probes, then those of
    each group.

    Where a motion is sensitive, that of a probe may end elsewhere than the same one in its group.
    """
    probes, group = specification["probes"], specification["group"]
    ends = [results[i] for i in range(probes) if i in results]
    catalogue = catalogue_of_probes(ends, specification["coordinates"], specification["rtol"])
    shared, labels = len(catalogue.attractors), np.full(specification["count"], UNDECIDED)
    for i in sorted(i for i in results if i >= probes):
        index = np.array([*range(shared), *(catalogue.place(attractor) for attractor in results[i]["found"])])
        first = (i - probes) * group
        labels[first : first + group] = index[results[i]["labels"]]
    attractors = catalogue.attractors
    if (labels != UNDECIDED).all():
        reached, labels = np.unique(labels, return_inverse=True)
        attractors = [attractors[i] for i in reached]
    return labels, name_attractors(attractors)


def _fractions_text(fractions: dict[str, float], errors: dict[str, float] | None = None) -> str:
    bounds = {
        name: "" if errors is None else f" +- {error:.2g}" for name, error in (errors or fractions).items()
    }
    return shorten(f"{name} {share:.4g}{bounds[name]}" for name, share in fractions.items())


@explains_keywords
def basins(
    model: ModelOrAutomaton,
    x: tuple[str, Any],
    y: tuple[str, Any],
    x0: Any = "rest",
    **keywords: Unpack[StudyKeywords],
) -> Basins:
    """Basins of attraction in a plane of initial states.

    First a dozen of the initial states are run to the end, which gives the first attractors.  Then all are
    run side by side (see :func:`ensemble`), each until it is on a known attractor.  A motion that is on none
    after the transient is classified as by :func:`steady_state`: it either has the features of a known
    attractor (kind, period, range of each state) or is on a new one.  States that drift for ever, such as the
    angle of a disc that turns, are left out of the comparison, also where two of them drift together.

    Parameters
    ----------
    model : Model or HybridAutomaton
    x, y : (str, array_like)
        A state, such as "x1" or "x1'", and its initial values (N,) and (M,).
    x0 : "rest", "near", mapping, array_like (n,) or callable
        Initial values of the other states.  A callable takes the state (n,) with these zero, and returns the
        complete initial state.
    **keywords
        Fields of :class:`SteadyStateOptions`, and how tasks are run, as for :func:`sweep`:
        ``transient=60.0, workers=2``.  The method has to be a Taylor.  The transient should be as long as the
        slowest motion takes to settle; a longer one costs time only for motions that have not settled.

    Returns
    -------
    Basins

    Raises
    ------
    TypeError
        Where `model` is no model, or a keyword is unknown.
    ValueError
        For other bad arguments, or a file of other basins.  Both are raised before any run starts.
    OSError
        Where the file cannot be written, or another sweep is using it.
    RuntimeError
        Where a task fails, raised from its error; the results before it are in the file.
    KeyboardInterrupt
        After ctrl-C; :func:`partial_result` then returns the Basins with -1 for what was not done, or None
        where nothing was.  A first press lets tasks that have begun finish, a second one abandons them.

    Examples
    --------
    >>> import frictionlab as fl
    >>> model = fl.SliderOnBelt(mu_k=1.4).without("geometry")
    >>> speeds = ("x1'", [0.0, 0.5]), ("y1'", [0.0, 0.1])
    >>> portrait = fl.basins(model, *speeds, "near", transient=150.0, window=10.0, progress=False)
    >>> [attractor.kind for attractor in portrait.attractors]
    ['equilibrium', 'periodic']
    """
    options, how = _options("basins", keywords)
    axes = [_axis(model, "x", x), _axis(model, "y", y)]
    if axes[0][0] == axes[1][0]:
        raise ValueError(f"x and y must be two states, got {abbreviate(x[0])} twice: choose another")
    check_number(
        "the number of initial states",
        len(axes[0][1]) * len(axes[1][1]),
        most=MAX_SAMPLES,
        cure="give fewer values",
    )
    plane = np.stack(np.meshgrid(axes[0][1], axes[1][1]), axis=-1).reshape(-1, 2)
    starts = _initial_states(model, [name for name, _ in axes], plane, x0)
    about = {key: {"name": name, "values": v.tolist()} for key, (name, v) in zip("xy", axes)}
    return run_basin_tasks(model, starts, about, options, how, basins_from_results)


@explains_keywords
def basin_stability(
    model: ModelOrAutomaton,
    ranges: Mapping[str, tuple[float, float]],
    samples: int = 1000,
    rng: int | np.random.Generator | None = 0,
    x0: Any = "rest",
    **keywords: Unpack[StudyKeywords],
) -> BasinStability:
    """The share of random initial states that goes to each attractor.

    Its standard error is that of a binomial distribution, sqrt(p (1 - p)/N).  Source: Menck, Heitzig, Marwan
    and Kurths, Nature Physics 9 (2013) 89-92.

    Parameters
    ----------
    model : Model or HybridAutomaton
    ranges : mapping of str to (float, float)
        States, such as "x1" or "x1'", and the interval in which each is uniformly distributed.
    samples : int
    rng : int, Generator or None
        Seed of the random numbers, a generator that draws one, or None for others each time.  A file of
        `resume` wants an integer.
    x0, **keywords
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
    >>> stability = fl.basin_stability(model, {"x1'": (0.0, 0.1)}, 20, x0="near", progress=False)
    >>> stability.fractions
    {'equilibrium': 1.0}
    """
    options, how = _options("basin_stability", keywords)
    samples = check_number(
        "samples", samples, integer=True, least=1, most=MAX_SAMPLES, cure="1000 give errors of 0.016 at most"
    )
    seed = seed_of(rng)
    check_mapping("ranges", ranges, "give states their smallest and largest values, as {'x1': (0, 1)}")
    if not ranges:
        raise ValueError("ranges must hold at least one state, got none: give its smallest and largest value")
    limits = {name: _range(model, name, limit) for name, limit in ranges.items()}
    points = random_initial_values(limits, samples, seed)
    starts = _initial_states(model, list(limits), points, x0)
    about = {"ranges": limits, "samples": int(samples), "seed": seed}
    return run_basin_tasks(model, starts, about, options, how, basin_stability_from_results)


def _options(function: str, keywords: Mapping[str, Any]) -> tuple[SteadyStateOptions, Execution]:
    """How motions are classified, and how the tasks are run."""
    options, how = settings_of(function, keywords, SteadyStateOptions, Execution, unused="t_max")
    if not isinstance(options.method, Taylor):
        raise ValueError(
            f"method must be 'taylor' or a Taylor, got {abbreviate(options.method)}: others have no ensembles"
        )
    check_number("transient", options.transient, above=0.0, cure="give the seconds in which motions settle")
    if options.t_max is not None:
        raise ValueError(f"t_max must be None, got {options.t_max}: give a longer transient")
    return options, how


def _axis(model: ModelOrAutomaton, which: str, axis: Any) -> tuple[str, Array]:
    names = automaton_of(model).state_names
    cure = f"for instance ({names[0]!r}, [0, 1])"
    name, numbers = check_pair(which, axis, "a name and its values", cure)
    check_choice(which, name, names)
    values = float_array(f"the values of {name}", numbers, cure).ravel()
    if not len(values) or not np.isfinite(values).all():
        raise ValueError(
            f"{which} must hold finite values of {name}, got {abbreviate(numbers)}: give one at least"
        )
    return name, values


def _range(model: ModelOrAutomaton, name: str, limits: Any) -> tuple[float, float]:
    check_choice("ranges", name, automaton_of(model).state_names)
    return check_limits(f"the range of {name}", limits, "give (low, high)")


def _initial_states(model: ModelOrAutomaton, names: Sequence[str], points: Array, x0: Any) -> Array:
    """Initial states (N, n): the named states take their values from the columns of `points`, the others from
    `x0`."""
    state_names = automaton_of(model).state_names
    own = callable(x0) and not isinstance(x0, type)
    base = np.zeros(len(state_names)) if own else initial_state_of(model, x0)
    starts = np.repeat(base[None], len(points), axis=0)
    starts[:, [state_names.index(name) for name in names]] = points
    if own:
        starts = np.array([state_from_x0(automaton_of(model), x0(start.copy())) for start in starts])
    return with_phase_in_turn(automaton_of(model), starts)
