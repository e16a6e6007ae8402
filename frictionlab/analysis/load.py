"""`fl.load`: a run from the file that `Trajectory.save` wrote."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from frictionlab.automaton import HybridAutomaton
from frictionlab.hybrid.chatter_limit import with_chatter_limit
from frictionlab.hybrid.problem import Problem, RunData, Sampling, Status
from frictionlab.hybrid.run_file import STORED_ARRAYS, StoredRun, rates_by_mode, read_run_file
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.models.automaton_of_model import automaton_from_stored
from frictionlab.models.model import Model, ModelOrAutomaton, automaton_of, model_from_data
from frictionlab.tape.packing import program_of, program_of_modes

RATES_RTOL = 1e-9  # rates by the same equations agree to rounding, on every processor


def load(path: str | Path, model: ModelOrAutomaton | None = None) -> Trajectory:
    """A run that :meth:`Trajectory.save` wrote.

    Parameters
    ----------
    path : path
    model : Model, Structure or HybridAutomaton, optional
        That of the run, the same as it was; by default that in the file.  Needed for laws and models of your
        own that are not defined in this session.

    Raises
    ------
    OSError
        Where there is no such file, or it cannot be read.
    ValueError
        Where the file is no saved run or is damaged; where its model cannot be made, or is not the given one.
    """
    stored = read_run_file(path)
    if model is None and "model" in stored.description:
        model = _model_in_file(stored)
    automaton = _automaton_in_file(stored) if model is None else automaton_of(model)
    return _trajectory_in_file(stored, automaton, None if isinstance(model, HybridAutomaton) else model)


def _model_in_file(stored: StoredRun) -> ModelOrAutomaton:
    try:
        return model_from_data(stored.description["model"])
    except (ValueError, TypeError, KeyError, RecursionError) as error:
        raise ValueError(
            f"{stored.path} holds a run of a model that cannot be made: {error}: "
            "give it as load(path, model=model)"
        ) from error


def _automaton_in_file(stored: StoredRun) -> HybridAutomaton:
    """The automaton that a file holds; ValueError where it holds none, or it is damaged."""
    data = stored.about.get("automaton")
    if not isinstance(data, dict):
        reason = f", {data}" if isinstance(data, str) else ""
        raise ValueError(
            f"{stored.path} holds a run without its automaton{reason}: give it as load(path, model=automaton)"
        )
    try:
        automaton = automaton_from_stored(data, stored.about.get("parameters"), Model)
        if not automaton.on_demand:
            program_of(automaton)  # checks that it is well formed; the program is cached
        return automaton
    except (ValueError, ArithmeticError) as error:
        raise ValueError(f"{stored.path} is damaged, {error}: save the run again") from error


def _trajectory_in_file(
    stored: StoredRun, automaton: HybridAutomaton, source: ModelOrAutomaton | None
) -> Trajectory:
    """The run that a file holds; ValueError where `automaton` is not the one that made it, or the file is
    damaged.
    """
    try:
        return _trajectory(stored, automaton, source)
    except (KeyError, TypeError, AttributeError, IndexError) as error:
        raise ValueError(f"{stored.path} is damaged, {error!r}: save the run again") from error


def _trajectory(stored: StoredRun, automaton: HybridAutomaton, source: ModelOrAutomaton | None) -> Trajectory:
    about = stored.about
    # The one parameter that is a setting of the method, not of the model.
    automaton = with_chatter_limit(automaton, about["parameters"].get("chatter", 0.0))
    _check_same(stored, "states", list(automaton.state_names))
    saved = about["mode_names"]  # steps and events give modes as places in this list
    derivable = automaton.on_demand and all(name in automaton.names for name in saved)
    _check_same(stored, "mode_names", saved if derivable else list(automaton.names))
    _check_same(stored, "parameters", {name: float(value) for name, value in automaton.values.items()})
    program, numbers = program_of_modes(automaton, tuple(saved)) if derivable else program_of(automaton)
    _check_same(stored, "guards", list(program.guards))
    arrays = {name: stored.arrays[name] for name in STORED_ARRAYS}
    raw = RunData(**arrays, t=float(about["t"]), mode=int(about["mode"]), status=Status[about["status"]])
    start = raw.step_states[0] if len(raw.step_states) else raw.state
    problem = Problem(program, numbers, start, raw.t)
    _check_rates(stored, rates_by_mode(problem, raw))
    samples = about["samples"]
    return Trajectory(
        automaton,
        problem,
        raw,
        Sampling(
            int(samples["order"]),
            int(samples["parts"]),
            stored.arrays.get("t_eval"),
            tuple(samples["sections"]),
        ),
        quadratures=dict(about["quadratures"]),
        description={k: v for k, v in stored.description.items() if k != "model" or source is None},
        source=source,
        wall_time=float(about["wall_time"]),
    )


def _check_same(stored: StoredRun, what: str, value: Any) -> None:
    """Raise ValueError unless the automaton has what the run had."""
    saved = stored.about[what]
    if value == saved:
        return
    if isinstance(saved, dict):
        names = sorted(name for name in {**saved, **value} if saved.get(name) != value.get(name))
        saved, value = ({name: values.get(name) for name in names} for values in (saved, value))
    raise ValueError(
        f"{stored.path} holds a run with the {what.replace('_', ' ')} {saved}, got {value}: "
        "give load(path, model=...) the model or automaton of that run"
    )


def _check_rates(stored: StoredRun, rates: dict[str, list[float]]) -> None:
    """Raise ValueError unless the equations give the rates that were saved."""
    for mode, saved in stored.about["rates"].items():
        room = RATES_RTOL * np.abs(saved).max()
        if not np.allclose(rates[mode], saved, rtol=0.0, atol=room, equal_nan=True):
            raise ValueError(
                f"{stored.path} holds a run by other equations: at its first step in mode {mode!r} the rates "
                f"of the states were {saved}, now they are {rates[mode]}: give load(path, model=...) the "
                "model or automaton of that run"
            )
