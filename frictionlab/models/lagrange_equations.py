"""Lagrange's equations of a model with contact forces, mode by mode, in the form of the paper.

Also the equations of an impact: on a stop, or of a re-contact, Eqs. (10) to (17).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import sympy

from frictionlab.automaton.modes_on_demand import check_mode_name
from frictionlab.models.equations import (
    LETTERS,
    TIME,
    Equations,
    equation,
    in_time_functions,
    parameter_letters,
    time_functions,
)
from frictionlab.models.mechanical.contact_regimes import (
    APART,
    DIRECTIONS,
    LEAST_IMPULSE,
    RATE_SYMBOLS,
    ContactRegime,
    impact_rubs,
    impulse_of_friction,
    magnitude,
    material_rate,
    normal_impulse,
    rate_after,
    rates_after_impact,
    rubbing_direction,
    sliding_friction,
    terms_of_impact,
)
from frictionlab.models.mechanical.dynamic_laws import (
    LawValues,
    limits_of_law,
    limits_of_states,
    values_of_law,
    values_on_one_side,
)
from frictionlab.models.mechanical.equations_of_motion import LagrangeSystem, Pair, system_at, system_of
from frictionlab.models.mechanical.mechanics import AnyContact, Contact, Friction, Stop
from frictionlab.models.mechanical.modes import contact_suffix, solve_contact_forces
from frictionlab.models.symbolic_laws import symbolic_copy
from frictionlab.models.symbols import symbol

if TYPE_CHECKING:
    from frictionlab.models.mechanical.mechanical_model import MechanicalModel

SIGNS = {"slip+": 1, "slip-": -1}  # of v_r
NORMAL_IMPULSE = symbol("p")
# p_T, and what it follows from: p without friction, the p_T that stops v_r, that of the least energy.
IMPULSES_OF_FRICTION = tuple(map(symbol, ("p_T", "p_0", "p_s", "p_e")))


def stop_equations(stop: Stop, rate: Any) -> tuple[Any, ...]:
    """Equations for the rate of the distance before an impact on a stop, given as `rate`, and after it."""
    before, after = symbol("rate-"), symbol("rate+")
    return equation(before, rate), equation(after, rate_after(stop.law, before))


def impact_equations(model: MechanicalModel) -> tuple[tuple[Any, ...], dict[str, Any]]:
    """Eqs. (10) to (17) for a symbolic model with one contact, and their symbols by name.

    Velocities just before and just after the impact are named ``y1'-`` and ``y1'+``.  Eq. (16) is the one
    that follows from Eqs. (11) and (14): as printed in the paper it has two terms too many.  With friction in
    the impact both impulses follow from p_0, the normal impulse without friction, p_s, that of friction that
    would bring v_r to zero, and p_e, that after which the energy would be least.
    """
    before, after = (_kinematics_with_sign(model, sign) for sign in "-+")
    contact: Any = before.rubbing
    symbols = {str(x): x for x in (*before.q, *before.v, *after.v, NORMAL_IMPULSE)}
    if impact_rubs(before, contact, contact.impact):
        return _with_friction(before, after), symbols | {str(x): x for x in IMPULSES_OF_FRICTION}
    impulse = normal_impulse(before, contact, contact.impact)
    factors = before.inverse * before.normal(contact)
    jumps = [row for row in zip(before.v, after.v, factors, strict=True) if row[2] != 0]
    equations = (
        *(equation(new - old, factor * NORMAL_IMPULSE) for old, new, factor in jumps),
        *_impact_law(before, after),
        equation(NORMAL_IMPULSE, impulse),
        *(equation(new, old + factor * impulse) for old, new, factor in jumps),
    )
    return equations, symbols


def _with_friction(before: LagrangeSystem, after: LagrangeSystem) -> tuple[Any, ...]:
    contact: Any = before.rubbing
    rubbing, alone, stopping, least = IMPULSES_OF_FRICTION
    pushed = before.inverse * (before.normal(contact) * NORMAL_IMPULSE + before.direction(contact) * rubbing)
    terms = terms_of_impact(before, contact, contact.impact)
    if terms.least == terms.stopping:
        least = stopping
    friction = impulse_of_friction(contact.impact, alone, stopping, least, terms.share)
    needs = {
        one: term for one, term in zip((alone, stopping, least), terms) if one is alone or friction.has(one)
    }
    return (
        *(equation(new - old, p) for old, new, p in zip(before.v, after.v, pushed, strict=True)),
        *(equation(one, term) for one, term in needs.items()),
        equation(rubbing, friction.xreplace({sympy.Float(LEAST_IMPULSE): sympy.S.Zero})),
        equation(NORMAL_IMPULSE, alone - terms.share * rubbing),
    )


def impact_letters(model: MechanicalModel, letters: Mapping[str, str]) -> dict[str, str]:
    """LaTeX of the velocities before and after an impact, as in the paper, and of the coordinates."""
    chosen = {}
    for name in model.coordinates:
        letter = letters.get(name) or (f"{name[0]}_{{{name[1:]}}}" if name[1:] else name)
        head, _, index = letter.partition("_")
        chosen[name] = letter
        for sign in "-+":
            dotted = rf"\dot{{{head}}}" + (f"_{index}" if index else "")
            chosen[f"{name}'{sign}"] = rf"{dotted}(t_{{\mathrm{{r}}}}^{{{sign}}})"
    return chosen


def _kinematics_with_sign(model: MechanicalModel, sign: str) -> LagrangeSystem:
    q = [symbol(name) for name in model.coordinates]
    return system_at(model, q, [symbol(f"{name}'{sign}") for name in model.coordinates])


def _impact_law(before: LagrangeSystem, after: LagrangeSystem) -> tuple[Any, ...]:
    """Eq. (13): the rate, material or full, that the impact multiplies by a factor; () if there is none."""
    pairs = list(zip(_rates(before), _rates(after), strict=True))
    contact: Any = before.rubbing
    for (old, new), left, rate in zip(
        pairs, rates_after_impact(before, contact, contact.impact), RATE_SYMBOLS
    ):
        factor = sympy.cancel(left / rate)
        if not factor.has(*RATE_SYMBOLS):
            return (equation(new, factor * old),)
    return ()


def _rates(system: LagrangeSystem) -> tuple[Any, Any]:
    return material_rate(system, system.rubbing), system.rate(system.rubbing.penetration)


class TimeDependentSystem(NamedTuple):
    """A system, the same with a function of time for each F_N, and a function of time for each state."""

    system: LagrangeSystem
    named: LagrangeSystem
    functions: Mapping[Any, Any]

    def __call__(self, expression: Any) -> Any:
        return in_time_functions(expression, self.functions)


def lagrange_equations(model: MechanicalModel, mode: str) -> Equations:
    """The equations of a mode, of "slip" in both directions, or of the "impact".

    Where slip has two modes, "slip" gives both in one, with sgn(v_r) as in Eq. (3).  A mode on one side of
    the borders of laws in pieces has the equations on all sides, as cases.

    Raises
    ------
    ValueError
        If the model has no such mode.
    """
    copy = symbolic_copy(model.structure_key)
    system = system_of(copy.structure_key)
    mode = _on_all_sides(model, system, mode)
    check_mode_name(mode, system.names, _others(system))
    letters = {**LETTERS, **parameter_letters(model), **_contact_letters(system)}
    if mode == "impact":
        return _impact(copy, system, letters)
    write = TimeDependentSystem(system, _named_forces(system), _functions(system))
    known = {"t": TIME, **{name: symbol(name) for name in model.parameters}}
    one = "slip+" if mode == "slip" and "slip+" in system.names else mode
    chosen = write.named.chosen(system.names.combination_of(one) or ())
    return _mode_equations(write, mode, chosen, letters, known)


def _on_all_sides(model: MechanicalModel, system: LagrangeSystem, mode: Any) -> Any:
    """The name of a mode on all sides of borders of laws in pieces, of which one on some sides is part."""
    automaton = model.automaton()
    if not isinstance(mode, str) or mode in system.names or mode not in automaton.names:
        return mode
    whole = automaton.mode(mode).whole
    return mode if whole is None else whole.name


def _others(system: LagrangeSystem) -> tuple[str, ...]:
    """Names besides those of modes for which a model with a single contact has equations."""
    if len(system.mechanics.contacts) != 1:
        return ()
    (contact,), modes = system.mechanics.contacts, system.names
    if isinstance(contact, Stop):
        return ("impact",) * (len(modes) > 1)
    if isinstance(contact, Contact):
        return ()
    hits = "separation" in modes and contact.impact is not None
    smooth = not limits_of_states(contact)
    return ("slip",) * ("slip+" in modes and smooth) + ("impact",) * hits


def _functions(system: LagrangeSystem) -> dict[Any, Any]:
    of_laws = (one for some in system.of_laws for one in some)
    functions = time_functions((*system.q, *system.v, *system.further, *of_laws), len(system.q))
    functions |= {
        one: sympy.diff(functions[x], TIME, 2)
        for one, x in zip(system.accelerations_of_mode, system.q, strict=True)
    }
    if system.phase:
        functions[system.phase[0]] = system.mechanics.frequency * TIME
    functions |= dict.fromkeys(system.time, TIME)
    return functions


def _named_forces(system: LagrangeSystem) -> LagrangeSystem:
    def named(contact: AnyContact, force: Any) -> AnyContact:
        return contact if isinstance(contact, Stop) else replace(contact, normal_force=force)

    contacts = enumerate(system.mechanics.contacts)
    shown = tuple(named(contact, _contact_function(system, "F_N", i)) for i, contact in contacts)
    return replace(system, mechanics=replace(system.mechanics, contacts=shown))


def _mode_equations(
    write: TimeDependentSystem,
    mode: str,
    chosen: Sequence[ContactRegime],
    letters: Mapping[str, str],
    known: Mapping[str, Any],
) -> Equations:
    system, each = write.system, range(len(chosen))
    forces = [_force_function(system, i) for i in each]
    rubbing = [i for i in each if isinstance(system.mechanics.contacts[i], Friction)]
    names = {i: ("F_N", *_components(system, "v_r", i)) for i in rubbing}
    names |= {i: ("F_T", "v_r") for i in each if _rubs_rigidly(system.mechanics.contacts[i])}
    others = [_contact_function(system, name, i) for i, some in names.items() for name in some]
    others += map(write, (*system.q, *system.further, *(one for some in system.of_laws for one in some)))
    return Equations(
        mode,
        motion=(
            *_motion(write, forces),
            *(eq for i in rubbing for eq in _law_rates(write, mode, chosen[i], i)),
        ),
        forces=tuple(eq for i in each for eq in _forces(write, mode, chosen, i)),
        definitions=_definitions(write),
        constraint=tuple(eq for regime in chosen for eq in _constraint(write, regime)),
        conditions=tuple(c for i in each for c in _conditions(write, mode, chosen[i], i)),
        symbols={**known, **{str(f.func): f for one in forces for f in _each(one)}}
        | {str(f.func): f for f in others},
        letters=letters,
    )


def _motion(write: TimeDependentSystem, forces: Sequence[Any]) -> tuple[Any, ...]:
    """Eq. (1): M q'' + forces of energies and dampers = loads + sum of W F; the rates of further states."""
    system = write.system
    second = sympy.Matrix([sympy.diff(write(x), TIME, 2) for x in system.q])
    left = system.mass * second + sympy.Matrix([write(r) for r in system.internal])
    right = sympy.Matrix([write(load) for load in system.loads])
    for i, (contact, force) in enumerate(zip(system.mechanics.contacts, forces, strict=True)):
        right += system.direction(contact) * sympy.Matrix(_each(force))
        right += system.normal(contact) * _contact_function(system, "F_N", i)
        if _rubs_rigidly(contact):
            right += rubbing_direction(system, contact) * _contact_function(system, "F_T", i)
    rates = (
        equation(sympy.diff(write(one), TIME), write(system.mechanics.rates[str(one)]))
        for one in system.further
    )
    return (*map(equation, left.applyfunc(write), right.applyfunc(write)), *rates)


def _forces(
    write: TimeDependentSystem, mode: str, chosen: Sequence[ContactRegime], i: int
) -> tuple[Any, ...]:
    """Eqs. (2) and (3): F_N and F_T of a contact.

    The constraint force is F_T in stick, and F_N at a stop.
    """
    system, force = write.system, _force_function(write.system, i)
    contact = system.mechanics.contacts[i]
    if isinstance(contact, Stop):
        return _forces_of_stop(write, chosen, i, force)
    normal, regime = _contact_function(system, "F_N", i), chosen[i]
    pressed = equation(normal, 0 if regime.name in APART else write(contact.pressing))
    if isinstance(contact, Contact):
        return (pressed,)
    if regime.name.startswith("slip") and not regime.constraints:
        friction = _friction(write, mode, regime, i)
    else:
        friction = tuple(map(write, _each(solve_contact_forces(write.named, chosen).forces[i])))
    return pressed, *map(equation, _each(force), _each(friction))


def _forces_of_stop(
    write: TimeDependentSystem, chosen: Sequence[ContactRegime], i: int, force: Any
) -> tuple[Any, ...]:
    """F_N, and F_T of a rigid contact with friction."""
    system, solved = write.system, solve_contact_forces(write.named, chosen)
    normal = equation(force, write(solved.forces[i]))
    if not _rubs_rigidly(system.mechanics.contacts[i]):
        return (normal,)
    share = chosen[i].share
    friction = solved.friction.get(i, 0) if share is None else share * force
    return normal, equation(_contact_function(system, "F_T", i), write(friction))


def _rubs_rigidly(contact: AnyContact) -> bool:
    return isinstance(contact, Stop) and contact.rubs


def _friction(write: TimeDependentSystem, mode: str, regime: ContactRegime, i: int) -> Any:
    """Eq. (3).  The sign is that of v_r, or of the belt's speed where the interface keeps it fixed."""
    system = write.system
    contact: Any = system.mechanics.contacts[i]
    if contact.in_plane:
        velocities = tuple(_contact_function(system, one, i) for one in _components(system, "v_r", i))
        size = contact.law.kinetic(_contact_function(system, "F_N", i), magnitude(velocities))
        return tuple(size * one / magnitude(velocities) for one in velocities)
    normal, velocity = (_contact_function(system, name, i) for name in ("F_N", "v_r"))
    if contact.law.states:
        return _law_values(write, mode, regime, i).force
    if mode == "slip" and regime.name == "slip+":
        return sympy.sign(velocity) * contact.law.kinetic(normal, sympy.Abs(velocity))
    sign = system.sliding_sign(contact) if regime.name == "slip" else SIGNS[regime.name]
    return sliding_friction(contact, sign, normal, velocity)


