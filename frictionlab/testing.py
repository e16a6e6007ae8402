"""Checks of any law and any model, your own included.

>>> import frictionlab as fl
>>> fl.testing.check_law(fl.HertzContact())
>>> run = fl.testing.check_model(fl.SliderOnBelt(friction=fl.Stribeck()), t_end=0.1)

`check_law` checks a law by itself: its forces have the right signs; it gives the same values for numbers,
arrays and symbols; its parameters have a meaning and a range; its repr and its dictionary make it again.
`check_model` checks a model's parameters, its equations, and a motion, by the rules of `fl.verify`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from enum import Enum
from itertools import islice
from typing import Any

import numpy as np
import sympy as sp

from frictionlab.analysis.orbits.closing import but_for_turns
from frictionlab.analysis.run_conditions import broken_condition
from frictionlab.analysis.simulate import simulate
from frictionlab.analysis.stated_conditions import broken_statement
from frictionlab.components import ContactLaw, FrictionLaw, ImpactLaw
from frictionlab.components.component import Component, Parameter, parameters_of, structure_of
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.models import MechanicalModel
from frictionlab.models.composition import parameter_metadata
from frictionlab.models.mechanical.dynamic_laws import check_elastic, values_of_law
from frictionlab.models.model import Model, require_model
from frictionlab.models.serialisation import component_from_dict, component_to_dict
from frictionlab.models.symbolic_laws import symbolic_copy
from frictionlab.models.symbols import symbol
from frictionlab.tape.formulas import formulas_of
from frictionlab.tape.intervals import Interval, interval
from frictionlab.tape.packing import program_of
from frictionlab.validation import abbreviate, check_number, check_t_end

__all__ = ["check_law", "check_model"]

PENETRATIONS = np.linspace(1e-4, 0.1, 7)
SHARES = np.append(0.0, np.geomspace(1e-9, 1.0, 73))  # of these, at which signs are looked at first
MAX_PARTS, ROUNDS = 4096, 50  # of the bisection of the parts between them
SPEEDS = np.linspace(0.0, 3.0, 7)
FORCES = np.array([1.0, 50.0, 1e3])
LAW_STATES = np.array([-1e-4, 0.0, 1e-4])
NEARLY_ZERO = float(np.finfo(float).tiny)  # m/s
CONTINUITY_RTOL = 1e-9  # of a law, between relative velocities of this size and either sign
LAW_RTOL = 1e-12
COMPARISON_TIME = 0.02  # s, of the comparison with another integrator
COMPARISON_METHOD, COMPARISON_RTOL = "DOP853", 1e-7
SAMPLE_COUNT, MAX_MISS = 400, 1e-9  # of the outputs of a motion, and by which share they may miss a rule
MOST_EQUATIONS = 81  # modes whose equations are printed
PARAMETER_FACTOR = 1.0 + 2.0**-20  # by which a parameter's value is changed

Limits = Mapping[str, float]  # `max_speed` and `max_penetration` of check_law


def fail(subject: Any, rule: str, got: Any) -> None:
    """Raise AssertionError with what is checked, the rule, and what there is instead."""
    raise AssertionError(f"{subject!r}: {rule}, got {abbreviate(got)}")


def check_parameters(subject: Component, known: Mapping[str, Parameter]) -> None:
    """Fail unless every parameter that is more than a number has a meaning and a range with its default."""
    for name, about in known.items():
        if about == Parameter(about.symbol, default=about.default):
            continue
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
    classes: dict[str, type] = {type(subject).__name__: type(subject)}
    waiting = [getattr(subject, name) for name in structure_of(type(subject))]
    while waiting:
        value = waiting.pop()
        if isinstance(value, tuple):
            waiting += value
        elif isinstance(value, Component):
            classes |= _class_names(value)
        elif isinstance(value, Enum):
            classes[type(value).__name__] = type(value)
    return classes


def check_law(law: Component, *, max_speed: float = 100.0, max_penetration: float = 0.1) -> None:
    """Check a contact, friction or impact law.

    Its parameters are described, its repr makes it again, its methods give for symbols what they give for
    numbers and arrays, and the forces have the signs that the modes of contact rely on: bounds tell.

    Parameters
    ----------
    law : ContactLaw, FrictionLaw or ImpactLaw
    max_speed, max_penetration : float
        m/s and m: the range of the law, up to which friction and normal force must have their signs.

    Raises
    ------
    AssertionError
        With the rule that the law breaks, and what it gives instead.
    TypeError
        For anything else than such a law.
    ValueError
        For a range that is not positive.
    """
    kind = next((kind for kind in LAW_CHECKS if isinstance(law, kind)), None)
    if kind is None:
        raise TypeError(f"law must be a ContactLaw, FrictionLaw or ImpactLaw, got {abbreviate(law)}")
    limits = {
        "max_speed": check_number("max_speed", max_speed, above=0.0, cure="give the law's range in m/s"),
        "max_penetration": check_number(
            "max_penetration", max_penetration, above=0.0, cure="give the law's range in m"
        ),
    }
    check_parameters(law, parameters_of(type(law)))
    check_round_trip(law)
    LAW_CHECKS[kind](law, limits)


def _check_contact(law: Any, limits: Limits) -> None:
    _consistent_values(law, "force", _within(PENETRATIONS, limits["max_penetration"]))
    rule = "force(penetration) must be finite and not negative where the bodies press on each other"
    _check_sign(law, rule, "force", (), "max_penetration", limits, "m")


def _within(arguments: Any, most: float) -> Any:
    """Arguments of a law, ascending, drawn together where they are beyond its range."""
    return arguments * min(1.0, most / arguments[-1])


def _check_friction(law: Any, limits: Limits) -> None:
    speeds = _within(SPEEDS, limits["max_speed"])
    if law.states:
        _check_dynamic_friction(law, speeds)
        return
    speed, normal = map(np.ravel, np.meshgrid(speeds, FORCES))
    kinetic, limit = (
        _consistent_values(law, "kinetic", normal, speed),
        _consistent_values(law, "static_limit", normal),
    )
    rule = "kinetic(normal_force, speed) must be finite and not negative, its direction is the mode's"
    for force in FORCES.tolist():
        _check_sign(law, rule, "kinetic", (force,), "max_speed", limits, "m/s")
    slow = speed == 0.0
    if not (kinetic[slow] <= limit[slow] * (1 + LAW_RTOL)).all():
        fail(law, "kinetic(normal_force, 0) must not exceed static_limit(normal_force)", kinetic[slow])


def _check_sign(
    law: Any, rule: str, method: str, before: Sequence[float], limit: str, limits: Limits, unit: str
) -> None:
    """Fail where a method is negative, or not finite, at a last argument from 0 to a limit, and say where."""
    most = limits[limit]
    x = sp.Symbol("argument", real=True)
    values = formulas_of([x], [_formula(law, method, *before, x)]).arrays

    def numbers_at(at: Any) -> Any:
        return np.broadcast_to(np.asarray(values(at)[0], float), np.shape(at))

    def is_wrong(at: Any) -> Any:
        value = numbers_at(at)
        return ~((value >= least) & np.isfinite(value))

    with np.errstate(all="ignore"):
        least = -_rounding(numbers_at(most * SHARES))
        points = _decisive_points(values, is_wrong, most, least)
        wrong = is_wrong(points)
        if not wrong.any():
            return
        first = int(wrong.argmax())
        last = first + int(np.append(~wrong[first:], True).argmax()) - 1
        low = _border(is_wrong, *points[first - 1 : first + 1]) if first > 1 else 0.0
        high = _border(is_wrong, *points[last : last + 2]) if last + 1 < len(points) else most
        middle = float(values((low + high) / 2)[0])
    force = f" at a normal force of {before[0]:g} N" if before else ""
    place = f"also from {low:.6g} to {high:.6g} {unit}{force}"
    fail(law, f"{rule}, {place}, or check_law(law, {limit}=...) must tell its smaller range", middle)


def _rounding(values: Any) -> float:
    """Rounding errors of terms that cancel, of a law with these values elsewhere."""
    return LAW_RTOL * float(np.abs(values[np.isfinite(values)]).max(initial=0.0))


def _decisive_points(
    values: Callable[..., Any], is_wrong: Callable[[Any], Any], most: float, least: float
) -> Any:
    """Points from 0 to `most` one of which is wrong, or none where bounds tell that none is below `least`.

    Parts without such bounds are bisected, as long as they are few.
    """
    points = most * SHARES
    low, high = points[:-1], points[1:]
    for _ in range(ROUNDS):
        with suppress(TypeError):  # of a function without bounds all parts are left
            bounds = interval(values(Interval(low, high))[0])
            left = np.broadcast_to(~((bounds.low >= least) & (bounds.high < np.inf)), low.shape)
            low, high = low[left], high[left]
        middle = (low + high) / 2
        points = np.union1d(points, middle)
        if is_wrong(points).any() or len(middle) > MAX_PARTS:
            break
        low, high = np.append(low, middle), np.append(middle, high)
    return points


def _border(is_wrong: Callable[[float], Any], low: float, high: float) -> float:
    """Where between two numbers, one of which is wrong, the others begin."""
    side = is_wrong(low)
    for _ in range(ROUNDS):
        middle = (low + high) / 2
        low, high = (middle, high) if is_wrong(middle) == side else (low, middle)
    return (low + high) / 2


def _check_dynamic_friction(law: Any, speeds: Any) -> None:
    velocities = np.concatenate([-speeds[1:], speeds[1:]])
    grid = np.meshgrid(FORCES, velocities, *[LAW_STATES] * len(law.states))
    arguments = [values.ravel() for values in grid]
    states = tuple(map(symbol, law.states))
    copy = symbolic_copy(law.structure_key)
    values_of_law(copy, symbol("normal_force"), symbol("velocity"), states)
    elastic = copy.state_limit(symbol("normal_force")) is not None
    if elastic:
        check_elastic(copy, states)
    _consistent_values(law, "force", *arguments)
    if elastic:
        for name in law.states if isinstance(law.state_limit(1.0), Mapping) else ("",):
            limit = _consistent_values(law, "state_limit", FORCES, of=name)
            if not (limit > 0.0).all():
                rule = "state_limit(normal_force) must be above 0 where the bodies press on each other"
                fail(law, rule, limit)
    for name in law.states:
        _consistent_values(law, "rates", *arguments, of=name)
    normal, _, *some = arguments
    either = [law.force(normal, side * NEARLY_ZERO, *some) for side in (1, -1)]
    largest = np.abs(law.force(*arguments)).max()
    if not np.allclose(*either, rtol=0.0, atol=CONTINUITY_RTOL * largest):
        rule = (
            "force(...) must not jump where the relative velocity changes its sign, as no mode holds it there"
        )
        fail(law, rule, np.abs(either[0] - either[1]).max())


def _check_impact(law: Any, limits: Limits) -> None:
    rate, compliance = map(np.ravel, np.meshgrid(_within(SPEEDS, limits["max_speed"]), [0.5, 2.0]))
    impulse = _consistent_values(law, "impulse", rate, rate, compliance)
    after = rate - compliance * impulse
    if not (impulse >= 0.0).all():
        fail(law, "impulse(...) must not be negative: bodies do not pull on each other", impulse)
    if not ((after <= LAW_RTOL) & (after >= -rate - LAW_RTOL)).all():
        fail(law, "the gap rate after an impact must be from -1 times that before to 0", after)


def _consistent_values(law: Any, method: str, *arguments: Any, of: str = "") -> Any:
    """A method's values at arrays; fails unless symbols and single numbers give the same values.

    Of a method that returns several values they are those `of` a name.
    """
    symbols = [sp.Symbol(f"argument{i}", real=True) for i in range(len(arguments))]
    formula = _formula(law, method, *symbols, of=of)  # first, as it says what is no formula
    with np.errstate(all="ignore"):
        values = np.broadcast_to(_value(law, method, arguments, of), arguments[0].shape)
    for i, row in enumerate(zip(*arguments, strict=True)):
        at = tuple(map(float, row))
        single = _real(law, method, at, _number(law, method, at, of))
        if not np.isfinite(single):
            fail(law, f"{method} must give a finite number at {row}", single)
        exact = _real(law, method, at, formula.subs(dict(zip(symbols, at, strict=True))))
        if not np.allclose([values[i], single], exact, rtol=LAW_RTOL, atol=_rounding(values)):
            rule = f"{method} must give the same for symbols ({exact}), numbers and arrays at {row}"
            fail(law, rule, (single, values[i]))
    return values


def _value(law: Any, method: str, at: Sequence[Any], of: str) -> Any:
    value = getattr(law, method)(*at)
    return value[of] if of else value


def _number(law: Any, method: str, at: Sequence[float], of: str) -> Any:
    """A method's value at numbers; NaN where it divides by zero."""
    try:
        return _value(law, method, at, of)
    except ZeroDivisionError:
        return np.nan


