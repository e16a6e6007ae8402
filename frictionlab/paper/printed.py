"""Numbers as the paper prints them: text, so that their last digit is known."""

from __future__ import annotations

from collections.abc import Iterable

SAME = 1 + 1e-9  # a value that lies exactly between two roundings agrees with both


def agrees(value: float, printed: str) -> bool:
    """Whether a value rounds to the number printed."""
    return abs(value - float(printed)) <= half_unit(printed) * SAME


def half_unit(printed: str) -> float:
    """Half a unit of the last digit."""
    return 0.5 * 10.0 ** -len(printed.partition(".")[2])


def listed(values: Iterable[float], digits: int) -> str:
    """Numbers in brackets, as the paper prints a state."""
    return f"[{', '.join(f'{value:.{digits}f}' for value in values)}]"
