"""Parameters that several models have: masses, springs, dampers, loads, angles, each with unit, symbol and
range.
"""

from __future__ import annotations

from math import pi
from typing import Any

from frictionlab.components.component import parameter


def mass_parameter(default: float = 1.0, symbol: str = "m", meaning: str = "mass") -> Any:
    """A mass, kg."""
    return parameter(
        default, unit="kg", symbol=symbol, meaning=meaning, exclusive_minimum=0.0, range=(0.1, 10.0), log=True
    )


def stiffness_parameter(
    default: float = 1.0,
    symbol: str = "k",
    meaning: str = "stiffness of the spring",
    range: tuple[float, float] = (0.1, 100.0),
) -> Any:
    """A stiffness, N/m."""
    return parameter(default, unit="N/m", symbol=symbol, meaning=meaning, minimum=0.0, range=range, log=True)


def damper_parameter(
    default: float = 0.0,
    symbol: str = "c",
    meaning: str = "damping",
    range: tuple[float, float] = (0.0, 2.0),
) -> Any:
    """A damper, N s/m."""
    return parameter(default, unit="N s/m", symbol=symbol, meaning=meaning, minimum=0.0, range=range)


def speed_parameter(default: float, symbol: str = "v") -> Any:
    """The speed of a belt, m/s."""
    return parameter(default, unit="m/s", symbol=symbol, meaning="speed of the belt", range=(-3.0, 3.0))


def normal_force_parameter(default: float = 1.0, symbol: str = "N", meaning: str = "normal force") -> Any:
    """A normal force that does not change, N."""
    return parameter(default, unit="N", symbol=symbol, meaning=meaning, minimum=0.0, range=(0.0, 10.0))


def load_parameter(default: float = 1.0) -> Any:
    """The amplitude of a harmonic force, N."""
    return parameter(
        default, unit="N", symbol="F", meaning="amplitude of the force", minimum=0.0, range=(0.0, 10.0)
    )


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


def angle_parameter(default: float, symbol: str, meaning: str) -> Any:
    """An angle, rad."""
    return parameter(default, unit="rad", symbol=symbol, meaning=meaning, range=(-pi, pi))


def natural_period(k: float, m: float) -> float:
    """2 pi sqrt(m/k), s; 2 pi without a spring."""
    return 2 * pi * ((m / k) ** 0.5 if k > 0 else 1.0)
