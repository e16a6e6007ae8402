"""What is kept of compiled code: whole, the user's own, and not for ever."""

import errno
import os
import time
from pathlib import Path

import pytest

from frictionlab import cache_folder

NOBODY, DAY = 65534, 86400.0
DIGEST, OLD_DIGEST = "0123456789abcdef", "fedcba9876543210"
CONTENT = b"machine code"
posix = pytest.mark.skipif(not hasattr(os, "getuid"), reason="owners and modes are those of POSIX")
as_root = pytest.mark.skipif(
    getattr(os, "getuid", lambda: 1)() != 0, reason="only root can make another user's files"
)
pytestmark = pytest.mark.plain_python


@pytest.fixture
def bases(tmp_path, monkeypatch):
    """The chosen folder, and the one in the temporary folder that is taken in its place."""
    (tmp_path / "tmp").mkdir(mode=0o1777)
    monkeypatch.setenv("FRICTIONLAB_CACHE_DIR", str(tmp_path / "chosen"))
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "tmp"))
    return tmp_path / "chosen", cache_folder.temporary_base()


@pytest.fixture
def kept(tmp_path):
    """A file of a version's folder, in the cache."""
    path = tmp_path / DIGEST / "jets-1.o"
    path.parent.mkdir()
    cache_folder.prune.cache_clear()
    cache_folder.write(path, CONTENT)
    return path


# --- files


def test_what_was_written_is_read(kept):
    assert cache_folder.read(kept) == CONTENT
    assert list(kept.parent.iterdir()) == [kept]


def test_a_file_shortened_anywhere_is_not_read(kept):
    whole = kept.read_bytes()
    for length in range(len(whole)):
        kept.write_bytes(whole[:length])
        assert cache_folder.read(kept) is None


