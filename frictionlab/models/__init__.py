"""Models: compositions of parameters and components, from which hybrid automata are derived.

`model` has the base of all models, with one namespace of parameters and nonlinearities that can be switched
off (`composition`), copies with changes and JSON data for files (`serialisation`).  It also checks that
arguments are models or automata.

`automaton_of_model` derives a model once for its structure, on a copy whose parameters are sympy symbols
(`symbols`, which also has derivatives of long sums).  It then puts the numbers back, which gives the
`HybridAutomaton` that the solver runs.  What has been derived of a model of the library is cached on disk for
later processes (`serialisation`); its automaton needs no sympy for what runs ask of it.

`mechanical` derives automata from energies and contacts, `library` holds the nine models, and `mechanism` has
the parts of their pictures.  `equations` holds the equations of a mode, printed as text or LaTeX, and derives
them from an automaton's flow; `lagrange_equations` writes those of mechanical models with their contact
forces, and those of an impact, as the paper does.
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
