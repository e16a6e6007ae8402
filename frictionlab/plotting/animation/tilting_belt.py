"""Fig. 1 of the paper, the slider on the tilting belt: where its parts are in each frame; the parts and the
contact forces as matplotlib artists, drawn once, then moved from frame to frame.

A run is sampled at the times of the frames.  Displacements are magnified by one factor s; the belt's tilt
is shown as it is.  So the penetration in the picture is s times that of the run: s y2 - (s x1 - s x2) phi
- s y1.  The slider stands on its contact spring, whose foot is on the belt while there is contact; in flight
the spring has its natural length.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Polygon, Rectangle
from matplotlib.quiver import Quiver

from frictionlab.analysis.motion_scales import round_down_1_2_5
from frictionlab.plotting.appearance import (
    BLACK,
    BLUE,
    GREY,
    VERMILLION,
    background,
    font_size,
    ink,
    is_dark,
    legible,
    line_width,
    marker_size,
    pen,
)
from frictionlab.plotting.time_histories import Array, modes_at

from .parts import spring_outline

if TYPE_CHECKING:
    from frictionlab.hybrid.trajectory import Trajectory

SLIDER_COORDINATES = ("x1", "y1", "x2", "y2")
FORCE_OUTPUTS = ("normal_force", "friction_force")
REQUIRED_PARAMETERS = ("v", "F", "l1", "l2")

COLUMNS = ("slider_x", "slider_y", "foot_x", "foot_y", "belt_x", "belt_y", "slope", "travel")
MAX_DISPLACEMENT_SHARE = 0.4  # largest displacement drawn, as a share of the distance of the nearer wheel
MIN_WHEEL_SHARE = 0.25  # smallest distance of a wheel as drawn, as a share of the other's
DEFAULT_SIZE = 0.2  # m: drawn size of a belt whose wheels are at its centre
SPRING_WIDTH = 0.12  # of springs, as a share of the size
BELT_COLOUR, BELT_ON_DARK = "#F2F2F2", "#333333"
# Label of each spring, and its place relative to the spring's middle, as shares of the size.
SPRING_LABELS = {
    "k1": ("$k_1$", (0.0, -0.2)),
    "k2": (r"$k_2, k_{\mathrm{nl}}$", (0.3, 0.0)),
    "k3": ("$k_3$", (0.2, 0.14)),
    "k4": ("$k_4$", (0.08, 0.2)),
    "k5": ("$k_5$", (-0.2, 0.0)),
    "k6": ("$k_6$", (0.2, 0.0)),
}
BELT_MARKS = 16  # on the belt, so that its motion is seen
FORCE_COLOURS = (BLUE, VERMILLION, BLACK)  # F_N, F_T, F
MAX_ARROW_LENGTH = 0.9  # as a share of the mechanism's size


@dataclass(frozen=True, eq=False)
class Frames:
    """States and contact forces at K times, in SI units; each array is (K,).

    Parameters
    ----------
    t : time
    x1, y1, x2, y2, phi : coordinates; phi is zero where the belt does not rotate
    rate : x1'
    penetration : positive in contact, negative in flight
    normal_force, friction_force : on the slider
    mode : names of the modes
    """

    t: Array
    x1: Array
    y1: Array
    x2: Array
    y2: Array
    phi: Array
    rate: Array
    penetration: Array
    normal_force: Array
    friction_force: Array
    mode: np.ndarray


def sample_frames(run: Trajectory, t: Array) -> Frames:
    """The frames of a run of a slider on a belt at times `t` (K,)."""
    states = dict(zip(run.names, run(t).T, strict=True))
    states |= {name: run.output(name, t) for name in ("penetration", *FORCE_OUTPUTS)}
    states.setdefault("phi", np.zeros(len(t)))
    shown = {name: states[name] for name in (*SLIDER_COORDINATES, "phi", "penetration", *FORCE_OUTPUTS)}
    return Frames(t=t, rate=states["x1'"], mode=modes_at(run, t), **shown)


def parameters(run: Trajectory) -> dict[str, float]:
    """The run's parameters by name."""
    return {name: float(value) for name, value in run.automaton.values.items()}


def is_tilting_belt(run: Trajectory) -> bool:
    """Whether a run has all that the picture of the slider on the tilting belt shows."""
    has = {*run.names, *run.automaton.outputs, *parameters(run)}
    return has >= {*SLIDER_COORDINATES, "x1'", "penetration", *FORCE_OUTPUTS, *REQUIRED_PARAMETERS}


