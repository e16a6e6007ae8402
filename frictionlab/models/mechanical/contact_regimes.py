"""The regimes of a contact: each with its force, its constraint and the events that end it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import sympy

from .mechanics import Friction, Stop

if TYPE_CHECKING:
    from .equations_of_motion import LagrangeSystem

PHASE = "phase"
# The regimes tried first after an event, in this order, where the contact has them.
AFTER_SLIP = {"slip+": ("stick", "slip-"), "slip-": ("stick", "slip+")}
AFTER_FLIGHT = ("slip+", "slip-", "slip", "stick")


class RegimeEnd(NamedTuple):
    """What ends a regime: an event function, the regimes to try then, and the kind of reset.

    `jump` is None, "project" (onto the constraint) or "impact".
    """

    name: str
    function: Any
    targets: tuple[str, ...]
    jump: str | None = None


@dataclass(frozen=True, eq=False)
class ContactRegime:
    """A regime of one contact, such as stick or flight.

    Parameters
    ----------
    name : str
    force : Expr or None
        Force (N) of the contact; None where it is the constraint force that keeps `held` at zero.
    held : Expr or None
        The velocity that is kept at zero; None without a constraint.
    constraints : tuple of Expr
    ends : callable
        Function of the force that returns the events.
    """

    name: str
    force: Any
    held: Any
    constraints: tuple[Any, ...]
    ends: Callable[[Any], tuple[RegimeEnd, ...]]


def regimes_of_contact(contact: Friction | Stop, found: LagrangeSystem) -> tuple[ContactRegime, ...]:
    """All regimes of a contact, in the order in which they are tried."""
    if isinstance(contact, Stop):
        return _stop_regimes(contact, found.rate(contact.distance))
    return tuple(regime(contact, name, found) for name in contact.modes)


def regime(contact: Friction, name: str, found: LagrangeSystem) -> ContactRegime:
    """One regime of a contact with friction.

    Raises
    ------
    ValueError
        If there is no regime of that name.
    """
    if name not in BUILDERS:
        raise ValueError(f"no mode is called {name!r}: an interface may list {', '.join(BUILDERS)}")
    return BUILDERS[name](contact, found)


def sliding_friction(contact: Friction, sign: Any, normal: Any, speed: Any) -> Any:
    """F_T in slip with v_r of this `sign`."""
    return sign * contact.law.kinetic(normal, sign * speed)


def _slip(contact: Friction, found: LagrangeSystem, name: str) -> ContactRegime:
    """Slip in one direction, Eqs. (1) to (4)."""
    sign, speed = 1 if name == "slip+" else -1, contact.relative_velocity
    stops = RegimeEnd("v_r", sign * speed, _known(contact, AFTER_SLIP[name]), "project")
    force = sliding_friction(contact, sign, contact.pressing, speed)
    return ContactRegime(name, force, None, (), lambda _: (stops, *_leaving(contact)))


def _slip_on(contact: Friction, found: LagrangeSystem) -> ContactRegime:
    """Slip whose friction force keeps its sign, that of the belt's speed."""
    speed = contact.relative_velocity
    force = sliding_friction(contact, sympy.sign(found.at_rest(speed)), contact.pressing, speed)
    return ContactRegime("slip", force, None, (), lambda _: _leaving(contact))


def _stick(contact: Friction, found: LagrangeSystem) -> ContactRegime:
    """Stick, Eqs. (5) to (8), until the constraint force leaves the friction cone."""
    speed, limit = contact.relative_velocity, contact.law.static_limit(contact.pressing)

    def breaks(force: Any) -> tuple[RegimeEnd, ...]:
        forwards = RegimeEnd("cone+", limit - force, _known(contact, ("slip+",)))
        backwards = RegimeEnd("cone-", limit + force, _known(contact, ("slip-",)))
        return (forwards, backwards, *_leaving(contact))

    return ContactRegime("stick", None, speed, (speed,), breaks)


def _separation(contact: Friction, found: LagrangeSystem) -> ContactRegime:
    """Flight, Eq. (9): no contact forces; it ends where the gap closes."""
    jump = None if contact.impact is None else "impact"
    lands = RegimeEnd("gap", -contact.penetration, _known(contact, AFTER_FLIGHT), jump)
    return ContactRegime("separation", sympy.S.Zero, None, (), lambda _: (lands,))


BUILDERS: dict[str, Callable[[Friction, Any], ContactRegime]] = {
    "stick": _stick,
    "slip+": partial(_slip, name="slip+"),
    "slip-": partial(_slip, name="slip-"),
    "slip": _slip_on,
    "separation": _separation,
}


def _leaving(contact: Friction) -> tuple[RegimeEnd, ...]:
    # A contact is bilateral where its interface has no mode for a lost contact.
    targets = _known(contact, ("separation",))
    return (RegimeEnd("gap", contact.penetration, targets),) if targets else ()


def _known(contact: Friction, names: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(name for name in names if name in contact.modes)


def _stop_regimes(contact: Stop, rate: Any) -> tuple[ContactRegime, ...]:
    if "contact" not in contact.modes:
        return (ContactRegime("flight", sympy.S.Zero, None, (), lambda _: ()),)
    hits = RegimeEnd("impact", contact.distance, ("flight", "contact"), "impact")
    return (
        ContactRegime("flight", sympy.S.Zero, None, (), lambda _: (hits,)),
        ContactRegime(
            "contact",
            None,
            rate,
            (contact.distance, rate),
            lambda force: (RegimeEnd("off", force, ("flight",)),),
        ),
    )
