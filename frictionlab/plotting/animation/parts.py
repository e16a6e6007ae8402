"""Any model's mechanism as a picture: where each of its parts is in every frame, and what draws them.

A part becomes a shape with a few numbers for each frame.  The same shapes and numbers are drawn by matplotlib
and by the live canvas in the browser.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Polygon

from frictionlab.analysis.motion_scales import round_down_1_2_5
from frictionlab.models.mechanism import Belt, Block, Forces, Mechanism, Point, Spring, Wall
from frictionlab.plotting.appearance import (
    BLACK,
    BLUE,
    GREY,
    VERMILLION,
    add_halo,
    background,
    ink,
    line_width,
    marker_size,
    pen,
)
from frictionlab.plotting.time_histories import Array, modes_at

if TYPE_CHECKING:
    from frictionlab.hybrid.trajectory import Trajectory

REACH = 0.5  # largest displacement drawn
LONGEST = 0.6  # longest arrow
MARGIN = 0.25
WIDTH = 0.16  # of springs
SPRING_TURNS = 6
MARKS = 8  # on a belt, so that its motion is seen
ROUND = 40  # corners of a disc
FORCES = {"normal_force": (BLUE, "F_N"), "friction_force": (VERMILLION, "F_T")}


@dataclass(frozen=True, eq=False)
class Shape:
    """What a part is drawn as.

    Parameters
    ----------
    kind : "wall", "spring", "block", "disc", "belt" or "arrow"
    rows : (K, numbers) array
        The numbers of a shape in each frame: both ends of a wall or spring; centre, width and height of a
        block or disc; ends, height and travel of a belt; foot and vector of an arrow.
    colour : str
    """

    kind: str
    rows: Array
    colour: str = BLACK


@dataclass(frozen=True, eq=False)
class Parts:
    """A mechanism in K frames.

    Parameters
    ----------
    t, x, rate : (K,) arrays
        Times, and the coordinate and its rate that the phase plane shows.
    mode : (K,) array
        Names of the modes.
    coordinate : str
    shapes : tuple of Shape
    magnify : float or None
        Factor of the displacements; None where no point is displaced.
    forces : mapping of str to float
        Largest size (N) of each force that is drawn, by its symbol.
    """

    t: Array
    x: Array
    rate: Array
    mode: np.ndarray
    coordinate: str
    shapes: tuple[Shape, ...]
    magnify: float | None
    forces: dict[str, float]

    @property
    def limits(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """The picture's edges in x and in y."""
        outlines = [outline(s.kind, s.rows[k]) for s in self.shapes for k in _extremes(s)]
        points = np.concatenate(outlines, axis=1)
        (x0, y0), (x1, y1) = np.nanmin(points, axis=1) - MARGIN, np.nanmax(points, axis=1) + MARGIN
        return (float(x0), float(x1)), (float(y0), float(y1))

    @property
    def note(self) -> str:
        """A note on the magnification, which angles of what turns do not have."""
        return "angles as they are" if self.magnify is None else f"displacements × {self.magnify:g}"

    def handles(self) -> list[Any]:
        """Legend entries of the forces."""
        colours = {letter: colour for colour, letter in FORCES.values()}
        return [
            Line2D([], [], label=f"${name}$, up to {size:.3g} N", **pen(colours[name], 3.0))
            for name, size in self.forces.items()
        ]

    def draw(self, ax: Axes) -> list[Any]:
        """The artists of all shapes, as they are in the first frame."""
        artists: list[Any] = []
        for place, shape in enumerate(self.shapes):
            artists += _artists(shape, 2.0 + place / len(self.shapes), ax)
        for artist in artists:
            ax.add_patch(artist) if isinstance(artist, Patch) else ax.add_line(artist)
        x, y = self.limits
        ax.set(xlim=x, ylim=y, aspect="equal", xticks=[], yticks=[])
        self.move(artists, 0, None)
        return artists

    def move(self, artists: list[Any], frame: int, colour: str | None) -> list[Artist]:
        """Put the artists where they are in a frame, the bodies in the colour of the mode."""
        left = iter(artists)
        for shape in self.shapes:
            artist: Any = next(left)
            points = outline(shape.kind, shape.rows[frame])
            if isinstance(artist, Polygon):
                artist.set_xy(points.T)
                if colour is not None:
                    artist.set_facecolor(colour)
            else:
                artist.set_data(*points)
            if shape.kind == "belt":
                next(left).set_data(*marks(shape.rows[frame]))
        return artists


