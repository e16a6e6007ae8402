"""The run that a file holds: whether its arrays belong together, and to the automaton that is given."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from frictionlab.automaton import HybridAutomaton
from frictionlab.hybrid.kernels.jets import MAX_ORDER
from frictionlab.hybrid.problem import Problem, RunData, Sampling, Status
from frictionlab.hybrid.solve import with_chatter_limit
from frictionlab.hybrid.storage import STORED_ARRAYS, StoredRun, rates_by_mode
from frictionlab.hybrid.tape.automaton_data import DERIVED_FROM, automaton_from_data
from frictionlab.hybrid.tape.packing import program_of, program_of_modes
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.validation import abbreviate

MAX_PARTS = 1000  # of a step, in samples: methods take eight at most
INTEGER_ARRAYS = "step_modes", "event_codes", "point_sections"
RATES_RTOL = 1e-9  # rates by the same equations agree to rounding, on every processor


Derive = Callable[[Any, Mapping[str, float]], HybridAutomaton]


def automaton_in_file(stored: StoredRun, derive: Derive) -> HybridAutomaton:
    """The automaton that a file holds.

    Parameters
    ----------
    stored : StoredRun
    derive : callable
        The automaton of what modes on demand are derived from, as data, with parameters by name.

    Raises
    ------
    ValueError
        Where it holds none, or it is damaged.
    """
    data = stored.about.get("automaton")
    if not isinstance(data, dict):
        reason = f", {data}" if isinstance(data, str) else ""
        raise ValueError(
            f"{stored.path} holds a run without its automaton{reason}: give it as load(path, model=automaton)"
        )
    try:
        if DERIVED_FROM in data:
            return _derived_automaton(stored, data, derive)
        automaton = automaton_from_data(data)
        program_of(automaton)  # which checks that it is well formed, and is remembered
        return automaton
    except (ValueError, ArithmeticError) as error:
        raise ValueError(f"{stored.path} is damaged, {error}: save the run again") from error


def _derived_automaton(stored: StoredRun, data: Mapping[str, Any], derive: Derive) -> HybridAutomaton:
    """That of a model with several contacts, whose modes a file cannot hold."""
    parameters = stored.about.get("parameters")
    if not isinstance(parameters, dict) or not all(type(value) is float for value in parameters.values()):
        raise ValueError(f"its parameters are {abbreviate(parameters)}")
    automaton = derive(data[DERIVED_FROM], parameters)
    if data.get("coordinates") != automaton.coordinates:
        raise ValueError(f"it has {data.get('coordinates')} coordinates instead of {automaton.coordinates}")
    return automaton


def trajectory_from_file(stored: StoredRun, automaton: HybridAutomaton, source: Any = None) -> Trajectory:
    """The run that a file holds, on the automaton that made it.

    Raises
    ------
    ValueError
        Where the file is damaged, or the automaton is another than that of the run.
    """
    try:
        return _trajectory(stored, automaton, source)
    except (KeyError, TypeError, AttributeError, IndexError) as error:
        raise ValueError(f"{stored.path} is damaged, {error!r}: save the run again") from error


def _trajectory(stored: StoredRun, automaton: HybridAutomaton, source: Any) -> Trajectory:
    about = stored.about
    # The one parameter that is a setting of the method, not of the model.
    automaton = with_chatter_limit(automaton, about["parameters"].get("chatter", 0.0))
    _check_same(stored, "states", list(automaton.state_names))
    saved = about["mode_names"]  # by which steps and events are numbered
    known = automaton.on_demand and all(name in automaton.names for name in saved)
    _check_same(stored, "mode_names", saved if known else list(automaton.names))
    _check_same(stored, "parameters", {name: float(value) for name, value in automaton.values.items()})
    program, numbers = program_of_modes(automaton, tuple(saved)) if known else program_of(automaton)
    _check_same(stored, "guards", list(program.guards))
    _check_arrays(stored, len(program.guards))
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


def _check_same(stored: StoredRun, what: str, given: Any) -> None:
    """Raise ValueError unless the automaton has what the run had."""
    saved = stored.about[what]
    if given == saved:
        return
    if isinstance(saved, dict):
        names = sorted(name for name in {**saved, **given} if saved.get(name) != given.get(name))
        saved, given = ({name: values.get(name) for name in names} for values in (saved, given))
    raise ValueError(
        f"{stored.path} holds a run with the {what.replace('_', ' ')} {saved}, got {given}: "
        "give load(path, model=...) the model or automaton of that run"
    )


def _ascend(times: np.ndarray) -> bool:
    """Whether times are an ascending list, from 0 on."""
    return times.ndim == 1 and bool((np.diff(times, prepend=0.0) >= 0.0).all())


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


def _check_arrays(stored: StoredRun, guards: int) -> None:
    """Raise ValueError unless lengths agree and indices are in range: the kernels check none."""
    about, arrays = stored.about, stored.arrays
    states, modes = len(about["states"]), len(about["mode_names"])
    steps, events, points = (len(arrays[name]) for name in ("step_modes", "event_times", "point_times"))
    shapes = {
        "step_times": (steps, 2),
        "step_states": (steps, states),
        "event_codes": (events, 3),
        "event_states": (events, 2, states),
        "point_sections": (points,),
        "point_states": (points, states),
        "state": (states,),
    }
    indices = {
        "step_modes": (arrays["step_modes"], 0, modes),
        "the guards in event_codes": (arrays["event_codes"][:, 0], 0, guards),
        "the modes in event_codes": (arrays["event_codes"][:, 1], -1, modes),
        "point_sections": (arrays["point_sections"], 0, len(about["samples"]["sections"])),
        "mode": (np.array([about["mode"]]), -1, modes),
        "order": (np.array([about["samples"]["order"]]), 1, MAX_ORDER + 1),
        "parts": (np.array([about["samples"]["parts"]]), 1, MAX_PARTS + 1),
    }
    wrong = [name for name, shape in shapes.items() if arrays[name].shape != shape]
    numbers = [name for name in arrays if name not in INTEGER_ARRAYS]
    wrong += [name for name in numbers if arrays[name].dtype != np.float64]
    if not _ascend(arrays.get("t_eval", np.zeros(0))) or not _ascend(arrays["step_times"][..., 0]):
        wrong.append("step_times or t_eval")
    for name, (values, low, high) in indices.items():
        if values.dtype.kind not in "iu" or (values < low).any() or (values >= high).any():
            wrong.append(name)
    if wrong:
        raise ValueError(f"{stored.path} is damaged, its {', '.join(wrong)} cannot be: save the run again")
