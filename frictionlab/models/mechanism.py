"""The mechanism of a model as data, which animations, the live canvas and the explorer draw.

Lengths are in units of the picture.  A coordinate moves a point to the right or up; how far it moves for one
metre is chosen when it is drawn, so that the largest displacement is well visible.  What is drawn may depend
on parameters by arithmetic, comparisons, functions of numpy and `fl.functions`; an exported page draws it
too::

    @property
    def mechanism(self):
        mass = Point(0.0, 0.2, right="x")
        return Mechanism(Wall((-1.5, 0.0), (-1.5, 0.8)), Spring(Point(-1.5, 0.4), mass), Block(mass))
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from frictionlab.components import functions


@dataclass(frozen=True)
class Turn:
    """A motion around a place, by an angle as it is: `right` cos to the right of it and `up` sin above it.

    Parameters
    ----------
    angle : str
        Name of the coordinate; "-phi" turns the other way.
    right, up : float
        Radii.
    start : float
        What is added to the angle, rad: -pi/2 for a pendulum, whose angle is zero where it hangs.
    linear : bool
        Whether the equations are linear in the angle, as for small tilts: it is drawn as a slope.
    """

    angle: str
    right: float
    up: float
    start: float = 0.0
    linear: bool = False


@dataclass(frozen=True)
class Point:
    """A point: its position at zero coordinates, and the coordinates that move it.

    Parameters
    ----------
    x, y : float
    right, up : str
        Name of the coordinate, or of the parameter that is a length, by which the point moves to the right
        or up; "-y" moves it the other way, "" not at all.
    turn : Turn or None
        How it moves around (`x`, `y`), if it does.
    on : Belt or None
        The belt on whose surface it lies, if it does: `y` follows from where it is along it.
    """

    x: float
    y: float
    right: str = ""
    up: str = ""
    turn: Turn | None = None
    on: Belt | None = None

    def beside(self, x: float, y: float = 0.0) -> Point:
        """A point that moves with this one."""
        return replace(self, x=self.x + x, y=self.y + y)

    def level_at(self, x: float) -> Point:
        """A point that stays at `x`, as high as this one."""
        return replace(self, x=x, right="", turn=self.turn and replace(self.turn, right=0.0))

    def upright_at(self, y: float) -> Point:
        """A point that stays at the height `y`, above or below this one."""
        return replace(self, y=y, up="", turn=self.turn and replace(self.turn, up=0.0))


@dataclass(frozen=True)
class Wall:
    """A fixed line from one point to another; a ground, or a stop.

    Parameters
    ----------
    start, end : (float, float) or Point
    """

    start: Any
    end: Any


@dataclass(frozen=True)
class Spring:
    """A spring between two points.

    Parameters
    ----------
    start, end : Point
    loose : str
        Name of the mode in which its start is free, as that of a contact spring is in "separation".
    label : str
        What is written on its left, seen from its start: "$k_1$".
    """

    start: Point
    end: Point
    loose: str = ""
    label: str = ""


@dataclass(frozen=True)
class Block:
    """A body about its centre `at`, in the colour of the mode; a ball if `disc`, else a rectangle."""

    at: Point
    width: float = 0.6
    height: float = 0.4
    disc: bool = False


@dataclass(frozen=True)
class Belt:
    """A belt about two wheels of equal radius; `speed` names a parameter, "" is a belt at rest.

    Parameters
    ----------
    speed : str
    start, end : Point
        Centres of the wheels, the left one first; by default the surface is level, at the height zero.
    radius : float
    """

    speed: str = ""
    start: Point = Point(-1.1, -0.15)
    end: Point = Point(1.1, -0.15)
    radius: float = 0.15


def level_belt(speed: str, start: float, end: float) -> Belt:
    """A belt with its surface at the height zero, from one wheel to the other."""
    return Belt(speed, Point(start, -0.15), Point(end, -0.15))


@dataclass(frozen=True)
class Forces:
    """Arrows of the contact forces on a body at `at`: friction to the right, the normal force upwards.

    Parameters
    ----------
    at : Point
    contact : str
        Suffix of the outputs of this contact: "_1", "_2".
    """

    at: Point
    contact: str = ""


@dataclass(frozen=True)
class Load:
    """An arrow of a force that is a parameter: it presses down on `at`.

    Parameters
    ----------
    at : Point
    force : str
        Name of the parameter.
    """

    at: Point
    force: str


@dataclass(frozen=True, init=False)
class Mechanism:
    """The parts of a picture, drawn in their order."""

    parts: tuple[Any, ...]

    def __init__(self, *parts: Any) -> None:
        object.__setattr__(self, "parts", parts)


def held_block(
    coordinate: str, *, wall: float = -1.6, place: float = 0.0, number: str = ""
) -> tuple[Any, ...]:
    """A sliding block, the contact forces on it, and a spring between it and a wall."""
    block, side = Point(place, 0.2, right=coordinate), 0.3 if wall > place else -0.3
    held = Spring(Point(wall, 0.2), block.beside(side))
    return Wall((wall, -0.2), (wall, 0.6)), held, Block(block), Forces(block, number)


def disc_with_mark(angle: str, radius: float, x: float = 0.0, y: float = 0.0) -> tuple[Any, ...]:
    """A disc, and a mark on its rim that a coordinate turns."""
    mark = Point(x, y, turn=Turn(angle, radius, radius))
    return Block(Point(x, y), 2 * radius, 2 * radius, disc=True), Block(mark, 0.2, 0.2, disc=True)


def inclined_end(angle: Any) -> tuple[Any, Any]:
    """The fixed end of a spring that leads down to a body at this angle."""
    return -1.6 * functions.cos(angle), 1.6 * functions.sin(angle)


def body_on_belt(*springs: tuple[Any, Any], speed: str = "v") -> Mechanism:
    """A body on its contact spring on a belt; its coordinates are x along the belt and y into it.

    `springs` has for each further spring the place of its fixed end, relative to the body.
    """
    body = Point(0.0, 0.8, right="x", up="-y")
    held = [part for x, y in springs for part in _held(body, x, y)]
    contact = Spring(Point(0.0, 0.0, right="x"), body.beside(0.0, -0.2), loose="separation")
    return Mechanism(Belt(speed), contact, *held, Block(body), Forces(body))


def _held(body: Point, x: Any, y: Any) -> tuple[Any, ...]:
    across = 0.15 / (x * x + y * y) ** 0.5
    ends = ((body.x + x - s * y * across, body.y + y + s * x * across) for s in (1, -1))
    return Wall(*ends), Spring(Point(body.x + x, body.y + y), body)
