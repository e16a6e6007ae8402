"""One claim by three ways of computing it: the exact solver with either impact law, the paper's algorithm."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from .claims import Claim, Verdict
from .setting import STEP, Setting

EXACT, FULL, PAPER = ("exact", "paper"), ("exact", "full gap rate"), ("paper", "paper")
WHY = (
    "With GN the slider leaves again right after an impact by Eq. (13) wherever the belt turns away from it: "
    "the flights pile up (E3), and what follows depends on how an algorithm treats them (E5)."
)


class Finding(NamedTuple):
    """What one way gives: numbers in words, and the parts of the claim with whether they hold."""

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
    exact, paper = check(setting.with_(*EXACT)), check(setting.with_(*PAPER))
    full = check(setting.with_(*FULL)) if impacts else None
    why = [_failing(way, each) for way, each in _ways(exact, full, paper) if not all(each.held.values())]
    if impacts and exact.held != paper.held:
        why.append(WHY)
    return Claim(
        name,
        question.where,
        question.says,
        exact.text,
        verdict_of(exact, paper),
        " ".join(why),
        full.text if full else "",
        f"step {STEP:g} s: {paper.text}",
    )


def verdict_of(exact: Finding, paper: Finding) -> Verdict:
    """The exact solver decides; where it denies what the paper's algorithm gives, the verdict says so."""
    if all(exact.held.values()):
        return Verdict.REPRODUCED
    if all(paper.held.values()):
        return Verdict.BY_PAPER
    if any(exact.held.values()):
        return Verdict.IN_PART
    return Verdict.NOT_REPRODUCED


def _ways(exact: Finding, full: Finding | None, paper: Finding) -> list[tuple[str, Finding]]:
    ways = [("the exact solver", exact), ("the paper's algorithm", paper)]
    return ways if full is None else [ways[0], ("the full gap rate", full), ways[1]]


def _failing(way: str, found: Finding) -> str:
    failing = [part for part, held in found.held.items() if not held]
    if len(failing) == len(found.held):
        return f"By {way} none of it holds."
    return f"By {way} this does not hold: {'; '.join(failing)}."
