"""A progress bar that appears after a second, and ctrl-C that ends a run without losing it."""

from __future__ import annotations

import signal
import sys
import threading
import time
from types import TracebackType
from typing import Any

PROGRESS_DELAY = 1.0  # seconds before a bar is shown


class Progress:
    """Counts simulated seconds; `update` tells whether the user asked to stop.

    A first ctrl-C is noted, and the run ends at the next update with what it has; a second one interrupts at
    once.  In a thread other than the main one Python delivers no signals, so nothing is installed there.
    """

    def __init__(self, t_end: float, show: bool = True, compiling: bool = False) -> None:
        # In a thread of a sweep, which has a bar of its own, runs show none.
        self._t_end, self._show = t_end, show and threading.current_thread() is threading.main_thread()
        self._compiling = compiling
        self._stop = False
        self._since = time.monotonic()
        self._bar: Any = None
        self._previous: Any = None

    def __enter__(self) -> Progress:
        if threading.current_thread() is threading.main_thread():
            self._previous = signal.getsignal(signal.SIGINT)
            if callable(self._previous):
                signal.signal(signal.SIGINT, self._note)
        if self._show and self._compiling:
            print("compiling the solver, once on this machine: some 30 s", file=sys.stderr, flush=True)
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if callable(self._previous):
            signal.signal(signal.SIGINT, self._previous)
        if self._bar is not None:
            self._bar.close()

    def _note(self, number: int, frame: Any) -> None:
        if self._stop:
            raise KeyboardInterrupt
        self._stop = True

    def update(self, t: float) -> bool:
        """Show that time `t` was reached; returns whether the run is to stop."""
        late = time.monotonic() - self._since > PROGRESS_DELAY
        if self._show and late and self._bar is None and t < self._t_end:
            self._bar = self._new_bar()
        if self._bar is not None:
            self._bar.update(t - self._bar.n)
        return self._stop

    def _new_bar(self) -> Any:
        from tqdm.auto import tqdm

        form = "{l_bar}{bar}| {n:.4g}/{total:.4g} s [{elapsed}<{remaining}]"
        return tqdm(total=self._t_end, leave=False, bar_format=form, desc="simulate")