def _law_values(write: TimeDependentSystem, mode: str, regime: ContactRegime, i: int) -> LawValues:
    """Force and rates of a dynamic law; with |v_r| where the mode does not tell the sign of v_r."""
    contact: Any = write.system.mechanics.contacts[i]
    normal, velocity = (_contact_function(write.system, name, i) for name in ("F_N", "v_r"))
    arguments = contact.law, normal, velocity, tuple(map(write, write.system.of_laws[i]))
    if mode != "slip" and regime.name in SIGNS:
        return values_on_one_side(*arguments, SIGNS[regime.name])
    return values_of_law(*arguments)


def _law_rates(
    write: TimeDependentSystem, mode: str, regime: ContactRegime, i: int
) -> Iterator[tuple[Any, ...]]:
    """The rates of the states of a contact's friction law."""
    contact: Any = write.system.mechanics.contacts[i]
    states = tuple(map(write, write.system.of_laws[i]))
    if not states:
        return
    if regime.name in APART or limits_of_states(contact):
        rates = tuple(map(write, regime.rates))
    else:
        rates = _law_values(write, mode, regime, i).rates
    for one, rate in zip(states, rates, strict=True):
        yield equation(sympy.diff(one, TIME), rate)


def _definitions(write: TimeDependentSystem) -> tuple[Any, ...]:
    contacts = enumerate(write.system.mechanics.contacts)
    rows: list[tuple[int, str, Any]] = []
    for i, contact in contacts:
        if isinstance(contact, Friction):
            names = _components(write.system, "v_r", i)
            rows += [(i, *row) for row in zip(names, contact.velocities, strict=True)]
        elif isinstance(contact, Stop) and contact.rubs:
            rows.append((i, "v_r", contact.relative_velocity))
    return tuple(equation(_contact_function(write.system, name, i), write(v)) for i, name, v in rows)


