"""Runs on disk: one npz file of arrays, with a description as JSON among them.

A file is written beside its place and then renamed, so that a full disk leaves what was there.  The archive
has a checksum of each array.  Shapes and indices are checked before kernels see them, as kernels check none.
Errors name the path.
"""

from __future__ import annotations

import io
import json
import re
import tokenize
import zipfile
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from frictionlab._version import __version__
from frictionlab.file_writing import read_file, write_file
from frictionlab.hybrid.kernels.jets import state_rates
from frictionlab.hybrid.problem import Problem, RunData
from frictionlab.validation import abbreviate, check_path

FILE_FORMAT = 2
STORED_ARRAYS = (*RunData._fields[:9], "state")  # of a run; its last time, mode and status are in the JSON
INTEGER_ARRAYS = "step_modes", "event_codes", "point_sections"
CURE = "save the run again"
OTHER_SUFFIX = re.compile(r"\.[A-Za-z]\w*")

# What the readers of archives, arrays and JSON raise where the content is no such thing.
DAMAGED = (
    *(zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError, OSError, MemoryError),
    *(ValueError, TypeError, KeyError, AttributeError, SyntaxError, OverflowError, tokenize.TokenError),
)


@dataclass(frozen=True)
class StoredRun:
    """The content of a file: its path, the JSON about the run, and its arrays by name."""

    path: Path
    about: dict[str, Any]
    arrays: dict[str, np.ndarray]

    @property
    def description(self) -> dict[str, Any]:
        """The description of the run: its method, its end time, its model if it had one."""
        return self.about["description"]


def path_of_run(path: Any) -> Path:
    """The path of a run's file, with the suffix .npz added where there is none."""
    path = check_path("path", path)
    if path.suffix == ".npz":
        return path
    if OTHER_SUFFIX.fullmatch(path.suffix):  # such as .mp3; "mu_k=0.5" has none
        check_path("path", path, (".npz",))
    return path.with_name(path.name + ".npz")


def write_run_file(path: str | Path, about: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> Path:
    """Write `about` as JSON, and arrays; returns the path, with the suffix .npz added where it is missing."""
    path = path_of_run(path)
    text = json.dumps({"format": FILE_FORMAT, "version": __version__, **about})
    everything: dict[str, Any] = {"about": np.array(text), **arrays}
    with write_file(path) as beside, open(beside, "wb") as stream:
        np.savez_compressed(stream, **everything)
    return path


def read_run_file(path: str | Path) -> StoredRun:
    """Read a file that :func:`write_run_file` wrote.

    Raises
    ------
    OSError
        Where there is none, or it cannot be read.
    ValueError
        Where it is not such a file.
    """
    path = check_path("path", path)
    content = io.BytesIO(read_file(path, "give a file that run.save(path) wrote"))
    try:
        about = json.loads(str(_arrays(content, ["about.npy"])["about"]))
        form, version = about.get("format"), about.get("version")
    except DAMAGED as error:
        raise ValueError(f"{path} is no saved run: write one with run.save(path)") from error
    if form != FILE_FORMAT:
        raise ValueError(
            f"{path} has format {abbreviate(form)}, this version reads {FILE_FORMAT}: read it "
            f"with frictionlab {str(version)[:20]}"
        )
    try:
        arrays = _arrays(content)
        del arrays["about"]
        check_arrays(about, arrays)
    except (*DAMAGED, LookupError) as error:
        raise ValueError(f"{path} is damaged, {error!r}: {CURE}") from error
    return StoredRun(path, about, arrays)


def _arrays(content: io.BytesIO, names: Sequence[str] | None = None) -> dict[str, np.ndarray]:
    """Some arrays of a file, by default all."""
    with zipfile.ZipFile(content) as file:
        # Each is read whole, so that its checksum is compared before numpy reads its content.
        parts = {name: io.BytesIO(file.read(name)) for name in names or file.namelist()}
    return {
        name.removesuffix(".npy"): np.lib.format.read_array(part, allow_pickle=False)
        for name, part in parts.items()
    }


def rates_by_mode(problem: Problem, raw: RunData) -> dict[str, list[float]]:
    """Rates of the states at the first step in each visited mode, to tell whether equations are the same."""
    program, by_mode = problem.program, {}
    jets, rates = np.zeros((program.slots, 1)), np.empty(raw.state.size)
    for mode in np.unique(raw.step_modes):
        state = raw.step_states[np.argmax(raw.step_modes == mode)]
        state_rates(program.code, problem.numbers, int(mode), state, jets, rates)
        by_mode[program.modes[mode]] = rates.tolist()
    return by_mode


def check_arrays(about: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> None:
    """Raise ValueError unless the arrays agree in length, and refer to modes and guards that there are."""
    steps, events, points = (len(arrays[name]) for name in ("step_modes", "event_times", "point_times"))
    states, modes = len(about["states"]), len(about["mode_names"])
    shapes: dict[str, tuple[int, ...]] = {
        "step_times": (steps, 2),
        "step_modes": (steps,),
        "step_states": (steps, states),
        "event_times": (events,),
        "event_codes": (events, 3),
        "event_states": (events, 2, states),
        "point_times": (points,),
        "point_sections": (points,),
        "point_states": (points, states),
        "state": (states,),
    }
    for name, shape in shapes.items():
        array, kind = arrays[name], np.dtype(np.int64 if name in INTEGER_ARRAYS else np.float64)
        if array.shape != shape or array.dtype != kind:
            raise ValueError(f"{name} must be {kind} {shape}, got {array.dtype} {array.shape}")
    indices = {
        "step_modes": (arrays["step_modes"], 0, modes),
        "guards in event_codes": (arrays["event_codes"][:, 0], 0, len(about["guards"])),
        "modes in event_codes": (arrays["event_codes"][:, 1], -1, modes),
        "mode": (np.array([about["mode"]]), -1, modes),
    }
    for name, (values, low, high) in indices.items():
        outside = values[(values < low) | (values >= high)]
        if len(outside):
            raise ValueError(f"{name} must be from {low} to {high - 1}, got {outside[0]}")
