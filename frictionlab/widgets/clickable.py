"""A PNG that says where it is clicked."""

from __future__ import annotations

from collections.abc import Callable
from importlib import resources
from typing import Any

import anywidget
import traitlets


class ClickablePicture(anywidget.AnyWidget):
    """A picture in the browser, as :class:`ipywidgets.Image` is one.

    Attributes
    ----------
    value : bytes
        PNG.
    hint : str
        What a click does.
    """

    _esm = resources.files("frictionlab.widgets").joinpath("clickable.js").read_text(encoding="utf-8")
    value = traitlets.Bytes().tag(sync=True)
    hint = traitlets.Unicode().tag(sync=True)  # views fail where it is called tooltip

    def on_click(self, clicked: Callable[[float, float], None]) -> None:
        """Have a function called with shares of the width, from the left, and of the height, from below."""

        def heard(_: Any, content: dict[str, Any], __: Any) -> None:
            clicked(float(content["x"]), float(content["y"]))

        self.on_msg(heard)