def _constraint(write: TimeDependentSystem, regime: ContactRegime) -> tuple[Any, ...]:
    if regime.by_holding is not None:
        return ()
    pair = write.system.pair(regime.held[0].velocity) if regime.held else None
    if pair is None or len(regime.constraints) > 1:
        return tuple(equation(write(c), 0) for c in regime.constraints)
    return _together(write, pair)


def _together(write: TimeDependentSystem, pair: Pair) -> tuple[Any, ...]:
    """Eq. (5): how the second body's coordinate follows from the first one's after the onset t_s of stick."""
    one, two = (write(write.system.q[i]) for i in (pair.first, pair.second))
    onset = symbol("t_s")
    travelled = one - one.subs(TIME, onset) - pair.speed * (TIME - onset)
    return (
        equation(sympy.diff(two, TIME), sympy.diff(one, TIME) - pair.speed),
        equation(sympy.diff(two, TIME, 2), sympy.diff(one, TIME, 2)),
        equation(two, travelled + two.subs(TIME, onset)),
    )


def _conditions(write: TimeDependentSystem, mode: str, regime: ContactRegime, i: int) -> tuple[Any, ...]:
    """What holds while the regime lasts: Eqs. (4), (8) and (9)."""
    system, contact = write.system, write.system.mechanics.contacts[i]
    if isinstance(contact, Stop):
        return _conditions_of_stop(write, regime, contact, i)
    if regime.name in APART:
        return _apart(write, regime, contact)
    normal, velocity = (_contact_function(system, name, i) for name in ("F_N", "v_r"))
    pressed = (sympy.Gt(normal, 0, evaluate=False),) if "separation" in contact.modes else ()
    if isinstance(contact, Contact):
        return pressed
    if contact.in_plane:
        return (*_conditions_in_plane(system, regime, i), *pressed)
    if limits := limits_of_law(contact.law, normal):
        pairs, held = zip(system.of_laws[i], limits, strict=True), sympy.Tuple(*regime.constraints)
        sticks = ((write(state), limit) for state, limit in pairs if not held.has(state))
        return (*(sympy.Le(sympy.Abs(state), limit, evaluate=False) for state, limit in sticks), *pressed)
    if regime.name == "stick":
        limit = contact.law.static_limit(normal)
        return (sympy.Le(sympy.Abs(_force_function(system, i)), limit, evaluate=False), *pressed)
    if regime.name == "slip" or regime.constraints:
        return pressed
    signs = {"slip": sympy.Ne, "slip+": sympy.Gt, "slip-": sympy.Lt}
    return (signs["slip" if mode == "slip" else regime.name](velocity, 0, evaluate=False), *pressed)


