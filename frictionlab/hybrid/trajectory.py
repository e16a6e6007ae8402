"""The result of a run: samples, events, dense output, named outputs.

`RunData` holds the state at the start of every step; samples and dense output are computed from it when they
are asked for, by the Taylor series of the step.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from functools import cached_property, partial
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from frictionlab.automaton import HybridAutomaton
from frictionlab.hybrid.accuracy import chatter_warning, defect_warning, defects, sampled_steps
from frictionlab.hybrid.chatter_limit import CHATTER
from frictionlab.hybrid.codegen.native_cache import native_code
from frictionlab.hybrid.guard_bounds import condition_violation
from frictionlab.hybrid.jamming import contact_behind, jammed_contact
from frictionlab.hybrid.kernels.run_state import StepData, jet_columns
from frictionlab.hybrid.kernels.taylor_steps import sample_states, subdivide_steps
from frictionlab.hybrid.outputs import evaluate_outputs
from frictionlab.hybrid.problem import Problem, RunData, Sampling, Status
from frictionlab.hybrid.real_powers import negative_base
from frictionlab.hybrid.run_events import EventOutputs, Events, SectionPoints
from frictionlab.hybrid.run_file import STORED_ARRAYS, rates_by_mode, write_run_file
from frictionlab.hybrid.variational.tangent_jets import state_on_constraints
from frictionlab.presentation import (
    Drawable,
    FrozenMapping,
    count,
    dataframe,
    dataset,
    impulse_unit,
    output_unit,
    unit_of_state,
)
from frictionlab.tape.automaton_data import storable_automaton
from frictionlab.tape.packing import program_of, program_of_modes
from frictionlab.validation import (
    ATTRIBUTES_ELSEWHERE,
    abbreviate,
    check_sequence,
    did_you_mean,
    float_array,
)

PICKLED = "automaton", "source", "raw", "status", "samples", "_quadratures", "_description", "_wall_time"


def check_run(run: Any) -> None:
    """Raise TypeError unless it is a run."""
    if not isinstance(run, Trajectory):
        raise TypeError(
            f"run must be a Trajectory, got {abbreviate(run)}: "
            "give what frictionlab.simulate or solve returns"
        )


class Trajectory(Drawable):
    """The result of a run.

    Samples are computed from the stored steps when they are first asked for.  ``run(t)`` gives the states
    at any times of the run; at an event, those after it.  States and outputs have names: ``run["x1"]``,
    ``run.normal_force``.  ``run.save("run.npz")`` writes the run, :func:`frictionlab.load` reads it.

    Attributes
    ----------
    t : (N,) times: `t_eval` where it was given, else every step cut in parts, eight for Taylor
    q, v : (N, n) coordinates and velocities;  states : (N, 2n) both
    mode : (N,) names of the modes
    events : Events
    time_in_mode : mapping: seconds spent in each mode
    final_state : (2n,) state at the end, on the constraints of its mode, so that a run can go on from it
    status : Status;  str(status) is a sentence
    stats : mapping: steps, events, Zeno accumulations closed, wall time in seconds
    defect : mapping: largest defect of a step in each mode
    warning : str or None: what is wrong where some of these defects are beyond the tolerance
    violation : largest violation of a mode's condition at a sample, as a share of the condition's size
    sections : mapping of name to SectionPoints;  quadratures : mapping of name to the integral up to the end
    automaton : the automaton that ran;  source : the model it came from, if any
    description : mapping that :meth:`save` writes beside the arrays: the method, the end time
    problem : Problem, what the method was given: the automaton as a program, and its numbers
    raw : RunData, the arrays that the method gave back

    Examples
    --------
    >>> import frictionlab as fl
    >>> run = fl.simulate(fl.SliderOnBelt(mu_k=1.4), 0.05)
    >>> run
    Trajectory(0 to 0.05 s, 6 steps, 1 event, finished)
    >>> run["x1"].shape == run.t.shape  # a state, at the times of the samples
    True
    >>> float(run.normal_force.max().round(1))  # an output, N
    196.6
    >>> run.output("penetration", [0.01, 0.02]).round(4)  # at other times
    array([0.009 , 0.0263])
    >>> {mode: round(seconds, 4) for mode, seconds in run.time_in_mode.items() if seconds}
    {'stick': 0.0345, 'slip+': 0.0155}
    """

    instead_of_array = "write run.states, a row for each time, or run['x1']"
    drawn_by = "plot_displacements"
    _modes: Any  # in a pickled copy: with `_start`, what `problem` is made from again
    _start: Any

    def __init__(
        self,
        automaton: HybridAutomaton,
        problem: Problem,
        raw: RunData,
        samples: Sampling,
        *,
        quadratures: Mapping[str, float] | None = None,
        description: Mapping[str, Any] | None = None,
        source: Any = None,
        wall_time: float = 0.0,
    ) -> None:
        self.automaton, self.source = automaton, source
        self.problem = problem
        self.raw, self.status, self.samples = raw, raw.status, samples
        self._quadratures, self._description = quadratures or {}, description or {}
        self._wall_time = wall_time

    def from_source(self, source: Any) -> Trajectory:
        """The same run as one that came from a model: its units, outputs of events and energies are known."""
        return Trajectory(
            self.automaton,
            self.problem,
            self.raw,
            self.samples,
            quadratures=self._quadratures,
            description=self._description,
            source=source,
            wall_time=self._wall_time,
        )

    @cached_property
    def problem(self) -> Problem:
        """What the method was given; a pickled copy makes it again, as compiled functions are not pickled."""
        if self._modes is None:
            return Problem(*program_of(self.automaton), *self._start)
        return Problem(*program_of_modes(self.automaton, self._modes), *self._start)

    def __getstate__(self) -> dict[str, Any]:
        start = self.problem.x0, self.problem.t_end, self.problem.mode
        names = self.mode_names if self.automaton.on_demand else None
        return {name: vars(self)[name] for name in PICKLED} | {"_modes": names, "_start": start}

    @property
    def quadratures(self) -> Mapping[str, float]:
        return FrozenMapping(self._quadratures)

    @property
    def description(self) -> Mapping[str, Any]:
        return FrozenMapping(self._description)

    @property
    def mode_names(self) -> tuple[str, ...]:
        """Names of the modes, indexed by the mode numbers in `raw`.

        Modes on demand: those that had been derived, in that order, or all if their program is kept for later
        processes.  Other automata: all their modes.
        """
        return self.problem.program.modes

    @property
    def mode_places(self) -> tuple[int, ...]:
        """The place of each mode of `mode_names` in the automaton's order."""
        return tuple(map(self.automaton.place_of_mode, self.mode_names))

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the states."""
        return self.automaton.state_names

    @cached_property
    def _samples(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Times, states and modes of the samples."""
        raw = self.raw
        if self.samples.t_eval is not None:
            t = self.samples.t_eval[self.samples.t_eval <= raw.t]
            steps = self._steps_at(t)
        else:
            t, steps = subdivide_steps(raw.step_times, self.samples.parts)
            # Between impacts at one instant the clock may not resolve a step: its parts round to its end.
            within = t < np.append(raw.step_times[1:, 0], raw.t)[steps]
            t, steps = np.append(t[within], raw.t), np.append(steps[within], len(raw.step_modes))
        return t, self._states_in_steps(t, steps), self._modes_of_steps(steps)

    def _steps_at(self, t: np.ndarray) -> np.ndarray:
        """Step that holds each time; one past the last step stands for the final state."""
        steps = np.searchsorted(self.raw.step_times[:, 0], t, side="right") - 1
        return np.where(t >= self.raw.t, len(self.raw.step_modes), steps)

    def _modes_of_steps(self, steps: np.ndarray) -> np.ndarray:
        return np.append(self.raw.step_modes, self.raw.mode)[steps]

    def _states_in_steps(self, t: np.ndarray, steps: np.ndarray) -> np.ndarray:
        raw, program, order = self.raw, self.problem.program, self.samples.order
        out = np.empty((len(t), raw.state.size))
        inside = steps < len(raw.step_modes)
        part = np.empty((int(inside.sum()), raw.state.size))
        J = np.zeros((program.slots, jet_columns(order)))
        stored = StepData(raw.step_times, raw.step_modes, raw.step_states)
        code = native_code(program).code
        sample_states(code, self.problem.numbers, order, stored, steps[inside], t[inside], part, J)
        out[inside], out[~inside] = part, raw.state
        return out

    def __call__(self, t: Any) -> np.ndarray:
        """States at times `t`: (states,) for one time, (..., states) for an array (...) of them.

        Raises
        ------
        ValueError
            Outside the run.
        """
        states, _ = self.states_and_modes(t)
        return states.reshape(*np.shape(t), states.shape[1])

    def states_and_modes(self, t: Any) -> tuple[np.ndarray, np.ndarray]:
        """States (N, states) and modes (N,) at N times of any shape; the modes are indices into `mode_names`.

        Raises
        ------
        ValueError
            Outside the run.
        """
        times = self._checked_times(t)
        order, steps = np.argsort(times, kind="stable"), self._steps_at(times)
        states = np.empty((len(times), self.raw.state.size))
        states[order] = self._states_in_steps(times[order], steps[order])
        return states, self._modes_of_steps(steps)

    def _checked_times(self, t: Any) -> np.ndarray:
        times = float_array("t", t, "give times of the run, in seconds").ravel()
        if times.size and not (times.min() >= 0.0 and times.max() <= self.raw.t):
            raise ValueError(
                f"t must lie within the run, 0 to {self.raw.t:g} s, got {times.min():g} to {times.max():g}: "
                "simulate longer"
            )
        return times

    def modes_at(self, t: Any) -> np.ndarray:
        """Names of the modes at times `t`, in the shape of `t`; at an event, the mode entered."""
        names = self._mode_names(self._modes_of_steps(self._steps_at(self._checked_times(t))))
        return names.reshape(np.shape(t))[()]

    @property
    def t(self) -> np.ndarray:
        return self._samples[0]

    @property
    def states(self) -> np.ndarray:
        return self._samples[1]

    @property
    def q(self) -> np.ndarray:
        return self.states[:, : self.automaton.coordinates]

    @property
    def v(self) -> np.ndarray:
        n = self.automaton.coordinates
        return self.states[:, n : 2 * n]

    @cached_property
    def mode(self) -> np.ndarray:
        return self._mode_names(self.mode_indices)

    @property
    def mode_indices(self) -> np.ndarray:
        """The modes at the samples, as indices into `mode_names`."""
        return self._samples[2]

    def _mode_names(self, codes: np.ndarray) -> np.ndarray:
        return np.array([*self.mode_names, ""])[codes]

    def __getitem__(self, name: str | Sequence[str]) -> np.ndarray:
        """A state by name, e.g. ``run["x1'"]``, or an output, e.g. ``run["penetration"]``, at the samples.

        Several names give an array with a column for each: ``run[["x1", "x2"]]``.
        """
        if not isinstance(name, str):
            several = check_sequence("name", name, "write run['x'] or run[['x', 'y']]; run(t) gives a time")
            if not all(isinstance(each, str) for each in several) or not several:
                raise KeyError(f"the run has no {abbreviate(name)}: write run['x'], or run[['x', 'y']]")
            return np.column_stack([self[each] for each in several])
        if name in self.names:
            return self.states[:, self.names.index(name)]
        if name in self.automaton.outputs:
            return self.output(name)
        known = [*self.names, *self.automaton.outputs]
        raise KeyError(
            f"the run has no {abbreviate(name)}{did_you_mean(name, known)}; it has {', '.join(known)}"
        )

    def __getattr__(self, name: str) -> np.ndarray:
        automaton = self.__dict__.get("automaton")
        if automaton is None or name not in automaton.outputs:
            known = [*dir(type(self)), *(automaton.outputs if automaton else ())]
            if name in ATTRIBUTES_ELSEWHERE:
                raise AttributeError(f"a Trajectory has no attribute {name!r}: {ATTRIBUTES_ELSEWHERE[name]}")
            raise AttributeError(f"a Trajectory has no attribute {name!r}{did_you_mean(name, known)}")
        return self.output(name)

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self.automaton.outputs]

    def output(self, name: str, t: Any = None) -> Any:
        """An output of the model at the samples, or at times `t`: a number for one time, else an array of the
        shape of `t`.

        Raises
        ------
        KeyError
            Where the model has no output of that name.
        """
        known = list(self.automaton.outputs)
        if not isinstance(name, str) or name not in known:
            state = isinstance(name, str) and name in self.names
            hint = f": write run[{name!r}]" if state else did_you_mean(name, known)
            raise KeyError(
                f"the run has no output {abbreviate(name)}{hint}; it has {', '.join(known) or 'none'}"
            )
        states_and_modes = (self.states, self.mode_indices) if t is None else self.states_and_modes(t)
        values = evaluate_outputs(self.automaton, [name], *states_and_modes, self.mode_names)[name]
        if t is None:
            return values
        return values.reshape(np.shape(t)) if np.ndim(t) else float(values[0])

    @property
    def events(self) -> Events:
        # Made anew: events know the run for their outputs, and a run that knew them would never be free.
        return Events(**self._columns_of_events, outputs=partial(getattr, self, "_outputs_of_events"))

    @cached_property
    def _columns_of_events(self) -> dict[str, Any]:
        raw, program = self.raw, self.problem.program
        guards = raw.event_codes[:, 0]
        return {
            "t": raw.event_times,
            "source": self._mode_names(program.guard_modes[guards] if len(guards) else guards),
            "target": self._mode_names(raw.event_codes[:, 1]),
            "guard": np.array([*program.guards, ""])[guards],
            "state": raw.event_states[:, 1],
            "before": raw.event_states[:, 0],
            "closed": raw.event_codes[:, 2].astype(bool),
            "names": self.names,
            "units": tuple(unit_of_state(self.source, name) for name in self.names),
        }

    @cached_property
    def _outputs_of_events(self) -> EventOutputs:
        """The impulses, where a model says what they are, and their units."""
        if not hasattr(self.source, "outputs_of_events"):
            return EventOutputs()
        values = self.source.outputs_of_events(self.events, self.states)
        return EventOutputs(values, {name: impulse_unit(name, self.source) for name in values})

    @cached_property
    def _final_state(self) -> np.ndarray:
        if not self.status.ok:
            return self.raw.state
        problem = self.problem
        return state_on_constraints(problem.program, problem.numbers, self.raw.mode, self.raw.state)

    @property
    def final_state(self) -> np.ndarray:
        return self._final_state.copy()

    @cached_property
    def time_in_mode(self) -> Mapping[str, float]:
        """Seconds spent in each mode; where modes are derived on demand, in each that was visited."""
        modes, lengths = self.raw.step_modes, self.raw.step_times[:, 1]
        on_demand = self.automaton.on_demand
        numbers = np.unique(modes).tolist() if on_demand else range(len(self.mode_names))
        # Summed exactly: they add up to the time of the run, whose clock is a compensated sum.
        return FrozenMapping({self.mode_names[i]: math.fsum(lengths[modes == i]) for i in numbers})

    @cached_property
    def stats(self) -> Mapping[str, float]:
        closed = int(self.raw.event_codes[:, 2].sum())
        counts = {"steps": len(self.raw.step_modes), "events": len(self.raw.event_times)}
        return FrozenMapping(counts | {"accumulations": closed, "wall_time": self._wall_time})

    @cached_property
    def defect(self) -> Mapping[str, float]:
        """Largest defect of the steps in each visited mode; for the whole run ``max(run.defect.values())``.

        It is the residual |x' - f(x)| of the dense output times the length of the step, or the jump from its
        end to the next state if that is larger, less rounding; as a share of the largest state of the group
        (coordinates, velocities, others) in that step.  It compares with the tolerance.  The jump shows the
        error of RK4 and scipy's methods, the residual that of the Taylor series.
        """
        return defects(self.problem, self.raw, self.samples.order)

    @cached_property
    def warning(self) -> str | None:
        """What is wrong with the run, or None.

        There are five warnings.  Some steps by series are far less exact than the tolerance.  Flights were
        replaced by their limit and are not short beside the stays in modes.  The run ended because the base
        of a power became negative, or because a rigid contact that rubs has no reaction.  It began behind a
        rigid contact.  Defects are measured as a share of the motion's size, in some steps of each mode whose
        equations are no polynomials of a low degree.
        """
        if self.status is not Status.FINISHED and (words := self._cause_of_end()):
            return f"it ended at {self.raw.t:g} s with {words}"
        code, order, codes = self.problem.program.code, self.samples.order, self.raw.event_codes
        if len(codes) and codes[:, 2].any() and np.isin(codes[:, 1], code.limits).any():
            words = chatter_warning(self.raw, self.automaton.values.get(CHATTER, 0.0))
            if words:
                return words
        if self.problem.program.highest_degree < order:  # the series of polynomials tell
            return None
        visited = np.bincount(self.raw.step_modes, minlength=len(code.degrees)) > 0
        modes = np.flatnonzero(visited & (code.degrees >= order))
        if not len(modes) or (tol := self._tolerance) is None:
            return None
        return defect_warning(self.problem, self.raw, order, tol, sampled_steps(self.raw, modes))

    def _cause_of_end(self) -> str:
        raw, about = self.raw, (self.automaton, self.problem, self.raw.state)
        words = ""
        if raw.status is Status.NOT_FINITE and self.problem.program.code.powers[raw.mode]:
            words = negative_base(*about, raw.mode)
        jams = raw.status in (Status.NO_ADMISSIBLE_MODE, Status.NOT_FINITE, Status.STALLED)
        words = words or (jammed_contact(*about) if jams else "")
        if not words and raw.status is Status.NO_ADMISSIBLE_MODE and not len(raw.event_times):
            words = contact_behind(self.automaton, raw.state)
        return words

    @property
    def _tolerance(self) -> float | None:
        """The relative tolerance of a method by series; None for others."""
        return self.description.get("method", {}).get("tol")

    def defect_warning(self) -> str | None:
        """What is wrong where a defect of any step is beyond the tolerance, or None."""
        tol = self._tolerance
        return None if tol is None else defect_warning(self.problem, self.raw, self.samples.order, tol)

    @cached_property
    def violation(self) -> float:
        """Largest violation of a mode's condition at a sample, as a share of the condition's size."""
        return condition_violation(self.problem, self.raw, self.states, self.mode_indices)

    @cached_property
    def sections(self) -> Mapping[str, SectionPoints]:
        raw = self.raw
        chosen = {name: raw.point_sections == i for i, name in enumerate(self.samples.sections)}
        points = {k: SectionPoints(raw.point_times[m], raw.point_states[m]) for k, m in chosen.items()}
        return FrozenMapping(points)

    def save(self, path: str | Path) -> Path:
        """Write the run to an npz file, which :func:`frictionlab.load` reads; returns its path."""
        raw, samples, program = self.raw, self.samples, self.problem.program
        about = {
            "states": self.names,
            "parameters": {name: float(value) for name, value in self.automaton.values.items()},
            "mode_names": program.modes,
            "guards": program.guards,
            "rates": rates_by_mode(self.problem, raw),
            "t": raw.t,
            "mode": int(raw.mode),
            "status": raw.status.name,
            "samples": {"order": samples.order, "parts": samples.parts, "sections": samples.sections},
            "quadratures": dict(self.quadratures),
            "wall_time": self._wall_time,
            "description": dict(self.description),
        }
        with suppress(TypeError):  # a model with a field that no file can hold
            if hasattr(self.source, "to_dict"):
                about["description"]["model"] = self.source.to_dict()
        if "model" not in about["description"]:
            about["automaton"] = storable_automaton(self.automaton)
        arrays = {name: getattr(raw, name) for name in STORED_ARRAYS}
        if samples.t_eval is not None:
            arrays["t_eval"] = samples.t_eval
        return write_run_file(path, about, arrays)

    def _repr_html_(self) -> str:
        """What a notebook shows: the summary; of each mode the time in it and how often it was entered."""
        entered = self.events.target.tolist()
        rows = "".join(
            f"<tr><th>{escape(mode)}</th><td>{seconds:.5g}</td><td>{entered.count(mode)}</td></tr>"
            for mode, seconds in self.time_in_mode.items()
        )
        head = "<tr><th>mode</th><th>time (s)</th><th>entered</th></tr>"
        return f"<p>{escape(repr(self))}</p><table><thead>{head}</thead><tbody>{rows}</tbody></table>"

    def to_dataframe(self) -> Any:
        """The samples as a pandas DataFrame, indexed by time (needs the extra ``data``).

        Its ``attrs["units"]`` has the units of the columns.
        """
        return dataframe(self._columns() | {"mode": self.mode}, {"t": self.t}, self._units())

    def to_xarray(self) -> Any:
        """The samples as an xarray Dataset along the dimension "t" (needs the extra ``data``).

        Variables have the attribute "units"; the attributes of the Dataset are the parameters, the method and
        the status.
        """
        about = {
            "method": str(self.description.get("method", {}).get("name", "")),
            "status": str(self.status),
        }
        numbers = {name: float(value) for name, value in self.automaton.values.items()}
        variables = {name: ("t", values) for name, values in self._columns().items()}
        variables |= {"mode": ("t", self.mode)}
        return dataset(variables, {"t": self.t}, self._units(), numbers | about)

    def _columns(self) -> dict[str, np.ndarray]:
        return {name: self[name] for name in (*self.names, *self.automaton.outputs)}

    def _units(self) -> dict[str, str]:
        states = {name: unit_of_state(self.source, name) for name in self.names}
        return {"t": "s"} | states | {name: output_unit(name, self.source) for name in self.automaton.outputs}

    def __repr__(self) -> str:
        steps, events = count(len(self.raw.step_modes), "step"), count(len(self.events), "event")
        end = f"0 to {self.raw.t:g} s, {steps}, {events}"
        doubt = "" if self.warning is None else f"; do not trust it: {self.warning}"
        return f"Trajectory({end}, {self.status.name.lower()}{doubt})"
