"""Tables as Markdown."""

from __future__ import annotations

from collections.abc import Iterable


def markdown(head: str, lines: Iterable[str]) -> str:
    """A table."""
    rule = "|".join("---" for _ in head.split("|"))
    return "\n".join([f"| {head} |", f"|{rule}|", *(f"| {line} |" for line in lines)])