def _conditions_in_plane(system: LagrangeSystem, regime: ContactRegime, i: int) -> tuple[Any, ...]:
    """A holding force within its circle in stick, a speed in slip."""
    contact: Any = system.mechanics.contacts[i]
    if regime.name == "stick":
        limit = contact.law.static_limit(_contact_function(system, "F_N", i))
        return (sympy.Le(magnitude(_each(_force_function(system, i))), limit, evaluate=False),)
    velocities = [_contact_function(system, one, i) for one in _components(system, "v_r", i)]
    return (sympy.Gt(magnitude(velocities), 0, evaluate=False),)


def _conditions_of_stop(
    write: TimeDependentSystem, regime: ContactRegime, contact: Stop, i: int
) -> tuple[Any, ...]:
    """A distance above zero in flight, else a force that pushes, friction in its cone, v_r of its sign."""
    if regime.name == "flight":
        return (sympy.Gt(write(contact.distance), 0, evaluate=False),)
    normal, friction, speed = (_contact_function(write.system, name, i) for name in ("F_N", "F_T", "v_r"))
    pushes = sympy.Gt(normal, 0, evaluate=False)
    if regime.name == "stick" and contact.friction is not None:
        limit = contact.friction.static_limit(normal)
        return sympy.Le(sympy.Abs(friction), limit, evaluate=False), pushes
    if regime.sliding is not None:
        return (sympy.Gt if SIGNS[regime.name] > 0 else sympy.Lt)(speed, 0, evaluate=False), pushes
    return (pushes,)


