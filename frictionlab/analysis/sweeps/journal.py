"""Results of a sweep in a file of JSON lines, written as they come, so that an interrupted sweep can be
resumed.

The first line holds the arguments of the sweep; each further one the result of one task.  When all are there
the lines are put in order, so that the file does not depend on how often the sweep was interrupted.
"""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import numpy as np

LINE_KEYS = {"task", "result"}


class Journal:
    """The specification and results of a sweep so far, also on disk if there is a path."""

    def __init__(self, specification: dict[str, Any], path: str | Path | None = None) -> None:
        self.results: dict[int, Any] = {}
        self._specification = specification
        self._path = None if path is None else Path(path)
        if self._path is not None:
            self._open(self._path)

    def _open(self, path: Path) -> None:
        try:
            if path.exists() and path.stat().st_size:
                found, self.results = read_journal(path)
                _refuse_another(path, found, self._specification)
            write_journal(path, self._specification, self.results)
        except OSError as error:
            raise OSError(f"resume must be a file that can be written, {path} is none: {error}") from error

    def keep(self, task: int, result: Any) -> None:
        """Keep a result, in the form in which the file gives it back; it is on disk when this returns.

        Raises
        ------
        TypeError
            For a result that the file cannot hold.
        """
        if self._path is None:
            self.results[task] = result
            return
        line = _json_line({"task": task, "result": result})
        self.results[task] = json.loads(line)["result"]
        with self._path.open("a", encoding="utf-8") as file:
            file.write(line)

    def close(self) -> None:
        """Put the lines in order."""
        if self._path is not None:
            write_journal(self._path, self._specification, self.results)


def write_journal(path: str | Path, specification: dict[str, Any], results: dict[int, Any]) -> Path:
    """Write all lines in order, atomically: a reader sees the old file or the new one."""
    path = Path(path)
    lines = [
        _json_line(specification),
        *(_json_line({"task": i, "result": results[i]}) for i in sorted(results)),
    ]
    temporary = path.with_name(path.name + ".new")
    temporary.write_text("".join(lines), encoding="utf-8")
    os.replace(temporary, path)
    return path


def read_journal(path: str | Path) -> tuple[dict[str, Any], dict[int, Any]]:
    """The specification of a sweep, and its results by index.

    Raises
    ------
    ValueError
        If the file holds no sweep.
    """
    head, *lines = _complete_lines(Path(path))
    if not all(isinstance(line, dict) for line in [head, *lines]) or any(
        LINE_KEYS - line.keys() for line in lines
    ):
        raise ValueError(f"{path} must be a file of a sweep, and is none: give another path")
    return head, {line["task"]: line["result"] for line in lines}


def _json_line(content: Any) -> str:
    return json.dumps(content, default=_json_value) + "\n"


def _json_value(value: Any) -> Any:
    """numpy's numbers and arrays as Python's."""
    if isinstance(value, (np.generic, np.ndarray)):
        return value.tolist()
    raise TypeError(
        f"results that resume keeps must be numbers, texts, or lists and mappings of such, got {value!r}: "
        "let the function return these, or leave resume out"
    )


def _complete_lines(path: Path) -> list[Any]:
    """The complete lines of a file, without a last one that was cut off."""
    text = path.read_text(encoding="utf-8")
    try:
        return [json.loads(line) for line in text[: text.rfind("\n") + 1].splitlines()] or [None]
    except json.JSONDecodeError as error:
        raise ValueError(f"{path} must be a file of a sweep, and is none: {error}") from error


def _refuse_another(path: Path, found: dict[str, Any], specification: dict[str, Any]) -> None:
    specification = json.loads(json.dumps(specification))
    differing = [name for name in {**found, **specification} if found.get(name) != specification.get(name)]
    if differing:
        raise ValueError(
            f"resume must be a file of the same sweep, {path} differs in {', '.join(differing)}: "
            "give another path, or delete it"
        )
