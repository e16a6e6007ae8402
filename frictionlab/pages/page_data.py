"""The data of a page: the structures of a model, its sliders, switches and scenes, checked.

A structure is the tape's arrays, its numbers, outputs and equilibria.  The arrays are those with which a run
in Python would begin, made by the same functions, so that the page need not know their shapes: each has a
name, such as ``code.ops``, a type, lengths, and its content where it is not all zeros.
"""

from __future__ import annotations

import base64
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import combinations, islice
from typing import Any

import numpy as np

from frictionlab.analysis.initial_states import initial_state_of
from frictionlab.automaton import HybridAutomaton, Mode
from frictionlab.components.component import StructureKey
from frictionlab.hybrid.chatter_limit import CHATTER, formulas_of_rate
from frictionlab.hybrid.kernels.run_state import (
    JETS_READY,
    STOPS_AT_ZENO,
    new_record,
    new_run_state,
    new_scratch,
)
from frictionlab.hybrid.methods.base import RECORD_CAPACITY
from frictionlab.hybrid.methods.taylor import Taylor, is_affine, new_affine_map
from frictionlab.lazy_names import sympy as sp
from frictionlab.models import Model
from frictionlab.models.kept_structures import derivations_of
from frictionlab.models.model import automaton_of, nonlinearities_in, values_of
from frictionlab.models.symbolic_laws import symbolic_copy
from frictionlab.models.symbols import symbol
from frictionlab.pages.cases import picture_data, rule_data
from frictionlab.pages.javascript import JavaScript, javascript_function, javascript_of_formulas
from frictionlab.pages.python_text import Place, python_text
from frictionlab.pages.scene import (
    MAX_MODES,
    Shown,
    has_friction_curve,
    law_menus,
    main_parameters,
    mode_data,
    name_of,
    own_law,
    quantity_data,
)
from frictionlab.plotting.appearance import looks_by_whole
from frictionlab.stability import equilibrium
from frictionlab.stability.equilibrium_points.steady_rates import is_free, steady_rates
from frictionlab.tape.formulas import Formulas, formulas_of, kept_formulas
from frictionlab.tape.packing import program_of
from frictionlab.tape.program import Program
from frictionlab.validation import (
    abbreviate,
    check_limits,
    check_mapping,
    check_sequence,
    did_you_mean_or_known,
)

# The laws that pages offer unless others are asked for, where the model has few modes: with more, each would
# take seconds to derive.
PAGE_LAWS = "Coulomb", "exponential decay", "hyperbolic decay", "Stribeck", "weakening-strengthening"
MODES_WITH_LAWS = 5


def structure_data(model: Shown) -> dict[str, Any]:
    """All that a page needs of the structure of a model or an automaton.

    Raises
    ------
    ValueError
        Where the model has more than 64 modes.
    """
    method = Taylor()
    automaton, names = automaton_of(model), automaton_of(model).names
    if len([*islice(names, MAX_MODES + 1)]) > MAX_MODES:
        raise ValueError(
            f"a page holds at most {MAX_MODES} modes, and {name_of(model)} has more: "
            "take a model with fewer contacts, or laws of fewer pieces or elements"
        )
    place_of, automaton = automaton.place_of_mode, automaton.derived()
    modes = tuple(automaton.modes)
    wholes = {mode.name: mode.name if mode.whole is None else mode.whole.name for mode in modes}
    program, _ = program_of(automaton)
    parameters = tuple(automaton.parameters)
    known = values_of(model)
    return {
        "parameters": [symbol.name for symbol in parameters],
        "fixed": {s.name: float(v) for s, v in automaton.parameters.items() if s.name not in known},
        **quantity_data(model, automaton),
        **mode_data(looks_by_whole([(place_of(name), name) for name in program.modes], wholes), wholes),
        "guards": list(program.guards),
        "affine": bool(is_affine(program)),
        "order": method.order_of(program),
        "constants": len(program.code.ops),
        "terms": len(program.number_places) - len(program.code.ops) + len(program.shared_terms),
        "numbers": javascript_of_formulas(program.formulas, [len(parameters)]),
        "rate": _rate_of_limit_mode(automaton),
        "release": javascript_function([parameters], _release(model, automaton)),
        "arrays": run_arrays(program, method),
        "outputs": _outputs(modes, automaton, parameters),
        "sliding": [
            _sliding(mode, i, automaton, parameters)
            for i, mode in enumerate(modes)
            if is_free(automaton, mode)
        ],
        "rules": rule_data(model, parameters),
        "friction": _friction_force(model, tuple(automaton.values)),
        "mechanism": picture_data(model, parameters),
        "python": python_text(model, Place("duration"), Place("start"), method, {n: Place(n) for n in known}),
        "near": _known_equilibrium(model, automaton),
    }