def _apart(write: TimeDependentSystem, regime: ContactRegime, contact: Friction | Contact) -> tuple[Any, ...]:
    """What holds while there are no contact forces: a gap, or a law that would pull."""
    if regime.name == "separation" and contact.penetration is not None:
        return (sympy.Lt(write(contact.penetration), 0, evaluate=False),)
    pulls = sympy.Lt(write(contact.pressing), 0, evaluate=False)
    if contact.penetration is None:
        return (pulls,)
    return (pulls, sympy.Gt(write(contact.penetration), 0, evaluate=False))


def _impact(copy: Any, system: LagrangeSystem, letters: Mapping[str, str]) -> Equations:
    contact = system.mechanics.contacts[0]
    if isinstance(contact, Stop):
        rate = in_time_functions(system.rate(contact.distance), _functions(system))
        return Equations("impact", impact=stop_equations(contact, rate), letters=letters)
    impact, symbols = impact_equations(copy)
    return Equations(
        "impact", impact=impact, symbols=symbols, letters={**letters, **impact_letters(copy, letters)}
    )


def _force_function(system: LagrangeSystem, i: int) -> Any:
    """F_T of a contact with friction, in the plane its components; F_N of one without."""
    if not isinstance(system.mechanics.contacts[i], Friction):
        return _contact_function(system, "F_N", i)
    shown = [_contact_function(system, one, i) for one in _components(system, "F_T", i)]
    return tuple(shown) if len(shown) > 1 else shown[0]


