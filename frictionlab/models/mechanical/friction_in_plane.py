"""Friction in the plane: the regimes of a contact whose v_r has two components, and when it stops.

In slip the friction force is the law's at the speed s = |v_r|, along v_r.  This has a Taylor series while
s > 0, whose radius is the time that is left before a stop.  So steps shrink with that time, until the solver
takes the last one with constant acceleration (:func:`step_length.first_stop`).

Stick holds both components, until the holding force F leaves the circle |F| <= mu_s F_N.  Then v_r is zero
and has no direction.  In "breakaway" the friction force has a direction e that has a series.  Slip is along
e = F/|F| at first, and goes on along F as this turns:

    F_k e = F - B^-1 v_r',  v_r' = s' F/|F| + s (F/|F|)',  s' = (|F| - F_k)/(F B^-1 F/F^2),

with B = W^T M^-1 W, and F' by the motion in stick.  With the excess x = 1 - F_k/|F|, the acceleration a by
|F| alone and the time T = |F|/|F'| in which the force changes, slip takes over at the speed 2 NEARNESS a T/x.
Under a constant force breakaway lasts, along a straight line.  Under a law with mu_s = mu_k the excess grows
from zero.  Then v_r turns into the direction of F at the rate |F|/s, so fast that steps from an earlier
instant would be thousands; but it follows F as closely, and that is the above.

The constraint of breakaway is v_r^2 = 0, which is so but for rounding: no motion rests in it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import sympy

from frictionlab.automaton import Reset
from frictionlab.components.contact import Interface
from frictionlab.components.impact import has_friction
from frictionlab.models.symbols import dot, expand_products, gradient
from frictionlab.validation import abbreviate

from .contact_regimes import (
    RUBBING_IN_PLANE,
    ContactRegime,
    HeldVelocity,
    RegimeEnd,
    components,
    ends_of_contact,
    magnitude,
    regime,
)
from .mechanics import Friction, Mechanics

if TYPE_CHECKING:
    from frictionlab.models.mechanical.equations_of_motion import LagrangeSystem

NEARNESS = sympy.Float("3e-9")  # a share of the time in which the force changes
NO_FORCE = sympy.Float("1e-200")  # N^2
STOP = "stop"  # the event at which slip ends


def plane_regimes(contact: Friction, system: LagrangeSystem) -> tuple[ContactRegime, ...]:
    """All regimes of a contact in the plane, in the order in which they are tried."""
    own = {"stick": _stick, "slip": _slip, "breakaway": _breakaway}
    return tuple(
        own[name](contact, system) if name in own else regime(contact, name, system) for name in contact.modes
    )


def _slip(contact: Friction, system: LagrangeSystem) -> ContactRegime:
    """Slip along v_r, until the speed |v_r| is zero."""
    speed, pressing = magnitude(contact.velocities), contact.pressing
    friction = contact.law.kinetic(pressing, speed)

    stops = RegimeEnd(STOP, speed, ("stick", "breakaway"), "stop")
    force = tuple(friction * one / speed for one in contact.velocities)
    leaving = ends_of_contact(contact, system)
    return ContactRegime("slip", force, (), (), lambda *_: (stops, *leaving), pressing=pressing)


def _stick(contact: Friction, system: LagrangeSystem) -> ContactRegime:
    """Stick: both components of v_r are zero, until the holding force leaves its circle."""
    limit, directions = contact.law.static_limit(contact.pressing), system.direction(contact)
    bilateral = "separation" not in contact.modes and system.varies(sympy.sympify(limit, strict=True))
    held = tuple(HeldVelocity(one, directions[:, k], -1) for k, one in enumerate(contact.velocities))

    def breaks(force: Any, largest: Any) -> tuple[RegimeEnd, ...]:
        room = largest**2 - sum(one**2 for one in components(force))
        pulls = (RegimeEnd("F_N", largest, ("breakaway",)),) if bilateral else ()
        return (RegimeEnd("cone", room, ("breakaway",)), *pulls, *ends_of_contact(contact, system))

    return ContactRegime("stick", None, held, contact.velocities, breaks, limit, pressing=contact.pressing)


def _breakaway(contact: Friction, system: LagrangeSystem) -> ContactRegime:
    """Slip begins: friction is along the force that would hold, until v_r has a direction."""
    pressing, velocities, directions = contact.pressing, contact.velocities, system.direction(contact)
    resting = sum(one**2 for one in velocities)  # rounding throughout
    soft = (directions.T * system.inverse * directions).tolist()
    stiff = tuple(_solved(soft, one) for one in ((1, 0), (0, 1)))  # B^-1, by columns

    def friction(holding: Any, rates: Any) -> tuple[Any, ...]:
        size = _size(holding)
        along = [one / size for one in holding]
        speed = dot(along, velocities)
        largest = contact.law.kinetic(pressing, speed)
        by_size = dot(along, rates)
        turning = [(rate - one * by_size) * speed / size for one, rate in zip(along, rates, strict=True)]
        drive = [one - dot(row, turning) for one, row in zip(holding, stiff, strict=True)]
        inert = dot(holding, [dot(row, holding) for row in stiff]) + NO_FORCE * (stiff[0][0] + stiff[1][1])
        rate = size**2 * (size - largest) / inert
        (a, b), (c, d) = stiff
        direction = _solved(((rate * a + largest, rate * b), (rate * c, rate * d + largest)), drive)
        return tuple(largest * one / _size(direction) for one in direction)

    def ends(holding: Any, rates: Any) -> tuple[RegimeEnd, ...]:
        holding, rates = components(holding), components(rates)
        power, force = dot(holding, velocities), dot(holding, holding)
        excess = 1 - contact.law.kinetic(pressing, sympy.S.Zero) / _size(holding)
        full = _softness(contact, system)  # acceleration by a unit of the force alone
        least = 2 * NEARNESS * full * force * _size(holding)
        return (
            RegimeEnd(STOP, power, ("stick",), "stop"),
            RegimeEnd("slips", least - power * excess * _size(rates), ("slip",)),
            *ends_of_contact(contact, system),
        )

    return ContactRegime("breakaway", None, (), (resting,), ends, pressing=pressing, by_holding=friction)


def _solved(matrix: Any, right: Sequence[Any]) -> tuple[Any, ...]:
    """The solution of two linear equations, by Cramer's rule and without looking for common factors."""
    (a, b), (c, d) = matrix
    determinant = a * d - b * c
    return (d * right[0] - b * right[1]) / determinant, (a * right[1] - c * right[0]) / determinant


def _size(force: Any) -> Any:
    """The magnitude of a force, with a value where no force acts on the body."""
    return sympy.sqrt(sum(one**2 for one in force) + NO_FORCE)


def _softness(contact: Friction, system: LagrangeSystem) -> Any:
    """Acceleration by a unit force (1/kg), the mean of all directions."""
    directions = system.direction(contact)
    return (directions.T * system.inverse * directions).trace() / 2


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
    law = contact.impact
    if law is not None and has_friction(law):
        raise ValueError(
            f"the impact law of {what} must have no friction, got {type(law).__name__}: take "
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
