"""Checks of any law and any model, your own included.

>>> import frictionlab as fl
>>> fl.testing.check_law(fl.HertzContact())
>>> run = fl.testing.check_model(fl.SliderOnBelt(friction=fl.Stribeck()), t_end=0.1)

`check_law` checks a law by itself: its forces have the right signs; it gives the same values for numbers,
arrays and symbols; its parameters have a meaning and a range; its repr and its dictionary make it again.
`check_model` checks a model's parameters, its equations, and a motion, which must keep the rules of friction
and unilateral contact, and Lagrange's equations by differences of the energies in numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from enum import Enum
from types import SimpleNamespace
from typing import Any

import numpy as np
import sympy as sp

from frictionlab.analysis.simulate import simulate
from frictionlab.analysis.stated_conditions import broken_statement
from frictionlab.components import ContactLaw, FrictionLaw, ImpactLaw
from frictionlab.components.component import Component, Parameter, parameters_of, structure_of
from frictionlab.hybrid.tape.packing import program_of
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.models import MechanicalModel
from frictionlab.models.composition import parameter_metadata
from frictionlab.models.mechanical.mechanics import Mechanics, Stop
from frictionlab.models.model import Model, require_model
from frictionlab.models.serialisation import component_from_dict, component_to_dict
from frictionlab.models.symbols import structure_of_component, symbol, symbolic_copy
from frictionlab.validation import abbreviate, check_number

__all__ = ["check_law", "check_model"]

PENETRATIONS = np.linspace(1e-4, 0.1, 7)
SPEEDS = np.linspace(0.0, 3.0, 7)
FORCES = np.array([1.0, 50.0, 1e3])
LAW_RTOL = 1e-12


def fail(subject: Any, rule: str, got: Any) -> None:
    """Raise AssertionError with what is checked, the rule, and what there is instead."""
    raise AssertionError(f"{subject!r}: {rule}, got {abbreviate(got)}")


def check_parameters(subject: Component, known: Mapping[str, Parameter]) -> None:
    """Fail unless every parameter has a meaning and a range that holds its default."""
    for name, about in known.items():
        if not about.meaning:
            fail(subject, f"parameter {name} must have a meaning: write parameter(..., meaning=...)", "")
        if about.range is None:
            fail(subject, f"parameter {name} must have a range for its slider", None)
        low, high = about.range or (0.0, 0.0)
        if about.default is not None and not low <= about.default <= high:
            fail(subject, f"the range of {name} must hold its default", (about.range, about.default))


def check_round_trip(subject: Component) -> None:
    """Fail unless the repr, as an expression, and the dictionary each make the object again."""
    names, text = _class_names(subject), repr(subject)
    for kind in names.values():  # that of a class in a function or a class, as dataclasses write it
        text = text.replace(kind.__qualname__, kind.__name__)
    try:
        again = eval(text, names)
    except Exception as error:
        again = f"{text}, which fails with {type(error).__name__}: {error}"
    if again != subject:
        fail(subject, "its repr must make it again", again)
    again = component_from_dict(component_to_dict(subject), type(subject))
    if again != subject or hash(again) != hash(subject):
        fail(subject, "its dictionary must make it again", again)


def _class_names(subject: Component) -> dict[str, type]:
    """The classes that a repr may name."""
    found: dict[str, type] = {type(subject).__name__: type(subject)}
    waiting = [getattr(subject, name) for name in structure_of(type(subject))]
    while waiting:
        value = waiting.pop()
        if isinstance(value, tuple):
            waiting += value
        elif isinstance(value, Component):
            found |= _class_names(value)
        elif isinstance(value, Enum):
            found[type(value).__name__] = type(value)
    return found


def check_law(law: Component) -> None:
    """Check a contact, friction or impact law.

    Its parameters are described, its repr makes it again, its methods give for symbols what they give for
    numbers and arrays, and the forces have the signs that the modes of contact rely on.

    Parameters
    ----------
    law : ContactLaw, FrictionLaw or ImpactLaw

    Raises
    ------
    AssertionError
        With the rule that the law breaks, and what it gives instead.
    TypeError
        For anything else than such a law.
    """
    kind = next((kind for kind in LAW_CHECKS if isinstance(law, kind)), None)
    if kind is None:
        raise TypeError(f"law must be a ContactLaw, FrictionLaw or ImpactLaw, got {abbreviate(law)}")
    check_parameters(law, parameters_of(type(law)))
    check_round_trip(law)
    LAW_CHECKS[kind](law)


def _check_contact(law: Any) -> None:
    force = _consistent_values(law, "force", PENETRATIONS)
    if not (force >= 0.0).all():
        fail(law, "force(penetration) must not be negative where the bodies press on each other", force)


def _check_friction(law: Any) -> None:
    speed, normal = map(np.ravel, np.meshgrid(SPEEDS, FORCES))
    kinetic, limit = (
        _consistent_values(law, "kinetic", normal, speed),
        _consistent_values(law, "static_limit", normal),
    )
    if not (kinetic >= 0.0).all():
        fail(law, "kinetic(normal_force, speed) must not be negative, its direction is the mode's", kinetic)
    slow = speed == 0.0
    if not (kinetic[slow] <= limit[slow] * (1 + LAW_RTOL)).all():
        fail(law, "kinetic(normal_force, 0) must not exceed static_limit(normal_force)", kinetic[slow])


def _check_impact(law: Any) -> None:
    rate, compliance = map(np.ravel, np.meshgrid(SPEEDS, [0.5, 2.0]))
    impulse = _consistent_values(law, "impulse", rate, rate, compliance)
    after = rate - compliance * impulse
    if not (impulse >= 0.0).all():
        fail(law, "impulse(...) must not be negative: bodies do not pull on each other", impulse)
    if not ((after <= LAW_RTOL) & (after >= -rate - LAW_RTOL)).all():
        fail(law, "the gap rate after an impact must be from -1 times that before to 0", after)


def _consistent_values(law: Any, method: str, *arguments: Any) -> Any:
    """A method's values at arrays; fails unless symbols and single numbers give the same values."""
    values = np.broadcast_to(getattr(law, method)(*arguments), arguments[0].shape)
    symbols = [sp.Symbol(f"argument{i}", real=True) for i in range(len(arguments))]
    reduced = law.reduced()
    numbers = {symbol(name): getattr(reduced, name) for name in parameters_of(type(reduced))}
    formula: Any = sp.sympify(
        getattr(symbolic_copy(structure_of_component(law)), method)(*symbols), strict=True
    ).subs(numbers)
    for i, row in enumerate(zip(*arguments, strict=True)):
        at = tuple(map(float, row))
        exact = _real(law, method, at, formula.subs(dict(zip(symbols, at, strict=True))))
        single = _real(law, method, at, getattr(law, method)(*at))
        if not np.allclose([values[i], single], exact, rtol=LAW_RTOL, atol=0.0):
            rule = f"{method} must give the same for symbols ({exact}), numbers and arrays at {row}"
            fail(law, rule, (single, values[i]))
    return values


