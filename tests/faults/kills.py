"""Long commands, ended at random moments: nothing computed is lost, and the file resumed is the same.

A command is ended by SIGKILL, as by a power cut or the system without memory; by SIGINT, ctrl-C in the
terminal; or its disk is full from then on (files can grow no more).  Commands are forked from a process that
has compiled what they need, so that what is interrupted is their work and not the start of Python.
"""

from __future__ import annotations

import contextlib
import io
import os
import random
import re
import resource
import select
import shutil
import signal
import sys
import time
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import frictionlab as fl
from tests.faults.commands import COMMANDS
from tests.faults.processes import CURES, Report
from tests.faults.stored_files import content

QUICK_NAMES = "sweep", "bifurcation", "basins", "run"
NAMES = (*QUICK_NAMES, "processes", "ablation", "bifurcation-on", "basin-stability", "figure")
FEW_KILLS = 50  # below, only the quick ones are ended
LONGEST = 600  # s, of a command
POLL_TIME = 0.002  # s
EARLY_SHARE = 0.2  # of the kills come before the file is there
CRASHES = {-signal.SIGSEGV, -signal.SIGABRT, -signal.SIGILL, -signal.SIGBUS, -signal.SIGFPE}


class Undisturbed(NamedTuple):
    """What a command does when it is left alone: what is in its files, and how long it takes after these are
    first there, and until then."""

    found: Any
    before: float
    after: float


def main(scratch: Path, kills: int, seed: int) -> int:
    """End commands so often, one after the other; returns how many times that was not withstood."""
    rng, report, known = random.Random(seed), Report("kills"), {}
    ends: dict[str, Callable[[Command], None]] = {
        "SIGKILL": lambda command: os.killpg(command.pid, signal.SIGKILL),
        "SIGINT": lambda command: os.killpg(command.pid, signal.SIGINT),
        "full disk": fill_disk,
    }
    names = NAMES if kills >= FEW_KILLS else QUICK_NAMES
    for number in range(kills):
        name, how = names[number % len(names)], list(ends)[number // len(names) % len(ends)]
        if name not in known:
            known[name] = undisturbed(name, scratch / f"{name} whole")
        folder = scratch / f"{number}"
        wrong = ended(name, folder, how, ends[how], known[name], rng)
        report.add(f"{name}, {how}, number {number} of seed {seed}", wrong)
        shutil.rmtree(folder)
    return report.finish()


class Command:
    """A command in a process of its own, which leads a group as in a terminal."""

    def __init__(self, name: str, folder: Path) -> None:
        self.folder, self._status = folder, None
        self._reading, writing = os.pipe()
        self.pid = os.fork()
        if self.pid == 0:
            os.close(self._reading)
            os._exit(_run(name, folder / "file.npz", writing))
        os.setpgid(self.pid, self.pid)  # before any signal is sent to the group
        os.close(writing)

    def running(self) -> bool:
        """Whether it has not ended yet."""
        if self._status is None:
            pid, status = os.waitpid(self.pid, os.WNOHANG)
            self._status = status if pid else None
        return self._status is None

    def wait(self) -> tuple[int, str]:
        """What it ended with, minus the signal's number after one, and what it has printed."""
        said, deadline = b"", time.monotonic() + LONGEST
        while select.select([self._reading], [], [], max(0.0, deadline - time.monotonic()))[0]:
            some = os.read(self._reading, 4096)
            if not some:
                break
            said += some
        else:
            os.killpg(self.pid, signal.SIGKILL)
            said += f"it did not end within {LONGEST} s".encode()
        os.close(self._reading)
        if self._status is None:
            self._status = os.waitpid(self.pid, 0)[1]
        return os.waitstatus_to_exitcode(self._status), said.decode(errors="replace")


def _run(name: str, path: Path, writing: int) -> int:
    """What Python does with a script, up to its exit status."""
    os.dup2(writing, 1)
    os.dup2(writing, 2)
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell ignores it in the background
    status = 1
    try:
        COMMANDS[name](str(path))
        status = 0
    except SystemExit as ended:
        status = int(ended.code or 0)
    except KeyboardInterrupt:
        traceback.print_exc()
        status = 128 + signal.SIGINT
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
    return status


def ended(
    name: str,
    folder: Path,
    how: str,
    end: Callable[[Command], None],
    whole: Undisturbed,
    rng: random.Random,
) -> str:
    """What is wrong after a command was ended once and then resumed; "" where all is well."""
    folder.mkdir()
    command = Command(name, folder)
    if rng.random() > EARLY_SHARE:
        wait_for_files(command)
        time.sleep(rng.random() * whole.after)
    else:
        time.sleep(rng.random() * whole.before)
    lines = count_lines(folder)
    if command.running():
        end(command)
    status, said = command.wait()
    if status in CRASHES:
        return f"it ended with signal {-status}: {said}"
    if count_lines(folder) < lines:
        return f"of {lines} lines {count_lines(folder)} are left"
    if how == "full disk" and status and not tells_of_disk(said, folder):
        return f"an error without path and cure: {said[-500:]}"
    status, said = Command(name, folder).wait()
    if status:
        return f"resumed, it ended with {status}: {said}"
    return "" if files(folder) == whole.found else "resumed, its files are others"


def undisturbed(name: str, folder: Path) -> Undisturbed:
    """The same command left alone, after it has been run here for what it compiles and remembers."""
    folder.mkdir()
    with contextlib.redirect_stdout(io.StringIO()):
        COMMANDS[name](str(folder / "here.npz"))
    shutil.rmtree(folder)
    folder.mkdir()
    begin = time.monotonic()
    command = Command(name, folder)
    wait_for_files(command)
    there = time.monotonic()
    status, said = command.wait()
    if status:
        raise RuntimeError(f"{name} fails even undisturbed: {said}")
    return Undisturbed(files(folder), there - begin, time.monotonic() - there)


def wait_for_files(command: Command) -> None:
    """Until there is a file, or the command has ended."""
    while command.running() and not any(kept(command.folder)):
        time.sleep(POLL_TIME)


def kept(folder: Path) -> list[Path]:
    """The files that hold results: not those that are unfinished, nor locks, nor pictures."""
    found = []
    for place, folders, names in os.walk(folder):  # which does not mind folders that are gone
        folders[:] = [name for name in folders if not name.endswith(".unfinished")]
        found += [Path(place) / name for name in names if name.endswith((".npz", ".jsonl"))]
    return sorted(found)


def files(folder: Path) -> dict[str, Any]:
    """What is in them: of a run its arrays, as the file also holds how long it took."""
    return {path.relative_to(folder).as_posix(): _content(path) for path in kept(folder)}


def _content(path: Path) -> Any:
    data = path.read_bytes()
    return content(fl.load(path)) if data.startswith(b"PK") else data


def count_lines(folder: Path) -> int:
    """Lines of results so far."""
    return sum(path.read_bytes().count(b"\n") for path in kept(folder) if path.stat().st_size)


def fill_disk(command: Command) -> None:
    """From now on no file of the process grows beyond what the largest one is, as on a full disk."""
    largest = max((path.stat().st_size for path in kept(command.folder)), default=0)
    resource.prlimit(command.pid, resource.RLIMIT_FSIZE, (largest, largest))


def tells_of_disk(err: str, folder: Path) -> bool:
    """Whether the last line names a file in the folder, and says what can be done."""
    last = err.strip().splitlines()[-1] if err.strip() else ""
    return str(folder) in last and re.search(CURES + "|make room", last) is not None
