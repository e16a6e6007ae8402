"""Explorers for the classroom: sliders made from the parameters' own metadata, and a picture that follows."""

from __future__ import annotations

from .bifurcation import explore_bifurcation
from .drawing import Curve, Drawing
from .explorer import Explorer, explore
from .stability import explore_stability

__all__ = ["Curve", "Drawing", "Explorer", "explore", "explore_bifurcation", "explore_stability"]
