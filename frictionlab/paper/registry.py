"""Which figures and claims there are, and the modules that compute them, imported when asked; a figure as a
result, numbers first, the picture on demand.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from frictionlab.paper.checks.claim import Claim, Claims, compare
from frictionlab.paper.scenes import Setting


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
        The solver and the impact law, where it takes a choice of them.
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
        # what draws gives a RunFigure, which has it; matplotlib's own class does not
        return self.plot()._repr_png_()  # type: ignore[attr-defined]


# Number -> module and function of the number: linear stability, which no algorithm and no impact law changes.
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
# Claim -> module with `CHECKS`, name -> Question.
STEADY_CLAIMS = {
    **dict.fromkeys((f"C{i}" for i in range(9, 21)), "checks.bifurcations"),
    **dict.fromkeys((f"C{i}" for i in range(21, 26)), "checks.nonsmooth"),
}
EVERY_CLAIM = CLAIMS | STEADY_CLAIMS


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
    chosen = tuple(EVERY_CLAIM) if "all" in names else names or tuple(CLAIMS)
    folder = None if resume is None else Path(resume)
    setting = Setting(quick=quick, workers=workers, progress=progress, resume=folder)
    return Claims(tuple(check(name, setting) for name in chosen))


def check(name: str, setting: Setting) -> Claim:
    """One claim; the setting's algorithm and impact law are not used."""
    module = import_module(f"{__package__}.{EVERY_CLAIM[name]}")
    return module.CHECKS[name]() if name in CLAIMS else compare(name, module.CHECKS[name], setting)