def _extremes(shape: Shape) -> set[int]:
    """Frames in which a number of a shape is largest or smallest."""
    return {int(k) for k in (*shape.rows.argmin(axis=0), *shape.rows.argmax(axis=0))}


def spring_outline(start: tuple[float, float], end: tuple[float, float], width: float) -> Array:
    """A zigzag (2, 2 SPRING_TURNS + 4) from `start` to `end`, straight at both ends."""
    a, b = np.array(start, dtype=float), np.array(end, dtype=float)
    along = np.r_[0.0, np.linspace(0.2, 0.8, 2 * SPRING_TURNS + 2), 1.0]
    across = np.r_[0.0, 0.0, np.tile([1.0, -1.0], SPRING_TURNS), 0.0, 0.0]
    way = b - a
    normal = np.array([-way[1], way[0]]) / (float(np.hypot(way[0], way[1])) or 1.0)
    return a[:, None] + way[:, None] * along + normal[:, None] * (width / 2 * across)


def outline(kind: str, row: Array) -> Array:
    """Points (2, P) of a shape."""
    if kind in ("block", "disc"):
        x, y, width, height = row
        if kind == "block":
            return np.array([[-1, 1, 1, -1], [-1, -1, 1, 1]]) / 2 * [[width], [height]] + [[x], [y]]
        turn = 2 * np.pi * np.arange(ROUND) / ROUND
        return np.array([x + width / 2 * np.cos(turn), y + height / 2 * np.sin(turn)])
    if kind == "spring":
        return spring_outline((row[0], row[1]), (row[2], row[3]), WIDTH)
    if kind == "belt":
        return np.array([[row[0], row[1]], [row[2], row[2]]])
    if kind == "arrow":
        return _arrow(*row)
    return np.array([[row[0], row[2]], [row[1], row[3]]])


def marks(row: Array) -> Array:
    """Points (2, MARKS) on a belt that travel with its surface."""
    start, end, y, way = row
    places = start + np.mod(way + (end - start) * np.arange(MARKS) / MARKS, end - start)
    return np.array([places, np.full(MARKS, y)])


def _arrow(x: float, y: float, dx: float, dy: float) -> Array:
    """Points (2, P) of shaft and head; one point that is NaN for a force of zero, which has no arrow."""
    length = float(np.hypot(dx, dy))
    if not length:
        return np.full((2, 1), np.nan)
    head = min(0.12, length) / length
    back = np.array([x + dx * (1 - head), y + dy * (1 - head)])
    side = np.array([-dy, dx]) * head / 2
    tip = np.array([x + dx, y + dy])
    return np.array([[x, y], tip, back + side, tip, back - side]).T


def _artists(shape: Shape, order: float, ax: Axes) -> list[Any]:
    """The artists of a shape, at its place in the order of drawing; arrows are over all others."""
    if shape.kind in ("block", "disc"):
        edge: dict[str, Any] = {"edgecolor": ink(ax), "linewidth": line_width(1.2)}
        return [Polygon(np.zeros((1, 2)), facecolor=background(ax), zorder=order, **edge)]
    width = {"wall": 4.0, "belt": 3.0, "arrow": 3.0}.get(shape.kind, 1.0)
    order = 5.0 if shape.kind == "arrow" else order
    artists = [Line2D([], [], zorder=order, solid_joinstyle="round", **pen(shape.colour, width, ax))]
    if shape.kind == "arrow":  # it is drawn over a body
        add_halo(artists[0], ax)
    if shape.kind == "belt":
        marked: dict[str, Any] = {"marker": "o", "markersize": marker_size(4.0), "linestyle": "none"}
        artists.append(Line2D([], [], color=ink(ax), zorder=order, **marked))
    return artists


