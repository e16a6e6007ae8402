"""Claims of the paper and what became of them, as a table."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from html import escape

HEAD = (
    "claim",
    "where",
    "the paper says",
    "computed, exact solver",
    "with the full gap rate",
    "by the paper's algorithm",
    "verdict",
    "why",
)


class Verdict(StrEnum):
    """What a check found."""

    REPRODUCED = "reproduced"
    IN_PART = "reproduced in part"  # for some of the values that the claim speaks of; the note says which
    BY_PAPER = "only by the paper's algorithm"  # at its step, which the column says; not by the exact solver
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
        What the model gives, by the exact solver where time is stepped, and with Eq. (13) as printed.
    verdict : Verdict
    note : str
        What else the reader should know; may be empty.
    full_gap_rate : str
        What the exact solver gives with the gap's full rate in the impact law, where that can differ.
    paper_algorithm : str
        What the paper's algorithm gives, and its step, where time is stepped.
    """

    id: str
    where: str
    says: str
    computed: str
    verdict: Verdict
    note: str = ""
    full_gap_rate: str = ""
    paper_algorithm: str = ""

    def __str__(self) -> str:
        lines = [f"{self.id} ({self.where}): {self.verdict}", f"  paper:    {self.says}"]
        lines += [f"  computed: {self.computed}"]
        lines += [f"  full gap rate: {self.full_gap_rate}"] * bool(self.full_gap_rate)
        lines += [f"  paper's algorithm: {self.paper_algorithm}"] * bool(self.paper_algorithm)
        return "\n".join(lines + [f"  note:     {self.note}"] * bool(self.note))

    @property
    def cells(self) -> tuple[str, ...]:
        """A row of the table, in the order of its head."""
        found = self.computed, self.full_gap_rate, self.paper_algorithm
        return (self.id, self.where, self.says, *found, str(self.verdict), self.note)


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
        from frictionlab.analysis.markdown import markdown

        lines = (" | ".join(cell.replace("|", r"\|") for cell in row.cells) for row in self.rows)
        return markdown(" | ".join(HEAD), lines)

    def _repr_html_(self) -> str:
        lines = (_html("td", row.cells) for row in self.rows)
        return f"<table>{_html('th', HEAD)}{''.join(lines)}</table>"


def verdict(*held: bool) -> Verdict:
    """From whether each part of a claim holds."""
    if all(held):
        return Verdict.REPRODUCED
    return Verdict.IN_PART if any(held) else Verdict.NOT_REPRODUCED


def _html(tag: str, cells: tuple[str, ...]) -> str:
    return f"<tr>{''.join(f'<{tag}>{escape(cell)}</{tag}>' for cell in cells)}</tr>"
