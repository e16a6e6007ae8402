"""A scene as data, as the front end takes it: controls with units and ranges, panels, mechanism, time scales.

A scene is the same for an exported page and for an explorer; they differ in the engine that computes results.
The state of a front end holds a value for each control, by its name.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any, TypeAlias

import numpy as np

from frictionlab.analysis.initial_states import initial_state_of
from frictionlab.analysis.motion_scales import highest_frequency, round_down_1_2_5
from frictionlab.analysis.period_of_motion import with_period
from frictionlab.automaton import HybridAutomaton
from frictionlab.automaton.modes_on_demand import ModeNames, regimes_in
from frictionlab.components.component import Component, Parameter, structure_of
from frictionlab.components.contact import ContactLaw, CubicContact, HertzContact, PolynomialContact
from frictionlab.components.dynamic_friction import Dahl, Iwan, Jenkins, LuGre, RateAndState, RateAndStateSlip
from frictionlab.components.friction import (
    Coulomb,
    ExponentialDecay,
    FrictionCurve,
    FrictionLaw,
    HyperbolicDecay,
    PressureDependent,
    Stribeck,
    WeakeningStrengthening,
)
from frictionlab.components.impact import ImpactLaw, PlasticImpact, RestitutionImpact
from frictionlab.hybrid.outputs import output_formulas
from frictionlab.letters import LATEX
from frictionlab.models.composition import parameter_owners
from frictionlab.models.library.challenges import CHALLENGES
from frictionlab.models.mechanism import Belt, Point, Turn
from frictionlab.models.model import (
    Model,
    ModelOrAutomaton,
    MovingSystem,
    automaton_of,
    parameters_about,
    require_model,
    roles_in,
    tone_of,
    values_of,
)
from frictionlab.plotting.appearance import ModeLook
from frictionlab.plotting.labels import state_label
from frictionlab.plotting.time_histories import force_axis_label, force_outputs
from frictionlab.plotting.turns import turning_angles
from frictionlab.presentation import OwnUnits, force_symbol, output_unit, unit_of_state
from frictionlab.stability import eigenvalues
from frictionlab.validation import abbreviate

Data = dict[str, Any]
Shown: TypeAlias = Model | HybridAutomaton  # what explorers and pages show
KINDS = "a model such as SliderOnBelt, a Structure or a HybridAutomaton"
MAX_MODES = 64  # with more, a page would have megabytes and take minutes to derive
MOST_FREEDOMS = 100  # of a structure, with whose square the size of a page grows

# The panels that the front end draws, in their order, and what each needs of a result but the equilibrium.
PANELS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "mechanism": ("run",),
        "friction": ("friction",),
        "response": ("run",),
        "phase": ("run",),
        "forces": ("run",),
        "spectrum": ("run", "spectrum"),
        "eigenvalues": (),
    }
)
# What the menu of a role offers, by the kind of law.  A linear contact is what the switch "cubic" leaves.
LAWS: Mapping[type[Component], Mapping[str, Component]] = MappingProxyType(
    {
        FrictionLaw: {
            "Coulomb": Coulomb(),
            "exponential decay": ExponentialDecay(),
            "hyperbolic decay": HyperbolicDecay(),
            "Stribeck": Stribeck(),
            "weakening-strengthening": WeakeningStrengthening(),
            "pressure-dependent": PressureDependent(),
            "curve of points": FrictionCurve(),
            "Dahl": Dahl(),
            "LuGre": LuGre(),
            "Jenkins": Jenkins(),
            "Iwan": Iwan(),
            "rate and state (aging)": RateAndState(),
            "rate and state (slip)": RateAndStateSlip(),
        },
        ContactLaw: {"cubic": CubicContact(), "Hertz": HertzContact(), "polynomial": PolynomialContact()},
        ImpactLaw: {
            "plastic, Eq. (13)": PlasticImpact("material"),
            "plastic, full gap rate": PlasticImpact("full"),
            "restitution": RestitutionImpact(),
        },
    }
)
LAW_HINTS = {ImpactLaw: "the velocity after a body has landed"}
OPERATION_PARAMETERS = "F", "v", "Omega"  # the model's own parameters that are changed most in operation
ONE_CONTACT = "normal_force", "friction_force"  # the outputs of a model with one contact
MAX_UNFOLDED = 12  # a model with more parameters has some of them folded away
MAX_SLIDER_STEPS = 300  # most steps of a slider from one end to the other
SHOWN_PERIODS = 5, 10, 20, 50  # periods
USUAL_PERIODS = 200  # that are simulated: 20 s of the slider on a belt
MOST_TIME_CONSTANTS = 5e5  # 1/|s| of the fastest eigenvalue, in a run: it keeps steps short
WHAT_MOVES = "moving"  # shows the last periods, or the whole of a motion that has come to rest
BEGINNING = "beginning"  # shows as many periods from the start
STARTS = {"rest": "at rest", "near": "near the equilibrium", "own": "own numbers"}
# Controls and words of links that no parameter may be named like.
TAKEN = frozenset(
    "start own duration window coordinate method step formula range transient scene challenge lesson play "
    "without".split()
)
SWITCH = "switch-"  # begins the names of switches
DURATION = Parameter("", "s", "seconds that are simulated", exclusive_minimum=0.0)
OF_COORDINATE = "coordinate of the phase plane and the spectrum"
MARK = "\0"  # encloses the place of a value in a text
NOTHING_SAID = str, bool, type(None)  # where a field of a picture is empty, false or missing
LEAST_DURATION, USUAL_DURATION = 10, 1000  # periods: the ends of the slider of the duration


@dataclass(frozen=True, eq=False, repr=False)
class StructureAutomaton(HybridAutomaton, OwnUnits):
    """The automaton of a structure, with its units and the rules of its parameters.

    Parameters
    ----------
    source : MovingSystem
        The structure, with the same values of parameters: studies take it in the automaton's place.
    """

    source: Any = field(kw_only=True)

    @property
    def units(self) -> Any:
        """Of length and of force."""
        return self.source.units

    def _with_values(self, changes: Mapping[str, float]) -> HybridAutomaton:
        source = self.source.replace(**changes)  # where a rule is broken, as mu_s >= mu_k, it says so
        return replace(super()._with_values(changes), source=source)


def shown_model(model: object, x0: Any, cure: str) -> tuple[Shown, str | tuple[float, ...]]:
    """The model, or the automaton with its period, and where it starts: "rest", "near" or the state (n,).

    A structure is shown by its automaton.

    Raises
    ------
    TypeError
        For anything that is no model, no structure and no automaton.
    ValueError
        For a bad `x0`, for parameters that are named like another control, and for a structure of more than
        100 freedoms or 64 modes.
    """
    if isinstance(model, MovingSystem):
        return shown_model(_shown_system(model), x0, cure)
    known = model if isinstance(model, HybridAutomaton) else require_model(model, KINDS, cure)
    for name in values_of(known):
        if name in TAKEN or name.startswith(SWITCH):
            raise ValueError(
                f"a parameter must not be named like the explorer's control {name!r} to be shown: rename it"
            )
    state = initial_state_of(known, x0)
    shown = with_period(known, state) if isinstance(known, HybridAutomaton) else known
    return shown, x0 if isinstance(x0, str) else tuple(state.tolist())


def _shown_system(system: MovingSystem) -> HybridAutomaton:
    """The automaton of a structure, with its period and units."""
    if len(system.coordinates) > MOST_FREEDOMS:
        raise ValueError(
            f"a structure must have at most {MOST_FREEDOMS} freedoms to be shown, got "
            f"{len(system.coordinates)}: take fl.reduce, or fl.simulate and fl.plot_run"
        )
    automaton = system.automaton()
    if isinstance(names := automaton.names, ModeNames) and names.more_than(MAX_MODES):
        raise ValueError(
            f"a structure must have at most {MAX_MODES} modes to be shown, got more of {abbreviate(system)}: "
            "take fewer contacts, or fl.simulate and fl.plot_run"
        )
    return StructureAutomaton(
        automaton.states,
        automaton.modes,
        automaton.parameters,
        automaton.coordinates,
        automaton.cyclic,
        system.period,
        source=system,
    )


def name_of(model: ModelOrAutomaton) -> str:
    """What a page is called unless it is given a title."""
    return "hybrid automaton" if isinstance(model, HybridAutomaton) else type(model).__name__


def scene_data(
    model: Shown, controls: Iterable[Data], panels: Sequence[str], period: float, *, title: str | None = None
) -> Data:
    """A scene of a model or an automaton, over multiples of a period (s)."""
    controls = list(controls)
    automaton = automaton_of(model)
    tone = getattr(model, "sound", None) or tone_of(automaton, period)
    return {
        "title": title or name_of(model),
        "about": "",
        "model": repr(model),
        "controls": controls,
        "initial": {each["name"]: each["value"] for each in controls},
        "panels": list(panels),
        "period": round_down_1_2_5(period),
        "highest": highest_frequency(period),
        "windows": windows(period),
        "mechanism": getattr(model, "mechanism", None) is not None,
        "challenges": challenge_data(model),
        "sound": {"signal": tone.signal, "pitch": float(tone.pitch)},
    }


def panels_of(model: Shown) -> list[str]:
    """The panels that are shown unless others are asked for; the friction curve comes last unless its points
    are dragged."""
    names = [name for name in PANELS if name != "friction"]
    if getattr(model, "mechanism", None) is None:
        names.remove("mechanism")
    if friction_points(model):
        return [*names[:1], "friction", *names[1:]]
    return [*names, "friction"] if FrictionLaw in roles_in(model).values() else names


def has_friction_curve(model: Shown) -> bool:
    """Whether friction is one law whose force follows from speed and normal force."""
    law = getattr(model, "friction", None)
    return isinstance(law, FrictionLaw) and not law.states


def friction_points(model: Shown) -> list[list[str]]:
    """The points of a curve that is drawn: the parameters that are the speed and the coefficient of each."""
    if not isinstance(getattr(model, "friction", None), FrictionCurve):
        return []
    return [["", "mu_0"], *([f"v_{i}", f"mu_{i}"] for i in range(1, 5))]


def challenge_data(model: Shown) -> list[Data]:
    """The challenges about models of these laws; each begins with the parameters of its own model."""
    return [
        each._asdict() | {"model": repr(each.model), "state": {**each.model.parameters, "start": each.start}}
        for each in CHALLENGES
        if isinstance(model, Model) and each.model.structure_key == model.structure_key
    ]


def scene_controls(
    models: Sequence[Any],
    switches: Iterable[str],
    laws: Mapping[str, Iterable[str]],
    about_run: tuple[float, float, str | tuple[float, ...]],
    *,
    sliders: tuple[Any, Any] = (None, None),
    more_laws: str = "",
) -> list[Data]:
    """The controls of the first of these models: its switches and menus of laws, the parameters of all models
    that these lead to, and how it is run, by a period (s), a length (s) and a start."""
    model = models[0]
    return [
        *(switch_control(model, name) for name in switches),
        *(law_control(model, role, names, more_laws) for role, names in laws.items()),
        *formula_controls(models),
        *controls_of_models(models, *sliders),
        *run_controls(model, *about_run),
    ]


def number(name: str, about: Parameter, value: float, group: str, bounds: Any = None) -> Data:
    """A number with its unit and the range of its slider; `bounds` take the place of the parameter's own."""
    low, high = bounds or slider_range(about, value)
    return {
        "name": name,
        "kind": "number",
        "group": group,
        "label": f"${about.symbol}$" if about.symbol else name.replace("_", " "),
        "unit": about.unit,
        "meaning": about.meaning,
        "value": float(value),
        "low": float(min(low, value)),
        "high": float(max(high, value)),
        "log": bool(about.log and min(low, value) > 0),
    }


