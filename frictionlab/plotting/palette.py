"""Colours that colour-blind readers can tell apart (Okabe & Ito 2008), and the units of what is drawn."""

from __future__ import annotations

from collections.abc import Sequence
from types import MappingProxyType
from typing import Any

BLACK, ORANGE, SKY, GREEN = "#000000", "#E69F00", "#56B4E9", "#009E73"
BLUE, VERMILLION, PURPLE, GREY = "#0072B2", "#D55E00", "#CC79A7", "#999999"
YELLOW = "#F0E442"

LINES = (BLACK, VERMILLION, BLUE, GREEN)
DASHED = (0, (4, 1.5))

MODES = MappingProxyType(
    {
        "stick": ORANGE,
        "slip+": GREY,
        "slip": GREY,
        "slip-": PURPLE,
        "separation": SKY,
        "chatter": YELLOW,
    },
)
ANGLES = {"phi": r"\varphi", "theta": r"\theta", "psi": r"\psi"}  # in LaTeX; all others are lengths


def is_angle(name: str) -> bool:
    """Whether a coordinate, or its rate, is an angle by its name: phi, theta, psi, phi1, phi2 ..."""
    return name.rstrip("'").rstrip("0123456789") in ANGLES


def beside(names: Sequence[str]) -> tuple[str, ...]:
    """The angles among coordinates that have an axis of their own: where there are lengths as well."""
    angles = tuple(filter(is_angle, names))
    return () if len(angles) == len(names) else angles


def left_label(names: Sequence[str]) -> str:
    """What the axis on the left shows."""
    return "displacement (m)" if beside(names) or not any(map(is_angle, names)) else "angle (rad)"


def mode_colours(names: Sequence[str]) -> dict[str, str]:
    """A colour for every mode: its own, or for modes of other automata one of the palette in turn."""
    spare = (GREY, SKY, ORANGE, PURPLE, YELLOW, GREEN, BLUE, VERMILLION, BLACK)
    return {name: MODES.get(name, spare[i % len(spare)]) for i, name in enumerate(names)}


def line_style(index: int, name: str) -> dict[str, Any]:
    """Colour and dashes of a coordinate's line: angles are dashed, as they have a unit of their own."""
    colour = LINES[index % len(LINES)]
    dashed = is_angle(name) or index >= len(LINES)
    return {"color": colour, "linestyle": DASHED if dashed else "-", "linewidth": 1.2}


def label(name: str) -> str:
    """The name as a reader expects it in a legend or at an axis: subscripts, dots, Greek letters."""
    base = name.rstrip("'")
    stem = base.rstrip("0123456789")
    index = base[len(stem) :]
    letter = ANGLES.get(stem, stem)
    letter = rf"\dot{{{letter}}}" if name.endswith("'") else letter
    return f"${letter}_{{{index}}}$" if index else f"${letter}$"


def unit(name: str) -> str:
    """SI unit of a coordinate or of its rate."""
    length = "rad" if is_angle(name) else "m"
    return f"{length}/s" if name.endswith("'") else length
