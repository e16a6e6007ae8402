"""Every public name with bad values: of the wrong type or shape, None, NaN, empty, huge, unknown names.

Each *door* is one valid call; then each argument in turn gets each of the bad values.  A call may take the
value, or refuse it by an error that the package raises on purpose, with a message of bounded length.  All
else is raw: an error that comes up from within, memory without bounds.
"""

from __future__ import annotations

import inspect
import io
import opcode
import tempfile
import typing
import warnings
from collections.abc import Callable
from contextlib import redirect_stdout
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import scipy.io
from scipy.stats import uniform

import frictionlab as fl
from frictionlab.analysis import options

MOST_CHARACTERS = 2000  # of a message
QUIET = {"progress": False}
BELT = fl.MassOnBelt(c=0.05)
SLIDER = fl.SliderOnBelt()
# Doors whose valid call takes a second or more.
SLOW_DOORS = {
    *("verify", "ensemble", "steady_state", "bifurcation", "lyapunov", "basins", "basin_stability", "fit"),
    *(
        "periodic_orbit",
        "continue_orbit",
        "optimum",
        "uncertainty",
        "sobol_indices",
        "ablation",
        "sensitivity",
    ),
    *(
        "OrbitAmplitude",
        "OrbitPeriod",
        "OrbitIntensity",
        "explore",
        "explore_bifurcation",
        "explore_stability",
    ),
    *("Fit.item", "Fit.interval", "Uncertainty.quantile", "Uncertainty.probability", "Sensitivity.item"),
    *(
        "HopfPoint.amplitude",
        "HopfPoint.cycle_frequency",
        "testing.check_model",
        "Animation.save",
        "export_page",
    ),
    *("Scipy", "Tableau", "hopf", "plot_run", "animate", "listen", "Sound.save", "FoldValue", "root_locus"),
}
SHORT = {"transient": 2.0, "window": 2.0}


@dataclass
class Door:
    """A valid call: what is called, its valid arguments by name, and those that are not replaced."""

    call: Callable[..., Any]
    valid: dict[str, Any] = field(default_factory=dict)
    fixed: dict[str, Any] = field(default_factory=dict)
    names: tuple[str, ...] | None = None  # of the arguments, where the signature does not have them

    def arguments(self) -> list[str]:
        """Names of the arguments that get bad values."""
        if self.names is not None:
            return list(self.names)
        found = []
        for name, each in inspect.signature(self.call).parameters.items():
            if each.kind is each.VAR_KEYWORD:
                found += _keywords_of(each.annotation)
            elif each.kind is not each.VAR_POSITIONAL:
                found.append(name)
        return [name for name in found if name not in self.fixed]


def _keywords_of(annotation: Any) -> list[str]:
    bundles = {
        "Unpack[ExecutionKeywords]": options.ExecutionKeywords,
        "Unpack[SteadyStateKeywords]": options.SteadyStateKeywords,
        "Unpack[StudyKeywords]": options.StudyKeywords,
    }
    return list(typing.get_type_hints(bundles[annotation])) if annotation in bundles else []


@cache
def _run(t_end: float = 12.0) -> Any:
    return fl.simulate(BELT, t_end, **QUIET)


@cache
def _scratch() -> Path:
    """A new folder with files to read."""
    folder = Path(tempfile.mkdtemp())
    fl.simulate(BELT, 0.5, **QUIET).save(folder / "run.npz")
    fl.bifurcation(BELT, "v", [0.3], **SHORT, **QUIET, workers=1).save(folder / "bifurcation.jsonl")
    scipy.io.mmwrite(folder / "matrix.mtx", np.eye(2))
    (folder / "freedoms.mtx").write_text("1,1, 1,1, 2.0")
    return folder


@cache
def _orbit() -> Any:
    return fl.periodic_orbit(fl.MassOnBelt(), [0.5, 0.2])


def _record() -> Any:
    t = np.linspace(0.1, 1.0, 10)
    return fl.TimeRecord(t, {"x": 0.2 + 0.1 * np.cos(t)}, error=0.01)