def test_a_file_with_one_bit_changed_is_not_read(kept):
    whole = kept.read_bytes()
    for bit in range(8 * len(whole)):
        changed = bytearray(whole)
        changed[bit // 8] ^= 1 << bit % 8
        kept.write_bytes(changed)
        assert cache_folder.read(kept) is None


def test_a_file_under_the_name_of_another_is_not_read(kept):
    assert cache_folder.read(kept.rename(kept.with_name("jets-2.o"))) is None


def test_a_file_of_another_version_is_not_read(kept):
    (kept.parents[1] / OLD_DIGEST).mkdir()
    assert cache_folder.read(kept.rename(kept.parents[1] / OLD_DIGEST / kept.name)) is None


def test_neither_a_folder_nor_nothing_is_read(kept):
    kept.unlink()
    assert cache_folder.read(kept) is None
    kept.mkdir()
    assert cache_folder.read(kept) is None


@posix
@pytest.mark.parametrize("mode", [0o620, 0o602, 0o666])
def test_a_file_that_others_can_write_to_is_not_read(kept, mode):
    kept.chmod(mode)
    assert cache_folder.read(kept) is None


@posix
def test_neither_a_link_nor_a_pipe_is_read(kept):
    kept.symlink_to(kept.rename(kept.with_name("elsewhere")))
    assert cache_folder.read(kept) is None
    kept.unlink()
    os.mkfifo(kept)
    assert cache_folder.read(kept) is None


@as_root
def test_a_file_of_another_user_is_not_read(kept):
    os.chown(kept, NOBODY, NOBODY)
    assert cache_folder.read(kept) is None
    cache_folder.write(kept, CONTENT)
    assert cache_folder.read(kept) == CONTENT


def test_a_full_disk_leaves_what_there_was(kept, monkeypatch):
    def full(*_, **__):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(cache_folder.os, "replace", full)
    cache_folder.write(kept, b"other code")
    assert cache_folder.read(kept) == CONTENT
    assert list(kept.parent.iterdir()) == [kept]
    monkeypatch.setattr(cache_folder.tempfile, "mkstemp", full)
    cache_folder.write(kept, b"other code")
    assert cache_folder.read(kept) == CONTENT


# --- folders


@posix
def test_folders_are_made_for_the_user_alone(bases):
    before = os.umask(0)
    try:
        folder = Path(cache_folder.digest_folder(DIGEST))
    finally:
        os.umask(before)
    assert folder.parent == bases[0]
    assert [path.stat().st_mode & 0o777 for path in (folder, folder.parent)] == [0o700, 0o700]


def make_open(folder):
    folder.chmod(0o770)


def make_foreign(folder):
    os.chown(folder, NOBODY, NOBODY)


def make_link(folder):
    folder.symlink_to(folder.rename(folder.with_name("elsewhere")))


PLANTED = [make_open, make_link, pytest.param(make_foreign, marks=as_root)]


@posix
@pytest.mark.parametrize("inner", ["", DIGEST])
@pytest.mark.parametrize("plant", PLANTED)
def test_a_folder_that_may_be_planted_is_not_used(bases, plant, inner):
    """The next one is, and where that may be planted too there is none."""
    for base, then in zip(bases, (str(bases[1] / DIGEST), ""), strict=True):
        (base / DIGEST).mkdir(mode=0o700, parents=True, exist_ok=True)
        base.chmod(0o700)
        plant(base / inner)
        with pytest.warns(
            RuntimeWarning, match="other users could write there: remove that folder"
        ) as warned:
            assert cache_folder.digest_folder(DIGEST) == then
        assert str(base / inner) in str(warned[-1].message)


def test_a_folder_that_cannot_be_made_is_replaced(bases):
    bases[0].write_text("not a folder")
    assert cache_folder.digest_folder(DIGEST) == str(bases[1] / DIGEST)
    bases[1].parent.chmod(0o777)
    bases[1].joinpath(DIGEST).rmdir()
    bases[1].rmdir()
    bases[1].write_text("not a folder")
    assert cache_folder.digest_folder(DIGEST) == ""


def test_a_folder_that_cannot_be_written_to_is_read_if_there_is_something_in_it(bases, monkeypatch):
    folder = bases[0] / DIGEST
    folder.mkdir(mode=0o700, parents=True)
    folder.parent.chmod(0o700)
    monkeypatch.setattr(cache_folder.os, "access", lambda path, _: Path(path) != folder)  # root may all
    assert cache_folder.digest_folder(DIGEST) == str(bases[1] / DIGEST)
    cache_folder.write(folder / "jets-1.o", CONTENT)
    assert cache_folder.digest_folder(DIGEST) == str(folder)


@posix
def test_a_file_of_a_read_only_folder_is_read(kept):
    os.utime(kept, (0, 0))
    kept.chmod(0o400)
    kept.parent.chmod(0o500)
    try:
        assert cache_folder.read(kept) == CONTENT
        cache_folder.write(kept.with_name("jets-2.o"), CONTENT)
    finally:
        kept.parent.chmod(0o700)


# --- what is removed


def aged(base, digest, name, days, size=100):
    path = base / digest / name
    path.parent.mkdir(exist_ok=True)
    path.write_bytes(bytes(size))
    os.utime(path, 2 * (time.time() - days * DAY,))
    return path


def test_what_was_not_used_for_long_is_removed(kept):
    base = kept.parents[1]
    foreign = {aged(base, "notes", "old.o", 900), aged(base, DIGEST, "notes", 900)}
    ages = {
        digest: [aged(base, digest, f"{days}.o", days) for days in (59, 61)] for digest in (DIGEST, "f" * 16)
    }
    gone = aged(base, OLD_DIGEST, "61.o", 61)
    cache_folder.prune.cache_clear()
    cache_folder.write(kept, CONTENT)
    assert {*base.glob("*/*")} == {kept, *foreign, *(files[0] for files in ages.values())}
    assert not gone.parent.exists()


def test_of_what_is_too_much_the_oldest_is_removed(kept, monkeypatch):
    monkeypatch.setattr(cache_folder, "KEPT_BYTES", 1000)
    base = kept.parents[1]
    files = [aged(base, OLD_DIGEST, f"{days}.o", days, 300) for days in (1, 2, 3, 4)]
    cache_folder.prune.cache_clear()
    cache_folder.write(kept, CONTENT)
    assert [path.exists() for path in (kept, *files)] == [True, True, True, True, False]


def test_a_use_is_noted_once_a_day(kept):
    for days, noted in ((0.5, False), (30, True)):
        before = time.time() - days * DAY
        os.utime(kept, (before, before))
        assert cache_folder.read(kept) == CONTENT
        assert (kept.stat().st_mtime > before + 1) == noted
