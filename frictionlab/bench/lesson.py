"""docs/exact-and-fast.md, written by `frictionlab bench -o docs`: three pictures for students."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from frictionlab.hybrid.taylor import Taylor

from . import lesson_pictures, missed
from .harness import Row
from .lesson_text import TEXT
from .switches import Switches

PAGE, IMAGES = "exact-and-fast.md", "images"
COST, MISSED, BARS = "error-against-cost.png", "missed-event.png", "cost-of-switches.png"


def write(folder: Path, rows: Sequence[Row], switched: Sequence[Switches]) -> Path:
    """Write the page and its pictures, from the rows of scene B and of the switches."""
    images = folder / IMAGES
    images.mkdir(parents=True, exist_ok=True)
    found = missed.missed()
    pictures = {
        COST: lesson_pictures.cost(rows),
        MISSED: lesson_pictures.events(found),
        BARS: lesson_pictures.bars(switched),
    }
    for name, picture in pictures.items():
        picture.savefig(images / name, dpi=110)
    (folder / PAGE).write_text(_text(rows, found), encoding="utf-8")
    return folder / PAGE


def _text(rows: Sequence[Row], found: missed.Missed) -> str:
    hop = np.abs(missed.NEAR - 0.5 * found.hop) < 0.5 * found.hop
    return TEXT.format(
        cost=COST,
        missed=MISSED,
        bars=BARS,
        events=next(row.events for row in rows if row.scene == lesson_pictures.SCENE),
        low=Taylor(tol=1e-6).degree,
        high=Taylor().degree,
        height=1e6 * found.courses[-1].height[hop].max(),
        hop=1e3 * found.hop,
        table=missed.table(found),
    )
