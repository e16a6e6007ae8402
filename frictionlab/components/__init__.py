"""Components: one small class for each law, in arithmetic that floats and sympy symbols share."""

from __future__ import annotations

from . import functions
from .component import Component
from .contact import ContactLaw, CubicContact, LinearContact
from .contact_powers import HertzContact, PolynomialContact
from .friction import Coulomb, FrictionLaw
from .friction_curves import ExponentialDecay, PressureDependent, Stribeck, WeakeningStrengthening
from .geometry import FixedLoad, Geometry, MovingLoad
from .impact import ImpactLaw, PlasticImpact, RestitutionImpact
from .impact_friction import FrictionalImpact
from .interface import Interface, SlidingOnly, SlidingSeparation, StickSlip, StickSlipSeparation
from .parameter import Parameter, parameter

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
