"""The front end of `frictionlab.pages` as a widget, whose engine is this process.

Three values go to the browser: the scene, the state of the controls, and the result of a state, whose arrays
travel as binary.  The browser sends the state back when a control is moved.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Mapping
from typing import Any

import anywidget
import numpy as np
import traitlets
from matplotlib.colors import to_hex

from frictionlab.analysis.motion_scales import time_of_rest
from frictionlab.automaton import HybridAutomaton
from frictionlab.hybrid.outputs import evaluate_outputs
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.models.kept_structures import derivations_of
from frictionlab.models.model import Model, automaton_of, values_of
from frictionlab.pages.export import FRONT_END, script_text, text_of
from frictionlab.pages.page_data import friction_formulas
from frictionlab.pages.python_text import python_text
from frictionlab.pages.scene import (
    ONE_CONTACT,
    Data,
    Shown,
    friction_points,
    has_friction_curve,
    mechanism_data,
    mode_data,
    quantity_data,
)
from frictionlab.plotting.appearance import DASHED, LINE_COLOURS, mode_looks, whole_names
from frictionlab.plotting.figure import Curve, Drawing
from frictionlab.presentation import tally
from frictionlab.widgets.result import Array, Result

from .sound import listen

MARKERS = {".": "o", "_": "_", "o": "o", "s": "s", "^": "^", "D": "D", "+": "+", "x": "x"}
SOLID = "-", "solid"
TURN_OF_FORCE = "period"  # the event at each period of a force in time, which is no impact
NO_LINE = "none", "None", "", " "
FRICTION_REACH, FRICTION_SAMPLES = 1.1, 200  # of a friction curve; as in pages/scripts/browser_engine.js


class FrontEnd(anywidget.AnyWidget):
    """The front end in a notebook or an application.

    Attributes
    ----------
    scene, state, picture : dict
        What is shown, what the controls are set to, and the result of that.
    error : str
        Why the present state has no result; empty where it has one.
    limits : dict
        The last value of a parameter that was moved too far.
    sliding : bool
        Whether a slider moves: what takes long waits until it stops.
    shown : bool
        Whether a browser shows it.
    computing : bool
        Whether a result is being computed.  Only then does the button "stop" interrupt the kernel, which may
        run a cell.
    """

    _esm = script_text((*FRONT_END, "python_engine"))
    _css = text_of("explorer.css")
    scene = traitlets.Dict().tag(sync=True)
    state = traitlets.Dict().tag(sync=True)
    picture = traitlets.Dict().tag(sync=True)
    error = traitlets.Unicode().tag(sync=True)
    limits = traitlets.Dict().tag(sync=True)
    sliding = traitlets.Bool(False).tag(sync=True)
    shown = traitlets.Bool(False).tag(sync=True)
    computing = traitlets.Bool(False).tag(sync=True)

    def __init__(self) -> None:
        super().__init__()
        self.run: Any = None
        self.answers: dict[str, Callable[[Any], None]] = {"hear": self._send_sound}  # by what is asked
        self.on_msg(self._answer)

    def _answer(self, _: Any, content: Any, __: Any) -> None:
        for name, about in content.items():
            if name in self.answers:  # a run that is watched cannot be stopped: it is there as a whole
                self.answers[name](about)

    def _send_sound(self, _: Any) -> None:
        """Send what the run sounds like, or why it makes no sound."""
        try:
            sound = listen(self.run)
        except ValueError as error:
            self.send({"text": str(error)})
            return
        silent = not sound.samples.any()
        signal = sound.signal.replace("_", " ")
        text = "it makes no sound" if silent else f"{signal}, {sound.pitch:.3g} times as high as it is"
        samples = np.round(sound.samples * np.iinfo(np.int16).max).astype("<i2")
        self.send({"text": text, "rate": sound.rate}, [samples.tobytes()])


def result_data(
    result: Result,
    drawings: Mapping[str, Drawing | bytes],
    needed: Container[str],
    complete: bool = True,
) -> Data:
    """A result as the front end takes it, with what is needed of "run", "spectrum" and "friction".

    While a slider moves it is not complete: the spectrum and what the words say of the run are left out.
    """
    model, settings = result.model, result.settings
    if "run" in needed:
        shown = run_data(result)
    else:
        shown = {"structure": quantities_of(model), "finished": True, "status": ""}
    known = result.eigenvalues  # after the run, whose error names the parameter that has no value
    point = None if known is None else known.equilibrium
    if complete:
        shown["python"] = python_text(model, settings.t_end, settings.x0, settings.method)
    if "run" in needed and complete:
        shown |= facts(result) | {"spectrum": spectrum_data(result) if "spectrum" in needed else None}
    data: Data = {
        "parameters": dict(values_of(model)),
        "coordinate": settings.coordinate,
        "from": settings.x0 if isinstance(settings.x0, str) else "own",
        "eigenvalues": None if known is None else [[v.real, v.imag] for v in known.values.tolist()],
        "equilibrium": point
        and {
            "state": point.state.tolist(),
            **{
                name: float(value) if np.isfinite(value := getattr(point, name)) else None
                for name in ("penetration", *ONE_CONTACT)
            },
        },
        "friction": friction_data(result) if "friction" in needed else None,
        "complete": complete,
        "drawings": {name: drawing_data(drawing) for name, drawing in drawings.items()},
        "progress": next(filter(None, map(progress_of, drawings.values())), None),
    }
    return data | shown


def quantities_of(model: Shown, run: Trajectory | None = None) -> Data:
    """What `quantity_data` says of a model, and the modes that a run knows, with how they look.

    The last of a structure is kept: it changes where a run comes to know a further mode.
    """
    kept = {} if isinstance(model, HybridAutomaton) else derivations_of(model.structure_key).objects
    modes = None if run is None else run.mode_names
    if "quantities" in kept and kept["quantities"][0] == modes:
        return kept["quantities"][1]
    found = quantity_data(model, automaton_of(model) if run is None else run.automaton)
    if run is not None:
        looks = mode_looks(run)
        found |= mode_data({name: looks[name] for name in run.mode_names}, whole_names(run))
    kept["quantities"] = modes, found
    return found


def friction_data(result: Result) -> Data | None:
    """The friction curve: speeds and coefficients; None without a law that is a curve.

    ``at`` holds the speed of steady sliding, the coefficient and its slope (s/m) there, and the damper
    (N s/m) that has the same force; None where several contacts have the law, each with a speed of its own.
    """
    model = result.model
    if not isinstance(model, Model) or not has_friction_curve(model):
        return None
    automaton = model.automaton()
    formulas = friction_formulas(model.structure_key, tuple(automaton.values))
    values, known = tuple(automaton.values.values()), result.eigenvalues
    point = None if known is None else known.equilibrium
    last = max((model.parameters[speed] for speed, _ in friction_points(model) if speed), default=0.0)
    if point is None or "relative_velocity" not in automaton.outputs:  # one curve, but several contacts
        speeds = np.linspace(0.0, FRICTION_REACH * (last or 1.0), FRICTION_SAMPLES)
        return {"speeds": packed(speeds), "mu": packed(formulas.arrays(speeds, 1.0, *values)[0]), "at": None}
    mode, normal = next(iter(automaton.names)), point.normal_force
    of_sliding = evaluate_outputs(automaton, ["relative_velocity"], point.state[None], np.zeros(1), [mode])
    slip = abs(of_sliding["relative_velocity"][0])
    speeds = np.linspace(0.0, FRICTION_REACH * max(last, slip), FRICTION_SAMPLES)
    force, damper = formulas.numbers(slip, normal, *values)
    mu = np.broadcast_to(formulas.arrays(speeds, normal, *values)[0], speeds.shape) / normal
    at = [float(slip), float(force / normal), float(damper / normal), float(damper)]
    return {"speeds": packed(speeds), "mu": packed(mu), "at": at}


def run_data(result: Result) -> Data:
    """The run, sampled over the part that is shown, and its end."""
    run, samples = result.run, result.samples()
    codes = run.raw.event_codes[run.raw.event_times > samples[0][0], 0]
    guards = {(*run.problem.program.guards, "")[code] for code in codes.tolist()}
    return sampled_run(run, result.model, *samples) | {
        "mode": run.mode_names[run.raw.step_modes[-1]] if len(run.raw.step_modes) else "",
        "struck": bool(guards - {TURN_OF_FORCE}),
    }


def facts(result: Result) -> Data:
    """What the run does at its end."""
    moving = result.is_moving
    return {
        "moving": moving,
        "decays": result.decays if moving else False,
        "rest": None if moving else time_of_rest(result.run),
    }


def sampled_run(run: Trajectory, model: Shown, times: Array, states: Array, modes: Any) -> Data:
    """A run at times (N,), with its states (N, n) and modes (N,) there."""
    automaton, names = run.automaton, run.mode_names
    columns = {name: states[:, i] for i, name in enumerate(run.names)}
    columns |= evaluate_outputs(automaton, automaton.outputs, states, modes, names)
    return {
        "structure": quantities_of(model, run),
        "mechanism": mechanism_data(model),
        "samples": {
            "times": packed(times),
            "modes": packed(modes),
            "columns": {name: packed(values) for name, values in columns.items()},
        },
        "start": float(times[0]),
        "stop": float(times[-1]),
        "size": float(np.abs(states[:, : len(automaton.shown_states)]).max()),
        "finished": run.status.ok and run.warning is None,
        "status": run_text(run),
    }


def run_text(run: Trajectory) -> str:
    """How a run ended: its steps and events, or a warning."""
    if not run.status.ok:
        return f"The run ended at {run.raw.t:.4g} s: {run.status}."
    if run.warning is not None:
        return f"Do not trust this picture: {run.warning}."
    stats = run.stats
    named = "" if isinstance(run.source, Model) or not len(run.events) else f" ({tally(run.events.guard)})"
    return (
        f"The end was reached. {stats['steps']} steps, {stats['events']} events{named}, "
        f"solved in {1e3 * stats['wall_time']:.1f} ms"
    )


def spectrum_data(result: Result) -> Data | None:
    """Frequencies and amplitudes; None where the run is too short."""
    found = result.spectrum
    if found is None:
        return None
    return {
        "frequencies": packed(found.frequencies),
        "amplitudes": packed(found.amplitudes),
        "strongest": float(found.strongest),
        "largest": float(found.amplitudes.max()),
    }


def packed(values: Any) -> bytes:
    """Numbers as 64-bit floats."""
    return np.ascontiguousarray(values, dtype="<f8").tobytes()


def progress_of(drawing: Drawing | bytes) -> list[int] | None:
    """Parts of a drawing that are computed, and their total; None where all are."""
    return None if isinstance(drawing, bytes) or not drawing.progress else list(drawing.progress)


def drawing_data(drawing: Drawing | bytes) -> Data:
    """A drawing as the front end takes it."""
    if isinstance(drawing, bytes):
        return {"image": drawing}
    curves = sorted(enumerate(drawing.curves.items()), key=lambda item: item[1][1].style.get("zorder", 2.0))
    return {
        "xlabel": drawing.xlabel,
        "ylabel": drawing.ylabel,
        "right": drawing.right,
        "log": drawing.yscale == "log",
        "note": drawing.note,
        "xlim": drawing.xlim and [float(x) for x in drawing.xlim],
        "ylim": drawing.ylim and [float(y) for y in drawing.ylim],
        "curves": [_curve(label, curve, place) for place, (label, curve) in curves],
    }


def _curve(label: str, curve: Curve, place: int) -> Data:
    style = curve.style
    line, marker = style.get("linestyle", "-"), style.get("marker")
    return {
        "label": label,
        "x": packed(curve.x),
        "y": packed(curve.y),
        "axis": curve.axis,
        "colour": to_hex(style.get("color", LINE_COLOURS[place % len(LINE_COLOURS)])),
        "width": float(style.get("linewidth", 1.3)),
        "line": line not in NO_LINE,
        "dash": [] if line in (*SOLID, *NO_LINE) else list(DASHED[1]),
        "marker": MARKERS.get(marker, "o") if marker not in (None, "none", "None", "") else None,
        "size": float(style.get("markersize", 6.0)) * (0.6 if marker == "." else 1.0) * 4 / 3,
    }