def _automaton() -> Any:
    return BELT.automaton()


def _own_mode(**changes: Any) -> Any:
    import sympy as sp

    x = sp.Symbol("x", real=True)
    event = fl.Event(**{"name": "wall", "function": x - 1, "targets": ("on",), **changes.pop("event", {})})
    flow = changes.pop("flow", (sp.Integer(1),))
    mode = fl.Mode(**{"name": "on", "flow": flow, "events": (event,), **changes.pop("mode", {})})
    automaton = fl.HybridAutomaton(**{"states": (x,), "modes": (mode,), "coordinates": 0, **changes})
    return fl.solve(automaton, 0.5, x0=[0.0], **QUIET)


def _drawn(result: Any) -> Any:
    """Draw a picture, so that what it cannot draw is seen."""
    figure = getattr(result, "figure", result)
    if hasattr(figure, "savefig"):
        figure.savefig(io.BytesIO(), format="svg")
        import matplotlib.pyplot as plt

        plt.close("all")
    return result


def _component(kind: type) -> Door:
    """A law or model with one parameter replaced, and what is made of it."""
    return Door(kind)


@cache
def doors() -> dict[str, Door]:
    """Name of the call -> the call; the public name comes before the first point."""
    quantity = fl.CriticalValue("mu_k", (0.0, 4.0))
    pair = {"parameter": "mu_k", "bounds": (0.1, 4.0)}
    near = {"model": SLIDER}
    one = {"workers": 1, "progress": False}
    scratch = _scratch()
    found = {
        "simulate": Door(fl.simulate, {"model": BELT, "t_end": 0.5, **QUIET}),
        "solve": Door(fl.solve, {"automaton": _automaton(), "t_end": 0.5, "x0": [0.0, 0.0], **QUIET}),
        "verify": Door(fl.verify, {"model": BELT, "t_end": 0.5, **QUIET}),
        "ensemble": Door(fl.ensemble, {"models": [BELT, BELT], "t_end": 0.5, **QUIET}),
        "steady_state": Door(fl.steady_state, {"model": BELT, **SHORT, **QUIET}),
        "bifurcation": Door(
            fl.bifurcation, {"model": BELT, "parameter": "v", "values": [0.3], **SHORT, **QUIET, "workers": 1}
        ),
        "lyapunov": Door(fl.lyapunov, {"model": BELT, "transient": 1.0, "t_end": 1.0, "blocks": 2, **QUIET}),
        "basins": Door(
            fl.basins,
            {
                "model": BELT,
                "x": ("x", [0.0, 0.1]),
                "y": ("x'", [0.0, 0.1]),
                "transient": 9.0,
                "window": 9.0,
                **one,
            },
        ),
        "basin_stability": Door(
            fl.basin_stability,
            {
                "model": BELT,
                "ranges": {"x": (0.0, 0.2)},
                "samples": 3,
                "transient": 9.0,
                "window": 9.0,
                **one,
            },
        ),
        "fit": Door(fl.fit, {"model": BELT, "data": _record(), "parameters": ["k"], "segments": 1}),
        "periodic_orbit": Door(
            fl.periodic_orbit, {"model": fl.MassOnBelt(), "guess": [0.5, 0.2], "t_max": 20.0}
        ),
        "continue_orbit": Door(
            fl.continue_orbit,
            {"orbit": None, "parameter": "v", "bounds": (0.19, 0.21), "max_points": 5, **QUIET},
        ),
        "sweep": Door(
            fl.sweep, {"model": BELT, "function": _study, "over": {"v": [0.3]}, "shard": (0, 1), **one}
        ),
        "ablation": Door(fl.ablation, {"model": SLIDER, "studies": _study, "switches": ["cubic"], **one}),
        "sensitivity": Door(fl.sensitivity, {**near, "quantity": quantity}),
        "optimum": Door(fl.optimum, {**near, "quantity": quantity, "bounds": {"F": (150.0, 200.0)}}),
        "uncertainty": Door(
            fl.uncertainty,
            {
                **near,
                "quantity": quantity,
                "distributions": {"F": uniform(150.0, 50.0)},
                "n": 16,
                "rng": 0,
                **one,
            },
        ),
        "sobol_indices": Door(
            fl.sobol_indices,
            {**near, "quantity": quantity, "distributions": {"F": uniform(150.0, 50.0)}, "n": 16, **one},
        ),
        "cea_against_motion": Door(
            fl.cea_against_motion, {"model": BELT, "parameter": "v", "values": [0.3], **SHORT, **one}
        ),
        "equilibrium": Door(fl.equilibrium, near),
        "equilibria": Door(fl.equilibria, near),
        "eigenvalues": Door(fl.eigenvalues, near),
        "linearize": Door(fl.linearize, {**near, "inputs": ["x1"], "outputs": ["y1"]}),
        "LinearSystem.frequency_response": Door(
            fl.linearize(SLIDER).frequency_response, {"frequencies": [5.0, 10.0]}
        ),
        "root_locus": Door(fl.root_locus, {**near, "parameter": "mu_k", "values": [0.5, 1.0]}),
        "stability_changes": Door(fl.stability_changes, {**near, **pair}),
        "critical_value": Door(fl.critical_value, {**near, **pair}),
        "critical_curve": Door(fl.critical_curve, {**near, **pair, "over": ("F", [100.0, 200.0])}),
        "hopf": Door(fl.hopf, {**near, **pair}),
        "stability_map": Door(
            fl.stability_map, {**near, "x": ("mu_k", [0.5, 1.0]), "y": ("F", [100.0, 200.0]), **QUIET}
        ),
        "energy_audit": Door(fl.energy_audit, {"run": _run(), **QUIET}),
        "amplitude_spectrum": Door(fl.amplitude_spectrum, {"run": _run()}),
        "tangent_flow": Door(fl.tangent_flow, {"run": _run(), **QUIET}),
        "load": Door(fl.load, {"path": scratch / "run.npz"}),
        "load_bifurcation": Door(fl.load_bifurcation, {"path": scratch / "bifurcation.jsonl"}),
        "load_basins": Door(fl.load_basins, {"path": scratch / "basins.jsonl"}),
        "plot_run": Door(
            lambda run, figure=None, **k: _drawn(fl.plot_run(run, figure, **k)),
            {"run": _run()},
            names=("run", "figure", "window"),
        ),
        "plot_spectrogram": Door(
            fl.plot_spectrogram,
            {"run": _run(), "f_max": 20.0, "window": 0.25},
            names=("run", "name", "f_max", "window"),
        ),
        "label_modes": Door(fl.label_modes, {"ax": fl.plot_run(_run()).axes[1]}),
        "animate": Door(fl.animate, {"run": _run()}),
        "watch": Door(fl.watch, {"run": _run()}),
        "listen": Door(fl.listen, {"run": _run()}),
        "explore": Door(lambda **k: fl.explore(**k).close(), {"model": BELT}, names=("model", "panels")),
        "explore_bifurcation": Door(
            lambda **k: fl.explore_bifurcation(**k).close(), {**near}, names=("model", "parameter")
        ),
        "explore_stability": Door(
            lambda **k: fl.explore_stability(**k).close(), {**near}, names=("model", "parameter", "over")
        ),
        "export_page": Door(fl.export_page, {"model": BELT, "path": scratch / "page.html"}),
        "style": Door(lambda name: fl.style(name).__enter__(), {"name": "paper"}),
        "progress": Door(lambda shown: fl.progress(shown).__enter__(), {"shown": True}),
        "partial_result": Door(fl.partial_result),
        "list_models": Door(fl.list_models),
        "model": Door(fl.model, {"cls": type("Mine", (fl.MechanicalModel,), {})}),
        "numbered": Door(
            lambda letters, **k: fl.numbered(letters, **k),
            {"letters": "x", "count": "masses", "least": 1, "most": 9},
            names=("letters", "count", "least", "most"),
        ),
        "quadratic_form": Door(fl.quadratic_form, {"matrix": np.eye(2), "x": (1.0, 2.0)}),
        "read_matrix": Door(fl.read_matrix, {"path": scratch / "matrix.mtx"}),
        "read_freedoms": Door(fl.read_freedoms, {"path": scratch / "freedoms.mtx"}),
        "Structure": Door(
            lambda **k: fl.eigenvalues(fl.Structure(**k)),
            {"M": np.eye(2), "K": np.diag([1.0, 2.0])},
            names=("M", "K", "C", "gyroscopic", "circulatory", "load", "parameters", "window"),
        ),
        "AnnularPlate": Door(
            lambda **k: fl.AnnularPlate(**k).matrices(),
            {"inner": 0.05, "outer": 0.14, "thickness": 0.01, "elements": 2, "diameters": 1},
        ),
        "DiscBrake": Door(
            lambda **k: fl.equilibrium(fl.DiscBrake(**k)),
            {"plate": fl.AnnularPlate(elements=2, diameters=1), "pad_angle": 0.5, "points": 2},
        ),
        "BeamOnBelt": Door(lambda **k: fl.equilibrium(fl.BeamOnBelt(**k)), {"elements": 3, "nodes": (-1,)}),
        "reduce": Door(
            fl.reduce,
            {
                "structure": fl.Structure(
                    np.eye(2), [("k", np.eye(2))], parameters={"k": 1.0}, window=(0, 1)
                ),
                "over": {"k": (1.0, 2.0)},
                "tol": 1e-3,
                "basis": fl.RealModes(),
            },
        ),
        "CraigBampton": Door(
            lambda **k: fl.reduce(
                fl.Structure(np.eye(2), np.diag([1.0, 2.0]), window=(0, 1)), basis=fl.CraigBampton(**k)
            ),
            {"interface": (0,)},
        ),
        "modal_damping": Door(
            fl.modal_damping, {"M": np.eye(2), "K": np.diag([1.0, 2.0]), "ratios": [0.1, 0.2]}
        ),
        "relative_rows": Door(fl.relative_rows, {"pairs": [(0, 2), (1, -1)], "size": 3}),
        "SlidingContacts": Door(
            lambda **k: fl.equilibrium(
                fl.Structure(np.eye(2), np.eye(2), load=[0.0, 1.0], contacts=(fl.SlidingContacts(**k),))
            ),
            {
                "tangential": [[1.0, 0.0]],
                "normal": [[0.0, 1.0]],
                "contact": fl.LinearContact(),
                "friction": fl.Coulomb(),
                "v": 1.0,
            },
        ),
        "ramp": Door(fl.ramp, {"t": 1.0, "start": 0.0, "end": 1.0, "duration": 2.0}),
        "table": Door(fl.table, {"t": 1.0, "values": {0.0: 1.0, 2.0: 0.5}}),
        "parameter": Door(
            fl.parameter,
            {"default": 1.0},
            names=(
                "default",
                "symbol",
                "unit",
                "doc",
                "range",
                "log",
                "positive",
                "at_least",
                "below",
                "step",
            ),
        ),
        # classes that users make
        "Taylor": Door(
            lambda **k: fl.simulate(BELT, 0.1, method=fl.Taylor(**k), **QUIET),
            names=("tol", "order", "chatter", "accumulation", "max_steps", "max_events"),
        ),
        "RK4": Door(
            lambda **k: fl.simulate(BELT, 0.01, method=fl.RK4(**k), **QUIET),
            names=("step", "max_steps", "max_events"),
        ),
        "Scipy": Door(
            lambda **k: fl.simulate(BELT, 0.01, method=fl.Scipy(**k), **QUIET),
            names=("integrator", "rtol", "atol", "max_step", "max_steps", "max_events"),
        ),
        "Tableau": Door(_own_method, {}, names=("stages", "weights", "divisor")),
        "SteadyStateOptions": Door(fl.SteadyStateOptions),
        "TimeRecord": Door(fl.TimeRecord, {"t": [0.1, 0.2], "values": {"x": [0.1, 0.2]}}),
        "EventTimes": Door(fl.EventTimes, {"t": [0.1, 0.2], "target": "stick"}),
        "Frequencies": Door(fl.Frequencies, {"values": {0: 1.0}}),
        "SpectrumRecord": Door(
            fl.SpectrumRecord, {"t": [0.1, 0.2, 0.3], "frequencies": [1.0], "values": {"x": [0.1]}}
        ),
        "SpectrumRecord.from_record": Door(
            fl.SpectrumRecord.from_record, {"record": _record(), "frequencies": [1.0]}
        ),
        "CriticalValue": _quantity(fl.CriticalValue, pair),
        "CriticalFrequency": _quantity(fl.CriticalFrequency, pair),
        "FoldValue": _quantity(fl.FoldValue, pair),
        "GrowthRate": _quantity(fl.GrowthRate, {}),
        "ModeFrequency": _quantity(fl.ModeFrequency, {}),
        "EquilibriumCoordinate": _quantity(fl.EquilibriumCoordinate, {"name": "x1"}),
        "ParameterValue": _quantity(fl.ParameterValue, {"name": "F"}),
        "OrbitAmplitude": Door(fl.OrbitAmplitude, {"name": "x"}),
        "OrbitPeriod": Door(fl.OrbitPeriod),
        "OrbitIntensity": Door(fl.OrbitIntensity),
        "Curve": Door(
            lambda **k: _drawing(curves={"a": fl.Curve(**k)}),
            {"x": [0.0, 1.0], "y": [0.0, 1.0]},
            names=("x", "y", "style", "axis"),
        ),
        "Drawing": Door(
            lambda **k: _drawing(**k),
            {},
            names=("xlabel", "ylabel", "curves", "right", "yscale", "note", "xlim", "ylim", "progress"),
        ),
        "Mode": Door(
            lambda **k: _own_mode(mode=k), names=("name", "flow", "events", "constraints", "outputs", "limit")
        ),
        "Event": Door(
            lambda **k: _own_mode(event=k), names=("name", "function", "targets", "reset", "accumulation")
        ),
        "Reset": Door(lambda **k: _own_mode(event={"reset": fl.Reset(**k)}), names=("jump", "vanishing")),
        "HybridAutomaton": Door(_own_mode, names=("states", "modes", "parameters", "coordinates")),
        "HybridAutomaton.replace": Door(_automaton().replace, {}, names=("v", "vv")),
        "HybridAutomaton.mode": Door(_automaton().mode, {"name": "stick"}),
        "Model.replace": Door(SLIDER.replace, {}, names=("v", "vv", "contact")),
        "Model.without": Door(lambda name: SLIDER.without(name), {"name": "cubic"}),
        "Model.equations": Door(SLIDER.equations, {"mode": "stick"}),
        "Model.from_dict": Door(fl.Model.from_dict, {"data": SLIDER.to_dict()}),
        # methods of results
        "Trajectory.call": Door(_run(), {"t": 0.5}),
        "Trajectory.item": Door(lambda name: _run()[name], {"name": "x"}),
        "Trajectory.output": Door(_run().output, {"name": "friction_force"}),
        "Trajectory.modes_at": Door(_run().modes_at, {"t": 0.5}),
        "Trajectory.states_and_modes": Door(_run().states_and_modes, {"t": 0.5}),
        "Trajectory.save": Door(_run().save, {"path": scratch / "run.npz"}),
        "Trajectory.plot": Door(lambda **k: _drawn(_run().plot(**k)), {}, names=("ax", "window")),
        "Events.item": Door(lambda index: _run().events[index], {"index": "stick"}),
        "SteadyState.spectrum": Door(_steady().spectrum),
        "Spectrum.peaks": Door(_spectrum().peaks),
        "Spectrum.plot": Door(lambda **k: _drawn(_spectrum().plot(**k)), names=("ax",)),
        "Bifurcation.section": Door(_bifurcation().section, {"name": "x"}),
        "Bifurcation.save": Door(_bifurcation().save, {"path": scratch / "bifurcation.jsonl"}),
        "Sound.save": Door(lambda path: _sound().save(path), {"path": scratch / "sound.wav"}),
        "Animation.save": Door(
            lambda path: fl.animate(_run(1.0), window=(0.0, 0.1)).save(path), {"path": scratch / "film.gif"}
        ),
        "Fit.item": Door(lambda parameter: _fit()[parameter], {"parameter": "k"}),
        "Fit.interval": Door(
            lambda **k: _fit().interval(**k), {"parameter": "k"}, names=("parameter", "level")
        ),
        "Uncertainty.quantile": Door(lambda share: _uncertainty().quantile(share), {"share": 0.5}),
        "Uncertainty.probability": Door(
            lambda **k: _uncertainty().probability(**{"below": 1.0, **k}), {}, names=("below", "above")
        ),
        "Sensitivity.item": Door(lambda parameter: _sensitivity()[parameter], {"parameter": "F"}),
        "HopfPoint.amplitude": Door(lambda value: _hopf().amplitude(value), {"value": 1.0}),
        "HopfPoint.cycle_frequency": Door(lambda value: _hopf().cycle_frequency(value), {"value": 1.0}),
        "testing.check_law": Door(fl.testing.check_law, {"law": fl.LinearContact()}),
        "testing.check_model": Door(fl.testing.check_model, {"model": BELT, "t_end": 0.1}),
    }
    for name in fl.__all__:
        kind = getattr(fl, name)
        if isinstance(kind, type) and name not in found and (_is_law(kind) or _is_model(kind)):
            found[name] = Door(kind)
    return found


