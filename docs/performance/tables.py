"""Tables in Markdown and their numbers."""

from collections.abc import Iterable


def three_digits(value: float) -> str:
    """A positive number rounded to three digits, without a power of ten where it is large: 0.0123, 12300."""
    return f"{float(f'{value:.3g}'):.0f}" if value >= 1e3 else f"{value:.3g}"


def markdown_table(head: str, lines: Iterable[str]) -> str:
    """A table in Markdown."""
    rule = "|".join("---" for _ in head.split("|"))
    return "\n".join([f"| {head} |", f"|{rule}|", *(f"| {line} |" for line in lines)])
