"""`fl.simulate`: run a model from an initial state ("rest", "near", an array); `fl.load`: read a file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from frictionlab.automaton import HybridAutomaton
from frictionlab.hybrid.chatter_limit import with_chatter_limit
from frictionlab.hybrid.methods.base import Method
from frictionlab.hybrid.problem import Problem, RunData, Sampling, Status
from frictionlab.hybrid.run_file import (
    STORED_ARRAYS,
    StoredRun,
    rates_by_mode,
    read_run_file,
)
from frictionlab.hybrid.solve import (
    RunOptions,
    method_of,
    run_automaton,
    state_from_mapping,
    state_from_x0,
    with_warning,
)
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.models import MechanicalModel
from frictionlab.models.automaton_of_model import automaton_from_structure_data
from frictionlab.models.mechanical.masses import check_masses
from frictionlab.models.model import Model, ModelOrAutomaton, automaton_of, require_model
from frictionlab.stability.eigenproblems.displaced_equilibrium import displaced_equilibrium
from frictionlab.tape.automaton_data import DERIVED_FROM, automaton_from_data
from frictionlab.tape.packing import program_of, program_of_modes
from frictionlab.validation import (
    abbreviate,
    check_choice,
    check_mapping,
    check_number,
    explains_keywords,
    float_array,
)

RATES_RTOL = 1e-9  # rates by the same equations agree to rounding, on every processor


def model_initial_state(model: ModelOrAutomaton, x0: Any, automaton: HybridAutomaton | None = None) -> Any:
    """The initial state that a name, a mapping or an array stands for.

    States that a mapping leaves out are as at rest; those that an array leaves out are zero.  Give the
    model's automaton where it is at hand, to save its assembly.
    """
    if not isinstance(model, Model):
        return _automaton_initial_state(model, x0)
    automaton = model.automaton() if automaton is None else automaton
    if isinstance(x0, Mapping):
        return state_from_mapping(automaton, x0, model_initial_state(model, "rest", automaton))
    n, names = len(model.coordinates), list(automaton.state_names)
    if not isinstance(x0, str):
        given = float_array("x0", x0, f"give a number for each of the states {', '.join(names)}")
        return np.append(given, np.zeros(len(names) - 2 * n)) if given.shape == (2 * n,) else given
    check_choice("x0", x0, ("rest", "near"), "or give numbers, one for each state")
    if x0 == "near":
        return displaced_equilibrium(model)
    start = np.zeros(len(names))
    for name, value in model.release().items():
        start[names.index(name)] = value
    return start


def _automaton_initial_state(automaton: HybridAutomaton, x0: Any) -> Any:
    if isinstance(x0, Mapping):
        return state_from_mapping(automaton, x0, np.zeros(len(automaton.state_names)))
    if isinstance(x0, str):
        check_choice("x0", x0, ("rest",), "or give numbers, one for each state")
        return np.zeros(len(automaton.state_names))
    return x0


def named_state(x0: Any) -> Any:
    """An initial state of any model as data that JSON can hold; names stay names.

    Raises ValueError for what is none of any model.
    """
    if isinstance(x0, Mapping):
        check_mapping("x0", x0, "give states by their names")
        cure = "give one in SI units"
        return {name: check_number(f"x0[{abbreviate(name)}]", each, cure=cure) for name, each in x0.items()}
    if isinstance(x0, str):
        return x0
    numbers = float_array("x0", x0, "give a number for each state", finite=True)
    if numbers.ndim != 1 or not numbers.size:
        raise ValueError(f"x0 must be a list of numbers, got {abbreviate(x0)}: give one for each state")
    return numbers.tolist()


def initial_state_of(
    model: ModelOrAutomaton, x0: Any, automaton: HybridAutomaton | None = None
) -> np.ndarray:
    """The initial state (n,) of a run of a model or an automaton; raises for a bad `x0`."""
    automaton = automaton_of(model) if automaton is None else automaton
    start = state_from_x0(automaton, model_initial_state(model, x0, automaton))
    if isinstance(model, MechanicalModel):
        check_masses(model, start)
    return start


@explains_keywords
def simulate(
    model: Model,
    t_end: float,
    *,
    x0: Any = "rest",
    method: str | Method = "taylor",
    t_eval: Any = None,
    sections: Mapping[str, Any] | None = None,
    quadratures: Mapping[str, Any] | None = None,
    progress: bool = True,
) -> Trajectory:
    """Run a model from 0 to `t_end`.

    Parameters
    ----------
    model : Model
        SliderOnBelt, another of :func:`frictionlab.list_models`, or your own.
    t_end : float
        End time in seconds, positive.
    x0 : "rest", "near", mapping or array_like (2n,)
        "rest": all states zero, but for those that `Model.release` gives.  "near": the sliding
        equilibrium with its coordinates displaced by one percent, velocities zero, further states as at the
        equilibrium.  Where that leaves a growing mode at rest, or all coordinates are zero, the state is
        displaced along the least stable mode: by one percent of the size at which this mode's motion meets
        an event or is no longer linear; by 0.01 in its largest state if it always is.  A mapping such as
        ``{"x1": 0.1, "x1'": -0.2}`` gives some states; the others are as at rest.  An array holds
        coordinates, then velocities; further states of a model, such as the phase of a force, are zero where
        they are left out.
    method : "taylor", "rk4", the name of a scipy method such as "dop853", Taylor(...), RK4(...), Scipy(...)
        "taylor" is exact to rounding; RK4 is the paper's algorithm.
    t_eval : array_like or None
        Ascending times of the samples, one at least; None samples every step.
    sections, quadratures : mapping or None
        See :func:`frictionlab.solve`.
    progress : bool
        Show a progress bar on runs of more than a second.

    Returns
    -------
    Trajectory
        Also if the run ended early: see ``run.status``.

    Warns
    -----
    RuntimeWarning
        Where some steps are far less exact than the tolerance: see ``run.warning``.

    Raises
    ------
    TypeError
        Where `model` is no model.
    ValueError
        For bad arguments, or ``x0="near"`` where there is no equilibrium; before any work is done.
    KeyboardInterrupt
        After ctrl-C; :func:`partial_result` then returns the run as far as it went.

    Examples
    --------
    >>> import frictionlab as fl
    >>> run = fl.simulate(fl.SliderOnBelt(mu_k=1.4), 0.05)
    >>> run.events.target.tolist()
    ['stick']
    """
    cure = (
        "use fl.solve for an automaton"
        if isinstance(model, HybridAutomaton)
        else "write simulate(model, t_end)"
    )
    model = require_model(model, cure=cure)
    chosen = method_of(method)
    options = RunOptions(None, t_eval, sections, quadratures, progress, model)
    automaton = model.automaton()
    start = state_from_x0(automaton, model_initial_state(model, x0, automaton))
    if isinstance(model, MechanicalModel):
        check_masses(model, start)
    return with_warning(run_automaton(automaton, t_end, start, chosen, options))


def load(path: str | Path, model: ModelOrAutomaton | None = None) -> Trajectory:
    """A run that :meth:`Trajectory.save` wrote.

    Parameters
    ----------
    path : path
    model : model or automaton, optional
        The model or automaton of the run; by default that in the file.  Needed for laws and models of your
        own that are not defined in this session.  It must be the same as that of the run.

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
    return _trajectory_in_file(stored, automaton, model if isinstance(model, Model) else None)


