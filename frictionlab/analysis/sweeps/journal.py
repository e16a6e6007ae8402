"""The journal of a sweep: its results so far, also in a file of JSON lines from which it can be resumed.

The first line holds the format, the version and the arguments of the sweep, each further line the result of
one task.  Every line ends with its checksum.  At the end the lines are put in order, so that the file does
not depend on how often the sweep was interrupted.

A task depends on the arguments alone.  So a line that a power cut or a bad disk has damaged is left out, and
its task is computed again; a file is useless only if its first line is damaged.
"""

from __future__ import annotations

import json
import os
import re
import sys
import warnings
import zlib
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from pathlib import Path
from time import monotonic
from types import TracebackType
from typing import Any, NamedTuple, TypeVar

import numpy as np

from frictionlab._version import __version__
from frictionlab.analysis.options import Execution
from frictionlab.analysis.sweeps.tasks import URGENT_PRESS, TaskFailure, run_tasks
from frictionlab.file_writing import cure_of, read_file, replace_file
from frictionlab.interruption import InterruptCounter, interruption
from frictionlab.partial_results import keep_partial_result
from frictionlab.validation import abbreviate, check_path

FORMAT = 1
HEAD_KEYS = "frictionlab sweep", "version", "python"  # of the first line, before the arguments of the sweep
PYTHON = "{}.{}".format(*sys.version_info)  # another version has other code of the same function
LINE = re.compile(rb'(\{.*), "crc32": "([0-9a-f]{8})"\}')
SYNC_TIME = 1.0  # seconds of results that a power cut may destroy: each fsync takes some milliseconds
OF_FUNCTIONS = (
    "; the function has other code, or what it holds has changed, such as a list or a cache: make these "
    "anew before each call"
)

Result = TypeVar("Result")


