"""Long commands, ended at random moments: nothing computed is lost, and the file resumed is the same.

A command is ended by SIGKILL, as by a power cut or the system without memory; by SIGINT, ctrl-C in the
terminal; or its disk is full from then on (files can grow no more).
"""

from __future__ import annotations

import os
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import frictionlab as fl
from tests.faults.processes import CURES, Report
from tests.faults.stored_files import content

ROOT = Path(__file__).parents[2]
QUICK_NAMES = "sweep", "bifurcation", "basins", "run"
NAMES = (*QUICK_NAMES, "processes", "bifurcation-on", "basin-stability", "figure")
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
    ends: dict[str, Callable[[subprocess.Popen[str]], None]] = {
        "SIGKILL": lambda process: os.killpg(process.pid, signal.SIGKILL),
        "SIGINT": lambda process: os.killpg(process.pid, signal.SIGINT),
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


def ended(
    name: str,
    folder: Path,
    how: str,
    end: Callable[[subprocess.Popen[str]], None],
    whole: Undisturbed,
    rng: random.Random,
) -> str:
    """What is wrong after a command was ended once and then resumed; "" where all is well."""
    folder.mkdir()
    process = start(name, folder)
    if rng.random() > EARLY_SHARE:
        wait_for_files(process, folder)
        time.sleep(rng.random() * whole.after)
    else:
        time.sleep(rng.random() * whole.before)
    lines = count_lines(folder)
    if process.poll() is None:
        end(process)
    out, err = process.communicate(timeout=LONGEST)
    if process.returncode in CRASHES:
        return f"it ended with signal {-process.returncode}: {err}"
    if count_lines(folder) < lines:
        return f"of {lines} lines {count_lines(folder)} are left"
    if how == "full disk" and process.returncode and not tells_of_disk(err, folder):
        return f"an error without path and cure: {err[-500:]}"
    again = start(name, folder)
    out, err = again.communicate(timeout=LONGEST)
    if again.returncode:
        return f"resumed, it ended with {again.returncode}: {out}{err}"
    return "" if files(folder) == whole.found else "resumed, its files are others"


def start(name: str, folder: Path) -> subprocess.Popen[str]:
    """The command, in a group of processes of its own, as a terminal has it."""
    return subprocess.Popen(
        [sys.executable, "-m", "tests.faults.commands", name, str(folder / "file.npz")],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        start_new_session=True,
    )


def undisturbed(name: str, folder: Path) -> Undisturbed:
    """The same command left alone."""
    folder.mkdir()
    begin = time.monotonic()
    process = start(name, folder)
    wait_for_files(process, folder)
    there = time.monotonic()
    out, err = process.communicate(timeout=LONGEST)
    if process.returncode:
        raise RuntimeError(f"{name} fails even undisturbed: {out}{err}")
    return Undisturbed(files(folder), there - begin, time.monotonic() - there)


def wait_for_files(process: subprocess.Popen[str], folder: Path) -> None:
    """Until there is a file, or the command has ended."""
    while process.poll() is None and not any(kept(folder)):
        time.sleep(POLL_TIME)


def kept(folder: Path) -> list[Path]:
    """The files that hold results: not those that are unfinished, nor locks, nor pictures."""
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    return [path for path in files if path.suffix in (".npz", ".jsonl")]


def files(folder: Path) -> dict[str, Any]:
    """What is in them: of a run its arrays, as the file also holds how long it took."""
    return {path.relative_to(folder).as_posix(): _content(path) for path in kept(folder)}


def _content(path: Path) -> Any:
    data = path.read_bytes()
    return content(fl.load(path)) if data.startswith(b"PK") else data


def count_lines(folder: Path) -> int:
    """Lines of results so far."""
    return sum(path.read_bytes().count(b"\n") for path in kept(folder) if path.stat().st_size)


def fill_disk(process: subprocess.Popen[str]) -> None:
    """From now on no file of the process grows beyond what the largest one is, as on a full disk."""
    largest = max((path.stat().st_size for path in kept(_folder(process))), default=0)
    resource.prlimit(process.pid, resource.RLIMIT_FSIZE, (largest, largest))


def _folder(process: subprocess.Popen[str]) -> Path:
    return Path(process.args[-1]).parent  # type: ignore[index, arg-type]


def tells_of_disk(err: str, folder: Path) -> bool:
    """Whether the last line names a file in the folder, and says what can be done."""
    last = err.strip().splitlines()[-1] if err.strip() else ""
    return str(folder) in last and re.search(CURES + "|make room", last) is not None
