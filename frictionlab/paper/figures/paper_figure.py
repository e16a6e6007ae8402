"""A figure of the paper as a result: numbers first, the picture on demand."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from matplotlib.figure import Figure


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
