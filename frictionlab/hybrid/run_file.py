"""Runs on disk: one npz file of arrays, with a description as JSON among them.

A file is written beside its place and then renamed, so that a full disk leaves what was there.  The header of
an array is compared with the bytes that follow it before it takes memory.  One schema checks all that is read
before kernels see it, as kernels check no indices.  Errors name the path, the field and the rule.
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
from frictionlab.hybrid.problem import Problem, RunData, Status
from frictionlab.stored_data import (
    agrees,
    array,
    array_bytes,
    either,
    integer,
    json_data,
    listed,
    mapping,
    number,
    reading,
    real,
    record,
    shape_text,
    text,
)
from frictionlab.validation import abbreviate, check_number, check_path

FILE_FORMAT = 2
LARGE_FILE = 100_000_000  # bytes of arrays, below which a file is read whatever its size
MOST_COMPRESSION = 100  # of the arrays of a large run, whose last bits are random
STORED_ARRAYS = (*RunData._fields[:9], "state")  # of a run; its last time, mode and status are in the JSON
ALL_ARRAYS = *STORED_ARRAYS, "t_eval"
INTEGER_ARRAYS = "step_modes", "event_codes", "point_sections"
CURE = "save the run again"
OTHER_SUFFIX = re.compile(r"\.[A-Za-z]\w*")
MAX_PARTS = 1000  # into which samples cut a step: methods use eight at most
TIME_RTOL = 1e-9  # of crossings, located by series, against the end of the run
# Runs that end so may have infinite states, or none.
LOST = Status.NOT_FINITE, Status.NO_ADMISSIBLE_MODE

# What a file says about its run; what must agree with other fields is in `check_arrays`.
ABOUT = record(
    {
        "states": listed(text(), distinct=True),
        "parameters": mapping(number()),
        "mode_names": listed(text(), distinct=True),
        "guards": listed(text()),
        "rates": mapping(array(None, finite=False)),
        "t": number(least=0.0),
        "mode": integer(least=-1),
        "status": text(*(status.name for status in Status)),
        "samples": record(
            {
                "order": integer(least=1, most=MAX_ORDER),
                "parts": integer(least=1, most=MAX_PARTS),
                "sections": listed(text(), distinct=True),
            }
        ),
        "quadratures": mapping(real),  # infinite where the run was
        "wall_time": number(least=0.0),
        "description": record(
            {},
            {
                "method": record({"name": text()}, {"tol": number(above=0.0)}),
                "t_end": number(above=0.0),
                "model": mapping(),
            },
        ),
    },
    {"automaton": either(str, text(), mapping())},
)

HEADERS = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}

# What the readers of archives, arrays and JSON raise where the content is no such thing.
DAMAGED = (
    *(zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError, OSError),
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
                name: _array(name, file.read(f"{name}.npy"))
                for name in ("about", *ALL_ARRAYS)
                if f"{name}.npy" in file.namelist()
            }
        about = json_data(str(arrays.pop("about")))
    except _TooLargeError:
        raise
    except MemoryError as error:
        raise ValueError(f"{path} takes more memory than is free: make room, or raise the limit") from error
    except DAMAGED as error:
        raise ValueError(f"{path} is no saved run: write one with run.save(path)") from error
    if not isinstance(about, dict) or about.get("format") != FILE_FORMAT:
        about = about if isinstance(about, dict) else {}
        raise ValueError(
            f"{path} has format {abbreviate(about.get('format'))}, this version reads {FILE_FORMAT}: read it "
            f"with frictionlab {str(about.get('version'))[:20]}"
        )
    with reading(path, CURE):
        ABOUT("", about)
        check_arrays(about, arrays)
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


def _array(name: str, content: bytes) -> np.ndarray:
    """The array in a member of a file; ValueError unless its header declares as many bytes as follow it."""
    stream = io.BytesIO(content)
    read_header = HEADERS[np.lib.format.read_magic(stream)]
    shape, _, dtype = read_header(stream)
    if dtype.hasobject or array_bytes(shape, dtype.itemsize) != len(content) - stream.tell():
        raise ValueError(f"{name} has the shape {abbreviate(shape)}")
    return np.lib.format.read_array(io.BytesIO(content), allow_pickle=False)


def rates_by_mode(problem: Problem, raw: RunData) -> dict[str, list[float]]:
    """Rates of the states at the first step in each visited mode, to tell whether equations are the same."""
    program, found = problem.program, {}
    jets, rates = np.zeros((program.slots, 1)), np.empty(raw.state.size)
    for mode in np.unique(raw.step_modes):
        state = raw.step_states[np.argmax(raw.step_modes == mode)]
        state_rates(program.code, problem.numbers, int(mode), state, jets, rates)
        found[program.modes[mode]] = rates.tolist()
    return found


def check_arrays(about: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> None:
    """Raise ValueError unless the arrays have their kinds, agree in length, and refer to what there is."""
    steps, events, points = (
        len(arrays[name]) if name in arrays and arrays[name].ndim else 0
        for name in ("step_modes", "event_times", "point_times")
    )
    states, modes = len(about["states"]), len(about["mode_names"])
    shapes: dict[str, tuple[int | None, ...]] = {
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
        _check_array(name, arrays.get(name), shape)
    if "t_eval" in arrays:
        _check_array("t_eval", arrays["t_eval"], (None,))
    if Status[about["status"]] not in LOST:
        for name in sorted(arrays.keys() - {*INTEGER_ARRAYS}):
            if not np.isfinite(arrays[name]).all():
                raise ValueError(f"{name} must be finite, as the run ended as {about['status']}")
    check_number("mode", about["mode"], below=modes)
    indices = {
        "step_modes": (arrays["step_modes"], 0, modes),
        "the guards in event_codes": (arrays["event_codes"][:, 0], 0, len(about["guards"])),
        "the modes in event_codes": (arrays["event_codes"][:, 1], -1, modes),
        "the last column of event_codes": (arrays["event_codes"][:, 2], 0, 2),
        "point_sections": (arrays["point_sections"], 0, len(about["samples"]["sections"])),
    }
    for name, (values, low, high) in indices.items():
        _check_within(name, values, low, high - 1)
    for name in ("step_times", "event_times", "t_eval"):
        if name in arrays:
            _check_ascending(name, _times(arrays[name]))
    _check_within("the lengths in step_times", arrays["step_times"][:, 1], 0.0, np.inf)
    for name in ("step_times", "event_times", "point_times"):
        _check_within(name, _times(arrays[name]), 0.0, about["t"] * (1.0 + TIME_RTOL))
    mapping(array(states, finite=False))("rates", about["rates"])
    for place in np.unique(arrays["step_modes"]):
        if about["mode_names"][place] not in about["rates"]:
            raise ValueError(
                f"rates must have those of mode {about['mode_names'][place]!r}, which was visited"
            )


def _times(array: np.ndarray) -> np.ndarray:
    """The times in an array: all, or those in the first column before lengths."""
    return array if array.ndim == 1 else array[:, 0]


def _check_array(name: str, given: np.ndarray | None, shape: tuple[int | None, ...]) -> None:
    wanted = np.dtype(np.int64 if name in INTEGER_ARRAYS else np.float64)
    if given is None or given.dtype != wanted or not agrees(given.shape, shape):
        rule = f"an array of {wanted}, {shape_text(shape)}"
        got = "none" if given is None else f"{given.dtype}, {shape_text(given.shape)}"
        raise ValueError(f"{name} must be {rule}, got {got}")


def _check_within(name: str, values: np.ndarray, low: float, high: float) -> None:
    outside = values[~((values >= low) & (values <= high))]
    if len(outside):
        raise ValueError(f"{name} must be within {low:g} and {high:g}, got {outside[0]:g}")


def _check_ascending(name: str, times: np.ndarray) -> None:
    if not (np.diff(times, prepend=0.0) >= 0.0).all():
        raise ValueError(f"{name} must ascend from 0 on, got {abbreviate(times)}")
