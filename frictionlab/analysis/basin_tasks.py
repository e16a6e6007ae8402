"""The tasks of `fl.basins`: some initial states first, which give the attractors, then all, in groups."""

from __future__ import annotations

from concurrent.futures import Executor
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from frictionlab.automaton import HybridAutomaton
from frictionlab.models import Model

from .attractors import spread_of
from .examine import probe
from .journal import Journal
from .recurrence import Array
from .settling import known_attractors, settle
from .steady_state import automaton_of, check_steady
from .tasks import check_workers, run_tasks

PROBES = 12  # initial states from which the attractors are looked for first
GROUP, LARGEST = 250, 1000  # initial states in a task: what is done once for each should not count,
TASKS = 16  # and yet there should be some for every processor


def names_of(model: Any) -> tuple[str, ...]:
    """Names of the states, as a run has them."""
    return tuple(map(str, automaton_of(model).states))


def settled(
    model: Any,
    starts: Array,
    about: dict[str, Any],
    settings: dict[str, Any],
    workers: int | None,
    executor: Executor | None,
    resume: str | Path | None,
    progress: bool,
) -> tuple[dict[str, Any], dict[int, Any]]:
    """What was asked, and the results of all tasks: those of the probes first, then those of the groups."""
    check_workers(workers)
    transient, window, section, tolerance = (
        settings[k] for k in ("transient", "window", "section", "tolerance")
    )
    check_steady(model, starts[0], transient, window, None, section, tolerance)
    automaton, chosen = automaton_of(model), _chosen(len(starts))
    size = max(GROUP, min(LARGEST, len(starts) // TASKS))
    groups = [starts[i : i + size] for i in range(0, len(starts), size)]
    layout = {"count": len(starts), "group": size, "probes": len(chosen), "starts": _digest(starts.tobytes())}
    asked = _asked(model, automaton, {**about, **layout}, settings)
    journal = Journal(asked, resume)
    run: dict[str, Any] = {"workers": workers, "executor": executor}
    done = run_tasks(
        probe,
        [(automaton, starts[i], settings) for i in chosen],
        keep=journal.keep,
        names=[f"initial state {i}" for i in chosen],
        done=journal.results.keys(),
        progress="attractors" if progress else None,
        **run,
    )
    if done:
        probed = [journal.results[i] for i in range(len(chosen))]
        known = known_attractors(automaton, probed, settings)
        settings = {**settings, "spread": spread_of(probed)}
        run_tasks(
            settle,
            [(automaton, group, known, settings) for group in groups],
            keep=lambda i, result: journal.keep(i + len(chosen), result),
            names=[f"initial states from {i * size} on" for i in range(len(groups))],
            done={i - len(chosen) for i in journal.results},
            progress=f"basins, {size} states each" if progress else None,
            **run,
        )
    journal.close()
    return asked, journal.results


def _chosen(count: int) -> list[int]:
    """Which initial states are run first: some at random, as a grid's rows may be alike."""
    drawn = np.random.default_rng(0).choice(count, min(PROBES, count), replace=False)
    return np.sort(drawn).tolist()


def _asked(
    model: Any, automaton: HybridAutomaton, about: dict[str, Any], settings: dict[str, Any]
) -> dict[str, Any]:
    identity = model.to_dict() if isinstance(model, Model) else _digest(_text(automaton).encode())
    data = {"model": identity, "states": list(names_of(model)), "coordinates": automaton.coordinates}
    return {**data, **about, **settings, "method": settings["method"].describe()}


def _text(automaton: HybridAutomaton) -> str:
    """All of an automaton in words; equal ones have equal texts."""
    modes = [
        (
            m.name,
            m.flow,
            m.constraints,
            m.limit,
            [(e.name, e.function, e.targets, *_jumps(e)) for e in m.events],
        )
        for m in automaton.modes
    ]
    return str((automaton.states, modes, {str(k): v for k, v in automaton.parameters.items()}))


def _jumps(event: Any) -> list[Any]:
    return [(dict(r.jump), dict(r.vanishing)) for r in (event.reset, event.accumulation) if r is not None]


def _digest(content: bytes) -> str:
    return sha256(content).hexdigest()
