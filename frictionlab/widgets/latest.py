"""The last value wins: of the changes that come while an update runs only the last is computed."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

PAUSE = 0.01  # seconds that what has come from the browser is given


class Latest:
    """Calls `update` for what is asked of it, once at a time.

    The update reads the settings when it begins.  What is asked for while it runs, from within or from
    another thread, makes it run once more.  A long update is done in parts, each of which asks for
    the next one.
    """

    def __init__(self, update: Callable[[], None]) -> None:
        self._update = update
        self._lock = threading.Lock()
        self._busy = self._asked = False
        self._timer: asyncio.TimerHandle | None = None

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

    def soon(self) -> None:
        """Update after what waits in the event loop, such as newer values; at once where there is none."""
        self.cancel()
        try:
            loop = asyncio.get_running_loop()
        except RuntimeError:
            self.request()
        else:
            self._timer = loop.call_later(PAUSE, self.request)

    def cancel(self) -> None:
        """No update soon."""
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

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
