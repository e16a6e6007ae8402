"""What is done to a file."""

from __future__ import annotations

import os
import random
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

NOBODY = 65534


class Damage(NamedTuple):
    """Something done to a file; `as_nobody` where root must become another user to feel it."""

    name: str
    do: Callable[[Path], Any]
    as_nobody: bool = False


def damages(truncations: int, flips: int) -> Iterator[Damage]:
    """All of them: truncated at places and with random bits changed, so many each."""
    for i in range(truncations):
        yield Damage(f"truncated {i}", lambda path, i=i: truncate(path, (i + 0.5) / truncations))
    for seed in range(flips):
        yield Damage(f"flipped {seed}", lambda path, seed=seed: flip(path, seed))
    yield Damage("emptied", empty)
    yield Damage("a folder", folder)
    yield Damage("a folder with something in it", full_folder)
    yield Damage("removed", Path.unlink)
    yield Damage("unreadable", unreadable, as_nobody=True)


def truncate(path: Path, share: float) -> None:
    """Keep a share of the file."""
    os.truncate(path, int(share * path.stat().st_size))


def flip(path: Path, seed: int) -> None:
    """Change one bit."""
    content = bytearray(path.read_bytes())
    bit = random.Random(f"{seed} {path.name}").randrange(8 * len(content))
    content[bit // 8] ^= 1 << bit % 8
    path.write_bytes(content)


def empty(path: Path) -> None:
    """Keep the name only."""
    path.write_bytes(b"")


def folder(path: Path) -> None:
    """A folder in its place."""
    path.unlink()
    path.mkdir()


def full_folder(path: Path) -> None:
    """A folder that cannot simply be removed."""
    folder(path)
    (path / "note").write_text("something else")


def unreadable(path: Path) -> None:
    """Nobody but root may read it."""
    path.chmod(0)
