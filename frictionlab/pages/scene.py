"""A scene as data, as the front end takes it: controls with units and ranges, panels, mechanism, time scales.

A scene is the same for an exported page and for an explorer; they differ in the engine that computes results.
The state of a front end holds a value for each control, by its name.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

from frictionlab.analysis.motion_scales import highest_frequency, rounded_period
from frictionlab.automaton import HybridAutomaton
from frictionlab.components.component import Parameter
from frictionlab.components.friction import FrictionCurve, FrictionLaw
from frictionlab.models.composition import parameter_metadata, parameter_owners
from frictionlab.models.library.challenges import CHALLENGES
from frictionlab.models.mechanism import Mechanism, TiltingBelt
from frictionlab.models.model import Model, require_model
from frictionlab.plotting.animation.parts import MARKS, WIDTH
from frictionlab.plotting.animation.tilting_belt import SPRING_LABELS
from frictionlab.plotting.labels import state_label
from frictionlab.plotting.time_histories import force_outputs
from frictionlab.presentation import state_unit

Data = dict[str, Any]

PANELS = ("mechanism", "friction", "response", "phase", "forces", "spectrum", "eigenvalues")
OPERATION_PARAMETERS = "F", "v", "Omega"  # the model's own parameters that are changed most in operation
MAX_UNFOLDED = 12  # a model with more parameters has some of them folded away
MAX_SLIDER_STEPS = 300  # most steps of a slider from one end to the other
SHOWN_PERIODS = 5, 10, 20, 50  # periods
WHAT_MOVES = "moving"  # shows the last periods, or the whole of a motion that has come to rest
BEGINNING = "beginning"  # shows as many periods from the start
STARTS = {"rest": "at rest", "near": "near the equilibrium", "own": "own numbers"}
LEAST_DURATION, USUAL_DURATION = 10, 1000  # periods: the ends of the slider of the duration


def require_shown_model(model: object, cure: str) -> Model:
    """Return the model; raise for anything else, and for a model without coordinates, which pictures show."""
    known = require_model(model, cure=cure)
    if not known.coordinates:
        raise ValueError(
            f"model must have coordinates to be shown, {type(known).__name__} has none: plot run.t and "
            "run.states"
        )
    return known


def scene_data(
    model: Model, controls: Iterable[Data], panels: Sequence[str], *, title: str | None = None
) -> Data:
    """A scene of a model."""
    controls = list(controls)
    return {
        "title": title or type(model).__name__,
        "about": "",
        "call": model_call(model),
        "model": repr(model),
        "controls": controls,
        "initial": {each["name"]: each["value"] for each in controls},
        "panels": list(panels),
        "period": float(rounded_period(model)),
        "highest": float(highest_frequency(model)),
        "windows": windows(model),
        "mechanism": mechanism_data(model),
        "points": friction_points(model),
        "challenges": challenge_data(model),
        "sound": {"signal": model.sound.signal, "pitch": float(model.sound.pitch)},
    }


def panels_of(model: Model) -> list[str]:
    """The panels that are shown unless others are asked for: the friction curve where it can be drawn."""
    lacking = {"mechanism": model.mechanism is None, "friction": not friction_points(model)}
    return [name for name in PANELS if not lacking.get(name)]


def has_friction_curve(model: Model) -> bool:
    """Whether friction is one law whose force follows from speed and normal force."""
    law = getattr(model, "friction", None)
    return isinstance(law, FrictionLaw) and not law.states


def friction_points(model: Model) -> list[list[str]]:
    """The points of a curve that is drawn: the parameters that are the speed and the coefficient of each."""
    if not isinstance(getattr(model, "friction", None), FrictionCurve):
        return []
    return [["", "mu_0"], *([f"v_{i}", f"mu_{i}"] for i in range(1, 5))]


def challenge_data(model: Model) -> list[Data]:
    """The challenges about models of these laws; each begins with the parameters of its own model."""
    fitting = (each for each in CHALLENGES if type(each.model) is type(model))
    return [
        {
            "name": each.name,
            "question": each.question,
            "state": {**each.model.parameters, "start": each.start},
            "goal": dict(each.goal),
            "may": list(each.may),
            "most": each.most,
        }
        for each in fitting
        if each.model.structure_key == model.structure_key
    ]


def model_call(model: Model) -> str:
    """The name by which Python code calls the model's class."""
    name, ours = type(model).__name__, type(model).__module__.startswith("frictionlab.")
    return f"fl.{name}" if ours else name


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