def _real(law: Any, method: str, at: tuple[float, ...], value: Any) -> float:
    """The value as a number; fails for a complex one, as of a root of a negative number."""
    try:
        return float(value)
    except TypeError:
        fail(law, f"{method} must give a real number at {at}", value)
        raise


LAW_CHECKS: dict[type, Callable[[Any], None]] = {
    ContactLaw: _check_contact,
    FrictionLaw: _check_friction,
    ImpactLaw: _check_impact,
}


COMPARISON_TIME = 0.02  # s, of the comparison with another integrator
COMPARISON_METHOD, COMPARISON_RTOL = "DOP853", 1e-7
PARAMETER_FACTOR = 1.0 + 2.0**-20  # by which a parameter's value is changed

STEPS_PER_MODE = 4  # in which Lagrange's equations are checked, for as many coordinates at most as
MOST_COORDINATES, COORDINATE_SEED = 6, 8
LAGRANGE_RTOL = 1e-6
DIFFERENCE_SHARE = 1e-2  # of the largest value of a state, by which it is changed for a difference
ROUNDING = 1e-14  # of a momentum, or a time, in a difference
STEP_SHARE = 1.0 / 9.0  # of a step, between the points of a difference by time
CENTRAL_WEIGHTS = 4 / 5, -1 / 5, 4 / 105, -1 / 280

