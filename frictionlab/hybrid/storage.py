"""Runs on disk: one npz file of arrays, with the description as JSON among them."""

from __future__ import annotations

import json
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from frictionlab._version import __version__
from frictionlab.automaton import HybridAutomaton
from frictionlab.automaton.modes_on_demand import ModesOnDemand
from frictionlab.hybrid.problem import Problem, RunData, Status
from frictionlab.hybrid.tape.packing import program_of
from frictionlab.hybrid.trajectory import Sampling, Trajectory

FILE_FORMAT = 1
ARRAYS = RunData._fields[:9]


def write_run_file(run: Trajectory, path: str | Path) -> Path:
    """Write a run; the suffix .npz is added where it is missing."""
    path = Path(path)
    path = path if path.suffix == ".npz" else path.with_name(path.name + ".npz")
    raw, program = run.raw, run.problem.program
    about = {
        "format": FILE_FORMAT,
        "version": __version__,
        "states": run.names,
        "parameters": {str(k): v for k, v in run.automaton.parameters.items()},
        "t": raw.t,
        "mode": int(raw.mode),
        "modes": [name for name, built in zip(program.modes, program.code.built, strict=True) if built],
        "status": raw.status.name,
        "samples": {"order": run.samples.order, "parts": run.samples.parts},
        "sections": run.section_names,
        "quadratures": dict(run.quadratures),
        "wall_time": run.stats["wall_time"],
        "description": run.description,
    }
    arrays = {name: getattr(raw, name) for name in (*ARRAYS, "state")}
    if run.samples.t_eval is not None:
        arrays["t_eval"] = run.samples.t_eval
    np.savez_compressed(path, about=np.array(json.dumps(about)), **arrays)
    return path


@dataclass(frozen=True)
class StoredRun:
    """The content of a file."""

    about: dict[str, Any]
    arrays: dict[str, np.ndarray]

    @property
    def description(self) -> dict[str, Any]:
        """The description of the run."""
        return self.about["description"]

    def trajectory(self, automaton: HybridAutomaton, source: Any = None) -> Trajectory:
        """The run, on the automaton that made it."""
        names = [str(state) for state in automaton.states]
        if names != self.about["states"]:
            raise ValueError(
                f"the run has the states {self.about['states']}, the model {names}: give the right model"
            )
        about, modes = self.about, None
        if isinstance(automaton.modes, ModesOnDemand) and "modes" in about:
            modes = automaton.modes.known(about["modes"])  # by which the events are numbered
        program, numbers = program_of(automaton, modes=modes)
        arrays = {name: self.arrays[name] for name in (*ARRAYS, "state")}
        status = Status[about["status"]]
        raw = RunData(**arrays, t=about["t"], mode=about["mode"], status=status)
        samples = Sampling(**about["samples"], t_eval=self.arrays.get("t_eval"))
        problem = Problem(program, numbers, raw.state, about["t"])
        return Trajectory(
            automaton,
            problem,
            raw,
            samples,
            sections=tuple(about["sections"]),
            quadratures=about["quadratures"],
            description=self.description,
            source=source,
            wall_time=about["wall_time"],
        )


def read_run_file(path: str | Path) -> StoredRun:
    """Read a file that :func:`write_run_file` wrote.

    Raises
    ------
    ValueError
        Where it is not such a file.
    """
    try:
        with open(path, "rb") as stream, np.load(stream, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
        about = json.loads(str(arrays.pop("about")))
    except (zipfile.BadZipFile, EOFError, ValueError, TypeError, KeyError, AttributeError) as error:
        raise ValueError(f"{path} is no saved run: write one with run.save(path)") from error
    if about.get("format") != FILE_FORMAT:
        raise ValueError(
            f"{path} has format {about.get('format')}, this version reads {FILE_FORMAT}: update frictionlab"
        )
    return StoredRun(about, arrays)