def parts(run: Trajectory, mechanism: Mechanism, t: Array, magnify: float | None = None) -> Parts:
    """The mechanism of a run at times `t` (K,); ``magnify=None`` makes the largest displacement well
    visible."""
    values = {name: np.full(len(t), float(value)) for name, value in run.automaton.values.items()}
    values |= dict(zip(run.names, run(t).T, strict=True))
    samples = SampledRun(run, t, values, modes_at(run, t))
    lengths = [values[name.lstrip("-")] for name in sorted(_names(mechanism))]
    largest = max((float(np.abs(value).max()) for value in lengths), default=0.0)
    s = magnify if magnify is not None else round_down_1_2_5(REACH / largest) if largest > 0 else 1.0
    contacts = [part.contact for part in mechanism.parts if isinstance(part, Forces)]
    forces = {(contact, name): run.output(name + contact, t) for contact in contacts for name in FORCES}
    top = max((float(np.abs(force).max()) for force in forces.values()), default=0.0)
    scale = LONGEST / top if top > 0 else 1.0
    shapes = [shape for part in mechanism.parts for shape in _shapes(part, samples, s, (forces, scale))]
    sizes: dict[str, float] = {}
    for (_, name), force in forces.items():
        letter = FORCES[name][1]
        sizes[letter] = max(sizes.get(letter, 0.0), float(np.abs(force).max()))
    first, factor = run.automaton.shown_state, s if lengths else None
    return Parts(t, values[first], values[first + "'"], samples.mode, first, tuple(shapes), factor, sizes)


@dataclass(frozen=True, eq=False)
class SampledRun:
    """Samples of a run at times `t`: states and parameters by name, and modes."""

    run: Trajectory
    t: Array
    values: dict[str, Array]
    mode: np.ndarray

    def at(self, point: Point | tuple[float, float], s: float) -> list[Array]:
        """x and y (K,) of a point."""
        point = point if isinstance(point, Point) else Point(*point)
        x, y = (base + self._moved(name, s) for base, name in ((point.x, point.right), (point.y, point.up)))
        if point.turn is None:
            return [x, y]
        angle = self.values[point.turn.angle] + point.turn.start
        return [x + point.turn.right * np.cos(angle), y + point.turn.up * np.sin(angle)]

    def _moved(self, name: str, s: float) -> Array:
        if not name:
            return np.zeros(len(self.t))
        return (-s if name.startswith("-") else s) * self.values[name.lstrip("-")]


def _shapes(part: Any, samples: SampledRun, s: float, forces: Any) -> list[Shape]:
    ones = np.ones(len(samples.t))
    if isinstance(part, Wall):
        return [Shape("wall", np.column_stack([*samples.at(part.start, s), *samples.at(part.end, s)]), GREY)]
    if isinstance(part, Spring):
        return [Shape("spring", _spring(part, samples, s))]
    if isinstance(part, Block):
        sizes = part.width * ones, part.height * ones
        return [Shape("disc" if part.disc else "block", np.column_stack([*samples.at(part.at, s), *sizes]))]
    if isinstance(part, Belt):
        way = s * samples.values[part.speed] * (samples.t - samples.t[0]) if part.speed else 0.0 * ones
        still = part.start * ones, part.end * ones, part.y * ones
        return [Shape("belt", np.column_stack([*still, way]), GREY)]
    return _pair(part, samples, s, forces)


def _pair(part: Forces, samples: SampledRun, s: float, forces: Any) -> list[Shape]:
    """The arrows of both contact forces."""
    sizes, scale = forces
    foot, nothing = samples.at(part.at, s), np.zeros(len(samples.t))
    vectors = {
        "normal_force": (nothing, scale * sizes[part.contact, "normal_force"]),
        "friction_force": (scale * sizes[part.contact, "friction_force"], nothing),
    }
    return [Shape("arrow", np.column_stack([*foot, *v]), FORCES[name][0]) for name, v in vectors.items()]


def _spring(part: Spring, samples: SampledRun, s: float) -> Array:
    start, end = samples.at(part.start, s), samples.at(part.end, s)
    if part.loose:
        hangs, rest = samples.mode == part.loose, (part.start.x - part.end.x, part.start.y - part.end.y)
        start = [np.where(hangs, x + dx, y) for x, dx, y in zip(end, rest, start, strict=True)]
    return np.column_stack([*start, *end])


def _names(mechanism: Mechanism) -> set[str]:
    """Names of the coordinates and parameters that move the points of a mechanism."""
    points = [p for part in mechanism.parts for p in vars(part).values() if isinstance(p, Point)]
    return {name for point in points for name in (point.right, point.up) if name}
