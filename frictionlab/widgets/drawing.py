"""What a panel shows, as data: a panel is a function that takes a result and returns a `Drawing`.

It makes no artists, so that it says nothing of how a picture is kept up to date, and the same curves can be
checked in a test or stay behind in grey::

    def gap(result):
        t = result.times()
        return Drawing("time (s)", "gap (m)", {"gap": Curve(t, result.run.output("gap", t))})

    fl.explore(panels=("response", gap))
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple


class Curve(NamedTuple):
    """A line of a panel.

    Parameters
    ----------
    x, y : array_like (N,)
        NaN breaks the line.
    style : mapping
        Keywords of matplotlib's Line2D; those that a curve had first are kept.
    axis : "left", "right" or "strip"
        Whose y it is; of a strip 0 is the foot of the panel and 1 its top.
    """

    x: Any
    y: Any
    style: Mapping[str, Any] = {}
    axis: Literal["left", "right", "strip"] = "left"


@dataclass(frozen=True)
class Drawing:
    """A panel's content.

    Parameters
    ----------
    xlabel, ylabel : str
        With units.
    curves : mapping of str to Curve
        By the label in the legend; one that begins with an underscore is not listed there.
    right : str
        Label of the axis on the right, for the curves that belong to it.
    yscale : "linear" or "log"
    note : str
        A few words in the corner, without mathematics; they may change with every step of a slider.
    xlim, ylim : (float, float) or None
        None follows the curves.
    progress : (int, int) or None
        How much is done, and of how much, where the panel wants to be asked again until all is.
    """

    xlabel: str
    ylabel: str
    curves: Mapping[str, Curve] = field(default_factory=dict)
    right: str = ""
    yscale: Literal["linear", "log"] = "linear"
    note: str = ""
    xlim: tuple[float, float] | None = None
    ylim: tuple[float, float] | None = None
    progress: tuple[int, int] | None = None