def _model_in_file(stored: StoredRun) -> Model:
    try:
        return Model.from_dict(stored.description["model"])
    except (ValueError, TypeError, RecursionError) as error:
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
        if DERIVED_FROM in data:
            return _derived_automaton(stored, data)
        automaton = automaton_from_data(data)
        program_of(automaton)  # checks that it is well formed; the program is cached
        return automaton
    except (ValueError, ArithmeticError) as error:
        raise ValueError(f"{stored.path} is damaged, {error}: save the run again") from error


def _derived_automaton(stored: StoredRun, data: Mapping[str, Any]) -> HybridAutomaton:
    """The automaton of a model with several contacts: a file holds its structure instead of its modes."""
    parameters = stored.about.get("parameters")
    if not isinstance(parameters, dict) or not all(type(value) is float for value in parameters.values()):
        raise ValueError(f"its parameters are {abbreviate(parameters)}")
    automaton = automaton_from_structure_data(data[DERIVED_FROM], Model, parameters)
    if data.get("coordinates") != automaton.coordinates:
        raise ValueError(f"it has {data.get('coordinates')} coordinates instead of {automaton.coordinates}")
    return automaton


def _trajectory_in_file(stored: StoredRun, automaton: HybridAutomaton, source: Model | None) -> Trajectory:
    """The run that a file holds; ValueError where `automaton` is not the one that made it, or the file is
    damaged.
    """
    try:
        return _trajectory(stored, automaton, source)
    except (KeyError, TypeError, AttributeError, IndexError) as error:
        raise ValueError(f"{stored.path} is damaged, {error!r}: save the run again") from error


def _trajectory(stored: StoredRun, automaton: HybridAutomaton, source: Model | None) -> Trajectory:
    about = stored.about
    # The one parameter that is a setting of the method, not of the model.
    automaton = with_chatter_limit(automaton, about["parameters"].get("chatter", 0.0))
    _check_same(stored, "states", list(automaton.state_names))
    saved = about["mode_names"]  # steps and events give modes as places in this list
    known = automaton.on_demand and all(name in automaton.names for name in saved)
    _check_same(stored, "mode_names", saved if known else list(automaton.names))
    _check_same(stored, "parameters", {name: float(value) for name, value in automaton.values.items()})
    program, numbers = program_of_modes(automaton, tuple(saved)) if known else program_of(automaton)
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
