"""A mark that appears where an update takes longer than one notices."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import ipywidgets

DELAY = 0.3  # seconds
TEXT = "computing …"
BAR = '<progress value="{0}" max="{1}" style="width: 70px"></progress> {0} of {1}'


class Busy:
    """A line of text, seen while something computes.

    Attributes
    ----------
    left : (int, int) or None
        How much is done, and of how much, where a computation goes on after the block that is marked.
    """

    def __init__(self) -> None:
        self.left: tuple[int, int] | None = None
        self.widget = ipywidgets.HTML(TEXT, layout=ipywidgets.Layout(visibility="hidden"))
        self.widget.add_class("fl-busy")
        self.shown = 0  # times it has appeared

    @contextmanager
    def mark(self) -> Iterator[None]:
        """Show the mark after DELAY until the block is done, or on until all is done."""
        timer: Any = threading.Timer(DELAY, self._show)
        timer.daemon = True
        timer.start()
        try:
            yield
        finally:
            timer.cancel()
            timer.join()
            self.widget.value = BAR.format(*self.left) if self.left else TEXT
            self.widget.layout.visibility = "visible" if self.left else "hidden"

    def _show(self) -> None:
        self.shown += 1
        self.widget.layout.visibility = "visible"
