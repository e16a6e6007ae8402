"""Ctrl-C, treated in one way everywhere, and progress bars, which appear after a second.

A computation that is stopped keeps what it has for `partial_result`, and raises KeyboardInterrupt.  A press
is counted, not raised where it happens to arrive (`deferred_interrupts`), so that no step and no line of a
file is half done.  What compiles for seconds runs in a thread of its own (`call_in_background`), so that a
press is answered meanwhile.  A computation in a thread of a sweep looks at the `STOP_SIGN` of that sweep.

What is shown goes to standard error where there is one: neither its lack (pythonw) nor a full disk behind it
ends a computation, or changes the exit status of a script.  Warnings and tracebacks are Python's own: where
one of these cannot be written, the interpreter ends with status 120.
"""

from __future__ import annotations

import atexit
import ctypes
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future, wait
from contextlib import ExitStack, contextmanager, suppress
from contextvars import ContextVar, copy_context
from functools import cache
from types import TracebackType
from typing import Any, ClassVar
from weakref import WeakSet

POLL_TIME = 0.1  # seconds between two looks at ctrl-C while something else computes

# Without the enums of the module `signal`, which take longer than all else of a short run's handlers.
SIGNALS: Any = sys.modules.get("_signal", signal)

_LAST: list[Any] = [None]  # the result of the last interruption
# of the sweep in whose thread a run is: set when the sweep no longer waits for it
STOP_SIGN: ContextVar[threading.Event | None] = ContextVar("STOP_SIGN", default=None)


def interruption(what: str, result: Any, more: str = "") -> KeyboardInterrupt:
    """The error after ctrl-C: what was stopped, and where what was computed is.

    It is Python's own and no class of ours: the interpreter tells the shell only of that one that ctrl-C was
    pressed, and a loop of the shell would go on.
    """
    if threading.current_thread() is threading.main_thread():
        _LAST[0] = result
    kept = "nothing was computed yet" if result is None else "frictionlab.partial_result() is what there is"
    return KeyboardInterrupt(f"{what} by ctrl-C; {kept}{more}")


def partial_result() -> Any:
    """What a computation had computed when ctrl-C stopped it, after the KeyboardInterrupt that says so.

    Returns
    -------
    Trajectory, BatchResult, Bifurcation, Sweep, ... or None
        What the function would have returned, as far as it had come: a run up to the time it had reached, a
        sweep with the values that were done.  Of a function that returns no part of its work, such as
        `steady_state`, the run that was stopped.  None where nothing was stopped in this session, or nothing
        had been computed.

    Examples
    --------
    >>> import frictionlab as fl
    >>> try:
    ...     run = fl.simulate(fl.SliderOnBelt(mu_k=1.4), 0.05)
    ... except KeyboardInterrupt:
    ...     run = fl.partial_result()  # up to where it was stopped; run.status says so
    """
    return _LAST[0]


class Presses:
    """Counts ctrl-C; from the number `limit` on each press interrupts at once."""

    def __init__(self, limit: int) -> None:
        self.count, self._limit = 0, limit
        self.installed = False

    def note(self, number: int, frame: Any) -> None:
        """As a handler of signals."""
        self.count += 1
        if self.count >= self._limit:
            raise KeyboardInterrupt


@contextmanager
def deferred_interrupts(limit: int) -> Iterator[Presses]:
    """Context in which ctrl-C is counted, and raises KeyboardInterrupt at the press number `limit` only.

    In a thread other than the main one Python delivers no signals, so nothing is installed there; nor where
    the process ignores them, as in the background of a shell.
    """
    presses, previous = Presses(limit), None
    if threading.current_thread() is threading.main_thread():
        previous = SIGNALS.getsignal(signal.SIGINT)
    presses.installed = callable(previous)
    if presses.installed:
        SIGNALS.signal(signal.SIGINT, presses.note)
    try:
        yield presses
    finally:
        if presses.installed:
            SIGNALS.signal(signal.SIGINT, previous)


def call_in_background(function: Callable[[], Any], abandoned: Callable[[], Any]) -> Future[Any]:
    """The call of a function in a thread of its own, done, or not done where `abandoned` became true before.

    An abandoned call goes on, and nobody looks at what it gives: a compiler must not be stopped half-way, and
    the next run need not compile what it has compiled.
    """
    future: Future[Any] = Future()

    def work() -> None:
        try:
            future.set_result(function())
        except BaseException as error:
            future.set_exception(error)

    context = copy_context()
    thread = threading.Thread(target=context.run, args=(work,), name="frictionlab-compiler", daemon=True)
    thread.start()
    while not wait([future], POLL_TIME).done and not abandoned():
        pass
    if not future.done():
        atexit.register(_end_thread, thread)
    return future


def _end_thread(thread: threading.Thread) -> None:
    """End an abandoned call before the interpreter ends, which must not pull LLVM from under it.

    It takes as long as the present pass of the compiler.
    """
    sys.unraisablehook = lambda _: None  # the exception may arrive in a callback, which cannot raise it
    while thread.is_alive():
        ctypes.pythonapi.PyThreadState_SetAsyncExc(
            ctypes.c_ulong(thread.ident or 0), ctypes.py_object(SystemExit)
        )
        thread.join(POLL_TIME)


