"""Runs on disk: one npz file of arrays, with a description as JSON among them.

A file is written beside its place and then renamed, so that a full disk leaves what was there.  Arrays that
are read are checked before kernels see them, as kernels check no indices; errors name the path.
"""

from __future__ import annotations

import io
import json
import re
import tokenize
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from frictionlab._version import __version__
from frictionlab.file_writing import read_file, write_file
from frictionlab.hybrid.kernels.jets import MAX_ORDER, state_rates
from frictionlab.hybrid.problem import Problem, RunData
from frictionlab.validation import check_path

FILE_FORMAT = 2
LARGE_FILE = 100_000_000  # bytes of arrays, below which a file is read whatever its size
MOST_COMPRESSION = 100  # of the arrays of a large run, whose last bits are random
STORED_ARRAYS = (*RunData._fields[:9], "state")  # of a run; its last time, mode and status are in the JSON
INTEGER_ARRAYS = "step_modes", "event_codes", "point_sections"
OTHER_SUFFIX = re.compile(r"\.[A-Za-z]\w*")
MAX_PARTS = 1000  # into which samples cut a step: methods use eight at most

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
        with zipfile.ZipFile(content) as file:
            _check_sizes(path, file, content.getbuffer().nbytes)
            # each is read whole, so that its checksum is compared before numpy reads its content
            arrays = {
                name.removesuffix(".npy"): np.lib.format.read_array(
                    io.BytesIO(file.read(name)), allow_pickle=False
                )
                for name in file.namelist()
            }
        about = json.loads(str(arrays.pop("about")))
    except _TooLargeError:
        raise
    except DAMAGED as error:
        raise ValueError(f"{path} is no saved run: write one with run.save(path)") from error
    if not isinstance(about, dict) or about.get("format") != FILE_FORMAT:
        about = about if isinstance(about, dict) else {}
        raise ValueError(
            f"{path} has format {about.get('format')}, this version reads {FILE_FORMAT}: read it with "
            f"frictionlab {about.get('version')}"
        )
    return StoredRun(path, about, arrays)


class _TooLargeError(ValueError):
    """The arrays of a file would take more memory than a run of its size has."""


def _check_sizes(path: Path, file: zipfile.ZipFile, stored: int) -> None:
    """Raise ValueError where a small file would take a large memory, before any of it is taken."""
    size = sum(member.file_size for member in file.infolist())
    if size > LARGE_FILE and size > MOST_COMPRESSION * stored:
        raise _TooLargeError(
            f"{path} would take {size / 1e9:.3g} GB of memory, but has {stored / 1e6:.3g} MB: no run is "
            "compressed so much, give a file that run.save(path) wrote"
        )


def rates_by_mode(problem: Problem, raw: RunData) -> dict[str, list[float]]:
    """Rates of the states at the first step in each visited mode, to tell whether equations are the same."""
    program, found = problem.program, {}
    jets, rates = np.zeros((program.slots, 1)), np.empty(raw.state.size)
    for mode in np.unique(raw.step_modes):
        state = raw.step_states[np.argmax(raw.step_modes == mode)]
        state_rates(program.code, problem.numbers, int(mode), state, jets, rates)
        found[program.modes[mode]] = rates.tolist()
    return found


def check_arrays(stored: StoredRun, guards: int) -> None:
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


def _ascend(times: np.ndarray) -> bool:
    """Whether times are an ascending list, from 0 on."""
    return times.ndim == 1 and bool((np.diff(times, prepend=0.0) >= 0.0).all())
