"""Models: compositions of parameters and components, from which hybrid automata are derived.

``model``
    `Model`, the base of all: one namespace of parameters, copies with changes, an automaton; `model`, the
    decorator of such classes.
``composition``
    Parameters of a model and its components; nonlinearities that can be switched off.
``symbols``
    sympy symbols of states and parameters; derivatives of long sums.
``symbolic_laws``
    Copies of models whose parameters are symbols, from which automata are derived; whether a law has a value.
``automaton_of_model``
    Derives a model once for its structure, and puts the numbers back: the `HybridAutomaton` that the solver
    runs.
``serialisation``
    Models as JSON data for files.
``kept_structures``
    What has been derived of the library's models, cached on disk for later processes, which need no sympy for
    what runs ask of it.
``mechanical``
    From energies and contacts to an automaton.
``library``
    The classics, and the table of all models.
``zoo``
    The systems of the literature, loaded when they are asked for.
``mechanism``
    The parts of a model's picture, as data.
``equations``, ``lagrange_equations``
    The equations of a mode as text or LaTeX, from an automaton's flow; for mechanical models with their
    contact forces, and those of an impact, as the paper writes them.
"""

from __future__ import annotations

from .library.catalogue import ModelTable, list_models
from .library.dry_friction_oscillators import DenHartog, FreeCoulomb, MassOnBelt, TwoBlocks
from .library.impact_oscillators import BouncingBall, ImpactOscillator
from .library.sliders import ModeCoupling, SliderOnBelt, SliderOnRigidBelt
from .mechanical.mechanical_model import MechanicalModel, numbered
from .mechanical.mechanics import Contact, Friction, Mechanics, Stop, quadratic_form
from .mechanism import Mechanism
from .model import Model

__all__ = [
    "BouncingBall",
    "Contact",
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
    "numbered",
    "quadratic_form",
]
