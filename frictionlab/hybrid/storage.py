"""Runs on disk: one npz file of arrays, with a description as JSON among them."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from frictionlab._version import __version__

FILE_FORMAT = 1


@dataclass(frozen=True)
class StoredRun:
    """The content of a file: what is said of the run, and its arrays by name."""

    about: dict[str, Any]
    arrays: dict[str, np.ndarray]

    @property
    def description(self) -> dict[str, Any]:
        """The description of the run: its method, its end time, its model if it had one."""
        return self.about["description"]


def write_run_file(path: str | Path, about: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> Path:
    """Write what JSON can hold, and arrays; the suffix .npz is added where it is missing."""
    path = Path(path)
    path = path if path.suffix == ".npz" else path.with_name(path.name + ".npz")
    text = json.dumps({"format": FILE_FORMAT, "version": __version__, **about})
    everything: dict[str, Any] = {"about": np.array(text), **arrays}
    np.savez_compressed(path, **everything)
    return path


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