class Journal:
    """The results of a sweep so far, also on disk if there is a path.

    It is a context manager that keeps other processes from writing to the file.  Within it ctrl-C is counted,
    so that no press comes between a result and :func:`frictionlab.partial_result`.

    Parameters
    ----------
    specification : dict
        The arguments of the sweep; a file of others is refused.  It is used only if there is a path.
    path : path or None
    parts : sequence of paths
        Journals of the same sweep, whose results are taken over.

    Attributes
    ----------
    results : dict of int to object
        By the index of their task.
    complete : bool
        Whether nothing has stopped the sweep.
    """

    def __init__(
        self,
        specification: dict[str, Any],
        path: str | Path | None = None,
        parts: Sequence[Path] = (),
    ) -> None:
        self.results: dict[int, Any] = {}
        self._interrupts, self._interrupted = InterruptCounter(URGENT_PRESS), False
        self._failure: TaskFailure | None = None
        self._specification, self._parts = specification, parts
        self._path = None if path is None else Path(path)
        self._lock: Any = None
        self._file: Any = None
        self._synced = monotonic()

    def __enter__(self) -> Journal:
        self._interrupts.__enter__()
        try:
            if self._path is not None:
                self._lock = _locked(self._path)
                self._open(self._path)
        except BaseException as error:
            self.__exit__(type(error), error, None)
            raise
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._interrupts.__exit__(kind, error, trace)
        if self._file is not None:
            with suppress(OSError):  # a failure to write was raised when the line was written
                os.fsync(self._file.fileno())
            self._file.close()
        if self._lock is not None:
            self._lock.release()

    @property
    def complete(self) -> bool:
        """Whether neither ctrl-C nor a failure has stopped the sweep."""
        return not self._interrupted and not self._interrupts.count and self._failure is None

    def _open(self, path: Path) -> None:
        try:
            for part in self._parts:
                self._take(part)
            if path.exists() and path.stat().st_size:
                damage = self._take(path)
                if damage:
                    warnings.warn(f"{path} is damaged in {damage}: computed again", RuntimeWarning, 5)
            write_journal(path, self._specification, self.results)
            self._file = path.open("ab", buffering=0)
        except OSError as error:
            raise _unusable(path, error) from error

    def _take(self, path: Path) -> str:
        """Take over the results in a file; returns what of it is damaged, in words."""
        stored = _read(path, read_file(path, "give another path"))
        _refuse_another(path, stored, self._specification)
        self.results |= stored.results
        return stored.damage if stored.damaged else ""

    def keep(self, task: int, result: Any) -> None:
        """Keep a result as the file would return it; it is in the file when this function returns.

        Raises
        ------
        TypeError
            For a result that the file cannot hold.
        OSError
            Where the file cannot be written any more; the results in it are still there.
        """
        if self._path is None:
            self.results[task] = result
            return
        line = _json_line({"task": task, "result": result})
        self._append(line)
        self.results[task] = json.loads(line)["result"]

    def _append(self, line: bytes) -> None:
        before = os.fstat(self._file.fileno()).st_size
        try:
            while line:
                line = line[self._file.write(line) :]
            if monotonic() - self._synced > SYNC_TIME:
                os.fsync(self._file.fileno())
                self._synced = monotonic()
        except OSError as error:
            with suppress(OSError):
                self._file.truncate(before)
            raise OSError(
                f"{self._path} cannot be written ({error.strerror}): make room, and call again with the same "
                f"resume=; the {len(self.results)} results in it are kept"
            ) from error

    def run_tasks(
        self,
        function: Callable[..., Any],
        tasks: Sequence[tuple[Any, ...]],
        name: Callable[[int], str],
        execution: Execution,
        title: str,
        first: int = 0,
        chosen: Iterable[int] | None = None,
    ) -> None:
        """Run the tasks of which there is no result yet, and keep their results.

        `name` gives the name of a task; `first` is the index of the first one in the sweep.  Only the tasks
        with the indices `chosen` are run, None stands for all.
        """
        indices = range(len(tasks)) if chosen is None else chosen
        todo = [i for i in indices if first + i not in self.results]
        self.attempt(
            lambda: run_tasks(
                function,
                tasks,
                keep=lambda i, result: self.keep(first + i, result),
                name=name,
                todo=todo,
                execution=execution,
                title=title,
            )
        )

    def attempt(self, compute: Callable[[], bool]) -> None:
        """Compute what is missing by a function that returns whether it came to its end.

        If ctrl-C or a failure stops it, `finish` says so.
        """
        if self._interrupts.count:
            return
        try:
            self._interrupted = not compute()
        except TaskFailure as error:
            self._failure = error

    def interrupt(self) -> None:
        """Note that ctrl-C has stopped the sweep."""
        self._interrupted = True

    def finish(self, result: Result, count: int) -> Result:
        """Put the lines of the file in order, and return the result of a sweep of `count` tasks.

        Raises
        ------
        KeyboardInterrupt
            After ctrl-C, with the result as the partial one.
        RuntimeError
            Where a task has failed or the executor was lost, with the result as the partial one.
        """
        self._put_in_order()
        file = "" if self._path is None else f"; resume={str(self._path)!r} goes on from there"
        if self._failure is not None:
            keep_partial_result(result)
            text = f"{self._failure}; frictionlab.partial_result() is what there is{file}"
            raise TaskFailure(text) from self._failure.__cause__
        if self._interrupted or self._interrupts.count:
            raise interruption(f"stopped after {len(self.results)} of {count} tasks", result, file)
        return result

    def _put_in_order(self) -> None:
        """Write the lines in the order of the tasks."""
        if self._path is None:
            return
        try:
            write_journal(self._path, self._specification, self.results)
        except OSError as error:  # all results are in the file already
            warnings.warn(f"{self._path} is complete, but not in order: {error}", RuntimeWarning, 5)


class _Content(NamedTuple):
    """What a file holds, the versions that wrote it, and the numbers of its damaged lines."""

    specification: dict[str, Any]
    results: dict[int, Any]
    version: str
    python: str | None
    damaged: list[int]

    @property
    def damage(self) -> str:
        """The damaged lines, in words."""
        first, *others = self.damaged
        return f"line {first}" + (f" and {len(others)} more" if others else "")


def write_journal(path: str | Path, specification: dict[str, Any], results: dict[int, Any]) -> Path:
    """Write all lines in order, atomically: even a power cut leaves the old file or the new one."""
    path = check_path("path", path)
    head = dict(zip(HEAD_KEYS, (FORMAT, __version__, PYTHON))) | specification
    rows = ({"task": i, "result": results[i]} for i in sorted(results))
    with replace_file(path) as beside, open(beside, "wb") as file:
        file.writelines(map(_json_line, (head, *rows)))
    return path


