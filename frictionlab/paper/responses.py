"""Figs 7 and 8: motions from near and far, and what they settle to.

The paper gives no initial states: "near" is the equilibrium displaced by 1 %, "far" is rest.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from frictionlab.analysis.simulate import simulate
from frictionlab.analysis.steady_state import SteadyState
from frictionlab.hybrid.trajectory import Trajectory
from frictionlab.plotting import RunFigure, plot_contact_forces, plot_phase_plane
from frictionlab.plotting.legends import legend_beside
from frictionlab.plotting.palette import BLACK, BLUE, label, unit
from frictionlab.plotting.parameters import parameter_value

from . import motions, scenes
from .result import PaperFigure
from .setting import Setting

SECONDS = 60.0  # of Fig. 7
SAMPLES = 20_001
CYCLES = (1.4, 2.5)  # mu_k of Fig. 8
F_MAX = 40.0
SHOWN = 1.5  # seconds of the forces in Fig. 8
DECADES = 5


@dataclass(frozen=True, eq=False)
class Responses:
    """What Fig. 7 shows: runs by start ("near", "rest") and mu_k, and what they settle to, by start."""

    runs: dict[tuple[str, float], Trajectory]
    steady: dict[str, Any]


@dataclass(frozen=True, eq=False)
class Cycles:
    """What Fig. 8 shows: steady states by mu_k."""

    steady: dict[float, SteadyState]


def figure(number: int, setting: Setting) -> PaperFigure:
    """Fig. 7 or 8."""
    return _responses(setting) if number == 7 else _cycles(setting)


def _responses(setting: Setting) -> PaperFigure:
    runs = {(s, mu): _run(s, mu, setting) for mu in motions.EXAMPLES for s in motions.STARTS}
    data = Responses(runs, {start: motions.examples(start, setting) for start in motions.STARTS})
    summary = [
        f"from {start}: " + ", ".join(_settled(*each) for each in zip(b.values, b.kinds, b.intensities))
        for start, b in data.steady.items()
    ]
    caption = "x1 from near the equilibrium and from rest"
    return PaperFigure(7, caption, data, tuple(summary), _draw_responses, str(setting))


def _run(start: str, mu_k: float, setting: Setting) -> Trajectory:
    model = setting.adapted(scenes.USUAL.replace(mu_k=mu_k))
    return simulate(model, SECONDS, x0=start, method=setting.method, progress=setting.progress)


def _settled(mu_k: float, kind: str, intensity: float) -> str:
    return f"{kind} at mu_k {mu_k:g} (L_s {intensity:.4g})"


def _cycles(setting: Setting) -> PaperFigure:
    data = Cycles({mu_k: example(mu_k, setting) for mu_k in CYCLES})
    summary = [f"mu_k = {mu_k:g}: {in_words(found)}" for mu_k, found in data.steady.items()]
    return PaperFigure(8, "steady states from rest", data, tuple(summary), _draw_cycles, str(setting))


def example(mu_k: float, setting: Setting) -> SteadyState:
    """The steady state of the usual model from rest, with its run."""
    return motions.single(scenes.USUAL.replace(mu_k=mu_k), setting)


def in_words(found: SteadyState) -> str:
    """Kind, frequencies and intensity."""
    spectrum = found.spectrum(f_max=F_MAX)
    strongest = spectrum.peaks()[0][0] if spectrum else np.nan
    cycle = f" at {1 / found.period:.3f} Hz, {found.onsets_per_period} onsets of stick a period"
    moving = found.kind == "periodic"
    text = f"{found.kind}{cycle if moving else ''}, strongest line of x1 {strongest:.2f} Hz"
    turns = f", the belt turns by up to {_rotation(found):.3g} rad" if _rotation(found) > 0 else ""
    return f"{text}, L_s {found.intensity:.5g}, returns to {found.deviation:.1e} of its size{turns}"


def _rotation(found: SteadyState) -> float:
    run = found.trajectory
    return float(np.abs(run.states[:, run.names.index("phi")]).max()) if "phi" in run.names else 0.0


def _draw_responses(result: PaperFigure) -> RunFigure:
    picture = RunFigure(figsize=(11.0, 7.5), layout="constrained")
    panels = picture.subplots(3, 2, sharex=True)
    t = np.linspace(0.0, SECONDS, SAMPLES)
    for (start, mu_k), ax in zip(result.data.runs, panels.flat):
        run = result.data.runs[start, mu_k]
        ax.plot(t, run(t)[:, run.names.index("x1")], color=BLUE, linewidth=0.4)
        value = parameter_value(run.source, "mu_k", mu_k)
        ax.set_title(f"({'abcdef'[list(result.data.runs).index((start, mu_k))]}) {value}, {start}")
        ax.set_ylabel(f"{label('x1')} ({unit('x1')})")
        ax.ticklabel_format(axis="y", scilimits=(-3, 4))
        ax.margins(x=0)
    for ax in panels[-1]:
        ax.set_xlabel("time (s)")
    picture.suptitle(result.heading("from near the equilibrium (left) and from rest (right)"))
    return picture


def _draw_cycles(result: PaperFigure) -> RunFigure:
    picture = RunFigure(figsize=(11.0, 9.5), layout="constrained")
    panels = picture.subplots(3, 2)
    for column, (mu_k, found) in zip(panels.T, result.data.steady.items()):
        forces, plane, lines = column
        run, end = found.trajectory, found.trajectory.raw.t
        plot_contact_forces(run, forces, window=(end - min(SHOWN, end), end), shade=False)
        plot_phase_plane(run, plane, window=min(SHOWN, end))
        _draw_spectrum(found, lines)
        forces.set_title(f"{parameter_value(run.source, 'mu_k', mu_k)}: {found.kind}")
        plane.set_title("")
    for ax in panels[:2, 1]:
        legend_beside(ax)
    picture.suptitle(result.heading("contact forces, phase planes and spectra of steady states from rest"))
    return picture


def _draw_spectrum(found: SteadyState, ax: Axes) -> None:
    spectrum = found.spectrum(f_max=F_MAX)
    if spectrum is None:
        return
    ax.semilogy(spectrum.frequencies, spectrum.amplitudes, color=BLACK, linewidth=1.0)
    top = float(spectrum.amplitudes.max())
    ax.set(xlabel="frequency (Hz)", ylabel=f"amplitude of {label('x1')} ({unit('x1')})")
    ax.set(xlim=(0, F_MAX), ylim=(top * 10.0**-DECADES, top * 2))
    ax.set_title(f"strongest line {spectrum.peaks()[0][0]:.2f} Hz")
