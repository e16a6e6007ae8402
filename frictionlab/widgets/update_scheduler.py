"""The scheduling of an explorer's updates: of the changes that arrive during an update only the last is
computed.

`UpdateScheduler` runs one update at a time.  All changes that arrive during an update are handled by a single
update after it; long updates are done in parts.  `in_this_thread` keeps all drawing in the thread that runs
the cells, as JupyterLab receives messages of widgets in other threads and matplotlib works in one only.
"""

from __future__ import annotations

import asyncio
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any

from frictionlab.interruption import HeededInterrupts, InterruptCounter

EVENT_LOOP_PAUSE = 0.01  # seconds in which the event loop handles messages from the browser
PAUSE_AFTER_CHANGE = 0.15  # seconds: a slider that moves on should not wait for a long update


def in_this_thread(function: Callable[..., object]) -> Callable[..., None]:
    """The same function; where another thread calls it, the present thread's event loop runs it instead.

    Matplotlib's settings and its parser of formulas belong to the whole process, and a cell may be drawing
    with them at the same time.  Without an event loop the function runs in the thread that calls it.
    """
    thread, loop = threading.get_ident(), running_loop()

    def call(*values: Any) -> None:
        if loop is None or loop.is_closed() or threading.get_ident() == thread:
            function(*values)
        else:
            loop.call_soon_threadsafe(partial(function, *values))

    return call


class UpdateScheduler:
    """Calls `update` on request, one call at a time, in the thread in which the scheduler was made.

    The update reads the settings when it begins.  Requests while it runs, from within or from another thread,
    make it run once more.  A long update is done in parts, each of which requests the next one.

    Parameters
    ----------
    update : callable
    stopped : callable
        Called with the error where ctrl-C stops an update.  Where no event loop runs, as in a script, the
        error is raised again; it would end a loop.
    """

    def __init__(self, update: Callable[[], None], stopped: Callable[[KeyboardInterrupt], None]) -> None:
        self._update, self._stopped = update, stopped
        self._lock = threading.Lock()
        self._busy = self._asked = False
        self._timer: asyncio.TimerHandle | None = None
        self._run = in_this_thread(self._update_all)

    def request(self) -> None:
        """Update now, or once more after the update that is running."""
        with self._lock:
            self._asked = True
            if self._busy:
                return
            self._busy = True
        self._run()

    def _update_all(self) -> None:
        try:
            with HeededInterrupts():
                while self._next():
                    self._update()
        except KeyboardInterrupt as stop:
            self._busy = False
            with InterruptCounter(sys.maxsize):  # further presses have nothing to stop
                self._stopped(stop)
            if not running_loop():
                raise
            if self._asked:
                self.request()
        except BaseException:
            self._busy = False
            raise

    def request_later(self, pause: float = 0.0) -> None:
        """Update after a pause of at least EVENT_LOOP_PAUSE, in which the event loop handles what comes, such
        as newer values; at once where there is no loop."""
        self.cancel()
        loop = running_loop()
        if loop is None:
            self.request()
        else:
            self._timer = loop.call_later(max(pause, EVENT_LOOP_PAUSE), self.request)

    def cancel(self) -> None:
        """Cancel an update that was requested for later."""
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    @contextmanager
    def batch(self) -> Iterator[None]:
        """Context in which all changes count as one request."""
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


def running_loop() -> asyncio.AbstractEventLoop | None:
    """The event loop of the present thread, as of a notebook or an application; without one nothing happens
    later."""
    try:
        return asyncio.get_running_loop()
    except RuntimeError:
        return None
