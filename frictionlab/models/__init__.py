"""Models: what a composition of components means as a hybrid automaton."""

from __future__ import annotations

from .bouncing_ball import BouncingBall
from .catalogue import ModelTable, list_models
from .den_hartog import DenHartog
from .free_coulomb import FreeCoulomb
from .impact_oscillator import ImpactOscillator
from .mass_on_belt import MassOnBelt
from .mechanics import Friction, MechanicalModel, Mechanics, Stop
from .mechanism import Mechanism
from .mode_coupling import ModeCoupling
from .model import Model, with_signature
from .slider_on_belt import SliderOnBelt
from .slider_on_rigid_belt import SliderOnRigidBelt
from .two_blocks import TwoBlocks

__all__ = [
    "BouncingBall",
    "DenHartog",
    "FreeCoulomb",
    "Friction",
    "ImpactOscillator",
    "MassOnBelt",
    "MechanicalModel",
    "Mechanics",
    "Mechanism",
    "ModeCoupling",
    "Model",
    "ModelTable",
    "SliderOnBelt",
    "SliderOnRigidBelt",
    "Stop",
    "TwoBlocks",
    "list_models",
    "with_signature",
]
