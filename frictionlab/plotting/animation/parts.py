"""Any model's mechanism as a picture: where each of its parts is in every frame, and what draws them.

A part becomes a shape with a few numbers for each frame.  The same shapes and numbers are drawn by matplotlib
and by the live canvas in the browser.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import chain
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Polygon
from matplotlib.text import Text

from frictionlab.analysis.motion_scales import round_down_1_2_5
from frictionlab.models.mechanism import Belt, Block, Forces, Load, Mechanism, Point, Spring, Turn, Wall
from frictionlab.plotting.appearance import (
    BLACK,
    BLUE,
    GREY,
    VERMILLION,
    add_halo,
    background,
    font_size,
    ink,
    is_dark,
    line_width,
    marker_size,
    pen,
)
from frictionlab.plotting.labels import parameter_symbol
from frictionlab.plotting.time_histories import Array
from frictionlab.presentation import FORCE_SYMBOLS, is_rotational, output_unit

if TYPE_CHECKING:
    from frictionlab.hybrid.trajectory import Trajectory

REACH = 0.5  # largest displacement drawn
LONGEST = 0.6  # longest arrow
MARGIN = 0.25
WIDTH = 0.16  # of springs
SPRING_TURNS = 6
MARKS = 16  # on a belt, so that its motion is seen
FOOT = 0.1  # half the plate at the free end of a contact spring
HUB = 0.75  # radius of a wheel, as a share of the belt's around it
ASIDE, ABOVE = 0.13, 0.25  # of a spring's label from its middle: beside it, and above or below
ROUND = 40  # corners of a disc
BELT_COLOUR, BELT_ON_DARK = "#F2F2F2", "#333333"
FORCES = {"normal_force": BLUE, "friction_force": VERMILLION}
BODIES = "block", "disc"  # shapes in the colour of the mode


@dataclass(frozen=True, eq=False)
class Shape:
    """What a part is drawn as.

    Parameters
    ----------
    kind : "wall", "spring", "block", "disc", "belt" or "arrow"
    rows : (K, numbers) array
        The numbers of a shape in each frame: both ends of a wall or spring; centre, width and height of a
        block or disc; centres of a belt's wheels, their radius and the belt's travel; foot and vector of an
        arrow.
    colour : str
    label : str
        What is written beside a spring.
    """

    kind: str
    rows: Array
    colour: str = BLACK
    label: str = ""


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
    note : str
        On the magnification, which angles of what turns do not have.
    forces : mapping of str to str
        What the legend says of each contact force that is drawn, and its colour.
    loads : mapping of str to str
        The same of each parameter that is drawn as a force.
    """

    t: Array
    x: Array
    rate: Array
    mode: np.ndarray
    coordinate: str
    shapes: tuple[Shape, ...]
    note: str
    forces: dict[str, str]
    loads: dict[str, str]

    @property
    def limits(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """The picture's edges in x and in y."""
        outlines = [outlines_of(s.kind, s.rows[k])[0] for s in self.shapes for k in _extremes(s)]
        points = np.concatenate(outlines, axis=1)
        (x0, y0), (x1, y1) = np.nanmin(points, axis=1) - MARGIN, np.nanmax(points, axis=1) + MARGIN
        return (float(x0), float(x1)), (float(y0), float(y1))

    def handles(self, ax: Axes | None = None) -> list[Any]:
        """Legend entries of the forces."""
        return [
            Line2D([], [], label=text, **pen(colour, 3.0, ax))
            for text, colour in (self.forces | self.loads).items()
        ]

    def draw(self, ax: Axes) -> list[list[Any]]:
        """The artists of all shapes, as they are in the first frame."""
        shapes = enumerate(self.shapes)
        artists = [_artists(shape, 2.0 + place / len(self.shapes), ax) for place, shape in shapes]
        for artist in chain.from_iterable(artists):
            ax.add_artist(artist)
        x, y = self.limits
        ax.set(xlim=x, ylim=y, aspect="equal", xticks=[], yticks=[])
        self.move(artists, 0, None)
        return artists

    def move(self, artists: list[list[Any]], frame: int, colour: str | None) -> list[Artist]:
        """Put the artists where they are in a frame, the bodies in the colour of the mode."""
        for shape, own in zip(self.shapes, artists, strict=True):
            for artist, points in zip(own, outlines_of(shape.kind, shape.rows[frame])):
                _put(artist, points)
            if shape.kind in BODIES and colour is not None:
                own[0].set_facecolor(colour)
        return list(chain.from_iterable(artists))


def _put(artist: Any, points: Array) -> None:
    if isinstance(artist, Polygon):
        artist.set_xy(points.T)
    elif isinstance(artist, Text):
        artist.set_position((points[0, 0], points[1, 0]))
    else:
        artist.set_data(*points)


def _extremes(shape: Shape) -> set[int]:
    """Frames in which a number of a shape is largest or smallest."""
    return {int(k) for k in (*shape.rows.argmin(axis=0), *shape.rows.argmax(axis=0))}


def spring_outline(start: Any, end: Any, width: float) -> Array:
    """A zigzag (2, 2 SPRING_TURNS + 4) from `start` to `end`, straight at both ends."""
    a, b = np.array(start, dtype=float), np.array(end, dtype=float)
    along = np.r_[0.0, np.linspace(0.2, 0.8, 2 * SPRING_TURNS + 2), 1.0]
    across = np.r_[0.0, 0.0, np.tile([1.0, -1.0], SPRING_TURNS), 0.0, 0.0]
    return a[:, None] + (b - a)[:, None] * along + _left(a, b)[:, None] * (width / 2 * across)


def _left(a: Array, b: Array) -> Array:
    """The unit vector to the left of the way from one point to another."""
    way = b - a
    return np.array([-way[1], way[0]]) / (float(np.hypot(way[0], way[1])) or 1.0)


def outlines_of(kind: str, row: Array) -> list[Array]:
    """Points (2, P) of each artist of a shape, its outline first; a label has one."""
    if kind == "block":
        x, y, width, height = row
        return [np.array([[-1, 1, 1, -1], [-1, -1, 1, 1]]) / 2 * [[width], [height]] + [[x], [y]]]
    if kind == "disc":
        return [_ellipse(*row)]
    if kind == "spring":
        middle, left = (row[:2] + row[2:]) / 2, _left(row[:2], row[2:])
        away = ASIDE + (ABOVE - ASIDE) * abs(left[1])
        return [spring_outline(row[:2], row[2:], WIDTH), (middle + away * left)[:, None]]
    if kind == "belt":
        return _belt_outlines(row)
    if kind == "arrow":
        return [_arrow(*row)]
    return [np.array([[row[0], row[2]], [row[1], row[3]]])]


def _ellipse(x: float, y: float, width: float, height: float) -> Array:
    turn = 2 * np.pi * np.arange(ROUND) / ROUND
    return np.array([x + width / 2 * np.cos(turn), y + height / 2 * np.sin(turn)])


def _belt_outlines(row: Array) -> list[Array]:
    """The belt, both of its wheels, and MARKS points on it that travel with its surface."""
    start, end, radius, travel = row[:2], row[2:4], float(row[4]), float(row[5])
    left, length = _left(start, end), float(np.hypot(*(end - start)))
    frame = np.column_stack([[left[1], -left[0]], left])

    def placed(distance: Array) -> Array:
        return frame @ belt_outline(distance, length, radius) + start[:, None]

    loop = 2 * (length + np.pi * radius)
    wheels = [_ellipse(x, y, 2 * HUB * radius, 2 * HUB * radius) for x, y in (start, end)]
    marks = placed(travel + loop * np.arange(MARKS) / MARKS)
    return [placed(np.linspace(0.0, loop, 5 * ROUND)), *wheels, marks]


def belt_outline(distance: Array, length: float, radius: float) -> Array:
    """Points (2, P) of a belt at a distance (P,) along it, from its left upper end, clockwise.

    The wheels' centres are at (0, 0) and (`length`, 0).
    """
    bend = np.pi * radius
    d = np.mod(distance, 2 * (length + bend))
    first, second = (d - length) / radius, (d - 2 * length - bend) / radius
    top, bottom = d < length, (d >= length + bend) & (d < 2 * length + bend)
    down = first < np.pi
    x = np.where(down, length + radius * np.sin(first), -radius * np.sin(second))
    y = np.where(down, radius * np.cos(first), -radius * np.cos(second))
    x = np.where(top, d, np.where(bottom, 2 * length + bend - d, x))
    return np.array([x, np.where(top, radius, np.where(bottom, -radius, y))])


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
    if shape.kind in BODIES:
        return [_polygon(background(ax), ink(ax), 1.2, order)]
    if shape.kind == "belt":
        dots: dict[str, Any] = {"marker": "o", "markersize": marker_size(3.0), "linestyle": "none"}
        loop = _polygon(BELT_ON_DARK if is_dark(ax) else BELT_COLOUR, ink(ax), 1.8, order)
        wheels = [_polygon(background(ax), GREY, 1.0, order) for _ in range(2)]
        return [loop, *wheels, Line2D([], [], color=ink(ax), zorder=order, **dots)]
    width = {"wall": 4.0, "arrow": 3.0}.get(shape.kind, 1.0)
    order = 5.0 if shape.kind == "arrow" else order
    line = Line2D([], [], zorder=order, solid_joinstyle="round", **pen(shape.colour, width, ax))
    if shape.kind == "arrow":  # it is drawn over a body
        add_halo(line, ax)
    return [line, _label(shape, ax)] if shape.label else [line]


def _polygon(face: str, edge: str, width: float, order: float) -> Polygon:
    return Polygon(
        np.zeros((1, 2)), facecolor=face, edgecolor=edge, linewidth=line_width(width), zorder=order
    )


def _label(shape: Shape, ax: Axes) -> Text:
    row = shape.rows[0]
    across = _left(row[:2], row[2:])[0]
    align = "left" if across > 0.5 else "right" if across < -0.5 else "center"
    return Text(0, 0, shape.label, color=ink(ax), fontsize=font_size(10.0), ha=align, va="center")


def parts(run: Any, mechanism: Mechanism, t: Array, magnify: float | None = None) -> Parts:
    """The mechanism of a run at times `t` (K,); ``magnify=None`` makes the largest displacement well
    visible.

    An equilibrium can be drawn as a run that rests, by an object with what is asked of the run.
    """
    values = {name: np.full(len(t), float(value)) for name, value in run.automaton.values.items()}
    values |= dict(zip(run.names, run(t).T, strict=True))
    points = [p for part in mechanism.parts for p in vars(part).values() if isinstance(p, Point)]
    names = {name.lstrip("-") for point in points for name in (point.right, point.up) if name}
    largest = max((_size(values[name]) for name in names), default=0.0)
    s = magnify if magnify is not None else round_down_1_2_5(REACH / largest) if largest > 0 else 1.0
    forces = {
        name + part.contact: run.output(name + part.contact, t)
        for part in mechanism.parts
        if isinstance(part, Forces)
        for name in FORCES
    }
    loads = {part.force: values[part.force] for part in mechanism.parts if isinstance(part, Load)}
    top = max(map(_size, (forces | loads).values()), default=0.0)
    samples = SampledRun(run, t, values | forces, run.modes_at(t), s, LONGEST / top if top > 0 else 1.0)
    shapes = [shape for part in mechanism.parts for shape in _shapes(part, samples)]
    first, turns = run.automaton.shown_state, any(point.turn for point in points)
    notes = [f"displacements × {s:g}"] * bool(names) + ["angles × 1"] * (turns or not names)
    return Parts(
        t,
        values[first],
        values[first + "'"],
        samples.mode,
        first,
        tuple(shapes),
        ", ".join(notes),
        _legend(run, forces),
        {f"{parameter_symbol(run.source, name)} = {size[0]:.4g} N": BLACK for name, size in loads.items()},
    )


def _legend(run: Any, forces: dict[str, Array]) -> dict[str, str]:
    """What is said of each contact force, and its colour: one entry for all forces, one for all moments."""
    sizes: dict[tuple[str, str, str], float] = {}
    for kind, colour in FORCES.items():
        for name in (each for each in forces if each.startswith(kind)):
            letter = "M" if is_rotational(name, run.source) else "F"
            key = FORCE_SYMBOLS[kind].replace("F", letter), output_unit(name, run.source), colour
            sizes[key] = max(_size(forces[name]), sizes.get(key, 0.0))
    return {f"${symbol}$, up to {size:.4g} {unit}": colour for (symbol, unit, colour), size in sizes.items()}


def _size(values: Array) -> float:
    """The largest absolute value; NaN, as of a force that an equilibrium does not have, is left out."""
    return float(np.fmax.reduce(np.abs(values), initial=0.0))


@dataclass(frozen=True, eq=False)
class SampledRun:
    """Samples of a run at times `t`: states, parameters and forces by name, and modes.

    Displacements are magnified by the factor `magnify`, and a newton is an arrow of the length `scale`.
    """

    run: Trajectory
    t: Array
    values: dict[str, Array]
    mode: np.ndarray
    magnify: float
    scale: float

    def at(self, point: Point | tuple[float, float]) -> list[Array]:
        """x and y (K,) of a point."""
        point = point if isinstance(point, Point) else Point(*point)
        x, y = point.x + self._moved(point.right), point.y + self._moved(point.up)
        if point.on is not None:
            return [x, self._surface(point.on, x)]
        if point.turn is None:
            return [x, y]
        angle = self._angle(point.turn)
        return [x + point.turn.right * np.cos(angle), y + point.turn.up * np.sin(angle)]

    def _moved(self, name: str) -> Array:
        return self.magnify * self._signed(name) if name else np.zeros(len(self.t))

    def _signed(self, name: str) -> Array:
        return -self.values[name[1:]] if name.startswith("-") else self.values[name]

    def _angle(self, turn: Turn) -> Array:
        angle = self._signed(turn.angle)
        return (np.arctan(angle) if turn.linear else angle) + turn.start

    def _surface(self, belt: Belt, x: Array) -> Array:
        """Height of a belt's upper side, or of its prolongation, at x."""
        (x1, y1), (x2, y2) = self.at(belt.start), self.at(belt.end)
        slope = (y2 - y1) / (x2 - x1)
        return y1 + slope * (x - x1) + belt.radius * np.hypot(1.0, slope)


def _shapes(part: Any, samples: SampledRun) -> list[Shape]:
    ones, at = np.ones(len(samples.t)), samples.at
    if isinstance(part, Wall):
        return [Shape("wall", np.column_stack([*at(part.start), *at(part.end)]), GREY)]
    if isinstance(part, Spring):
        rows = _spring(part, samples)
        spring = Shape("spring", rows, label=part.label)
        return [spring, Shape("wall", _foot(rows))] if part.loose else [spring]
    if isinstance(part, Block):
        sizes = part.width * ones, part.height * ones
        return [Shape("disc" if part.disc else "block", np.column_stack([*at(part.at), *sizes]))]
    if isinstance(part, Belt):
        speed = samples.values[part.speed] if part.speed else 0.0 * ones
        way = samples.magnify * speed * (samples.t - samples.t[0])
        return [Shape("belt", np.column_stack([*at(part.start), *at(part.end), part.radius * ones, way]))]
    x, y = at(part.at)
    if isinstance(part, Load):
        length = samples.scale * samples.values[part.force]
        return [Shape("arrow", np.column_stack([x, y + length, 0.0 * ones, -length]))]
    normal, friction = (samples.scale * samples.values[name + part.contact] for name in FORCES)
    vectors = (0.0 * ones, normal), (friction, 0.0 * ones)
    return [
        Shape("arrow", np.column_stack([x, y, *vector]), colour)
        for vector, colour in zip(vectors, FORCES.values())
    ]


def _spring(part: Spring, samples: SampledRun) -> Array:
    start, end = samples.at(part.start), samples.at(part.end)
    if part.loose:
        hangs, rest = samples.mode == part.loose, (part.start.x - part.end.x, part.start.y - part.end.y)
        start = [np.where(hangs, x + dx, y) for x, dx, y in zip(end, rest, start, strict=True)]
    return np.column_stack([*start, *end])


def _foot(spring: Array) -> Array:
    """Both ends (K, 4) of the plate across the start of a contact spring."""
    start, way = spring[:, :2], spring[:, 2:] - spring[:, :2]
    length = np.hypot(way[:, 0], way[:, 1])
    across = np.column_stack([-way[:, 1], way[:, 0]]) * (FOOT / np.where(length > 0, length, 1.0))[:, None]
    return np.hstack([start - across, start + across])