def switch_control(model: Any, name: str) -> Data:
    """A switch of a nonlinearity of a model."""
    one = model.nonlinearities[name]
    about, on = one.about, not one.missing(model)
    if name == "nonsmooth" and on:
        about = _regimes(model, about)
    hint = f"switches a nonlinearity on and off: {about}"
    return {
        "name": f"{SWITCH}{name}",
        "kind": "switch",
        "group": "main",
        "text": about,
        "value": on,
        "hint": hint,
    }


def _regimes(model: Model, words: str) -> str:
    """Those of the words that are regimes of the model; "impacts" where none is."""
    regimes = regimes_in(model.automaton().names)
    fitting = [word for word in words.split(", ") if any(part.startswith(word) for part in regimes)]
    return ", ".join(fitting) or "impacts"


def law_menus(model: Shown) -> dict[str, dict[str, Component]]:
    """For each role for which the library has laws: those that the model takes, and its own, by name."""
    return {role: _laws_of(model, role) for role, kind in roles_in(model).items() if kind in LAWS}


def _laws_of(model: Any, role: str) -> dict[str, Component]:
    own = getattr(model, role)
    laws = {name: law for name, law in LAWS[model.roles[role]].items() if _takes(model, role, law)}
    return laws | {own_law(model, role): own}


