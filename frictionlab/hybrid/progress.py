"""A progress bar that appears after a second, and ctrl-C that ends a run without losing it."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from types import TracebackType
from typing import Any

PROGRESS_DELAY = 1.0  # seconds before a bar is shown
PROGRESS_VARIABLE = "FRICTIONLAB_PROGRESS"  # of the environment: 0, off, no or false shows no bars

_switch = {"shown": os.environ.get(PROGRESS_VARIABLE, "1").strip().lower() not in ("0", "off", "no", "false")}


class ProgressSetting:
    """A setting of `progress`; at the end of a ``with`` block the one before holds again."""

    def __init__(self, before: bool) -> None:
        self._before = before

    def __enter__(self) -> ProgressSetting:
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        _switch["shown"] = self._before


def progress(shown: bool) -> ProgressSetting:
    """Show progress bars or none, from now on or within a ``with`` block.

    Without bars nothing is said of the compilation of the solver either.  ``progress=False`` of a single
    function shows none in any case.  The environment variable FRICTIONLAB_PROGRESS=0 does the same for all
    sessions.

    Parameters
    ----------
    shown : bool

    Returns
    -------
    ProgressSetting
        For ``with``.

    Examples
    --------
    >>> import frictionlab as fl
    >>> with fl.progress(False):
    ...     run = fl.simulate(fl.SliderOnBelt(), 0.1)
    """
    if not isinstance(shown, bool):
        raise TypeError(f"shown must be True or False, got {shown!r}: write fl.progress(False)")
    setting = ProgressSetting(_switch["shown"])
    _switch["shown"] = shown
    return setting


def progress_bar(*arguments: Any, shown: bool = True, **options: Any) -> Any:
    """A bar of tqdm that appears after a second and leaves nothing behind, if bars are shown at all."""
    from tqdm.auto import tqdm

    usual = {"leave": False, "delay": PROGRESS_DELAY, "disable": not (shown and _switch["shown"])}
    return tqdm(*arguments, **(usual | options))


class Progress:
    """Counts simulated seconds; `update` tells whether the user asked to stop.

    A first ctrl-C is noted, and the run ends at the next update with what it has; a second one interrupts at
    once.  In a thread other than the main one Python delivers no signals, so nothing is installed there.
    """

    def __init__(self, t_end: float, show: bool = True, compiling: bool = False) -> None:
        # In a thread of a sweep, which has a bar of its own, runs show none.
        alone = threading.current_thread() is threading.main_thread()
        self._t_end, self._show = t_end, show and _switch["shown"] and alone
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
        form = "{l_bar}{bar}| {n:.4g}/{total:.4g} s [{elapsed}<{remaining}]"
        return progress_bar(total=self._t_end, bar_format=form, desc="simulate", delay=0.0)
