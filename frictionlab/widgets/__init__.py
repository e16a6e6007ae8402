"""Explorers for the classroom: sliders made from the parameters' own metadata, and a picture that follows."""

from __future__ import annotations

from .drawing import Curve, Drawing
from .explorer import Explorer, explore

__all__ = ["Curve", "Drawing", "Explorer", "explore"]
