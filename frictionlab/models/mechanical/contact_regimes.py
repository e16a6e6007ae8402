"""The regimes of a contact: the force, constraint and events of each, the resets, and the chatter mode.

Resets are the projection onto stick, the impact on a stop, and the impact of a re-contact.  Chatter is the
limit of impacts after each of which the slider leaves the belt again, in ever shorter flights.

Eq. (13) brings the velocity relative to the belt's *material* point to zero.  The slider then leaves the belt
at the rate r = (x1' - x2') phi, which no impact changes.  Where r > 0 the gap opens; if in flight it closes
with the acceleration a, the slider lands after 2 r/a, at the rate r, and so on.  Flights of length T differ
from their limit T -> 0 by O(T^2).  In the limit the mean of the impulses is a force F_N = a/(g^T M^-1 W_N)
that keeps gap and gap rate at zero; g is the gap's gradient.  There is no friction, as there is none in
flight and none in an impact.  Chatter ends where r comes to zero, which is the accumulation (Zeno) point of
the flights, or where the flights grow long.  In the latter case the slider takes off, with an error of the
order of r, as the limit does not tell at which point of a flight it is.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from itertools import combinations
from typing import TYPE_CHECKING, Any, NamedTuple

import sympy

from frictionlab.automaton import Event, Mode, Reset
from frictionlab.automaton.expressions import exact_number
from frictionlab.components.friction import FrictionLaw
from frictionlab.components.impact import ImpactLaw, PlasticImpact, clip, has_friction
from frictionlab.models.mechanical.common_directions import RUBBING
from frictionlab.models.mechanical.coupled_masses import numbers_of, pivot_of, solved_for
from frictionlab.models.mechanical.dynamic_laws import (
    limits_of_states,
    rates_in_separation,
    returns_to_zero,
    values_of_contact,
    values_of_law,
    zeros_at_landing,
)
from frictionlab.models.mechanical.mechanics import AnyContact, Contact, Friction, Stop
from frictionlab.models.symbols import dot, expand_products, symbol
from frictionlab.presentation import WEDGE

if TYPE_CHECKING:
    from frictionlab.models.mechanical.equations_of_motion import LagrangeSystem


# The regimes tried first after an event, in this order, where the contact has them.
AFTER_SLIP = {"slip+": ("stick", "slip-"), "slip-": ("stick", "slip+")}
AFTER_FLIGHT = ("slip+", "slip-", "slip", "stick", "contact")
RUBBING_IN_PLANE = ("stick", "breakaway", "slip")  # in this order, as slip takes any v_r, also zero
APART = ("separation", "relaxation")  # regimes without contact forces
COMPLIANCE = sympy.Symbol("compliance", positive=True)
RATE_SYMBOLS: tuple[Any, Any, Any] = (*sympy.symbols("material_rate gap_rate", real=True), COMPLIANCE)
CLOSING = PlasticImpact("full")  # law of the impact that closes a Zeno accumulation
LEAST_IMPULSE = 1e-150  # N s, so that nothing is divided by zero without a push; its square is no underflow
DIRECTIONS = "a", "b"  # the components of friction in the plane, in names of outputs
CHATTER_MODE = "chatter"
CHATTER_FLIGHT = "flight"  # the event that ends it by an impact
CHATTER_TIME = symbol("chatter")  # s, below which the solver replaces flights by their limit


class HeldVelocity(NamedTuple):
    """A velocity that a contact keeps at zero, and the direction (n, 1) of the force that does so.

    The force acts along the gradient of the velocity, `sign` 1, as the reaction of a stop; or against it, -1,
    as friction.
    """

    velocity: Any
    along: Any
    sign: int


class RegimeEnd(NamedTuple):
    """What ends a regime: an event function, the regimes to try then, and the kind of reset.

    `jump` is None, "project" (onto the constraints), "stop" (the same in the plane), "impact", "cross"
    (v_r changes its sign, and nothing jumps), "open" (a rigid contact ends, and nothing jumps), "unload"
    (the states of a friction law return to zero), "yield" (one comes to its limit) or "hold" (it leaves
    that). What is `common` ends the regimes of all contacts that rub along one direction, at once.  `state`
    is the place among the law's states of the one that comes to its limit or leaves it.
    """

    name: str
    function: Any
    targets: tuple[str, ...]
    jump: str | None = None
    common: bool = False
    state: int = 0


class ImpactTerms(NamedTuple):
    """What the impulses of an impact with friction follow from.

    `impulse` is p, that of the impact without friction (N s).  After it `stopping` is the p_T that brings v_r
    to zero, and `least` that at which the kinetic energy is least.  p_N = p - b p_T, where b is `share`.
    """

    impulse: Any
    stopping: Any
    least: Any
    share: Any


@dataclass(frozen=True, eq=False)
class ContactRegime:
    """A regime of one contact, such as stick or flight.

    Parameters
    ----------
    name : str
    force : Expr or None
        Force (N) of the contact; None where constraint forces keep what is `held` at zero.
    held : tuple of HeldVelocity
        The velocities that are kept at zero; () without a constraint.
    constraints : tuple of Expr
    ends : callable
        Function of the force, and of its limit, that returns what ends the regime.  Of a rigid contact with
        friction: of the reaction, and of the friction force in stick, or the compliance in slip.
    limit : Expr or None
        Largest force (N) of friction that can hold; None for other regimes.
    resting : ContactRegime or None
        What takes the place of slip where other contacts keep v_r at zero: friction at its limit.
    pressing : Expr
        F_N of a contact with friction, N.
    rates : tuple of Expr
        The rates of the states of its friction law.
    share : Expr or None
        F_T/F_N in slip of a rigid contact.
    sliding : Expr or None
        What is positive in slip of a rigid contact, whatever its forces: v_r by its sign.
    by_holding : callable or None
        Of breakaway in the plane: the friction force, by the one that would hold and the rate of this.
    """

    name: str
    force: Any
    held: tuple[HeldVelocity, ...]
    constraints: tuple[Any, ...]
    ends: Callable[[Any, Any], tuple[RegimeEnd, ...]]
    limit: Any = None
    resting: ContactRegime | None = None
    pressing: Any = sympy.S.Zero
    rates: tuple[Any, ...] = ()
    share: Any = None
    sliding: Any = None
    by_holding: Callable[[Any, Any], Any] | None = None


def regimes_of_contact(contact: AnyContact, system: LagrangeSystem) -> tuple[ContactRegime, ...]:
    """All regimes of a contact, in the order in which they are tried."""
    if isinstance(contact, Stop):
        return _rigid_regimes(contact, system) if contact.rubs else _stop_regimes(contact, system)
    return tuple(regime(contact, name, system) for name in contact.modes)


def regime(contact: Friction | Contact, name: str, system: LagrangeSystem) -> ContactRegime:
    """One regime of a contact that is not rigid.

    Raises
    ------
    ValueError
        If there is no regime of that name.
    """
    if name not in BUILDERS:
        raise ValueError(f"no mode is called {name!r}: an interface may list {', '.join(BUILDERS)}")
    return BUILDERS[name](contact, system)


def sliding_friction(contact: Friction, sign: Any, normal: Any, speed: Any) -> Any:
    """F_T in slip with v_r of this `sign`."""
    return sign * contact.law.kinetic(normal, sign * speed)


def _slip(contact: Friction, system: LagrangeSystem, name: str) -> ContactRegime:
    """Slip in one direction, Eqs. (1) to (4)."""
    if contact.law.states:
        return (_elastic_plastic if limits_of_states(contact) else _slip_by_states)(contact, system, name)
    sign, speed = 1 if name == "slip+" else -1, contact.relative_velocity
    stops = RegimeEnd("v_r", sign * speed, _known(contact, AFTER_SLIP[name]), "project", common=True)
    force = sliding_friction(contact, sign, contact.pressing, speed)
    pressing = contact.pressing
    limit = sign * contact.law.static_limit(pressing)
    resting = ContactRegime(
        name, limit, (), (speed,), lambda *_: ends_of_contact(contact, system), pressing=pressing
    )
    return ContactRegime(
        name,
        force,
        (),
        (),
        lambda *_: (stops, *ends_of_contact(contact, system)),
        resting=resting,
        pressing=pressing,
    )


def _slip_by_states(contact: Friction, system: LagrangeSystem, name: str) -> ContactRegime:
    """v_r of one sign under a dynamic law, whose force is continuous where v_r changes its sign."""
    sign, speed, pressing = 1 if name == "slip+" else -1, contact.relative_velocity, contact.pressing
    crosses = RegimeEnd("v_r", sign * speed, _known(contact, AFTER_SLIP[name]), "cross")
    leaving = ends_of_contact(contact, system)
    force, rates = values_of_contact(contact, system.law_states(contact), sign)
    held = ContactRegime(name, force, (), (speed,), lambda *_: leaving, pressing=pressing, rates=rates)
    return ContactRegime(
        name, force, (), (), lambda *_: (crosses, *leaving), resting=held, pressing=pressing, rates=rates
    )


def _elastic_plastic(contact: Friction, system: LagrangeSystem, name: str) -> ContactRegime:
    """The one state of an elastic-plastic law sticks, within its limit, or slips, at the limit."""
    of_state = (one._replace(targets=_known(contact, one.targets)) for one in _ends(contact, system, 0, name))
    ends = (*of_state, *ends_of_contact(contact, system))
    yielded = _yielded(contact, system, (name,))
    return ContactRegime(name, held=(), ends=lambda *_: ends, pressing=contact.pressing, **yielded)


def regimes_of_state(contact: Friction, system: LagrangeSystem, k: int) -> tuple[ContactRegime, ...]:
    """The regimes of one of several states of an elastic-plastic law; in "separation" it is at rest."""

    def regime(name: str) -> ContactRegime:
        if name not in RUBBING:
            return ContactRegime(name, sympy.S.Zero, (), (), lambda *_: ())
        ends, sticks = _ends(contact, system, k, name), ["stick"] * len(contact.law.states)
        rate = _yielded(contact, system, [*sticks[:k], name, *sticks[k + 1 :]])["rates"][k]
        return ContactRegime(name, sympy.S.Zero, (), (), lambda *_: ends, rates=(rate,))

    return tuple(map(regime, (*RUBBING, *_known(contact, ("separation",)))))


def in_contact(
    contact: Friction, system: LagrangeSystem, of_states: Sequence[ContactRegime]
) -> ContactRegime:
    """The regime "contact", in which several states of a law have these regimes."""
    bare, names = _frictionless(contact, system), [one.name for one in of_states]
    ends = (*(end for one in of_states for end in one.ends(None, None)), *bare.ends(None, None))
    return replace(bare, ends=lambda *_: ends, **_yielded(contact, system, names))


def _yielded(contact: Friction, system: LagrangeSystem, names: Sequence[str]) -> dict[str, Any]:
    """Force, rates and constraints of an elastic-plastic law by the regime of each state.

    In slip a state is at its limit, and follows it.
    """
    pairs = zip(limits_of_states(contact), names, strict=True)
    borders = [RUBBING[name] * limit for limit, name in pairs]
    slips, states = [bool(RUBBING[name]) for name in names], system.law_states(contact)
    at = [border if slip else state for border, slip, state in zip(borders, slips, states, strict=True)]
    force, elastic = values_of_law(contact.law, contact.pressing, contact.relative_velocity, at)
    each = list(zip(borders, slips, states, elastic, strict=True))
    return {
        "force": force,
        "rates": tuple(_rate_of_limit(system, one) if slip else rate for one, slip, _, rate in each),
        "constraints": tuple(state - border for border, slip, state, _ in each if slip),
    }


def _rate_of_limit(system: LagrangeSystem, limit: Any) -> Any:
    return system.rate_in_motion(limit, system.accelerations_of_mode)


def _ends(contact: Friction, system: LagrangeSystem, k: int, name: str) -> tuple[RegimeEnd, ...]:
    """What ends stick or slip of one state of an elastic-plastic law."""
    states, limit, sign = [*system.law_states(contact)], limits_of_states(contact)[k], RUBBING[name]
    if not sign:
        return (
            RegimeEnd("cone+", limit - states[k], ("slip+",), "yield", state=k),
            RegimeEnd("cone-", limit + states[k], ("slip-",), "yield", state=k),
        )
    states[k] = border = sign * limit
    rates = values_of_law(contact.law, contact.pressing, contact.relative_velocity, states).rates
    return (
        RegimeEnd("v_r", sign * (rates[k] - _rate_of_limit(system, border)), ("stick",), "hold", state=k),
    )


def _slip_on(contact: Friction, system: LagrangeSystem) -> ContactRegime:
    """Slip whose friction force keeps its sign, that of the belt's speed."""
    sign, belt = system.sliding_sign(contact), system.at_rest(contact.relative_velocity)
    force = sliding_friction(contact, sign, contact.pressing, contact.relative_velocity)
    # A belt whose speed depends on time or place may turn round; then the force has no sign.
    turns = (RegimeEnd("belt", sign * belt, ()),) if system.varies(belt) else ()
    leaving = ends_of_contact(contact, system)
    return ContactRegime("slip", force, (), (), lambda *_: (*turns, *leaving), pressing=contact.pressing)


