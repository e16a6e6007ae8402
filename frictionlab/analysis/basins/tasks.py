"""The tasks of `fl.basins`: probes of some initial states, which give the attractors, then all states in
groups.

The runs of a group go side by side and are checked from time to time; a run on a known attractor is stopped.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from hashlib import sha256
from typing import Any

import numpy as np

from frictionlab.analysis.basins.attractors import (
    UNDECIDED,
    AttractorCatalogue,
    AttractorData,
    ModeState,
    add_ranges,
    attractor_points,
    catalogue_of_probes,
    classify_attractor,
    probe_attractor,
    transient_ranges,
)
from frictionlab.analysis.ensemble import advance_group, start_group
from frictionlab.analysis.initial_states import initial_state_of
from frictionlab.analysis.motion_scales import Array
from frictionlab.analysis.options import Execution, SteadyStateOptions
from frictionlab.analysis.steady_state.classification import MotionKind
from frictionlab.analysis.steady_state.steady_state import check_section
from frictionlab.analysis.sweeps.journal import Journal
from frictionlab.automaton import HybridAutomaton
from frictionlab.hybrid.ensemble.arrays import Batch, select_runs
from frictionlab.hybrid.kernels.run_state import FINISHED, MODE
from frictionlab.models.model import ModelOrAutomaton, automaton_of, data_of
from frictionlab.stability.equilibrium_points.frozen_time import refuse_time

PROBE_COUNT = 12  # initial states of the probes, which look for the attractors first
# initial states in a task: enough that the overhead of a task does not matter
MIN_GROUP_SIZE, MAX_GROUP_SIZE = 250, 1000
TARGET_TASK_COUNT = 16  # tasks aimed at between these sizes, so that every processor has several

CHECKS_PER_TRANSIENT = 20  # checks of the runs within the transient, evenly spaced
EARLY_CHECKS = 4  # further checks before the first of them


def run_basin_tasks(
    model: ModelOrAutomaton,
    starts: Array,
    about: dict[str, Any],
    options: SteadyStateOptions,
    execution: Execution,
    result_of: Callable[[dict[str, Any], dict[int, Any]], Any],
) -> Any:
    """Run the probes, then the groups; return what `result_of` makes of the specification and all results.

    Raises
    ------
    KeyboardInterrupt
        After ctrl-C, with what `result_of` makes of the results so far, None where there are none.
    """
    refuse_time(model, "basins")
    check_section(model, options.section)
    initial_state_of(model, starts[0])
    automaton, sample = automaton_of(model), probe_indices(len(starts))
    size = max(MIN_GROUP_SIZE, min(MAX_GROUP_SIZE, len(starts) // TARGET_TASK_COUNT))
    groups = [starts[i : i + size] for i in range(0, len(starts), size)]
    layout = {
        "count": len(starts),
        "group": size,
        "probes": len(sample),
        "starts": _digest(starts.tobytes()),
    }
    specification = _basin_arguments(model, automaton, {**about, **layout}, options)
    probes = [(automaton, starts[i], options) for i in sample]
    names = [f"initial state {i}" for i in sample]
    with Journal(specification, execution.resume) as journal:
        journal.run_tasks(probe_attractor, probes, names.__getitem__, execution, "attractors")
        if journal.complete:
            _run_groups(journal, automaton, groups, options, len(sample), execution)
        result = result_of(specification, journal.results) if journal.results else None
        return journal.finish(result, len(sample) + len(groups))


def _run_groups(
    journal: Journal,
    automaton: HybridAutomaton,
    groups: Sequence[Array],
    options: SteadyStateOptions,
    probes: int,
    execution: Execution,
) -> None:
    """Label the initial states by the attractors to which they lead."""
    size, ends = len(groups[0]), [journal.results[i] for i in range(probes)]

    def points_on(attractor: AttractorData) -> Array:
        return attractor_points(automaton, attractor, options)

    try:
        catalogue = catalogue_of_probes(ends, automaton.coordinates, options.rtol, points_on)
    except KeyboardInterrupt:
        journal.interrupt()
        return
    spread = transient_ranges(ends)
    tasks = [(automaton, group, catalogue, spread, options) for group in groups]
    names = [f"initial states from {i * size} on" for i in range(len(groups))]
    journal.run_tasks(
        label_initial_states, tasks, names.__getitem__, execution, f"basins, {size} states each", probes
    )


def probe_indices(count: int) -> list[int]:
    """Indices of the initial states to probe: chosen at random, as the rows of a grid may be alike."""
    sample = np.random.default_rng(0).choice(count, min(PROBE_COUNT, count), replace=False)
    return np.sort(sample).tolist()


def _basin_arguments(
    model: ModelOrAutomaton, automaton: HybridAutomaton, about: dict[str, Any], options: SteadyStateOptions
) -> dict[str, Any]:
    data = {
        "model": data_of(model),
        "states": list(automaton.state_names),
        "coordinates": automaton.coordinates,
        "cyclic": list(automaton.cyclic),
    }
    return data | about | options.specification("transient", "window", "rtol", "section", "tolerance")


def _digest(content: bytes) -> str:
    return sha256(content).hexdigest()


def check_times(transient: float) -> Array:
    """Times at which the runs are checked.

    The first ones double, for motions that settle soon; then they are evenly spaced.
    """
    even = transient / CHECKS_PER_TRANSIENT
    return np.array(
        [
            *(even / 2**k for k in range(EARLY_CHECKS, 0, -1)),
            *(even * k for k in range(1, CHECKS_PER_TRANSIENT + 1)),
        ]
    )


def label_initial_states(
    automaton: HybridAutomaton,
    starts: Array,
    attractors: AttractorCatalogue,
    spread: Array,
    options: SteadyStateOptions,
) -> dict[str, list[Any]]:
    """One task: the attractors to which the initial states (N, n) lead.

    Runs are checked from time to time; one that has come to a known attractor is stopped.  Those left after
    the transient are classified one by one.  `spread` (n,) is the range of each state over the motions to the
    known attractors.

    Returns
    -------
    dict
        "labels": N indices; those beyond the known attractors refer to "found".
    """
    catalogue, states = attractors.copy(), np.array(starts, dtype=float)
    labels, running = np.full(len(states), UNDECIDED), np.arange(len(states))
    method: Any = options.method  # a Taylor
    group = start_group(automaton, states, method)
    for t in check_times(options.transient):
        advance_group(group, t)
        modes = None if automaton.on_demand else _modes_of_runs(group)
        states[running], labels[running] = group.runs.states, _labels_of_runs(group, catalogue, modes)
        goes_on = labels[running] == UNDECIDED
        group, running = select_runs(group, goes_on), running[goes_on]
        if not len(running):
            break
    modes = None if automaton.on_demand else _modes_of_runs(group)
    for row, i in enumerate(running):
        mode = None if modes is None else modes[row : row + 1]
        labels[i] = catalogue.reached(states[i : i + 1], mode)[0]
        if labels[i] == UNDECIDED:
            start = states[i], None if modes is None else str(modes[row])
            labels[i] = _label_after_transient(automaton, start, catalogue, spread, options)
    return {"labels": labels.tolist(), "found": catalogue.attractors[len(attractors.attractors) :]}


def _modes_of_runs(group: Batch) -> np.ndarray:
    """The name of the mode that each run is in, "" where it has none."""
    return np.array([*group.program.modes, ""])[group.runs.counts[:, MODE]]


def _labels_of_runs(group: Batch, catalogue: AttractorCatalogue, modes: np.ndarray | None) -> np.ndarray:
    """The index of the attractor that each run is on; "ended early" has one, too."""
    labels = catalogue.reached(group.runs.states, modes)
    for i in np.flatnonzero(group.runs.status != FINISHED):
        labels[i] = catalogue.place(
            {"kind": MotionKind.ENDED_EARLY, "period": None, "state": group.runs.states[i].tolist()}
        )
    return labels


def _label_after_transient(
    automaton: HybridAutomaton,
    start: ModeState,
    catalogue: AttractorCatalogue,
    spread: Array,
    options: SteadyStateOptions,
) -> int:
    """The attractor of the motion from where it is after the transient."""
    attractor = classify_attractor(automaton, start, spread, options)
    points = attractor_points(automaton, attractor, options)
    return catalogue.place(add_ranges(attractor, points), points)