SAMPLE_COUNT = 400
SLIP_SIGNS = {"slip+": 1.0, "slip-": -1.0}
MAX_VIOLATION = 1e-9
CONTACT_OUTPUTS = ("penetration", "normal_force", "friction_force", "relative_velocity")


def check_model(model: Model, t_end: float = 1.0) -> Trajectory:
    """Check a model together with its laws.

    Its parameters are described; its repr makes it again; every mode's equations print; another value of a
    parameter changes no structure, so that a slider compiles nothing; a motion from rest keeps the rules of
    contact and friction, agrees with that of another integrator, and keeps Lagrange's equations with the
    energies that the model states, whose derivatives are then differences of numbers; its contacts do not
    pull, hold no more than they can and no less, and their impacts keep momentum, energy and law.

    Parameters
    ----------
    model : Model
    t_end : float
        Length of the motion, s.

    Returns
    -------
    Trajectory
        The motion.

    Raises
    ------
    AssertionError
        With the rule that the model breaks, and what there is instead.
    """
    require_model(model)
    t_end = check_number("t_end", t_end, above=0.0, cure="give the length of the run in seconds")
    check_parameters(model, parameter_metadata(type(model), model.components))
    check_round_trip(model)
    _check_equations(model)
    _check_structure(model)
    run = simulate(model, t_end, progress=False)
    check_run(model, run)
    _check_agreement(model, min(t_end, COMPARISON_TIME))
    if isinstance(model, MechanicalModel):
        check_lagrange(model, run)
        if broken := broken_statement(run):
            fail(model, "a motion must be one of the energies and contacts that the model states", broken)
    return run


def check_run(model: Any, run: Trajectory) -> None:
    """Raise AssertionError unless a run came to its end and kept the rules of contact and friction."""

    if not run.status.ok:
        fail(model, f"a motion of {run.t[-1]:g} s must come to its end", run.status)
    if broken := rule_violations(run):
        fail(model, "a motion must keep the rules of contact and friction", broken)


def _check_equations(model: Any) -> None:
    for mode in model.automaton().names:
        try:
            found = model.equations(mode)
        except ValueError:  # a limit mode has no equations to print
            continue
        if not len(found) or "\\" not in found.latex() or not repr(found):
            fail(model, f"equations({mode!r}) must print, also in LaTeX", found)


def _check_structure(model: Any) -> None:
    program = program_of(model.automaton())[0]
    for name, value in model.parameters.items():
        if not value or name not in {*parameters_of(type(model)), *_component_parameters(model)}:
            continue
        try:
            other = model.replace(**{name: value * PARAMETER_FACTOR})
        except ValueError:  # a rule forbids it, as mu_k above mu_s
            other = model.replace(**{name: value / PARAMETER_FACTOR})
        if program_of(other.automaton())[0] is not program:
            fail(model, f"the value of {name} must change numbers only", "another structure")


def _component_parameters(model: Any) -> set[str]:
    return {name for part in model.components.values() for name in parameters_of(type(part))}


def _check_agreement(model: Any, t_end: float) -> None:
    own = simulate(model, t_end, progress=False).final_state
    other = simulate(model, t_end, method=COMPARISON_METHOD, progress=False).final_state
    error = np.abs(own - other).max() / (np.abs(own).max() or 1.0)
    if not error <= COMPARISON_RTOL:
        fail(
            model,
            f"its motion must be that of {COMPARISON_METHOD} but for a share of {COMPARISON_RTOL:g}",
            error,
        )


