"""A process for each case, and what counts as withstood."""

from __future__ import annotations

import os
import pickle
import re
import signal
import sys
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from tests.faults.damage import NOBODY

LONGEST = 300  # seconds of one case, after which it counts as hanging
# How messages of the package begin to say what can be done.
CURES = r": (give|save|delete|read|write|make|remove|use|call|choose|load|import|send|wait)\b"


class Outcome(NamedTuple):
    """How a process ended: its status (0, else a signal), and what it returned or raised."""

    status: int
    value: Any
    error: str = ""
    kind: str = ""


def in_a_process(run: Callable[[], Any], user: int | None = None) -> Outcome:
    """What a function does in a process of its own, as another user if one is given."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        status = 1
        try:
            os.close(reading)
            _write_all(writing, pickle.dumps(_called(run, user)))
            status = 0
        finally:
            os._exit(status)
    os.close(writing)
    with os.fdopen(reading, "rb") as pipe:
        content = pipe.read()
    status = os.waitpid(child, 0)[1]
    return Outcome(status, *pickle.loads(content)) if status == 0 else Outcome(status, None)


def _called(run: Callable[[], Any], user: int | None) -> tuple[Any, str, str]:
    signal.alarm(LONGEST)
    warnings.simplefilter("ignore")
    if user is not None:
        os.setgroups([])
        os.setgid(user)
        os.setuid(user)
    try:
        return run(), "", ""
    except BaseException as error:
        return None, str(error) or repr(error), type(error).__name__


def _write_all(pipe: int, content: bytes) -> None:
    while content:
        content = content[os.write(pipe, content) :]


def other_user(needed: bool = True) -> int | None:
    """The user that a case runs as: nobody, where this is root and it matters."""
    return NOBODY if needed and os.getuid() == 0 else None


def judge(found: Outcome, path: Path, accepted: Callable[[Any], bool]) -> str:
    """What is wrong with an outcome, "" where it was withstood: the right value, or an error that names the
    path and says what can be done."""
    if found.status:
        return f"the process ended with status {found.status}"
    if not found.error:
        return "" if accepted(found.value) else "another result"
    if found.kind not in (
        "ValueError",
        "OSError",
        "FileNotFoundError",
        "IsADirectoryError",
        "PermissionError",
    ):
        return f"{found.kind}: {found.error}"
    if str(path) not in found.error:
        return f"an error without the path: {found.error}"
    return "" if re.search(CURES, found.error) else f"an error without a cure: {found.error}"


class Report:
    """Counts cases, and prints those that were not withstood."""

    def __init__(self, title: str) -> None:
        self.title, self.count, self.failed = title, 0, 0

    def add(self, case: str, wrong: str) -> None:
        """One more case; `wrong` is "" where it was withstood."""
        self.count += 1
        if wrong:
            self.failed += 1
            print(f"{case}: {wrong}", file=sys.stderr, flush=True)
        if sys.stdout.isatty():
            print(f"\r{self.title} {self.count}", end="", flush=True)

    def finish(self) -> int:
        """Print the sum; returns how many were not withstood."""
        print(f"{self.title}: {self.count} cases, {self.failed} not withstood", flush=True)
        return self.failed
