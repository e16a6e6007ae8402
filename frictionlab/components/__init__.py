"""Components: one small class for each law, in arithmetic that floats and sympy symbols share."""

from __future__ import annotations

from .component import Component
from .contact import ContactLaw, CubicContact, LinearContact
from .friction import Coulomb, FrictionLaw
from .geometry import FixedLoad, Geometry, MovingLoad
from .impact import ImpactLaw, PlasticImpact, RestitutionImpact
from .interface import Interface, SlidingOnly, SlidingSeparation, StickSlip, StickSlipSeparation
from .parameter import Parameter, parameter

__all__ = [
    "Component",
    "ContactLaw",
    "Coulomb",
    "CubicContact",
    "FixedLoad",
    "FrictionLaw",
    "Geometry",
    "ImpactLaw",
    "Interface",
    "LinearContact",
    "MovingLoad",
    "Parameter",
    "PlasticImpact",
    "RestitutionImpact",
    "SlidingOnly",
    "SlidingSeparation",
    "StickSlip",
    "StickSlipSeparation",
    "parameter",
]
