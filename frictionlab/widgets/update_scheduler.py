"""The scheduling of an explorer's updates: of the changes that arrive during an update only the last is
computed.

`UpdateScheduler` runs one update at a time.  All changes that arrive during an update are handled by a single
update after it; long updates are done in parts.  `in_this_thread` keeps all drawing in the thread that runs
the cells, as JupyterLab receives messages of widgets in other threads and matplotlib works in one only.
`BusyIndicator` is a line of text that appears when an update takes noticeably long.
"""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any

import ipywidgets

EVENT_LOOP_PAUSE = 0.01  # seconds in which the event loop handles messages from the browser
PAUSE_AFTER_CHANGE = 0.15  # seconds: a slider that moves on should not wait for a long update

INDICATOR_DELAY = 0.3  # seconds
INDICATOR_TEXT = "computing …"
WAITING_TEXT = "waiting for the cell that runs …"
COMPILING_TEXT = "compiling the solver, once on this machine: some 30 s …"
PROGRESS_BAR = '<progress aria-label="done" value="{0}" max="{1}" style="width: 70px"></progress> {0} of {1}'


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
    wait : callable or None
        Called where an update has to wait for that thread.
    """

    def __init__(self, update: Callable[[], None], wait: Callable[[], None] | None = None) -> None:
        self._update, self._wait, self._thread = update, wait, threading.get_ident()
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
        if self._wait is not None and threading.get_ident() != self._thread:
            self._wait()
        self._run()

    def _update_all(self) -> None:
        try:
            while self._next():
                self._update()
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


def has_event_loop() -> bool:
    """Whether an event loop runs, as in a notebook or an application; without one nothing happens later."""
    return running_loop() is not None


def running_loop() -> asyncio.AbstractEventLoop | None:
    """The event loop of the present thread."""
    try:
        return asyncio.get_running_loop()
    except RuntimeError:
        return None


class BusyIndicator:
    """A line of text, shown while something is computed.

    Attributes
    ----------
    left : (int, int) or None
        Parts done and their total, where a computation goes on after the block of `show_while_busy`.
    """

    def __init__(self) -> None:
        self.left: tuple[int, int] | None = None
        self.widget = ipywidgets.HTML(INDICATOR_TEXT, layout=ipywidgets.Layout(visibility="hidden"))
        self.widget.add_class("fl-busy")
        self.shown = 0  # times it has appeared
        self._waiting: threading.Timer | None = None

    def show_waiting(self) -> None:
        """Say after INDICATOR_DELAY that an update waits for a running cell, until the update begins."""
        self._waiting = _started_timer(partial(self._show, WAITING_TEXT))

    @contextmanager
    def show_while_busy(self) -> Iterator[None]:
        """Show the text after INDICATOR_DELAY, until the block, or a computation in parts, is done."""
        if self._waiting is not None:
            _end_timer(self._waiting)
            self._waiting = None
            self.widget.value = self._text()
        timer = _started_timer(self._show)
        try:
            yield
        finally:
            _end_timer(timer)
            self.widget.value = self._text()
            self.widget.layout.visibility = "visible" if self.left else "hidden"

    def announce_compilation(self, compiling: bool) -> None:
        """If the solver has to be compiled first, say so at once, as that takes half a minute."""
        if compiling:
            self._show(COMPILING_TEXT)
        elif not self.left:  # else the progress stays in sight from part to part
            self.widget.value = INDICATOR_TEXT

    def _text(self) -> str:
        return PROGRESS_BAR.format(*self.left) if self.left else INDICATOR_TEXT

    def _show(self, text: str = "") -> None:
        self.shown += 1
        self.widget.value = text or self.widget.value
        self.widget.layout.visibility = "visible"


def _started_timer(show: Callable[[], None]) -> threading.Timer:
    timer = threading.Timer(INDICATOR_DELAY, show)
    timer.daemon = True
    timer.start()
    return timer


def _end_timer(timer: threading.Timer) -> None:
    timer.cancel()
    timer.join()