@dataclass(frozen=True, eq=False)
class BeltLayout:
    """Sizes of the picture, and where its moving parts are in each of K frames.

    Parameters
    ----------
    size : float
        Distance of the farther wheel from the belt's centre, m; the other sizes follow from it.
    wheels : (float, float)
        Distances of the wheels from the belt's centre as drawn, m.
    magnify : float
        Factor s of the displacements.
    spring : float
        Natural length of the contact spring as drawn, m.
    reach : float
        Room for displacements, m.
    rows : (K, 8) array
        The columns COLUMNS: bottom of the slider, foot of the contact spring, point of the belt's surface
        above its centre (all m), slope of the belt (its surface falls to the right for phi > 0), travel of
        the belt's surface (m).
    """

    size: float
    wheels: tuple[float, float]
    magnify: float
    spring: float
    reach: float
    rows: Array

    def row(self, frame: int) -> dict[str, float]:
        """Where the moving parts are in a frame, by the names of COLUMNS."""
        return {name: float(value) for name, value in zip(COLUMNS, self.rows[frame])}

    @property
    def radius(self) -> float:
        """Radius of the wheels, m."""
        return 0.2 * self.size

    @property
    def block(self) -> tuple[float, float]:
        """Width and height of the slider, m."""
        return 0.4 * self.size, 0.3 * self.size

    @property
    def walls(self) -> tuple[float, float, float]:
        """Left wall (x), right wall (x) and ground (y), m."""
        left = -(0.2 + 0.8) * self.size - self.reach
        right = self.wheels[1] + 0.7 * self.size + self.reach
        return left, right, -self.radius - 0.8 * self.size - self.reach

    @property
    def anchor(self) -> tuple[float, float]:
        """Fixed end of the spring k3, at 45 degrees above the slider's upper left corner at rest, m."""
        width, height = self.block
        out = 0.6 * self.size + self.reach
        return -width / 2 - out, self.spring + height + out

    @property
    def limits(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """The picture's edges in x and in y, m."""
        left, right, ground = self.walls
        margin = 0.15 * self.size
        left = min(left, self.anchor[0], -self.wheels[0] - self.radius - self.reach)
        return (left - margin, right + margin), (ground - margin, self.anchor[1] + 2 * margin)


def lay_out_belt(
    frames: Frames, *, v: float, l1: float, l2: float, magnify: float | None = None
) -> BeltLayout:
    """Where everything is drawn; ``magnify=None`` makes the largest displacement well visible.

    Parameters
    ----------
    frames : Frames
    v : float
        Speed of the belt, m/s.
    l1, l2 : float
        Distances of the wheels, m.
    magnify : float or None
    """
    size = max(l1, l2) or DEFAULT_SIZE
    wheels = (max(l1, MIN_WHEEL_SHARE * size), max(l2, MIN_WHEEL_SHARE * size))
    room = MAX_DISPLACEMENT_SHARE * min(wheels)
    largest = max(float(np.abs(x).max()) for x in (frames.x1, frames.y1, frames.x2, frames.y2))
    s = magnify if magnify is not None else round_down_1_2_5(room / largest) if largest > 0 else 1.0
    spring = max(0.6 * size, 1.3 * s * float(frames.penetration.max()))
    rows = _part_positions(frames, s, spring, s * v * (frames.t - frames.t[0]))
    return BeltLayout(size, wheels, s, spring, max(room, s * largest), rows)


def _part_positions(frames: Frames, s: float, spring: float, travel: Array) -> Array:
    x1, y1, x2, y2 = s * frames.x1, s * frames.y1, s * frames.x2, s * frames.y2
    surface = y2 - (x1 - x2) * frames.phi
    # The mode decides, not the sign of the penetration: a bilateral contact pulls where that is negative.
    foot = np.where(frames.mode == "separation", y1, surface)
    return np.column_stack([x1, y1 + spring, x1, foot, x2, y2, -frames.phi, travel])


def belt_colour(ax: Axes | None = None) -> str:
    """The colour of the belt's inside, in `ax` or on new axes."""
    return BELT_ON_DARK if is_dark(ax) else BELT_COLOUR


def belt_outline(distance: Array, wheels: tuple[float, float], radius: float) -> Array:
    """Points (2, P) of a belt at a distance (P,) along it, from its left upper end, clockwise.

    In the belt's own frame: the upper surface is at height zero, the wheels' centres are one radius below.
    """
    left, right = wheels
    straight, bend = left + right, np.pi * radius
    d = np.mod(distance, 2 * (straight + bend))
    first, second = (d - straight) / radius, (d - 2 * straight - bend) / radius
    top, bottom = d < straight, (d >= straight + bend) & (d < 2 * straight + bend)
    down = first < np.pi
    x = np.where(down, right + radius * np.sin(first), -left - radius * np.sin(second))
    y = np.where(down, radius * np.cos(first) - radius, -radius - radius * np.cos(second))
    x = np.where(top, d - left, np.where(bottom, right - (d - straight - bend), x))
    return np.array([x, np.where(top, 0.0, np.where(bottom, -2 * radius, y))])


def to_picture_frame(points: Array, x: float, y: float, slope: float) -> Array:
    """Points (2, P) of the belt's frame in the frame of the picture: rotated to a slope, moved to (x, y)."""
    c, s = np.array([1.0, slope]) / np.hypot(1.0, slope)
    return np.array([[c, -s], [s, c]]) @ points + np.array([[x], [y]])


def draw_mechanism(ax: Axes, layout: BeltLayout) -> dict[str, Any]:
    """Draw the mechanism; returns its moving artists by name, for `move_mechanism`.

    Parameters
    ----------
    ax : Axes
    layout : BeltLayout

    Returns
    -------
    dict of str to artist
        "slider", "belt", "wheel1", "wheel2", "marks", "foot", "k1" to "k6" and their names ("k1 name"), at
        their places in the first frame.
    """
    _draw_walls(ax, layout)
    thin, edge = pen(BLACK, 1.0, ax), ink(ax)
    artists: dict[str, Any] = {
        "belt": Polygon(
            np.zeros((1, 2)), facecolor=belt_colour(ax), edgecolor=edge, linewidth=line_width(1.8)
        )
    }
    for name in ("wheel1", "wheel2"):
        artists[name] = Circle((0.0, 0.0), 0.75 * layout.radius, facecolor=background(ax), edgecolor=GREY)
    outlined: dict[str, Any] = {"edgecolor": edge, "linewidth": line_width(1.2), "zorder": 3}
    artists["slider"] = Rectangle((0.0, 0.0), *layout.block, **outlined)
    artists |= {name: Line2D([], [], solid_joinstyle="round", **thin) for name in SPRING_LABELS}
    dots: dict[str, Any] = {"marker": "o", "markersize": marker_size(3.0), "linestyle": "none"}
    artists["marks"] = Line2D([], [], color=edge, **dots)
    foot: dict[str, Any] = {"marker": "_", "markersize": marker_size(9.0), "markeredgewidth": line_width(2.0)}
    artists["foot"] = Line2D([], [], color=edge, **foot)
    for artist in artists.values():
        ax.add_patch(artist) if not isinstance(artist, Line2D) else ax.add_line(artist)
    for name, (text, _) in SPRING_LABELS.items():
        artists[f"{name} name"] = ax.text(0, 0, text, ha="center", va="center", fontsize=font_size(10.0))
    x, y = layout.limits
    ax.set(xlim=x, ylim=y, aspect="equal", xticks=[], yticks=[])
    move_mechanism(artists, layout, 0)
    return artists


def move_mechanism(
    artists: dict[str, Any], layout: BeltLayout, frame: int, colour: str | None = None
) -> list[Artist]:
    """Put the artists of `draw_mechanism` where they are in a frame, the slider in the colour of its mode."""
    row = layout.row(frame)
    place = row["belt_x"], row["belt_y"], row["slope"]
    loop = 2 * (sum(layout.wheels) + np.pi * layout.radius)
    belt = {"wheels": layout.wheels, "radius": layout.radius}
    artists["belt"].set_xy(to_picture_frame(belt_outline(np.linspace(0, loop, 200), **belt), *place).T)
    marks = row["travel"] + loop * np.arange(BELT_MARKS) / BELT_MARKS
    artists["marks"].set_data(*to_picture_frame(belt_outline(marks, **belt), *place))
    for name, centre in zip(("wheel1", "wheel2"), wheel_centres(layout, row)):
        artists[name].center = centre
    artists["slider"].set_xy((row["slider_x"] - layout.block[0] / 2, row["slider_y"]))
    artists["foot"].set_data([row["foot_x"]], [row["foot_y"]])
    if colour is not None:
        artists["slider"].set_facecolor(colour)
    for name, (start, end) in spring_ends(layout, row).items():
        artists[name].set_data(*spring_outline(start, end, SPRING_WIDTH * layout.size))
        aside = layout.size * np.array(SPRING_LABELS[name][1])
        artists[f"{name} name"].set_position((np.array(start) + np.array(end)) / 2 + aside)
    return list(artists.values())


def wheel_centres(layout: BeltLayout, row: dict[str, float]) -> list[tuple[float, float]]:
    """Centres of the two wheels."""
    (left, right), r = layout.wheels, layout.radius
    points = to_picture_frame(
        np.array([[-left, right], [-r, -r]]), row["belt_x"], row["belt_y"], row["slope"]
    )
    return [(float(x), float(y)) for x, y in points.T]


def spring_ends(layout: BeltLayout, row: dict[str, float]) -> dict[str, tuple[Any, Any]]:
    """Both ends of every spring: those to walls and ground stay horizontal or vertical, as in Eq. (1)."""
    (width, height), (left, right, ground) = layout.block, layout.walls
    x, y = row["slider_x"], row["slider_y"]
    middle, (first, second) = y + height / 2, wheel_centres(layout, row)
    return {
        "k1": ((left, middle), (x - width / 2, middle)),
        "k2": ((row["foot_x"], row["foot_y"]), (x, y)),
        "k3": (layout.anchor, (x - width / 2, y + height)),
        "k4": (second, (right, second[1])),
        "k5": ((first[0], ground), first),
        "k6": ((second[0], ground), second),
    }


def _draw_walls(ax: Axes, layout: BeltLayout) -> None:
    """Draw the fixed parts: two walls, the ground, the anchor of k3."""
    (left, right, ground), (x, y) = layout.walls, layout.anchor
    span = layout.reach + 0.25 * layout.size
    middle = layout.spring + layout.block[1] / 2
    across = 0.12 * layout.size
    edges = layout.limits[0][0] * 0.9, layout.wheels[1] + layout.reach + layout.radius
    thick: dict[str, Any] = {"solid_capstyle": "butt", "zorder": 0, **pen(GREY, 4.0, ax)}
    ax.plot([left, left], [middle - span, min(middle + span, y - 2 * across)], **thick)
    ax.plot([right, right], [-layout.radius - span, -layout.radius + span], **thick)
    ax.plot(edges, [ground, ground], **thick)
    ax.plot([x - across, x + across], [y - across, y + across], **thick)


def force_scale(layout: BeltLayout, frames: Frames, preload: float) -> float:
    """N per m of the picture: the largest force is MAX_ARROW_LENGTH times the mechanism's size long."""
    forces = np.abs([frames.normal_force, frames.friction_force]).max()
    return max(float(forces), abs(preload)) / (MAX_ARROW_LENGTH * layout.size) or 1.0


def draw_force_arrows(ax: Axes, scale: float) -> Quiver:
    """The arrows of normal force, friction force and preload, which `move_force_arrows` places.

    Parameters
    ----------
    ax : Axes
    scale : float
        N per m of the picture.
    """
    options: dict[str, Any] = {"angles": "xy", "scale_units": "xy", "minlength": 0.0, "zorder": 5}
    width: dict[str, Any] = {"units": "dots", "width": 4.0, "edgecolor": background(ax), "linewidth": 0.7}
    colours, zeros = [legible(colour, ax) for colour in FORCE_COLOURS], [[0.0] * 3] * 4
    return ax.quiver(*zeros, color=colours, scale=scale, **width, **options)


def move_force_arrows(arrows: Quiver, layout: BeltLayout, frames: Frames, preload: float, frame: int) -> None:
    """Put the arrows in a frame: contact forces start at the slider's centre, the preload ends on its top."""
    row = layout.row(frame)
    width, height = layout.block
    x, y = row["slider_x"], row["slider_y"]
    normal, friction = frames.normal_force[frame], frames.friction_force[frame]
    top = y + height + preload / float(arrows.scale or 1.0)
    arrows.set_offsets([(x, y + height / 2), (x, y + height / 2), (x + 0.35 * width, top)])
    # A force of zero has no arrow at all, rather than one of length zero.
    absent = np.array([normal, friction, preload]) == 0.0
    arrows.set_UVC(*(np.ma.array(x, mask=absent) for x in ([0.0, friction, 0.0], [normal, 0.0, -preload])))


def force_legend_handles(frames: Frames, preload: float) -> list[Line2D]:
    """Legend entries of the arrows, with the largest size that each has in the frames."""
    sizes = np.abs(frames.normal_force).max(), np.abs(frames.friction_force).max()
    texts = [f"{name}, up to {size:.0f} N" for name, size in zip(("$F_N$", "$F_T$"), sizes)]
    texts.append(f"$F$ = {preload:.4g} N")
    return [Line2D([], [], label=text, **pen(c, 3.0)) for c, text in zip(FORCE_COLOURS, texts)]
