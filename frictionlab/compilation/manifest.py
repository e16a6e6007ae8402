"""What has been compiled, and from which sources: a file beside the objects."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, field, replace
from importlib import resources
from typing import Any, NamedTuple

from frictionlab.compilation.kernel_sources import code_digest, digest

# The repository's objects, for all targets; what has been compiled on this machine since, which git ignores.
# The latter counts where the former were made from other sources.
FOLDERS = REPOSITORY, MACHINE = "objects", "objects_of_machine"
FILE = "manifest.json"
Word = tuple[str, str, int]  # name, type, number of axes (0: a number)


@dataclass(frozen=True)
class Function:
    """The table of a function: its results, then its arguments.

    `returns` names the class of named tuples that the results form; "" where there is one result or none.
    """

    results: tuple[Word, ...]
    arguments: tuple[Word, ...]
    returns: str = ""


class Source(NamedTuple):
    """Digests of a file that compiled code depends on.

    Parameters
    ----------
    bytes : str
        Of all of it; while this one holds, the other need not be computed.
    code : str
        Of the code that matters (:func:`code_digest`).
    names : tuple of str
        The definitions that matter; none: all of the file.
    """

    bytes: str
    code: str
    names: tuple[str, ...]


@dataclass(frozen=True)
class Manifest:
    """What a folder of objects holds.

    Parameters
    ----------
    sources : dict of str to Source
        The files that compiled code depends on, by their paths in the package.
    functions : dict of str to Function
        The entry points that Python calls.
    symbols : tuple of str
        Functions that native code calls.
    objects : dict of str to str
        Digest of each file with machine code, by its name.
    versions : dict of str to str
        Of Python and of the packages that made them.
    """

    sources: dict[str, Source]
    functions: dict[str, Function] = field(default_factory=dict)
    symbols: tuple[str, ...] = ()
    objects: dict[str, str] = field(default_factory=dict)
    versions: dict[str, str] = field(default_factory=dict)

    def to_json(self) -> str:
        return json.dumps(asdict(self), indent=1)


def objects_folder(name: str) -> Any:
    """One of the folders of objects, which may be in a zip file."""
    return resources.files("frictionlab.compilation") / name


def read_manifest(folder: Any) -> Manifest | None:
    """The manifest in a folder of objects; None where it is missing or damaged."""
    try:
        data = json.loads((folder / FILE).read_text(encoding="utf-8"))
        functions = {
            name: Function(
                tuple(tuple(word) for word in each["results"]),
                tuple(tuple(word) for word in each["arguments"]),
                each["returns"],
            )
            for name, each in data.pop("functions").items()
        }
        sources = {
            path: Source(of_bytes, of_code, tuple(names))
            for path, (of_bytes, of_code, names) in data.pop("sources").items()
        }
        return Manifest(sources, functions, **data)
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None


class CompiledObject(NamedTuple):
    """A file that was compiled from the present sources: its folder, name and content, and its manifest."""

    folder: str
    name: str
    content: bytes
    manifest: Manifest


def compiled_object(files: Sequence[str]) -> CompiledObject | str:
    """The first of these files that was compiled from the present sources; else why there is none."""
    reason = "the kernels have not been compiled ahead of time"
    for name in FOLDERS:
        folder = objects_folder(name)
        manifest = read_manifest(folder)
        if manifest is None:
            continue
        if edits := changed_sources(manifest):
            reason = f"kernels have changed since they were compiled ahead of time ({edits[0]})"
            continue
        for file in files:
            content = _read_object(folder / file, manifest)
            if content is not None:
                return CompiledObject(name, file, content, manifest)
    return reason


def lacking_objects(names: Iterable[str]) -> list[str]:
    """Those of the files that are missing, not as they were written, or made from other sources."""
    return [name for name in names if isinstance(compiled_object([name]), str)]


def _read_object(file: Any, manifest: Manifest) -> bytes | None:
    """Content of a file; None where it is missing or not as it was written."""
    try:
        content = file.read_bytes()
    except OSError:
        return None
    return content if manifest.objects.get(file.name) == digest(content) else None


def changed_sources(manifest: Manifest) -> list[str]:
    """Sources that have changed since they were compiled."""
    package = resources.files("frictionlab")
    return [path for path, source in manifest.sources.items() if not _is_source(package, path, source)]


def _is_source(package: Any, path: str, expected: Source) -> bool:
    """Whether a file has the same bytes, or else the same code that matters, as when it was compiled."""
    try:
        content = (package / path).read_bytes()
    except OSError:
        return False
    return digest(content) == expected.bytes or code_digest(content, expected.names) == expected.code


def refreshed(manifest: Manifest) -> Manifest:
    """The manifest of the same objects with the digests of the present files.

    Where only their prose has changed since, they need not be taken apart at every start.
    """
    package = resources.files("frictionlab")
    contents = {path: (package / path).read_bytes() for path in manifest.sources}
    sources = {path: source(contents[path], known.names) for path, known in manifest.sources.items()}
    return replace(manifest, sources=sources)


def source(content: bytes, names: tuple[str, ...]) -> Source:
    """The digests of a file of which these names matter."""
    return Source(digest(content), code_digest(content, names), names)
