"""The user's cache folder: compiled code and derived equations, read only if whole and the user's own.

A damaged object file would end the process, and one that somebody else wrote would run with the user's
rights.  So each file begins with a checksum of its name and content, and no folder or file is used that
another user owns or can write to.  Whatever goes wrong, such as a full disk, counts as a miss: nothing here
raises.
"""

from __future__ import annotations

import hashlib
import logging
import os
import stat
import sys
import tempfile
import time
import warnings
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from pathlib import Path

LOGGER = logging.getLogger(__name__)
FOLDER_VARIABLE = "FRICTIONLAB_CACHE_DIR"
CHECKSUM_BYTES = 32
# Limits for all versions together.  The kernels of a run take 12 MB, a structure's code 0.3 MB, and what the
# tests compile for one version 150 MB: two versions can be worked on side by side.
KEPT_BYTES, KEPT_SECONDS = 500e6, 60 * 86400.0
TOUCHED_AFTER = 86400.0  # seconds: a use is noted once a day, as that costs a write
DIGEST_LENGTH = 16  # hexadecimal digits, also in the name of a version's folder
VERSION_FOLDER = "[0-9a-f]" * DIGEST_LENGTH
# Only such files are removed, as the folder may hold others.
SUFFIXES = ".kernel", ".o", ".structure", ".unfinished"


def digest_folder(digest: str) -> str:
    """First usable folder of this name: in the user's cache, or in the temporary folder; "" where none is.

    A folder that cannot be written to is usable if there is something in it.  A folder that others can write
    to causes a warning, as nothing else would tell why every start compiles.
    """
    for base in (_user_base, temporary_base):
        try:
            folder = base().absolute() / digest
            shared = next((each for each in (folder.parent, folder) if not _made_private(each)), None)
            if shared is not None:
                _warn_of_shared(shared)
            elif os.access(folder, os.W_OK) or any(folder.iterdir()):
                return str(folder)
        except (OSError, RuntimeError):  # it cannot be made, or there is no home folder
            continue
    return ""


def _user_base() -> Path:
    if folder := os.environ.get(FOLDER_VARIABLE):
        return Path(folder)
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local") / "frictionlab"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "frictionlab"
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "frictionlab"


def temporary_base() -> Path:
    user = os.getuid() if hasattr(os, "getuid") else os.environ.get("USERNAME") or "user"
    return Path(tempfile.gettempdir()) / f"frictionlab-{user}"


def _made_private(folder: Path) -> bool:
    """Make a folder if need be; whether it is no link, and only the present user can write to it."""
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    info = os.lstat(folder)
    return stat.S_ISDIR(info.st_mode) and _is_private(info)


def _warn_of_shared(folder: Path) -> None:
    warnings.warn(
        f"compiled code is not kept in {folder}, as other users could write there: remove that folder, which "
        f"is then made for you alone, or set {FOLDER_VARIABLE} to another one",
        RuntimeWarning,
        stacklevel=4,
    )


def _is_private(info: os.stat_result) -> bool:
    if not hasattr(os, "getuid"):  # on Windows both base folders are the user's own already
        return True
    return info.st_uid == os.getuid() and not info.st_mode & (stat.S_IWGRP | stat.S_IWOTH)


def read(path: Path) -> bytes | None:
    """What was written to a file; None where it is missing, damaged, or not surely the user's own."""
    with suppress(OSError), open(path, "rb", opener=_opened) as file:
        # of the open file, as the folder may have been exchanged since it was checked
        info = os.fstat(file.fileno())
        whole = file.read() if _is_private(info) else b""
        content = whole[CHECKSUM_BYTES:]
        if whole[:CHECKSUM_BYTES] == _checksum(path, content):
            _note_use(path, info)
            return content
    return None


def write(path: Path, content: bytes) -> None:
    """Write to a temporary file and rename it, so that no process reads an incomplete one."""
    with suppress(OSError):
        handle, name = tempfile.mkstemp(".unfinished", dir=path.parent)
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(_checksum(path, content) + content)
            os.replace(name, path)
        except BaseException:
            os.unlink(name)
            raise
        if path.parent.match(VERSION_FOLDER):
            prune(path.parent.parent)


def _opened(path: str, flags: int) -> int:
    """Open a file without following a link or waiting for the writer of a pipe."""
    return os.open(path, flags | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0))


def _checksum(path: Path, content: bytes) -> bytes:
    """Checksum of version, name and content: an undamaged file in the place of another is other code."""
    summed = hashlib.blake2b("/".join(path.parts[-2:]).encode(), digest_size=CHECKSUM_BYTES)
    summed.update(content)
    return summed.digest()


def _note_use(path: Path, info: os.stat_result) -> None:
    if time.time() - info.st_mtime > TOUCHED_AFTER:
        with suppress(OSError):
            os.utime(path)


@cache  # once in a process is often enough
def prune(base: Path) -> None:
    """Remove files that have not been used for long, and the oldest ones beyond the size that is kept."""
    total, now = 0, time.time()
    for last_use, size, path in sorted(_files(base), reverse=True):
        total += size
        if total > KEPT_BYTES or now - last_use > KEPT_SECONDS:
            LOGGER.info("removing %s from the cache", path)
            with suppress(OSError):
                path.unlink()
                path.parent.rmdir()  # fails while there is more in it
                path.parent.parent.rmdir()


def _files(base: Path) -> Iterator[tuple[float, int, Path]]:
    """Time of the last use, size and path of each removable file in the folders of all versions."""
    for folder in base.glob(VERSION_FOLDER):
        for path in folder.rglob("*"):
            with suppress(OSError):
                info = path.lstat()
                if stat.S_ISREG(info.st_mode) and path.suffix in SUFFIXES:
                    yield info.st_mtime, info.st_size, path
