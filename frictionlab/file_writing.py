"""Files that are written whole or not at all: beside their place, then renamed.

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

NO_ROOM = errno.ENOSPC, errno.EFBIG, getattr(errno, "EDQUOT", errno.ENOSPC)  # a quota, which Windows lacks
NAME_LENGTH = 40  # characters of a file's name in that of the folder beside: a name has 255 bytes at most


@contextmanager
def write_file(path: Any) -> Iterator[Any]:
    """Context that gives the path to write to instead, by :func:`replace_file`; errors name `path`."""
    with name_written_file(path), replace_file(path) as beside:
        yield beside


def write_text(path: Path, text: str) -> Path:
    """Write a text by :func:`write_file`; returns its path."""
    with write_file(path) as beside:
        beside.write_text(text, encoding="utf-8")
    return path


@contextmanager
def replace_file(path: Any) -> Iterator[Any]:
    """Context that gives the path to write to instead: a file of the same name in a new folder beside.

    All that is in the folder is renamed into the place of `path` once the context ends well, with the suffix
    that a writer may have added.  Streams and devices, which nothing can take the place of, are given as they
    are.
    """
    if not isinstance(path, (str, PathLike)) or not _replaceable(path):
        yield path
        return
    target = Path(os.path.realpath(path))  # a link stays
    folder = Path(tempfile.mkdtemp(".unfinished", f"{target.name[:NAME_LENGTH]}.", target.parent))
    try:
        yield folder / target.name
        for made in folder.iterdir():
            _move(made, target.with_name(made.name))
        with suppress(OSError):  # not all systems can open folders
            _sync(target.parent, os.O_RDONLY)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _replaceable(path: Any) -> bool:
    """Whether it is a file, or nothing; raises where it is a folder or must not be written."""
    try:
        kind = os.stat(path).st_mode
    except OSError:
        return True
    if stat.S_ISREG(kind) or stat.S_ISDIR(kind):
        with open(path, "ab"):  # raises the system's error
            return True
    return False


def _move(made: Path, target: Path) -> None:
    with suppress(OSError):
        shutil.copymode(target, made)
    _sync(made, os.O_RDWR)
    os.replace(made, target)


def _sync(path: Path, way: int) -> None:
    """Have the system write it down, as a power cut may otherwise leave an empty file under the new name."""
    handle = os.open(path, way)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


@contextmanager
def name_written_file(path: Any) -> Iterator[None]:
    """Context in which a file is written: errors of the system have its path, and what can be done."""
    try:
        yield
    except Exception as error:
        found = _system_error(error)
        if found is None or not isinstance(path, (str, PathLike)):  # a stream only its owner knows
            raise
        raise with_cure(found, path, "give another path, or make room") from error


def _system_error(error: BaseException) -> OSError | None:
    """The error of the system; that of a full disk too where a library failed as it tidied up after it."""
    if isinstance(error, OSError):
        return error
    before = error.__context__
    while before is not None:
        if isinstance(before, OSError) and before.errno in NO_ROOM:
            return before
        before = before.__context__
    return None
