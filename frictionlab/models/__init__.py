"""Models: what a composition of components means as a hybrid automaton."""

from __future__ import annotations

from .model import Model
from .slider_on_belt import SliderOnBelt

__all__ = ["Model", "SliderOnBelt"]