def read_journal(path: str | Path) -> tuple[dict[str, Any], dict[int, Any]]:
    """The specification of a sweep, and its results by index.

    Raises
    ------
    OSError
        If there is no such file, or it cannot be read.
    ValueError
        If the file holds no sweep, or is damaged.
    """
    path = check_path("path", path)
    stored = _read(path, read_file(path, "give a file that save(path) or resume=path wrote"))
    if stored.damaged:
        raise ValueError(
            f"{path} is damaged in {stored.damage}: use it as resume={str(path)!r}, which computes "
            "again what is missing"
        )
    return stored.specification, stored.results


def _read(path: Path, content: bytes) -> _Content:
    # What follows the last line feed is a line that was cut off, and is left out.
    first, *rest = content.split(b"\n")[:-1] or [b""]
    head = _content(first)
    if head is None or HEAD_KEYS[0] not in head:
        raise ValueError(
            f"{path} must be a file of a sweep, and is none, or its first line is damaged: give another "
            "path, or delete it to begin anew"
        )
    form, version, python = (head.pop(key, None) for key in HEAD_KEYS)
    if form != FORMAT:
        raise ValueError(
            f"{path} has format {abbreviate(form)}, this version reads {FORMAT}: read it with frictionlab "
            f"{str(version)[:20]}, or delete it to begin anew"
        )
    lines = {i: _content(line) for i, line in enumerate(rest, 2)}
    results = {line["task"]: line["result"] for line in lines.values() if line is not None}
    return _Content(head, results, version, python, [i for i, line in lines.items() if line is None])


def _unusable(path: Path, error: OSError) -> OSError:
    """The error for a path at which no file can be written."""
    return OSError(
        f"resume must be a file that can be written, {path} is none ({error.strerror or error}): "
        f"{cure_of(error)}"
    )


def _json_line(content: dict[str, Any]) -> bytes:
    """A line: the content, with the checksum of its text as the last entry."""
    text = json.dumps(content, default=_json_value).encode()[:-1]
    return b'%b, "crc32": "%08x"}\n' % (text, zlib.crc32(text))


def _content(line: bytes) -> dict[str, Any] | None:
    """The content of a line; None where it is damaged."""
    match = LINE.fullmatch(line)
    if match is None or zlib.crc32(match[1]) != int(match[2], 16):
        return None
    return json.loads(match[1] + b"}")


def _json_value(value: Any) -> Any:
    """Numbers and arrays of numpy as numbers and lists of Python."""
    if isinstance(value, (np.generic, np.ndarray)):
        return value.tolist()
    raise TypeError(
        f"results that resume keeps must be numbers, texts, or lists and mappings of such, "
        f"got {abbreviate(value)}: "
        "let the function return these, or leave resume out"
    )


def _locked(path: Path) -> Any:
    """The acquired lock of a file; the lock file beside it is not removed."""
    from filelock import FileLock, Timeout

    lock = FileLock(path.with_name(path.name + ".lock"))
    try:
        path.parent.stat()  # FileLock would create a missing folder
        lock.acquire(timeout=0)
    except Timeout:
        raise OSError(
            f"resume={str(path)!r} is in use by another sweep, here or in another process: wait until that "
            "has ended, or give another path"
        ) from None
    except OSError as error:
        raise _unusable(path, error) from error
    return lock


def _refuse_another(path: Path, content: _Content, specification: dict[str, Any]) -> None:
    current = {**json.loads(json.dumps(specification)), "version": __version__}
    stored = {**content.specification, "version": content.version}
    differing = [name for name in {**stored, **current} if stored.get(name) != current.get(name)]
    if differing:
        by_another = content.python not in (PYTHON, None)
        of_function = {"function", "quantity", "ablation"}.intersection(differing)
        raise ValueError(
            f"resume must be a file of the same sweep, {path} differs in {', '.join(differing)}"
            f"{f', by Python {content.python} and not {PYTHON}' if by_another else ''}: "
            f"give another path, or delete it{OF_FUNCTIONS if of_function else ''}"
        )