def _is_law(kind: type) -> bool:
    from frictionlab.components.component import Component

    return issubclass(kind, Component) and not issubclass(kind, fl.Model)


def _is_model(kind: type) -> bool:
    return issubclass(kind, fl.Model) and kind not in (fl.Model, fl.MechanicalModel)


def _quantity(kind: Any, valid: dict[str, Any]) -> Door:
    return Door(lambda **k: kind(**k)(SLIDER), valid, names=tuple(inspect.signature(kind).parameters))


def _study(model: Any, x0: Any = None) -> float:
    return 1.0


def _own_method(**changes: Any) -> Any:
    given = {"stages": ((), (1.0,)), "weights": (1.0, 1.0), "divisor": 2.0, **changes}

    class Heun(fl.OneStepMethod):
        name = "heun"
        tableau = fl.Tableau(**given)

    return fl.simulate(BELT, 0.01, method=Heun(step=1e-3), **QUIET)


def _drawing(**changes: Any) -> Any:
    given = {"xlabel": "x", "ylabel": "y", "curves": {"a": fl.Curve([0.0, 1.0], [0.0, 1.0])}, **changes}
    return fl.Drawing(**given)


@cache
def _steady() -> Any:
    return fl.steady_state(BELT, transient=5.0, window=30.0, **QUIET)