def own_law(model: Any, role: str) -> str:
    """The name in the menu of the law that the model has."""
    own = getattr(model, role)
    return next(
        (name for name, law in LAWS[model.roles[role]].items() if _alike(law, own)), type(own).__name__
    )


def _alike(law: Component, other: Component) -> bool:
    """Whether two laws differ in nothing but the values of parameters."""
    if type(law) is not type(other):
        return False
    return all(getattr(law, name) == getattr(other, name) for name in structure_of(type(law)))


def _takes(model: Model, role: str, law: Component) -> bool:
    try:
        model.replace(**{role: law})
    except (TypeError, ValueError):  # a parameter's name is taken, or the model asks for another kind of law
        return False
    return True


def law_control(model: Any, role: str, names: Iterable[str], more: str = "") -> Data:
    """A menu of the laws of a role, by these names; `more` is added to its hint."""
    hint = LAW_HINTS.get(model.roles[role], f"the law of {role}") + more
    return choice(role, names, own_law(model, role), "main", hint=hint) | {"text": f"{role} law"}


def formula_controls(models: Iterable[Shown]) -> list[Data]:
    """The field of a formula that puts the points of a friction curve on it, where a model has some."""
    listed = list(models)
    model = next(filter(friction_points, listed), None)
    if model is None:
        return []
    (_, coefficient), (speed, _), *_ = friction_points(model)
    unit = parameters_about(model, listed[0])[speed].unit
    about = {"name": "formula", "kind": "formula", "group": "main", "text": "μ(v) =", "value": ""}
    given = f"a formula of the sliding speed v{f' in {unit}' if unit else ''}"
    hint = f"{given}, on which the points of the friction curve are put"
    return [about | {"needs": coefficient, "hint": hint}]


