"""The slider on the belt as matplotlib artists, which `move` takes from frame to frame."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Polygon, Rectangle

from .mechanism import Mechanism
from .palette import BLACK, GREY
from .shapes import around, spring, tilted
from .windows import Array

WIDTH = 0.12  # of springs, as a share of the size
PALE = "#F2F2F2"
# Name of each spring, and where it stands beside the spring's middle, as shares of the size.
SPRINGS = {
    "k1": ("$k_1$", (0.0, -0.2)),
    "k2": (r"$k_2, k_{\mathrm{nl}}$", (0.3, 0.0)),
    "k3": ("$k_3$", (0.2, 0.14)),
    "k4": ("$k_4$", (0.08, 0.2)),
    "k5": ("$k_5$", (-0.2, 0.0)),
    "k6": ("$k_6$", (0.2, 0.0)),
}
MARKS = 16  # on the belt, so that its motion is seen


def draw_mechanism(ax: Axes, mechanism: Mechanism) -> dict[str, Any]:
    """Draw the mechanism; returns its moving artists by name, of which `move` puts all in place.

    Parameters
    ----------
    ax : Axes
    mechanism : Mechanism

    Returns
    -------
    dict of str to artist
        "slider", "belt", "wheel1", "wheel2", "marks", "foot", "k1" to "k6" and their names ("k1 name"), at
        their places in the first frame.
    """
    _walls(ax, mechanism)
    thin: dict[str, Any] = {"color": BLACK, "linewidth": 1.0}
    artists: dict[str, Any] = {
        "belt": Polygon(np.zeros((1, 2)), facecolor=PALE, edgecolor=BLACK, linewidth=1.8)
    }
    for name in ("wheel1", "wheel2"):
        artists[name] = Circle((0.0, 0.0), 0.75 * mechanism.radius, facecolor="white", edgecolor=GREY)
    artists["slider"] = Rectangle((0.0, 0.0), *mechanism.block, edgecolor=BLACK, linewidth=1.2, zorder=3)
    artists |= {name: Line2D([], [], solid_joinstyle="round", **thin) for name in SPRINGS}
    artists["marks"] = Line2D([], [], color=BLACK, marker="o", markersize=3.0, linestyle="none")
    artists["foot"] = Line2D([], [], color=BLACK, marker="_", markersize=9.0, markeredgewidth=2.0)
    for artist in artists.values():
        ax.add_patch(artist) if not isinstance(artist, Line2D) else ax.add_line(artist)
    for name, (text, _) in SPRINGS.items():
        artists[f"{name} name"] = ax.text(0, 0, text, ha="center", va="center", fontsize=10.0)
    x, y = mechanism.limits
    ax.set(xlim=x, ylim=y, aspect="equal", xticks=[], yticks=[])
    move(artists, mechanism, 0)
    return artists


def move(
    artists: dict[str, Any], mechanism: Mechanism, frame: int, colour: str | None = None
) -> list[Artist]:
    """Put the artists of `draw_mechanism` where they are in a frame, the slider in the colour of its mode."""
    row = mechanism.row(frame)
    place = row["belt_x"], row["belt_y"], row["slope"]
    loop = 2 * (sum(mechanism.wheels) + np.pi * mechanism.radius)
    belt = {"wheels": mechanism.wheels, "radius": mechanism.radius}
    artists["belt"].set_xy(tilted(around(np.linspace(0, loop, 200), **belt), *place).T)
    marks = row["travel"] + loop * np.arange(MARKS) / MARKS
    artists["marks"].set_data(*tilted(around(marks, **belt), *place))
    for name, centre in zip(("wheel1", "wheel2"), hubs(mechanism, row)):
        artists[name].center = centre
    artists["slider"].set_xy((row["slider_x"] - mechanism.block[0] / 2, row["slider_y"]))
    artists["foot"].set_data([row["foot_x"]], [row["foot_y"]])
    if colour is not None:
        artists["slider"].set_facecolor(colour)
    for name, (start, end) in ends(mechanism, row).items():
        artists[name].set_data(*spring(start, end, WIDTH * mechanism.size))
        aside = mechanism.size * np.array(SPRINGS[name][1])
        artists[f"{name} name"].set_position((np.array(start) + np.array(end)) / 2 + aside)
    return list(artists.values())


def outlines(mechanism: Mechanism, frame: int) -> list[Array]:
    """Lines (2, P) of the moving parts in a frame: belt, springs, slider, and the foot's way to the belt."""
    row, (width, height) = mechanism.row(frame), mechanism.block
    loop = 2 * (sum(mechanism.wheels) + np.pi * mechanism.radius)
    belt = around(np.linspace(0, loop, 200), mechanism.wheels, mechanism.radius)
    springs = [spring(*both, WIDTH * mechanism.size) for both in ends(mechanism, row).values()]
    corners = np.array([[-0.5, 0.5, 0.5, -0.5, -0.5], [0.0, 0.0, 1.0, 1.0, 0.0]]) * [[width], [height]]
    slider = corners + np.array([[row["slider_x"]], [row["slider_y"]]])
    return [tilted(belt, row["belt_x"], row["belt_y"], row["slope"]), *springs, slider]


def hubs(mechanism: Mechanism, row: dict[str, float]) -> list[tuple[float, float]]:
    """Centres of the two wheels."""
    (left, right), r = mechanism.wheels, mechanism.radius
    points = tilted(np.array([[-left, right], [-r, -r]]), row["belt_x"], row["belt_y"], row["slope"])
    return [(float(x), float(y)) for x, y in points.T]


def ends(mechanism: Mechanism, row: dict[str, float]) -> dict[str, tuple[Any, Any]]:
    """Both ends of every spring: those to the walls stay horizontal and vertical, as Eq. (1) takes them."""
    (width, height), (left, right, ground) = mechanism.block, mechanism.walls
    x, y = row["slider_x"], row["slider_y"]
    middle, (first, second) = y + height / 2, hubs(mechanism, row)
    return {
        "k1": ((left, middle), (x - width / 2, middle)),
        "k2": ((row["foot_x"], row["foot_y"]), (x, y)),
        "k3": (mechanism.anchor, (x - width / 2, y + height)),
        "k4": (second, (right, second[1])),
        "k5": ((first[0], ground), first),
        "k6": ((second[0], ground), second),
    }


def _walls(ax: Axes, mechanism: Mechanism) -> None:
    """The fixed parts: two walls, the ground, the point that holds k3."""
    (left, right, ground), (x, y) = mechanism.walls, mechanism.anchor
    span = mechanism.reach + 0.25 * mechanism.size
    middle = mechanism.spring + mechanism.block[1] / 2
    across = 0.12 * mechanism.size
    edges = mechanism.limits[0][0] * 0.9, mechanism.wheels[1] + mechanism.reach + mechanism.radius
    thick: dict[str, Any] = {"color": GREY, "linewidth": 4.0, "solid_capstyle": "butt", "zorder": 0}
    ax.plot([left, left], [middle - span, min(middle + span, y - 2 * across)], **thick)
    ax.plot([right, right], [-mechanism.radius - span, -mechanism.radius + span], **thick)
    ax.plot(edges, [ground, ground], **thick)
    ax.plot([x - across, x + across], [y - across, y + across], **thick)