def _rate_of_limit_mode(automaton: HybridAutomaton) -> JavaScript | None:
    """What the limit of chatter follows from, as a JavaScript function of parameters; None without one."""
    if CHATTER not in automaton.values:
        return None
    return javascript_of_formulas(formulas_of_rate(automaton), [len(automaton.parameters)])


def _release(model: Shown, automaton: HybridAutomaton) -> list[Any]:
    """The state at rest: formulas of the parameters or, without such formulas, the numbers of this model."""
    names = automaton.state_names
    if not isinstance(model, Model):
        return [0.0] * len(names)
    try:
        released = symbolic_copy(model.structure_key).release()
    except (TypeError, AttributeError):  # `release` needs numbers, as to compare them
        return [float(value) for value in initial_state_of(model, "rest", automaton)]
    return [sp.sympify(released.get(name, 0.0), strict=True) for name in names]


def _friction_force(model: Shown, names: tuple[str, ...]) -> JavaScript | None:
    if not isinstance(model, Model) or not has_friction_curve(model):
        return None
    return javascript_of_formulas(friction_formulas(model.structure_key, names), [2, len(names)])


def friction_formulas(key: StructureKey, names: tuple[str, ...]) -> Formulas:
    """The force of a law of friction and its slope, as formulas of speed, normal force and the parameters of
    these names."""

    def derive() -> Formulas:
        speed, normal_force = sp.symbols("speed normal_force", real=True)
        force = symbolic_copy(key).friction.kinetic(normal_force, speed)
        formulas = formulas_of([speed, normal_force, *map(symbol, names)], [force, 0])
        slope = _whole_jacobian(formulas, 1)
        return Formulas(slope.tape, (formulas.outputs[0], *slope.outputs))

    return kept_formulas(derivations_of(key), f"friction of {', '.join(names)}", derive)


def run_arrays(program: Program, method: Taylor) -> list[dict[str, Any]]:
    """The arrays and numbers that the kernels take for a run, each with its name there."""
    code = program.code
    run = new_run_state(code.inputs, code.sections.shape[1])
    run.counts[JETS_READY], run.counts[STOPS_AT_ZENO] = 1, method.accumulation == "raise"
    parts: dict[str, Any] = {
        "code": code,
        "run": run,
        "record": new_record(code, RECORD_CAPACITY, RECORD_CAPACITY, 0),
        "scratch": new_scratch(program.slots, code, method.order_of(program)),
        "candidates": program.initial,
        "shared_terms": program.shared_terms,
    }
    if is_affine(program):
        parts["change"] = new_affine_map(code)
    return [data for name, part in parts.items() for data in _arrays(name, part)]


def _arrays(name: str, value: Any) -> Iterator[dict[str, Any]]:
    """The arrays and numbers of nested tuples; their fields are in the names."""
    if isinstance(value, tuple):
        for field, part in zip(getattr(value, "_fields", range(len(value))), value, strict=True):
            yield from _arrays(f"{name}.{field}", part)
    elif isinstance(value, np.ndarray):
        data = {"name": name, "type": value.dtype.str[1:], "shape": list(value.shape)}
        if not name.startswith("record.") and value.any():  # a record holds nothing yet
            data["data"] = base64.b64encode(np.ascontiguousarray(value).tobytes()).decode()
        yield data
    else:
        yield {"name": name, "value": value}


def _outputs(modes: tuple[Mode, ...], automaton: HybridAutomaton, parameters: Any) -> dict[str, Any]:
    """Names of the outputs that all modes have, and a function of state and parameters for each mode."""
    shared = [name for name in modes[0].outputs if all(name in mode.outputs for mode in modes)]
    arguments = (automaton.states, parameters)
    functions = [javascript_function(arguments, [mode.outputs[name] for name in shared]) for mode in modes]
    return {"names": shared, "functions": functions}


def _sliding(mode: Mode, number: int, automaton: HybridAutomaton, parameters: Any) -> dict[str, Any]:
    """Flow, its Jacobian and the event functions of a mode, from which the page finds equilibria; and the
    places of states that follow from the others, as the angle in steady rotation."""
    steady = steady_rates(automaton, mode)
    arguments, flow = (automaton.states, parameters), list(steady.rates)
    lengths = [len(flow), len(parameters)]
    formulas = formulas_of([*automaton.states, *parameters], [*flow, 0])
    return {
        "mode": number,
        "following": list(steady.following),
        "flow": javascript_function(arguments, flow),
        "jacobian": javascript_of_formulas(_whole_jacobian(formulas, len(flow)), lengths),
        "guards": javascript_function(arguments, [event.function for event in mode.events]),
    }


