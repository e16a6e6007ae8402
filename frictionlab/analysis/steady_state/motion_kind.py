"""`MotionKind`: the kinds of motion that a steady state can be."""

from enum import StrEnum


class MotionKind(StrEnum):
    """Kind of a steady state; each member equals its text, as ``MotionKind.PERIODIC == "periodic"``."""

    EQUILIBRIUM = "equilibrium"
    PERIODIC = "periodic"
    NON_PERIODIC = "non-periodic"
    NOT_SETTLED = "not settled yet"  # the transient was too short to tell
    ENDED_EARLY = "ended early"  # the run did not reach its end

    def __repr__(self) -> str:
        """That of the text, as results show it."""
        return repr(self.value)
