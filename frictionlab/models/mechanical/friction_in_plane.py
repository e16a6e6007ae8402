"""Friction in the plane: the regimes of a contact whose v_r has two components, and when it stops.

In slip the friction force is the law's at the speed |v_r|, along v_r.  This has a Taylor series while
|v_r| > 0, whose radius is the time that is left before a stop.  So steps shrink with that time, and slip
ends at STOP_SPEED, where a reset makes v_r zero.  With the deceleration a, the place errs by
STOP_SPEED^2/(2 a) and the instant by STOP_SPEED/a.

Stick holds both components, until the holding force F leaves the circle |F| <= mu_s F_N.  Then v_r is zero
and has no direction.  In "breakaway" the friction force is along F instead, which has a series: v_r turns
into this direction at a rate that is infinite at v_r = 0.  Slip takes over at twice STOP_SPEED.  With
mu_s = mu_k the slip is slow at first and turns so fast that its first steps are some thousands.  Where
inertia differs between the directions, v_r begins a little beside F; the error of velocities is of the order
of STOP_SPEED.  Breakaway starts at v_r = 0 and counts as a mode that holds this: no motion rests in it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import sympy

from frictionlab.automaton import Reset
from frictionlab.components.contact import Interface
from frictionlab.models.symbols import expand_products, gradient
from frictionlab.validation import abbreviate

from .contact_regimes import (
    ContactRegime,
    HeldVelocity,
    RegimeEnd,
    ends_of_contact,
    magnitude,
    regime,
)
from .mechanics import Friction, Mechanics

if TYPE_CHECKING:
    from frictionlab.models.mechanical.equations_of_motion import LagrangeSystem

STOP_SPEED = sympy.Float("1e-9")  # m/s; of smaller ones on a belt the squares are rounding
NO_FORCE = sympy.Float("1e-200")  # N^2
RUBBING_IN_PLANE = "stick", "slip", "breakaway"


def plane_regimes(contact: Friction, system: LagrangeSystem) -> tuple[ContactRegime, ...]:
    """All regimes of a contact in the plane, in the order in which they are tried."""
    own = {"stick": _stick, "slip": _slip, "breakaway": _breakaway}
    return tuple(
        own[name](contact, system) if name in own else regime(contact, name, system) for name in contact.modes
    )


def _slip(contact: Friction, system: LagrangeSystem) -> ContactRegime:
    """Slip along v_r, until it stops."""
    speed, pressing = magnitude(contact.velocities), contact.pressing
    friction = contact.law.kinetic(pressing, speed)
    stops = RegimeEnd("v_r", speed - STOP_SPEED, ("stick", "breakaway"), "project")
    ends = (stops, *ends_of_contact(contact, system))
    force = tuple(friction * one / speed for one in contact.velocities)
    return ContactRegime("slip", force, (), (), lambda *_: ends, pressing=pressing)


def _stick(contact: Friction, system: LagrangeSystem) -> ContactRegime:
    """Stick: both components of v_r are zero, until the holding force leaves its circle."""
    limit, directions = contact.law.static_limit(contact.pressing), system.direction(contact)
    held = tuple(HeldVelocity(one, directions[:, k], -1) for k, one in enumerate(contact.velocities))

    def breaks(force: Any, largest: Any) -> tuple[RegimeEnd, ...]:
        room = largest**2 - sum(one**2 for one in _components(force))
        return (RegimeEnd("cone", room, ("breakaway",)), *ends_of_contact(contact, system))

    return ContactRegime("stick", None, held, contact.velocities, breaks, limit, pressing=contact.pressing)


def _breakaway(contact: Friction, system: LagrangeSystem) -> ContactRegime:
    """Slip begins: friction is along the force that would hold, until v_r has a direction."""
    pressing, velocities = contact.pressing, contact.velocities

    def friction(holding: Any) -> tuple[Any, ...]:
        largest = contact.law.kinetic(pressing, sympy.S.Zero)
        return tuple(largest * one / _size(holding) for one in holding)

    def ends(holding: Any, _: Any) -> tuple[RegimeEnd, ...]:
        holding = _components(holding)
        power = sum(one * velocity for one, velocity in zip(holding, velocities, strict=True))
        return (
            RegimeEnd("v_r", power, ("stick",), "project"),
            RegimeEnd("slips", 2 * STOP_SPEED * _size(holding) - power, ("slip",)),
            *ends_of_contact(contact, system),
        )

    return ContactRegime("breakaway", None, (), velocities, ends, pressing=pressing, by_holding=friction)


def _size(holding: Any) -> Any:
    """|F| of the force that would hold, with a value where no force acts on the body."""
    return sympy.sqrt(sum(one**2 for one in holding) + NO_FORCE)


def _components(force: Any) -> tuple[Any, ...]:
    return force if isinstance(force, tuple) else (force, force)


def plane_stop(system: LagrangeSystem, contact: Friction) -> Reset:
    """The reset to v_r = 0 by the impulse of a contact in the plane.

    It is left out where W^T M^-1 W depends on the state, as in :func:`contact_regimes.stick_reset`.
    """
    zero: dict[Any, int] = {sign * one: 1 for one in contact.velocities for sign in (1, -1)}
    directions = system.direction(contact)
    soft = directions.T * system.inverse * directions
    if system.varies(soft):
        return Reset(vanishing=zero)
    changes = system.inverse * directions * soft.LUsolve(sympy.Matrix(contact.velocities))
    pairs = zip(system.v, changes, strict=True)
    return Reset({rate: expand_products(rate + one) for rate, one in pairs if one != 0}, zero)


def names_in_plane(names: Sequence[str]) -> tuple[str, ...]:
    """The regimes in the plane, by those of a contact with one direction."""
    return (*RUBBING_IN_PLANE, *(name for name in names if name == "separation"))


def check_plane(contact: Friction, of: str, interface: Interface) -> tuple[Any, ...]:
    """The two components of v_r of a contact in the plane.

    Raises
    ------
    ValueError
        Where there are not two, or its laws or its interface are for one direction.
    """
    what = f"a contact in the plane of {of}"
    if len(contact.velocities) != 2:
        raise ValueError(
            f"relative_velocity of {what} must have two components, got {len(contact.velocities)}: write "
            "(self.v - v.x, -v.y), or one expression for friction along a line"
        )
    if contact.law.states:
        raise ValueError(
            f"the friction law of {what} must have no states, got {type(contact.law).__name__}: its states "
            "would be vectors; take a law such as Coulomb's, or write bristles as further states and loads"
        )
    if contact.impact is not None and contact.impact.friction_coefficient != 0:
        raise ValueError(
            f"the impact law of {what} must have no friction, got {type(contact.impact).__name__}: take "
            "RestitutionImpact"
        )
    for one in (contact.interface or interface, interface):
        if not one.sticks:
            raise ValueError(
                f"the interface of {what} must have stick, got {type(one).__name__}: slip in the plane has "
                "no fixed direction; take StickSlipSeparation"
            )
    return contact.velocities


def check_directions(contact: Friction, of: str, v: Sequence[Any]) -> None:
    """Raise ValueError where the components of v_r are along one direction."""
    if _rank(contact, v) < 2:
        raise ValueError(
            f"relative_velocity of a contact in the plane of {of} must have two independent components, got "
            f"{abbreviate(contact.relative_velocity)}: write those along two directions at right angles"
        )


def check_alone(about: Mechanics, of: str, v: Sequence[Any]) -> None:
    """Raise ValueError where another contact may hold what a contact in the plane holds."""
    rubbing = [one for one in about.contacts if isinstance(one, Friction)]
    for one in (one for one in rubbing if one.in_plane):
        for other in (other for other in rubbing if other is not one):
            if _rank(one, v, other) < len(one.velocities) + len(other.velocities):
                raise ValueError(
                    f"a contact in the plane of {of} must be the only one with friction along its "
                    "directions, as the equations give only the sum of the forces: give the body one contact"
                )


def _rank(contact: Friction, v: Sequence[Any], *others: Friction) -> int:
    every = (velocity for one in (contact, *others) for velocity in one.velocities)
    return sympy.Matrix([gradient(one, v) for one in every]).rank()
