"""What has been derived of the structures of models, kept on disk.

Deriving the equations of a structure takes sympy half a second, and loading sympy a quarter.  The tapes and
formulas that runs, equilibria and pictures need are therefore kept in the user's cache folder, in one file
for each structure.  The file's name contains a digest of the structure; the folder's name is a digest of all
sources that take part in deriving, and of the versions of sympy and mpmath.  A wheel carries an archive of
such files for the library's models, which is used only if it was derived from the same sources.  Nothing is
kept for laws and models from outside the library, since their sources are not in the digest.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import fields
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from sys import modules
from types import FunctionType
from typing import Any, NamedTuple
from zipfile import BadZipFile, ZipFile

from frictionlab import cache_folder
from frictionlab.components.component import Component, StructureKey
from frictionlab.components.surroundings import PYTHONS
from frictionlab.models.serialisation import structure_to_data

PACKAGE = Path(__file__).parents[1]
# Folders of all sources that derive, lower or read the data.
SOURCES = "automaton", "components", "hybrid", "models", "stability", "tape"
HOMES = tuple(f"frictionlab.{name}." for name in ("components", "models"))  # modules with laws and models
# Files that contain versions: versions of sympy order the terms of sums differently.
VERSIONS = ("sympy", "release.py"), ("mpmath", "__init__.py")
ARCHIVE = PACKAGE / "models" / "structures.zip"  # what a wheel carries; a clone has none


class Derivations:
    """What has been derived of a structure, under names such as "program", kept in a JSON file.

    Parameters
    ----------
    path : Path or None
        The file; None where nothing is kept.
    """

    def __init__(self, path: Path | None) -> None:
        self._path = path
        self._known: dict[str, Any] | None = None
        self.objects: dict[str, Any] = {}  # formulas and programs, made of the data

    @property
    def keeps(self) -> bool:
        """Whether there is a file."""
        return self._path is not None

    def get(self, name: str) -> Any:
        """The data kept under a name; None where there are none."""
        if self._known is None:
            self._known = self._read()
        return self._known.get(name)

    def keep(self, name: str, data: Any) -> None:
        """Keep data under a name, together with what other processes have kept meanwhile.

        Nothing is kept where a source has been edited since the digest was taken: the data may have been
        derived by other sources than those of the digest.
        """
        if self._path is not None and _stamps(LOADED.paths) == LOADED.stamps:
            self._known = self._read() | (self._known or {}) | {name: data}
            cache_folder.write(self._path, json.dumps(self._known, separators=(",", ":")).encode())

    def value(self, name: str, derive: Callable[[], Any]) -> Any:
        """The JSON data kept under a name; where there are none, `derive` makes them and they are kept."""
        known = self.get(name)
        if known is None:
            known = derive()
            self.keep(name, known)
        return known

    def _read(self) -> dict[str, Any]:
        if self._path is None:
            return {}
        content = cache_folder.read(self._path) or archived(self._path.name)
        return {} if content is None else json.loads(content)


def archived(name: str) -> bytes | None:
    """A file of the wheel's archive; None if it is not there or was derived from other sources."""
    if archive_digest(ARCHIVE) != LOADED.digest:
        return None
    with suppress(KeyError, OSError, BadZipFile), ZipFile(ARCHIVE) as archive:
        return archive.read(name)
    return None


def archive_digest(path: Path) -> str | None:
    """Digest of the sources that an archive was derived from; None where there is no intact archive."""
    try:
        with ZipFile(path) as archive:
            return archive.comment.decode()
    except (OSError, BadZipFile):
        return None


@cache
def derivations_of(key: StructureKey) -> Derivations:
    """What has been derived of a structure, as functions of its parameters in their order.

    Nothing is kept where a class is not the library's.
    """
    try:
        text = json.dumps(structure_to_data(key)) if is_of_library(key) else ""
    except TypeError:  # a field that no file can hold
        text = ""
    folder = cache_folder.digest_folder(LOADED.digest) if text and LOADED.digest else ""
    name = f"{key.component.__name__}-{hashlib.sha256(text.encode()).hexdigest()[:24]}.structure"
    return Derivations(Path(folder) / name if folder else None)


def is_of_library(key: StructureKey) -> bool:
    """Whether all classes of a structure are Python's or the library's."""
    return all(map(_is_ours, _classes(key)))


def _classes(key: StructureKey) -> Iterator[type]:
    """The classes of a structure, its components and its values."""
    yield key.component
    for value in key.values:
        yield from _classes(value) if isinstance(value, StructureKey) else _classes_of_value(value)


def _classes_of_value(value: Any) -> Iterator[type]:
    yield type(value)
    if isinstance(value, Component):
        value = tuple(getattr(value, each.name) for each in fields(value))
    for each in value if isinstance(value, tuple) else ():
        yield from _classes_of_value(each)


def _is_ours(cls: type) -> bool:
    """Whether a class and its bases are Python's or the library's, none of them changed at run time."""
    return all(map(_is_as_written, (each for each in cls.__mro__ if each.__module__ not in PYTHONS)))


def _is_as_written(cls: type) -> bool:
    written = getattr(modules.get(cls.__module__), cls.__qualname__, None)
    methods = (getattr(each, "fget", None) or getattr(each, "__func__", each) for each in vars(cls).values())
    homes = (each.__module__ for each in methods if isinstance(each, FunctionType))
    return written is cls and all(home.startswith((*HOMES, *PYTHONS)) for home in (cls.__module__, *homes))


class Sources(NamedTuple):
    """The sources that the data depend on: their digest, paths and stamps; empty if unreadable."""

    digest: str
    paths: tuple[str, ...]
    stamps: tuple[tuple[int, int], ...]


def sources() -> Sources:
    """The sources as they are now; empty in a zip file, or where there is only byte code."""
    try:
        digest, paths = hashlib.sha256(), tuple(_files())
        for path in paths:
            digest.update(Path(path).read_bytes())
    except OSError:
        return Sources("", (), ())
    return Sources(digest.hexdigest()[: cache_folder.DIGEST_LENGTH], paths, _stamps(paths))


def _stamps(paths: tuple[str, ...]) -> tuple[tuple[int, int], ...]:
    """Time of the last change and size of each file; () where one cannot be read."""
    try:
        return tuple((info.st_mtime_ns, info.st_size) for info in map(os.stat, paths))
    except OSError:
        return ()


def _files() -> Iterator[str]:
    """Their paths, as texts: to make a hundred of pathlib's takes three times as long as all the rest."""
    for name in SOURCES:
        walk = os.walk(PACKAGE / name)
        paths = [os.path.join(folder, file) for folder, _, files in walk for file in files]
        sources = sorted(path for path in paths if path.endswith(".py"))
        if not sources:  # a zip file, or only byte code: without sources all versions would be one
            raise FileNotFoundError(PACKAGE / name)
        yield from sources
    yield from (str(_beside(package, name)) for package, name in VERSIONS)


def _beside(package: str, name: str) -> Path:
    """The path of a file in another package, found without loading the package."""
    spec = find_spec(package)
    if spec is None or spec.origin is None:
        raise FileNotFoundError(package)
    return Path(spec.origin).with_name(name)


LOADED = sources()
