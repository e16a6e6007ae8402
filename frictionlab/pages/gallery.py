"""`frictionlab page --all`: a folder with a page of each scene of the library, and an index.

The pages are those of `fl.export_page`; their menu leads from one to the other.  A page that is there from
the same sources is not written again, so that an export that was stopped goes on where it was.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from frictionlab.file_writing import write_text
from frictionlab.interruption import progress_bar
from frictionlab.models.library.catalogue import PRESETS, ROW_MODELS, list_models
from frictionlab.models.model import Model
from frictionlab.models.zoo.topics import TOPICS
from frictionlab.pages.export import (
    SCRIPTS,
    html_page,
    model_page,
    script_text,
    solver_data,
)
from frictionlab.pages.scene import Data, mechanism_data
from frictionlab.validation import check_path

WORTH_SEEING = "worth seeing"
INDEX = "index.html"
INDEX_SCRIPTS = ("text", "svg", "plot", "layout", "friction", "panels", "gallery")
EXPLORER_CARD = {
    "name": "explorer with Python",
    "topic": "in Python",
    "about": "all of these in one explorer, with every law and method of the package; four at once",
    "reason": "",
    "mechanism": None,
}
HEAD = 2000  # bytes of a page in which its mark is


class LibraryScene(NamedTuple):
    """A model of the library as explorers and pages show it."""

    name: str
    topic: str
    model: Model
    about: str

    @property
    def file(self) -> str:
        """The name of its page's file."""
        return re.sub(r"\W+", "-", self.name.replace("fl.", "")).strip("-") + ".html"


@dataclass(frozen=True)
class Gallery:
    """What an export of the library has written.

    Parameters
    ----------
    index : Path
    written, present : tuple of str
        Scenes whose pages were written, and those whose pages were there.
    refused : dict of str to str
        Scenes that a page cannot show, each with the reason.
    """

    index: Path
    written: tuple[str, ...]
    present: tuple[str, ...]
    refused: dict[str, str]


def library_scenes() -> tuple[LibraryScene, ...]:
    """The scenes worth seeing, then all models."""
    models = (*ROW_MODELS, *(cls() for classes in TOPICS.values() for cls in classes))
    rows = zip(list_models(), models, strict=True)
    return (
        *(LibraryScene(each.name, WORTH_SEEING, each.model, each.about) for each in PRESETS),
        *(LibraryScene(row.call, row.topic, model, row.about) for row, model in rows),
    )


def scene_labels(scenes: Iterable[LibraryScene]) -> list[Data]:
    """The entries of a menu of scenes."""
    return [
        {
            "name": each.name,
            "label": each.name if each.topic == WORTH_SEEING else f"model: {each.name}",
            "page": each.file,
        }
        for each in scenes
    ]


def export_gallery(folder: str | Path, scenes: Iterable[LibraryScene] | None = None) -> Gallery:
    """Write a page for each scene, and the index.

    Parameters
    ----------
    folder : path
        It is made where there is none.
    scenes : iterable of LibraryScene or None
        None takes those of the library.

    Raises
    ------
    SolverNotBuiltError
        As :func:`frictionlab.export_page` does.
    """
    folder = check_path("folder", folder)
    chosen = library_scenes() if scenes is None else tuple(scenes)
    folder.mkdir(parents=True, exist_ok=True)
    mark, menu = sources_mark(), scene_labels(chosen)
    written, present, refused = [], [], {}
    for scene in progress_bar(chosen, desc="pages", unit="page"):
        path = folder / scene.file
        if _is_of(path, mark):
            present.append(scene.name)
            continue
        try:
            write_scene(scene, path, menu, mark)
            written.append(scene.name)
        except ValueError as error:
            refused[scene.name] = str(error)
    index = write_text(folder / INDEX, index_page(chosen, refused))
    return Gallery(index, tuple(written), tuple(present), refused)


def sources_mark() -> str:
    """What tells pages of these sources from those of others."""
    script = script_text(SCRIPTS)
    return hashlib.sha256(f"{script}{solver_data(script)}".encode()).hexdigest()[:16]


def _is_of(path: Path, mark: str) -> bool:
    try:
        with path.open("rb") as page:
            return mark.encode() in page.read(HEAD)
    except OSError:
        return False


def write_scene(scene: LibraryScene, path: Path, menu: list[Data], mark: str = "") -> Path:
    """Write the page of a scene, whose menu leads to the others.

    Raises
    ------
    ValueError
        Where a page cannot show the model.
    """
    own = {"name": scene.name, "about": scene.about, "menu": menu}
    return write_text(path, model_page(scene.model, scene.name, own=own, mark=mark))


def index_page(scenes: Iterable[LibraryScene], refused: dict[str, str], explorer: str = "") -> str:
    """The page with a card for each scene: sketch, name and sentence, or why it is not here.

    The last card leads to an explorer with Python, where `explorer` is its address.
    """
    cards = [_card(scene, refused.get(scene.name, "")) for scene in scenes]
    if explorer:
        cards.append(EXPLORER_CARD | {"page": explorer})
    return html_page("frictionlab: all models", {"CARDS": cards}, script_text(INDEX_SCRIPTS))


def _card(scene: LibraryScene, reason: str) -> Data:
    model = scene.model
    return {
        "name": scene.name,
        "topic": scene.topic,
        "about": scene.about,
        "page": scene.file,
        "reason": reason,
        "mechanism": mechanism_data(model),
        "parameters": dict(model.parameters),
        "states": list(model.coordinates),
    }
