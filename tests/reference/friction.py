"""Friction laws as plain functions of numbers, written from their formulas; nothing comes from the package.

A law is a friction force F(N, u), a static limit S(N), and its layers: where in the sliding speed u, and over
which width, it bends.  Names are those of the classes that the tests give to the package.
"""

from collections.abc import Callable
from math import atan, cosh, exp, log, sin, tanh
from types import SimpleNamespace
from typing import Any, NamedTuple


class Law(NamedTuple):
    """Friction force while sliding, static limit, and (centre, width) of the layers."""

    kinetic: Callable[[float, float], float]
    static: Callable[[Any], Any]
    layers: tuple[tuple[float, float], ...]


def law(kind: str, p: SimpleNamespace) -> Law:
    """The law of that name with the parameters p."""
    if kind == "PressureDependent":
        return _pressed(p)
    mu, layers = CURVES[kind](p)
    return Law(lambda N, u: mu(u) * N, lambda N: p.mu_s * N, layers)


def _pressed(p: SimpleNamespace) -> Law:
    share = 1 - p.n

    def pressed(N: Any) -> Any:
        return p.F_ref**p.n * abs(N) ** share

    def kinetic(N: float, u: float) -> float:
        return (p.mu_k + (p.mu_s - p.mu_k) * _fall(u / p.v_s)) * pressed(N)

    return Law(kinetic, lambda N: p.mu_s * pressed(N), ((0.0, p.v_s),))


def _fall(x: float) -> float:
    """e^-x; a step that is tried and refused may look far before the layer."""
    return exp(-max(x, -50.0)) if x < 700 else 0.0


def _ahead(x: float) -> float:
    """1 + x, kept positive where a step looks beyond its event."""
    return max(1 + x, 0.1)


def _coulomb(p):
    return lambda u: p.mu_k, ()


def _exponential(p):
    return lambda u: p.mu_k + (p.mu_s - p.mu_k) * _fall(u / p.v_s), ((0.0, p.v_s),)


def _stribeck(p):
    return lambda u: p.mu_k + (p.mu_s - p.mu_k) * _fall((u / p.v_s) ** 2) + p.mu_v * u, ((0.0, p.v_s),)


def _strengthening(p):
    return (
        lambda u: p.mu_k + (p.mu_s - p.mu_k) * _fall(u / p.v_s) + p.mu_v * u / p.v_s,
        ((0.0, p.v_s),),
    )


def _smooth(p):
    return lambda u: p.mu_k * tanh(u / p.v_s), ((0.0, p.v_s),)


def _rise_and_fall(p):
    return (
        lambda u: (p.mu_k + (p.mu_s - p.mu_k) * _fall(u / p.v_2)) * tanh(u / p.v_s),
        ((0.0, p.v_s), (0.0, p.v_2)),
    )


def _bump(p):
    return lambda u: p.mu_k + p.h * _fall(((u - p.u_0) / p.v_s) ** 2), ((p.u_0, p.v_s),)


def _edge(p):
    return (
        lambda u: p.mu_k + (p.mu_s - p.mu_k) * (1 - tanh((u - p.u_0) / p.v_s)) / 2,
        ((p.u_0, p.v_s),),
    )


def _two_layers(p):
    half = (p.mu_s - p.mu_k) / 2
    return (
        lambda u: p.mu_k + half * _fall(u / p.v_s) + half * _fall((u / p.v_2) ** 2),
        ((0.0, p.v_s), (0.0, p.v_2)),
    )


def _product(p):
    return (
        lambda u: p.mu_k + (p.mu_s - p.mu_k) * _fall((u / p.v_s) ** 2) * (1 - tanh(u / p.v_2) / 2),
        ((0.0, p.v_s), (0.0, p.v_2)),
    )


def _quotient(p):
    return lambda u: p.mu_k + (p.mu_s - p.mu_k) / (1 + (u / p.v_s) ** 2), ((0.0, p.v_s),)


def _power(p):
    return lambda u: p.mu_k + (p.mu_s - p.mu_k) * _ahead(u / p.v_s) ** (-p.n), ((0.0, p.v_s),)


def _ripple(p):
    return (
        lambda u: p.mu_k * (1 + p.h * sin(u / p.v_2)) + (p.mu_s - p.mu_k) * _fall(u / p.v_s),
        ((0.0, p.v_s), (0.0, p.v_2)),
    )


def _logarithm(p):
    return lambda u: p.mu_k + p.h * log(_ahead(u / p.v_s)) / _ahead(u), ((0.0, p.v_s),)


def _nested(p):
    return (
        lambda u: (
            p.mu_k
            + (p.mu_s - p.mu_k) * _fall(3 * tanh((u / p.v_s) ** 2)) / cosh(max(-300.0, min(u / p.v_2, 300.0)))
        ),
        ((0.0, p.v_s), (0.0, p.v_2)),
    )


def _angle(p):
    return lambda u: p.mu_s - (p.mu_s - p.mu_k) * 0.6 * atan(u / p.v_s), ((0.0, p.v_s),)


CURVES = {
    "Coulomb": _coulomb,
    "ExponentialDecay": _exponential,
    "Stribeck": _stribeck,
    "WeakeningStrengthening": _strengthening,
    "Smooth": _smooth,
    "RiseAndFall": _rise_and_fall,
    "Bump": _bump,
    "Edge": _edge,
    "TwoLayers": _two_layers,
    "Product": _product,
    "Quotient": _quotient,
    "Power": _power,
    "Ripple": _ripple,
    "Logarithm": _logarithm,
    "Nested": _nested,
    "Angle": _angle,
}
