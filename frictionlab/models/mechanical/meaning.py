"""Whether what a model states is a mechanical system: energies of the right variables, and masses.

It is checked once for a structure, in symbols: T has degree 2 in the velocities, V has none of them, v_r is
linear in them, no parameter is the exponent of what can be negative, and all symbols are known.  Whether T is
positive depends on the values of the parameters (:mod:`frictionlab.models.mechanical.masses`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import sympy

from frictionlab.automaton.expressions import integer_exponent, multiply_out, real_power_cure
from frictionlab.components.component import Component, expressions_of
from frictionlab.models.symbolic_laws import with_explained_errors
from frictionlab.models.symbols import expand_products, gradient, symbol
from frictionlab.presentation import PHASE, TIME
from frictionlab.validation import abbreviate, did_you_mean_or_known

from .dynamic_laws import check_elastic, limits_of_states, rates_in_separation, values_of_law
from .friction_in_plane import check_directions, check_plane
from .massless_motions import LEAST_SHARE, SEED, motion_without_energy
from .mechanics import AnyContact, Contact, Friction, Mechanics, Stop

if TYPE_CHECKING:
    from frictionlab.models.mechanical.mechanical_model import MechanicalModel

NO_VALUES = sympy.nan, sympy.zoo, sympy.oo, -sympy.oo, sympy.I


def check_mechanics(
    about: Any, model: MechanicalModel, q: Sequence[Any], v: Sequence[Any], laws: Sequence[Component]
) -> Mechanics:
    """The energies, loads and contacts that a model states, as expressions; `laws` are those made of such.

    Raises
    ------
    TypeError, ValueError
        Where they are no mechanical system.
    """
    of = type(model).__name__
    if not isinstance(about, Mechanics):
        cure = "write return in front" if about is None else "write return fl.Mechanics(kinetic, potential)"
        raise TypeError(f"mechanics of {of} must return a Mechanics, got {abbreviate(about)}: {cure}")
    about = replace(about, contacts=tuple(map(with_explained_errors, about.contacts)))
    for name in about.loads:
        if name not in model.coordinates:
            hint = did_you_mean_or_known(name, model.coordinates)
            raise ValueError(f"loads of {of} must be on its coordinates, got one on {name!r}{hint}")
    if {*about.rates} != {*model.states}:
        raise ValueError(
            f"rates of {of} must be those of its states {', '.join(model.states) or '(it has none)'}, got "
            f"{', '.join(about.rates) or 'none'}: write states = (...) in the class, and a rate for each"
        )
    check = _Check(of, model, about.frequency is not None, q, v)
    check.expression("frequency", about.frequency, ())
    for law in laws:
        for name, given in expressions_of(law).items():
            check.expression(f"{name} of the {type(law).__name__}", given)
    stored = "what a further state does to a body is a load"
    check.free("kinetic", about.kinetic, check.further, stored)
    potential = about.potential if isinstance(about.potential, Mapping) else {"potential": about.potential}
    for name, energy in potential.items():
        check.free(f"the energy {name!r}", energy, v, "a force that depends on velocities is a load")
        check.free(f"the energy {name!r}", energy, check.further, stored)
    for name, rate in about.rates.items():
        check.free(f"the rate of {name!r}", rate, (), "")
    check.expression("dissipation", about.dissipation)
    if about.dissipation != 0 and not any(gradient(about.dissipation, v)):
        raise ValueError(
            f"dissipation of {of} must be a function of the velocities, got {about.dissipation}: write "
            "c * v.x**2 / 2, half the power that the damper takes"
        )
    for name, load in about.loads.items():
        check.expression(f"the load on {name!r}", load)
    check.names_of_law_states(about.law_states)
    for contact, names in zip(about.contacts, about.law_states, strict=True):
        check.contact(contact)
        if isinstance(contact, Friction):
            check.law(contact, tuple(map(symbol, names)))
    forces = {f"the load on {name!r}": load for name, load in about.loads.items()}
    energies = {f"the energy {name!r}": energy for name, energy in potential.items()}
    others = {"kinetic": about.kinetic, "dissipation": about.dissipation}
    distances = [contact.distance for contact in about.contacts if isinstance(contact, Stop)]
    for what, given in (others | energies | forces).items():
        check.powers(what, given, distances)
    return about


class _Check:
    """Checks of the expressions of one model."""

    def __init__(
        self, of: str, model: MechanicalModel, in_time: bool, q: Sequence[Any], v: Sequence[Any]
    ) -> None:
        self.of, self.q, self.v, self.interface = of, q, v, model.interface
        self.names, self.further = model.structure_key.parameters, tuple(map(symbol, model.states))
        self.states = {*q, *v, *self.further, *([symbol(PHASE)] if in_time else []), symbol(TIME)}
        self.moving = (*v, *self.further)

    def expression(self, what: str, given: Any, states: Any = None) -> Any:
        """The expression that is given, with symbols of the parameters and of `states`, by default all."""
        if given is None:
            return None
        try:
            expr = sympy.sympify(given, strict=True)
        except (sympy.SympifyError, TypeError, ValueError):
            expr = None
        if not isinstance(expr, sympy.Expr):
            raise TypeError(
                f"{what} of {self.of} must be an expression of the coordinates q, the velocities v and the "
                f"parameters, got {abbreviate(given)}"
            )
        if expr.has(*NO_VALUES):
            raise ValueError(f"{what} of {self.of} must be finite and real, got {abbreviate(expr)}")
        known = {*map(symbol, self.names), *(self.states if states is None else states)}
        if unknown := sorted(expr.free_symbols - known, key=str):
            raise ValueError(f"{what} of {self.of} must not depend on {unknown[0]}: {self._cure(unknown[0])}")
        return expr

    def _cure(self, unknown: Any) -> str:
        if unknown in self.states:
            return "it is one number, given by parameters alone"
        if unknown == symbol(PHASE):
            return "give Mechanics the frequency too, which is the rate of q.phase"
        return (
            "it is no coordinate, no velocity and no parameter; make it a field by fl.parameter(...), and "
            f"write self.{unknown}"
        )

    def free(self, what: str, given: Any, of: Sequence[Any], cure: str) -> Any:
        """An expression without the symbols `of`."""
        expr = self.expression(what, given)
        if expr is None:
            raise TypeError(f"{what} of {self.of} must be an expression, got None: write 0 for none")
        if wrong := sorted(expr.free_symbols & {*of}, key=str):
            raise ValueError(
                f"{what} of {self.of} must not depend on {wrong[0]}, got {abbreviate(expr)}: {cure}"
            )
        return expr

    def powers(self, what: str, given: Any, positive: Sequence[Any], of_law: Sequence[Any] = ()) -> None:
        """That no parameter is the exponent of a base that can be negative.

        What is in `positive` is not; parameters count as positive, as their values are not known here.  The
        states `of_law`, a friction law, may have either sign.
        """
        vary = self.states.union(of_law, *(one.free_symbols for one in positive))
        for power in sympy.sympify(given, strict=True).atoms(sympy.Pow):
            base, exponent = power.base, power.exp
            by_parameter = integer_exponent(power) is None and exponent.free_symbols
            if not by_parameter or vary.isdisjoint(base.free_symbols):
                continue
            known = {symbol(name): sympy.Dummy(positive=True) for name in self.names}
            shown = [(one, sympy.Dummy(nonnegative=True)) for one in positive]
            if not base.subs(shown).xreplace(known).is_nonnegative:
                raise ValueError(
                    f"{what} of {self.of} must not have the parameter {exponent} as exponent of {base}, "
                    f"which can be negative: {real_power_cure(base, exponent)}"
                )

    def contact(self, contact: AnyContact) -> None:
        """The expressions of a contact."""
        place = "where bodies touch depends on coordinates and time only"
        if isinstance(contact, Stop):
            distance = self.free("distance of a Stop", contact.distance, self.moving, place)
            if not any(gradient(distance, self.q)):
                raise ValueError(
                    f"distance of a Stop of {self.of} must depend on a coordinate, got {distance}: write it "
                    "with the coordinates q, as in self.d - q.x"
                )
            self.friction_of_stop(contact)
            if contact.rubs:
                self.relative_velocity(contact)
            return
        if isinstance(contact, Friction):
            self.relative_velocity(contact)
        self.damper(contact)
        if callable(contact.normal_force) and contact.penetration is None:
            raise TypeError(
                f"normal_force of {self.of} must be an expression, got a function: a contact without a "
                "penetration has nothing to give to it"
            )
        if not callable(contact.normal_force):
            self.free("normal_force", contact.normal_force, (), "")
            pressed = [] if contact.penetration is None else [contact.penetration]
            self.powers("normal_force", contact.normal_force, pressed)
        if contact.penetration is not None:
            self.free("penetration", contact.penetration, self.moving, place)
        if contact.normal is not None:
            for one in contact.normal:
                self.free("normal", one, self.moving, place)
            if len(contact.normal) != len(self.q):
                raise ValueError(
                    f"normal of {self.of} must have one entry for each of its {len(self.q)} coordinates, got "
                    f"{len(contact.normal)}"
                )

    def damper(self, contact: Friction | Contact) -> None:
        """The penetration of a contact that needs one, and its damper."""
        if contact.penetration is None:
            if isinstance(contact, Friction) and not callable(contact.damper) and contact.damper == 0:
                return
            kind = type(contact).__name__
            raise TypeError(
                f"penetration of a {kind} of {self.of} must be an expression, got None: a normal force that "
                "does no work has no effect without friction, nor has a damper without a penetration"
            )
        if contact.damping.is_negative if hasattr(contact.damping, "is_negative") else contact.damping < 0:
            raise ValueError(
                f"damper of a {type(contact).__name__} of {self.of} must be at least 0, got "
                f"{contact.damping}: below 0 each impact would add energy, without end; give one that a "
                "value sets fl.parameter(..., minimum=0.0)"
            )
        self.free("damper", contact.damping, (*self.v,), "it is N s/m, which multiplies the rate by itself")
        self.powers("damper", contact.damping, [contact.penetration])

    def relative_velocity(self, contact: Friction | Stop) -> None:
        """That v_r depends on velocities, and linearly."""
        if isinstance(contact, Friction) and contact.in_plane:
            for component in check_plane(contact, self.of, self.interface):
                self.component(component)
            check_directions(contact, self.of, self.v)
            return
        if isinstance(contact.relative_velocity, (tuple, list)):
            raise ValueError(
                f"relative_velocity of a Stop of {self.of} must be one expression, got "
                f"{len(contact.relative_velocity)}: friction in the plane needs a contact with a stiffness, "
                "as in Friction((v_a, v_b), self.contact.force, law, penetration=...)"
            )
        self.component(contact.relative_velocity)

    def component(self, relative_velocity: Any) -> None:
        """That one component of v_r depends on velocities, and linearly."""
        speed = self.free("relative_velocity", relative_velocity, (), "")
        if not any(gradient(speed, self.v)):
            raise ValueError(
                f"relative_velocity of {self.of} must depend on the velocities, got {abbreviate(speed)}: "
                "write it with the velocities v, as in self.v - v.x"
            )
        if any({*one.free_symbols} & {*self.moving} for one in map(multiply_out, gradient(speed, self.v))):
            raise ValueError(
                f"relative_velocity of {self.of} must be linear in the velocities, got {abbreviate(speed)}: "
                "its gradient by them is the direction of the friction force; a function of it belongs into "
                "the friction law"
            )

    def friction_of_stop(self, contact: Stop) -> None:
        """That a rigid contact has both friction and v_r or neither, and friction in proportion to F_N."""
        if (contact.friction is None) != (contact.relative_velocity is None):
            missing = "friction" if contact.friction is None else "relative_velocity"
            raise ValueError(
                f"a Stop of {self.of} must have both friction and relative_velocity or neither, got no "
                f"{missing}: write Stop(..., friction=self.friction, relative_velocity=self.v - v.x)"
            )
        law, force = contact.friction, sympy.Symbol("normal_force", nonnegative=True)
        if law is None:
            return
        cure = "give the contact a stiffness, as in Friction(v_r, self.contact.force, law, penetration=...)"
        if law.states:
            got = type(law).__name__
            raise ValueError(f"friction of a Stop of {self.of} must have no states, got {got}: {cure}")
        speed = sympy.Symbol("speed", nonnegative=True)
        for given, one in (
            (law.kinetic(force, speed), law.kinetic(sympy.S.One, speed)),
            (law.static_limit(force), law.static_limit(sympy.S.One)),
        ):
            if expand_products(given - force * one) != 0:
                raise ValueError(
                    f"friction of a Stop of {self.of} must be F_N times a coefficient, got {given}: write it "
                    f"so, or {cure}"
                )
            self.powers("the friction law", one, [speed])

    def law(self, contact: Friction, states: tuple[Any, ...]) -> None:
        """That a friction law has formulas, of bases with a sign where exponents are parameters."""
        force, sliding = sympy.symbols("normal_force speed", nonnegative=True)
        if not states:
            self.powers("the friction law", contact.law.kinetic(force, sliding), [force, sliding])
            return
        limits = limits_of_states(contact)
        if wrong := [limit for limit in limits if any(gradient(limit, self.v))]:
            raise ValueError(
                f"{type(contact.law).__name__} in {self.of} must have a state_limit that does not depend on "
                f"velocities, got {abbreviate(wrong[0])}: give a normal force without a damper"
            )
        if limits:
            check_elastic(contact.law, states)
        for sign in (1, -1):
            values = values_of_law(contact.law, force, sign * sliding, states)
            for given in (values.force, *values.rates, *rates_in_separation(contact, states)):
                self.powers("the friction law", given, [force, sliding], states)

    def names_of_law_states(self, of_laws: Sequence[Sequence[str]]) -> None:
        """Refuse a state of a friction law that has the name of anything else."""
        taken = {*self.names, *map(str, self.states)}
        for name in (one for some in of_laws for one in some):
            if name in taken:
                raise ValueError(
                    f"the state {name!r} of a friction law must differ from the coordinates, states and "
                    f"parameters of {self.of}: rename these, or derive a class from the law with another "
                    "name in its states"
                )
            taken.add(name)


def mass_matrix(
    about: Mechanics, model: MechanicalModel, v: Sequence[Any]
) -> tuple[Mechanics, list[Any], Any]:
    """What is stated, with T as sympy needs it; the momenta dT/dv; and the masses, their derivatives by v.

    Raises
    ------
    ValueError
        Where T is not of degree 2 in the velocities, or a coordinate has no mass.
    """
    momenta, mass = _masses(about.kinetic, v)
    if mass.free_symbols & {*v}:  # perhaps they cancel
        about = replace(about, kinetic=multiply_out(about.kinetic))
        momenta, mass = _masses(about.kinetic, v)
    if wrong := sorted(mass.free_symbols & {*v}, key=str):
        raise ValueError(
            f"kinetic of {type(model).__name__} must be of degree 2 at most in the velocities, got "
            f"{abbreviate(about.kinetic)}: its second derivatives, the masses, depend on {wrong[0]}"
        )
    without = [i for i in range(len(v)) if mass[i, :].is_zero_matrix]
    without = without or _structurally_without(mass)
    if without:
        raise ValueError(_no_mass(model, without))
    return about, momenta, mass


def _masses(kinetic: Any, v: Sequence[Any]) -> tuple[list[Any], Any]:
    momenta = gradient(kinetic, v)
    return momenta, sympy.Matrix([gradient(momentum, v) for momentum in momenta])


def _no_mass(model: MechanicalModel, without: Sequence[int]) -> str:
    names = [model.coordinates[i] for i in without]
    some = " and ".join(map(repr, names))
    what = f"the coordinate {some} has none" if len(names) == 1 else f"a motion of {some} together has none"
    return (
        f"kinetic of {type(model).__name__} must give each coordinate a mass, and {what}: add its energy, as "
        f"in self.m * v.{names[0]}**2 / 2, or leave out the coordinate, which follows from the others"
    )


def _structurally_without(mass: Any) -> list[int]:
    """The coordinates of a motion that has no energy whatever values parameters and states have; or []."""
    if mass.is_diagonal():
        return []
    some = sorted(mass.free_symbols, key=str)
    rng = np.random.default_rng(SEED)
    motions = []
    for _ in range(2):  # twice, as a single choice may be a singular one
        values = {x: sympy.Float(value) for x, value in zip(some, rng.uniform(0.5, 1.5, len(some)))}
        at = np.zeros(mass.shape)
        for place, entry in mass.todok().items():
            at[place] = float(entry.xreplace(values))
        motions.append(motion_without_energy(at, -LEAST_SHARE * len(at)))
    return motions[0] if all(motions) else []


def check_linear(about: Mechanics, model: MechanicalModel, q: Sequence[Any], v: Sequence[Any]) -> None:
    """Raise ValueError unless all but the contact is linear, and constant in time, as `statics` needs."""
    parameters = {*map(symbol, model.structure_key.parameters)}
    fixed = {*q, *v, symbol(PHASE), symbol(TIME), *map(symbol, model.states)}
    still = dict.fromkeys(v, sympy.S.Zero)
    momenta = gradient(about.kinetic, v)
    others = [one.xreplace(still) for one in (sympy.sympify(about.kinetic, strict=True), *momenta)]
    checks = {
        "kinetic": [*(one for p in momenta for one in gradient(p, (*q, symbol(PHASE)))), *others],
        "frequency": [] if about.frequency is None else [symbol(PHASE)],
        "q.t": [symbol(TIME)] if symbol(TIME) not in parameters and about.depends_on(symbol(TIME)) else [],
        "rates": [*map(symbol, model.states)],
    }
    curved = {"potential": (about.stored, q), "dissipation": (about.dissipation, v)}
    for name, (energy, x) in curved.items():
        second = (entry for slope in gradient(energy, x) for entry in gradient(slope, x))
        checks[name] = [one for one in second if one.free_symbols & fixed]
    for name, terms in checks.items():
        if any(term != 0 for term in terms):
            raise ValueError(
                f"{name} of {type(model).__name__} does not go with statics: SlidingStatics needs energies "
                "that are quadratic, with constant masses, springs and dampers, and nothing that depends on "
                "time; leave out statics, and equilibria are found by Newton's method"
            )
