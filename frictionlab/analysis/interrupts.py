"""Ctrl-C that lets what has begun come to its end."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing import parent_process
from typing import Any


@contextmanager
def noted_interrupts() -> Iterator[Callable[[], bool]]:
    """Within it a first ctrl-C is only noted: the function given tells of it; a second one interrupts.

    In a thread other than the main one Python delivers no signals, so nothing is installed there.
    """
    noted: list[int] = []

    def note(number: int, frame: Any) -> None:
        if noted:
            raise KeyboardInterrupt
        noted.append(number)

    previous = signal.getsignal(signal.SIGINT)
    here = threading.current_thread() is threading.main_thread() and callable(previous)
    if here:
        signal.signal(signal.SIGINT, note)
    try:
        yield lambda: bool(noted)
    finally:
        if here:
            signal.signal(signal.SIGINT, previous)


def leave_interrupts_to_parent() -> None:
    """In a process of a pool: ctrl-C reaches all processes of a terminal, only the first has to heed it."""
    if parent_process() is not None and threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGINT, signal.SIG_IGN)