@cache
def _spectrum() -> Any:
    return fl.amplitude_spectrum(_run(40.0))


@cache
def _bifurcation() -> Any:
    return fl.bifurcation(BELT, "v", [0.3], **SHORT, **QUIET, workers=1)


@cache
def _sound() -> Any:
    return fl.listen(_run())


@cache
def _fit() -> Any:
    return fl.fit(BELT, _record(), ["k"], segments=1)


@cache
def _uncertainty() -> Any:
    quantity = fl.CriticalValue("mu_k", (0.0, 4.0))
    return fl.uncertainty(SLIDER, quantity, {"F": (150.0, 200.0)}, n=16, workers=1, **QUIET)


@cache
def _sensitivity() -> Any:
    return fl.sensitivity(SLIDER, fl.CriticalValue("mu_k", (0.0, 4.0)))


@cache
def _hopf() -> Any:
    return fl.hopf(SLIDER, "mu_k", (0.1, 4.0))


def bad_values() -> dict[str, Any]:
    """What arguments are replaced by, by a name for messages; anew for each call, as iterators run out."""
    return {
        "None": None,
        "True": True,
        "minus one": -1,
        "half": 0.5,
        "NaN": float("nan"),
        "infinity": float("inf"),
        "complex": 1.0 + 1.0j,
        "10**400": 10**400,
        "1e300": 1e300,
        "10**9": 10**9,
        "text": "unknown",
        "no text": "",
        "long text": "x" * 100_000,
        "bytes": b"x",
        "null byte": "a\0b",
        "object": object(),
        "function": lambda value: value,
        "class": int,
        "class of model": fl.MassOnBelt,
        "model": fl.DenHartog(),
        "law": fl.LinearContact(),
        "empty list": [],
        "list of None": [None],
        "list of text": ["a", "b"],
        "ragged": [[1.0, 2.0], [3.0]],
        "long list": list(range(100_000)),
        "cube": np.zeros((2, 3, 4)),
        "empty array": np.zeros(0),
        "array of text": np.array(["a", "b"]),
        "masked": np.ma.masked_array([1.0, 2.0], [False, True]),
        "complex array": np.array([1j, 2.0]),
        "NaNs": [float("nan"), float("nan")],
        "pair of text": ("unknown", "unknown"),
        "name and None": ("unknown", None),
        "name and numbers": ("x", [0.0, float("nan")]),
        "reversed pair": (2.0, 1.0),
        "empty mapping": {},
        "mapping": {"unknown": 1.0},
        "mapping to None": {None: None},
        "mapping to numbers": {"F": [1.0, 2.0]},
        "long key": {"x" * 100_000: 1.0},
        "many keys": {f"x{i}": 1.0 for i in range(10_000)},
        "list of long text": ["x" * 100_000, "x" * 100_000],
        "pair with long text": ("x" * 100_000, [0.0, 1.0]),
        "list of 10**400": [10**400, 10**400],
        "10**5000": 10**5000,  # which Python does not write
        "set": {1.0, 2.0},
        "iterator": iter([1.0]),
        "Path": Path("unknown"),
        "date": np.datetime64("2020-01-01"),
        "nested": {"a": {"b": [1, {"c": None}]}},
    }


