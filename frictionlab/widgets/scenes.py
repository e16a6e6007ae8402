"""The explorer of all models: a menu of scenes and models above it, and a link that sets it.

`frictionlab app` shows it.  A link is the page's address followed by the scene and what was changed in it,
such as ``?scene=two+fates&mu_k=1.5``.
"""

from __future__ import annotations

import os
from html import escape
from typing import TYPE_CHECKING, Any
from urllib.parse import parse_qsl, urlencode

import ipywidgets

from frictionlab.models.library.catalogue import CLASSICS, PRESETS, ROW_MODELS, list_models
from frictionlab.models.zoo.topics import TOPICS
from frictionlab.validation import abbreviate, did_you_mean_or_known

from .explorer import Explorer, explore
from .layout import error_text
from .state import FileButton, State, state_from_text
from .update_scheduler import in_this_thread

if TYPE_CHECKING:
    from frictionlab.models.model import Model

SCENE = "scene"  # the name of the scene's entry in a link
LINK_VARIABLE = "QUERY_STRING"  # environment variable in which Voila tells a kernel what follows the address


def scene_models() -> dict[str, tuple[Any, str]]:
    """Model and description of every scene, by its name: the scenes worth seeing, then all models."""
    scenes = {preset.name: (preset.model, preset.about) for preset in PRESETS}
    rows = list_models(CLASSICS)
    classics = {row.call: (model, row.about) for row, model in zip(rows, ROW_MODELS, strict=True)}
    zoo = {f"{cls.__name__}()": (cls(), cls.about) for classes in TOPICS.values() for cls in classes}
    return scenes | classics | zoo


class Scenes:
    """A menu of scenes and the explorer of the one that is chosen.

    Parameters
    ----------
    link : str
        A page's address, or what follows it: "?scene=two+fates&mu_k=1.5"; empty opens the first scene.
    panels : iterable of str or callable, or None
        As :func:`~frictionlab.explore` takes them.

    Attributes
    ----------
    menu : Dropdown
        Its value is the scene's name.
    explorer : Explorer
    widget : Box
    """

    def __init__(self, link: str = "", panels: Any = None) -> None:
        self._scenes, self._panels = scene_models(), panels
        options = [(name if name in _preset_names() else f"model: {name}", name) for name in self._scenes]
        self.menu = ipywidgets.Dropdown(options=options, description="scene", value=PRESETS[0].name)
        self.menu.add_class("fl-scene").tooltip = "scenes worth seeing, then all models"
        self.menu.layout = ipywidgets.Layout(width="auto", flex="1 1 17em", min_width="0", max_width="32em")
        self.about = ipywidgets.HTML().add_class("fl-about")
        self.copy_link = FileButton(
            "copy link", "an address that opens this scene as it is", self.link, print
        )
        self.widget = ipywidgets.VBox().add_class("fl-scenes")
        # Only the link's scene is opened, not the first one before it: an explorer takes a second to make.
        try:
            scene, values = values_of_link(link, list(self._scenes))
            wrong = None
        except ValueError as error:
            scene, values, wrong = "", {}, error
        self.menu.value = scene or PRESETS[0].name
        self.explorer: Explorer = self._open(scene or PRESETS[0].name)
        self.menu.observe(in_this_thread(lambda change: self._open(change["new"])), names="value")
        if wrong is not None:
            self._failed(wrong)
        elif values:
            self._set(values)

    def link(self) -> str:
        """What to put after the page's address to open this scene with the changes made in it.

        Raises
        ------
        ValueError
            For a model that was loaded and is not in the menu.
        """
        if not self._has_link:
            raise ValueError("a link must be of a model of the menu, got one that was loaded: save its state")
        texts = {name: _as_text(value) for name, value in self.explorer.changed().items()}
        return f"?{urlencode({SCENE: self.menu.value, **texts})}"

    def load(self, content: str | bytes) -> None:
        """Open the model of a saved state and set its controls.

        Raises
        ------
        ValueError
            If it is no state.
        """
        model, changed = state_from_text(content)
        name = next((name for name, (each, _) in self._scenes.items() if each == model), None)
        if name is None:
            self._show(model, "")
        elif name == self.menu.value:
            self._open(name)
        else:
            self.menu.value = name
        self._has_link = name is not None
        self._set(changed)

    def _open(self, name: str) -> Explorer:
        self._has_link = True
        return self._show(*self._scenes[name])

    def _show(self, model: Model, about: str) -> Explorer:
        old = getattr(self, "explorer", None)
        self.explorer = explore(model, self._panels)
        self.explorer.files.take = self.load
        self.about.value = escape(about)
        row = ipywidgets.Box([self.menu, self.copy_link], layout=ipywidgets.Layout(flex_flow="row wrap"))
        self.widget.children = [row, self.about, self.explorer.widget]
        if old is not None:
            old.close()
        return self.explorer

    def _set(self, values: State) -> None:
        try:
            self.explorer.set_values(values)
        except (TypeError, ValueError) as error:
            self._failed(error)

    def _failed(self, error: Exception) -> None:
        self.explorer.layout.show_message(error_text(error))

    def _repr_mimebundle_(self, **options: Any) -> Any:
        return self.widget._repr_mimebundle_(**options)


def values_of_link(link: str, scenes: list[str]) -> tuple[str, State]:
    """The scene, "" where the link has none, and the values of controls.

    Raises
    ------
    ValueError
        For an unknown scene.

    Examples
    --------
    >>> values_of_link("?scene=flutter&mu_k=0.5", ["flutter"])
    ('flutter', {'mu_k': '0.5'})
    """
    values: State = dict(parse_qsl(link.rpartition("?")[2]))
    values.pop("token", None)
    scene = values.pop(SCENE, "")
    if scene and scene not in scenes:
        hint = did_you_mean_or_known(scene, scenes)
        raise ValueError(f"scene in the link must be one of the menu, got {abbreviate(scene)}{hint}")
    return scene, values


def open_scenes() -> Scenes:
    """The explorer of all models, set as the link says with which a browser opened the page."""
    return Scenes(os.environ.get(LINK_VARIABLE, ""))


def _preset_names() -> set[str]:
    return {preset.name for preset in PRESETS}


def _as_text(value: Any) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)
