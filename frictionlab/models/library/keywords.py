"""Keywords of the models' constructors, for type checkers and editors: by these they see a misspelt one.

They cannot follow how a model joins the parameters of its laws to its own; a test compares what is here with
what the models take.  Parameters of a law of your own go to that law: ``MassOnBelt(friction=Mine(a=2))``.
"""

from __future__ import annotations

from typing import TypedDict

from frictionlab.components.contact import ContactLaw, Interface
from frictionlab.components.friction import FrictionLaw
from frictionlab.components.geometry import Geometry
from frictionlab.components.impact import ImpactLaw


class FrictionKeywords(TypedDict, total=False):
    """A friction law, and the parameters that one of the package may have."""

    friction: FrictionLaw
    mu_k: float
    mu_s: float
    v_s: float
    mu_v: float
    n: float
    F_ref: float


class ImpactKeywords(TypedDict, total=False):
    """An impact law, and the parameters that one of the package may have."""

    impact: ImpactLaw
    mu_i: float
    e: float


class ContactKeywords(TypedDict, total=False):
    """A contact law, and the parameters that one of the package may have."""

    contact: ContactLaw
    k2: float
    k_nl: float
    k_h: float
    a1: float
    a2: float
    a3: float
    a4: float
    a5: float


class DenHartogKeywords(FrictionKeywords, total=False):
    """Of `DenHartog`."""

    m: float
    c: float
    k: float
    N: float
    F: float
    Omega: float
    interface: Interface


class FreeCoulombKeywords(FrictionKeywords, total=False):
    """Of `FreeCoulomb`."""

    m: float
    k: float
    N: float
    x_0: float
    interface: Interface


class ImpactOscillatorKeywords(ImpactKeywords, total=False):
    """Of `ImpactOscillator`."""

    m: float
    c: float
    k: float
    d: float
    F: float
    Omega: float
    interface: Interface


class MassOnBeltKeywords(FrictionKeywords, total=False):
    """Of `MassOnBelt`."""

    m: float
    c: float
    k: float
    N: float
    v: float
    interface: Interface


class ModeCouplingKeywords(FrictionKeywords, total=False):
    """Of `ModeCoupling`."""

    m: float
    c: float
    k1: float
    k2: float
    k3: float
    a1: float
    a2: float
    F: float
    v: float
    interface: Interface


class SliderOnRigidBeltKeywords(ContactKeywords, FrictionKeywords, total=False):
    """Of `SliderOnRigidBelt`."""

    m: float
    c: float
    k1: float
    k3: float
    a: float
    F: float
    v: float
    interface: Interface


class BouncingBallKeywords(ImpactKeywords, total=False):
    """Of `BouncingBall`."""

    m: float
    g: float
    h: float
    interface: Interface


class SliderOnBeltKeywords(ContactKeywords, FrictionKeywords, ImpactKeywords, total=False):
    """Of `SliderOnBelt`."""

    M: float
    m: float
    J: float
    c1: float
    c2: float
    c4: float
    c5: float
    c6: float
    k1: float
    k3: float
    k4: float
    k5: float
    k6: float
    l1: float
    l2: float
    v: float
    F: float
    interface: Interface
    geometry: Geometry


class TwoBlocksKeywords(FrictionKeywords, total=False):
    """Of `TwoBlocks`."""

    m1: float
    m2: float
    c: float
    k1: float
    k2: float
    k12: float
    N1: float
    N2: float
    v: float
    interface: Interface