def _formula(law: Any, method: str, *at: Any, of: str = "") -> Any:
    """A method's value at symbols, or at symbols and numbers, as an expression."""
    numbers = {symbol(name): getattr(law, name) for name in law.structure_key.parameters}
    return sp.sympify(_value(symbolic_copy(law.structure_key), method, at, of), strict=True).subs(numbers)


def _real(law: Any, method: str, at: tuple[float, ...], value: Any) -> float:
    """The value as a number; fails for a complex one, as of a root of a negative number."""
    try:
        return float(value)
    except TypeError:
        fail(law, f"{method} must give a real number at {at}", value)
        raise


LAW_CHECKS: dict[type, Callable[[Any, Limits], None]] = {
    ContactLaw: _check_contact,
    FrictionLaw: _check_friction,
    ImpactLaw: _check_impact,
}


def check_model(model: Model, t_end: float = 1.0) -> Trajectory:
    """Check a model together with its laws.

    Its parameters are described; its repr makes it again; every mode's equations print; another value of a
    parameter changes no structure, so that a slider compiles nothing; a motion from rest keeps the event
    functions and constraints of its modes, agrees with that of another integrator, and is one of what a
    :class:`MechanicalModel` states, as :func:`frictionlab.verify` judges it: with at most 12 coordinates it
    keeps Lagrange's equations, whose derivatives are then differences of numbers; its contacts do not pull,
    hold no more than they can and no less, and their impacts keep momentum, energy and law.  Of other models
    the outputs are judged: v_r = 0 in stick, friction along v_r, F_N >= 0, no F_N in flight.

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
    t_end = check_t_end(t_end)
    check_parameters(model, parameter_metadata(type(model), model.components))
    check_round_trip(model)
    _check_equations(model)
    _check_structure(model)
    run = simulate(model, t_end, progress=False)
    _check_motion(model, run)
    _check_agreement(model, min(t_end, COMPARISON_TIME))
    return run


def _check_motion(model: Model, run: Trajectory) -> None:
    if not run.status.ok:
        fail(model, f"a motion of {run.t[-1]:g} s must come to its end", run.status)
    if broken := broken_condition(run) or broken_statement(run):
        fail(model, "a motion must be one of its modes, and of what the model states", broken)
    for rule, worst in () if isinstance(model, MechanicalModel) else _misses_of_outputs(run):
        if not worst <= MAX_MISS:
            fail(model, f"its outputs must keep the rule: {rule}", f"a miss of {worst:.2g}")


def _misses_of_outputs(run: Trajectory) -> Iterator[tuple[str, float]]:
    """Rules of one contact and by how much outputs of a model that states no mechanics miss them, as shares.

    Modes are known by their names.  Without a flight, contact is bilateral, and F_N may have either sign.
    """
    t = np.unique(np.concatenate([np.linspace(0.0, run.raw.t, SAMPLE_COUNT), run.t, run.events.t]))
    modes, visited = run.modes_at(t), [run.automaton.mode(name) for name in run.mode_names]
    values = {
        name: run.output(name, t)
        for name in ("relative_velocity", "friction_force", "normal_force")
        if all(name in mode.outputs for mode in visited)
    }
    shares = {name: x / (np.abs(x).max() or 1.0) for name, x in values.items()}
    flight, unilateral = modes == "separation", "separation" in run.automaton.names
    v_r, friction, normal = map(shares.get, ("relative_velocity", "friction_force", "normal_force"))
    if v_r is not None:
        held = [mode.name for mode in visited if mode.name == "stick" and mode.holds]
        yield "v_r = 0 in stick", np.abs(v_r[np.isin(modes, held)]).max(initial=0.0)
        if friction is not None and unilateral:
            slip = np.isin(modes, ["slip+", "slip-"])
            yield "friction along v_r in slip", (-np.sign(v_r) * friction)[slip].max(initial=0.0)
    if normal is not None and unilateral:
        yield "no normal force in flight", np.abs(normal[flight]).max(initial=0.0)
        yield "F_N >= 0 in contact", -normal[~flight].min(initial=0.0)


def _check_equations(model: Model) -> None:
    for mode in islice(model.automaton().names, MOST_EQUATIONS):
        try:
            equations = model.equations(mode)
        except ValueError:  # a limit mode has no equations to print
            continue
        if not len(equations) or "\\" not in equations.latex() or not repr(equations):
            fail(model, f"equations({mode!r}) must print, also in LaTeX", equations)


def _check_structure(model: Model) -> None:
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


def _component_parameters(model: Model) -> set[str]:
    return {name for part in model.components.values() for name in parameters_of(type(part))}


def _check_agreement(model: Model, t_end: float) -> None:
    run = simulate(model, t_end, progress=False)
    own, other = run.final_state, simulate(model, t_end, method=COMPARISON_METHOD, progress=False).final_state
    # A phase may have begun anew in one of them.
    error = np.abs(but_for_turns(run, own, other)).max() / (np.abs(own).max() or 1.0)
    if not error <= COMPARISON_RTOL:
        fail(
            model,
            f"its motion must be that of {COMPARISON_METHOD} but for a share of {COMPARISON_RTOL:g}",
            error,
        )
