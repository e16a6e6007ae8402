"""What a computation had computed when it was stopped."""

from __future__ import annotations

import threading
from typing import Any

_LAST: list[Any] = [None]  # the result of the last interruption


def keep_partial_result(result: Any) -> None:
    """Keep what there is of a computation that has stopped, for :func:`partial_result`."""
    if threading.current_thread() is threading.main_thread():
        _LAST[0] = result


def partial_result() -> Any:
    """What a computation had computed when ctrl-C stopped it, or when a task of a sweep failed.

    Returns
    -------
    Trajectory, BatchResult, Bifurcation, Sweep, ... or None
        What the function would have returned, as far as it had come: a run up to the time it had reached, a
        sweep with the values that were done.  For a function that cannot return part of its result, such as
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
