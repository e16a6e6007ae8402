"""Ctrl-C, treated in one way everywhere: a computation stops, keeps what it has for
`partial_result`, and raises KeyboardInterrupt.

A press is counted, not raised where it happens to arrive (`deferred_interrupts`), so that no step and no line
of a file is half done.  What compiles for seconds runs in a thread of its own (`call_in_background`), so that
a press is answered meanwhile.  A computation in a thread of a sweep looks at the `STOP_SIGN` of that sweep.
"""

from __future__ import annotations

import atexit
import ctypes
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Future, wait
from contextlib import contextmanager
from contextvars import ContextVar, copy_context
from typing import Any

POLL_TIME = 0.1  # seconds between two looks at ctrl-C while something else computes

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
        previous = signal.getsignal(signal.SIGINT)
    presses.installed = callable(previous)
    if presses.installed:
        signal.signal(signal.SIGINT, presses.note)
    try:
        yield presses
    finally:
        if presses.installed:
            signal.signal(signal.SIGINT, previous)


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