def check_lagrange(model: MechanicalModel, run: Trajectory) -> None:
    """Raise AssertionError unless a run keeps Lagrange's equations with the energies that the model states.

    In the middle of the longest steps of each mode d/dt (dT/dv) - dT/dq + dV/dq + dD/dv is compared with
    the loads and the forces of the contacts.  All derivatives are differences of numbers, that by time along
    the run, so that nothing of the derivation by symbols is used.
    """
    balance = _LagrangeBalance(model, run)
    begins, lengths = run.raw.step_times.T
    middles, n = begins + lengths / 2, len(model.coordinates)
    coordinates = np.random.default_rng(COORDINATE_SEED).permutation(n)[:MOST_COORDINATES]
    places = [(k, i) for k in _longest_steps(run.modes_at(middles), lengths) for i in coordinates]
    each = [balance.terms(middles[k], lengths[k], i) for k, i in places]
    terms = np.array([terms for terms, _ in each]).reshape(-1, len(coordinates), balance.count)
    rooms = np.array([room for _, room in each]).reshape(terms.shape[:2])
    sizes = np.abs(terms).sum(axis=2).max(axis=0, initial=0.0)
    misses = np.maximum(np.abs(terms.sum(axis=2)) - rooms, 0.0)
    shares = misses / np.where(sizes > 0, sizes, 1.0)
    if not shares.max(initial=0.0) <= LAGRANGE_RTOL:
        worst = int(coordinates[np.unravel_index(shares.argmax(), shares.shape)[1]])
        rule = (
            f"its motion must keep Lagrange's equation of {model.coordinates[worst]!r} but for a share of "
            f"{LAGRANGE_RTOL:g} of the forces in it"
        )
        fail(model, rule, shares.max())


def _longest_steps(modes: Any, lengths: Any) -> list[int]:
    """The indices of the longest steps in each mode."""
    some = (np.flatnonzero(modes == name) for name in np.unique(modes))
    return [int(k) for steps in some for k in steps[np.argsort(-lengths[steps])][:STEPS_PER_MODE]]


class _LagrangeBalance:
    """The terms of Lagrange's equations along a run, from the energies in numbers."""

    def __init__(self, model: MechanicalModel, run: Trajectory) -> None:
        self.model, self.run, self.names = model, run, model.coordinates
        n = len(self.names)
        sizes = np.abs(run.states[:, : 2 * n]).max(axis=0, initial=0.0)
        self.count = 5 + sum(_force_count(c) for c in self._mechanics(run.states[0]).contacts)
        self.steps = DIFFERENCE_SHARE * np.where(sizes > 0, sizes, 1.0)

    def terms(self, t: float, length: float, i: int) -> tuple[list[float], float]:
        """The terms of the equation of coordinate `i` at a time in the middle of a step, of a sum of zero.

        And what rounding of momentum and time may leave in the first, which is a difference by time.
        """
        n, state = len(self.names), self.run(t)

        def momentum(offset: float) -> float:
            there = self.run(t + offset)
            return self._slope(lambda about: about.kinetic, there, n + i)

        about = self._mechanics(state)
        h = length * STEP_SHARE
        terms = [_difference(momentum, h)]
        room = ROUNDING * (abs(momentum(0.0)) + abs(terms[0]) * t) / h
        terms += [-self._slope(lambda about: about.kinetic, state, i)]
        terms += [self._slope(lambda about: about.stored, state, i)]
        terms += [self._slope(lambda about: about.dissipation, state, n + i)]
        terms += [-float(about.loads.get(self.names[i], 0.0))]
        for k, contact in enumerate(about.contacts):
            terms += self._contact_terms(state, i, k, contact, lambda name: float(self.run.output(name, t)))
        return terms, room

    def _contact_terms(self, state: Any, i: int, k: int, contact: Any, force: Any) -> list[float]:
        known = self.run.automaton.outputs
        suffix = "" if "friction_force" in known or "reaction" in known else f"_{k + 1}"
        if isinstance(contact, Stop):
            return [-force("reaction" + suffix) * self._slope(lambda m: m.contacts[k].distance, state, i)]
        n = len(self.names)
        along = self._slope(lambda m: m.contacts[k].relative_velocity, state, n + i)
        terms = [force("friction_force" + suffix) * along]
        if contact.penetration is None:
            return terms
        if contact.normal is not None:
            return [*terms, -force("normal_force" + suffix) * float(contact.normal[i])]
        return [
            *terms,
            force("normal_force" + suffix) * self._slope(lambda m: m.contacts[k].penetration, state, i),
        ]

    def _slope(self, of: Callable[[Any], Any], state: Any, place: int) -> float:
        """The derivative of what a model states by one of the states."""

        def value(offset: float) -> float:
            there = state.copy()
            there[place] += offset
            return float(of(self._mechanics(there)))

        return _difference(value, self.steps[place])

    def _mechanics(self, state: Any) -> Mechanics:
        n = len(self.names)
        q, v = (
            dict(zip(self.names, map(float, part), strict=True)) for part in (state[:n], state[n : 2 * n])
        )
        phase = {"phase": float(state[2 * n])} if len(state) > 2 * n else {}
        return self.model.mechanics(SimpleNamespace(**q, **phase), SimpleNamespace(**v))