def parameter_controls(model: Model, main: Iterable[str], ranges: Any = None) -> list[Data]:
    """A number for each parameter; those of `main` come first, the others are folded away."""
    about, ranges = parameter_metadata(type(model), model.components), ranges or {}
    chosen = list(main)
    ordered = [*chosen, *(name for name in model.parameters if name not in chosen)]
    numbers = {
        name: number(name, about[name], model.parameters[name], _group(name in chosen), ranges.get(name))
        for name in ordered
    }
    return [each | {"parameter": True} for each in numbers.values()]


def _group(main: bool) -> str:
    return "main" if main else "structure"


def switch_control(model: Model, name: str) -> Data:
    """A switch of a nonlinearity of a model."""
    one = model.nonlinearities[name]
    about, on = one.about, not one.missing(model)
    if name == "nonsmooth" and on:
        about = _regimes(model, about)
    hint = f"switches a nonlinearity on and off: {about}"
    return {
        "name": f"switch-{name}",
        "kind": "switch",
        "group": "main",
        "text": about,
        "value": on,
        "hint": hint,
    }


def _regimes(model: Model, words: str) -> str:
    """Those of the words that are regimes of the model; "impacts" where none is."""
    regimes = {part for mode in model.automaton().modes for part in mode.name.split(" | ")}
    fitting = [word for word in words.split(", ") if any(part.startswith(word) for part in regimes)]
    return ", ".join(fitting) or "impacts"


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


def run_controls(model: Model, t_end: float) -> list[Data]:
    """How a model is run, and what is shown of it: start, own state, duration, window, coordinate."""
    names = list(model.coordinates)
    duration = Parameter("", "s", "seconds that are simulated", exclusive_minimum=0.0)
    period = rounded_period(model)
    ends = LEAST_DURATION * period, USUAL_DURATION * period
    own = {
        "name": "own",
        "kind": "text",
        "group": "run",
        "text": "state",
        "value": ", ".join(["0"] * 2 * len(names)),
        "when": ["start", "own"],
        "hint": f"coordinates {', '.join(names)}, then their rates, with commas between",
    }
    shown = model.automaton().shown_state
    return [
        choice("start", STARTS, "rest", "run", STARTS.values(), "initial state"),
        own,
        number("duration", duration, t_end, "run", ends),
        choice("window", windows(model), "what moves", "run", hint="part of the run that the panels show"),
        choice("coordinate", names, shown, "run", hint="coordinate of the phase plane and the spectrum"),
    ]


def windows(model: Model) -> dict[str, float | str | None]:
    """The parts of a run that may be shown, by their names: seconds at its end, or all of it."""
    lengths = [round(count * rounded_period(model), 12) for count in SHOWN_PERIODS]
    last = {f"last {s:g} s": s for s in lengths}
    return {"what moves": WHAT_MOVES, "how it begins": BEGINNING, **last, "whole run": None}


def main_parameters(model: Model) -> list[str]:
    """All parameters if they are few; else those of the friction law, of operation, of other components."""
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


def quantity_data(model: Model, automaton: HybridAutomaton) -> Data:
    """Labels and units of states, labels and colours of contact forces, and whether something can slide."""
    names = [symbol.name for symbol in automaton.states]
    forces = {
        name: [text.partition(" (")[0], colour] for name, (text, colour) in force_outputs(automaton).items()
    }
    return {
        "states": names,
        "coordinates": len(model.coordinates),
        "labels": {name: state_label(name) for name in names},
        "units": {name: state_unit(name) for name in names},
        "forces": forces,
        "slides": can_slide_steadily(automaton),
    }


def can_slide_steadily(automaton: HybridAutomaton) -> bool:
    """Whether something slides while all coordinates are at rest: on a belt, say."""
    mode = next(iter(automaton.modes))
    velocities = [e for name, e in mode.outputs.items() if name.startswith("relative_velocity")]
    return any(e.subs({s: 0 for s in e.free_symbols if s.name.endswith("'")}) != 0 for e in velocities)


def mechanism_data(model: Model) -> Data | None:
    """The model's picture as data: what its parts are, and the fields of each."""
    mechanism = model.mechanism
    if isinstance(mechanism, TiltingBelt):
        return {
            "kind": "TiltingBelt",
            "names": {name: aside for name, (_, aside) in SPRING_LABELS.items()},
        }
    if isinstance(mechanism, Mechanism):
        parts = [_part(part) for part in mechanism.parts]
        return {"kind": "Mechanism", "parts": parts, "width": WIDTH, "marks": MARKS}
    return None


def _part(part: Any) -> Data:
    return {"part": type(part).__name__} | {name: _field(value) for name, value in vars(part).items()}


def _field(value: Any) -> Any:
    if isinstance(value, tuple):
        return {"x": value[0], "y": value[1], "right": "", "up": ""}
    return dict(vars(value)) if hasattr(value, "right") else value