def _frictionless(contact: Friction | Contact, system: LagrangeSystem) -> ContactRegime:
    """Contact without friction."""
    leaving = ends_of_contact(contact, system)
    return ContactRegime("contact", sympy.S.Zero, (), (), lambda *_: leaving, pressing=contact.pressing)


def _stick(contact: Friction, system: LagrangeSystem) -> ContactRegime:
    """Stick, Eqs. (5) to (8), until the constraint force leaves the friction cone."""
    if contact.law.states:
        return _elastic_plastic(contact, system, "stick")
    speed, limit = contact.relative_velocity, contact.law.static_limit(contact.pressing)

    def breaks(force: Any, largest: Any) -> tuple[RegimeEnd, ...]:
        forwards = RegimeEnd("cone+", largest - force, _known(contact, ("slip+",)), common=True)
        backwards = RegimeEnd("cone-", largest + force, _known(contact, ("slip-",)), common=True)
        return (forwards, backwards, *ends_of_contact(contact, system))

    held = (HeldVelocity(speed, system.direction(contact), -1),)
    return ContactRegime("stick", None, held, (speed,), breaks, limit, pressing=contact.pressing)


def _separation(contact: Friction | Contact, system: LagrangeSystem) -> ContactRegime:
    """Flight, Eq. (9): no contact forces; it ends where the gap closes."""
    rates = _rates_apart(contact, system)
    if contact.penetration is None:
        return ContactRegime("separation", sympy.S.Zero, (), (), lambda *_: (_pressed(contact),), rates=rates)
    jump = None if contact.impact is None else "impact"
    lands = RegimeEnd(
        "gap", -contact.penetration, _known(contact, (*_first_tried(contact), "relaxation")), jump
    )
    return ContactRegime("separation", sympy.S.Zero, (), (), lambda *_: (lands,), rates=rates)