def _force_count(contact: Any) -> int:
    """How many forces a contact has."""
    return 1 if isinstance(contact, Stop) or contact.penetration is None else 2


def _difference(function: Callable[[float], float], h: float) -> float:
    """The derivative at 0 by a central difference of order 8."""
    pairs = (w * (function(k * h) - function(-k * h)) for k, w in enumerate(CENTRAL_WEIGHTS, start=1))
    return sum(pairs) / h


def rule_violations(run: Trajectory) -> dict[str, float]:
    """Worst violation of each rule as a share of its scale, for those that are violated.

    Checked on a grid, at the steps and just after every event.  Which rules there are depends on the
    outputs and the names of the modes: v_r = 0 in stick, v_r of the mode's sign in slip, friction along it,
    F_N >= 0 and penetration >= 0 in contact, penetration <= 0 and no force in flight (where there is a
    flight).
    """
    t = np.unique(np.concatenate([np.linspace(0.0, run.t[-1], SAMPLE_COUNT), run.t, run.events.t]))
    modes = run.modes_at(t)
    if not np.isfinite(run(t)).all():
        return {"every state is a number": np.inf}
    some = [run.automaton.mode(name) for name in run.mode_names]
    known = [name for name in CONTACT_OUTPUTS if all(name in mode.outputs for mode in some)]
    values = {name: run.output(name, t) for name in known}
    return {
        rule: worst for rule, worst in _violation_of_rules(run, modes, values) if not worst <= MAX_VIOLATION
    }


def _violation_of_rules(run: Trajectory, modes: Any, values: dict[str, Any]) -> Any:
    unilateral, flight = "separation" in run.mode_names, modes == "separation"
    for name, value in values.items():
        yield f"{name} is a number", 0.0 if np.isfinite(value).all() else np.inf
    if "relative_velocity" in values:
        # Where contact is bilateral, friction reverses with F_N.
        friction = values.get("friction_force") if unilateral else None
        yield from _friction_violations(modes, values["relative_velocity"], friction)
    if unilateral and "penetration" in values:
        penetration, scale = values["penetration"], _scale(values["penetration"])
        yield "penetration <= 0 in flight", (penetration[flight] / scale).max(initial=0.0)
        yield "penetration >= 0 in contact", (-penetration[~flight] / scale).max(initial=0.0)
    if unilateral and "normal_force" in values:
        force, scale = values["normal_force"], _scale(values["normal_force"])
        yield "no normal force in flight", np.abs(force[flight]).max(initial=0.0)
        yield "F_N >= 0 in contact", (-force[~flight] / scale).max(initial=0.0)


def _friction_violations(modes: Any, v_r: Any, friction: Any) -> Any:
    scale, stick = _scale(v_r), modes == "stick"
    yield "v_r = 0 in stick", np.abs(v_r[stick] / scale).max(initial=0.0)
    for name, sign in SLIP_SIGNS.items():
        slip = modes == name
        yield f"v_r has the sign of {name}", (-sign * v_r[slip] / scale).max(initial=0.0)
        if friction is not None:
            yield (
                f"friction has the sign of {name}",
                (-sign * friction[slip] / _scale(friction)).max(initial=0.0),
            )


def _scale(values: Any) -> float:
    return float(np.abs(values).max(initial=0.0)) or 1.0
