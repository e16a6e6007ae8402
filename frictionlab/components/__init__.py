"""Components: one small class for each law, in arithmetic that floats and sympy symbols share.

`component` is the base of all, a frozen dataclass whose fields are parameters with unit, symbol and range.
`contact`, `friction` and `impact` hold the laws, `dynamic_friction` those of friction with states of their
own.  `contact` also has the regimes of contact (`Interface`), and the coordinates and directions of the
contact forces (`Geometry`).  `functions` has exp, tanh and the like for laws, also
those in pieces.  Nothing here imports sympy;
numpy is imported only inside functions.
"""

from __future__ import annotations

from . import functions
from .component import Component, Parameter, parameter
from .contact import (
    ContactLaw,
    CubicContact,
    FixedLoad,
    Geometry,
    HertzContact,
    Interface,
    LinearContact,
    MovingLoad,
    PolynomialContact,
    SlidingOnly,
    SlidingSeparation,
    StickSlip,
    StickSlipSeparation,
)
from .dynamic_friction import Dahl, Iwan, Jenkins, LuGre, RateAndState, RateAndStateSlip
from .friction import (
    Coulomb,
    ExponentialDecay,
    FrictionCurve,
    FrictionLaw,
    HyperbolicDecay,
    PressureDependent,
    Stribeck,
    WeakeningStrengthening,
)
from .functions import ramp, table
from .impact import FrictionalImpact, ImpactLaw, PlasticImpact, RestitutionImpact

__all__ = [
    "Component",
    "ContactLaw",
    "Coulomb",
    "CubicContact",
    "Dahl",
    "ExponentialDecay",
    "FixedLoad",
    "FrictionCurve",
    "FrictionLaw",
    "FrictionalImpact",
    "Geometry",
    "HertzContact",
    "HyperbolicDecay",
    "ImpactLaw",
    "Interface",
    "Iwan",
    "Jenkins",
    "LinearContact",
    "LuGre",
    "MovingLoad",
    "Parameter",
    "PlasticImpact",
    "PolynomialContact",
    "PressureDependent",
    "RateAndState",
    "RateAndStateSlip",
    "RestitutionImpact",
    "SlidingOnly",
    "SlidingSeparation",
    "StickSlip",
    "StickSlipSeparation",
    "Stribeck",
    "WeakeningStrengthening",
    "functions",
    "parameter",
    "ramp",
    "table",
]
