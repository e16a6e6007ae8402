"""Models: compositions of parameters and components, and what they mean as hybrid automata.

`model` is the base of all models: one namespace of parameters (`parameter_namespace`), copies with changes,
files (`serialisation`, `structure_data`), switches (`nonlinearities`).  A model is derived once for its
structure, on a copy whose parameters are sympy symbols, with derivatives of long sums; the numbers are put
back, which gives the `HybridAutomaton` that the solver runs (all in `symbols`).
`mechanical` derives automata from energies and contacts, `library` holds the nine models, `description`
shows a model as equations.  `coercion` tells models and automata from anything else.
"""

from __future__ import annotations

from .library.bouncing_ball import BouncingBall
from .library.catalogue import ModelTable, list_models
from .library.den_hartog import DenHartog
from .library.free_coulomb import FreeCoulomb
from .library.impact_oscillator import ImpactOscillator
from .library.mass_on_belt import MassOnBelt
from .library.mode_coupling import ModeCoupling
from .library.slider_on_belt import SliderOnBelt
from .library.slider_on_rigid_belt import SliderOnRigidBelt
from .library.two_blocks import TwoBlocks
from .mechanical.mechanical_model import MechanicalModel
from .mechanical.mechanics import Friction, Mechanics, Stop, quadratic_form
from .mechanism import Mechanism
from .model import Model, with_signature

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
    "quadratic_form",
    "with_signature",
]