def controls_of_models(models: Iterable[Shown], main: Any = None, ranges: Any = None) -> list[Data]:
    """A number for each parameter of any of these models; the first that has it gives its value.

    Those of `main` come first, the others are folded away; `main` and `ranges` are those of the first model,
    where they are not the usual ones.
    """
    numbers: dict[str, Data] = {}
    first: Shown | None = None
    for model in models:
        first, chosen = first or model, main or main_parameters(model)
        about, values = parameters_about(model, first), values_of(model)
        for name in dict.fromkeys((*chosen, *values)):
            if name not in numbers:
                group = "main" if name in chosen else "structure"
                bounds = (ranges or {}).get(name)
                numbers[name] = number(name, about[name], values[name], group, bounds) | {"parameter": True}
        main = ranges = None
    return list(numbers.values())


def choice(
    name: str, options: Iterable[str], value: str, group: str, labels: Iterable[str] = (), hint: str = ""
) -> Data:
    """A menu; its value is one of the options, which may have labels of their own."""
    listed = list(options)
    return {
        "name": name,
        "kind": "choice",
        "group": group,
        "text": name.replace("_", " "),
        "value": value,
        "options": listed,
        "labels": list(labels) or listed,
        "hint": hint,
    }


def run_controls(
    model: Shown, period: float, t_end: float, x0: str | tuple[float, ...] = "rest"
) -> list[Data]:
    """How a model is run, and what is shown of it: start, own state, duration, window, coordinate."""
    automaton = automaton_of(model)
    names, is_model = automaton.shown_states, isinstance(model, Model)
    count = 2 * automaton.coordinates if is_model else 0  # further states of a model begin as at rest
    needed = automaton.state_names[: count or None]
    numbers = ", ".join(["0"] * len(needed) if isinstance(x0, str) else map(repr, x0))
    ends = tuple(periods * round_down_1_2_5(period) for periods in (LEAST_DURATION, USUAL_DURATION))
    own = {
        "name": "own",
        "kind": "text",
        "group": "run",
        "text": "state",
        "value": numbers,
        "when": ["start", "own"],
        "hint": f"numbers for {', '.join(needed)}, with commas between",
    }
    starts = STARTS if is_model else STARTS | {"rest": "all states zero"}
    start = x0 if isinstance(x0, str) else "own"
    return [
        choice("start", starts, start, "run", starts.values(), "initial state"),
        own,
        number("duration", DURATION, t_end, "run", ends),
        choice("window", windows(period), "what moves", "run", hint="part of the run that the panels show"),
        choice("coordinate", names, automaton.shown_state, "run", map(label_of, names), OF_COORDINATE),
    ]


