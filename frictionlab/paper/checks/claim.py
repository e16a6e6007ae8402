"""Claims of the paper, their verdicts as a table, and one claim computed in three ways.

These are the exact solver with either impact law, and the paper's algorithm; the exact solver decides.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import StrEnum
from html import escape
from typing import NamedTuple

from frictionlab.paper.scenes import PAPER_STEP, Setting

TABLE_HEAD = (
    "claim",
    "where",
    "the paper says",
    "computed, exact solver",
    "with the full gap rate",
    "by the paper's algorithm",
    "verdict",
    "why",
)

EXACT_SOLVER, FULL_GAP_RATE, PAPER_ALGORITHM = (
    ("exact", "paper"),
    ("exact", "full gap rate"),
    ("paper", "paper"),
)
REASON_FOR_DIFFERENCE = (
    "With GN the slider leaves again right after an impact by Eq. (13) wherever the belt turns away from it: "
    "the flights pile up (E3), and what follows depends on how an algorithm treats them (E5)."
)


class Verdict(StrEnum):
    """The verdict of a check."""

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
        What the exact solver gives with the full gap rate in the impact law, where that can differ.
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
        from frictionlab.presentation import markdown_table

        lines = (" | ".join(cell.replace("|", r"\|") for cell in row.cells) for row in self.rows)
        return markdown_table(" | ".join(TABLE_HEAD), lines)

    def _repr_html_(self) -> str:
        lines = (_html_row("td", row.cells) for row in self.rows)
        return f"<table>{_html_row('th', TABLE_HEAD)}{''.join(lines)}</table>"


def verdict_of_parts(*held: bool) -> Verdict:
    """From whether each part of a claim holds."""
    if all(held):
        return Verdict.REPRODUCED
    return Verdict.IN_PART if any(held) else Verdict.NOT_REPRODUCED


def _html_row(tag: str, cells: tuple[str, ...]) -> str:
    return f"<tr>{''.join(f'<{tag}>{escape(cell)}</{tag}>' for cell in cells)}</tr>"


class Finding(NamedTuple):
    """The result of one way of computing a claim: a text, and whether each part of the claim holds."""

    text: str
    held: dict[str, bool]


class Question(NamedTuple):
    """A claim to be checked: where it stands, what it says, and what decides it.

    `impacts` is whether the impact law can make a difference: not without the moving load.
    """

    where: str
    says: str
    check: Callable[[Setting], Finding]
    impacts: bool = True


def compare(name: str, question: Question, setting: Setting) -> Claim:
    """Check a claim in all ways.

    Parameters
    ----------
    name : str
    question : Question
    setting : Setting
        Its grid, workers and so on are used; algorithm and impact law are varied.

    Returns
    -------
    Claim
    """
    check, impacts = question.check, question.impacts
    exact, paper = check(setting.with_solver(*EXACT_SOLVER)), check(setting.with_solver(*PAPER_ALGORITHM))
    full = check(setting.with_solver(*FULL_GAP_RATE)) if impacts else None
    why = [
        _failing_parts_text(way, each)
        for way, each in _findings_by_solver(exact, full, paper)
        if not all(each.held.values())
    ]
    if impacts and exact.held != paper.held:
        why.append(REASON_FOR_DIFFERENCE)
    return Claim(
        name,
        question.where,
        question.says,
        exact.text,
        verdict_by_solver(exact, paper),
        " ".join(why),
        full.text if full else "",
        f"step {PAPER_STEP:g} s: {paper.text}",
    )


def verdict_by_solver(exact: Finding, paper: Finding) -> Verdict:
    """The exact solver decides; where it denies what the paper's algorithm gives, the verdict says so."""
    if all(exact.held.values()):
        return Verdict.REPRODUCED
    if all(paper.held.values()):
        return Verdict.BY_PAPER
    if any(exact.held.values()):
        return Verdict.IN_PART
    return Verdict.NOT_REPRODUCED


def _findings_by_solver(exact: Finding, full: Finding | None, paper: Finding) -> list[tuple[str, Finding]]:
    ways = [("the exact solver", exact), ("the paper's algorithm", paper)]
    return ways if full is None else [ways[0], ("the full gap rate", full), ways[1]]


def _failing_parts_text(way: str, found: Finding) -> str:
    failing = [part for part, held in found.held.items() if not held]
    if len(failing) == len(found.held):
        return f"By {way} none of it holds."
    return f"By {way} this does not hold: {'; '.join(failing)}."
