"""The explorer of all models: one front end with a menu of scenes and models.

`frictionlab app` shows it.  A link is the page's address followed by the scene and what was changed in it,
such as ``#scene=two+fates&mu_k=1.5``; the front end reads and writes it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from frictionlab.pages.gallery import library_scenes, scene_labels
from frictionlab.pages.scene import panels_of
from frictionlab.validation import abbreviate, did_you_mean_or_known

from .explorer import Explorer, error_text
from .front_end import FrontEnd
from .panels.standard import select_panels
from .result import starting_settings
from .update_scheduler import in_this_thread


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
        scenes = library_scenes()
        self._scenes = {each.name: each for each in scenes}
        self._menu, self._panels, self._address = scene_labels(scenes), panels, address
        self.widget = FrontEnd()
        self.widget.answers["open"] = in_this_thread(self._opened)
        self.explorer: Explorer | None = None
        self.open(scenes[0].name)

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
        _, _, model, about = self._scenes[name]
        panels = select_panels(panels_of(model) if self._panels is None else self._panels)
        own = {"name": name, "about": about, "menu": self._menu, "address": self._address, "plays": True}
        self.explorer = Explorer(starting_settings(model), panels, self.widget, **own)
        return self.explorer

    def _opened(self, asked: Mapping[str, Any]) -> None:
        """Show the scene that the browser asks for, with what was changed in it."""
        try:
            self.open(asked["name"]).set_values(asked["changed"])
        except (TypeError, ValueError) as error:
            self.widget.error = error_text(error)

    def _repr_mimebundle_(self, **options: Any) -> Any:
        return self.widget._repr_mimebundle_(**options)