def usual_duration(model: Shown, period: float) -> float:
    """Seconds that explorers, pages, films and sounds simulate: 200 periods, fewer for a stiff model, but 10.

    >>> import frictionlab as fl
    >>> usual_duration(fl.SliderOnBelt(), 0.1), usual_duration(fl.LuGreOscillator(), 4.4)
    (20.0, 50.0)
    """
    least, seconds = (periods * round_down_1_2_5(period) for periods in (LEAST_DURATION, USUAL_PERIODS))
    with suppress(ValueError):  # no equilibrium tells how stiff it is
        fastest = float(np.abs(eigenvalues(model).values).max())
        if fastest:
            return max(least, min(seconds, round_down_1_2_5(MOST_TIME_CONSTANTS / fastest)))
    return seconds


def windows(period: float) -> dict[str, float | str | None]:
    """The parts of a run that may be shown, by their names: seconds at its end, or all of it."""
    lengths = [round(count * round_down_1_2_5(period), 12) for count in SHOWN_PERIODS]
    last = {f"last {s:g} s": s for s in lengths}
    return {"what moves": WHAT_MOVES, "how it begins": BEGINNING, **last, "whole run": None}


def main_parameters(model: Shown) -> list[str]:
    """All parameters if they are few; else those of the friction law, of operation, of other components; of
    an automaton the first ones."""
    if isinstance(model, HybridAutomaton):
        return list(model.values)[:MAX_UNFOLDED]
    owner = parameter_owners(type(model), model.components)
    if len(owner) <= MAX_UNFOLDED:
        return list(owner)
    friction = [name for name, role in owner.items() if role == "friction"]
    laws = [name for name, role in owner.items() if role and role != "friction"]
    return [*friction, *(name for name in OPERATION_PARAMETERS if name in owner), *laws]


def slider_range(about: Parameter, value: float) -> tuple[float, float]:
    """Where a slider for a parameter begins and ends: its range, made wide enough for the value; without one
    up to twice the value, within the parameter's bounds."""
    low, high = about.range or _default_range(about, value)
    if about.log and low <= 0 < value:
        low = min(value, high) / 1e3
    return min(low, value), max(high, value)


def _default_range(about: Parameter, value: float) -> tuple[float, float]:
    twice = 2 * abs(value) or 1.0
    bounds = [b for b in (about.minimum, about.exclusive_minimum) if b is not None]
    # An exclusive bound is no admissible value itself.
    margin = twice / MAX_SLIDER_STEPS if about.minimum is None else 0.0
    low = max(bounds[0] + margin if bounds else -math.inf, 0.0 if value > 0 else -twice)
    return low, min(max(twice, low + twice), math.inf if about.maximum is None else about.maximum)


