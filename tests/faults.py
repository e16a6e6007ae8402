"""The cache of compiled code under faults, by the command ``python -m tests.faults``.

Every kind of file is truncated, changed by one bit, emptied, replaced by a folder or a link, made unreadable,
or replaced by another user's; then the disk is full.  After each the same run, in a process of its own, ends
with exit code 0 and the same states to the last bit.  Needs fork, which spares it the imports.
"""

from __future__ import annotations

import argparse
import os
import pickle
import random
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

NOBODY = 65534
# A kernel that takes long to compile is as good as another of its kind.
KINDS = "jets-*.o", "step-*.o", "lane_steps-*.kernel", "tanh_range-*.kernel"


class Fault(NamedTuple):
    """Something done to a file, or to the folder, before the run or within its process."""

    name: str
    do: Callable[[Path], Any]
    pattern: str = "."
    within: bool = False


def main() -> int:
    """Do all faults, print the ones that were not withstood; their number is the exit code."""
    parser = argparse.ArgumentParser(prog="python -m tests.faults", description=__doc__)
    parser.add_argument("--truncations", type=int, default=20, help="places in each kind of file")
    parser.add_argument("--flips", type=int, default=50, help="random bits in each kind of file")
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        os.environ["FRICTIONLAB_CACHE_DIR"] = str(Path(scratch) / "cache")
        return _do_all(Path(scratch), list(_faults(chosen.truncations, chosen.flips)))


def _faults(truncations: int, flips: int) -> Iterator[Fault]:
    for kind in KINDS:
        for i in range(truncations):
            yield Fault(f"truncated {i}", lambda path, i=i: _truncate(path, (i + 0.5) / truncations), kind)
        for seed in range(flips):
            yield Fault(f"flipped {seed}", lambda path, seed=seed: _flip(path, seed), kind)
        for do in (_empty, _folder, _link, _unreadable, _open_to_others, _foreign):
            yield Fault(do.__name__[1:], do, kind)
    yield Fault("folder removed", shutil.rmtree)
    yield Fault("no file can be written", _full_disk, within=True)
    yield Fault("no file can be written, none is there", _full_disk_and_nothing, within=True)


def _do_all(scratch: Path, faults: list[Fault]) -> int:
    from frictionlab.hybrid.compilation import CACHE_FOLDER, NUMBA
    from tests.helpers.cached_run import final_states

    NUMBA.njit(lambda: 0)()  # imports what all runs need
    folder, whole, failed = Path(CACHE_FOLDER), scratch / "whole", 0
    expected = _in_a_process(final_states)
    shutil.copytree(folder, whole)
    for number, fault in enumerate(faults):
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(whole, folder)
        path = next(folder.glob(fault.pattern)) if fault.pattern != "." else folder
        if not fault.within:
            fault.do(path)
        found = _in_a_process(lambda f=fault: (f.within and f.do(folder), final_states())[1])
        if found != expected or (scratch / "executed").exists():
            failed += 1
            print(f"{fault.pattern}, {fault.name}: {found}", file=sys.stderr)
        if sys.stdout.isatty():
            print(f"\r{number + 1}/{len(faults)}", end="", flush=True)
    print(f"{len(faults)} faults, {failed} not withstood")
    return failed


def _in_a_process(run: Callable[[], bytes]) -> tuple[int, bytes]:
    """Status of a process that runs this, and what it returns."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        status = 1
        try:
            os.write(writing, run())
            status = 0
        finally:
            os._exit(status)
    os.close(writing)
    with os.fdopen(reading, "rb") as pipe:
        printed = pipe.read()
    return os.waitpid(child, 0)[1], printed


def _truncate(path: Path, share: float) -> None:
    os.truncate(path, int(share * path.stat().st_size))


def _flip(path: Path, seed: int) -> None:
    content = bytearray(path.read_bytes())
    bit = random.Random(f"{seed} {path.name}").randrange(8 * len(content))
    content[bit // 8] ^= 1 << bit % 8
    path.write_bytes(content)


def _empty(path: Path) -> None:
    path.write_bytes(b"")


def _folder(path: Path) -> None:
    path.unlink()
    path.mkdir()


def _link(path: Path) -> None:
    _plant(path)
    path.symlink_to(path.rename(path.with_suffix(".elsewhere")))


def _unreadable(path: Path) -> None:
    path.chmod(0)


def _open_to_others(path: Path) -> None:
    _plant(path)
    path.chmod(0o666)


def _foreign(path: Path) -> None:
    """Another user's, which only root can make; else one that others could have changed."""
    _plant(path)
    if os.getuid() == 0:
        os.chown(path, NOBODY, NOBODY)
    else:
        path.chmod(0o620)


def _plant(path: Path) -> None:
    """Put code here, with a right checksum, that would leave a file behind or end the process."""
    from frictionlab.hybrid import kernel_cache

    kernel_cache.write(path, pickle.dumps(Planted(str(path.parents[2] / "executed"))))


class Planted:
    """Unpickled, it makes a folder."""

    def __init__(self, path: str) -> None:
        self.path = path

    def __reduce__(self) -> tuple[Callable, tuple[str]]:
        return os.mkdir, (self.path,)


def _full_disk(folder: Path) -> None:
    import resource  # not on Windows

    resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))


def _full_disk_and_nothing(folder: Path) -> None:
    for path in folder.iterdir():
        path.unlink()
    _full_disk(folder)


if __name__ == "__main__":
    sys.exit(min(main(), 100))
