"""Figs 7 to 15: single motions, and steady states against mu_k and against the preload.

Figs 7 and 8: motions from near the equilibrium and from rest, and what they settle to.  The paper gives
no initial states: "near" is the equilibrium displaced by 1 %, "far" is rest.  Figs 9, 11 and 13 show
section points, 10, 12 and 14 the intensity, 15 both.  GN is the geometrical nonlinearity.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes

from frictionlab.analysis.simulate import simulate
from frictionlab.analysis.steady_state.classification import MotionKind
from frictionlab.analysis.steady_state.steady_state import SteadyState
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.paper import scenes
from frictionlab.paper.results import PaperFigure
from frictionlab.paper.scenes import Setting, intervals_text, is_vibration, regime_changes
from frictionlab.plotting import (
    RunFigure,
    plot_bifurcation,
    plot_contact_forces,
    plot_intensity,
    plot_phase_plane,
)
from frictionlab.plotting.appearance import BLUE, ink
from frictionlab.plotting.figure import legend_beside, new_figure
from frictionlab.plotting.labels import parameter_value_text, state_label
from frictionlab.presentation import state_unit

if TYPE_CHECKING:
    from frictionlab.analysis.sweeps.bifurcation import Bifurcation
    from frictionlab.models.library.sliders import SliderOnBelt

RESPONSE_TIME = 60.0  # of Fig. 7
SAMPLES = 20_001
CYCLE_MU_K = (1.4, 2.5)  # mu_k of Fig. 8
F_MAX = 40.0
FORCES_SHOWN = 1.5  # seconds of the forces in Fig. 8
DECADES = 5

SECTION_FIGURES = {9: (1e4,), 11: (0.0, 1e7), 13: scenes.CONTACT_STIFFNESSES}  # k_nl of each
INTENSITY_FIGURES = {10: (1e4,), 12: scenes.CONTACT_STIFFNESSES, 14: scenes.CONTACT_STIFFNESSES}
FIGURES_WITHOUT_GEOMETRY = (13, 14)  # without GN
PHASE_PLANE_MU_K = 2.0  # mu_k of Figs 13d to f
PLANES_SHOWN = 0.3  # seconds shown in these


@dataclass(frozen=True, eq=False)
class Responses:
    """What Fig. 7 shows: runs by start ("near", "rest") and mu_k, and what they settle to, by start."""

    runs: dict[tuple[str, float], Trajectory]
    steady_states: dict[str, Any]


@dataclass(frozen=True, eq=False)
class Cycles:
    """What Fig. 8 shows: steady states by mu_k."""

    steady_states: dict[float, SteadyState]


def motion_figure(number: int, setting: Setting) -> PaperFigure:
    """Fig. 7 or 8."""
    return _responses_figure(setting) if number == 7 else _cycles_figure(setting)


def _responses_figure(setting: Setting) -> PaperFigure:
    runs = {(s, mu): _simulate_from(s, mu, setting) for mu in scenes.EXAMPLES for s in scenes.START_NAMES}
    data = Responses(
        runs,
        {start: scenes.example_steady_states(start, setting) for start in scenes.START_NAMES},
    )
    summary = [
        f"from {start}: " + ", ".join(_outcome_text(*each) for each in zip(b.values, b.kinds, b.intensities))
        for start, b in data.steady_states.items()
    ]
    caption = "x1 from near the equilibrium and from rest"
    return PaperFigure(7, caption, data, tuple(summary), _draw_responses, str(setting))


def _simulate_from(start: str, mu_k: float, setting: Setting) -> Trajectory:
    model = setting.adapt_model(scenes.USUAL.replace(mu_k=mu_k))
    return simulate(model, RESPONSE_TIME, x0=start, method=setting.method, progress=setting.progress)


def _outcome_text(mu_k: float, kind: str, intensity: float) -> str:
    return f"{kind} at mu_k {mu_k:g} (L_s {intensity:.4g})"


def _cycles_figure(setting: Setting) -> PaperFigure:
    data = Cycles({mu_k: example_cycle(mu_k, setting) for mu_k in CYCLE_MU_K})
    summary = [f"mu_k = {mu_k:g}: {steady_state_text(steady)}" for mu_k, steady in data.steady_states.items()]
    return PaperFigure(8, "steady states from rest", data, tuple(summary), _draw_cycles, str(setting))


def example_cycle(mu_k: float, setting: Setting) -> SteadyState:
    """The steady state of the usual model from rest, with its run."""
    return scenes.steady_state_of(scenes.USUAL.replace(mu_k=mu_k), setting)


def steady_state_text(steady: SteadyState) -> str:
    """Kind, frequencies and intensity."""
    spectrum = steady.spectrum(f_max=F_MAX)
    strongest = spectrum.peaks()[0][0] if spectrum else np.nan
    cycle = f" at {1 / steady.period:.3f} Hz, {steady.onsets_per_period} onsets of stick a period"
    moving = steady.kind == MotionKind.PERIODIC
    text = f"{steady.kind}{cycle if moving else ''}, strongest line of x1 {strongest:.2f} Hz"
    turns = f", the belt turns by up to {_rotation(steady):.3g} rad" if _rotation(steady) > 0 else ""
    return f"{text}, L_s {steady.intensity:.5g}, returns to {steady.deviation:.1e} of its size{turns}"


def _rotation(steady: SteadyState) -> float:
    run = steady.trajectory
    return float(np.abs(run.states[:, run.names.index("phi")]).max()) if "phi" in run.names else 0.0


def _draw_responses(result: PaperFigure) -> RunFigure:
    picture = new_figure(11.0, 7.5)
    panels = picture.subplots(3, 2, sharex=True)
    t = np.linspace(0.0, RESPONSE_TIME, SAMPLES)
    for (start, mu_k), ax in zip(result.data.runs, panels.flat):
        run = result.data.runs[start, mu_k]
        ax.plot(t, run(t)[:, run.names.index("x1")], color=BLUE, linewidth=0.4)
        value = parameter_value_text(run.source, "mu_k", mu_k)
        ax.set_title(f"({'abcdef'[list(result.data.runs).index((start, mu_k))]}) {value}, {start}")
        ax.set_ylabel(f"{state_label('x1')} ({state_unit('x1')})")
        ax.ticklabel_format(axis="y", scilimits=(-3, 4))
        ax.margins(x=0)
    for ax in panels[-1]:
        ax.set_xlabel("time (s)")
    picture.suptitle(result.heading("from near the equilibrium (left) and from rest (right)"))
    return picture


def _draw_cycles(result: PaperFigure) -> RunFigure:
    picture = new_figure(11.0, 9.5)
    panels = picture.subplots(3, 2)
    for column, (mu_k, steady) in zip(panels.T, result.data.steady_states.items()):
        forces, plane, lines = column
        run, end = steady.trajectory, steady.trajectory.raw.t
        plot_contact_forces(run, forces, window=(end - min(FORCES_SHOWN, end), end), shade=False)
        plot_phase_plane(run, plane, window=min(FORCES_SHOWN, end))
        _draw_spectrum(steady, lines)
        forces.set_title(f"{parameter_value_text(run.source, 'mu_k', mu_k)}: {steady.kind}")
        plane.set_title("")
    for ax in panels[:2, 1]:
        legend_beside(ax)
    picture.suptitle(result.heading("contact forces, phase planes and spectra of steady states from rest"))
    return picture


def _draw_spectrum(steady: SteadyState, ax: Axes) -> None:
    spectrum = steady.spectrum(f_max=F_MAX)
    if spectrum is None:
        return
    ax.semilogy(spectrum.frequencies, spectrum.amplitudes, color=ink(ax), linewidth=1.0)
    top = float(spectrum.amplitudes.max())
    ax.set(xlabel="frequency (Hz)", ylabel=f"amplitude of {state_label('x1')} ({state_unit('x1')})")
    ax.set(xlim=(0, F_MAX), ylim=(top * 10.0**-DECADES, top * 2))
    ax.set_title(f"strongest line {spectrum.peaks()[0][0]:.2f} Hz")


@dataclass(frozen=True, eq=False)
class FrictionSweeps:
    """What Figs 9 to 14 show.

    Parameters
    ----------
    sweeps : dict of (float, str) to Bifurcation
        By k_nl (N/m^3) and start ("rest", "near").
    cycles : dict of float to SteadyState
        At mu_k = 2, by k_nl; of Fig. 13 only.
    """

    sweeps: dict[tuple[float, str], Any]
    cycles: dict[float, SteadyState]


def friction_figure(number: int, setting: Setting) -> PaperFigure:
    """Fig. 9, 10, 11, 12, 13 or 14."""
    geometry = number not in FIGURES_WITHOUT_GEOMETRY
    stiffnesses = {**SECTION_FIGURES, **INTENSITY_FIGURES}[number]
    sweeps = {(k, "rest"): scenes.sweep_from_rest(k, setting, geometry) for k in stiffnesses}
    if number in INTENSITY_FIGURES:
        sweeps |= {(k, "near"): scenes.sweep_from_near(k, setting, geometry) for k in stiffnesses}
    cycles = {k: phase_plane_cycle(k, setting) for k in stiffnesses} if number == 13 else {}
    what = "x1 at the onset of stick" if number in SECTION_FIGURES else "intensity L_s"
    caption = f"{what} against mu_k, {scenes.GEOMETRY_NAMES[geometry]}"
    summary = [f"k_nl = {k:g} N/m^3, from {start}: {_sweep_text(b)}" for (k, start), b in sweeps.items()]
    draw = _draw_sections if number in SECTION_FIGURES else _draw_intensities
    how = str(setting) if geometry else setting.solver  # without GN both impact laws are the same
    return PaperFigure(number, caption, FrictionSweeps(sweeps, cycles), tuple(summary), draw, how)


def phase_plane_cycle(k_nl: float, setting: Setting) -> SteadyState:
    """The motion of Figs 13d to f."""
    return scenes.steady_state_of(
        scenes.model_with_contact(k_nl, geometry=False).replace(mu_k=PHASE_PLANE_MU_K), setting
    )


def _sweep_text(sweep: Bifurcation) -> str:
    strong = sweep.intensities[is_vibration(sweep)]
    size = f"; L_s {np.nanmin(strong):.5g} to {np.nanmax(strong):.5g}" if len(strong) else ""
    return f"{intervals_text(sweep)}{size}"


def _draw_sections(result: PaperFigure) -> RunFigure:
    sweeps, cycles = result.data.sweeps, result.data.cycles
    rows, columns = (2, len(cycles)) if cycles else (1, len(sweeps))
    picture = new_figure(max(7.5, 4.4 * columns), 4.2 * rows)
    panels = picture.subplots(rows, columns, squeeze=False)
    for i, ((k_nl, _), sweep) in enumerate(sweeps.items()):
        ax = panels[0, i]
        plot_bifurcation(sweep, ax, legend=False)
        ax.set_title(_title("abc"[i], sweep.model, k_nl, columns))
    for i, (k_nl, sweep) in enumerate(cycles.items()):
        plot_phase_plane(sweep.trajectory, panels[1, i], window=PLANES_SHOWN)
        panels[1, i].set_title(_title("def"[i], sweep.model, k_nl, columns))
    _row_legends(panels)
    gn = "without" if cycles else "with"
    planes = f", and phase planes at $\\mu_k$ = {PHASE_PLANE_MU_K:g}" if cycles else ""
    picture.suptitle(result.heading(f"from rest, {gn} the geometrical nonlinearity{planes}"))
    return picture


def _title(letter: str, model: SliderOnBelt, k_nl: float, columns: int) -> str:
    value = parameter_value_text(model, "k_nl", k_nl)
    return f"({letter}) {value}" if columns > 1 else value


def _row_legends(panels: Any) -> None:
    """One legend for each row, with all labels in that row."""
    for row in panels:
        legend_beside(row[-1], [handle for ax in row for handle in ax.get_legend_handles_labels()[0]])


def _draw_intensities(result: PaperFigure) -> RunFigure:
    sweeps = result.data.sweeps
    stiffnesses = list(dict.fromkeys(k for k, _ in sweeps))
    picture = new_figure(max(7.5, 4.4 * len(stiffnesses)), 4.2)
    panels = picture.subplots(1, len(stiffnesses), squeeze=False)
    for i, k_nl in enumerate(stiffnesses):
        _draw_intensity([sweeps[k_nl, start] for start in ("rest", "near")], panels[0, i])
        title = _title("abc"[i], sweeps[k_nl, "rest"].model, k_nl, len(stiffnesses))
        panels[0, i].set_title(title)
    legend_beside(panels[0, -1])
    gn = "without" if result.number in FIGURES_WITHOUT_GEOMETRY else "with"
    picture.suptitle(result.heading(f"{gn} the geometrical nonlinearity; hollow: at rest"))
    return picture


def _draw_intensity(sweeps: list[Any], ax: Axes) -> None:
    plot_intensity(sweeps, ax, legend=False)


@dataclass(frozen=True, eq=False)
class PreloadSweeps:
    """What Fig. 15 shows: sweeps over F by "with GN" and "without GN"."""

    sweeps: dict[str, Any]


def preload_figure(number: int, setting: Setting) -> PaperFigure:
    """Fig. 15."""
    data = PreloadSweeps(
        {name: scenes.preload_sweep(geometry, setting) for geometry, name in scenes.GEOMETRY_NAMES.items()}
    )
    summary = [
        f"{name}: {intervals_text(b)} N; {regime_changes(b)} changes of regime"
        for name, b in data.sweeps.items()
    ]
    caption = "steady states from rest against the preload, mu_k = 2.5, k_nl = 1e7 N/m^3"
    return PaperFigure(number, caption, data, tuple(summary), _draw_preload, str(setting))


def _draw_preload(result: PaperFigure) -> RunFigure:
    picture = new_figure(11.0, 7.5)
    panels = picture.subplots(2, 2, sharex=True, squeeze=False)
    for i, (name, sweep) in enumerate(result.data.sweeps.items()):
        plot_bifurcation(sweep, panels[0, i], legend=False)
        plot_intensity(sweep, panels[1, i], legend=False)
        panels[0, i].set_title(f"({'ab'[i]}) {name}")
        panels[1, i].set_title(f"({'cd'[i]}) {name}")
        panels[0, i].set_xlabel("")
    _row_legends(panels[:1])
    model = next(iter(result.data.sweeps.values())).model
    values = ", ".join(parameter_value_text(model, name, getattr(model, name)) for name in ("mu_k", "k_nl"))
    picture.suptitle(result.heading(f"against the preload from rest, {values}"))
    return picture