def _relaxation(contact: Friction | Contact, system: LagrangeSystem) -> ContactRegime:
    """No contact forces, as the law would pull: it ends where it would press, or where a gap opens."""
    opens = RegimeEnd("gap", contact.penetration, _known(contact, ("separation",)))
    rates = _rates_apart(contact, system)
    ends = (_pressed(contact), opens)
    return ContactRegime("relaxation", sympy.S.Zero, (), (), lambda *_: ends, rates=rates)


def _rates_apart(contact: Friction | Contact, system: LagrangeSystem) -> tuple[Any, ...]:
    """The rates of the states of the friction law, if there are any, without contact forces."""
    return rates_in_separation(contact, system.law_states(contact)) if isinstance(contact, Friction) else ()


def _pressed(contact: Friction | Contact) -> RegimeEnd:
    return RegimeEnd("F_N", -contact.pressing, _known(contact, _first_tried(contact)))


def _first_tried(contact: Friction | Contact) -> tuple[str, ...]:
    return RUBBING_IN_PLANE if contact.in_plane else AFTER_FLIGHT


BUILDERS: dict[str, Callable[[Any, Any], ContactRegime]] = {
    "stick": _stick,
    "slip+": partial(_slip, name="slip+"),
    "slip-": partial(_slip, name="slip-"),
    "slip": _slip_on,
    "contact": _frictionless,
    "separation": _separation,
    "relaxation": _relaxation,
}


