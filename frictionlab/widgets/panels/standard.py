"""The panels that have names, and the panel of critical values.

Colours show the modes: a strip at the foot of the panels over time, and the curves of the phase plane.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import lru_cache
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from frictionlab.analysis.motion_scales import highest_frequency
from frictionlab.models.composition import parameter_metadata
from frictionlab.models.model import check_parameter_name
from frictionlab.plotting.appearance import BLACK, BLUE, GREY, VERMILLION, line_style, mode_colours
from frictionlab.plotting.figure import Curve, Drawing, envelope
from frictionlab.plotting.labels import (
    coordinate_axis_label,
    parameter_label,
    secondary_axis_angles,
    state_label,
)
from frictionlab.plotting.time_histories import force_outputs
from frictionlab.presentation import is_angle, state_unit
from frictionlab.stability import CriticalCurve
from frictionlab.stability.boundaries.stability_changes import curve_and_gaps
from frictionlab.validation import abbreviate, check_sequence, did_you_mean
from frictionlab.widgets.canvas import MovingMechanism
from frictionlab.widgets.number_control import round_to_step, slider_range
from frictionlab.widgets.update_scheduler import has_event_loop

if TYPE_CHECKING:
    from frictionlab.hybrid.trajectory import Trajectory
    from frictionlab.models.model import Model
    from frictionlab.widgets.result import Result

STRIP_THICKNESS = 7.0  # points
STRIP_SAMPLES = 400
STRIP_HEIGHT = 0.02

EIGENVALUE_MARKER: dict[str, Any] = {"linestyle": "none", "marker": "o", "markersize": 5.0, "zorder": 2.5}
ZERO_GROWTH_LINE: dict[str, Any] = {"color": GREY, "linewidth": 0.8, "zorder": 1.0}

NEUTRAL = 1e-12  # share of an eigenvalue's size below which its real part is a rounding error

CURVE_POINTS, CURVE_PARTS = 87, 4  # points of a critical curve, and the parts in which it is computed
MAX_CACHED_CURVES = 16  # curves
OPERATING_POINT: dict[str, Any] = {"linestyle": "none", "markersize": 8.0, "zorder": 3.0}
MECHANISM = MovingMechanism.name


def _colours_of_modes(run: Trajectory) -> dict[str, str]:
    """Colours of the model's modes; where modes are derived on demand, only of those that the run visits, as
    which others are known depends on earlier runs."""
    colours = mode_colours(run)
    return {mode: colours[mode] for mode in run.time_in_mode} if run.automaton.on_demand else colours


def mode_strip(result: Result) -> dict[str, Curve]:
    """A thick line for every mode of the model, broken where the run is in other modes."""
    colours = _colours_of_modes(result.run)
    t, modes = result.times(), result.modes
    sampled = slice(None, None, max(1, len(t) // STRIP_SAMPLES))
    t, modes = t[sampled], modes[sampled]
    return {mode: _strip_curve(t, modes == mode, colour) for mode, colour in colours.items()}


def _strip_curve(t: Any, chosen: Any, colour: str) -> Curve:
    shown = chosen | np.append(False, chosen[:-1])  # up to the sample after, so that lines meet
    style = {"color": colour, "linewidth": STRIP_THICKNESS, "solid_capstyle": "butt", "zorder": 1.0}
    return Curve(np.where(shown, t, np.nan), np.where(shown, STRIP_HEIGHT, np.nan), style, "strip")


def response(result: Result) -> Drawing:
    """Coordinates against time; an angle is dashed, and on the right axis where there are lengths."""
    names = result.run.names[: result.run.automaton.coordinates]
    angles = secondary_axis_angles(names)
    curves = {state_label(name): _coordinate_curve(result, name, i, angles) for i, name in enumerate(names)}
    # The panels of the forces and of the phase plane have the legend of the modes.
    strip = {f"_{mode}": curve for mode, curve in mode_strip(result).items()}
    right = "angle (rad), dashed" if angles else ""
    t = result.times()
    limits = float(t[0]), float(t[-1])
    return Drawing("time (s)", coordinate_axis_label(names), {**curves, **strip}, right=right, xlim=limits)


def _coordinate_curve(result: Result, name: str, i: int, angles: tuple[str, ...]) -> Curve:
    x, y = envelope(result.times(), result.state(name))
    style = line_style(i, name) | ({"zorder": 1.8} if is_angle(name) else {})  # behind the lengths
    return Curve(x, y, style, "right" if name in angles else "left")


def forces(result: Result) -> Drawing:
    """Normal and friction force against time; the rates, where a model has no contact forces."""
    outputs = force_outputs(result.run.automaton)
    what, curves = (
        ("contact force (N)", _force_curves(result, outputs)) if outputs else ("rate", _rate_curves(result))
    )
    t = result.times()
    limits = float(t[0]), float(t[-1])
    return Drawing("time (s)", what, {**curves, **mode_strip(result)}, xlim=limits)


def _force_curves(result: Result, outputs: dict[str, tuple[str, str]]) -> dict[str, Curve]:
    t, curves = result.times(), {}
    for name, (text, colour) in outputs.items():
        x, y = envelope(t, result.run.output(name, t))
        curves[text.partition(" (")[0]] = Curve(x, y, {"color": colour})
    return curves


def _rate_curves(result: Result) -> dict[str, Curve]:
    names = [f"{name}'" for name in result.model.coordinates]
    drawn = (envelope(result.times(), result.state(name)) for name in names)
    styles = (line_style(i, name) for i, name in enumerate(names))
    return {state_label(n): Curve(x, y, style) for n, (x, y), style in zip(names, drawn, styles)}


def phase(result: Result) -> Drawing:
    """Coordinate against rate over the part that is shown, and the equilibrium of sliding."""
    name = result.settings.coordinate
    x, rate, modes = result.state(name), result.state(f"{name}'"), result.modes
    curves = {m: _phase_curve(x, rate, modes == m, c) for m, c in _colours_of_modes(result.run).items()}
    cross = {"color": BLACK, "marker": "+", "markersize": 8.0, "linestyle": "none", "zorder": 3.0}
    curves["equilibrium"] = Curve(*_equilibrium_point(result, name), cross)
    xlabel, ylabel = (f"{state_label(n)} ({state_unit(n)})" for n in (name, f"{name}'"))
    return Drawing(xlabel, ylabel, curves)


def _phase_curve(x: Any, rate: Any, chosen: Any, colour: str) -> Curve:
    shown = chosen | np.append(False, chosen[:-1])  # up to the sample after, so that lines meet
    return Curve(np.where(shown, x, np.nan), np.where(shown, rate, np.nan), {"color": colour})


def _equilibrium_point(result: Result, name: str) -> tuple[list[float], list[float]]:
    eigenvalues = result.eigenvalues
    if eigenvalues is None:  # the text beside the picture says why
        return [], []
    return [float(eigenvalues.equilibrium.q[result.run.names.index(name)])], [0.0]


def spectrum(result: Result) -> Drawing:
    """Amplitude spectrum over the second half of the run."""
    name, spectrum, f_max = result.settings.coordinate, result.spectrum, highest_frequency(result.model)
    labels = "frequency (Hz)", f"amplitude of {state_label(name)} ({state_unit(name)})"
    if spectrum is None:
        return Drawing(
            *labels, {"_spectrum": Curve([], [])}, note="the run is too short for one", xlim=(0, f_max)
        )
    curve = Curve(spectrum.frequencies, spectrum.amplitudes, {"color": BLACK, "linewidth": 1.0})
    note = f"strongest line {spectrum.strongest:.4g} Hz" if spectrum.amplitudes.any() else "at rest"
    return Drawing(*labels, {"_spectrum": curve}, yscale="log", note=note, xlim=(0.0, f_max))


def eigenvalues(result: Result) -> Drawing:
    """Growth rate and frequency of each mode, those that grow in another colour."""
    eigenvalues = result.eigenvalues
    values: Any = (
        np.zeros(0, dtype=complex)
        if eigenvalues is None
        else eigenvalues.values[eigenvalues.values.imag >= 0]
    )
    grows, frequencies = values.real > 0, values.imag / (2 * np.pi)
    curves = {
        "_no growth": Curve([0.0, 0.0], [0.0, 1.0], ZERO_GROWTH_LINE, "strip"),
        "decays": Curve(values.real[~grows], frequencies[~grows], EIGENVALUE_MARKER | {"color": BLUE}),
        "grows": Curve(
            values.real[grows], frequencies[grows], EIGENVALUE_MARKER | {"color": VERMILLION, "marker": "^"}
        ),
    }
    note = "no equilibrium" if eigenvalues is None else ""
    # Growth rates that are rounding errors alone would give the axis a range of 1e-13.
    neutral = np.all(np.abs(values.real) <= NEUTRAL * np.abs(values))
    xlim = (-1.0, 1.0) if neutral else None
    return Drawing("growth rate (1/s)", "frequency (Hz)", curves, note=note, xlim=xlim)


class CriticalValuePanel:
    """A panel: the critical values of a parameter over another; steady sliding is stable below the curve.

    The curve does not depend on the model's values of the two parameters, so moving the point computes
    nothing anew.  It is computed in parts, first every fourth point; in a script that is all.

    Parameters
    ----------
    model : SliderOnBelt
        The model whose parameters give the limits of the axes.
    parameter, over : str
        The critical parameter, on the vertical axis, and the other one, on the horizontal axis.
    """

    __name__ = "critical"
    hint = "click to move the model there"

    def __init__(self, model: Model, parameter: str = "mu_k", over: str = "F") -> None:
        about = parameter_metadata(type(model), model.components)
        self.parameter, self.over = parameter, over
        self.bounds, self.sides = (slider_range(about[n], model.parameters[n]) for n in (parameter, over))
        self._curve = lru_cache(MAX_CACHED_CURVES)(self._begun)
        self._shown: Any = None

    def __call__(self, result: Result) -> Drawing:
        """The curve, and a point in the colour of its stability."""
        model, eigenvalues = result.model, result.eigenvalues
        for name in (self.parameter, self.over):
            check_parameter_name(model, name)
        curve = self._curve(_ModelApartFrom(model, (self.parameter, self.over)))
        # After a change the present curve is shown before more is computed; a script gets its first part.
        if not curve.at.size or (result is self._shown and has_event_loop()):
            curve.work()
        self._shown = result
        here = [model.parameters[self.over]], [model.parameters[self.parameter]]
        stable = eigenvalues is not None and eigenvalues.stable
        curves = {
            "critical": Curve(curve.at, curve.values, {"color": BLACK}),
            "here, stable": _operating_point(here, stable, BLUE, "o"),
            "here, unstable": _operating_point(here, eigenvalues is not None and not stable, VERMILLION, "^"),
        }
        x, y = (parameter_label(model, name) for name in (self.over, self.parameter))
        progress = (curve.at.size, CURVE_POINTS) if curve.left and has_event_loop() else None
        return Drawing(x, y, curves, xlim=self.sides, ylim=self.bounds, progress=progress)

    def pick(self, x: float, y: float) -> dict[str, float]:
        """The two parameters at a point of the picture, as round numbers."""
        return {self.over: round_to_step(x, self.sides), self.parameter: round_to_step(y, self.bounds)}

    def _begun(self, others: _ModelApartFrom) -> _CurveInParts:
        # At the ends there may be no contact force, or a mass may be zero.
        at = np.linspace(*self.sides, CURVE_POINTS + 2)[1:-1]

        def compute(part: Any) -> CriticalCurve:
            return curve_and_gaps(others.model, self.parameter, self.bounds, over=(self.over, part))[0]

        return _CurveInParts(compute, [at[i - 1 :: CURVE_PARTS] for i in (4, 2, 1, 3)])


class _CurveInParts:
    """The parts of a critical curve that are computed so far, (at, values), and those that are left."""

    def __init__(self, compute: Callable[[Any], CriticalCurve], parts: list[Any]) -> None:
        self.at = self.values = np.zeros(0)
        self.left, self._compute = parts, compute

    def work(self) -> None:
        """Compute one more part, if one is left."""
        if not self.left:
            return
        part, self.left = self._compute(self.left[0]), self.left[1:]
        at, values = np.append(self.at, part.at), np.append(self.values, part.values)
        order = np.argsort(at)
        self.at, self.values = at[order], values[order]


class _ModelApartFrom:
    """A model without regard to the parameters named: two are equal if they differ only in these."""

    def __init__(self, model: Model, names: tuple[str, ...]) -> None:
        self.model = model
        values = tuple(item for item in model.parameters.items() if item[0] not in names)
        self._key = model.structure_key, values

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _ModelApartFrom) and self._key == other._key

    def __hash__(self) -> int:
        return hash(self._key)


def _operating_point(here: Any, there: bool, colour: str, marker: str) -> Curve:
    x, y = here if there else ([], [])
    return Curve(x, y, OPERATING_POINT | {"color": colour, "marker": marker})


PANELS: Mapping[str, Callable[[Any], Drawing]] = MappingProxyType(
    {
        "response": response,
        "phase": phase,
        "forces": forces,
        "spectrum": spectrum,
        "eigenvalues": eigenvalues,
    }
)
NAMES = (MECHANISM, *PANELS)


def select_panels(asked: Iterable[Any]) -> dict[str, Any]:
    """Panels by name; those asked for may be names or functions, or one name alone.

    Raises
    ------
    ValueError
        For an unknown name, something that is no function, or none at all.
    """
    if isinstance(asked, str) or callable(asked):
        asked = [asked]
    asked = check_sequence("panels", asked, f"take some of {', '.join(NAMES)}")
    made = {MECHANISM: MovingMechanism(), **PANELS}
    chosen = {_panel_name(panel): made[panel] if isinstance(panel, str) else panel for panel in asked}
    if not chosen:
        raise ValueError(f"panels must hold at least one panel, got none: take some of {', '.join(NAMES)}")
    return chosen


def _panel_name(panel: Any) -> str:
    if isinstance(panel, str) and panel in NAMES:
        return panel
    if callable(panel):
        return getattr(panel, "__name__", type(panel).__name__)
    known = ", ".join(map(repr, NAMES))
    raise ValueError(
        f"panels must be functions or some of {known}, got {abbreviate(panel)}{did_you_mean(panel, NAMES)}"
    )
