"""Components: one small class for each law, in arithmetic that floats and sympy symbols share.

`component` is the base of all, a frozen dataclass whose fields are parameters with unit, symbol and range.
`contact`, `friction` and `impact` hold the laws; the regimes of contact (`Interface`), the coordinates and
the directions of the contact forces (`Geometry`) are beside the contact laws.  `functions` are exp, tanh and
the like for laws.  Nothing here imports sympy; numpy is imported in functions only.
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
from .friction import (
    Coulomb,
    ExponentialDecay,
    FrictionLaw,
    PressureDependent,
    Stribeck,
    WeakeningStrengthening,
)
from .impact import FrictionalImpact, ImpactLaw, PlasticImpact, RestitutionImpact

__all__ = [
    "Component",
    "ContactLaw",
    "Coulomb",
    "CubicContact",
    "ExponentialDecay",
    "FixedLoad",
    "FrictionLaw",
    "FrictionalImpact",
    "Geometry",
    "HertzContact",
    "ImpactLaw",
    "Interface",
    "LinearContact",
    "MovingLoad",
    "Parameter",
    "PlasticImpact",
    "PolynomialContact",
    "PressureDependent",
    "RestitutionImpact",
    "SlidingOnly",
    "SlidingSeparation",
    "StickSlip",
    "StickSlipSeparation",
    "Stribeck",
    "WeakeningStrengthening",
    "functions",
    "parameter",
]
