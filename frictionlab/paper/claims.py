"""Claims of the paper and what became of them, as a table."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import astuple, dataclass
from enum import StrEnum
from html import escape

HEAD = ("claim", "where", "the paper says", "computed", "verdict", "note")


class Verdict(StrEnum):
    """What a check found."""

    REPRODUCED = "reproduced"
    IN_PART = "reproduced in part"  # for some of the values that the claim speaks of; the note says which
    NOT_REPRODUCED = "not reproduced"


@dataclass(frozen=True)
class Claim:
    """One claim, checked.

    Parameters
    ----------
    id : str
    where : str
        Section or figure of the paper.
    says : str
        What the paper says.
    computed : str
        What the model gives.
    verdict : Verdict
    note : str
        What else the reader should know; may be empty.
    """

    id: str
    where: str
    says: str
    computed: str
    verdict: Verdict
    note: str = ""

    def __str__(self) -> str:
        lines = [f"{self.id} ({self.where}): {self.verdict}", f"  paper:    {self.says}"]
        lines += [f"  computed: {self.computed}"] + [f"  note:     {self.note}"] * bool(self.note)
        return "\n".join(lines)


@dataclass(frozen=True)
class Claims:
    """Checked claims, in order; ``claims["C5"]`` is one of them."""

    rows: tuple[Claim, ...]

    def __iter__(self) -> Iterator[Claim]:
        return iter(self.rows)

    def __len__(self) -> int:
        return len(self.rows)

    def __getitem__(self, name: str) -> Claim:
        for row in self.rows:
            if row.id == name:
                return row
        raise KeyError(f"no claim {name!r} among {', '.join(row.id for row in self.rows)}")

    def __str__(self) -> str:
        return "\n".join(map(str, self.rows))

    __repr__ = __str__

    def to_markdown(self) -> str:
        """The table as Markdown."""
        from frictionlab.analysis.benchmark import markdown  # which imports the solver

        lines = (" | ".join(cell.replace("|", r"\|") for cell in astuple(row)) for row in self.rows)
        return markdown(" | ".join(HEAD), lines)

    def _repr_html_(self) -> str:
        lines = (_html("td", astuple(row)) for row in self.rows)
        return f"<table>{_html('th', HEAD)}{''.join(lines)}</table>"


def verdict(*held: bool) -> Verdict:
    """From whether each part of a claim holds."""
    if all(held):
        return Verdict.REPRODUCED
    return Verdict.IN_PART if any(held) else Verdict.NOT_REPRODUCED


def _html(tag: str, cells: tuple[str, ...]) -> str:
    return f"<tr>{''.join(f'<{tag}>{escape(cell)}</{tag}>' for cell in cells)}</tr>"