PROGRESS_DELAY = 1.0  # seconds before a bar is shown
URGENT_PRESS = 2  # the press of ctrl-C that interrupts a run at once, wherever it is
PROGRESS_VARIABLE = "FRICTIONLAB_PROGRESS"  # of the environment: 0, off, no or false shows no bars

VOILA = "voila/"  # what Voila says of itself in the environment of its kernels

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


class _ForgivingStream:
    """A stream whose failure ends nothing, neither now nor when the interpreter ends.

    What a buffer of Python's own standard error cannot get rid of makes a script end with status 120, however
    well it went: so that buffer is passed by.
    """

    def __init__(self, stream: Any) -> None:
        self._stream = stream
        own = stream is sys.__stderr__  # others, as that of a notebook, lead elsewhere than to a file
        self._raw = getattr(getattr(stream, "buffer", None), "raw", None) if own else None

    def write(self, text: str) -> None:
        with suppress(OSError, ValueError):  # a full disk; a closed stream
            if self._raw is None:
                self._stream.write(text)
            else:
                self._stream.flush()
                self._raw.write(text.encode(self._stream.encoding, "replace"))

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
    """tqdm's class of bars, with a lock of this process alone and no thread that watches over them.

    tqdm's own lock is shared with all processes that are forked: one of them that is killed while it writes
    its bar, as a worker without memory, would leave the lock taken, and every later bar would wait for ever.
    """
    from tqdm.auto import tqdm

    class Bar(tqdm):
        monitor_interval = 0
        _instances: ClassVar[WeakSet[Any]] = WeakSet()

    def take_new_lock() -> None:
        Bar.set_lock(threading.RLock())

    take_new_lock()
    if hasattr(os, "register_at_fork"):  # where another thread held it, nobody gives it back in the child
        os.register_at_fork(after_in_child=take_new_lock)
    return Bar


def progress_bar(*arguments: Any, shown: bool = True, delay: float = PROGRESS_DELAY, **options: Any) -> Any:
    """tqdm's bar, which vanishes when it is done; `options` are tqdm's.

    None on a page of Voila, which shows outputs when all is computed, and in place of a bar that vanished
    "Error displaying widget: model not found".
    """
    bar = _bar_class()
    if sys.stderr is None or os.environ.get("SERVER_SOFTWARE", "").startswith(VOILA):
        return bar(*arguments, disable=True)
    shown = shown and _switch["shown"]
    options |= {"leave": False, "delay": delay, "file": _ForgivingStream(sys.stderr)}
    options |= {"miniters": 0}  # the time since the last picture decides, as nothing else looks at it
    return bar(*arguments, disable=not shown, **options)


class Progress:
    """Counts simulated seconds; `update` tells whether the user asked to stop.

    A first ctrl-C is noted, and the run ends at the next update with what it has; a second one interrupts at
    once.  In a thread of a sweep a run shows no bar, and ends where the sweep no longer waits for it.
    """

    def __init__(self, t_end: float, show: bool = True, compiling: bool = False) -> None:
        # In a thread of a sweep, which has a bar of its own, runs show none.
        alone = threading.current_thread() is threading.main_thread()
        self._t_end, self._show = t_end, show and _switch["shown"] and alone
        self._compiling, self._started = compiling, False
        self._sign = STOP_SIGN.get()
        self._since = time.monotonic()
        self._bar: Any = None
        self._context = ExitStack()

    def __enter__(self) -> Progress:
        self._presses = self._context.enter_context(deferred_interrupts(URGENT_PRESS))
        if self._show and self._compiling:
            tell("compiling the solver, once on this machine: some 30 s")
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._context.close()
        if self._bar is not None:
            self._bar.close()

    def call(self, integrate: Callable[..., Any], *arguments: Any) -> Any:
        """``integrate(*arguments, progress)``, where ctrl-C is answered while the solver is compiled, too.

        Raises
        ------
        KeyboardInterrupt
            After ctrl-C before the first update: nothing has been computed.
        """
        if not (self._compiling and self._presses.installed):
            return integrate(*arguments, self)
        call = call_in_background(
            lambda: integrate(*arguments, self), lambda: self._presses.count and not self._started
        )
        if not call.done():
            raise interruption("the compilation of the solver was left", None)
        return call.result()

    @property
    def stopped(self) -> bool:
        """Whether the user asked to stop, also where the run had just come to its end."""
        return self._presses.count > 0 or (self._sign is not None and self._sign.is_set())

    def update(self, t: float) -> bool:
        """Show that time `t` was reached; returns whether the run is to stop."""
        self._started = True
        if self.stopped:
            return True
        late = time.monotonic() - self._since > PROGRESS_DELAY
        if self._show and late and self._bar is None and t < self._t_end:
            self._bar = self._new_bar()
        if self._bar is not None:
            self._bar.update(t - self._bar.n)
        return False

    def _new_bar(self) -> Any:
        form = "{l_bar}{bar}| {n:.4g}/{total:.4g} s [{elapsed}<{remaining}]"
        return progress_bar(total=self._t_end, bar_format=form, desc="simulate", delay=0.0)
