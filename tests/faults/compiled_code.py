"""The cache of compiled code under faults: after each the same run ends with the same states to the last bit.

Every kind of file is damaged, or replaced by a link or by another user's; then no file can be written.  What
was planted must not be executed.  Needs fork, which spares the runs the imports.
"""

from __future__ import annotations

import os
import pickle
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

from tests.faults.damage import NOBODY, damages
from tests.faults.processes import Outcome, Report, in_a_process

# A kernel that takes long to compile is as good as another of its kind.  The last one is a part of another,
# and is not needed where that is there.
KINDS = "jets-*.o", "step-*.o", "lane_steps-*.kernel", "tanh_range-*.kernel"


class Fault(NamedTuple):
    """Something done to a file, or to the folder, before the run or within its process."""

    name: str
    do: Callable[[Path], Any]
    pattern: str = "."
    within: bool = False


def main(scratch: Path, truncations: int, flips: int) -> int:
    """Do all faults; returns how many were not withstood."""
    from frictionlab.compilation.machine_code import CACHE_FOLDER, NUMBA
    from tests.helpers.cached_run import final_states

    NUMBA.njit(lambda: 0)()  # imports what all runs need
    folder, whole, report = Path(CACHE_FOLDER), scratch / "whole", Report("compiled code")
    expected = in_a_process(final_states).value
    shutil.copytree(folder, whole)
    for fault in faults(truncations, flips):
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(whole, folder)
        path = next(folder.glob(fault.pattern)) if fault.pattern != "." else folder
        if not fault.within:
            fault.do(path)
        found = in_a_process(lambda f=fault, run=final_states: (f.within and f.do(folder), run())[1])
        wrong = _wrong(found, expected, scratch)
        if not wrong and fault.pattern in KINDS[:3] and not path.is_file():
            wrong = "it is not compiled anew"
        report.add(f"{fault.pattern}, {fault.name}", wrong)
    return report.finish()


def faults(truncations: int, flips: int) -> Iterator[Fault]:
    """All of them, those of each kind of file first."""
    for kind in KINDS:
        for damage in damages(truncations, flips):
            yield Fault(damage.name, damage.do, kind)
        for do in (_link, _open_to_others, _foreign):
            yield Fault(do.__name__[1:], do, kind)
    yield Fault("folder removed", shutil.rmtree)
    yield Fault("no file can be written", _full_disk, within=True)
    yield Fault("no file can be written, none is there", _full_disk_and_nothing, within=True)


def _wrong(found: Outcome, expected: Any, scratch: Path) -> str:
    if found.status or found.error:
        return f"status {found.status}, {found.kind} {found.error}"
    if (scratch / "executed").exists():
        return "what was planted was executed"
    return "" if found.value == expected else "another result"


def _link(path: Path) -> None:
    _plant(path)
    path.symlink_to(path.rename(path.with_suffix(".elsewhere")))


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
    from frictionlab import cache_folder

    cache_folder.write(path, pickle.dumps(Planted(str(path.parents[2] / "executed"))))


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
