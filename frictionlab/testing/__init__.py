"""Checks for laws and models, your own included.

>>> import frictionlab as fl
>>> fl.testing.check_law(fl.HertzContact())
>>> run = fl.testing.check_model(fl.SliderOnBelt(friction=fl.Stribeck()), t_end=0.1)
"""

from __future__ import annotations

from .checks import check_law, check_model

__all__ = ["check_law", "check_model"]