@dataclass
class Found:
    """What came of a call: "taken", "refused", "raw", "long", "unnamed", and more about it."""

    verdict: str
    about: str = ""


def try_value(door: Door, argument: str, value: Any) -> Found:
    """Call a door with one argument replaced."""
    given = {**door.fixed, **door.valid, argument: value}
    if "orbit" in given and given["orbit"] is None and argument != "orbit":
        given["orbit"] = _orbit()
    try:
        with warnings.catch_warnings(), redirect_stdout(io.StringIO()):
            warnings.simplefilter("ignore")
            with np.errstate(all="ignore"):
                door.call(**given)
    except Exception as error:
        return _judge(error, argument)
    return Found("taken")


def _judge(error: BaseException, argument: str) -> Found:
    trace = error.__traceback__
    while trace.tb_next is not None:
        trace = trace.tb_next
    code, file = trace.tb_frame.f_code, trace.tb_frame.f_code.co_filename
    where = f"{Path(file).name}:{trace.tb_lineno}"
    text = f"{type(error).__name__}: {str(error)[:300]} ({where})"
    raised = code.co_code[trace.tb_lasti] == opcode.opmap["RAISE_VARARGS"]
    if file == __file__:  # our own call: Python's answer to an argument that is missing, or a bad function
        return Found("refused" if isinstance(error, TypeError) else "raw", text)
    if "/frictionlab/" not in file or not raised or not str(error):
        return Found("raw", text)
    if len(str(error)) > MOST_CHARACTERS:
        return Found("long", text)
    if isinstance(error, (ValueError, TypeError, OSError, LookupError, RuntimeError, AssertionError)):
        return Found("refused", text)
    return Found("raw", text)