def last_value(model: Shown, name: str, beyond: float) -> float:
    """Of a parameter from the model's value to another one: the last that keeps the model's rules."""

    def holds(value: float) -> bool:
        try:
            initial_state_of(model.replace(**{name: value}), "rest")  # masses, loads, dampers, normal forces
        except ValueError:
            return False
        return True

    good, bad = values_of(model)[name], beyond
    if holds(bad):
        return bad
    while (middle := good + (bad - good) / 2) not in (good, bad):
        good, bad = (middle, bad) if holds(middle) else (good, middle)
    rounded = float(f"{good:.9g}")
    return rounded if holds(rounded) else good


def quantity_data(model: Shown, automaton: HybridAutomaton) -> Data:
    """Labels and units of states, labels and colours of contact forces, and whether something can slide."""
    names, forces = list(automaton.state_names), force_outputs(automaton, model)
    speeds = {output_unit(name, model) for name in automaton.outputs if name.startswith("relative_velocity")}
    speed = speeds.pop() if len(speeds) == 1 else ""
    return {
        "automaton": isinstance(model, HybridAutomaton),
        "states": names,
        "coordinates": automaton.coordinates,
        "rates": dict(automaton.rates),
        "cyclic": list(automaton.cyclic),
        "turning": turning_angles(automaton),
        "labels": {name: label_of(name) for name in names},
        "units": {name: unit_of_state(model, name) for name in names},
        "forces": {name: [look.symbol, look.colour] for name, look in forces.items()},
        "axis_of_forces": force_axis_label(forces.values()),
        "at_contact": {
            "penetration": ["penetration", output_unit("penetration", model)],
            **{name: [f"${force_symbol(name, model)}$", output_unit(name, model)] for name in ONE_CONTACT},
        },
        "sliding_units": {"speed": speed, "damper": "N m s" if speed == "rad/s" else "N s/m"},
        "slides": can_slide_steadily(model, automaton),
        "points": friction_points(model),
    }


def mode_data(looks: Mapping[str, ModeLook], wholes: Mapping[str, str]) -> Data:
    """Modes in the order of their numbers: names, those without pieces of laws, and how they look."""
    return {
        "modes": list(looks),
        "wholes": [wholes[name] for name in looks],
        "colours": [look.colour for look in looks.values()],
        "dashes": [list(look.dashes) for look in looks.values()],
    }


def label_of(name: str) -> str:
    """The label of a state, which may be LaTeX itself, as states of automata have any name."""
    return f"${name.strip('$')}$" if LATEX.search(name) else state_label(name)


def can_slide_steadily(model: Shown, automaton: HybridAutomaton) -> bool:
    """Whether something slides while all coordinates but cyclic ones are at rest: on a belt, say.

    Of an automaton that is not said.
    """
    if isinstance(model, HybridAutomaton):
        return False
    resting = {rate for name, rate in automaton.rates.items() if name not in automaton.cyclic}
    draw = np.random.default_rng(0)  # at other numbers by chance: it holds for the structure, not for values
    states = [0.0 if name in resting else draw.uniform(1.0, 2.0) for name in automaton.state_names]
    at = [*states, *draw.uniform(1.0, 2.0, len(automaton.values)).tolist()]
    mode, names = automaton.names[0], [n for n in automaton.outputs if n.startswith("relative_velocity")]
    return any(output_formulas(automaton, mode, name).numbers(*at)[0] != 0.0 for name in names)


def mechanism_data(model: Shown) -> list[Data] | None:
    """The model's picture as data: what its parts are, and the fields of each; None where it has none."""
    mechanism = getattr(model, "mechanism", None)
    return mechanism and [{"part": type(part).__name__} | _stated(part) for part in mechanism.parts]


def _stated(fields: Any) -> Data:
    """The fields that say something: no names that are empty, no parts that are missing."""
    said: Data = {}
    for name, one in vars(fields).items():
        field = Point(*one) if isinstance(one, tuple) else one
        if isinstance(field, (np.ndarray, np.generic)):  # as np.where gives numbers
            field = field.item()
        if isinstance(field, (Point, Turn, Belt)):
            said[name] = _stated(field)
        elif not isinstance(field, NOTHING_SAID) or field:
            said[name] = field
    return said
