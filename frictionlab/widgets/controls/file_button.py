"""A button whose click makes a file, which the browser downloads, or a text, which it copies."""

from __future__ import annotations

from collections.abc import Callable
from importlib import resources
from typing import Any, NamedTuple

import anywidget
import traitlets


class MadeFile(NamedTuple):
    """A file for a browser: its name, its media type, its content."""

    name: str
    type: str
    content: bytes


class FileButton(anywidget.AnyWidget):
    """Asks for a file, or a text, when it is pressed.

    Parameters
    ----------
    label, hint : str
    make : callable
        Gives a `MadeFile`, or a text to copy.
    failed : callable
        Is given the error where `make` raises one.
    """

    _esm = (
        resources.files("frictionlab.widgets.controls").joinpath("file_button.js").read_text(encoding="utf-8")
    )
    label = traitlets.Unicode().tag(sync=True)
    hint = traitlets.Unicode().tag(sync=True)  # the name tooltip makes views fail

    def __init__(
        self, label: str, hint: str, make: Callable[[], MadeFile | str], failed: Callable[[Exception], None]
    ) -> None:
        super().__init__(label=label, hint=hint)
        self._make, self._failed = make, failed
        self.on_msg(self._pressed)

    def _pressed(self, *_: Any) -> None:
        try:
            made = self._make()
        except Exception as error:  # told beside the picture: a missing library, a full disk
            self._failed(error)
            return
        if isinstance(made, str):
            self.send({"text": made})
        else:
            self.send({"name": made.name, "type": made.type}, [made.content])