def _whole_jacobian(formulas: Formulas, size: int) -> Formulas:
    """All entries of the Jacobian by the states, row after row; the last of the formulas is zero."""
    places, entries = formulas.jacobian(range(size))
    known = dict(zip(places, entries.outputs, strict=True))
    zero = formulas.outputs[-1]  # derivatives are appended to the tape, so that its slots stay
    slots = (known.get((i, j), zero) for i in range(size) for j in range(size))
    return Formulas(entries.tape, tuple(slots))


def _known_equilibrium(model: Shown, automaton: HybridAutomaton) -> list[float]:
    """Where the search for the equilibrium begins: at that of this model, or at zero."""
    try:
        return equilibrium(model).state.tolist()
    except (ValueError, ArithmeticError):
        return [0.0] * len(automaton.states)


def switch_names(model: Any, switches: Sequence[str] | None) -> tuple[str, ...]:
    """The nonlinearities that get a switch; those that the model lacks already get none."""
    known = {name: each for name, each in nonlinearities_in(model).items() if not each.missing(model)}
    if switches is None:
        return tuple(name for name in known if _can_be_switched(model, name))
    switches = check_sequence("switches", switches, "give names of nonlinearities in a list")
    _check_names("switches", "nonlinearity", switches, list(known))
    return switches


def _check_names(where: str, kind: str, names: Iterable[Any], known: Sequence[str]) -> None:
    for name in names:
        if not isinstance(name, str) or name not in known:
            hint = did_you_mean_or_known(name, known)
            raise ValueError(f"{where} has no {kind} {abbreviate(name)}{hint}")


def _can_be_switched(model: Any, name: str) -> bool:
    try:
        model.without(name)
    except ValueError:  # a law that cannot do without its nonlinearity
        return False
    return True


def structures(model: Any, switches: Sequence[str]) -> dict[str, Any]:
    """The model for every set of switches that are off; the key is their names, joined by commas."""
    sets = [some for k in range(len(switches) + 1) for some in combinations(switches, k)]
    return {",".join(some): model.without(*some) if some else model for some in sets}


def page_laws(model: Any, laws: Sequence[str] | None) -> dict[str, Model]:
    """The model with each law of friction that its page offers, by the law's name, its own first; empty where
    there is nothing to choose.

    Raises
    ------
    ValueError
        For a name that is none of the menu of `friction`.
    """
    menu = law_menus(model).get("friction", {})
    if laws is None:
        few = bool(menu) and len(model.automaton().modes) <= MODES_WITH_LAWS
        laws = [name for name in PAGE_LAWS if name in menu] if few else []
    names = check_sequence("laws", laws, "give names of laws in a list")
    _check_names("laws", "law of friction", names, list(menu))
    others = [name for name in names if name != own_law(model, "friction")]
    if not others:
        return {}
    return {own_law(model, "friction"): model} | {name: model.replace(friction=menu[name]) for name in others}


def chosen_sliders(model: Shown, sliders: Any) -> tuple[list[str], dict[str, tuple[float, float]]]:
    """The parameters whose sliders are shown at first, and the ranges that were given for them."""
    if sliders is None:
        return main_parameters(model), {}
    ranged = isinstance(sliders, Mapping)
    chosen = sliders if ranged else check_sequence("sliders", sliders, "give names of parameters in a list")
    _check_names("sliders", "parameter", chosen, list(values_of(model)))
    return list(chosen), {
        name: check_limits(f"the range of slider {name!r}", ends, "give (low, high)")
        for name, ends in (sliders.items() if ranged else ())
    }


def scene_menu(model: Shown, switches: Sequence[str], presets: Any) -> list[dict[str, Any]]:
    """The scenes of a page, each with its name and the state of the controls that differ."""
    presets = {} if presets is None else presets
    check_mapping("presets", presets, 'give each a name, such as {"flutter": {"mu_k": 1.4}}')
    made = [_preset(model, switches, name, values) for name, values in presets.items()]
    return [{"name": "", "label": "as exported", "state": {}}, *made] if made else []


def _preset(model: Shown, switches: Sequence[str], name: str, values: Any) -> dict[str, Any]:
    check_mapping(f"presets[{abbreviate(name)}]", values, 'give values, such as {"mu_k": 1.4}')
    values = dict(values)
    off = values.pop("without", ())
    off = [off] if isinstance(off, str) else list(check_sequence("without", off, "give names in a list"))
    _check_names(f"presets[{abbreviate(name)}]", "switch", off, switches)
    model.replace(**values)  # raises for unknown names and values that break a rule
    state = {key: float(value) for key, value in values.items()}
    return {"name": name, "state": state | {f"switch-{switch}": False for switch in off}}
