"""The explorer of all models: one front end with a menu of scenes and models.

`frictionlab app` shows it.  A link is the page's address followed by the scene and what was changed in it,
such as ``#scene=two+fates&mu_k=1.5``; the front end reads and writes it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from frictionlab.models.library.catalogue import CLASSICS, PRESETS, ROW_MODELS, list_models
from frictionlab.models.zoo.topics import TOPICS
from frictionlab.pages.scene import panels_of
from frictionlab.validation import abbreviate, did_you_mean_or_known

from .explorer import Explorer, error_text
from .front_end import FrontEnd
from .panels.standard import select_panels
from .result import default_settings
from .update_scheduler import in_this_thread


def scene_models() -> dict[str, tuple[Any, str]]:
    """Model and description of every scene, by its name: the scenes worth seeing, then all models."""
    scenes = {preset.name: (preset.model, preset.about) for preset in PRESETS}
    rows = list_models(CLASSICS)
    classics = {row.call: (model, row.about) for row, model in zip(rows, ROW_MODELS, strict=True)}
    zoo = {f"{cls.__name__}()": (cls(), cls.about) for classes in TOPICS.values() for cls in classes}
    return scenes | classics | zoo


class Scenes:
    """A front end with a menu of scenes, and the explorer of the one that is chosen.

    Parameters
    ----------
    panels : iterable of str or callable, or None
        As :func:`~frictionlab.explore` takes them.
    address : bool
        Whether the page's address holds what is set, as in the app.

    Attributes
    ----------
    explorer : Explorer
    widget : FrontEnd
    """

    def __init__(self, panels: Any = None, address: bool = False) -> None:
        self._scenes, self._panels, self._address = scene_models(), panels, address
        worth_seeing = {preset.name for preset in PRESETS}
        self._menu = [
            {"name": name, "label": name if name in worth_seeing else f"model: {name}"}
            for name in self._scenes
        ]
        self.widget = FrontEnd()
        self.widget.opens = in_this_thread(self._opened)
        self.explorer: Explorer | None = None
        self.open(PRESETS[0].name)

    def open(self, name: str) -> Explorer:
        """Show a scene of the menu.

        Raises
        ------
        ValueError
            For an unknown scene.
        """
        if name not in self._scenes:
            hint = did_you_mean_or_known(name, list(self._scenes))
            raise ValueError(f"scene must be one of the menu, got {abbreviate(name)}{hint}")
        if self.explorer is not None:
            self.explorer.release()
        model, about = self._scenes[name]
        panels = select_panels(panels_of(model) if self._panels is None else self._panels)
        own = {"name": name, "about": about, "menu": self._menu, "address": self._address, "plays": True}
        self.explorer = Explorer(default_settings(model), panels, self.widget, **own)
        return self.explorer

    def _opened(self, name: str, changed: Mapping[str, Any]) -> None:
        """Show the scene that the browser asks for, with what was changed in it."""
        try:
            self.open(name).set_values(changed)
        except (TypeError, ValueError) as error:
            self.widget.error = error_text(error)

    def _repr_mimebundle_(self, **options: Any) -> Any:
        return self.widget._repr_mimebundle_(**options)


def open_scenes(address: bool = False) -> Scenes:
    """The explorer of all models."""
    return Scenes(address=address)
