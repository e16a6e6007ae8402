"""What another user has put where the package looks is never executed.

The other user is one of a number that nobody has; only root can act in its name.  What is planted has a right
checksum, and would leave a folder behind, or end the process.  Which folders and files are not used
tests/unit/test_cache_folder.py tells.
"""

import os
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import frictionlab as fl
from frictionlab import cache_folder
from tests.helpers.compilers import HAS_NUMBA

ROOT = Path(__file__).parents[2]
OTHER = 54321
RUN = "import sys; from tests.helpers.cached_run import final_states; sys.stdout.buffer.write(final_states())"
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(getattr(os, "getuid", lambda: 1)() != 0, reason="only root can be two users"),
    pytest.mark.skipif(not HAS_NUMBA, reason="needs numba, whose code is planted"),
]


class Planted:
    """Unpickled, it makes a folder."""

    def __init__(self, path):
        self.path = str(path)

    def __reduce__(self):
        return os.mkdir, (self.path,)


@pytest.fixture(scope="module")
def known(tmp_path_factory):
    """The version's folder, the names of its files, and what the run gives."""
    cache = tmp_path_factory.mktemp("whole") / "cache"
    found = run({"FRICTIONLAB_CACHE_DIR": str(cache)})
    (folder,) = cache.iterdir()
    return folder.name, [path.name for path in folder.iterdir()], found.stdout


@pytest.fixture
def shared():
    """A folder that everybody can write to, in which everybody owns what is theirs, and one without that."""
    import tempfile

    with tempfile.TemporaryDirectory(dir="/tmp") as base:
        os.chmod(base, 0o711)
        for name, mode in (("sticky", 0o1777), ("open", 0o777)):
            Path(base, name).mkdir()
            Path(base, name).chmod(mode)
        yield Path(base)


def run(environment):
    """The run, in a process of its own."""
    return subprocess.run(
        [sys.executable, "-c", RUN],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT), "FRICTIONLAB_COMPILE_KERNELS": "1", **environment},
        capture_output=True,
        check=False,
    )


def as_other_user(act):
    """Do it in a process of the other user."""
    child = os.fork()
    if child == 0:
        status = 1
        try:
            os.setgroups([])
            os.setgid(OTHER)
            os.setuid(OTHER)
            os.umask(0)
            act()
            status = 0
        finally:
            os._exit(status)
    assert os.waitpid(child, 0)[1] == 0


def plant(folder, names, executed):
    """Files of all those names, with code in them."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in names:
        cache_folder.write(folder / name, pickle.dumps(Planted(executed)))
        (folder / name).chmod(0o777)


def nothing_was_executed(found, known, executed):
    assert found.returncode == 0, found.stderr.decode()
    assert found.stdout == known[2]
    assert not executed.exists()


def test_planted_files_would_be_executed(known, shared):
    """The test's own bite: what root itself puts there is run."""
    folder, executed = shared / "own" / known[0], shared / "sticky" / "executed"
    folder.mkdir(mode=0o700, parents=True)
    folder.parent.chmod(0o700)
    plant(folder, known[1], executed)
    for path in folder.iterdir():
        path.chmod(0o600)
    found = run({"FRICTIONLAB_CACHE_DIR": str(folder.parent)})
    assert executed.exists() or found.returncode != 0


def test_in_the_temporary_folder(known, shared):
    """Its name there is known to everybody; it is used where there is no home."""
    base, executed = shared / "sticky" / f"frictionlab-{os.getuid()}", shared / "sticky" / "executed"
    as_other_user(lambda: plant(base / known[0], known[1], executed))
    nowhere = {"FRICTIONLAB_CACHE_DIR": "/dev/null/none", "TMPDIR": str(shared / "sticky")}
    found = run(nowhere)
    nothing_was_executed(found, known, executed)
    assert b"other users could write there" in found.stderr
    assert str(base).encode() in found.stderr


def test_in_files_of_runs_and_sweeps(shared):
    """Pickles within are not unpickled, classes not imported."""
    executed = shared / "open" / "executed"
    path, journal = shared / "open" / "run.npz", shared / "open" / "sweep.jsonl"

    def plant_files():
        np.savez(path, about=np.array([Planted(executed)], dtype=object))
        journal.write_bytes(pickle.dumps(Planted(executed)))

    as_other_user(plant_files)
    model = fl.SliderOnBelt().without("geometry")
    for read in (
        lambda: fl.load(path),
        lambda: fl.load_bifurcation(journal),
        lambda: fl.load_basins(journal),
        lambda: fl.bifurcation(model, "mu_k", [0.5], resume=journal, progress=False),
    ):
        with pytest.raises(ValueError, match=str(shared)):
            read()
    assert not executed.exists()
