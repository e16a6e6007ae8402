"""Models: compositions of parameters and components, and what they mean as hybrid automata.

`model` is the base of all models, and tells models and automata from anything else: one namespace of
parameters and switches (`composition`), copies with changes, files (`serialisation`).
A model is derived once for its structure, on a copy whose parameters are sympy symbols, with derivatives of
long sums; the numbers are put back, which gives the `HybridAutomaton` that the solver runs (all in
`symbols`).  What has been derived of a model of the library is kept in a file for later processes
(`serialisation` too).
`mechanical` derives automata from energies and contacts, `library` holds the nine models.  `equations` holds
the equations of a mode, printed as text or LaTeX, and derives them from an automaton's flow;
`lagrange_equations` writes those of mechanical models with their contact forces, and those of an impact, as
the paper does.
"""

from __future__ import annotations

from .library.catalogue import ModelTable, list_models
from .library.dry_friction_oscillators import DenHartog, FreeCoulomb, MassOnBelt, TwoBlocks
from .library.impact_oscillators import BouncingBall, ImpactOscillator
from .library.sliders import ModeCoupling, SliderOnBelt, SliderOnRigidBelt
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
