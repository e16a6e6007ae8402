"""Figures and claims of the paper as results, and the modules that compute them, imported when needed.

A figure has its numbers, and draws the picture on demand; claims are a table with verdicts.  A claim is
computed in three ways: by the exact solver with either impact law, and by the paper's algorithm; the exact
solver with the law as printed decides.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from enum import StrEnum
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

from matplotlib.figure import Figure

from frictionlab.paper.scenes import PAPER_STEP, Setting
from frictionlab.presentation import html_rows

WAYS = "computed, exact solver", "with the full gap rate", "by the paper's algorithm"
TABLE_HEAD = "claim", "where", "the paper says", *WAYS, "verdict", "why"

EXACT_SOLVER, PAPER_ALGORITHM = ("exact", "paper"), ("paper", "paper")  # algorithm, impact law
FULL_GAP_RATE = "exact", "full gap rate"
REASON_FOR_DIFFERENCE = (
    "With GN the slider leaves again right after an impact by Eq. (13) wherever the belt turns away from it: "
    "the flights pile up (E3), and what follows depends on how an algorithm treats them (E5)."
)

# Number -> module and function of the number: linear stability, on which algorithm and law have no effect.
FIGURES = {
    2: "figures.linear_stability:coalescence_figure",
    3: "figures.linear_stability:coalescence_figure",
    4: "figures.linear_stability:critical_figure",
    5: "figures.linear_stability:critical_figure",
    6: "figures.linear_stability:two_pairs_figure",
}
# Number -> module and function of the number and the setting: steady states.
STEADY = {
    **dict.fromkeys((7, 8), "figures.bifurcations:motion_figure"),
    **dict.fromkeys(range(9, 15), "figures.bifurcations:friction_figure"),
    15: "figures.bifurcations:preload_figure",
    **dict.fromkeys((16, 17), "figures.stiff_structure:nonsmooth_figure"),
    18: "figures.stiff_structure:frequency_figure",
}
EVERY_FIGURE = FIGURES | STEADY
WITHOUT_GEOMETRY = (13, 14)  # where both impact laws are the same
# Claim -> module with `CHECKS`, name -> function that gives the Claim.
CLAIMS: dict[str, str] = {f"C{i}": "checks.linear_stability" for i in range(1, 9)}
# Claim -> module with `CHECKS`, name -> ClaimCheck.
STEADY_CLAIMS = {
    **dict.fromkeys((f"C{i}" for i in range(9, 21)), "checks.bifurcations"),
    **dict.fromkeys((f"C{i}" for i in range(21, 26)), "checks.nonsmooth"),
}
EVERY_CLAIM = CLAIMS | STEADY_CLAIMS


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
        texts = self.computed, self.full_gap_rate, self.paper_algorithm
        return (self.id, self.where, self.says, *texts, str(self.verdict), self.note)


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

    def _repr_html_(self) -> str:
        return html_rows(TABLE_HEAD, (row.cells for row in self.rows))


def verdict_of_parts(*held: bool) -> Verdict:
    """From whether each part of a claim holds."""
    if all(held):
        return Verdict.REPRODUCED
    return Verdict.IN_PART if any(held) else Verdict.NOT_REPRODUCED


class Finding(NamedTuple):
    """The result of one way of computing a claim: a text, and whether each part of the claim holds."""

    text: str
    held: dict[str, bool]


class ClaimCheck(NamedTuple):
    """A claim to be checked: where it stands, what it says, and what decides it.

    `impacts` tells whether the impact law can make a difference: not without the moving load or impacts.
    """

    where: str
    says: str
    check: Callable[[Setting], Finding]
    impacts: bool = True


def compare(name: str, claim: ClaimCheck, setting: Setting) -> Claim:
    """Check a claim in all ways.

    Parameters
    ----------
    name : str
    claim : ClaimCheck
    setting : Setting
        Its grid, workers and so on are used; algorithm and impact law are varied.

    Returns
    -------
    Claim
    """
    check, impacts = claim.check, claim.impacts
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
        claim.where,
        claim.says,
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


def _failing_parts_text(way: str, finding: Finding) -> str:
    failing = [part for part, held in finding.held.items() if not held]
    if len(failing) == len(finding.held):
        return f"By {way} none of it holds."
    return f"By {way} this does not hold: {'; '.join(failing)}."


@dataclass(frozen=True, eq=False)
class PaperFigure:
    """A figure of the paper, computed; a notebook shows the picture, print() the summary.

    Parameters
    ----------
    number : int
    caption : str
    data : object
        The models, and what was computed from them.
    summary : tuple of str
        The numbers that matter, a line each.
    draw : callable
        Figure from this result.
    how : str
        The solver and the impact law, where there is a choice of them.
    """

    number: int
    caption: str
    data: Any = field(repr=False)
    summary: tuple[str, ...] = field(repr=False)
    draw: Callable[[PaperFigure], Figure] = field(repr=False)
    how: str = field(default="", repr=False)

    def plot(self) -> Figure:
        """Draw it into a new figure, which belongs to no window."""
        return self.draw(self)

    def heading(self, text: str) -> str:
        """A title for the picture: number, text and how it was computed."""
        return f"Fig. {self.number}: {text}" + (f"\n{self.how}" if self.how else "")

    def __str__(self) -> str:
        how = f" ({self.how})" if self.how else ""
        return "\n".join([f"Fig. {self.number}: {self.caption}{how}", *self.summary])

    def _repr_png_(self) -> bytes:
        # `draw` gives a RunFigure, which has this method; matplotlib's own class does not
        return self.plot()._repr_png_()  # type: ignore[attr-defined]


def figure(
    number: int,
    *,
    algorithm: str = "exact",
    impact: str = "paper",
    quick: bool = False,
    workers: int | None = None,
    progress: bool = True,
    resume: str | Path | None = None,
) -> PaperFigure:
    """Compute a figure of the paper.

    Figures 2 to 6 are of linear stability and take a second; 7 to 18 are of steady states and take up to
    some minutes, which the last four options are for.

    Parameters
    ----------
    number : int
        The paper's.
    algorithm : "exact" or "paper"
        The Taylor method, or ``fl.RK4(step=2e-4)``.  Figs 7 to 18.
    impact : "paper" or "full gap rate"
        Eq. (13) as printed, or with the full gap rate.  Figs 7 to 12 and 15 to 18: without the moving
        load (Figs 13, 14) both are the same.
    quick : bool
        A coarser grid of parameters.
    workers : int or None
        Threads; None takes one for each processor.
    progress : bool
    resume : path or None
        Folder in which sweeps are kept as they come, and from which they are continued.

    Returns
    -------
    PaperFigure
        With the numbers in ``.data`` and the picture from ``.plot()``.

    Raises
    ------
    ValueError
        For a figure that is not computed, and for an algorithm or impact law that makes no difference to it.

    Examples
    --------
    >>> import frictionlab as fl
    >>> fl.paper.figure(2).data.changes[1e7][0].value  # doctest: +ELLIPSIS
    1.14842...
    """
    check_figure(number, algorithm, impact)
    setting = Setting(algorithm, impact, quick, workers, progress, None if resume is None else Path(resume))
    if number in FIGURES:
        return _function(FIGURES[number])(number)
    return _function(STEADY[number])(number, setting)


def _function(place: str) -> Any:
    module, name = place.split(":")
    return getattr(import_module(f"{__package__}.{module}"), name)


def check_figure(number: int, algorithm: str, impact: str) -> None:
    """Refuse a number that no module computes, and options that make no difference."""
    if number not in list(EVERY_FIGURE):
        raise ValueError(f"the figure must be one of {', '.join(map(str, EVERY_FIGURE))}, got {number!r}")
    Setting(algorithm, impact)
    if number in FIGURES and algorithm != "exact":
        raise ValueError(f"algorithm must be 'exact', got {algorithm!r}: Fig. {number} needs no time steps")
    if number in (*FIGURES, *WITHOUT_GEOMETRY) and impact != "paper":
        why = "has no impacts" if number in FIGURES else "has no moving load, so both laws are the same"
        raise ValueError(f"impact must be 'paper', got {impact!r}: Fig. {number} {why}")


def claims(
    *names: str,
    quick: bool = False,
    workers: int | None = None,
    progress: bool = True,
    resume: str | Path | None = None,
) -> Claims:
    """Check claims of the paper.

    C1 to C8, on equilibria and linear stability, take seconds.  C9 to C25, on steady states, are each
    computed by the exact solver with both impact laws and by the paper's algorithm, and take minutes.

    Parameters
    ----------
    *names : str
        Such as "C5"; none checks C1 to C8, "all" checks all 25.
    quick, workers, progress, resume
        As :func:`figure`; for C9 to C25.

    Returns
    -------
    Claims
        A row for each, which prints as text and shows as a table in a notebook.

    Raises
    ------
    ValueError
        For an unknown name.

    Examples
    --------
    >>> import frictionlab as fl
    >>> fl.paper.claims("C8")["C8"].verdict.value
    'reproduced'
    """
    for name in names:
        if name not in EVERY_CLAIM and name != "all":
            raise ValueError(f"a claim must be one of {', '.join(EVERY_CLAIM)} or all, got {name!r}")
    selection = tuple(EVERY_CLAIM) if "all" in names else names or tuple(CLAIMS)
    folder = None if resume is None else Path(resume)
    setting = Setting(quick=quick, workers=workers, progress=progress, resume=folder)
    return Claims(tuple(check(name, setting) for name in selection))


def check(name: str, setting: Setting) -> Claim:
    """One claim; the setting's algorithm and impact law are not used."""
    module = import_module(f"{__package__}.{EVERY_CLAIM[name]}")
    return module.CHECKS[name]() if name in CLAIMS else compare(name, module.CHECKS[name], setting)