def ends_of_contact(contact: Friction | Contact, system: LagrangeSystem) -> tuple[RegimeEnd, ...]:
    """What ends contact: nothing where it is bilateral, as its interface has no mode for a lost contact."""
    open_regimes = _known(contact, APART[::-1])
    states = system.law_states(contact)
    jump = "unload" if isinstance(contact, Friction) and returns_to_zero(contact, states) else None
    gap = (RegimeEnd("gap", contact.penetration, _known(contact, ("separation",)), jump),)
    pulls = (RegimeEnd("F_N", contact.pressing, open_regimes, jump),)
    if not open_regimes:
        return ()
    if contact.penetration is None:
        return pulls
    return (*gap, *pulls) if "relaxation" in contact.modes else gap


def _known(contact: AnyContact, names: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(name for name in names if name in contact.modes)


def _flight(contact: Stop, closed: tuple[str, ...]) -> ContactRegime:
    """No contact forces; it ends at an impact, after which the contact may have a regime of `closed`."""
    hits = (RegimeEnd("impact", contact.distance, ("flight", *closed), "impact"),) if closed else ()
    return ContactRegime("flight", sympy.S.Zero, (), (), lambda *_: hits)


def _stop_regimes(contact: Stop, system: LagrangeSystem) -> tuple[ContactRegime, ...]:
    """Flight, and contact, in which the reaction keeps the distance at zero and pushes."""
    if "contact" not in contact.modes:
        return (_flight(contact, ()),)
    rate = system.rate(contact.distance)
    held = (HeldVelocity(rate, system.direction(contact), 1),)
    touches = ContactRegime(
        "contact",
        None,
        held,
        (contact.distance, rate),
        lambda force, _: (RegimeEnd("off", force, ("flight",), "open"),),
    )
    return _flight(contact, ("contact",)), touches


def _rigid_regimes(contact: Stop, system: LagrangeSystem) -> tuple[ContactRegime, ...]:
    """Flight, stick and slip of a rigid contact with friction, in the order of its names."""
    closed = contact.modes[1:]
    regimes = {"flight": lambda _: _flight(contact, closed), "stick": lambda _: _rigid_stick(contact, system)}
    slip = partial(_rigid_slip, contact, system)
    return tuple(regimes.get(name, slip)(name) for name in contact.modes)


def _rigid_slip(contact: Stop, system: LagrangeSystem, name: str) -> ContactRegime:
    """Slip in one direction: friction follows from the reaction, F_T = +-mu F_N.

    The reaction keeps the distance at zero together with its friction.  How much both accelerate the
    contact, W_N^T M^-1 (W_N + F_T/F_N W_T), may come to zero where it depends on the state: this is
    Painleve's paradox, and slip ends there.
    """
    speed, rate, law = contact.relative_velocity, system.rate(contact.distance), _law_of(contact)
    sign = {"slip+": 1, "slip-": -1}.get(name) or system.sliding_sign(contact)
    normal, tangent = system.direction(contact), rubbing_direction(system, contact)

    def leaving(reaction: Any, softness: Any) -> tuple[RegimeEnd, ...]:
        jams = () if softness is None else (RegimeEnd(WEDGE, softness, ("flight",)),)
        return (RegimeEnd("off", reaction, ("flight",), "open"), *jams)

    def slip(coefficient: Any, constraints: tuple[Any, ...], ends: Any, **more: Any) -> ContactRegime:
        share = sign * coefficient
        held = (HeldVelocity(rate, normal + share * tangent, 1),)
        return ContactRegime(name, None, held, constraints, ends, share=share, **more)

    closed, kinetic = (contact.distance, rate), law.kinetic(sympy.S.One, sign * speed)
    if name == "slip":
        return slip(kinetic, closed, leaving)
    stops = RegimeEnd("v_r", sign * speed, _known(contact, AFTER_SLIP[name]), "project")
    resting = slip(law.static_limit(sympy.S.One), (*closed, speed), leaving)

    def ends(reaction: Any, softness: Any) -> tuple[RegimeEnd, ...]:
        return (stops, *leaving(reaction, softness))

    return slip(kinetic, closed, ends, resting=resting, sliding=sign * speed)


def _rigid_stick(contact: Stop, system: LagrangeSystem) -> ContactRegime:
    """Stick: distance and v_r are kept at zero, until the forces leave the friction cone or F_N ends."""
    speed, rate = contact.relative_velocity, system.rate(contact.distance)
    held = (
        HeldVelocity(rate, system.direction(contact), 1),
        HeldVelocity(speed, rubbing_direction(system, contact), -1),
    )

    def breaks(reaction: Any, friction: Any) -> tuple[RegimeEnd, ...]:
        limit = _law_of(contact).static_limit(sympy.S.One) * reaction
        return (
            RegimeEnd("cone+", limit - friction, _known(contact, ("slip+",))),
            RegimeEnd("cone-", limit + friction, _known(contact, ("slip-",))),
            RegimeEnd("off", reaction, ("flight",), "open"),
        )

    return ContactRegime("stick", None, held, (contact.distance, rate, speed), breaks)


def _law_of(contact: Stop) -> FrictionLaw:
    """The law of a rigid contact that has friction."""
    assert contact.friction is not None
    return contact.friction


def rubbing_direction(system: LagrangeSystem, contact: AnyContact) -> Any:
    """W_T (n, 1), along which friction acts: minus the gradient of v_r."""
    return -sympy.ImmutableMatrix(system.gradient(contact.relative_velocity, system.v))


@lru_cache(maxsize=4096)  # one for all modes in which the contact slips
def stick_reset(system: LagrangeSystem, contact: Any) -> Reset:
    """Reset to v_r = 0 by an impulse along W, which removes only the rounding error of the event's time.

    There is none where the compliance depends on the state: v_r may be zero because the contact's direction
    vanishes, as at the dead centre of a crank, where no impulse changes v_r.
    """
    pair = system.pair(contact.relative_velocity) if isinstance(contact, Friction) else None
    # Stated, as v_r after the impulse need not be zero to the last bit, and sympy need not see that it is.
    resting = (contact.relative_velocity, *_alike(system, contact))
    zero = {sign * speed: 1 for speed in resting for sign in (1, -1)}
    if isinstance(contact, Stop):
        return Reset(_at_rest_in_contact(system, contact), zero | zeros_in_contact(system, contact))
    if pair is not None:
        return Reset(_together(system, pair), zero)
    w = system.direction(contact)
    soft = compliance(system, w)
    if system.varies(soft):
        return Reset(vanishing=zero)
    jump = _velocity_jump(system, w, contact.relative_velocity / soft)
    after = {rate: expand_products(one) for rate, one in jump.items()}
    if system.coupled is not None:
        after |= _last_velocity(system, contact, w, after)
    return Reset(after, zero)


def zeros_in_contact(system: LagrangeSystem, contact: Stop) -> dict[Any, int]:
    """What is zero in a rigid contact, seen from either side: its distance, and the rate of this."""
    orders = {contact.distance: 2, system.rate(contact.distance): 1}
    return {sign * function: order for function, order in orders.items() for sign in (1, -1)}


def _at_rest_in_contact(system: LagrangeSystem, contact: Stop) -> dict[Any, Any]:
    """Velocities with v_r = 0 and a distance at rest, by the two impulses of a rigid contact; {} where the
    compliance depends on the state, for the reason of :func:`stick_reset`."""
    directions = sympy.Matrix.hstack(system.direction(contact), rubbing_direction(system, contact))
    soft = directions.T * system.inverse * directions
    if system.varies(soft):
        return {}
    missed = sympy.Matrix([-system.rate(contact.distance), contact.relative_velocity])
    changes = system.inverse * directions * soft.LUsolve(missed)
    return {
        rate: expand_products(rate + one) for rate, one in zip(system.v, changes, strict=True) if one != 0
    }


def crossing_reset(contact: Friction) -> Reset:
    """What is known where v_r changes its sign and nothing jumps: v_r is zero, seen from either side."""
    return Reset(vanishing={sign * contact.relative_velocity: 1 for sign in (1, -1)})


def yielding_reset(system: LagrangeSystem, contact: Friction, end: RegimeEnd) -> Reset:
    """A state of an elastic-plastic law is at the limit that an event function, limit -+ state, has met."""
    state, limit = system.law_states(contact)[end.state], limits_of_states(contact)[end.state]
    at = limit if expand_products(end.function - limit + state) == 0 else -limit
    return Reset({state: at}, {state - at: 1})


def holding_reset(system: LagrangeSystem, contact: Friction, k: int, regime_left: str) -> Reset:
    """After a regime of slip a slider sticks: its state is still at the limit, and moves as this does."""
    state, limit = system.law_states(contact)[k], limits_of_states(contact)[k]
    return Reset(vanishing={limit - state if regime_left == "slip+" else limit + state: 2})


def unloading_reset(system: LagrangeSystem, contact: Friction) -> Reset:
    """The states of a dynamic law are zero once the contact is lost."""
    return Reset(dict.fromkeys(system.law_states(contact), sympy.S.Zero))


def _alike(system: LagrangeSystem, contact: Any) -> tuple[Any, ...]:
    """The relative velocities of other contacts that are zero where that of this one is."""
    contacts: Any = system.mechanics.contacts
    i = contacts.index(contact)
    direction = system.direction_of(i)
    if direction is None:
        return ()
    others = (j for j in direction.contacts if j != i and direction.at_one_speed(j, i))
    return tuple(contacts[j].relative_velocity for j in others)


def _last_velocity(system: LagrangeSystem, contact: Any, w: Any, after: dict[Any, Any]) -> dict[Any, Any]:
    """One velocity after the reset, solved from v_r = 0: the jumps leave v_r with a rounding error."""
    row = numbers_of([-one for one in w])
    if row is None:
        return {}
    values, pivot = [after.get(rate, rate) for rate in system.v], pivot_of(row)
    rest = system.at_rest(contact.relative_velocity)
    return {system.v[pivot]: expand_products(solved_for(row, pivot, values, rest))}


def _together(system: LagrangeSystem, pair: Any) -> dict[Any, Any]:
    """Velocities after a reset to v_r = 0 between two bodies, which keep their momentum M x1' + m x2'."""
    one, two, speed = pair
    heavy, light = system.masses[one], system.masses[two]
    together = (heavy * system.v[one] + light * system.v[two] + light * speed) / (heavy + light)
    return {system.v[one]: together, system.v[two]: together - speed}


@lru_cache(maxsize=4096)
def impact_resets(system: LagrangeSystem, contact: Friction | Stop) -> tuple[Reset, Reset]:
    """The impact by the contact's law, and the one that closes a Zeno accumulation of impacts."""
    if isinstance(contact, Stop):
        return _on_stop(system, contact, contact.law), _on_stop(system, contact, CLOSING)
    return _landing(system, contact, contact.impact), _landing(system, contact, CLOSING)


def compliance(system: LagrangeSystem, w: Any) -> Any:
    """W^T M^-1 W (1/kg), the denominator of Eq. (14)."""
    numbers = None if system.coupled is None else numbers_of(list(w))
    if system.coupled is not None and numbers is not None:
        return system.coupled.softness(numbers) / system.coupled.scale
    return (w.T * system.inverse * w)[0]


def _pushed(system: LagrangeSystem, w: Any, impulse: Any) -> Any:
    """M^-1 W p: how the velocities change by an impulse along W."""
    numbers = None if system.coupled is None else numbers_of(list(w))
    if system.coupled is not None and numbers is not None:
        return [exact_number(one) * impulse / system.coupled.scale for one in system.coupled.times(numbers)]
    return system.inverse * w * impulse


def velocities_after(system: LagrangeSystem, direction: Any, impulse: Any) -> dict[Any, Any]:
    """M dv = W p, Eqs. (10) to (12): the velocities that jump, after an impulse along W_N or W_T."""
    return _velocity_jump(system, direction, impulse) if impulse != 0 else {}


def _velocity_jump(system: LagrangeSystem, w: Any, impulse: Any) -> dict[Any, Any]:
    changes = [p * impulse / m for p, m in zip(w, system.masses)] or _pushed(system, w, impulse)
    return {rate: rate + change for rate, change in zip(system.v, changes, strict=True) if change != 0}


def material_rate(system: LagrangeSystem, contact: Friction | Contact) -> Any:
    """The velocity at which the bodies approach at the contact's material points: -W_N . q', and how fast the
    penetration grows with all coordinates at rest, where a ground moves with time."""
    approaching = -sum(w * rate for w, rate in zip(system.normal(contact), system.v, strict=True))
    return approaching + system.explicit_rate(contact.penetration)


def normal_direction(system: LagrangeSystem, contact: Friction | Stop) -> Any:
    """W_N (n, 1) of a contact that has impacts."""
    return system.direction(contact) if isinstance(contact, Stop) else system.normal(contact)


@lru_cache(maxsize=4096)
def _closing_rates(system: LagrangeSystem, contact: Friction | Stop) -> tuple[Any, Any]:
    """Material rate and rate (m/s) at which a gap closes: one expression where they are equal."""
    if isinstance(contact, Stop):
        return (-system.rate(contact.distance),) * 2
    material, full = material_rate(system, contact), system.rate(contact.penetration)
    return (full, full) if expand_products(material - full) == 0 else (material, full)


def normal_impulse(system: LagrangeSystem, contact: Friction | Stop, law: ImpactLaw) -> Any:
    """The impulse p (N s) of an impact without friction, Eq. (14)."""
    return law.impulse(*_closing_rates(system, contact), _compliance_of_law(system, contact, law))


@lru_cache(maxsize=4096)
def _compliances(system: LagrangeSystem, contact: Friction | Stop) -> tuple[Any, Any]:
    """How much an impulse along W_N changes material rate and rate (1/kg): one expression if equal.

    They are W_N^T M^-1 W_N and g^T M^-1 W_N with the gap's gradient g, which the masses may tell apart.
    """
    normal, (material, full) = normal_direction(system, contact), _closing_rates(system, contact)
    soft = compliance(system, normal)
    if material is full:
        return soft, soft
    of_gap = dot(_gradient_of_gap(system, contact), _pushed(system, normal, 1))
    return soft, soft if expand_products(of_gap - soft) == 0 else of_gap


def _compliance_of_law(system: LagrangeSystem, contact: Friction | Stop, law: ImpactLaw) -> Any:
    """How much an impulse along W_N changes the rate of a law, 1/kg."""
    return _compliances(system, contact)[_uses_gap_rate(law)]


def _uses_gap_rate(law: ImpactLaw) -> bool:
    """Whether a law changes the full rate of the gap; else it changes the material one."""
    return sympy.sympify(law.impulse(*RATE_SYMBOLS), strict=True).has(RATE_SYMBOLS[1])


def _gradient_of_gap(system: LagrangeSystem, contact: Friction | Stop) -> Any:
    return -sympy.ImmutableMatrix(system.gradient(_closing_rates(system, contact)[1], system.v))


def impact_rubs(system: LagrangeSystem, contact: Friction | Stop, law: ImpactLaw) -> bool:
    """Whether an impact has friction, and this acts along another direction than the normal impulse."""
    if not has_friction(law) or (isinstance(contact, Stop) and not contact.rubs) or contact.in_plane:
        return False
    w, t = normal_direction(system, contact), rubbing_direction(system, contact)
    pairs = combinations(range(w.rows), 2)
    return any(expand_products(w[i] * t[j] - w[j] * t[i]) != 0 for i, j in pairs)


def terms_of_impact(system: LagrangeSystem, contact: Friction | Stop, law: ImpactLaw) -> ImpactTerms:
    """What the impulses of an impact with friction follow from.

    The rate that the law changes is what it is without friction, whatever p_T is: with its gradient g,
    b = g^T M^-1 W_T/(g^T M^-1 W_N).
    """
    normal, tangent = normal_direction(system, contact), rubbing_direction(system, contact)
    along: list[Any] = [sympy.Matrix(_pushed(system, w, 1)) for w in (normal, tangent)]
    along_normal, along_tangent = along
    rate = _rate_of_law(system, contact, law)
    share = dot(rate, along_tangent) / dot(rate, along_normal)
    coupling, impulse = dot(tangent, along_normal), normal_impulse(system, contact, law)
    work = softness = compliance(system, tangent) - coupling * share
    if rate != normal:
        work -= share * dot(normal, along_tangent - share * along_normal)
    values = (*_closing_rates(system, contact), _compliance_of_law(system, contact, law))
    before = dict(zip(RATE_SYMBOLS, values, strict=True))
    opening = -rates_after_impact(system, contact, law)[0].xreplace(before)
    sliding = contact.relative_velocity - coupling * impulse
    return ImpactTerms(impulse, sliding / softness, (sliding + share * opening) / work, share)


def _rate_of_law(system: LagrangeSystem, contact: Friction | Stop, law: ImpactLaw) -> Any:
    """The gradient (n, 1) of the rate at which a gap opens that a law changes, material or full."""
    material, full = _closing_rates(system, contact)
    if material is not full and _uses_gap_rate(law):
        return _gradient_of_gap(system, contact)
    return normal_direction(system, contact)


def rates_after_impact(system: LagrangeSystem, contact: Friction | Stop, law: Any) -> tuple[Any, Any]:
    """Material and full penetration rate after the impact in terms of those before it, RATE_SYMBOLS."""
    material, full, soft = RATE_SYMBOLS
    rates = _closing_rates(system, contact)
    if rates[0] is rates[1]:
        material = full
    change, own = soft * law.impulse(material, full, soft), _compliance_of_law(system, contact, law)
    changes = (change if one is own else change * one / own for one in _compliances(system, contact))
    return tuple(expand_products(rate - one) for rate, one in zip((material, full), changes, strict=True))


def _landing(system: LagrangeSystem, contact: Friction, law: Any) -> Reset:
    # The penetration is zero at the impact; its rate after it only if the law makes it zero identically.
    order = 2 if rates_after_impact(system, contact, law)[1] == 0 else 1
    landed = zeros_at_landing(contact, system.law_states(contact))
    jump = _after_impact(system, contact, law)
    return Reset(jump, {contact.penetration: order, -contact.penetration: order, **landed})


def _on_stop(system: LagrangeSystem, contact: Stop, law: Any) -> Reset:
    """Reset by an impact on a stop: the distance is zero after it, and so is its rate if the law says so."""
    w = system.direction(contact)
    order = 2 if rates_after_impact(system, contact, law)[1] == 0 else 1
    # The position is projected as well, which removes only a rounding error: a body that comes to rest on the
    # stop is on it to the last bit.
    moved = zip(system.q, _pushed(system, w, contact.distance / compliance(system, w)), strict=True)
    placed = {x: expand_products(x - change) for x, change in moved if change != 0}
    after = _after_impact(system, contact, law)
    if not impact_rubs(system, contact, law):
        after = {v: expand_products(a) for v, a in after.items()}
    return Reset(
        {**placed, **after}, zeros_in_contact(system, contact) if order == 2 else {contact.distance: order}
    )


def _after_impact(system: LagrangeSystem, contact: Friction | Stop, law: ImpactLaw) -> dict[Any, Any]:
    """M dv = W_N p_N + W_T p_T: the velocities after an impact by those before it, of those that jump."""
    normal = normal_direction(system, contact)
    if not impact_rubs(system, contact, law):
        return velocities_after(system, normal, normal_impulse(system, contact, law))
    terms = terms_of_impact(system, contact, law)
    rubbing = impulse_of_friction(law, *terms)
    jump = velocities_after(system, normal, terms.impulse - terms.share * rubbing)
    rubbed = velocities_after(system, rubbing_direction(system, contact), rubbing)
    return jump | {v: jump.get(v, v) + after - v for v, after in rubbed.items()}


def impulse_of_friction(law: ImpactLaw, impulse: Any, stopping: Any, least: Any, share: Any) -> Any:
    """p_T of an impact with friction, N s, by its `ImpactTerms`."""
    if law.has_own_friction:
        return law.friction(impulse, stopping)
    return rubbing_impulse(law.friction_coefficient, impulse, -share, stopping, least)


def rubbing_impulse(mu: Any, impulse: Any, share: Any, stopping: Any, least: Any) -> Any:
    """The impulse of friction p_T at an impact, after which the distance opens as the impact law says.

    The normal impulse is p_N = `impulse` + `share` p_T.  p_T is `stopping`, which brings v_r to zero, or as
    much of it as |p_T| <= mu p_N allows (Moreau, Unilateral contact and dry friction in finite freedom
    dynamics, Springer 1988).  With e > 0 that may feed energy in (Kane & Levinson, Dynamics: Theory and
    Applications, 1985).  The kinetic energy is least at `least`.  Up to twice this impulse friction
    dissipates, which limits p_T too.
    """
    size = partial(sympy.Abs, evaluate=False)  # sympy would look for a sign for a minute
    needed, largest = 2 * size(stopping), 2 * mu * impulse  # twice, and neither is negative
    if share != 0:
        needed = size(stopping) - mu * share * stopping  # below 0 where the cone has no border on this side
        needed = size(needed + size(needed))
    rubbing = 2 * stopping * largest / (largest + needed + size(largest - needed) + LEAST_IMPULSE)
    if least == stopping:
        return rubbing
    twice = 2 * least
    return clip(rubbing, (twice - size(twice)) / 2, (twice + size(twice)) / 2, size)


def rate_after(law: ImpactLaw, rate: Any, compliance: Any = COMPLIANCE) -> Any:
    """Rate of a distance after an impact, as a function of that before and, of few laws, of the compliance.

    It is zero where the law makes it so, as it is found with symbols: numbers would leave a rounding error.
    """
    given = symbol("rate")
    after = expand_products(given + COMPLIANCE * law.impulse(-given, -given, COMPLIANCE))
    return after.xreplace({given: rate, COMPLIANCE: compliance})


def rubbing_outputs(contact: Friction | Stop, force: Any) -> dict[str, Any]:
    """Friction force and v_r by their names: in the plane their magnitudes, and both components of each."""
    if not isinstance(contact, Friction) or not contact.in_plane:
        return {"friction_force": force, "relative_velocity": contact.relative_velocity}
    forces = components(force)
    shown = {"friction_force": magnitude(forces), "relative_velocity": magnitude(contact.velocities)}
    for direction, one, velocity in zip(DIRECTIONS, forces, contact.velocities, strict=True):
        shown |= {f"friction_force_{direction}": one, f"relative_velocity_{direction}": velocity}
    return shown


def components(force: Any) -> tuple[Any, ...]:
    """Both components of a force in the plane; a number, where no regime gives a vector, stands for both."""
    return force if isinstance(force, tuple) else (force, force)


def magnitude(vector: Sequence[Any]) -> Any:
    """The length of a vector in the plane."""
    return sympy.sqrt(sum(one**2 for one in vector))


def chatter_mode(system: LagrangeSystem) -> Mode | None:
    """The limit mode of a single contact at which the gap opens again after an impact; None for others."""
    for contact in system.mechanics.contacts[:1]:
        if isinstance(contact, Friction) and contact.impact is not None and "separation" in contact.modes:
            rate = leaving_rate(system, contact)
            return None if rate == 0 else _limit(system, contact, rate)
    return None


def _limit(system: LagrangeSystem, contact: Friction, rate: Any) -> Mode:
    closing = closing_acceleration(system, contact)
    force = closing / _compliances(system, contact)[1]
    outputs = {
        "penetration": contact.penetration,
        "gap": -contact.penetration,
        "normal_force": force,
        **rubbing_outputs(contact, sympy.S.Zero),
    }
    flow = system.flow(
        _accelerations(system, contact, force), rates_in_separation(contact, system.law_states(contact))
    )
    constraints = (contact.penetration, system.rate(contact.penetration))
    events = (*_chatter_events(system, contact, rate, closing), *period_events(system, CHATTER_MODE))
    return Mode(CHATTER_MODE, flow, events, constraints, outputs, limit=True)


def leaving_rate(system: LagrangeSystem, contact: Friction) -> Any:
    """The rate r such that a gap that closes at the rate r opens at the rate r after the impact.

    Zero where zero is the only such rate, where the law just reverses the rate of the gap, and for impact
    laws that are not linear in the rates.
    """
    material, full, soft = RATE_SYMBOLS
    rate, other = sympy.symbols("rate other")
    law: Any = contact.impact
    before = {material: rate + other, full: rate, soft: _compliance_of_law(system, contact, law)}
    after = rates_after_impact(system, contact, law)[1].subs(before, simultaneous=True)
    slope = sympy.diff(after, rate)
    if slope.has(rate) or (1 + slope).is_zero:
        return sympy.S.Zero
    fixed = -after.subs(rate, 0) / (1 + slope)
    return expand_products(
        fixed.subs(other, material_rate(system, contact) - system.rate(contact.penetration))
    )


def closing_acceleration(system: LagrangeSystem, contact: Friction) -> Any:
    """Second derivative of the penetration in flight, Eq. (9)."""
    rates = (*system.v, *_accelerations(system, contact, 0), *system.other_rates)
    penetration_rate = system.rate(contact.penetration)
    states = system.states[: len(rates)]  # those of friction laws do not move the bodies
    return sum(sympy.diff(penetration_rate, x) * rate for x, rate in zip(states, rates, strict=True))


def _accelerations(system: LagrangeSystem, contact: Friction, force: Any) -> list[Any]:
    """Accelerations under a normal force without friction."""
    return list(system.inverse * sympy.Matrix(system.forces(contact, force)))


def period_events(system: LagrangeSystem, mode: str) -> tuple[Event, ...]:
    """The event that sets the phase back by 2 pi, which leaves the mode as it is; () without a phase."""
    turn = 2 * sympy.pi
    return tuple(
        Event("period", turn - phase, (mode,), Reset({phase: phase - turn})) for phase in system.phase
    )


def _chatter_events(system: LagrangeSystem, contact: Friction, rate: Any, closing: Any) -> tuple[Event, ...]:
    """The events that end the limit mode: flights become infinitely short, or too long.

    Too long is twice the dwell time below which the solver replaces them.
    """
    targets = _known(contact, _first_tried(contact))
    landed = Reset(vanishing={contact.penetration: 2, -contact.penetration: 2})
    return (
        Event("leaving rate", rate, targets, landed),
        Event(
            CHATTER_FLIGHT, CHATTER_TIME * closing - rate, ("separation",), impact_resets(system, contact)[0]
        ),
    )
