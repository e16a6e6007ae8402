"""How a run ended, as sentences."""

from __future__ import annotations

from enum import Enum


class Status(Enum):
    """End of a run; the value says what happened and what can be done."""

    FINISHED = "finished: the end time was reached"
    NO_ADMISSIBLE_MODE = (
        "no admissible mode: after the last event no mode of the automaton could be entered; "
        "check the model's laws there, or the initial state"
    )
    STALLED = (
        "stalled: time no longer advances; the step or the dwell times fell below the resolution of time"
    )
    ACCUMULATED = "accumulation: events piled up in finite time; use accumulation='close' to pass such points"
    NOT_FINITE = "not finite: the state overflowed; the motion is unbounded, end the run earlier"
    STEP_CAP = "step cap: max_steps was reached before the end time; raise it to go on"
    EVENT_CAP = "event cap: max_events was reached before the end time; raise it to go on"
    INTERRUPTED = "interrupted: stopped by the user; what was computed is kept"
    RUNNING = "running"

    def __str__(self) -> str:
        return self.value

    @property
    def ok(self) -> bool:
        """Whether the end time was reached."""
        return self is Status.FINISHED
