"""A mark that appears where an update takes longer than one notices."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import ipywidgets

DELAY = 0.3  # seconds


class Busy:
    """A line of text, seen while something computes."""

    def __init__(self) -> None:
        self.widget = ipywidgets.HTML("computing …", layout=ipywidgets.Layout(visibility="hidden"))
        self.widget.add_class("fl-busy")
        self.shown = 0  # times it has appeared

    @contextmanager
    def mark(self) -> Iterator[None]:
        """Show the mark after DELAY, until the block is done."""
        timer: Any = threading.Timer(DELAY, self._show)
        timer.daemon = True
        timer.start()
        try:
            yield
        finally:
            timer.cancel()
            timer.join()
            self.widget.layout.visibility = "hidden"

    def _show(self) -> None:
        self.shown += 1
        self.widget.layout.visibility = "visible"
