"""What has been compiled, and from which sources: a file beside the objects."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass, field
from importlib import resources
from typing import Any

FOLDER, FILE = "objects", "manifest.json"
Word = tuple[str, str, int]  # name, type, number of axes (0: a number)


@dataclass(frozen=True)
class Function:
    """The table of a function: its results, then its arguments.

    `returns` is the class of the named tuple that the results are; "" where there is one result or none.
    """

    results: tuple[Word, ...]
    arguments: tuple[Word, ...]
    returns: str = ""


@dataclass(frozen=True)
class Manifest:
    """What a folder of objects holds.

    Parameters
    ----------
    sources : dict of str to str
        Digest of each file that compiled code depends on, by its path in the package.
    functions : dict of str to Function
        The entry points that Python calls.
    symbols : tuple of str
        Functions that native code calls.
    objects : dict of str to str
        Digest of each file with machine code, by its name.
    """

    sources: dict[str, str]
    functions: dict[str, Function] = field(default_factory=dict)
    symbols: tuple[str, ...] = ()
    objects: dict[str, str] = field(default_factory=dict)

    def to_json(self) -> str:
        return json.dumps(asdict(self), indent=1)


def objects_folder() -> Any:
    """The folder of objects, which may be in a zip file."""
    return resources.files("frictionlab.hybrid.ahead_of_time") / FOLDER


def read_manifest() -> Manifest | None:
    """The manifest beside the objects; None where there is none that is whole."""
    try:
        given = json.loads((objects_folder() / FILE).read_text(encoding="utf-8"))
        functions = {
            name: Function(
                tuple(tuple(word) for word in each["results"]),
                tuple(tuple(word) for word in each["arguments"]),
                each["returns"],
            )
            for name, each in given.pop("functions").items()
        }
        return Manifest(functions=functions, **given)
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None


def lacking_objects(names: Iterable[str]) -> list[str]:
    """Those of the files that are missing, not as they were written, or older than the sources."""
    manifest = read_manifest()
    if manifest is None or changed_sources(manifest):
        return list(names)
    return [name for name in names if read_object(manifest, name) is None]


def read_object(manifest: Manifest, name: str) -> bytes | None:
    """Content of a file; None where it is missing or not as it was written."""
    try:
        content = (objects_folder() / name).read_bytes()
    except OSError:
        return None
    return content if manifest.objects.get(name) == digest(content) else None


def digest(content: bytes) -> str:
    """Digest by which files are compared."""
    return hashlib.sha256(content).hexdigest()


def changed_sources(manifest: Manifest) -> list[str]:
    """Sources that are not as they were when they were compiled."""
    package = resources.files("frictionlab")
    return [path for path, known in manifest.sources.items() if _digest_of(package, path) != known]


def _digest_of(package: Any, path: str) -> str:
    try:
        return digest((package / path).read_bytes())
    except OSError:
        return ""
