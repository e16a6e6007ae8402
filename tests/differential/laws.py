"""Friction laws as a user would write them: sums, products, powers and quotients of exp, tanh, sin and so on.

Their formulas stand a second time, as plain functions, in tests/reference/friction.py.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import frictionlab as fl
from frictionlab import functions as fn


def _speed(default: float) -> Any:
    return fl.parameter(default, unit="m/s", meaning="a speed", exclusive_minimum=0.0)


def _share(default: float) -> Any:
    return fl.parameter(default, meaning="a height or an exponent", minimum=0.0)


@dataclass(frozen=True, repr=False)
class Curve(fl.Coulomb):
    """Base: a coefficient mu(u) times the normal force, with a layer of the width v_s."""

    v_s: float = _speed(0.1)

    def mu(self, u: Any) -> Any:
        """Coefficient at a sliding speed."""
        raise NotImplementedError

    def kinetic(self, normal_force: Any, speed: Any) -> Any:
        return self.mu(speed) * normal_force


@dataclass(frozen=True, repr=False)
class Smooth(Curve):
    """mu_k tanh(u/v_s): no friction at rest, but a static limit."""

    def mu(self, u: Any) -> Any:
        return self.mu_k * fn.tanh(u / self.v_s)


@dataclass(frozen=True, repr=False)
class RiseAndFall(Curve):
    """A product of layers that both begin at rest: exp(-u/v_2) that falls, tanh(u/v_s) that rises."""

    v_2: float = _speed(0.2)

    def mu(self, u: Any) -> Any:
        return (self.mu_k + (self.mu_s - self.mu_k) * fn.exp(-u / self.v_2)) * fn.tanh(u / self.v_s)


@dataclass(frozen=True, repr=False)
class Bump(Curve):
    """A bell of the height h around the speed u_0."""

    u_0: float = _speed(0.3)
    h: float = _share(0.1)

    def mu(self, u: Any) -> Any:
        return self.mu_k + self.h * fn.exp(-(((u - self.u_0) / self.v_s) ** 2))


@dataclass(frozen=True, repr=False)
class Edge(Curve):
    """A fall at the speed u_0, by tanh."""

    u_0: float = _speed(0.3)

    def mu(self, u: Any) -> Any:
        return self.mu_k + (self.mu_s - self.mu_k) * (1 - fn.tanh((u - self.u_0) / self.v_s)) / 2


@dataclass(frozen=True, repr=False)
class TwoLayers(Curve):
    """A sum of two layers."""

    v_2: float = _speed(0.2)

    def mu(self, u: Any) -> Any:
        return (
            self.mu_k + (self.mu_s - self.mu_k) * (fn.exp(-u / self.v_s) + fn.exp(-((u / self.v_2) ** 2))) / 2
        )


@dataclass(frozen=True, repr=False)
class Product(Curve):
    """A product of two layers."""

    v_2: float = _speed(0.2)

    def mu(self, u: Any) -> Any:
        return self.mu_k + (self.mu_s - self.mu_k) * fn.exp(-((u / self.v_s) ** 2)) * (
            1 - fn.tanh(u / self.v_2) / 2
        )


@dataclass(frozen=True, repr=False)
class Quotient(Curve):
    """A fall like 1/u^2."""

    def mu(self, u: Any) -> Any:
        return self.mu_k + (self.mu_s - self.mu_k) / (1 + (u / self.v_s) ** 2)


@dataclass(frozen=True, repr=False)
class Power(Curve):
    """A fall like u^-n."""

    n: float = _share(0.5)

    def mu(self, u: Any) -> Any:
        return self.mu_k + (self.mu_s - self.mu_k) * (1 + u / self.v_s) ** (-self.n)


@dataclass(frozen=True, repr=False)
class Ripple(Curve):
    """A sine of the period 2 pi v_2 on a fall."""

    v_2: float = _speed(0.2)
    h: float = _share(0.1)

    def mu(self, u: Any) -> Any:
        return self.mu_k * (1 + self.h * fn.sin(u / self.v_2)) + (self.mu_s - self.mu_k) * fn.exp(
            -u / self.v_s
        )


@dataclass(frozen=True, repr=False)
class Logarithm(Curve):
    """A logarithm that fades."""

    h: float = _share(0.1)

    def mu(self, u: Any) -> Any:
        return self.mu_k + self.h * fn.log(1 + u / self.v_s) / (1 + u)


@dataclass(frozen=True, repr=False)
class Nested(Curve):
    """exp of tanh of a square, over cosh."""

    v_2: float = _speed(0.2)

    def mu(self, u: Any) -> Any:
        return self.mu_k + (self.mu_s - self.mu_k) * fn.exp(-3 * fn.tanh((u / self.v_s) ** 2)) / fn.cosh(
            u / self.v_2
        )


@dataclass(frozen=True, repr=False)
class Angle(Curve):
    """A fall by arctan."""

    def mu(self, u: Any) -> Any:
        return self.mu_s - 0.6 * (self.mu_s - self.mu_k) * fn.arctan(u / self.v_s)


OWN = {law.__name__: law for law in Curve.__subclasses__()}
