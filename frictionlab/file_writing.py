"""Files that are written whole or not at all: in a folder beside their place, then renamed.

So a full disk, an error or the end of the process leaves what was there before.
"""

from __future__ import annotations

import errno
import os
import shutil
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from os import PathLike
from pathlib import Path
from typing import Any

from frictionlab.validation import with_cure

NO_ROOM = errno.ENOSPC, errno.EFBIG, getattr(errno, "EDQUOT", errno.ENOSPC)  # a quota; not everywhere
NAME_LENGTH = 40  # characters of a file's name in that of the folder: a name has 255 bytes at most


@contextmanager
def write_file(path: Any) -> Iterator[Any]:
    """Context that gives another path to write to, as :func:`replace_file` does; errors name `path`."""
    with name_written_file(path), replace_file(path) as beside:
        yield beside


def check_folder(path: Path) -> None:
    """Raise the system's error, with what can be done, where a file's folder is not there."""
    with name_written_file(path):
        os.stat(path.parent)


def write_text(path: Path, text: str) -> Path:
    """Write a text by :func:`write_file`; returns its path."""
    with write_file(path) as beside:
        beside.write_text(text, encoding="utf-8")
    return path


def read_file(path: Path, cure: str) -> bytes:
    """The content of a file; OSError, with what can be done, for a folder, a pipe, or what cannot be read.

    A pipe would wait for ever for somebody to write.
    """
    try:
        if not stat.S_ISREG(os.stat(path).st_mode) and not path.is_dir():
            raise OSError(f"{path} must be a file, it is a pipe or a device: {cure}")
        return path.read_bytes()
    except OSError as error:
        if error.errno is None:
            raise
        raise with_cure(error, path, cure) from error


@contextmanager
def replace_file(path: Any) -> Iterator[Any]:
    """Context that gives another path to write to: of the same name, in a new folder beside `path`.

    If the context ends without an error, all files in that folder are renamed into the folder of `path`, with
    the suffix that a writer may have added.  Streams and devices cannot be replaced: they are given as they
    are.
    """
    if not isinstance(path, (str, PathLike)) or not _replaceable(path):
        yield path
        return
    target = Path(os.path.realpath(path))  # so that a link stays a link
    folder = Path(tempfile.mkdtemp(".unfinished", f"{target.name[:NAME_LENGTH]}.", target.parent))
    try:
        yield folder / target.name
        for file in folder.iterdir():
            _move(file, target.with_name(file.name))
        with suppress(OSError):  # not all systems can open folders
            _sync(target.parent, os.O_RDONLY)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _replaceable(path: Any) -> bool:
    """Whether there is a file, or nothing; raises where there is a folder, or writing is not allowed."""
    try:
        kind = os.stat(path).st_mode
    except OSError:
        return True
    if stat.S_ISREG(kind) or stat.S_ISDIR(kind):
        with open(path, "ab"):  # raises the system's error
            return True
    return False


def _move(file: Path, target: Path) -> None:
    with suppress(OSError):
        shutil.copymode(target, file)
    _sync(file, os.O_RDWR)
    os.replace(file, target)


def _sync(path: Path, way: int) -> None:
    """Have the system write it to the disk: else a power cut may leave an empty file under the new name."""
    handle = os.open(path, way)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


@contextmanager
def name_written_file(path: Any) -> Iterator[None]:
    """Context in which a file is written: errors of the system get its path, and what can be done."""
    try:
        yield
    except Exception as error:
        cause = _system_error(error)
        if cause is None or not isinstance(path, (str, PathLike)):  # only its owner knows what a stream is
            raise
        raise with_cure(cause, path, cure_of(cause)) from error


def cure_of(error: OSError) -> str:
    """What can be done where the system writes no file."""
    if isinstance(error, FileNotFoundError):
        return "make its folder first, or give another path"
    return "give another path, or make room"


def _system_error(error: BaseException) -> OSError | None:
    """The system's error, or None; also a full disk's, where a library then failed in its clean-up."""
    if isinstance(error, OSError):
        return error
    before = error.__context__
    while before is not None:
        if isinstance(before, OSError) and before.errno in NO_ROOM:
            return before
        before = before.__context__
    return None
