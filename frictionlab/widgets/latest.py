"""The last value wins: of the changes that come while an update runs only the last is computed."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager


class Latest:
    """Calls `update` for what is asked of it, once at a time.

    The update reads the settings when it begins.  What is asked for while it runs, from within or from
    another thread, makes it run once more.
    """

    def __init__(self, update: Callable[[], None]) -> None:
        self._update = update
        self._lock = threading.Lock()
        self._busy = self._asked = False

    def request(self) -> None:
        """Update now, or once more after the update that is under way."""
        with self._lock:
            self._asked = True
            if self._busy:
                return
            self._busy = True
        try:
            while self._next():
                self._update()
        except BaseException:
            self._busy = False
            raise

    @contextmanager
    def held(self) -> Iterator[None]:
        """Changes made inside count as one."""
        before, self._busy = self._busy, True
        try:
            yield
        finally:
            self._busy = before
        if not before:
            self.request()

    def _next(self) -> bool:
        with self._lock:
            asked, self._asked = self._asked, False
            if not asked:
                self._busy = False
            return asked