def _components(system: LagrangeSystem, name: str, i: int) -> tuple[str, ...]:
    """The names of the components of F_T or v_r of a contact."""
    in_plane = system.mechanics.contacts[i].in_plane
    return tuple(name + one for one in DIRECTIONS) if in_plane else (name,)


def _each(force: Any) -> tuple[Any, ...]:
    return force if isinstance(force, tuple) else (force,)


def _contact_function(system: LagrangeSystem, name: str, i: int) -> Any:
    return sympy.Function(name + contact_suffix(system, i), real=True)(TIME)


def _contact_letters(system: LagrangeSystem) -> dict[str, str]:
    """LaTeX of F_N, F_T and v_r of numbered contacts, and of the rates before and after an impact."""
    letters = {"rate-": r"\dot{d}^{-}", "rate+": r"\dot{d}^{+}"}
    for i in range(len(system.mechanics.contacts)):
        for name, letter in (("F_N", r"\mathrm{N}"), ("F_T", r"\mathrm{T}"), ("v_r", r"\mathrm{r}")):
            if contact_suffix(system, i):
                letters[name + contact_suffix(system, i)] = rf"{name[0]}_{{{letter},{i + 1}}}"
            for one in DIRECTIONS if system.mechanics.contacts[i].in_plane and name != "F_N" else ():
                where = f"{one},{i + 1}" if contact_suffix(system, i) else one
                letters[name + one + contact_suffix(system, i)] = rf"{name[0]}_{{{letter},{where}}}"
    return letters
