"""All that writes files, on a full disk: errors name the path and the cure, and what was there stays.

The disk is a small one in memory, which only root can make; else the size of files is limited.
"""

from __future__ import annotations

import contextlib
import os
import resource
import shutil
import subprocess
from collections.abc import Callable, Iterator
from functools import cache, partial
from pathlib import Path
from typing import Any, NamedTuple

import frictionlab as fl
from tests.faults.processes import Report, in_a_process, judge
from tests.faults.stored_files import QUIET, SLIDER, basins, bifurcation, sweep

DISK = 200_000  # bytes
PAGE = 4096  # bytes, by which memory is given; the file that was there has one
BEFORE = b"what was there"
ROOM = 0, 1, 500, 5000  # bytes that are left


class Writer(NamedTuple):
    """What writes a file."""

    write: Callable[[Path], Any]
    suffix: str


@cache
def _run() -> Any:
    return fl.simulate(SLIDER, 1.0, **QUIET)


def _picture(path: Path) -> None:
    _run().plot().figure.savefig(path, dpi=100)


def _film(path: Path) -> None:
    fl.animate(_run(), window=(0.0, 0.05), fps=4.0, speed=0.05).save(path, writer="pillow", dpi=50)


@cache
def _long_run() -> Any:
    return fl.solve(SLIDER.automaton(), 20.0, x0=[0.0] * 8, **QUIET)


WRITERS = {
    "run": Writer(lambda path: _long_run().save(path), ".npz"),
    "bifurcation": Writer(
        lambda path: fl.load_bifurcation(_made(bifurcation)).save(path),
        ".jsonl",
    ),
    "basins": Writer(
        lambda path: fl.load_basins(_made(basins)).save(path),
        ".jsonl",
    ),
    **{name: Writer(_picture, f".{name.lower()}") for name in ("PNG", "SVG", "PDF")},
    "animation": Writer(_film, ".gif"),
    "sound": Writer(lambda path: fl.listen(_run()).save(path), ".wav"),
}
RESUMED = {"bifurcation": bifurcation, "sweep": sweep, "basins": basins}
_FILES: dict[Any, Path] = {}


def _made(compute: Callable[[Path], Any]) -> Path:
    return _FILES[compute]


def main(scratch: Path, parts: int) -> int:
    """Fill disks, those of sweeps at so many places; returns how many cases were not withstood."""
    for compute in (bifurcation, basins):
        _FILES[compute] = scratch / f"{compute.__name__}.jsonl"
        compute(_FILES[compute])
    return _write_all(scratch) + _resume_all(scratch, parts)


def _write_all(scratch: Path) -> int:
    report = Report("full disks")
    for name, writer in WRITERS.items():
        path, large = scratch / f"disk/file{writer.suffix}", scratch / f"large{writer.suffix}"
        writer.write(large)
        for room in (room for room in ROOM if room + 2 * PAGE < large.stat().st_size):
            with small_disk(scratch / "disk", room, lambda path=path: path.write_bytes(BEFORE)) as limit:
                found = in_a_process(
                    lambda writer=writer, path=path, limit=limit: (limit(), writer.write(path))
                )
                wrong = judge(found, path, lambda _: False)
                if path.read_bytes() != BEFORE:
                    wrong = wrong or "the file that was there is lost"
                if left := [each.name for each in path.parent.glob("*unfinished*")]:
                    wrong = wrong or f"{left} is left"
            report.add(f"{name}, {room} bytes left", wrong)
    return report.finish()


def _resume_all(scratch: Path, parts: int) -> int:
    """A sweep on a disk that fills up keeps what is done, and goes on to the same file once there is room."""
    report = Report("sweeps on full disks")
    for name, compute in RESUMED.items():
        whole = scratch / f"whole {name}"
        compute(whole)
        path, expected = scratch / "disk/sweep.jsonl", whole.read_bytes()
        for part in range(1, parts + 1):
            room = 2 * len(expected) * part // (parts + 1)  # beyond its length, as it is copied at its end
            with small_disk(scratch / "disk", room, lambda: None) as limit:
                found = in_a_process(
                    lambda compute=compute, path=path, limit=limit: (
                        limit(),
                        compute(path),
                        path.read_bytes(),
                    )[2]
                )
                # without room for a copy its lines are in the order in which they came
                wrong = judge(found, path, partial(same_lines, expected))
                kept = path.read_bytes() if path.exists() else b""
            again = scratch / "again.jsonl"
            again.write_bytes(kept)
            compute(again)
            if again.read_bytes() != expected:
                wrong = wrong or "what is resumed is another file"
            again.unlink()
            report.add(f"{name}, {room} bytes left", wrong)
    return report.finish()


def same_lines(one: bytes, other: bytes) -> bool:
    """Whether two files have the same lines, whatever their order."""
    return sorted(one.splitlines()) == sorted(other.splitlines())


@contextlib.contextmanager
def small_disk(folder: Path, room: int, fill: Callable[[], Any]) -> Iterator[Callable[[], None]]:
    """A folder on a disk with so many bytes left; yields what limits a process where that is not possible."""
    folder.mkdir()
    mounted = os.getuid() == 0 and _mounted(folder)
    try:
        fill()
        if mounted:
            _fill_up(folder, room)
        yield lambda: None if mounted else resource.setrlimit(resource.RLIMIT_FSIZE, (room, room))
    finally:
        if mounted:
            subprocess.run(["umount", folder], check=True)
        for left in folder.iterdir():
            shutil.rmtree(left) if left.is_dir() else left.unlink()
        folder.rmdir()


def _mounted(folder: Path) -> bool:
    size = DISK // 4096 * 4096
    command = ["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", folder]
    return subprocess.run(command, check=False, capture_output=True).returncode == 0


def _fill_up(folder: Path, room: int) -> None:
    """Fill the disk but for whole pages, of which `room` bytes need one more each 4096."""
    left = os.statvfs(folder)
    pages = left.f_bavail - -(-room // left.f_frsize)
    (folder / "filling").write_bytes(bytes(max(pages, 0) * left.f_frsize))
