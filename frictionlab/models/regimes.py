"""What a contact may do: each regime with its force, its constraint and the events that end it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import sympy

from frictionlab.components.impact import ImpactLaw, PlasticImpact

from .mechanics import Friction, Stop
from .symbols import multiplied_out

OTHER = {"slip+": "slip-", "slip-": "slip+"}
PHASE = "phase"


class End(NamedTuple):
    """What ends a regime: a function that is positive before, the regimes to try then, and who jumps how.

    `jump` is None, "project" or "impact".
    """

    name: str
    function: Any
    targets: tuple[str, ...]
    jump: str | None = None


@dataclass(frozen=True, eq=False)
class Regime:
    """One way to be of one contact.

    Parameters
    ----------
    name : str
    force : Expr or None
        Force (N) of the contact; None where it is what holds `held`.
    held : Expr or None
        The velocity that is kept at zero.
    constraints : tuple of Expr
    ends : callable
        From the force to its events.
    """

    name: str
    force: Any
    held: Any
    constraints: tuple[Any, ...]
    ends: Callable[[Any], tuple[End, ...]]


def regimes(contact: Friction | Stop, rate: Callable[[Any], Any]) -> tuple[Regime, ...]:
    """All regimes of a contact, in the order in which they are tried; `rate` differentiates by time."""
    return (
        _of_friction(contact) if isinstance(contact, Friction) else _of_stop(contact, rate(contact.distance))
    )


def _of_friction(contact: Friction) -> tuple[Regime, ...]:
    speed, normal, law = contact.relative_velocity, contact.normal_force, contact.law
    lost = () if contact.gap is None else (End("gap", contact.gap, ("separation",)),)
    limit = law.static_limit(normal)

    def breaks(force: Any) -> tuple[End, ...]:
        return (End("cone+", limit - force, ("slip+",)), End("cone-", limit + force, ("slip-",)), *lost)

    def slip(name: str) -> Regime:
        sign = 1 if name == "slip+" else -1
        stops = End("v_r", sign * speed, ("stick", OTHER[name]), "project")
        return Regime(name, sign * law.kinetic(normal, sign * speed), None, (), lambda _: (stops, *lost))

    found = Regime("stick", None, speed, (speed,), breaks), slip("slip+"), slip("slip-")
    if contact.gap is None:
        return found
    lands = End("gap", -contact.gap, ("slip+", "slip-", "stick"))
    return (*found, Regime("separation", sympy.S.Zero, None, (), lambda _: (lands,)))


def _of_stop(contact: Stop, rate: Any) -> tuple[Regime, ...]:
    hits = End("impact", contact.distance, ("flight", "contact"), "impact")
    return (
        Regime("flight", sympy.S.Zero, None, (), lambda _: (hits,)),
        Regime(
            "contact", None, rate, (contact.distance, rate), lambda force: (End("off", force, ("flight",)),)
        ),
    )


def rate_after(law: ImpactLaw, rate: Any) -> Any:
    """Rate at which the distance from a stop grows after an impact, from that before."""
    compliance = sympy.Symbol("compliance", positive=True)
    return multiplied_out(rate + compliance * law.impulse(-rate, -rate, compliance))


CLOSING = PlasticImpact("full")
