"""Ctrl-C, treated in one way everywhere, and progress bars, which appear after a second.

A computation that is stopped keeps what it has for `partial_result`, and raises KeyboardInterrupt.  A press
is counted, not raised where it happens to arrive (`InterruptCounter`), so that no step and no line of a
file is half done.  A computation in a thread of a sweep looks at the `STOP_SIGN` of that sweep.

Bars and lines go to standard error.  Where there is none (pythonw), or it cannot be written, the computation
goes on.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from contextlib import ExitStack, suppress
from contextvars import ContextVar
from functools import cache
from types import TracebackType
from typing import Any, ClassVar, Self
from weakref import WeakSet

from frictionlab.partial_results import keep_partial_result
from frictionlab.validation import check_flag

POLL_TIME = 0.1  # seconds between two looks at ctrl-C while something else computes

# Functions of `signal` make enums, which takes longer than all else of a short run's handlers; those of
# `_signal` do not.
SIGNALS: Any = sys.modules.get("_signal", signal)

# for the runs in a sweep's threads: set when the sweep no longer waits for them
STOP_SIGN: ContextVar[threading.Event | None] = ContextVar("STOP_SIGN", default=None)
PROGRESS_DELAY = 1.0  # seconds before a bar is shown
URGENT_PRESS = 2  # the press of ctrl-C that interrupts a run at once, wherever it is
PROGRESS_VARIABLE = "FRICTIONLAB_PROGRESS"  # environment variable: 0, off, no or false shows no bars
VOILA = "voila/"  # what Voila says of itself in the environment of its kernels
_switch = {"shown": os.environ.get(PROGRESS_VARIABLE, "1").strip().lower() not in ("0", "off", "no", "false")}


def interruption(what: str, result: Any, more: str = "") -> KeyboardInterrupt:
    """The error after ctrl-C: what was stopped, and where the results so far are.

    It is Python's own class, not one derived from it: for no other does the interpreter tell the shell that
    ctrl-C was pressed, and without that a loop of the shell would go on.
    """
    keep_partial_result(result)
    remark = "nothing was computed yet" if result is None else "frictionlab.partial_result() is what there is"
    return KeyboardInterrupt(f"{what} by ctrl-C; {remark}{more}")


class InterruptCounter:
    """Context in which ctrl-C is counted, and raises KeyboardInterrupt only from the press `limit` on.

    Its end closes the progress bar, if there is one.  Python delivers no signals to threads other than the
    main one, so nothing is installed there; nor where the process ignores them, as in the background of a
    shell.
    """

    def __init__(self, limit: int, bar: Any = None) -> None:
        self.count, self._limit, self.installed = 0, limit, False
        self.bar = bar
        self.in_main_thread = threading.current_thread() is threading.main_thread()
        self._previous: Any = None  # the handler outside

    def __enter__(self) -> Self:
        if self.in_main_thread:
            self._previous = SIGNALS.getsignal(signal.SIGINT)
        self.installed = callable(self._previous)
        if self.installed:
            SIGNALS.signal(signal.SIGINT, self.note)
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if self.installed:
            SIGNALS.signal(signal.SIGINT, self._previous)
        if self.bar is not None:
            self.bar.close()

    def note(self, number: int, frame: Any) -> None:
        """Count a press; a handler of signals."""
        self.count += 1
        if self.count >= self._limit:
            raise KeyboardInterrupt


class HeededInterrupts:
    """Context in which ctrl-C raises KeyboardInterrupt, also where the process ignores it.

    The kernel of a notebook ignores it but for when a cell runs; an explorer computes between cells.
    """

    def __enter__(self) -> None:
        in_main_thread = threading.current_thread() is threading.main_thread()
        self._previous = SIGNALS.getsignal(signal.SIGINT) if in_main_thread else None
        if self._previous == SIGNALS.SIG_IGN:
            SIGNALS.signal(signal.SIGINT, SIGNALS.default_int_handler)

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if self._previous == SIGNALS.SIG_IGN:
            SIGNALS.signal(signal.SIGINT, self._previous)


def progress(shown: bool) -> ExitStack:
    """Show progress bars or none, from now on or within a ``with`` block.

    Without bars no message says that the solver is being compiled either.  A single function shows no bar
    with its keyword ``progress=False``.  The environment variable FRICTIONLAB_PROGRESS=0 turns bars off in
    all sessions.

    Parameters
    ----------
    shown : bool

    Returns
    -------
    contextlib.ExitStack
        For ``with``, at whose end the setting is again what it was before.

    Examples
    --------
    >>> import frictionlab as fl
    >>> with fl.progress(False):
    ...     run = fl.simulate(fl.SliderOnBelt(), 0.1)
    """
    shown = check_flag("shown", shown, "write fl.progress(False)")
    setting = ExitStack()
    setting.callback(_switch.update, shown=_switch["shown"])
    _switch["shown"] = shown
    return setting


class _ForgivingStream:
    """A stream whose failure stops nothing."""

    def __init__(self, stream: Any) -> None:
        self._stream = stream

    def write(self, text: str) -> None:
        with suppress(OSError, ValueError):  # a full disk; a closed stream
            self._stream.write(text)

    def flush(self) -> None:
        with suppress(OSError, ValueError):
            self._stream.flush()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


def tell(text: str) -> None:
    """Write a line to standard error, if that can be done."""
    if sys.stderr is not None:
        stream = _ForgivingStream(sys.stderr)
        stream.write(f"{text}\n")
        stream.flush()


@cache
def _bar_class() -> Any:
    """tqdm's class of bars, with a lock of this process alone and no thread that monitors them.

    tqdm's own lock is shared with all forked processes.  If one of them is killed while it writes its bar, as
    a worker that has run out of memory, the lock stays taken, and every later bar waits for ever.
    """
    from tqdm.auto import tqdm

    class Bar(tqdm):
        monitor_interval = 0
        _instances: ClassVar[WeakSet[Any]] = WeakSet()

    def take_new_lock() -> None:
        Bar.set_lock(threading.RLock())

    take_new_lock()
    if hasattr(os, "register_at_fork"):  # if another thread held it, the child has nobody to release it
        os.register_at_fork(after_in_child=take_new_lock)
    return Bar


def progress_bar(*arguments: Any, shown: bool = True, delay: float = PROGRESS_DELAY, **options: Any) -> Any:
    """tqdm's bar, which vanishes when it is done; `options` are tqdm's.

    No bar is shown on a page of Voila.  That shows outputs when all is computed, and in the place of a bar
    that has vanished "Error displaying widget: model not found".
    """
    bar = _bar_class()
    if sys.stderr is None or os.environ.get("SERVER_SOFTWARE", "").startswith(VOILA):
        return bar(*arguments, disable=True)
    shown = shown and _switch["shown"]
    options |= {"leave": False, "delay": delay, "file": _ForgivingStream(sys.stderr)}
    options |= {"miniters": 0}  # only the time since it was last drawn decides, as no thread monitors it
    return bar(*arguments, disable=not shown, **options)


class Progress(InterruptCounter):
    """Counts simulated seconds; `update` tells whether the user asked to stop.

    A first ctrl-C is noted, and the run ends at the next update with what it has; a second one interrupts at
    once.  In a thread of a sweep a run shows no bar, and ends where the sweep no longer waits for it.
    """

    def __init__(self, t_end: float, show: bool = True, compiling: bool = False) -> None:
        super().__init__(URGENT_PRESS)
        # In a thread of a sweep, which has a bar of its own, runs show none.
        self._t_end, self._show = t_end, show and _switch["shown"] and self.in_main_thread
        self._sign = STOP_SIGN.get()
        self._since = time.monotonic()
        if self._show and compiling:
            tell("compiling the solver, once on this machine: some 30 s")

    @property
    def stopped(self) -> bool:
        """Whether the user or the sweep asked to stop, even if the run had just come to its end."""
        return self.count > 0 or (self._sign is not None and self._sign.is_set())

    def update(self, t: float) -> bool:
        """Show that time `t` was reached; returns whether the run is to stop."""
        if self.stopped:
            return True
        late = time.monotonic() - self._since > PROGRESS_DELAY
        if self._show and late and self.bar is None and t < self._t_end:
            form = "{l_bar}{bar}| {n:.4g}/{total:.4g} s [{elapsed}<{remaining}]"
            self.bar = progress_bar(total=self._t_end, bar_format=form, desc="simulate", delay=0.0)
        if self.bar is not None:
            self.bar.update(t - self.bar.n)
        return False
