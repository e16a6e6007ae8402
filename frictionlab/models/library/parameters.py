"""How the parameters of models are written, with units, symbols and ranges, and the keywords of the classics.

By these keywords type checkers and editors find a misspelt one.  They cannot follow how a model joins the
parameters of its laws to its own, so all are listed here; a test compares them with what the models take.
Parameters of a law of your own go to that law: ``MassOnBelt(friction=Mine(a=2))``.
"""

from __future__ import annotations

from math import pi
from typing import Any, TypedDict

from frictionlab.components.component import parameter
from frictionlab.components.contact import ContactLaw, Geometry, Interface
from frictionlab.components.friction import FrictionLaw
from frictionlab.components.impact import ImpactLaw

RANGE = 10.0  # a slider goes from a tenth of a positive parameter's default to ten times it


def positive(default: float, unit: str, symbol: str, meaning: str) -> Any:
    """A parameter above 0, such as a mass; its slider is logarithmic."""
    around = (default / RANGE, default * RANGE)
    return parameter(
        default, unit=unit, symbol=symbol, meaning=meaning, exclusive_minimum=0.0, range=around, log=True
    )


def not_negative(default: float, most: float, unit: str, symbol: str, meaning: str) -> Any:
    """A parameter of at least 0, such as a damper; its slider goes up to `most`."""
    return parameter(default, unit=unit, symbol=symbol, meaning=meaning, minimum=0.0, range=(0.0, most))


def of_either_sign(default: float, most: float, unit: str, symbol: str, meaning: str) -> Any:
    """A parameter of either sign, such as a speed; its slider goes from -`most` to `most`."""
    return parameter(default, unit=unit, symbol=symbol, meaning=meaning, range=(-most, most))


def stiffness_parameter(
    default: float = 1.0,
    symbol: str = "k",
    meaning: str = "stiffness of the spring",
    range: tuple[float, float] = (0.1, 100.0),
) -> Any:
    """A stiffness, N/m."""
    return parameter(default, unit="N/m", symbol=symbol, meaning=meaning, minimum=0.0, range=range, log=True)


def frequency_parameter(default: float) -> Any:
    """The angular frequency of a harmonic force, rad/s."""
    return parameter(
        default,
        unit="rad/s",
        symbol=r"\Omega",
        meaning="angular frequency of the force",
        exclusive_minimum=0.0,
        range=(0.1, 10.0),
    )


def natural_period(k: float, m: float) -> float:
    """2 pi sqrt(m/k), s; 2 pi without a spring."""
    return 2 * pi * ((m / k) ** 0.5 if k > 0 else 1.0)


class FrictionKeywords(TypedDict, total=False):
    """A friction law, and the parameters of the package's friction laws."""

    friction: FrictionLaw
    mu_k: float
    mu_s: float
    v_s: float
    mu_v: float
    n: float
    F_ref: float
    sigma_0: float
    sigma_1: float
    sigma_2: float
    k_t: float
    mu_0: float
    mu_1: float
    mu_2: float
    mu_3: float
    mu_4: float
    v_1: float
    v_2: float
    v_3: float
    v_4: float
    a: float
    b: float
    D_c: float
    v_0: float


class ImpactKeywords(TypedDict, total=False):
    """An impact law, and the parameters of the package's impact laws."""

    impact: ImpactLaw
    mu_i: float
    e: float


class ContactKeywords(TypedDict, total=False):
    """A contact law, and the parameters of the package's contact laws."""

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
    """Keywords of `DenHartog`."""

    m: float
    c: float
    k: float
    N: float
    F: float
    Omega: float
    interface: Interface


class FreeCoulombKeywords(FrictionKeywords, total=False):
    """Keywords of `FreeCoulomb`."""

    m: float
    k: float
    N: float
    x_0: float
    interface: Interface


class ImpactOscillatorKeywords(ImpactKeywords, total=False):
    """Keywords of `ImpactOscillator`."""

    m: float
    c: float
    k: float
    d: float
    F: float
    Omega: float
    interface: Interface


class MassOnBeltKeywords(FrictionKeywords, total=False):
    """Keywords of `MassOnBelt`."""

    m: float
    c: float
    k: float
    N: float
    v: float
    interface: Interface


class ModeCouplingKeywords(FrictionKeywords, total=False):
    """Keywords of `ModeCoupling`."""

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
    """Keywords of `SliderOnRigidBelt`."""

    m: float
    c: float
    k1: float
    k3: float
    a: float
    F: float
    v: float
    interface: Interface


class BouncingBallKeywords(ImpactKeywords, total=False):
    """Keywords of `BouncingBall`."""

    m: float
    g: float
    h: float
    interface: Interface


class SliderOnBeltKeywords(ContactKeywords, FrictionKeywords, ImpactKeywords, total=False):
    """Keywords of `SliderOnBelt`."""

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
    """Keywords of `TwoBlocks`."""

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
